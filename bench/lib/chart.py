"""Charts of results: gnuplot draws them, and their svg is rewritten to a third of its bytes, the picture unchanged.

gnuplot states the same attributes on every mark and wraps many marks in groups of their own, most of them empty, and
gives a hundredth of a pixel. Here what is inherited is not said again, groups that say nothing go, and coordinates have
one decimal. Error bars may run through hollow marks.
SPDX-License-Identifier: MIT
"""
import os
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as tree

import cases

SVG = "{http://www.w3.org/2000/svg}"
INHERITED = ("fill", "color", "stroke", "stroke-width", "stroke-linecap", "stroke-linejoin", "font-family", "font-size",
             "text-anchor")
SHARED = {"fill": "none", "color": "black", "stroke": "currentColor", "stroke-width": "1", "stroke-linecap": "butt",
          "stroke-linejoin": "miter", "font-family": "sans", "font-size": "12"}
LINK = "{http://www.w3.org/1999/xlink}href"
MARK = re.compile(r"translate\(([-\d.]+),([-\d.]+)\) scale\(([\d.]+)\)")
AXES = ({"stroke": "#dddddd"}, {"stroke": "black"})  # lines of the grid, tics
STYLE = ".t{stroke:none;fill:black}"


def shorter(value):
    """Numbers to one decimal, colours in hexadecimal digits, one blank between words."""
    value = re.sub(r"rgb\( *(\d+), *(\d+), *(\d+)\)", lambda m: "#%02x%02x%02x" % tuple(map(int, m.groups())), value)
    value = re.sub(r"\d+\.\d+", lambda m: ("%.1f" % float(m.group())).removesuffix(".0"), value)
    return re.sub(r"\s+", " ", value).strip()


def say_once(element, inherited):
    """Drops attributes that the surrounding group has already, and names that nothing refers to."""
    for key in list(element.attrib):
        element.set(key, shorter(element.get(key)))
        if key in ("id", "class") or element.get(key) == inherited.get(key):
            del element.attrib[key]
    return {**inherited, **{key: element.get(key) for key in INHERITED if key in element.attrib}}


def scaled_marks(children):
    """Runs of marks of one symbol, size and colour: said once, for all of them; the white ones behind marks go."""
    runs = []
    for child in children:
        where = MARK.fullmatch(child.get("transform", "")) if child.tag == SVG + "use" else None
        if where is None:
            runs.append(child)
        elif child.get("color") != "#FFFFFF":
            x, y, scale = map(float, where.groups())
            looks = {"color": child.get("color"), "transform": "scale(%g)" % scale}
            if not runs or runs[-1].attrib != looks:
                runs.append(tree.Element(SVG + "g", looks))
            tree.SubElement(runs[-1], SVG + "use", {LINK: child.get(LINK), "x": "%.2f" % (x / scale), "y": "%.2f" % (y / scale)})
    return runs


def joined(children):
    """Neighbours of equal looks become one: groups, and the lines of an axis, whatever the order of grid, tics and labels."""
    out, axis = [], {}
    for child in children:
        looks = {key: value for key, value in child.attrib.items() if key != "d"}
        if child.tag == SVG + "path" and looks in AXES:
            line = axis.setdefault(looks["stroke"], child)
            if line is not child:
                line.set("d", line.get("d") + child.get("d"))
                continue
        elif child.tag != SVG + "text":
            axis = {}
        if out and child.tag == out[-1].tag == SVG + "g" and child.attrib == out[-1].attrib and "transform" not in looks:
            out[-1][:] = joined(list(out[-1]) + list(child))
        else:
            out.append(child)
    return out


def plain(text, inherited):
    """A text without spans that say nothing; the last of those of gnuplot only set the size back."""
    for part in list(text):
        say_once(part, inherited)
        if not part.text:
            text.remove(part)
        elif not part.attrib and part is text[0]:
            text.text = part.text
            text.remove(part)
    return text


def shrunk(element, inherited):
    """What `element` becomes: a list of elements, empty where it draws nothing."""
    if element.tag == SVG + "title":
        return []
    inherited = say_once(element, inherited)
    if element.tag == SVG + "text":
        return [plain(element, inherited)]
    element.text = element.tail = None
    element[:] = joined(scaled_marks([part for child in element for part in shrunk(child, inherited)]))
    if element.tag != SVG + "g" or (len(element) and element.attrib):
        return labelled(element)
    return list(element)


def labelled(element):
    """A group with one text in it becomes the text."""
    if element.tag != SVG + "g" or [child.tag for child in element] != [SVG + "text"]:
        return [element]
    element[0].attrib.update(element.attrib)
    if element.get("stroke") == "none" and element.get("fill") == "black":
        del element[0].attrib["stroke"], element[0].attrib["fill"]
        element[0].set("class", "t")
    return [element[0]]


def shrink(path):
    tree.register_namespace("", SVG[1:-1])
    tree.register_namespace("xlink", LINK[1:-5])
    figure = tree.parse(path)
    canvas = figure.find(SVG + "g[@id='gnuplot_canvas']")
    for ground in canvas.findall(SVG + "rect"):
        ground.set("stroke", "none")  # what all inherit would frame it
    marks = [part for child in canvas if child.tag != SVG + "defs" for part in
             (shrunk(child, SHARED) if child.tag == SVG + "g" else [child])]
    canvas[:] = canvas.findall(SVG + "defs") + joined(marks)
    canvas.attrib.update(SHARED)
    for element in canvas.iter():
        element.tail = None if element.tag == SVG + "tspan" else "\n"
    style = tree.Element(SVG + "style")
    style.text = STYLE
    canvas.insert(0, style)
    figure.write(path, encoding="utf-8", xml_declaration=True)


def plot(script, target, shrunk=True, **names):
    """Has a script of bench draw the target, svg or .png, from what the names say."""
    names.update(out=target, kind="pngcairo" if target.endswith(".png") else "svg")
    words = "; ".join("%s=%r" % pair for pair in names.items())
    if subprocess.run(["gnuplot", "-e", words, os.path.join(cases.BENCH, script)], check=False).returncode:
        sys.exit("%s: gnuplot failed" % target)
    if shrunk and names["kind"] == "svg":
        shrink(target)


def draw_result(draw, csv, target):
    """Of a result in the folder of results, where gnuplot is installed."""
    if shutil.which("gnuplot"):
        draw(csv, target)
    else:
        print("no gnuplot, no figure", file=sys.stderr)
