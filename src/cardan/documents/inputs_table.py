"""What an application says, as rows of name and value: for reports and for comparing.

What is known best by a word of its own, or follows from several entries, has a row written for
it; every other entry of the file stands there by its address.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cardan.application.entries import EnteredValue, entered_values
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.labels import Part
from cardan.core.units import N, deg, kg, kN, mm, rpm
from cardan.core.verdict import Limit
from cardan.model.application import Application, InstalledLine, VehicleState
from cardan.model.laminate import CompositeTube
from cardan.model.parts import JointSize, Shaft
from cardan.model.vehicle import LoadState, Suspension
from cardan.render.i18n import Translator

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
_ENTRIES_BY_TABLE: dict[str, tuple[str, ...]] = {
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
    "states": ("name", "kind", "load", "travel", "pitch", "torque", "speed"),
    "obstacles": ("name", "start", "end", "radius", "diameter", "travel_share"),
    "duty": ("share", "torque", "speed", "angle"),
    "limits": ("profile", *_LIMIT),
    "limits.overrides": _LIMIT,
}  # fmt: skip
"""Entries, by the tables they stand in, that a row below says in words of its own."""
ENTRIES_WITH_OWN_ROW = frozenset(
    f"{table}.{name}" if table else name
    for table, names in _ENTRIES_BY_TABLE.items()
    for name in names
)


@dataclass(frozen=True, kw_only=True)
class InputRow:
    """One thing given: in which group it stands, what it is called, what it says."""

    group: str
    name: str
    value: str


def input_rows(of: Application, say: Translator) -> tuple[InputRow, ...]:
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
    for one in entered_values(of):
        if one.path not in ENTRIES_WITH_OWN_ROW:
            table = f"{one.path.partition('.')[0]} {one.line}".strip()
            found[captions.get(table, say("Application"))].append(_entry(one, of, say))
    return tuple(
        InputRow(group=group, name=name, value=value)
        for group, rows in found.items()
        for name, value in rows
        if value
    )


def _entry(one: EnteredValue, of: Application, say: Translator) -> tuple[str, str]:
    """Return an entry of the file by its address, which is its name in every language."""
    written = of.written
    numbers = {**written.numbers, **written.fixed_numbers} if written else {}
    values = (say.with_decimal_sign(said) if at in numbers else said for at, said in one.values)
    return one.address, ("; " if say.code != "en" else ", ").join(values)


def _quantity_text(value: float | None, unit: float, name: str, say: Translator) -> str:
    """Return a value in a unit; empty where it is not given."""
    return "" if value is None else f"{say.compact_number(value / unit)} {name}".rstrip()


def _list_text(values: object, unit: float, name: str, say: Translator) -> str:
    """Return a list of values in a unit."""
    array = np.ravel(np.asarray(values, dtype=float)) / unit
    apart = "; " if say.code != "en" else ", "
    return (
        f"{apart.join(say.compact_number(v, 5) for v in array)} {name}".rstrip()
        if array.size
        else ""
    )


def _general(a: Application, say: Translator) -> Iterator[tuple[str, str]]:
    yield say("limit profile"), a.profile
    yield say("shaft torque"), _quantity_text(a.torque, 1, "N·m", say)
    yield say("overrun torque"), _quantity_text(a.coast_torque, 1, "N·m", say)
    yield say("shaft speed"), _quantity_text(a.speed, rpm, "rpm", say)
    yield say("shock factor"), say.compact_number(a.shock_factor)
    yield say("prime mover factor"), say.compact_number(a.prime_mover_factor)
    both = (("gravity", a.include_gravity), ("unbalance", a.include_unbalance))
    yield say("loads include"), say.join(*(say(name) for name, on in both if on))
    if a.duty_cycle:
        yield say("duty cycle"), f"{a.duty_cycle.name} ({say.source(str(a.duty_cycle.source))})"
    for k, p in enumerate(a.duty, 1):
        said = say.join(
            f"{say.compact_number(100 * p.share)} %",
            _quantity_text(p.torque, 1, "N·m", say),
            _quantity_text(p.speed, rpm, "rpm", say),
            _quantity_text(p.angle, deg, "deg", say),
        )
        yield say("duty point {number}", number=k), said


def _torsion(a: Application, say: Translator) -> Iterator[tuple[str, str]]:
    if a.torsion is not None:
        s = a.torsion
        yield say("axle inertia"), _quantity_text(s.axle_inertia, 1, "kg·m²", say)
        yield say("axle torsional stiffness"), _quantity_text(s.axle_stiffness, 1, "N·m/rad", say)
        yield say("gearbox inertia"), _quantity_text(s.gearbox_inertia, 1, "kg·m²", say)
        yield (
            say("gearbox torsional stiffness"),
            _quantity_text(s.gearbox_stiffness, 1, "N·m/rad", say),
        )
        yield say("damping ratio of the first mode"), _quantity_text(s.damping_ratio, 1, "", say)


def _vehicle(a: Application, say: Translator) -> Iterator[tuple[str, str]]:
    v, t = a.vehicle, a.tyre
    if v:
        yield say("drive"), v.drive
        yield say("wheelbase"), _quantity_text(v.wheelbase, mm, "mm", say)
        yield (
            say("share of the rear load that is driven"),
            _quantity_text(v.driven_share, 0.01, "%", say),
        )
        yield say("grade"), _quantity_text(v.grade, deg, "deg", say)
        for load in v.loads:
            yield say("load {name}", name=say.state(load.name)), _load(load, say)
        for k, axle in enumerate(v.auxiliary, 1):
            said = say.join(
                _quantity_text(axle.load, kN, "kN", say),
                _quantity_text(axle.behind_front, mm, "mm", say),
            )
            yield say("auxiliary axle {number}", number=k), said
    if t:
        yield say("tyre, static radius"), _quantity_text(t.static_radius, mm, "mm", say)
        yield say("tyre, friction"), say.compact_number(t.friction)


def _load(load: LoadState, say: Translator) -> str:
    rows = (
        ("mass", load.mass, kg, "kg"),
        ("front axles", load.front_load, kN, "kN"),
        ("rear axles", load.rear_load, kN, "kN"),
        ("centre of gravity behind the front axle", load.cg_behind_front, mm, "mm"),
        ("height of the centre of gravity", load.cg_height, mm, "mm"),
    )
    return "; ".join(
        f"{say(n)} {_quantity_text(v, u, w, say)}" for n, v, u, w in rows if v is not None
    )


def _engine(a: Application, say: Translator) -> Iterator[tuple[str, str]]:
    e, g = a.engine, a.gearbox
    if e:
        yield say("engine speed"), _list_text(e.speed, rpm, "rpm", say)
        yield say("engine torque"), _list_text(e.torque, 1, "N·m", say)
        yield say("engine brake torque"), _quantity_text(e.brake_torque or None, 1, "N·m", say)
    if g:
        yield say("gear ratios"), _list_text(g.ratios, 1, "", say)
        yield say("gearbox efficiency"), say.compact_number(g.efficiency)
        yield say("converter torque ratio"), say.compact_number(g.converter_ratio)
        yield say("transfer case, low range"), say.compact_number(g.transfer_ratio)
        yield say("reverse ratio"), _quantity_text(g.reverse_ratio, 1, "", say)
        yield say("retarder torque"), _quantity_text(g.retarder_torque, 1, "N·m", say)


def _suspension(s: Suspension | None, say: Translator) -> Iterator[tuple[str, str]]:
    if s is None:
        return
    yield say("spring load"), _list_text(s.spring.load, N, "N", say)
    yield say("spring deflection"), _list_text(s.spring.deflection, mm, "mm", say)
    yield say("springs per axle"), str(s.springs_per_axle)
    yield say("unsprung mass"), _quantity_text(s.unsprung_mass, kg, "kg", say)
    yield say("equivalent link radius"), _quantity_text(s.linkage.radius, mm, "mm", say)
    yield say("link angle"), _quantity_text(s.linkage.angle, deg, "deg", say)
    yield say("pitch rate"), _quantity_text(s.linkage.pitch_rate or None, deg / mm, "deg/mm", say)
    yield say("linkage table, travel"), _list_text(s.linkage.travel, mm, "mm", say)
    yield say("wind-up stiffness"), _quantity_text(s.windup_stiffness, 1e3 / deg, "kN·m/deg", say)
    yield say("brake torque on the axle"), _quantity_text(s.brake_torque or None, 1, "N·m", say)
    yield say("reference state"), say.state(s.reference)
    yield (
        say("deflection at full rebound"),
        _quantity_text(s.full_rebound_deflection, mm, "mm", say),
    )
    yield say("deflection at bump"), _quantity_text(s.jounce_deflection, mm, "mm", say)
    if not s.squats:
        yield say("squat"), say("left out")


def _line(of: InstalledLine, say: Translator) -> Iterator[tuple[str, str]]:
    line, layout = of.line, of.layout
    if of.forward:
        yield say("the line runs"), say("forward")
    if of.axle:
        yield say("axle ratio"), say.compact_number(of.axle.ratio)
        yield say("axle efficiency"), say.compact_number(of.axle.efficiency)
    if (share := of.torque_ratio * of.torque_share) != 1:
        yield say("share of the torque"), say.compact_number(share)
    yield say("side slopes of the members"), _list_text(layout.side, deg, "deg", say)
    yield say("top slopes of the members"), _list_text(layout.top, deg, "deg", say)
    joints = [_size(j, say) for j in line.joints]
    yield say("joints"), joints[0] if len(set(joints)) == 1 else say.join(*joints)
    for k, shaft in enumerate(line.shafts):
        part = say.part(Part("shaft", k + 1))
        for name, value in _shaft(shaft, float(layout.lengths[k]), say):
            yield f"{part}, {name}", value


def _size(joint: JointSize | None, say: Translator) -> str:
    """Return a joint by its name, and by its kind if it is no cross."""
    if joint is None:
        return "-"
    words = {
        "cross": "", "double cardan": say("double cardan"), "rzeppa": say("Rzeppa joint"),
        "tripod": say("tripod joint"), "flexible disc": say("flexible disc"),
    }  # fmt: skip
    kind = words[joint.kind]
    return f"{joint.name} ({kind})" if kind else joint.name


def _shaft(s: Shaft, length: float, say: Translator) -> Iterator[tuple[str, str]]:
    yield say("length"), _quantity_text(length, mm, "mm", say)
    if s.tube:
        size = (
            f"{say.compact_number(s.tube.outer / mm)} × {say.compact_number(s.tube.wall / mm)} mm"
        )
        yield say("tube"), say.join(size, s.tube.material.name)
        if isinstance(s.tube, CompositeTube):
            yield say("plies, from the inside out"), s.tube.layup
    yield say("yoke phase"), _quantity_text(s.phase, deg, "deg", say)
    b = s.centre_bearing
    if b:
        yield (
            say("centre bearing ahead of the rear joint"),
            _quantity_text(b.from_rear_joint, mm, "mm", say),
        )
        if b.stiffness:
            yield (
                say("bearing stiffness, vertical and lateral"),
                _list_text(b.stiffness, 1 / mm, "N/mm", say),
            )
        yield (
            say("bearing stiffness along the shaft"),
            _quantity_text(b.axial_stiffness, 1 / mm, "N/mm", say),
        )
        yield say("loss factor of the bearing's rubber"), _quantity_text(b.loss_factor, 1, "", say)
        if b.travel is not None:
            yield (
                say("travel of the bearing's rubber to its stop"),
                _quantity_text(b.travel, mm, "mm", say),
            )
        if b.bracket_stiffness:
            yield (
                say("bracket stiffness along the shaft, across and up"),
                _list_text(b.bracket_stiffness, 1 / mm, "N/mm", say),
            )
            yield say("loss factor of the bracket"), _quantity_text(b.bracket_loss, 1, "", say)
    if s.spline:
        yield say("spline plunge"), _quantity_text(s.spline.plunge, mm, "mm", say)
        yield say("spline draw"), _quantity_text(s.spline.draw, mm, "mm", say)
    yield (
        say("yoke masses, front and rear"),
        _list_text(s.yoke_mass, kg, "kg", say) if any(s.yoke_mass) else "",
    )
    yield say("balance grade"), f"G{say.compact_number(s.balance_grade)}" if s.balance_grade else ""


def _states(a: Application, say: Translator) -> Iterator[tuple[str, str]]:
    for s in a.states:
        yield say.state(s.name), _state(s, say) or say("as given")


def _state(s: VehicleState, say: Translator) -> str:
    rows = (
        ("axle travel", s.travel, mm, "mm"),
        ("pinion pitch", s.pitch, deg, "deg"),
        ("torque", s.torque, 1.0, "N·m"),
        ("speed", s.speed, rpm, "rpm"),
    )
    said = [f"{say(n)} {_quantity_text(v, u, w, say)}" for n, v, u, w in rows if v is not None]
    kind = [say.state(s.kind)] if s.kind and s.kind != s.name else []
    placed = [say("placed by the suspension")] if s.kind else []
    own = [say("own geometry")] if s.layouts else []
    load = [say("load {name}", name=say.state(s.load))] if s.load else []
    return "; ".join([*kind, *placed, *load, *said, *own])


def _obstacles(a: Application, say: Translator) -> Iterator[tuple[str, str]]:
    for o in a.obstacles:
        ends = " → ".join(
            f"({'; '.join(say.compact_number(v / mm) for v in p)})" for p in (o.start, o.end)
        )
        said = f"{ends} mm, {say('radius')} {say.compact_number(o.radius / mm)} mm"
        share = f", {say('share of the axle travel')} {say.compact_number(o.travel_share)}"
        yield o.name, said + (share if o.travel_share else "")


def _limits(a: Application, say: Translator) -> Iterator[tuple[str, str]]:
    for limit in a.limits:
        yield say.name(limit.quantity), _limit(limit, say)


def _limit(limit: Limit, say: Translator) -> str:
    q = QUANTITIES[limit.quantity]
    sense = {"<=": "≤", ">=": "≥"}[limit.sense]
    shown = [
        f"{say(name)} {sense} {say.compact_number(bound / q.si_factor)}"
        for name, bound in (("normal", limit.normal), ("maximum", limit.maximum))
        if bound is not None
    ]
    if limit.band:
        low, high = (say.compact_number(b / q.si_factor) for b in limit.band)
        shown.append(say("outside {low} … {high}", low=low, high=high))
    return f"{'; '.join(shown)} {q.unit_symbol}".rstrip()
