"""Tests that texts of SVG pictures do not overlap, stay within the picture, and stand on white: svg_text.py FILE.svg [...].

The SVG files of matplotlib are read: attributes, or a style that holds them. No fonts are at hand, so a text's box is as wide as its number of
characters times WIDTH of the size of its letters. WIDTH is about the mean of Helvetica, in which digits take 0.556. The box reaches from the tails
of letters up to the capitals:

    UP    ┌─────────┐
          │ Tt_r(g) │  baseline at 0
    DOWN  └─────────┘

Boxes may overlap by SLACK points. Rotated texts have rotated boxes. The command prints each pair that overlaps, and its exit code is then 1.

SPDX-License-Identifier: MIT
"""
import math
import re
import sys
import xml.etree.ElementTree as tree

WIDTH, UP, DOWN, SLACK = 0.56, 0.72, 0.2, 1.0
SVG = "{http://www.w3.org/2000/svg}"
STEP = re.compile(r"(translate|scale|rotate)\(([^)]*)\)")
STYLED = {key: re.compile(rf"(?:^|[;\s]){words}") for key, words in (
    ("font-size", r"(?:font:[^;]*?|font-size: *)([\d.]+)px"), ("text-anchor", r"text-anchor: *(\w+)"), ("fill", r"fill: *(#\w+)"))}
LENGTH = re.compile(r"[-+0-9.eE]+")
SAME = (1, 0, 0, 1, 0, 0)  # the identity; x' = a x + c y + e, y' = b x + d y + f, as SVG's matrix(a b c d e f)


def times(m, n):
    """Returns the product of two transforms: first n, then m."""
    a, b, c, d, e, f = m
    return (a * n[0] + c * n[1], b * n[0] + d * n[1], a * n[2] + c * n[3], b * n[2] + d * n[3],
            a * n[4] + c * n[5] + e, b * n[4] + d * n[5] + f)


def matrix(transform):
    m = SAME
    for name, words in STEP.findall(transform or ""):
        v = [float(word) for word in LENGTH.findall(words)]
        if name == "translate":
            m = times(m, (1, 0, 0, 1, v[0], v[1] if len(v) > 1 else 0))
        elif name == "scale":
            m = times(m, (v[0], 0, 0, v[-1], 0, 0))
        else:
            sine, cosine = math.sin(math.radians(v[0])), math.cos(math.radians(v[0]))
            x, y = v[1:] or (0, 0)  # rotate(angle x y) turns about the point (x, y)
            m = times(m, (cosine, sine, -sine, cosine, x - cosine * x + sine * y, y - sine * x - cosine * y))
    return m


def said(element, key, default):
    """Returns an attribute, or its value in the style."""
    styled = STYLED[key].search(element.get("style", ""))
    return styled[1] if styled else element.get(key, default)


def box_of(element, m, size, anchor):
    """Returns the box of a text as (left, top, right, bottom) in points of the picture."""
    width = len(words_of(element)) * size * WIDTH
    left = {"middle": -width / 2, "end": -width}.get(anchor, 0)
    x, y = float(element.get("x", 0)), float(element.get("y", 0))
    corners = [(x + left + i * width, y + j * size) for i in (0, 1) for j in (-UP, DOWN)]
    moved = [(m[0] * u + m[2] * v + m[4], m[1] * u + m[3] * v + m[5]) for u, v in corners]
    return (min(u for u, _ in moved), min(v for _, v in moved), max(u for u, _ in moved), max(v for _, v in moved))


def words_of(element):
    """Returns the words of a text. In a text of parts, such as a power of ten, white space around each part is dropped."""
    return "".join(text.strip() for text in element.itertext()) if len(element) and element.get("style") is None else "".join(element.itertext()).strip()


def texts_of(element, m=SAME, size=12.0, anchor="start"):
    """Yields (words, box) of every text below the element."""
    m = times(m, matrix(element.get("transform")))
    size = float(LENGTH.match(said(element, "font-size", str(size))).group())
    anchor = said(element, "text-anchor", anchor)
    if element.tag == SVG + "text":
        for part in element:
            size = max(size, float(LENGTH.match(said(part, "font-size", str(size))).group()))
        return [(words_of(element), box_of(element, m, size, anchor))] if words_of(element) else []
    return [found for child in element if child.tag != SVG + "defs" for found in texts_of(child, m, size, anchor)]


def fills(part, view):
    """True if a rectangle, or a path of four corners, fills the whole picture."""
    if part.tag == SVG + "rect":
        return [float(part.get(key)) for key in ("x", "y", "width", "height")] == view
    corners = [float(word) for word in LENGTH.findall(part.get("d"))]
    return len(corners) == 8 and [min(corners[::2]), min(corners[1::2]), max(corners[::2]), max(corners[1::2])] == [
        view[0], view[1], view[0] + view[2], view[1] + view[3]]


def on_white(root, view):
    """True if white fills the picture."""
    return any(said(part, "fill", "").lower() == "#ffffff" and fills(part, view)
               for part in root.iter() if part.tag in (SVG + "rect", SVG + "path"))


def faults_of(root):
    view = [float(word) for word in LENGTH.findall(root.get("viewBox"))]
    texts = texts_of(root)
    faults = [] if on_white(root, view) else ["has no white background"]
    faults += [f"{words!r} leaves the picture" for words, box in texts
              if box[0] < view[0] - SLACK or box[1] < view[1] - SLACK or box[2] > view[2] + SLACK or box[3] > view[3] + SLACK]
    for i, (words, a) in enumerate(texts):
        for other, b in texts[:i]:
            if min(a[2], b[2]) - max(a[0], b[0]) > SLACK and min(a[3], b[3]) - max(a[1], b[1]) > SLACK:
                faults.append(f"{other!r} and {words!r} overlap")
    return faults, len(texts)


def check_the_check():
    """Checks made-up pictures: two texts apart, and one fault of each kind."""
    def faults(*texts, paper='<rect x="0" y="0" width="100" height="100" fill="#FFFFFF"/>'):
        body = paper + "".join(f'<g transform="{where}" font-size="10" text-anchor="middle"><text>{text}</text></g>' for where, text in texts)
        return len(faults_of(tree.fromstring(f'<svg xmlns="{SVG[1:-1]}" viewBox="0 0 100 100">{body}</svg>'))[0])
    first = ("translate(50,50)", "aaaaa")
    assert faults(first, ("translate(50,62)", "bbbbb")) == 0 and faults(first, ("translate(80,50)", "bbbbb")) == 0
    assert faults(first, ("translate(50,55)", "bbbbb")) == 1 and faults(first, ("translate(75,50)", "bbbbb")) == 1
    assert faults(first, ("translate(72,50) rotate(-90)", "bbbbb")) == 0
    assert faults(first, ("translate(66,50) rotate(-90)", "bbbbb")) == 1
    assert faults(first, paper="") == 1
    # texts with a style, as matplotlib writes them
    def styled(*turns):
        body = "".join(f'<text style="font: 10px \'DejaVu Sans\'; text-anchor: middle" x="50" y="50" transform="rotate({turn} 50 50)">aaaaa</text>'
                       for turn in turns) + '<path d="M 0 100 L 100 100 L 100 0 L 0 0 z" style="fill: #ffffff"/>'
        return len(faults_of(tree.fromstring(f'<svg xmlns="{SVG[1:-1]}" viewBox="0 0 100 100">{body}</svg>'))[0])
    assert styled(0) == 0 and styled(-90) == 0 and styled(0, -90) == 1
    assert faults(("translate(10,50)", "aaaaa")) == 1 and faults(("translate(50,5)", "aaaaa")) == 1


def main():
    check_the_check()
    count = 0
    for path in sys.argv[1:]:
        faults, texts = faults_of(tree.parse(path).getroot())
        if not texts:
            faults = ["no text"]
        for fault in faults:
            print(f"{path}: {fault}")
        count += len(faults)
    sys.exit(1 if count or len(sys.argv) < 2 else 0)


if __name__ == "__main__":
    main()
