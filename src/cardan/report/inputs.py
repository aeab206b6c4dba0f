"""What an application says, as rows of name and value: for reports and for comparing.

What is known best by a word of its own, or follows from several entries, has a row written for
it; every other entry of the file stands there by its address.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cardan.base.part import Part
from cardan.base.units import N, deg, kg, kN, mm, rpm
from cardan.base.verdict import Limit
from cardan.files.entered import Entered, entered
from cardan.model.application import Application, Installed, State
from cardan.model.laminate import CompositeTube
from cardan.model.parts import JointSize, Shaft
from cardan.model.vehicle import LoadState, Suspension
from cardan.quantity.quantities import QUANTITIES
from cardan.report.language import Language

_SIZES = ("outer", "wall", "material", "material.name", "layup.ply", "layup.angle", "layup.times")
_BEARING = (
    "from_rear_joint", "stiffness", "vertical_stiffness", "lateral_stiffness", "axial_stiffness",
    "loss_factor", "travel", "bracket.stiffness", "bracket.loss_factor",
)  # fmt: skip
_SUSPENSION = (
    "spring.load", "spring.deflection", "spring.rates", "spring.contact", "springs_per_axle",
    "unsprung_mass", "linkage.radius", "linkage.front_half_length", "linkage.angle",
    "linkage.pitch_rate", "linkage.travel", "windup_stiffness", "brake_torque", "reference",
    "full_rebound_deflection", "jounce_deflection", "squat",
)  # fmt: skip
_LIMIT = ("quantity", "normal", "maximum", "sense", "band")
_IN_WORDS: dict[str, tuple[str, ...]] = {
    "": (
        "torque", "coast_torque", "speed", "shock_factor", "prime_mover", "include", "duty",
        "states", "limits",
    ),
    "vehicle": ("drive", "wheelbase", "driven_share", "grade", "grade_percent"),
    "vehicle.loads.*": ("mass", "cg_behind_front", "cg_height", "front_axle", "rear_axle"),
    "vehicle.auxiliary": ("behind_front", "load"),
    "tyre": ("static_radius", "friction"),
    "engine": ("speed", "torque", "brake_torque"),
    "gearbox": (
        "ratios", "efficiency", "converter_ratio", "transfer_ratio", "reverse_ratio",
        "retarder_torque",
    ),
    "suspension": _SUSPENSION,
    "torsion": (
        "axle_inertia", "axle_stiffness", "gearbox_inertia", "gearbox_stiffness", "damping_ratio",
    ),
    "axle": ("ratio", "efficiency"),
    "driveline": (
        "slopes.side", "slopes.top", "joint_angles.side", "joint_angles.top",
        "gearbox_slope.side", "gearbox_slope.top", "pinion_slope.side", "pinion_slope.top",
        "axle.ratio", "axle.efficiency", "runs", "torque_share",
        "joints", "joints.name", "joints.kind",
    ),
    "driveline.shafts": (
        "length", "phase", "tube", "spline.plunge", "spline.draw", "yoke_mass", "balance_grade",
    ),
    "driveline.shafts.tube": _SIZES,
    "driveline.shafts.centre_bearing": _BEARING,
    "states": ("name", "load", "travel", "pitch", "torque", "speed"),
    "obstacles": ("name", "start", "end", "radius", "diameter", "travel_share"),
    "duty": ("share", "torque", "speed", "angle"),
    "limits": ("profile", *_LIMIT),
    "limits.overrides": _LIMIT,
}  # fmt: skip
"""Entries, by the tables they stand in, that a row below says in words of its own."""
SAID = frozenset(
    f"{table}.{name}" if table else name for table, names in _IN_WORDS.items() for name in names
)


@dataclass(frozen=True, kw_only=True)
class Input:
    """One thing given: in which group it stands, what it is called, what it says."""

    group: str
    name: str
    value: str


def inputs(of: Application, say: Language) -> tuple[Input, ...]:
    """Return everything an application says, without what it leaves out."""
    torsion = ("torsion", "clutch", "dual_mass_flywheel", "converter", "inter_axle", "launch")
    groups: list[tuple[str, tuple[str, ...], Iterator[tuple[str, str]]]] = [
        (say("Application"), (), _general(of, say)),
        (say("Vehicle"), ("vehicle", "axle", "tyre", "wheels"), _vehicle(of, say)),
        (say("Engine and gearbox"), ("engine", "gearbox"), _engine(of, say)),
        (say("Suspension"), ("suspension",), _suspension(of.suspension, say)),
        (say("Torsion"), torsion, _torsion(of, say)),
    ]
    for k, one in enumerate(of.lines):
        tables = (f"driveline {one.line.name}", *(() if k else ("driveline",)))
        groups.append((say("Line {line}", line=one.line.name), tables, _line(one, say)))
    groups += [
        (say("States"), ("states",), _states(of, say)),
        (say("Obstacles"), ("obstacles",), _obstacles(of, say)),
        (say("Limits"), ("limits",), _limits(of, say)),
    ]
    captions = {table: caption for caption, tables, _ in groups for table in tables}
    found = {caption: list(rows) for caption, _, rows in groups}
    for one in entered(of):
        if one.path not in SAID:
            table = f"{one.path.partition('.')[0]} {one.line}".strip()
            found[captions.get(table, say("Application"))].append(_entry(one, of, say))
    return tuple(
        Input(group=group, name=name, value=value)
        for group, rows in found.items()
        for name, value in rows
        if value
    )


def _entry(one: Entered, of: Application, say: Language) -> tuple[str, str]:
    """Return an entry of the file by its address, which is its name in every language."""
    written = of.written
    numbers = {**written.numbers, **written.single} if written else {}
    values = (say.pointed(said) if at in numbers else said for at, said in one.values)
    return one.at, ("; " if say.code != "en" else ", ").join(values)


def _q(value: float | None, unit: float, name: str, say: Language) -> str:
    """Return a value in a unit; empty where it is not given."""
    return "" if value is None else f"{say.short(value / unit)} {name}".rstrip()


def _each(values: object, unit: float, name: str, say: Language) -> str:
    """Return a list of values in a unit."""
    array = np.ravel(np.asarray(values, dtype=float)) / unit
    apart = "; " if say.code != "en" else ", "
    return f"{apart.join(say.short(v, 5) for v in array)} {name}".rstrip() if array.size else ""


def _general(a: Application, say: Language) -> Iterator[tuple[str, str]]:
    yield say("limit profile"), a.profile
    yield say("shaft torque"), _q(a.torque, 1, "N·m", say)
    yield say("coast torque"), _q(a.coast_torque, 1, "N·m", say)
    yield say("shaft speed"), _q(a.speed, rpm, "rpm", say)
    yield say("shock factor"), say.short(a.shock_factor)
    yield say("prime mover factor"), say.short(a.prime_mover_factor)
    both = (("gravity", a.include_gravity), ("unbalance", a.include_unbalance))
    yield say("loads include"), say.list(*(say(name) for name, on in both if on))
    if a.duty_cycle:
        yield say("duty cycle"), f"{a.duty_cycle.name} ({say.source(str(a.duty_cycle.source))})"
    for k, p in enumerate(a.duty, 1):
        said = say.list(
            f"{say.short(100 * p.share)} %",
            _q(p.torque, 1, "N·m", say),
            _q(p.speed, rpm, "rpm", say),
            _q(p.angle, deg, "deg", say),
        )
        yield say("duty point {number}", number=k), said


def _torsion(a: Application, say: Language) -> Iterator[tuple[str, str]]:
    if a.torsion is not None:
        s = a.torsion
        yield say("axle inertia"), _q(s.axle_inertia, 1, "kg·m²", say)
        yield say("axle torsional stiffness"), _q(s.axle_stiffness, 1, "N·m/rad", say)
        yield say("gearbox inertia"), _q(s.gearbox_inertia, 1, "kg·m²", say)
        yield say("gearbox torsional stiffness"), _q(s.gearbox_stiffness, 1, "N·m/rad", say)
        yield say("damping ratio of the first mode"), _q(s.damping_ratio, 1, "", say)


def _vehicle(a: Application, say: Language) -> Iterator[tuple[str, str]]:
    v, t = a.vehicle, a.tyre
    if v:
        yield say("drive"), v.drive
        yield say("wheelbase"), _q(v.wheelbase, mm, "mm", say)
        yield say("share of the rear load that is driven"), _q(v.driven_share, 0.01, "%", say)
        yield say("grade"), _q(v.grade, deg, "deg", say)
        for load in v.loads:
            yield say("load {name}", name=say.state(load.name)), _load(load, say)
        for k, axle in enumerate(v.auxiliary, 1):
            said = say.list(_q(axle.load, kN, "kN", say), _q(axle.behind_front, mm, "mm", say))
            yield say("auxiliary axle {number}", number=k), said
    if t:
        yield say("tyre, static radius"), _q(t.static_radius, mm, "mm", say)
        yield say("tyre, friction"), say.short(t.friction)


def _load(load: LoadState, say: Language) -> str:
    rows = (
        ("mass", load.mass, kg, "kg"),
        ("front axles", load.front_load, kN, "kN"),
        ("rear axles", load.rear_load, kN, "kN"),
        ("centre of gravity behind the front axle", load.cg_behind_front, mm, "mm"),
        ("height of the centre of gravity", load.cg_height, mm, "mm"),
    )
    return "; ".join(f"{say(n)} {_q(v, u, w, say)}" for n, v, u, w in rows if v is not None)


def _engine(a: Application, say: Language) -> Iterator[tuple[str, str]]:
    e, g = a.engine, a.gearbox
    if e:
        yield say("engine speed"), _each(e.speed, rpm, "rpm", say)
        yield say("engine torque"), _each(e.torque, 1, "N·m", say)
        yield say("engine brake torque"), _q(e.brake_torque or None, 1, "N·m", say)
    if g:
        yield say("gear ratios"), _each(g.ratios, 1, "", say)
        yield say("gearbox efficiency"), say.short(g.efficiency)
        yield say("converter torque ratio"), say.short(g.converter_ratio)
        yield say("transfer case, low range"), say.short(g.transfer_ratio)
        yield say("reverse ratio"), _q(g.reverse_ratio, 1, "", say)
        yield say("retarder torque"), _q(g.retarder_torque, 1, "N·m", say)


def _suspension(s: Suspension | None, say: Language) -> Iterator[tuple[str, str]]:
    if s is None:
        return
    yield say("spring load"), _each(s.spring.load, N, "N", say)
    yield say("spring deflection"), _each(s.spring.deflection, mm, "mm", say)
    yield say("springs per axle"), str(s.springs_per_axle)
    yield say("unsprung mass"), _q(s.unsprung_mass, kg, "kg", say)
    yield say("equivalent link radius"), _q(s.linkage.radius, mm, "mm", say)
    yield say("link angle"), _q(s.linkage.angle, deg, "deg", say)
    yield say("pitch rate"), _q(s.linkage.pitch_rate or None, deg / mm, "deg/mm", say)
    yield say("linkage table, travel"), _each(s.linkage.travel, mm, "mm", say)
    yield say("wind-up stiffness"), _q(s.windup_stiffness, 1e3 / deg, "kN·m/deg", say)
    yield say("brake torque on the axle"), _q(s.brake_torque or None, 1, "N·m", say)
    yield say("reference state"), say.state(s.reference)
    yield say("deflection at full rebound"), _q(s.full_rebound_deflection, mm, "mm", say)
    yield say("deflection at jounce"), _q(s.jounce_deflection, mm, "mm", say)
    if not s.squats:
        yield say("squat"), say("left out")


def _line(of: Installed, say: Language) -> Iterator[tuple[str, str]]:
    line, layout = of.line, of.layout
    if of.forward:
        yield say("the line runs"), say("forward")
    if of.axle:
        yield say("axle ratio"), say.short(of.axle.ratio)
        yield say("axle efficiency"), say.short(of.axle.efficiency)
    if (share := of.torque_ratio * of.torque_share) != 1:
        yield say("share of the torque"), say.short(share)
    yield say("side slopes of the members"), _each(layout.side, deg, "deg", say)
    yield say("top slopes of the members"), _each(layout.top, deg, "deg", say)
    joints = [_size(j, say) for j in line.joints]
    yield say("joints"), joints[0] if len(set(joints)) == 1 else say.list(*joints)
    for k, shaft in enumerate(line.shafts):
        part = say.part(Part("shaft", k + 1))
        for name, value in _shaft(shaft, float(layout.lengths[k]), say):
            yield f"{part}, {name}", value


def _size(joint: JointSize | None, say: Language) -> str:
    """Return a joint by its name, and by its kind if it is no cross."""
    if joint is None:
        return "-"
    words = {
        "cross": "", "double cardan": say("double cardan"), "rzeppa": say("Rzeppa joint"),
        "tripod": say("tripod joint"),
    }  # fmt: skip
    kind = words[joint.kind]
    return f"{joint.name} ({kind})" if kind else joint.name


def _shaft(s: Shaft, length: float, say: Language) -> Iterator[tuple[str, str]]:
    yield say("length"), _q(length, mm, "mm", say)
    if s.tube:
        size = f"{say.short(s.tube.outer / mm)} × {say.short(s.tube.wall / mm)} mm"
        yield say("tube"), say.list(size, s.tube.material.name)
        if isinstance(s.tube, CompositeTube):
            yield say("plies, from the inside out"), s.tube.layup
    yield say("yoke phase"), _q(s.phase, deg, "deg", say)
    b = s.centre_bearing
    if b:
        yield say("centre bearing ahead of the rear joint"), _q(b.from_rear_joint, mm, "mm", say)
        if b.stiffness:
            yield (
                say("bearing stiffness, vertical and lateral"),
                _each(b.stiffness, 1 / mm, "N/mm", say),
            )
        yield say("bearing stiffness along the shaft"), _q(b.axial_stiffness, 1 / mm, "N/mm", say)
        yield say("loss factor of the bearing's rubber"), _q(b.loss_factor, 1, "", say)
        if b.travel is not None:
            yield say("travel of the bearing's rubber to its stop"), _q(b.travel, mm, "mm", say)
        if b.bracket_stiffness:
            yield (
                say("bracket stiffness along the shaft, across and up"),
                _each(b.bracket_stiffness, 1 / mm, "N/mm", say),
            )
            yield say("loss factor of the bracket"), _q(b.bracket_loss, 1, "", say)
    if s.spline:
        yield say("spline plunge"), _q(s.spline.plunge, mm, "mm", say)
        yield say("spline draw"), _q(s.spline.draw, mm, "mm", say)
    yield (
        say("yoke masses, front and rear"),
        _each(s.yoke_mass, kg, "kg", say) if any(s.yoke_mass) else "",
    )
    yield say("balance grade"), f"G{say.short(s.balance_grade)}" if s.balance_grade else ""


def _states(a: Application, say: Language) -> Iterator[tuple[str, str]]:
    for s in a.states:
        yield say.state(s.name), _state(s, say) or say("as given")


def _state(s: State, say: Language) -> str:
    rows = (
        ("axle travel", s.travel, mm, "mm"),
        ("pinion pitch", s.pitch, deg, "deg"),
        ("torque", s.torque, 1.0, "N·m"),
        ("speed", s.speed, rpm, "rpm"),
    )
    said = [f"{say(n)} {_q(v, u, w, say)}" for n, v, u, w in rows if v is not None]
    placed = [say("placed by the suspension")] if s.kind else []
    own = [say("own geometry")] if s.layouts else []
    load = [say("load {name}", name=say.state(s.load))] if s.load else []
    return "; ".join([*placed, *load, *said, *own])


def _obstacles(a: Application, say: Language) -> Iterator[tuple[str, str]]:
    for o in a.obstacles:
        ends = " → ".join(f"({'; '.join(say.short(v / mm) for v in p)})" for p in (o.start, o.end))
        said = f"{ends} mm, {say('radius')} {say.short(o.radius / mm)} mm"
        share = f", {say('share of the axle travel')} {say.short(o.travel_share)}"
        yield o.name, said + (share if o.travel_share else "")


def _limits(a: Application, say: Language) -> Iterator[tuple[str, str]]:
    for limit in a.limits:
        yield say.name(limit.quantity), _limit(limit, say)


def _limit(limit: Limit, say: Language) -> str:
    q = QUANTITIES[limit.quantity]
    sense = {"<=": "≤", ">=": "≥"}[limit.sense]
    shown = [
        f"{say(name)} {sense} {say.short(bound / q.factor)}"
        for name, bound in (("normal", limit.normal), ("maximum", limit.maximum))
        if bound is not None
    ]
    if limit.band:
        low, high = (say.short(b / q.factor) for b in limit.band)
        shown.append(say("outside {low} … {high}", low=low, high=high))
    return f"{'; '.join(shown)} {q.unit_name}".rstrip()
