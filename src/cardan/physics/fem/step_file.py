"""A bracket from a STEP file: its solid, the faces the user picked, and checks of both."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt

from cardan.core.errors import DesignError
from cardan.core.units import mm
from cardan.model.bracket import FaceSelector, StepFileShape
from cardan.physics.fem.bracket_solid import (
    HOLE_WALL_NAME_SUFFIX,
    MOUNT_FACE_NAME,
    SEAT_FACE_NAME,
    UNASSIGNED_FACE_NAME,
    WASHER_DIAMETER_RATIO,
    WELDED_END_NAME_PREFIX,
    BracketSolid,
    FaceSelection,
    finish_solid,
)
from cardan.physics.fem.ngsolve_import import import_ngsolve
from cardan.physics.fem.round_faces import (
    Cylinder,
    bore_faces,
    cylinder_of_face,
    is_outside_of_round,
)
from cardan.physics.fem.step_structure import StepStructure, names_of_solids

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


def solid_from_step(part: StepFileShape) -> BracketSolid:
    """Read a STEP file and find the faces the user picked."""
    occ = import_ngsolve().occ
    if not Path(part.path).is_file():
        msg = f"no STEP file at {part.path}"
        raise DesignError(msg, about="bracket.step")
    structure = StepStructure(Path(part.path).read_text("latin-1"))
    solids = _solids(structure, part.path)
    body, names = _chosen(solids, names_of_solids(structure, solids), part)
    faces = list(body.faces)
    wanted = [
        (SEAT_FACE_NAME, part.seat),
        *((f"bolt {k}", (p,)) for k, p in enumerate(part.bolts, 1)),
        *((f"{WELDED_END_NAME_PREFIX}{k}", (p,)) for k, p in enumerate(part.welded, 1)),
    ]
    taken: dict[int, str] = {}
    found: list[FaceSelection] = []
    rings: list[tuple[str, Any]] = []
    imprints: list[Any] = []
    long: list[float] = []
    upright: list[int] = []
    round_: set[int] = set()
    seat: tuple[list[Any], Cylinder | None] = [], None
    for name, picks in wanted:
        mine = {
            k
            for n, pick in enumerate(picks)
            for k in _picked(faces, names, pick, part.path, name, n)
        }
        mine |= {other for k in mine for other in bore_faces(faces, k)}
        for k in mine:
            if taken.get(k, name) != name:
                msg = f"the same face of {part.path} is picked as {taken[k]} and as {name}"
                raise DesignError(msg, about="bracket.step")
            taken[k] = name
        walls = {k: c for k in sorted(mine) if (c := cylinder_of_face(faces[k]))}
        if outside := [c for k, c in walls.items() if is_outside_of_round(body, faces[k], c)]:
            msg = (
                f"{name}: a face picked of {part.path} is the outside of a round of "
                f"{outside[0].radius:.4g} mm radius: pick its inside"
            )
            raise DesignError(msg, about=_about(name))
        bore = next(iter(walls.values()), None)
        area = sum(faces[k].mass for k in mine) * mm**2
        found.append(
            FaceSelection(name=name, face_count=len(mine), area=float(area))
            if bore is None
            else FaceSelection(
                name=name, face_count=len(mine), area=float(area), radius=bore.radius * mm,
                axis=(float(bore.axis[0]), float(bore.axis[1]), float(bore.axis[2])),
            )
        )  # fmt: skip
        if name == SEAT_FACE_NAME:
            seat = [faces[k] for k in mine], bore
            continue
        if name.startswith(WELDED_END_NAME_PREFIX):
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
        face.name = taken.get(k, UNASSIGNED_FACE_NAME) + (
            HOLE_WALL_NAME_SUFFIX if k in round_ else ""
        )
    if imprints:
        body = occ.Glue([body, *imprints])
    _name_plane(body, rings)
    x, y, z = (-v / mm for v in part.centre)
    made = finish_solid(body.Move(occ.Vec(x, y, z)), part.thickness, bolts=len(part.bolts))
    return replace(made, face_selections=tuple(found))


def _solids(structure: StepStructure, path: str) -> list[Any]:
    """Return the solids of all roots of a file; the kernel reads the first root alone."""
    occ = import_ngsolve().occ
    try:
        if not (roots := structure.root_texts()):
            return list(occ.OCCGeometry(path).shape.solids)
        found: list[Any] = []
        with TemporaryDirectory(prefix="cardan-step-") as folder:
            for k, text in enumerate(roots):
                one = Path(folder) / f"root{k}.step"
                one.write_text(text, "latin-1")
                found += occ.OCCGeometry(str(one)).shape.solids
        return found
    except Exception as error:  # the kernel raises bare exceptions of its own
        msg = f"{path} is not a STEP file the CAD kernel can read ({error})"
        raise DesignError(msg, about="bracket.step") from error


def _chosen(
    solids: list[Any], names: list[tuple[str, str, tuple[str, ...]]], part: StepFileShape
) -> tuple[Any, list[str]]:
    """Return the solid that is meant, and its faces' names.

    It is the only one, or the one of its name, its product's or its place.
    """
    products = [product for _, product, _ in names]
    called = [
        one.name or own or (product if products.count(product) == 1 else "")
        for one, (own, product, _) in zip(solids, names, strict=True)
    ]
    unnamed = (f"one of {p}" if p else "no name" for p in products)
    told = ", ".join(
        f"{name or f'{k} ({how})'} of {one.mass / 1000:.4g} cm3"
        for k, (one, name, how) in enumerate(zip(solids, called, unnamed, strict=True), 1)
    )
    if not solids:
        msg = f"{part.path} has no solid, surfaces at most: export the bracket as a solid"
        raise DesignError(msg, about="bracket.step.file")
    place = 0
    if part.solid:
        named = (
            [k for k, name in enumerate(called) if name == part.solid]
            or [k for k, product in enumerate(products) if product == part.solid]
            or [k for k, name in enumerate(called) if not name and f"{k + 1}" == part.solid]
        )
        if len(named) != 1:
            if named:
                msg = f"{len(named)} solids of {part.path} are called {part.solid!r}: it has {told}"
            else:
                msg = f"no solid of {part.path} is called {part.solid!r}: it has {told}"
            raise DesignError(msg, about="bracket.step.solid")
        place = named[0]
    elif len(solids) > 1:
        msg = (
            f"{part.path} has {len(solids)} solids, {told}: say which by `solid`, its name or, if "
            "it has none, its number"
        )
        raise DesignError(msg, about="bracket.step")
    written = names[place][2]
    faces = solids[place].faces
    return solids[place], [face.name or said for face, said in zip(faces, written, strict=True)]


def _picked(
    faces: list[Any],
    names: list[str],
    pick: FaceSelector,
    path: str,
    name: str,
    place: int,
) -> Iterable[int]:
    """Places of the faces a pick means."""
    about = _about(name, place)
    if pick.name:
        # A bolt's name means its ring and its hole's wall, as this program writes them.
        found = [
            k
            for k, called in enumerate(names)
            if called in (pick.name, pick.name + HOLE_WALL_NAME_SUFFIX)
        ]
        if not found:
            there = sorted({*names} - {""})
            has = f"its faces are called {', '.join(there)}" if there else "none of its has a name"
            msg = f"no face of {path} is called {pick.name!r}: {has}; or pick by a point on it"
            raise DesignError(msg, about=about)
        return found
    assert pick.near is not None  # Pick refuses one without both
    occ = import_ngsolve().occ
    point = [v / mm for v in pick.near]
    probe = occ.Vertex(occ.Pnt(*point))
    distances = [face.Distance(probe) for face in faces]
    best = int(np.argmin(distances))
    if distances[best] > 1.0:
        c = faces[best].center
        msg = (
            f"{name}: no face of {path} lies within 1 mm of "
            f"{tuple(round(v, 3) for v in point)} mm: the nearest is {distances[best]:.3g} mm "
            f"away, a face of {faces[best].mass:.4g} mm2 about ({c.x:.4g}, {c.y:.4g}, {c.z:.4g}) "
            f"mm, and all of them measure {_size_of(faces)} mm"
        )
        raise DesignError(msg, about=about)
    near = {k for k, d in enumerate(distances) if d <= distances[best] + _TIE}
    if near - {*bore_faces(faces, best)} - {best}:
        msg = (
            f"{name}: {len(near)} faces of {path} lie as near to "
            f"{tuple(round(v, 3) for v in point)} mm: pick by a point within one of them"
        )
        raise DesignError(msg, about=about)
    return [best]


def _size_of(faces: Sequence[Any]) -> str:
    """Return the size of the box about faces, `130 x 120 x 8`: it shows a file of another unit."""
    corners = np.array([[(p.x, p.y, p.z) for p in face.bounding_box] for face in faces])
    return " x ".join(f"{v:.4g}" for v in np.ptp(corners.reshape(-1, 3), axis=0))


def _about(name: str, place: int | None = None) -> str:
    """Return where a file names a pick of a bolt or a weld, one of the seat, or all of it."""
    kind, _, bolt = name.partition(" ")
    key = {SEAT_FACE_NAME: "seat", WELDED_END_NAME_PREFIX.strip(): "welded"}.get(kind, "bolts")
    number = bolt or ("" if place is None else str(place + 1))
    return f"bracket.step.{key}[{number}]" if number else f"bracket.step.{key}"


def _centred(faces: list[Any], bore: Cylinder | None, part: StepFileShape) -> None:
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


def _no_bore(body: Any, left: dict[int, Any], part: StepFileShape) -> None:
    """Refuse a seat without a bore where faces not picked (k: face) are one about the centre."""
    centre = np.array(part.centre) / mm
    for face in left.values():
        bore = cylinder_of_face(face)
        if bore is None or is_outside_of_round(body, face, bore):
            continue
        off = centre - bore.point
        across = float(np.linalg.norm(off - (off @ bore.axis) * bore.axis))
        if across <= max(0.5, 0.02 * bore.radius):
            msg = (
                f"the seat picked of {part.path} has no round, and a bore of {bore.radius:.4g} mm "
                "radius about the bearing's centre is not picked: is that the seat?"
            )
            raise DesignError(msg, about="bracket.step.seat")


def _as_thick(body: Any, faces: list[Any], long: Sequence[float], part: StepFileShape) -> None:
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


def _length(wall: Any, bore: Cylinder | None) -> float:
    """Return how long a bore is by a face of it, mm."""
    assert bore is not None
    along = [
        float(np.dot((p.x, p.y, p.z), bore.axis)) for e in wall.edges for p in (e.start, e.end)
    ]
    return max(along) - min(along)


def _all_round(bore: Cylinder, walls: list[Any], part: StepFileShape, name: str) -> None:
    """Refuse for a bolt what is round by a part of a turn alone, such as a slot's end."""
    long = max(_length(wall, bore) for wall in walls)
    goes = sum(wall.mass for wall in walls) / (2 * np.pi * bore.radius * long)
    if goes < _ROUND:
        msg = (
            f"{name}: what is picked of {part.path} goes round its axis by {360 * goes:.0f} "
            "degrees: where a bolt sits in a slot is unknown, draw a round hole there"
        )
        raise DesignError(msg, about=_about(name))


def _along_an_axis(bore: Cylinder, part: StepFileShape, name: str, before: Sequence[int]) -> int:
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


def _round_its_hole(
    body: Any, faces: list[Any], picked: int, part: StepFileShape, name: str
) -> None:
    """Refuse a flat face for a bolt that is no ring or pad about the hole of one."""
    face = faces[picked]
    low, high = face.bounding_box
    low, high = (np.array([p.x, p.y, p.z]) for p in (low, high))
    holes = [
        c for k, other in enumerate(faces)
        if k != picked and face.Distance(other) < 1e-3 and (c := cylinder_of_face(other))
        and np.abs((high - low) @ np.abs(c.axis)) < 1e-2 and not is_outside_of_round(body, other, c)
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


def _ring(body: Any, bore: Cylinder, part: StepFileShape) -> Any:
    """Return the ring a bolt's washer presses against the frame; None where no plane lies there.

    Of the two planes a hole ends in, the frame's is the one farther from the bearing.
    """
    occ = import_ngsolve().occ
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
    disc = plane.Circle(WASHER_DIAMETER_RATIO * bore.radius).Face()
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
            if (
                face.name != UNASSIGNED_FACE_NAME
                or max(abs(a[axis] - low[axis]), abs(b[axis] - low[axis])) > 0.01
            ):
                continue
            inside = np.all(a > low - 0.01) and np.all(b < high + 0.01)
            face.name = name if inside else MOUNT_FACE_NAME
    for name, ring in rings:  # one ring's plane was called the mount before its own turn came
        low, high = box(ring)
        for face in body.faces:
            a, b = box(face)
            if face.name == MOUNT_FACE_NAME and np.all(a > low - 0.01) and np.all(b < high + 0.01):
                face.name = name
