"""Writes a mesh as scanners and modelling tools do: scan_files.py MESH.obj STEM FORMAT... The formats are keys of WRITERS; the
file of each is STEM.FORMAT and an ending. Text has coordinates as the .obj has them; binary floats round them, so that
files agree only where coordinates are floats. SPDX-License-Identifier: MIT"""
import struct
import sys


def read_obj(path):
    """Returns vertices and faces, the corners of which are counted from 0."""
    with open(path, encoding="ascii") as file:
        lines = [line.split() for line in file]
    vertices = [tuple(map(float, words[1:4])) for words in lines if words[:1] == ["v"]]
    return vertices, [[int(word.split("/")[0]) - 1 for word in words[1:]] for words in lines if words[:1] == ["f"]]


def obj(vertices, faces):
    return "".join("v %r %r %r\n" % v for v in vertices).encode() + "".join("f " + " ".join(str(k + 1) for k in f) + "\n" for f in faces).encode()


def stl_text(vertices, faces):
    facets = "".join("facet normal 0 0 0\n outer loop\n" + "".join("  vertex %r %r %r\n" % vertices[k] for k in face) + " endloop\nendfacet\n" for face in faces)
    return f"solid mesh\n{facets}endsolid mesh\n".encode()


def stl_binary(vertices, faces):
    facets = b"".join(struct.pack("<12fH", 0, 0, 0, *(x for k in face for x in vertices[k]), 0) for face in faces)
    return b"solid, but binary".ljust(80) + struct.pack("<I", len(faces)) + facets


def ply_head(kind, vertices, faces):
    """A header with properties that no reader of shapes needs."""
    return (f"ply\nformat {kind} 1.0\ncomment of tests\nobj_info none\nelement vertex {len(vertices)}\nproperty float nx\n"
            "property double x\nproperty float y\nproperty float32 z\nproperty uchar red\n"
            f"element face {len(faces)}\nproperty list uchar int vertex_indices\nproperty list ushort float texcoord\nproperty int8 flag\n"
            "element edge 1\nproperty int16 first\nend_header\n").encode()


def ply_ascii(vertices, faces):
    rows = ["nan %r %r %r 255" % v for v in vertices]
    rows += [f"{len(face)} {' '.join(map(str, face))} 2 0.5 -1 -3" for face in faces]
    return ply_head("ascii", vertices, faces) + ("\n".join(rows) + "\n7\n").encode()


def ply_binary(order, vertices, faces):
    rows = [struct.pack(order + "fdffB", float("nan"), *v, 255) for v in vertices]
    rows += [struct.pack(f"{order}B{len(face)}iH2fb", len(face), *face, 2, 0.5, -1, -3) for face in faces]
    return ply_head("binary_little_endian" if order == "<" else "binary_big_endian", vertices, faces) + b"".join(rows) + struct.pack(order + "h", 7)


WRITERS = {"obj": obj, "stl-text": stl_text, "stl-binary": stl_binary, "ply-ascii": ply_ascii,
           "ply-little": lambda *mesh: ply_binary("<", *mesh), "ply-big": lambda *mesh: ply_binary(">", *mesh)}

if __name__ == "__main__":
    for form in sys.argv[3:]:
        with open(f"{sys.argv[2]}.{form}.{form[:3]}", "wb") as out:
            out.write(WRITERS[form](*read_obj(sys.argv[1])))
