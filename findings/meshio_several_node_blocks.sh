#!/usr/bin/env bash
# Abaqus and CalculiX decks: meshio 5.3.5 keeps the last *NODE block alone, so elements move in silence.
#
# Valid input: a tetrahedron of volume 1/6 whose four nodes stand in one *NODE block, and a second *NODE
# block behind its elements: other nodes, each with a set of its own, as preprocessors write reference
# points and further parts. Abaqus and CalculiX take any number of *NODE blocks.
#
# Guess: all nodes are read, and the tetrahedron has the volume 1/6.
#
# Seen:
# - four further nodes: four points in all, those of the second block, and a tetrahedron on them, of
#   volume 36. No error, no warning.
# - one further node, as a reference point: one point, and a tetrahedron of the points 0 to 3 of it.
# - the second block ahead of the elements: KeyError 1, the number of a node that stands in the file.
#
# `_abaqus.py` sets `points, point_ids = _read_nodes(f)` at each *NODE, and what was read is gone.
# CalculiX 2.20 reads the same decks: it stretches the tetrahedron by F L/(E V) = 6, as one of volume 1/6.
# cardan writes one block, and its decks are read.
#
# Run by hand: bash findings/meshio_several_node_blocks.sh. Needs Python 3.11 or later and a package
# index. It fails if the output is another one.
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
python3 -m venv "$here/venv"
"$here/venv/bin/pip" install --quiet meshio==5.3.5 'numpy<3'
cd "$here"
"$here/venv/bin/python" > seen <<'PYTHON'
import meshio
import numpy as np

MESH = "*NODE, NSET=MESH\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n4, 0., 0., 1.\n"
SOLID = "*ELEMENT, TYPE=C3D4, ELSET=SOLID\n1, 1, 2, 3, 4\n"
FURTHER = "*NODE, NSET=OTHER\n5, 10., 10., 10.\n6, 16., 10., 10.\n7, 10., 16., 10.\n8, 10., 10., 16.\n"
POINT = "*NODE, NSET=REFERENCE\n9, 5., 5., 5.\n"


def look(name, *blocks):
    with open("deck.inp", "w") as deck:
        deck.write("*HEADING\n\n" + "".join(blocks))
    try:
        read = meshio.read("deck.inp")
    except KeyError as error:
        print(f"{name}: KeyError {int(error.args[0])}")
        return
    (corners,) = read.cells[0].data
    volume = "none"
    if max(corners) < len(read.points):
        first, *others = read.points[corners]
        volume = f"{abs(np.linalg.det(np.array(others) - first)) / 6:.4g}"
    print(f"{name}: {len(read.points)} points, corners {corners.tolist()}, volume {volume}")


look("one block", MESH, SOLID)
look("four further nodes", MESH, SOLID, FURTHER)
look("a reference point", MESH, SOLID, POINT)
look("a reference point ahead", MESH, POINT, SOLID)
PYTHON
diff - seen <<'SEEN'
one block: 4 points, corners [0, 1, 2, 3], volume 0.1667
four further nodes: 4 points, corners [0, 1, 2, 3], volume 36
a reference point: 1 points, corners [0, 1, 2, 3], volume none
a reference point ahead: KeyError 1
SEEN
cat seen
