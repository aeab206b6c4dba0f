"""Decks for other finite element programs, of two tetrahedra: read back field by field."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from cardan.core.units import mm
from cardan.model.material import STEEL
from cardan.physics.fem.meshing import MeshNodes
from cardan.topics.bracket.calculix_file import inp_text
from cardan.topics.bracket.nastran_file import bdf_text, seat_weights
from cardan.topics.bracket.solver_deck import DeckStep, SolverDeck, plain_text

CORNERS = np.array([[0, 0, 0], [90, 0, 0], [0, 60, 0], [0, 0, 30], [90, 60, 30]]) * mm
TETRAHEDRA = np.array([[0, 1, 2, 3], [1, 4, 2, 3]])
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
LOADS = np.array([10.0, -20.0, 0.0, 1.5, 0.0, -2.0, 0.0, 5.0, -9.80665])


def with_middles(corners, numbers):
    """Return nodes and, of corners (k, 4), elements (k, 10)."""
    points, elements, middle = list(corners), [], {}
    for element in numbers.tolist():
        mine = list(element)
        for a, b in EDGES:
            key = tuple(sorted((element[a], element[b])))
            if key not in middle:
                middle[key] = len(points)
                points.append((points[key[0]] + points[key[1]]) / 2)
            mine.append(middle[key])
        elements.append(mine)
    return np.array(points), np.array(elements)


@pytest.fixture
def deck():
    points, elements = with_middles(CORNERS, TETRAHEDRA)
    # Of the first tetrahedron the face z = 0 is the seat, and y = 0 is held.
    faces = elements[0][[[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7]]]
    nodes = MeshNodes(
        points=points, elements=elements, faces=faces,
        face_names=np.array(["seat", "bolt 1 wall"]), face_numbers=np.array([1, 2]),
    )  # fmt: skip
    return SolverDeck(
        comments=("one line", "another"), nodes=nodes, material=STEEL,
        held={"bolt 1 wall": "xy"}, held_clamped={"bolt 1 wall": "xyz"},
        frequencies=np.array([167.247866, 1119.15]),
        steps=(DeckStep(title="kerb", loads=LOADS, max_displacement=1e-4),
               DeckStep(title="at rest", loads=np.zeros(9), max_displacement=0.0)),
    )  # fmt: skip


def bulk_entries(text):
    """Yield the entries of bulk data as lists of their fields, without spaces."""
    entry = []
    for line in text.split("BEGIN BULK\n")[1].splitlines():
        if line.startswith("$") or "," in line or line == "ENDDATA":
            continue
        wide = 16 if "*" in line[:8] else 8
        fields = [line[k : k + wide].strip() for k in range(8, len(line), wide)]
        if line[0] in "*+":
            entry += fields
        else:
            yield from [entry] if entry else []
            entry = [line[:8].strip().rstrip("*"), *fields]
    yield entry


def test_nastran_deck_holds_mesh_material_coupling_and_loads(deck):
    text = bdf_text(deck)
    assert not [line for line in text.splitlines() if len(line) > 72 and line[0] != "$"]
    by = {}
    for name, *fields in bulk_entries(text):
        by.setdefault(name, []).append(fields)
    nodes, reference = deck.nodes, str(deck.reference_node)
    read = {f[0]: [float(x) for x in f[2:5]] for f in by["GRID"]}
    assert read.pop(reference) == [0, 0, 0]
    assert np.allclose(list(read.values()), nodes.points / mm)
    assert np.array_equal([list(map(int, f[2:])) for f in by["CTETRA"]], nodes.elements + 1)
    [metal] = by["MAT1"]
    assert [float(metal[k]) for k in (1, 3, 4)] == pytest.approx([206e3, 0.3, 7.85e-9], rel=1e-6)
    [spread] = by["RBE3"]
    assert spread[2:4] == [reference, "123456"]
    assert set(spread[5::3]) == {"123"}
    at = np.array(spread[6::3], dtype=int) - 1
    weight = np.array(spread[4::3], dtype=float)
    assert np.allclose(weight / weight.sum(), seat_weights(nodes)[at], atol=1e-6)
    assert [f[:2] for f in by["SPC1"]] == [["1", "12"], ["2", "123"]]
    assert set(map(int, by["SPC1"][0][2:])) == set((nodes.faces[1] + 1).tolist())
    assert [f[0] for f in by["LOAD"]] == ["1", "2"]
    parts = {f[0]: [float(x) for x in f[3:]] for f in (*by["FORCE"], *by["MOMENT"])}
    first = by["LOAD"][0]
    assert len(first) == 6
    force, moment = (next(f for f in by[n] if f[0] == first[3]) for n in ("FORCE", "MOMENT"))
    assert [float(x) for x in (*force[3:], *moment[3:])] == [1, 10, -20, 0, 1, 1500, 0, -2000]
    [gravity] = by["GRAV"]
    assert gravity[0] == first[5]
    # The frame accelerates one way: the bracket's mass is pulled the other.
    assert [float(x) for x in gravity[2:]] == [1, 0, -5000, 9806.65]
    assert parts[by["LOAD"][1][3]] == [0, 1, 0, 0]
    assert re.findall(r"SUBTITLE = (.*)", text) == ["kerb", "at rest"]
    assert by["EIGRL"] == [["1", "", "", "2"]]
    assert "$ largest displacement 0.1 mm" in text


@pytest.mark.parametrize("there", [(), (0,), (3,), (0, 3), (6,), (3, 7)])
def test_nastran_loads_have_a_component_and_every_set_that_is_named(deck, there):
    """Quick Reference Guide, FORCE, MOMENT and GRAV: one component at least is not 0."""
    loads = np.zeros(9)
    loads[list(there)] = 2.0
    step = DeckStep(title="one", loads=loads, max_displacement=0.0)
    entries = list(bulk_entries(bdf_text(replace(deck, steps=(step,)))))
    [combined] = [fields for name, *fields in entries if name == "LOAD"]
    vectors = [fields for name, *fields in entries if name in ("FORCE", "MOMENT", "GRAV")]
    assert all(any(float(x) for x in fields[-3:]) for fields in vectors)
    assert set(combined[3::2]) == {fields[0] for fields in vectors}


def test_seat_weights_are_shares_of_area(deck):
    """Of a flat triangle a third at each edge's middle; the mean place is then its centroid."""
    weights = seat_weights(deck.nodes)
    assert weights @ deck.nodes.points == pytest.approx(CORNERS[:3].mean(axis=0))
    assert sorted(weights[weights > 0]) == pytest.approx([1 / 3] * 3)


def test_calculix_deck_names_sets_and_directs_accelerations(deck):
    lines = inp_text(deck).splitlines()
    assert max(len(field) for line in lines if line[0] != "*" for field in line.split(",")) <= 20
    after = dict(pairwise(lines))
    assert after["*SURFACE,NAME=SEAT_FACES,TYPE=ELEMENT"] == "1,S1"
    assert after["*BOUNDARY"] == "BOLT_1_WALL,1,1"
    assert set(map(int, after["*NSET,NSET=BOLT_1_WALL"].strip(",").split(","))) == set(
        (deck.nodes.faces[1] + 1).tolist()
    )
    assert lines.count("*STEP") == 2
    reference = deck.reference_node
    assert {f"{reference},2,-2.000000000e+01", f"{reference},6,-2.000000000e+03"} < set(lines)
    assert {"EALL,GRAV,5.000000000e+03,0.,-1.,0.", "EALL,GRAV,9.806650000e+03,0.,0.,1."} < set(
        lines
    )


def test_calculix_deck_has_one_block_of_nodes(deck):
    """A common reader keeps the last block alone: findings/meshio_several_node_blocks.sh."""
    lines = inp_text(deck).splitlines()
    assert [one for one in lines if one.startswith("*NODE,")] == ["*NODE,NSET=NALL"]
    end = lines.index("*NSET,NSET=REFERENCE")
    assert lines[end - 1] == f"{deck.reference_node},0.,0.,0."
    assert lines[end + 1] == f"{deck.reference_node},"


def test_decks_say_natural_frequencies_and_the_step_that_computes_them(deck):
    said = "Natural frequencies of the bracket alone, the flange sliding: 167.248, 1119.15 Hz"
    assert f"$ {said}" in bdf_text(deck).splitlines()
    lines = inp_text(deck).splitlines()
    step = lines[lines.index(f"** {said}") + 2 :][:4]
    assert [one.removeprefix("** ") for one in step] == ["*STEP", "*FREQUENCY", "2", "*END STEP"]
    assert all(one.startswith("** ") for one in step)


def test_titles_are_ascii_in_one_line():
    assert plain_text("caminhão\n6x2, 4 Ω") == "caminhao 6x2, 4 ?"
