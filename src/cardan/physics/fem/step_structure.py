"""Names and roots of a STEP file, which the CAD kernel leaves out where assemblies place parts.

Source: ISO 10303-21 (the text), ISO 10303-42 (solids, faces, vertices) and -44 (products). The text
is read for names alone; all geometry is the kernel's. A name goes to what has the same vertices,
whatever placement and unit.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from cardan.core.arrays import FloatArray

_STATEMENT = re.compile(r"#(\d+)\s*=\s*([A-Z0-9_]*)\s*\(((?:[^';]|'[^']*')*)\)\s*;")
_TEXT = re.compile(r"'((?:[^']|'')*)'")
_REFERENCE = re.compile(r"#(\d+)")
_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_UTF16 = re.compile(r"\\X2\\((?:[0-9A-F]{4})*)\\X0\\")
_UTF32 = re.compile(r"\\X4\\((?:00[01][0-9A-F]{5})*)\\X0\\")
_BYTE = re.compile(r"\\X\\([0-9A-F]{2})")
_SHIFTED = re.compile(r"\\S\\([ -~])")
_NO_NAME = "Open CASCADE STEP translator"
"""What the kernel writes where a product has no name."""
_SOLIDS = ("MANIFOLD_SOLID_BREP", "BREP_WITH_VOIDS", "FACETED_BREP")
_UNITS_IN_MM = (1.0, 1e3, 10.0, 25.4, 304.8)
_SAME = 1e-5
"""Share by which distances between vertices may differ, as digits of a file do."""

Vertices = FloatArray


@dataclass(frozen=True, kw_only=True)
class NamedSolid:
    """A solid of the text: its own name, that of its product, and its faces in order.

    `vertices` has those of each face, (n, 3), in the file's unit.
    """

    name: str
    product: str
    face_names: tuple[str, ...]
    vertices: tuple[Vertices, ...]


@dataclass(frozen=True)
class _Entity:
    kind: str
    text: str

    @cached_property
    def references(self) -> tuple[int, ...]:
        """Entities that it refers to, in order."""
        return tuple(map(int, _REFERENCE.findall(_TEXT.sub("", self.text))))

    @cached_property
    def texts(self) -> tuple[str, ...]:
        """Its texts, decoded, in order."""
        return tuple(_decoded(one) for one in _TEXT.findall(self.text))


class StepStructure:
    """Products, solids and faces of the text of a STEP file."""

    def __init__(self, text: str) -> None:
        self._text = _COMMENT.sub("", text)
        found = list(_STATEMENT.finditer(self._text))
        self._spans = {int(m[1]): m.span() for m in found}
        self._entities = {int(m[1]): _Entity(m[2], m[3]) for m in found}

    def root_texts(self) -> tuple[str, ...]:
        """Return the text with one of its root products each; nothing where there is one at most.

        A root is a product with a shape that no assembly places. The kernel reads the first.
        """
        placed = {
            e.references[1] for e in self._of_kind("NEXT_ASSEMBLY_USAGE_OCCURRENCE")
            if len(e.references) > 1
        }  # fmt: skip
        roots = [
            k for k, e in self._entities.items()
            if e.kind == "SHAPE_DEFINITION_REPRESENTATION" and self._product(e) is not None
            and self._product(e) not in placed
        ]  # fmt: skip
        if len(roots) < 2:
            return ()
        return tuple(self._without(k for k in roots if k != root) for root in roots)

    @cached_property
    def solids(self) -> tuple[NamedSolid, ...]:
        """Every solid of the text."""
        products = self._product_names()
        return tuple(
            NamedSolid(
                name=(e.texts or ("",))[0],
                product=products.get(k, ""),
                face_names=tuple((self._entities[f].texts or ("",))[0] for f in faces),
                vertices=tuple(self._vertices(f) for f in faces),
            )
            for k, e in self._entities.items()
            if e.kind in _SOLIDS and (faces := self._faces(e))
        )

    def _of_kind(self, kind: str) -> Iterator[_Entity]:
        return (e for e in self._entities.values() if e.kind == kind)

    def _without(self, statements: Iterator[int]) -> str:
        text = self._text
        for start, end in sorted((self._spans[k] for k in statements), reverse=True):
            text = text[:start] + text[end:]
        return text

    def _product(self, shape: _Entity) -> int | None:
        """Return the product definition that a shape representation is of; else None."""
        for k in shape.references:
            pointed = self._entities.get(k)
            if pointed and pointed.kind == "PRODUCT_DEFINITION_SHAPE":
                of = pointed.references[-1:]
                definition = self._entities.get(of[0]) if of else None
                if definition and definition.kind.startswith("PRODUCT_DEFINITION"):
                    return of[0]
        return None

    def _product_names(self) -> dict[int, str]:
        """Return the name of the product of each solid."""
        same: dict[int, set[int]] = {}
        for relation in self._of_kind("SHAPE_REPRESENTATION_RELATIONSHIP"):
            if len(relation.references) > 1:
                one, other = relation.references[-2:]
                same.setdefault(one, set()).add(other)
                same.setdefault(other, set()).add(one)
        found: dict[int, str] = {}
        for shape in self._of_kind("SHAPE_DEFINITION_REPRESENTATION"):
            definition = self._product(shape)
            if definition is None:
                continue
            name = self._product_name(definition)
            for representation in {shape.references[-1], *same.get(shape.references[-1], ())}:
                held = self._entities.get(representation)
                for item in held.references if held else ():
                    if item in self._entities and self._entities[item].kind in _SOLIDS:
                        found[item] = name
        return found

    def _product_name(self, definition: int) -> str:
        """Return the name of a product definition's product, or its identifier."""
        for formation in self._entities[definition].references:
            held = self._entities.get(formation)
            for product in held.references if held else ():
                of = self._entities.get(product)
                if of and of.kind == "PRODUCT":
                    said = (*of.texts[1:2], *of.texts[:1])
                    return next((t for t in said if t and not t.startswith(_NO_NAME)), "")
        return ""

    def _faces(self, solid: _Entity) -> list[int]:
        """Return the faces of a solid's shells, in order."""
        found: list[int] = []
        for k in solid.references:
            shell = self._entities.get(k)
            if shell and shell.kind == "ORIENTED_CLOSED_SHELL":
                shell = self._entities.get(shell.references[0]) if shell.references else None
            if shell and shell.kind == "CLOSED_SHELL":
                found += [f for f in shell.references if f in self._entities]
        return found

    def _vertices(self, face: int) -> Vertices:
        """Return the places of a face's vertices, (n, 3)."""
        points: dict[int, list[float]] = {}
        stack, seen = list(self._entities[face].references), set[int]()
        while stack:
            k = stack.pop()
            entity = self._entities.get(k)
            if entity is None or k in seen:
                continue
            seen.add(k)
            if entity.kind == "VERTEX_POINT":
                for p in entity.references:
                    if p in self._entities and self._entities[p].kind == "CARTESIAN_POINT":
                        points[p] = _coordinates(self._entities[p])
            elif entity.kind == "EDGE_CURVE":
                stack += entity.references[:2]
            elif entity.kind in (
                "FACE_BOUND", "FACE_OUTER_BOUND", "EDGE_LOOP", "VERTEX_LOOP", "ORIENTED_EDGE",
            ):  # fmt: skip
                stack += entity.references
        return np.array([p for p in points.values() if len(p) == 3]).reshape(-1, 3)


def _coordinates(point: _Entity) -> list[float]:
    bare = _TEXT.sub("", point.text).replace("(", ",").replace(")", ",")
    try:
        return [float(c) for c in bare.split(",") if c.strip()]
    except ValueError:
        return []


def _decoded(text: str) -> str:
    """Return a text of ISO 10303-21: doubled quotes, and letters beyond ASCII.

    Its third edition writes UTF-8, as CAD kernels did before; the file was read byte by byte.
    CadQuery 2.8 and build123d 0.13 write UTF-8 of UTF-8.
    """
    for _ in range(2):
        try:
            text = text.encode("latin-1").decode("utf-8")
        except UnicodeError:
            break  # a letter of Latin-1 itself, or one beyond it
    said = _UTF16.sub(lambda m: bytes.fromhex(m[1]).decode("utf-16-be", "replace"), text)
    said = _UTF32.sub(lambda m: bytes.fromhex(m[1]).decode("utf-32-be", "replace"), said)
    said = _BYTE.sub(lambda m: chr(int(m[1], 16)), said)
    said = _SHIFTED.sub(lambda m: chr(ord(m[1]) + 128), said)
    return said.replace("''", "'").replace("\\\\", "\\")


# --------------------------------------------------------------------------- onto the kernel's


def names_of_solids(
    structure: StepStructure, solids: Sequence[Any]
) -> list[tuple[str, str, tuple[str, ...]]]:
    """Return name, product and names of faces of the kernel's solids; empty where not known.

    A solid of the text is that of the kernel whose faces have vertices as far from the middle of
    all, in the same order. Where several of other names fit, nothing is known.
    """
    return [_names(structure.solids, solid) for solid in solids]


def _names(written: Sequence[NamedSolid], solid: Any) -> tuple[str, str, tuple[str, ...]]:
    faces = [
        np.array([[v.p.x, v.p.y, v.p.z] for v in face.vertices]).reshape(-1, 3)
        for face in solid.faces
    ]
    size, there = _shape(faces)
    fitting = {
        (one.name, one.product, one.face_names)
        for one in written
        if len(one.vertices) == len(faces) and _fits(_shape(one.vertices), (size, there))
    }
    return fitting.pop() if len(fitting) == 1 else ("", "", ("",) * len(faces))


def _shape(faces: Sequence[Vertices]) -> tuple[float, list[FloatArray]]:
    """Return the size of a solid, and how far each face's vertices are from the middle of all.

    Distances are shares of the size, those of one face sorted, the same ones once.
    """
    every = np.concatenate([np.zeros((0, 3)), *faces])
    if not len(every) or not (size := float(np.ptp(every, axis=0).max())):
        return 0.0, [np.zeros(0) for _ in faces]
    # Cells of a grid off the round numbers of drawings: noise of a placement leaves a point in its.
    cells = np.floor(every / size * 1e5 + 1 / np.pi)
    middle = every[np.unique(cells, axis=0, return_index=True)[1]].mean(axis=0)
    found: list[FloatArray] = []
    for vertices in faces:
        away = np.sort(np.linalg.norm(vertices - middle, axis=1)) / size
        found.append(away[np.diff(away, prepend=-1) > _SAME])
    return size, found


def _fits(written: tuple[float, list[FloatArray]], there: tuple[float, list[FloatArray]]) -> bool:
    """Return whether all faces have the same distances, in a unit of length."""
    if not (written[0] and there[0]):
        return False
    return all(
        len(a) == len(b) and np.allclose(a * written[0] * unit, b * there[0], rtol=0, atol=within)
        for unit, within in [_unit(written, there)]
        for a, b in zip(written[1], there[1], strict=True)
    )


def _unit(
    written: tuple[float, list[FloatArray]], there: tuple[float, list[FloatArray]]
) -> tuple[float, float]:
    """Return the unit of the text in mm by the farthest vertices, and the tolerance in mm."""
    far, read = (max(float(d.max(initial=0)) for d in f) * size for size, f in (there, written))
    return min(_UNITS_IN_MM, key=lambda u: abs(read * u - far)), 3 * _SAME * far
