"""Checks that texts (*.md) can be read at once. Sentences have at most 20 words in the mean of a text and none more than 40;
no line has more than 160 letters outside tables. Code, tables, headings and quotes of old results do not count. Runs in
the source directory."""
import os
import re
import statistics
import sys

MEAN, MOST, LETTERS = 20, 40, 160
SKIPPED = tuple(f"bench/{room}/results" for room in ("accuracy", "choices", "parts", "peers", "speed", "stability"))

FENCED = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
HIDDEN = re.compile(r"<!--.*?-->|\A---\n.*?\n---\n", re.DOTALL)
ITEM = re.compile(r"(?:[-*+]|\d+\.)\s+")
LINK = re.compile(r"!?\[([^\]]*)\]\([^)]*\)")
CODE = re.compile(r"`[^`]+`")
DOTTED = re.compile(r"\b(e\.g|i\.e|Fig|Figs|Eq|Eqs|Sec|cf|vs|No|al)\.")
END = re.compile(r"""(?<=[.!?])["*)]*\s+(?=["*(]*[A-Z0-9])""")


def without_code(text):
    """Returns the text without its code, with as many lines as before."""
    for pattern in (HIDDEN, FENCED):
        text = pattern.sub(lambda found: "\n" * found[0].count("\n"), text)
    return text


def paragraphs(text):
    """Returns paragraphs and items of lists, each on one line."""
    found, lines = [], []
    for line in without_code(text).split("\n") + [""]:
        words, item = line.strip(), ITEM.match(line.strip())
        ends = not words or words.startswith(("|", "#", "<", "!!!")) or (line.startswith("    ") and not lines)
        if ends or item:
            found.append(" ".join(lines))
            lines = []
        if not ends:
            lines.append(words[item.end():] if item else words)
    return [paragraph for paragraph in found if paragraph]


def sentences(text):
    """Yields the sentences of a text. Code in a sentence counts as one word, and so does a link."""
    for paragraph in paragraphs(text):
        plain = CODE.sub("Code", LINK.sub(r"\1", paragraph))
        yield from END.split(DOTTED.sub(r"\1", plain))


def complaints_of(path, text):
    lengths = [(len(sentence.split()), sentence) for sentence in sentences(text)]
    mean = statistics.mean(length for length, _ in lengths) if lengths else 0
    found = [f"{path}: {length} words (expected at most {MOST}): {sentence[:100]} ..." for length, sentence in lengths if length > MOST]
    found += [f"{path}: {mean:.1f} words a sentence (expected at most {MEAN})"] * (mean > MEAN)
    return found + [f"{path}:{number}: a line of {len(line)} letters (expected at most {LETTERS})"
                    for number, line in enumerate(without_code(text).split("\n"), 1) if len(line) > LETTERS and not line.startswith("|")]


def check_the_check():
    """Checks on made-up texts that this check can fail."""
    words = "a " * 39
    sound = f"# {words * 2}\n{words}end. It is `a b c`. No. 3 is\nhere, e.g. Rd.\n\n| {words * 5}|\n```sh\n{words * 9}\n```\n- Item.\n- Item.\n- Item.\n- Item.\n"
    assert complaints_of("a.md", sound) == [], complaints_of("a.md", sound)
    assert list(sentences("One (e.g. this one). Two\nlines. `three` four")) == ["One (e.g this one).", "Two lines.", "Code four"]
    for text in (f"{words}two end. A.\n\nB.\n", f"{words}end.\n", "x" * 161, f"- {words}\n  two end. A. B. C.\n"):
        assert len(complaints_of("a.md", text)) == 1, (text, complaints_of("a.md", text))


def main():
    check_the_check()
    complaints, count = [], 0
    for folder, folders, names in os.walk("."):
        folders[:] = sorted(name for name in folders if name != ".git" and not name.startswith("build"))
        for path in sorted(os.path.relpath(os.path.join(folder, name)) for name in names if name.endswith(".md")):
            if path.startswith(SKIPPED):
                continue
            with open(path, encoding="utf-8") as file:
                complaints += complaints_of(path, file.read())
            count += 1
    print("\n".join(complaints) or f"{count} texts")
    sys.exit(1 if complaints else 0)


main()
