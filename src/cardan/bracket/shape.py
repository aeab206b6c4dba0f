"""From a bracket's drawing, or a STEP file, to a solid whose seat and bolt faces have names.

The CAD kernel works in millimetres, the unit its tolerances and STEP files are made for;
what leaves this module is scaled to metres, with the bearing's centre at the origin.
"""

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cardan.base.errors import CardanError, DesignError
from cardan.base.units import Metre, mm
from cardan.bracket.elastic import PER_RADIUS
from cardan.bracket.engine import engine
from cardan.model.bracket import Hold, LShape, Pick, Shape, StepShape, UShape, Vector

SEAT = "seat"
FREE = "free"
MOUNT = "mount"
"""The plane that lies against the frame, without the washers' rings."""
WELD = "weld"
END = "end "
"""Begins the name of a face that is welded to the frame, which holds it every way."""
WALL = " wall"
"""Ends the name of a bolt hole's wall; the ring about it is called after the bolt alone."""
WASHER = 2.0
"""Diameter of the ring a bolt bears on, over its hole's."""

_AS_THICK = 1.75
"""Times the mean thickness of a solid, and share of it, that its walls may have."""
_ALONG = np.cos(np.radians(20))
"""Of the angle between a bore and the shaft's direction: shafts slope by less."""
_BESIDE = 0.5
"""Radii of a seat's bore, beyond whose ends its bearing's centre may lie: bearings are no wider
than their bore's radius, and one that is as wide touches the seat from there at least."""
_TIE = 0.01
"""mm, by which another face may be farther from a point that picks one."""
_PAD = 4.0
"""Radii of a hole, from its axis, that a pad about it may reach."""
_ASKEW = 1e-5
"""Sine of the angle between a bolt and an axis that is a drawing's last digits."""
_ROUND = 0.75
"""Of a turn that a bolt's hole goes at least, cut into or not; a slot's end goes by half."""
_SMALL = 0.4
"""Of its thickness, a round that breaks a corner of it; an estimate knows larger ones as bends."""
_WIDE = 3.0
"""Times its thickness, a round whose elements that thickness bounds, and not its radius alone."""
_NEAR = 1e-3  # mm: faces of a drawing meet far closer, and none is smaller


@dataclass(frozen=True, slots=True, kw_only=True)
class Picked:
    """Faces of a STEP file that a pick found: how many, their area m², a bore's radius m or 0."""

    name: str
    faces: int
    area: float
    radius: Metre = 0.0
    axis: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Solid:
    """A solid in metres, the bearing's centre at its origin.

    `shape` is the kernel's; its faces are called "seat", "bolt 1", "bolt 1 wall", ..., "end 1",
    ..., "mount", "weld" or "free". `thickness` is that of its walls, `volume` in m³. `found` says
    what was found of the picks in a STEP file.
    """

    shape: Any
    bolts: tuple[str, ...]
    thickness: Metre
    volume: float
    found: tuple[Picked, ...] = ()

    def held(self, hold: Hold = "sliding") -> dict[str, str]:
        """Return the faces that are held, with the axes they may not move along.

        The bolts at least hold the washers' rings against the frame and the holes' walls along
        it; at most the whole plane is one with the frame. A real flange, which slides a
        little and lifts off a little, is as stiff as the first or stiffer, as the second or
        softer, as long as its bolts are rigid: each frees, or holds, all the other does and
        more. Bolts that give make it up to 11 % softer than the first where it is pulled off
        (`tests/verify/test_bracket_contact.py`). What is welded is held, whatever the bolts do.
        """
        names = {face.name for face in self.shape.faces}
        ends = dict.fromkeys(sorted(n for n in names if n.startswith(END)), "xyz")
        walls = [bolt + WALL for bolt in self.bolts if bolt + WALL in names]
        rings = [bolt for bolt in self.bolts if bolt in names]
        if hold == "clamped" or not (walls and rings):
            plane = [MOUNT] if hold == "clamped" and MOUNT in names else []
            return ends | dict.fromkeys([*rings, *walls, *plane], "xyz")
        up = "xyz"[self.upright]
        return ends | dict.fromkeys(rings, up) | dict.fromkeys(walls, "xyz".replace(up, ""))

    @property
    def upright(self) -> int:
        """Axis along which the bolts pull: of x, y, z the one the rings do not reach along."""
        boxes = [face.bounding_box for face in self.shape.faces if face.name in self.bolts]
        low = np.array([[a.x, a.y, a.z] for a, _ in boxes])
        high = np.array([[b.x, b.y, b.z] for _, b in boxes])
        return int((high - low).sum(axis=0).argmin())

    def write(self, path: Path) -> None:
        """Write a STEP file in millimetres; faces keep their names."""
        occ = engine().occ
        self.shape.Scale(occ.Pnt(0, 0, 0), 1 / mm).WriteStep(str(path))


def solid(part: Shape) -> Solid:
    """Build a bracket.

    Raises
    ------
    DesignError
        If the kernel cannot build the shape, or a STEP file or a face of it is not found.
    NotInstalled
        Without the extra `cardan[bracket]`.
    """
    if isinstance(part, StepShape):
        return _from_step(part)
    body, name = (_u, "U") if isinstance(part, UShape) else (_l, "L")
    try:
        raw = body(part)  # type: ignore[arg-type]
    except CardanError:
        raise
    except Exception as error:  # the kernel raises bare exceptions of its own
        msg = f"the CAD kernel cannot build this {name} bracket ({error}): try a smaller fillet"
        raise DesignError(msg, about="bracket") from error
    raw = _with_washers(raw, part)
    for face in raw.faces:
        face.name = _named(face, part)
    return _finished(raw, part.thickness, bolts=len(part.places))


def _u(part: UShape) -> Any:
    """Sheet, bends and holes of a U, in mm."""
    occ = engine().occ
    t, r, w, h = (v / mm for v in (part.thickness, part.bend_radius, part.width, part.height))
    inner, reach = part.seat_diameter / 2 / mm, part.flange / mm
    leg = inner + t
    end = leg + reach

    def at(y: float, z: float) -> Any:
        return occ.Pnt(-w / 2, y, z)

    def line(*points: tuple[float, float]) -> list[Any]:
        # Where the bend ends at the seat there is no leg, and a line of no length ends the kernel.
        pairs = [p for p in itertools.pairwise(points) if np.hypot(*np.subtract(*p)) > _NEAR]
        return [occ.Segment(at(*a), at(*b)) for a, b in pairs]

    def arc(centre: tuple[float, float], radius: float, start: float, end: float) -> Any:
        angles = np.radians([start, (start + end) / 2, end])
        return occ.ArcOfCircle(
            *(at(centre[0] + radius * np.cos(a), centre[1] + radius * np.sin(a)) for a in angles)
        )

    bend = h - t - r
    outline = [
        arc((0, 0), inner, 180, 360),
        *line((inner, 0), (inner, bend)),
        arc((leg + r, bend), r + t, 180, 90),
        *line((leg + r, h), (end, h), (end, h - t), (leg + r, h - t)),
        arc((leg + r, bend), r, 90, 180),
        *line((leg, bend), (leg, 0)),
        arc((0, 0), leg, 0, -180),
        *line((-leg, 0), (-leg, bend)),
        arc((-leg - r, bend), r, 0, 90),
        *line((-leg - r, h - t), (-end, h - t), (-end, h), (-leg - r, h)),
        arc((-leg - r, bend), r + t, 90, 0),
        *line((-inner, bend), (-inner, 0)),
    ]
    sheet = occ.Face(occ.Wire(outline)).Extrude(w * occ.X)
    if part.gusset:
        thick, down = part.gusset / mm, part.gusset_height / mm
        toe = thick / 2 + _NEAR
        mid, far = leg - t / 2, leg + 0.85 * reach  # ribs start inside the sheet, to fuse with it
        nose = 2 * part.fillet / mm  # a fillet as high as the end it runs round would swallow it
        for side in (-1, 1):
            corners = [(leg + r, h - t / 2), (far, h - t / 2), (far, h - t - nose),
                       (leg + nose, h - t - down), (mid, h - t - down), (mid, bend)]  # fmt: skip
            quarter = [(leg + r - (r + t / 2) * np.cos(a), bend + (r + t / 2) * np.sin(a))
                       for a in np.radians([0, 45, 90])]  # fmt: skip
            rim = [occ.Pnt(-thick / 2, side * y, z) for y, z in corners]
            inside = [occ.Pnt(-thick / 2, side * y, z) for y, z in quarter]
            edges = [occ.Segment(a, b) for a, b in itertools.pairwise(rim)]
            rib = occ.Face(occ.Wire([*edges, occ.ArcOfCircle(*inside)]))
            sheet = sheet + rib.Extrude(occ.Vec(thick, 0, 0))
        seams = [
            e for e in sheet.edges
            if max(abs(p.x) for p in (e.start, e.center, e.end)) < toe
            and _on_sheet(e, leg=leg, under=h - t, bend=(leg + r, bend, r))
        ]  # fmt: skip
        sheet = sheet.MakeFillet(seams, part.fillet / mm)
        for face in sheet.faces:
            # The kernel calls the faces it makes of a seam "fillet"; here each is a weld.
            face.name = WELD if face.name == "fillet" else FREE
    return _drilled(sheet, part)


def _on_sheet(edge: Any, *, leg: float, under: float, bend: tuple[float, float, float]) -> bool:
    """Whether an edge lies where a rib meets the outside of a U's sheet."""
    y0, z0, r = bend
    for p in (edge.start, edge.center, edge.end):
        y, z = abs(p.y), p.z
        flat = abs(y - leg) < _NEAR or abs(z - under) < _NEAR
        # The centre of an arc's curve lies off the arc, on its inner side.
        curved = y <= y0 + _NEAR and z >= z0 - _NEAR and abs(np.hypot(y - y0, z - z0) - r) < 0.1 * r
        if not (flat or curved):
            return False
    return True


def _l(part: LShape) -> Any:
    """Plate, wall, root, bore and holes of an L, in mm."""
    occ = engine().occ
    t, h, w = part.thickness / mm, part.height / mm, part.width / mm
    wall, bore = part.wall_width / mm, part.seat_diameter / 2 / mm
    front, foot = -t / 2, -bore - part.rim / mm
    rear = front + part.depth / mm
    plate = occ.Box(occ.Pnt(front, -w / 2, h - t), occ.Pnt(rear, w / 2, h))
    hung = occ.Box(occ.Pnt(front, -wall / 2, foot), occ.Pnt(-front, wall / 2, h))
    low = [e for e in hung.edges if abs(e.center.z - foot) < _NEAR and abs(e.center.x) < _NEAR]
    hung = hung.MakeFillet(low, 0.6 * min(wall / 2, part.rim / mm + bore))
    body = plate + hung
    if part.gusset:
        thick, down = part.gusset / mm, part.gusset_height / mm
        back = -front + 0.85 * (rear + front)
        for side in (-1, 1):
            y = side * (part.brace / mm - thick / 2) - thick / 2
            corners = [(0.0, h - t / 2), (back, h - t / 2), (back, h - 1.5 * t),
                       (-front + t / 2, h - t - down), (0.0, h - t - down)]  # fmt: skip
            points = [occ.Pnt(x, y, z) for x, z in corners]
            ring = [*points, points[0]]
            wire = occ.Wire([occ.Segment(a, b) for a, b in itertools.pairwise(ring)])
            body = body + occ.Face(wire).Extrude(occ.Vec(0, thick, 0))
    root = [
        e for e in body.edges
        if abs(e.center.x + front) < _NEAR and abs(e.center.z - h + t) < _NEAR
        and abs(e.start.z - e.end.z) < _NEAR
    ]  # fmt: skip
    body = body.MakeFillet(root, part.fillet / mm)
    x_axis = occ.Pnt(front - 1, 0, 0)
    body = body - occ.Cylinder(x_axis, occ.X, r=bore, h=t + 2)
    return _drilled(body, part)


def _drilled(body: Any, part: UShape | LShape) -> Any:
    """Drill the bolt holes."""
    occ = engine().occ
    t, r = part.thickness / mm, part.bolt_diameter / 2 / mm
    for place in part.places:
        x, y, z = (v / mm for v in place)
        body = body - occ.Cylinder(occ.Pnt(x, y, z - t - 1), occ.Z, r=r, h=t + 2)
    return body


def _with_washers(body: Any, part: UShape | LShape) -> Any:
    """Imprint the ring each bolt presses against the frame on the mounting plane."""
    occ = engine().occ
    r = part.bolt_diameter / 2 / mm
    rings: list[Any] = []
    for place in part.places:
        x, y, z = (v / mm for v in place)
        plane = occ.WorkPlane(occ.Axes((x, y, z), occ.Z, occ.X))
        disc = plane.Circle(WASHER * r).Face()
        rings.append(disc - occ.Cylinder(occ.Pnt(x, y, z - 1), occ.Z, r=r, h=2))
    return occ.Glue([body, *rings])


def _named(face: Any, part: UShape | LShape) -> str:
    """Name a face of a parametric bracket by where it lies."""
    low, high = face.bounding_box
    low, high = np.array([low.x, low.y, low.z]), np.array([high.x, high.y, high.z])
    for k, place in enumerate(part.places, 1):
        across = np.abs(np.stack([low, high])[:, :2] - np.asarray(place[:2]) / mm).max()
        if across < WASHER * part.bolt_diameter / 2 / mm + 0.1:
            return f"bolt {k}" if high[2] - low[2] < _NEAR * 100 else f"bolt {k}{WALL}"
    if face.name == WELD:
        return WELD
    if low[2] > part.height / mm - _NEAR * 100:
        return MOUNT
    bore = part.seat_diameter / 2 / mm
    u = isinstance(part, UShape)
    half, top = (part.width if u else part.thickness) / 2 / mm, 0.0 if u else bore
    reach = np.abs(np.stack([low, high])).max(axis=0)
    # The kernel's boxes are a little loose, so the seat is told by a tenth of a millimetre. A
    # U's ends at the axis: the legs of a low one reach no farther than its round.
    if reach[0] < half + 0.1 and max(reach[1], -low[2]) < bore + 0.1 and high[2] < top + 0.1:
        return SEAT
    return FREE


def _from_step(part: StepShape) -> Solid:
    """Read a STEP file and find the faces the user picked."""
    occ = engine().occ
    if not Path(part.path).is_file():
        msg = f"no STEP file at {part.path}"
        raise DesignError(msg, about="bracket.step")
    try:
        body = occ.OCCGeometry(part.path).shape
    except Exception as error:  # the kernel raises bare exceptions of its own
        msg = f"{part.path} is not a STEP file the CAD kernel can read ({error})"
        raise DesignError(msg, about="bracket.step") from error
    body = _chosen(body, part)
    faces = list(body.faces)
    wanted = [
        (SEAT, part.seat),
        *((f"bolt {k}", (p,)) for k, p in enumerate(part.bolts, 1)),
        *((f"{END}{k}", (p,)) for k, p in enumerate(part.welded, 1)),
    ]
    taken: dict[int, str] = {}
    found: list[Picked] = []
    rings: list[tuple[str, Any]] = []
    imprints: list[Any] = []
    long: list[float] = []
    upright: list[int] = []
    round_: set[int] = set()
    seat: tuple[list[Any], _Cylinder | None] = [], None
    for name, picks in wanted:
        mine = {k for n, pick in enumerate(picks) for k in _picked(faces, pick, part.path, name, n)}
        mine |= {other for k in mine for other in _bore(faces, k)}
        for k in mine:
            if taken.get(k, name) != name:
                msg = f"the same face of {part.path} is picked as {taken[k]} and as {name}"
                raise DesignError(msg, about="bracket.step")
            taken[k] = name
        walls = {k: c for k in sorted(mine) if (c := _cylinder(faces[k]))}
        if outside := [c for k, c in walls.items() if _outside(body, faces[k], c)]:
            msg = (
                f"{name}: a face picked of {part.path} is the outside of a round of "
                f"{outside[0].radius:.4g} mm radius: pick its inside"
            )
            raise DesignError(msg, about=_about(name))
        bore = next(iter(walls.values()), None)
        area = sum(faces[k].mass for k in mine) * mm**2
        found.append(
            Picked(name=name, faces=len(mine), area=float(area))
            if bore is None
            else Picked(
                name=name, faces=len(mine), area=float(area), radius=bore.radius * mm,
                axis=(float(bore.axis[0]), float(bore.axis[1]), float(bore.axis[2])),
            )
        )  # fmt: skip
        if name == SEAT:
            seat = [faces[k] for k in mine], bore
            continue
        if name.startswith(END):
            continue
        if bore is not None:
            _all_round(bore, [faces[k] for k in walls], part, name)
            upright.append(_along_an_axis(bore, part, name, upright))
        long += [_length(faces[k], bore) for k in walls]
        flat = sorted(mine - walls.keys())
        for k in flat:
            _round_its_hole(body, faces, k, part, name)
        if flat:  # a ring, or a pad, is drawn already
            rings.append((name, faces[flat[0]]))
        elif bore is not None and (ring := _ring(body, bore, part)) is not None:
            rings.append((name, ring))
            imprints.append(ring)
        if rings and rings[-1][0] == name:
            round_ |= walls.keys()
    _as_thick(body, faces, long, part)
    _centred(*seat, part)
    if seat[1] is None:
        _no_bore(body, {k: face for k, face in enumerate(faces) if k not in taken}, part)
    for k, face in enumerate(faces):
        face.name = taken.get(k, FREE) + (WALL if k in round_ else "")
    if imprints:
        body = occ.Glue([body, *imprints])
    _name_plane(body, rings)
    x, y, z = (-v / mm for v in part.centre)
    made = _finished(body.Move(occ.Vec(x, y, z)), part.thickness, bolts=len(part.bolts))
    return replace(made, found=tuple(found))


def _chosen(body: Any, part: StepShape) -> Any:
    """Return the solid that is meant: the only one, or the one of its name, or of its place."""
    solids = list(body.solids)
    told = ", ".join(
        f"{one.name or f'{k} (no name)'} of {one.mass / 1000:.4g} cm3"
        for k, one in enumerate(solids, 1)
    )
    if not solids:
        msg = f"{part.path} has no solid, surfaces at most: export the bracket as a solid"
        raise DesignError(msg, about="bracket.step.file")
    if part.solid:
        named = [one for one in solids if one.name == part.solid] or [
            one for k, one in enumerate(solids, 1) if not one.name and f"{k}" == part.solid
        ]
        if len(named) != 1:
            if named:
                msg = f"{len(named)} solids of {part.path} are called {part.solid!r}: it has {told}"
            else:
                msg = f"no solid of {part.path} is called {part.solid!r}: it has {told}"
            raise DesignError(msg, about="bracket.step.solid")
        return named[0]
    if len(solids) > 1:
        msg = (
            f"{part.path} has {len(solids)} solids, {told}: say which by `solid`, its name or, if "
            "it has none, its number"
        )
        raise DesignError(msg, about="bracket.step")
    return solids[0]


def _picked(faces: list[Any], pick: Pick, path: str, name: str, place: int) -> Iterable[int]:
    """Places of the faces a pick means."""
    about = _about(name, place)
    if pick.name:
        # A bolt's name means its ring and its hole's wall, as this program writes them.
        found = [k for k, face in enumerate(faces) if face.name in (pick.name, pick.name + WALL)]
        if not found:
            names = sorted({face.name for face in faces if face.name})
            has = f"its faces are called {', '.join(names)}" if names else "none of its has a name"
            msg = f"no face of {path} is called {pick.name!r}: {has}; or pick by a point on it"
            raise DesignError(msg, about=about)
        return found
    assert pick.near is not None  # Pick refuses one without both
    occ = engine().occ
    point = [v / mm for v in pick.near]
    probe = occ.Vertex(occ.Pnt(*point))
    distances = [face.Distance(probe) for face in faces]
    best = int(np.argmin(distances))
    if distances[best] > 1.0:
        c = faces[best].center
        msg = (
            f"{name}: no face of {path} lies within 1 mm of "
            f"{tuple(round(v, 3) for v in point)} mm: the nearest is {distances[best]:.3g} mm "
            f"away, a face of {faces[best].mass:.4g} mm2 about ({c.x:.4g}, {c.y:.4g}, {c.z:.4g}) mm"
        )
        raise DesignError(msg, about=about)
    near = {k for k, d in enumerate(distances) if d <= distances[best] + _TIE}
    if near - {*_bore(faces, best)} - {best}:
        msg = (
            f"{name}: {len(near)} faces of {path} lie as near to "
            f"{tuple(round(v, 3) for v in point)} mm: pick by a point within one of them"
        )
        raise DesignError(msg, about=about)
    return [best]


def _about(name: str, place: int | None = None) -> str:
    """Return where a file names a pick of a bolt or a weld, one of the seat, or all of it."""
    kind, _, bolt = name.partition(" ")
    key = {SEAT: "seat", END.strip(): "welded"}.get(kind, "bolts")
    number = bolt or ("" if place is None else str(place + 1))
    return f"bracket.step.{key}[{number}]" if number else f"bracket.step.{key}"


class _Cylinder(NamedTuple):
    """A round face: a point of its axis, the axis' direction, its radius, in mm."""

    point: npt.NDArray[np.float64]
    axis: npt.NDArray[np.float64]
    radius: float


def longest_on(face: Any, thickness: Metre) -> Metre:
    """Longest edge of an element on a face of a sheet: endless but on a wide round.

    An arc of L rises by L²/8r over its chord. Where that is much more than a tenth of the sheet,
    elements of its other side come through, turned inside out.
    """
    of = _cylinder(face)
    if of is None or of.radius < _WIDE * thickness:
        return np.inf
    return float(np.sqrt(0.8 * of.radius * thickness))


def round_off(face: Any, thickness: Metre) -> Metre:
    """Edge of the elements on a round that breaks a sheet's corner: endless on any other face."""
    of = _cylinder(face)
    return of.radius / PER_RADIUS if of and of.radius < _SMALL * thickness else np.inf


def _cylinder(face: Any) -> _Cylinder | None:
    """Return what cylinder a face is part of; None if of none.

    The kernel tells no kinds of surfaces, so a surface is a cylinder where its normals at
    four places meet in one line, at one distance from it.
    """
    try:
        at = [(u, v) for u in (0.3, 1.1, 2.3, 4.0) for v in (0.0, 1.0)]
        found = [face.surf.D1(u, v) for u, v in at]
    except Exception:  # noqa: BLE001  a surface that is not known so far out is no cylinder
        return None
    points, one, other = (np.array([[d[k].x, d[k].y, d[k].z] for d in found]) for k in range(3))
    normals = np.cross(one, other)
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    if size.min() < 1e-9:
        return None
    normals /= size
    axis = np.cross(normals[0], normals[2])
    size = np.linalg.norm(axis)
    if size < 1e-9:
        return None
    axis = axis / size
    if np.abs(normals @ axis).max() > 1e-9:
        return None
    # Two normals in the plane across meet at the axis: p0 + s n0 = p2 + t n2.
    flat = points - (points @ axis)[:, None] * axis
    s, _ = np.linalg.lstsq(np.stack([normals[0], -normals[2]], 1), flat[2] - flat[0], rcond=None)[0]
    centre = flat[0] + s * normals[0]
    radii = np.linalg.norm(flat - centre, axis=1)
    if np.ptp(radii) > 1e-6 * radii.max() or radii.min() < 1e-6:
        return None
    edges = np.array([[e.start.x, e.start.y, e.start.z] for e in face.edges])
    off = edges - centre - ((edges - centre) @ axis)[:, None] * axis
    if np.abs(np.linalg.norm(off, axis=1) - radii[0]).max() > 1e-3 * radii[0]:
        return None
    return _Cylinder(centre, axis, float(radii[0]))


def _outside(body: Any, face: Any, of: _Cylinder) -> bool:
    """Whether a body lies within a round face of it, on the side of the axis: no hole's does."""
    middle = np.array([face.center.x, face.center.y, face.center.z])
    foot = of.point + ((middle - of.point) @ of.axis) * of.axis
    out = middle - foot
    if np.linalg.norm(out) < 1e-3 * of.radius:  # a whole turn: any side will do
        out = np.cross(of.axis, np.eye(3)[np.abs(of.axis).argmin()])
    within = foot + (of.radius - 0.05) * out / np.linalg.norm(out)
    occ = engine().occ
    return bool(body.Distance(occ.Vertex(occ.Pnt(*map(float, within)))) < 1e-6)


def _bore(faces: list[Any], picked: int) -> Iterable[int]:
    """Yield the faces that make one bore with a picked one: coaxial, as wide, and meeting."""
    first = _cylinder(faces[picked])
    if first is None:
        return
    row = [picked]
    left = set(range(len(faces))) - {picked}
    while row:
        here = row.pop()
        yield here
        for k in sorted(left):
            other = _cylinder(faces[k])
            if other is None or abs(other.radius - first.radius) > 1e-3:
                continue
            if abs(abs(other.axis @ first.axis) - 1) > 1e-6:
                continue
            apart = other.point - first.point
            apart = apart - (apart @ first.axis) * first.axis
            if np.linalg.norm(apart) < 1e-3 and faces[k].Distance(faces[here]) < 1e-3:
                left.discard(k)
                row.append(k)


def _centred(faces: list[Any], bore: _Cylinder | None, part: StepShape) -> None:
    """Refuse a centre that is not the seat's: a wrong one makes a moment of every force."""
    centre = np.array(part.centre) / mm
    if bore is not None:
        if abs(bore.axis[0]) < _ALONG:
            axis = ", ".join(f"{round(float(v), 3) + 0.0:g}" for v in bore.axis)
            msg = (
                f"the bore picked of {part.path} as the seat lies along ({axis}), and the shaft "
                "along x, rearward: turn the file's axes to the vehicle's, x rearward and z up"
            )
            raise DesignError(msg, about="bracket.step.seat")
        off = centre - bore.point
        across = float(np.linalg.norm(off - (off @ bore.axis) * bore.axis))
        if across > max(0.5, 0.02 * bore.radius):
            foot = bore.point + ((centre - bore.point) @ bore.axis) * bore.axis
            where = ", ".join(f"{v:.2f}" for v in foot)
            msg = (
                f"the bearing's centre lies {across:.3g} mm off the axis of its seat, a bore of "
                f"{bore.radius:.4g} mm radius: the nearest point of the axis is ({where}) mm"
            )
            raise DesignError(msg, about="bracket.step.centre")
        ends = np.array([[e.start.x, e.start.y, e.start.z] for f in faces for e in f.edges])
        reach, at = (ends - bore.point) @ bore.axis, off @ bore.axis
        beyond = float(max(reach.min() - at, at - reach.max()))
        if beyond > (room := _BESIDE * bore.radius):
            msg = (
                f"the bearing's centre lies {beyond:.3g} mm beyond the end of its seat, a bore of "
                f"{bore.radius:.4g} mm radius, and may lie {room:.3g} mm beyond it: a bearing as "
                "wide as that radius would not touch it"
            )
            raise DesignError(msg, about="bracket.step.centre")
    low = np.min(
        [[f.bounding_box[0].x, f.bounding_box[0].y, f.bounding_box[0].z] for f in faces], 0
    )
    high = np.max(
        [[f.bounding_box[1].x, f.bounding_box[1].y, f.bounding_box[1].z] for f in faces], 0
    )
    room = max(float((high - low).max()), 1.0)
    if np.any(centre < low - room) or np.any(centre > high + room):
        where = ", ".join(f"{a:.1f} to {b:.1f}" for a, b in zip(low, high, strict=True))
        msg = (
            f"the bearing's centre, ({', '.join(f'{v:g}' for v in centre)}) mm, is far from its "
            f"seat, which reaches from {where} mm along x, y, z"
        )
        raise DesignError(msg, about="bracket.step.centre")


def _no_bore(body: Any, left: dict[int, Any], part: StepShape) -> None:
    """Refuse a seat without a bore where faces not picked (k: face) are one about the centre."""
    centre = np.array(part.centre) / mm
    for face in left.values():
        bore = _cylinder(face)
        if bore is None or _outside(body, face, bore):
            continue
        off = centre - bore.point
        across = float(np.linalg.norm(off - (off @ bore.axis) * bore.axis))
        if across <= max(0.5, 0.02 * bore.radius):
            msg = (
                f"the seat picked of {part.path} has no round, and a bore of {bore.radius:.4g} mm "
                "radius about the bearing's centre is not picked: is that the seat?"
            )
            raise DesignError(msg, about="bracket.step.seat")


def _as_thick(body: Any, faces: list[Any], long: Sequence[float], part: StepShape) -> None:
    """Refuse a thickness that is not the solid's: another unit's, or a slip.

    It sets the mesh, and how near a border stress is read. Walls are about as thick as the volume
    over half the surface, or as its bolts' holes are `long`.
    """
    told, mean = part.thickness / mm, 2 * body.mass / sum(face.mass for face in faces)
    if not min(mean, *long, mean) / _AS_THICK < told < _AS_THICK * max(mean, *long, mean):
        low, high = body.bounding_box
        size = " x ".join(f"{getattr(high, a) - getattr(low, a):.4g}" for a in "xyz")
        msg = (
            f"walls of {told:g} mm are not those of {part.path}: it measures {size} mm, its volume "
            f"over half its surface is {mean:.3g} mm, and through its bolts' holes it is "
            f"{max(long, default=mean):.3g} mm thick; is its unit another?"
        )
        raise DesignError(msg, about="bracket.step.thickness")


def _length(wall: Any, bore: _Cylinder | None) -> float:
    """Return how long a bore is by a face of it, mm."""
    assert bore is not None
    along = [
        float(np.dot((p.x, p.y, p.z), bore.axis)) for e in wall.edges for p in (e.start, e.end)
    ]
    return max(along) - min(along)


def _all_round(bore: _Cylinder, walls: list[Any], part: StepShape, name: str) -> None:
    """Refuse for a bolt what is round by a part of a turn alone, such as a slot's end."""
    long = max(_length(wall, bore) for wall in walls)
    goes = sum(wall.mass for wall in walls) / (2 * np.pi * bore.radius * long)
    if goes < _ROUND:
        msg = (
            f"{name}: what is picked of {part.path} goes round its axis by {360 * goes:.0f} "
            "degrees: of a slot nobody knows where its bolt sits, draw a round hole there"
        )
        raise DesignError(msg, about=_about(name))


def _along_an_axis(bore: _Cylinder, part: StepShape, name: str, before: Sequence[int]) -> int:
    """Return the axis a bolt lies along; refuse one askew, or along another than those before.

    Its washer's plane would be found nowhere, and its hole's wall alone would hold the bracket.
    """
    along = np.abs(bore.axis)
    axis = int(along.argmax())
    direction = ", ".join(f"{round(float(v), 4) + 0.0:g}" for v in bore.axis)
    if np.sort(along)[1] > _ASKEW:
        msg = (
            f"{name}: its hole in {part.path} lies along ({direction}), and a flange is held along "
            "x, y or z: turn the file so that its bolts lie along one of these"
        )
        raise DesignError(msg, about=_about(name))
    if before and axis != before[0]:
        msg = (
            f"{name}: its hole in {part.path} lies along {'xyz'[axis]}, and that of a bolt before "
            f"it along {'xyz'[before[0]]}: all bolts of a bracket are held along one axis"
        )
        raise DesignError(msg, about=_about(name))
    return axis


def _round_its_hole(body: Any, faces: list[Any], picked: int, part: StepShape, name: str) -> None:
    """Refuse a flat face for a bolt that is no ring or pad about the hole of one."""
    face = faces[picked]
    low, high = face.bounding_box
    low, high = (np.array([p.x, p.y, p.z]) for p in (low, high))
    holes = [
        c for k, other in enumerate(faces)
        if k != picked and face.Distance(other) < 1e-3 and (c := _cylinder(other))
        and np.abs((high - low) @ np.abs(c.axis)) < 1e-2 and not _outside(body, other, c)
    ]  # fmt: skip
    far = [
        float((np.abs(np.stack([low, high]) - c.point) * (1 - np.abs(c.axis))).max()) / c.radius
        for c in holes
    ]  # fmt: skip
    if holes and max(far) <= _PAD:
        return
    size = " x ".join(f"{v:.4g}" for v in high - low if v > 1e-2)
    has = f"with a hole of {2 * holes[0].radius:.4g} mm" if holes else "without a hole"
    msg = (
        f"{name}: a flat face picked of {part.path}, {size} mm {has}, is no bolt's: pick the "
        "wall of its hole, or a ring or pad about one hole; a face welded to the frame is `welded`"
    )
    raise DesignError(msg, about=_about(name))


def _ring(body: Any, bore: _Cylinder, part: StepShape) -> Any:
    """Return the ring a bolt's washer presses against the frame; None where no plane lies there.

    Of the two planes a hole ends in, the frame's is the one farther from the bearing.
    """
    occ = engine().occ
    centre = np.array(part.centre) / mm
    ends: list[float] = []
    for face in body.faces:
        low, high = face.bounding_box
        c = np.array([face.center.x, face.center.y, face.center.z])
        reach = np.array([high.x - low.x, high.y - low.y, high.z - low.z])
        at = float((c - bore.point) @ bore.axis)
        probe = bore.point + at * bore.axis
        flat = float(reach @ np.abs(bore.axis)) < 1e-3
        if flat and face.Distance(occ.Vertex(occ.Pnt(*probe))) < 1.001 * bore.radius:
            ends.append(at)
    if not ends:
        return None
    at = max(ends, key=lambda s: abs(s - float((centre - bore.point) @ bore.axis)))
    middle = bore.point + at * bore.axis
    aside = np.eye(3)[np.abs(bore.axis).argmin()]
    across = np.cross(bore.axis, aside)
    plane = occ.WorkPlane(occ.Axes(tuple(middle), occ.Dir(*bore.axis), occ.Dir(*across)))
    disc = plane.Circle(WASHER * bore.radius).Face()
    start = middle - bore.axis
    hole = occ.Cylinder(occ.Pnt(*start), occ.Dir(*bore.axis), r=bore.radius, h=2)
    return (disc - hole) * body


def _name_plane(body: Any, rings: list[tuple[str, Any]]) -> None:
    """Name the rings, and what is left of the planes they lie in: the mount."""

    def box(shape: Any) -> npt.NDArray[np.float64]:
        return np.array([[p.x, p.y, p.z] for p in shape.bounding_box])

    for name, ring in rings:
        low, high = box(ring)
        axis = int((high - low).argmin())
        for face in body.faces:
            a, b = box(face)
            if face.name != FREE or max(abs(a[axis] - low[axis]), abs(b[axis] - low[axis])) > 0.01:
                continue
            inside = np.all(a > low - 0.01) and np.all(b < high + 0.01)
            face.name = name if inside else MOUNT
    for name, ring in rings:  # one ring's plane was called the mount before its own turn came
        low, high = box(ring)
        for face in body.faces:
            a, b = box(face)
            if face.name == MOUNT and np.all(a > low - 0.01) and np.all(b < high + 0.01):
                face.name = name


def _finished(body: Any, thickness: Metre, *, bolts: int) -> Solid:
    """Scale to metres and make sure of one sound solid with all its faces."""
    occ = engine().occ
    solids = list(body.solids)
    if len(solids) != 1 or not solids[0].mass > 0:
        msg = f"a bracket must be one solid, this shape has {len(solids)}: its parts do not meet"
        raise DesignError(msg, about="bracket")
    shape = solids[0].Scale(occ.Pnt(0, 0, 0), mm)
    held = tuple(f"bolt {k}" for k in range(1, bolts + 1))
    names = {face.name for face in shape.faces}
    missing = [name for name in (SEAT, *held) if name not in names]
    if missing:
        msg = f"the shape has lost its {', '.join(missing)}: sizes overlap there"
        raise DesignError(msg, about="bracket")
    return Solid(shape=shape, bolts=held, thickness=thickness, volume=float(shape.mass))
