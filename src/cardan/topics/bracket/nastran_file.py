"""A bracket as a deck of Nastran: case control of linear statics (SOL 101), and bulk data.

Fields of 8 and of 16 characters. Source: MSC Nastran Quick Reference Guide: GRID, CTETRA, RBE3.
"""

from collections.abc import Iterable, Iterator

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.units import mm
from cardan.physics.fem.bracket_solid import SEAT_FACE_NAME
from cardan.physics.fem.meshing import MeshNodes
from cardan.topics.bracket.solver_deck import SolverDeck, deck_loads

_FIELDS_PER_LINE = 8
_SUBTITLE_LENGTH = 64
_FORCE_SETS, _GRAVITY_SETS = 100_000, 200_000
"""What numbers of sets of forces, and of accelerations, begin beyond."""


def bdf_text(deck: SolverDeck) -> str:
    """Return a deck: one subcase a case, mesh, sets, material, seat coupling, held faces."""
    nodes, seat_element = deck.nodes, len(deck.nodes.elements) + 1
    lines = [
        *(f"$ {line}" for line in deck.comments),
        f"$ {deck.frequency_text}",
        "$ SOL 103 computes them, with SPC = 1 and METHOD = 1 for its one subcase.",
        "SOL 101",
        "CEND",
        "ECHO = NONE",
        "DISPLACEMENT(PLOT) = ALL",
        "STRESS(PLOT) = ALL",
    ]
    for k, (face, name) in enumerate(deck.face_sets.items(), 1):
        lines += [f"$ Set {k}: {name}", *_set_lines(k, deck.face_nodes(face).tolist())]
    lines.append("SPC = 1")
    for k, step in enumerate(deck.steps, 1):
        lines += [
            f"SUBCASE {k}",
            f"$ largest displacement {step.max_displacement / mm:.6g} mm",
            f"  SUBTITLE = {step.title[:_SUBTITLE_LENGTH]}",
            f"  LOAD = {k}",
        ]
    lines += ["BEGIN BULK", "PARAM,POST,-1"]
    for k, (x, y, z) in enumerate(nodes.points / mm, 1):
        lines += _large("GRID", k, None, x, y, z)
    lines += _large("GRID", deck.reference_node, None, 0.0, 0.0, 0.0)
    for k, corners in enumerate((nodes.elements + 1).tolist(), 1):
        lines += _small("CTETRA", k, 1, *corners)
    lines += _small("PSOLID", 1, 1)
    metal = deck.material
    lines += _large(
        "MAT1", 1, metal.youngs_modulus * mm**2, None, metal.poisson, metal.density * mm**4
    )
    lines += _coupling_lines(deck, seat_element)
    lines.append("$ SPC 1: the flange slides in its plane. SPC 2: clamped.")
    for number, held in ((1, deck.held), (2, deck.held_clamped)):
        for face, axes in held.items():
            dofs = "".join(str("xyz".index(axis) + 1) for axis in axes)
            if len(at := deck.face_nodes(face)):
                lines += _small("SPC1", number, dofs, *at.tolist())
    lines += _small("EIGRL", 1, None, None, len(deck.frequencies))
    for k, step in enumerate(deck.steps, 1):
        lines += _load_lines(k, deck_loads(step.loads), deck.reference_node)
    return "\n".join([*lines, "ENDDATA"]) + "\n"


def seat_weights(nodes: MeshNodes) -> FloatArray:
    """Return the share of each node (n,) in the seat's area, which adds up to 1.

    Integrals of the shape functions over six-node triangles, by the rule of degree 2 at edge
    middles: corners have none.
    """
    faces = nodes.faces[nodes.face_names == SEAT_FACE_NAME]
    x = nodes.points[faces]
    share = np.zeros(len(nodes.points))
    for node, (a, b, c) in zip(
        (3, 4, 5), ((0.5, 0.5, 0), (0, 0.5, 0.5), (0.5, 0, 0.5)), strict=True
    ):
        by_r = np.array([1 - 4 * a, 4 * b - 1, 0, 4 * (a - b), 4 * c, -4 * c])
        by_s = np.array([1 - 4 * a, 0, 4 * c - 1, -4 * b, 4 * b, 4 * (a - c)])
        r, s = (np.einsum("k,fkx->fx", d, x) for d in (by_r, by_s))
        np.add.at(share, faces[:, node], np.linalg.norm(np.cross(r, s), axis=-1) / 6)
    return share / share.sum()


def _coupling_lines(deck: SolverDeck, element: int) -> Iterator[str]:
    """Yield the element that spreads the reference node's loads over the seat, by its area."""
    weights = seat_weights(deck.nodes)
    at = np.flatnonzero(weights)
    relative = weights[at] / weights[at].max()
    yield "$ Seat: loads of the node at the bearing's centre, spread linearly by area"
    groups = (
        field
        for node, w in zip((at + 1).tolist(), relative.tolist(), strict=True)
        for field in (f"{w:.6f}", "123", node)
    )
    yield from _small("RBE3", element, None, deck.reference_node, "123456", *groups)


def _load_lines(number: int, loads: FloatArray, node: int) -> Iterator[str]:
    """Yield the loads (9,) of a case in N, N mm and mm/s².

    An entry with a factor of 1 needs a component other than 0, by the guide.
    """
    forces, gravity = _FORCE_SETS + number, _GRAVITY_SETS + number
    force, moment, acceleration = loads[:3], loads[3:6], loads[6:]
    parts = [1.0, forces, *([1.0, gravity] if acceleration.any() else [])]
    yield from _small("LOAD", number, 1.0, *parts)
    if force.any():
        yield from _large("FORCE", forces, node, 0, 1.0, *force.tolist())
    if moment.any():
        yield from _large("MOMENT", forces, node, 0, 1.0, *moment.tolist())
    if not (force.any() or moment.any()):  # LOAD names a set that has to be there
        yield from _large("FORCE", forces, node, 0, 0.0, 1.0, 0.0, 0.0)
    if acceleration.any():
        yield from _large("GRAV", gravity, 0, 1.0, *(0.0 - acceleration).tolist())


_Field = str | int | float | None


def _small(name: str, *fields: _Field) -> Iterator[str]:
    """Yield an entry in fields of 8 characters."""
    return _entry(name, fields, width=8, each=_FIELDS_PER_LINE)


def _large(name: str, *fields: _Field) -> Iterator[str]:
    """Yield an entry in fields of 16 characters."""
    return _entry(f"{name}*", fields, width=16, each=_FIELDS_PER_LINE // 2)


def _entry(name: str, fields: tuple[_Field, ...], *, width: int, each: int) -> Iterator[str]:
    more = "*" if width > 8 else "+"
    for k in range(0, len(fields), each):
        head = name if k == 0 else more
        text = "".join(f"{_field(f, width):>{width}}" for f in fields[k : k + each])
        yield f"{head:<8}{text}".rstrip()


def _field(value: _Field, width: int) -> str:
    """Return a number as it stands in a field."""
    if value is None:
        return ""
    if isinstance(value, float | np.floating):
        return f"{value:.9E}" if width > 8 else f"{value:.1f}"
    return str(value)


def _set_lines(number: int, nodes: Iterable[int]) -> list[str]:
    """Return a set of case control, in lines of 72 characters at most."""
    lines, line = [], f"SET {number} = "
    every = [str(n) for n in nodes]
    for k, node in enumerate(every):
        word = node + ("," if k + 1 < len(every) else "")
        if len(line) + len(word) > 72:
            lines.append(line)
            line = "  "
        line += word
    return [*lines, line]
