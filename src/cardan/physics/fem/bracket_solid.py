"""A bracket as a solid of the CAD kernel, and the names of its faces."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cardan.core.errors import DesignError
from cardan.core.units import Metre, mm
from cardan.model.bracket import FlangeBoundaryCondition, Vector3
from cardan.physics.fem.ngsolve_import import import_ngsolve

SEAT_FACE_NAME = "seat"
UNASSIGNED_FACE_NAME = "free"
MOUNT_FACE_NAME = "mount"
"""The plane that lies against the frame, without the washers' rings."""
WELD_FACE_NAME = "weld"
WELDED_END_NAME_PREFIX = "end "
"""Begins the name of a face that is welded to the frame, which holds it every way."""
HOLE_WALL_NAME_SUFFIX = " wall"
"""Ends the name of a bolt hole's wall; the ring about it is called after the bolt alone."""
WASHER_DIAMETER_RATIO = 2.0
"""Diameter of the ring a bolt bears on, over its hole's."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FaceSelection:
    """Faces of a STEP file that a pick found: how many, their area m², a bore's radius m or 0."""

    name: str
    face_count: int
    area: float
    radius: Metre = 0.0
    axis: Vector3 = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class BracketSolid:
    """A solid in metres, the bearing's centre at its origin.

    `shape` is the kernel's; its faces are called "seat", "bolt 1", "bolt 1 wall", ..., "end 1",
    ..., "mount", "weld" or "free". `thickness` is that of its walls, `volume` in m³.
    `face_selections` says what was found of the picks in a STEP file.
    """

    shape: Any
    bolts: tuple[str, ...]
    thickness: Metre
    volume: float
    face_selections: tuple[FaceSelection, ...] = ()

    def fixed_faces(self, hold: FlangeBoundaryCondition = "sliding") -> dict[str, str]:
        """Return the faces that are held, with the axes they may not move along.

        The bolts at least hold the washers' rings against the frame and the holes' walls along
        it; at most the whole plane is one with the frame. A real flange, which slides a
        little and lifts off a little, is as stiff as the first or stiffer, as the second or
        softer, as long as its bolts are rigid: each frees, or holds, all the other does and
        more. Bolts that give make it up to 11 % softer than the first where it is pulled off
        (`tests/verify/test_bracket_contact.py`). What is welded is held, whatever the bolts do.
        """
        names = {face.name for face in self.shape.faces}
        ends = dict.fromkeys(
            sorted(n for n in names if n.startswith(WELDED_END_NAME_PREFIX)), "xyz"
        )
        walls = [
            bolt + HOLE_WALL_NAME_SUFFIX
            for bolt in self.bolts
            if bolt + HOLE_WALL_NAME_SUFFIX in names
        ]
        rings = [bolt for bolt in self.bolts if bolt in names]
        if hold == "clamped" or not (walls and rings):
            plane = [MOUNT_FACE_NAME] if hold == "clamped" and MOUNT_FACE_NAME in names else []
            return ends | dict.fromkeys([*rings, *walls, *plane], "xyz")
        up = "xyz"[self.bolt_axis]
        return ends | dict.fromkeys(rings, up) | dict.fromkeys(walls, "xyz".replace(up, ""))

    @property
    def bolt_axis(self) -> int:
        """Axis along which the bolts pull: of x, y, z the one the rings do not reach along."""
        boxes = [face.bounding_box for face in self.shape.faces if face.name in self.bolts]
        low = np.array([[a.x, a.y, a.z] for a, _ in boxes])
        high = np.array([[b.x, b.y, b.z] for _, b in boxes])
        return int((high - low).sum(axis=0).argmin())

    def write_step(self, path: Path) -> None:
        """Write a STEP file in millimetres; faces keep their names."""
        occ = import_ngsolve().occ
        self.shape.Scale(occ.Pnt(0, 0, 0), 1 / mm).WriteStep(str(path))


def finish_solid(body: Any, thickness: Metre, *, bolts: int) -> BracketSolid:
    """Scale to metres and make sure of one sound solid with all its faces."""
    occ = import_ngsolve().occ
    solids = list(body.solids)
    if len(solids) != 1 or not solids[0].mass > 0:
        msg = f"a bracket must be one solid, this shape has {len(solids)}: its parts do not meet"
        raise DesignError(msg, about="bracket")
    shape = solids[0].Scale(occ.Pnt(0, 0, 0), mm)
    held = tuple(f"bolt {k}" for k in range(1, bolts + 1))
    names = {face.name for face in shape.faces}
    missing = [name for name in (SEAT_FACE_NAME, *held) if name not in names]
    if missing:
        msg = f"the shape has lost its {', '.join(missing)}: sizes overlap there"
        raise DesignError(msg, about="bracket")
    return BracketSolid(shape=shape, bolts=held, thickness=thickness, volume=float(shape.mass))
