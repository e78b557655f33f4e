"""Tests that the manual builds without a warning, its navigation has every page, and every link, anchor and picture of the site exists.

Skipped without MkDocs (sh samples/packages.sh test installs it)."""
import html.parser
import os
import shutil
import subprocess
import sys
import tempfile
import urllib.parse

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "lib"))
import cml  # noqa: E402
import manual  # noqa: E402

COMMAND = [sys.executable, "-m", "mkdocs", "build", "--strict", "-f", os.path.join(manual.TOP, "samples", "mkdocs.yml"), "-d"]


class Page(html.parser.HTMLParser):
    """The ids of a page, and its links."""

    def __init__(self, text):
        super().__init__()
        self.ids, self.links = set(), set()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.ids |= {attrs.get("id"), attrs.get("name")}
        link = attrs.get("href" if tag in ("a", "link") else "src")
        if link and not urllib.parse.urlsplit(link).scheme and not link.startswith("//"):
            self.links.add(link)


def read_site(folder):
    pages = {}
    for where, _, names in os.walk(folder):
        for path in (os.path.join(where, name) for name in names if name.endswith(".html") and name != "404.html"):
            with open(path, encoding="utf-8") as file:
                pages[path] = Page(file.read())
    return pages


def broken(pages):
    """Yields the links that lead nowhere, each with its page."""
    for path, page in sorted(pages.items()):
        for link in sorted(page.links):
            target, _, anchor = urllib.parse.unquote(link).partition("#")
            target = os.path.normpath(os.path.join(os.path.dirname(path), target)) if target else path
            if os.path.isdir(target):
                target = os.path.join(target, "index.html")
            if not os.path.exists(target):
                yield path, link
            elif anchor and target in pages and anchor not in pages[target].ids:
                yield path, link


def check_the_check():
    """Checks that `broken` finds broken links, because a check that cannot fail is none."""
    here = os.path.abspath(__file__)
    assert list(broken({here: Page('<a href="#a">x</a><p id="a"><img src="site.py">')})) == []
    for text in ('<a href="#b">x</a><p id="a">', '<img src="none.svg">', '<a href="none.html#a">'):
        assert len(list(broken({here: Page(text)}))) == 1


def main():
    check_the_check()
    if not shutil.which("mkdocs") or subprocess.run([sys.executable, "-c", "import mkdocs, mkdocstrings_handlers.python"], check=False, capture_output=True).returncode:
        print("skipped: no mkdocs with mkdocstrings (sh samples/packages.sh test installs them)")
        sys.exit(77)
    verdict = cml.Verdict("site")
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([*COMMAND, folder], capture_output=True, text=True, check=False)
        said = "\n".join(line for line in done.stderr.splitlines() if not line.startswith(("INFO", "DEBUG")) or "not included" in line or "  - " in line)
        verdict.check("mkdocs", done.returncode == 0 and "not included in the" not in said, said)
        pages = read_site(folder)
        verdict.check("site", len(pages) >= len(manual.pages()), f"has {len(pages)} pages")
        for path, link in broken(pages):
            verdict.check(os.path.relpath(path, folder), False, f"links to {link}, which is not there")
    verdict.finish()


main()
