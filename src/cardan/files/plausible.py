"""What values of an application say about each other: relations that vehicles keep.

A measure knows what is usual by itself; here a value is held against its neighbours. Each
relation is a number made of values of the file, the range in which it lies on vehicles of
every day, and the key that is odd where it does not. Whoever builds something else is asked
once and may go on. All ranges are our own judgement, set wide; the examples keep them all.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from itertools import islice
from math import inf, nan
from typing import TypeAlias

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.errors import DesignError, Problem
from cardan.base.frozen import dataclass
from cardan.base.units import MPa, deg, g, kN, t
from cardan.border.table import MANY
from cardan.demand.axles import driven_axles
from cardan.demand.states import Demand, demand, resolve
from cardan.demand.suspension import deflection
from cardan.files.origin import place
from cardan.model.application import Application, Installed, State
from cardan.model.layout import Layout
from cardan.model.parts import Shaft
from cardan.model.vehicle import LoadState, Suspension, SuspensionState

Keys: TypeAlias = tuple[str, ...]
"""Addresses that a value may have in the file: the first that is given counts."""
Found: TypeAlias = Iterator[tuple[Keys, float]]
"""Values of a relation, and whose fault one is that lies outside."""


@dataclass(frozen=True, kw_only=True)
class _Seen:
    """One line with what surrounds it, resolved once.

    Attributes
    ----------
    at
        Address of the line.
    """

    application: Application
    installed: Installed

    @property
    def at(self) -> str:
        return f"drivelines.{self.installed.line.name}"

    @property
    def axle(self) -> str:
        """Address of the axle the line drives: its own, or the vehicle's."""
        own = f"{self.at}.axle"
        found = place(self.application, own)
        return own if found and found.key.endswith(".axle") else "axle"

    @cached_property
    def suspension(self) -> tuple[str, Suspension] | None:
        """Address and springs of what moves the line's axle."""
        if self.installed.suspension:
            return f"{self.at}.suspension", self.installed.suspension
        if self.application.suspension and self.installed.drives == "rear":
            return "suspension", self.application.suspension
        return None

    @cached_property
    def reference(self) -> Demand | None:
        """What the vehicle asks in the state the geometry is given in; None if nobody knows."""
        return self.standing(self.suspension[1].reference if self.suspension else "gvw")

    def standing(self, kind: SuspensionState) -> Demand | None:
        """Return what the vehicle asks in one kind of state; None if nobody knows."""
        alone = replace(self.application, states=(State(name=kind, kind=kind),))
        with suppress(DesignError):
            return demand(resolve(alone, self.installed))
        return None

    @property
    def shafts(self) -> Iterator[tuple[str, Shaft, float]]:
        """Address, shaft and length of every shaft."""
        lengths = self.installed.layout.lengths.tolist()
        for k, (shaft, length) in enumerate(
            zip(self.installed.line.shafts, lengths, strict=True), 1
        ):
            yield f"{self.at}.shafts[{k}]", shaft, length


@dataclass(frozen=True, kw_only=True)
class Relation:
    """A number made of several values, and where it lies on vehicles of every day.

    Attributes
    ----------
    says
        What the number is.
    of
        Gives it, in the unit it is said in, for everything it can be asked of; nan where a
        value is not known.
    usual
        Lowest and highest number nobody wonders at.
    unit, hint
        How the number is printed; what to look at.
    """

    says: str
    of: Callable[[Application], Found]
    usual: tuple[float, float]
    unit: str = ""
    hint: str = ""

    def doubts(self, application: Application) -> Iterator[Problem]:
        """Yield a warning, at its key, for each value outside the usual range."""
        low, high = self.usual
        for keys, value in self.of(application):
            if not (value < low or value > high):  # a nan is not known, hence not odd
                continue
            range_ = f"{low:.4g} to {high:.4g}" if high < inf else f"{low:.4g} or more"
            found = place(application, *keys)
            yield Problem(
                message=f"{self.says} is {value:.3g}{self.unit}, where {range_} is usual",
                hint=self.hint,
                key=found.key if found else keys[0],
                line=found.line if found else 0,
                column=found.column if found else 0,
            )


def doubts(application: Application) -> tuple[Problem, ...]:
    """Return what values of an application say against each other, each at its own key."""
    _SEEN[id(application)] = tuple(
        _Seen(application=application, installed=i) for i in application.lines
    )
    try:
        with np.errstate(all="ignore"):
            found = (d for relation in RELATIONS for d in relation.doubts(application))
            return tuple(islice(dict.fromkeys(found), MANY))  # one joint may stand for all
    finally:
        del _SEEN[id(application)]


_SEEN: dict[int, tuple[_Seen, ...]] = {}
"""Lines while their relations are asked: what each needs is resolved once for all of them."""


def _lines(application: Application) -> Iterator[_Seen]:
    return iter(_SEEN[id(application)])


def _over(a: float | None, b: float | None) -> float:
    """Return a/b, nan where one is not known."""
    return a / b if a is not None and b else nan


# --- shafts -------------------------------------------------------------------------------


def _slenderness(application: Application) -> Found:
    for line in _lines(application):
        for at, shaft, length in line.shafts:
            if shaft.tube:
                keys = f"{at}.length", f"{line.at}.points", f"{at}.tube.outer", f"{at}.tube"
                yield keys, length / shaft.tube.outer


def _thinness(application: Application) -> Found:
    for line in _lines(application):
        for at, shaft, _ in line.shafts:
            tube = shaft.tube
            if tube and tube.inner > 1e-3 * tube.outer:  # a solid bar is meant
                yield (f"{at}.tube.wall", f"{at}.tube"), tube.outer / tube.wall


def _bearing_place(application: Application) -> Found:
    for line in _lines(application):
        for at, shaft, length in line.shafts:
            if shaft.centre_bearing:
                keys = (f"{at}.centre_bearing.from_rear_joint",)
                yield keys, shaft.centre_bearing.from_rear_joint / length


def _spline_size(application: Application) -> Found:
    for line in _lines(application):
        for at, shaft, _ in line.shafts:
            if shaft.spline and shaft.tube and shaft.spline.mean_radius:
                keys = (f"{at}.spline.mean_radius",)
                yield keys, 2 * shaft.spline.mean_radius / shaft.tube.outer


def _spline_place(application: Application) -> Found:
    for line in _lines(application):
        for at, shaft, length in line.shafts:
            if shaft.spline:
                yield (f"{at}.spline.from_front_joint",), shaft.spline.from_front_joint / length


def _rubber(application: Application) -> Found:
    for line in _lines(application):
        for at, shaft, _ in line.shafts:
            if shaft.centre_bearing and shaft.centre_bearing.stiffness:
                keys = (f"{at}.centre_bearing.vertical_stiffness",)
                yield keys, _over(*shaft.centre_bearing.stiffness)
        for end in ("gearbox", "pinion"):
            flange = getattr(line.installed.line, f"{end}_flange")
            if flange.stiffness:
                yield (f"{line.at}.{end}_flange.vertical_stiffness",), _over(*flange.stiffness)


def _flanges(application: Application) -> Found:
    for line in _lines(application):
        soft = [s.centre_bearing.stiffness for _, s, _ in line.shafts if s.centre_bearing]
        firm = max((max(k) for k in soft if k), default=None)
        for end in ("gearbox", "pinion"):
            flange = getattr(line.installed.line, f"{end}_flange")
            if flange.stiffness:
                keys = tuple(f"{line.at}.{end}_flange.{n}stiffness" for n in ("", "vertical_"))
                yield keys, _over(min(flange.stiffness), firm)


def _yokes(application: Application) -> Found:
    for line in _lines(application):
        for at, shaft, length in line.shafts:
            if shaft.tube:
                tube = shaft.tube.mass_per_length * length
                yield (f"{at}.yoke_mass",), _over(max(shaft.yoke_mass) or None, tube)


def _given_inertia(application: Application) -> Found:
    for line in _lines(application):
        for at, shaft, length in line.shafts:
            if shaft.tube:
                own = shaft.tube.polar_inertia_per_length * length
                yield (f"{at}.polar_inertia",), _over(shaft.polar_inertia_given, own)


def _strengths(application: Application) -> Found:
    for line in _lines(application):
        for at, shaft, _ in line.shafts:
            if shaft.tube:
                m = shaft.tube.material
                keys = f"{at}.tube.material.ultimate", f"{at}.tube.material", f"{at}.tube"
                yield keys, _over(m.yield_strength, m.ultimate_strength)


def _ratings(application: Application) -> Found:
    for line in _lines(application):
        for k, joint in enumerate(line.installed.line.joints, 1):
            if joint is None:
                continue
            ratings = {"reversing": joint.reversing_torque, "pulsating": joint.pulsating_torque}
            for name, rating in ratings.items():
                keys = f"{line.at}.joints.{name}", f"{line.at}.joints[{k}].{name}"
                yield keys, _over(rating, joint.peak_torque)


def _shear(application: Application) -> Found:
    for line in _lines(application):
        share = line.installed.torque_ratio * line.installed.torque_share
        for _, shaft, _ in line.shafts:
            if shaft.tube and application.torque:
                polar = 2 * shaft.tube.second_moment
                stress = application.torque * share * shaft.tube.outer / 2 / polar
                yield ("torque",), stress / MPa


def _lost_sign(application: Application) -> Found:
    """Yield the bend beside a member that would lie straight if its slope had another sign."""
    for line in _lines(application):
        given = [(line.at, line.installed.layout)]
        for k, state in enumerate(application.states, 1):
            name = line.installed.line.name
            if own := (state.layouts or {}).get(name):
                inside = place(application, f"states[{k}].drivelines.{name}")
                nested = inside and inside.key.endswith(name)
                given.append((f"states[{k}]" + (f".drivelines.{name}" if nested else ""), own))
        for at, layout in given:
            yield from _lost_in(application, at, layout)


def _lost_in(application: Application, at: str, layout: Layout) -> Found:
    points, side = layout.points, layout.side
    found = place(application, f"{at}.points")
    if found and ".points" in found.key:
        ends = (f"{at}.gearbox_slope.side", 0), (f"{at}.pinion_slope.side", len(side) - 1)
        for k in range(1, len(points)):
            turned = points * np.where(np.arange(len(points))[:, None] == k, [1, 1, -1], 1)
            steps = np.diff(turned, axis=0)
            other = np.array([side[0], *np.arctan2(-steps[:, 2], steps[:, 0]), side[-1]])
            yield (f"{at}.points[{k + 1}]",), _sign_bend(side, other, slice(k - 1, k + 2))
    else:
        ends = tuple((f"{at}.slopes.side", k) for k in range(len(side)))
    for key, k in ends:
        other = np.where(np.arange(len(side)) == k, -side, side)
        yield (key,), _sign_bend(side, other, slice(max(k - 1, 0), k + 1))


def _sign_bend(side: FloatArray, other: FloatArray, joints: slice) -> float:
    """Return the larger bend (deg) at some joints; nan where another sign is no better."""
    now, then = (float(np.abs(np.diff(s))[joints].max()) / deg for s in (side, other))
    return now if then < 3 else nan


# --- engine, gears, speed, torque ---------------------------------------------------------


def _top(application: Application) -> float:
    """Top speed of the gearbox output that the engine allows, rad/s."""
    if application.engine is None:
        return nan
    ratios = application.gearbox.ratios if application.gearbox else (1.0,)
    return max(application.engine.full_load[0]) / min(ratios)


def _most(application: Application) -> float:
    """Largest torque at the gearbox output, without losses, N m."""
    if application.engine is None:
        return nan
    gearbox, torque = application.gearbox, application.engine.peak
    if gearbox is None:
        return torque
    return torque * max(gearbox.ratios) * gearbox.converter_ratio * max(gearbox.transfer_ratio, 1)


def _power(application: Application) -> float:
    """Largest power of the engine, W."""
    engine = application.engine
    return max(map(float.__mul__, engine.speed, engine.torque)) if engine else nan


def _heaviest(application: Application) -> float:
    """Largest mass of the vehicle, t."""
    vehicle = application.vehicle
    masses = [_mass(application, load) for load in vehicle.loads] if vehicle else []
    return max(masses, default=nan) / t


def _speed(application: Application) -> Found:
    yield ("speed",), _over(application.speed or None, _top(application))


def _torque(application: Application) -> Found:
    yield ("torque",), _over(application.torque or None, _most(application))


def _parts_of_top(application: Application) -> Found:
    top = _top(application)
    for k, state in enumerate(application.states, 1):
        yield (f"states[{k}].speed",), _over(state.speed, top)
    top = np.fmin(top, nan if application.speed is None else application.speed)
    for k, point in enumerate(application.duty, 1):
        yield (f"duty[{k}].speed",), _over(point.speed, float(top))


def _parts_of_most(application: Application) -> Found:
    most = _most(application)
    for k, state in enumerate(application.states, 1):
        yield (f"states[{k}].torque",), _over(state.torque, most)
    most = np.fmin(most, nan if application.torque is None else application.torque)
    for k, point in enumerate(application.duty, 1):
        yield (f"duty[{k}].torque",), _over(point.torque, float(most))


def _parts_of_power(application: Application) -> Found:
    power = _power(application)
    for k, p in enumerate(application.duty, 1):
        yield (f"duty[{k}].torque",), _over(p.torque * p.speed, power)
    for k, s in enumerate(application.states, 1):
        if s.torque is not None and s.speed is not None:
            yield (f"states[{k}].torque",), _over(s.torque * s.speed, power)


def _slowest(application: Application) -> Found:
    if application.engine:
        # An electric motor's curve starts at rest.
        lowest = min(application.engine.speed) or None
        yield ("engine.speed",), _over(lowest, max(application.engine.speed))


def _dip(application: Application) -> Found:
    """Yield each torque of the curve between others, over the lower of the tops beside it."""
    curve = application.engine.torque if application.engine else ()
    for k in range(1, len(curve) - 1):
        beside = min(max(curve[:k]), max(curve[k + 1 :]))
        yield (f"engine.torque[{k + 1}]", "engine.torque"), _over(curve[k], beside)


def _braking(application: Application) -> Found:
    engine = application.engine
    if engine and engine.brake_torque:
        yield ("engine.brake_torque",), _over(engine.brake_torque, max(engine.torque))


def _coasting(application: Application) -> Found:
    yield ("coast_torque",), _over(application.coast_torque or None, _most(application))


def _specific_torque(application: Application) -> Found:
    if application.engine:
        yield ("engine.torque",), _over(max(application.engine.torque), _heaviest(application))


def _specific_power(application: Application) -> Found:
    yield ("engine.speed",), _over(_power(application) / 1e3, _heaviest(application))


def _gears(application: Application) -> Found:
    if application.gearbox and len(application.gearbox.ratios) > 1:
        yield ("gearbox.ratios",), max(application.gearbox.ratios)


def _reverse(application: Application) -> Found:
    if gearbox := application.gearbox:
        yield ("gearbox.reverse_ratio",), _over(gearbox.reverse_ratio, max(gearbox.ratios))


def _retarding(application: Application) -> Found:
    if gearbox := application.gearbox:
        held = gearbox.retarder_torque or None
        yield ("gearbox.retarder_torque",), _over(held, _most(application))


def _axial(application: Application) -> Found:
    for line in _lines(application):
        for at, shaft, _ in line.shafts:
            if (bearing := shaft.centre_bearing) and bearing.stiffness:
                across = max(bearing.stiffness)
                keys = (f"{at}.centre_bearing.axial_stiffness",)
                yield keys, _over(bearing.axial_stiffness, across)


def _spread(application: Application) -> Found:
    if application.gearbox:
        ratios = application.gearbox.ratios
        yield ("gearbox.ratios",), max(ratios) / min(ratios)


def _road_speed(application: Application) -> Found:
    tyre = application.tyre
    for line in _lines(application):
        axle = line.installed.axle
        if axle and tyre:
            speed = application.speed or _top(application)
            speed *= line.installed.speed_ratio / axle.ratio
            yield (f"{line.axle}.ratio",), speed * (tyre.dynamic_radius or tyre.static_radius) * 3.6


# --- vehicle ------------------------------------------------------------------------------


def _mass(application: Application, load: LoadState) -> float:
    """Mass of a loaded vehicle, kg."""
    if load.mass is not None:
        return load.mass
    vehicle = application.vehicle
    beside = sum(a.load for a in vehicle.auxiliary) if vehicle else 0.0
    on_axles = (load.front_load or 0.0) + (load.rear_load or 0.0)
    return (on_axles + (0.0 if load.auxiliary_lifted else beside)) / g


def _loads(application: Application) -> dict[str, float]:
    vehicle = application.vehicle
    return {w.name: _mass(application, w) for w in vehicle.loads} if vehicle else {}


def _lighter(light: str, heavy: str) -> Callable[[Application], Found]:
    def of(application: Application) -> Found:
        masses = _loads(application)
        for name in (light, heavy):  # nobody knows which of the two is wrong
            at = f"vehicle.loads.{name}"
            keys = f"{at}.mass", f"{at}.front_axle", at
            yield keys, _over(masses.get(light), masses.get(heavy))

    return of


def _centre_height(application: Application) -> Found:
    if vehicle := application.vehicle:
        for load in vehicle.loads:
            keys = (f"vehicle.loads.{load.name}.cg_height",)
            yield keys, _over(load.cg_height, vehicle.wheelbase)


def _front_share(application: Application) -> Found:
    if vehicle := application.vehicle:
        for load in vehicle.loads:
            if load.front_load is not None and load.rear_load is not None:
                keys = f"vehicle.loads.{load.name}.front_axle", f"vehicle.loads.{load.name}"
                yield keys, _over(load.front_load, load.front_load + load.rear_load)


def _centre_over_tyre(application: Application) -> Found:
    if (vehicle := application.vehicle) and (tyre := application.tyre):
        for load in vehicle.loads:
            keys = (f"vehicle.loads.{load.name}.cg_height",)
            yield keys, _over(load.cg_height, tyre.static_radius)


def _centre_place(application: Application) -> Found:
    if vehicle := application.vehicle:
        for load in vehicle.loads:
            keys = (f"vehicle.loads.{load.name}.cg_behind_front",)
            yield keys, _over(load.cg_behind_front, vehicle.wheelbase)


def _axle_weight(application: Application) -> Found:
    if vehicle := application.vehicle:
        for load in vehicle.loads:
            at = f"vehicle.loads.{load.name}"
            yield (f"{at}.front_axle",), _over(load.front_load, vehicle.front_group * kN * g)
            yield (f"{at}.rear_axle",), _over(load.rear_load, vehicle.rear_group * kN * g)


def _rolling(application: Application) -> Found:
    if tyre := application.tyre:
        yield ("tyre.dynamic_radius",), _over(tyre.dynamic_radius, tyre.static_radius)


def _pinion_ahead(application: Application) -> Found:
    for line in _lines(application):
        axle, tyre = line.installed.axle, application.tyre
        if axle and tyre and axle.pinion_joint[0]:
            keys = f"{line.axle}.pinion.ahead", f"{line.axle}.pinion.behind"
            yield keys, -axle.pinion_joint[0] / tyre.static_radius


def _pinion_height(application: Application) -> Found:
    for line in _lines(application):
        axle, tyre = line.installed.axle, application.tyre
        if axle and tyre:
            keys = f"{line.axle}.pinion.above", f"{line.axle}.pinion.below"
            yield keys, abs(axle.pinion_joint[1]) / tyre.static_radius


def _output_behind(application: Application) -> Found:
    for line in _lines(application):
        joint, tyre = line.installed.output_joint, application.tyre
        if joint and tyre:
            keys = f"{line.at}.output_joint.behind", f"{line.at}.output_joint.ahead"
            yield keys, joint[0] / tyre.static_radius


def _reach(application: Application) -> Found:
    for line in _lines(application):
        vehicle, axle = application.vehicle, line.installed.axle
        if vehicle and line.installed.drives == "rear" and not line.installed.forward:
            x = line.installed.layout.points[:, 0]
            ahead = -axle.pinion_joint[0] if axle else 0.0
            yield ("vehicle.wheelbase",), (x[-1] - x[0] + ahead) / vehicle.wheelbase


# --- suspension ---------------------------------------------------------------------------


def _unsprung(application: Application) -> Found:
    for line in _lines(application):
        if line.suspension and line.reference and line.suspension[1].unsprung_mass:
            at, suspension = line.suspension
            load = float(line.reference.axle_load[0])
            yield (f"{at}.unsprung_mass",), _over(suspension.unsprung_mass * g, load)


def _frequency(application: Application) -> Found:
    for line in _lines(application):
        if line.suspension and line.reference:
            spring = f"{line.suspension[0]}.spring"
            keys = f"{spring}.rates", f"{spring}.load", spring
            yield keys, float(line.reference.suspension_frequency[0])


def _windup(application: Application) -> Found:
    for line in _lines(application):
        axle, vehicle = line.installed.axle, application.vehicle
        if not (line.suspension and line.reference and axle):
            continue
        at, suspension = line.suspension
        behind = driven_axles(vehicle, drives=line.installed.drives) if vehicle else 1
        torque = float(line.reference.torque[0]) * axle.ratio * axle.efficiency
        torque = _over(torque, behind * line.installed.load_share)
        yield (f"{at}.windup_stiffness",), _over(torque, suspension.windup_stiffness) / deg


def _stops(name: str, sign: int) -> Callable[[Application], Found]:
    def of(application: Application) -> Found:
        for line in _lines(application):
            if not (line.suspension and line.reference):
                continue
            at, suspension = line.suspension
            key, stop = f"{at}.{name}_deflection", getattr(suspension, f"{name}_deflection")
            if stop is None and name == "jounce" and suspension.spring.ends:
                key, stop = f"{at}.spring.deflection", suspension.spring.deflection[-1]
            load = float(line.reference.axle_load[0])
            with suppress(DesignError):
                rest = deflection(suspension, suspension.reference, axle_load=load)
                if stop is not None and suspension.reference not in (name, "rebound"):
                    yield (key,), 1e3 * sign * (stop - float(rest))

    return of


UNLADEN: tuple[SuspensionState, ...] = ("curb", "empty")
"""Kinds of state in which springs carry least on the road."""


def _strap(application: Application) -> Found:
    kinds = {state.kind for state in application.states}
    for line in _lines(application):
        at, suspension = line.suspension or ("", None)
        strap = suspension.full_rebound_deflection if suspension else None
        for kind in UNLADEN:
            stands = line.standing(kind) if kind in kinds else None
            if suspension and strap is not None and stands and suspension.reference != kind:
                load = float(stands.axle_load[0])
                with suppress(DesignError):
                    rest = float(deflection(suspension, kind, axle_load=load))
                    yield (f"{at}.full_rebound_deflection",), 1e3 * (rest - strap)


RELATIONS: tuple[Relation, ...] = (
    Relation(says="the shaft's length over its tube's diameter", of=_slenderness, usual=(2, 60),
             hint="is one of them in another unit?"),
    Relation(says="the tube's diameter over its wall", of=_thinness, usual=(8, 120),
             hint="is one of them in another unit, or a radius?"),
    Relation(says="the bearing's distance from the rear joint, as a share of the shaft,",
             of=_bearing_place, usual=(0, 1 / 3), hint="is it measured from the front joint?"),
    Relation(says="the spline's mean diameter over the tube's", of=_spline_size,
             usual=(0.15, 0.9), hint="is a diameter given for the radius?"),
    Relation(says="the spline's place, as a share of its shaft,", of=_spline_place, usual=(0, 1),
             hint="it is measured from the front joint"),
    Relation(says="the vertical stiffness over the lateral one", of=_rubber, usual=(0.1, 10),
             hint="is one of them in another unit?"),
    Relation(says="the flange's stiffness over that of the firmest rubber", of=_flanges,
             usual=(0.2, 1e4), hint="is one of them in another unit?"),
    Relation(says="the mass of a shaft's yoke over that of its tube", of=_yokes,
             usual=(0.01, 4), hint="check the unit"),
    Relation(says="the given inertia over that of the tube", of=_given_inertia, usual=(0.8, 20),
             hint="check the unit"),
    Relation(says="yield over ultimate strength", of=_strengths, usual=(0.3, 1),
             hint="are they swapped?"),
    Relation(says="the rating over the joint's peak torque", of=_ratings, usual=(0.05, 1),
             hint="are they swapped?"),
    Relation(says="shear in a tube under this torque", of=_shear, usual=(2, 900), unit=" MPa",
             hint="check the unit, or the tube"),
    Relation(says="the bend of the joint beside it", of=_lost_sign, usual=(0, 6), unit=" deg",
             hint="with the other sign it would be below 3 deg: is the sign right?"),
    Relation(says="top speed over that of the engine in its highest gear", of=_speed,
             usual=(0.15, 1.05), hint="is it the gearbox output's, in this unit?"),
    Relation(says="the torque over the engine's in its lowest gear", of=_torque,
             usual=(0.1, 1.05), hint="is it the gearbox output's, in this unit?"),
    Relation(says="the speed over the top speed of the gearbox output", of=_parts_of_top,
             usual=(0, 1.05), hint="it is counted at the gearbox output"),
    Relation(says="the torque over the largest at the gearbox output", of=_parts_of_most,
             usual=(0, 1.05), hint="it is counted at the gearbox output"),
    Relation(says="torque times speed over the engine's largest power", of=_parts_of_power,
             usual=(0, 1.1), hint="they do not occur together"),
    Relation(says="the curve's lowest speed over its highest", of=_slowest, usual=(0.02, 1),
             hint="check the unit"),
    Relation(says="the torque over the tops of the curve beside it", of=_dip, usual=(0.4, inf),
             hint="is a value missing or mistyped?"),
    Relation(says="the brake's torque over the engine's own", of=_braking, usual=(0.02, 1.5),
             hint="it is counted at the crankshaft"),
    Relation(says="the torque over the engine's in its lowest gear", of=_coasting,
             usual=(0.001, 1.5), hint="it is counted at the gearbox output"),
    Relation(says="the engine's torque for each tonne", of=_specific_torque, usual=(10, 800),
             unit=" N m", hint="is it the crankshaft's, in this unit?"),
    Relation(says="the engine's power for each tonne", of=_specific_power, usual=(1.5, 600),
             unit=" kW", hint="check the unit of its speed"),
    Relation(says="the largest ratio", of=_gears, usual=(1.2, inf),
             hint="ratios are engine speed over output speed: are these the inverse?"),
    Relation(says="the lowest gear's ratio over the highest's", of=_spread, usual=(1, 30),
             hint="check the ratios"),
    Relation(says="the reverse ratio over the lowest gear's", of=_reverse, usual=(0.4, 2.5),
             hint="it is engine speed over output speed, without a sign"),
    Relation(says="the retarder's torque over the engine's in its lowest gear", of=_retarding,
             usual=(0.02, 1.5), hint="it is counted at the gearbox output"),
    Relation(says="stiffness along the shaft over that across it", of=_axial, usual=(0.02, 10),
             hint="is one of them in another unit?"),
    Relation(says="the vehicle's top speed", of=_road_speed, usual=(15, 300), unit=" km/h",
             hint="check speed, tyre and this ratio"),
    Relation(says="the mass empty over that at gvw", of=_lighter("empty", "gvw"),
             usual=(0.1, 1), hint="are they swapped, or in another unit?"),
    Relation(says="the mass at curb over that empty", of=_lighter("curb", "empty"),
             usual=(0.3, 1), hint="are they swapped, or in another unit?"),
    Relation(says="the mass at curb over that at gvw", of=_lighter("curb", "gvw"),
             usual=(0.1, 1), hint="are they swapped, or in another unit?"),
    Relation(says="the centre of gravity's height over the wheelbase", of=_centre_height,
             usual=(0.07, 0.8), hint="it is measured from the ground"),
    Relation(says="the centre of gravity's height over the tyre's radius", of=_centre_over_tyre,
             usual=(0.8, 6), hint="it is measured from the ground"),
    Relation(says="the front axle's share of the load", of=_front_share, usual=(0.1, 0.9),
             hint="is one of them in another unit?"),
    Relation(says="the centre of gravity's place, as a share of the wheelbase,",
             of=_centre_place, usual=(0.1, 0.95),
             hint="it is measured from the front axle rearward"),
    Relation(says="the load of each axle", of=_axle_weight, usual=(0.05, 30), unit=" t",
             hint="check the unit"),
    Relation(says="the rolling radius over the standing one", of=_rolling, usual=(1, 1.15),
             hint="a rolling tyre is a little larger"),
    Relation(says="how far the last joint sits ahead of the wheels, in tyre radii,",
             of=_pinion_ahead, usual=(0.15, 2), hint="ahead is towards the gearbox"),
    Relation(says="the last joint's height from the wheel centre, in tyre radii,",
             of=_pinion_height, usual=(0, 0.7), hint="check the unit"),
    Relation(says="how far joint 1 sits behind the wheels it leaves, in tyre radii,",
             of=_output_behind, usual=(0.15, 2), hint="behind is away from the gearbox"),
    Relation(says="the line's length to its axle over the wheelbase", of=_reach, usual=(0.02, 1),
             hint="check the wheelbase, or the line"),
    Relation(says="the unsprung mass, as a share of what its axle carries,", of=_unsprung,
             usual=(0.02, 1 / 3), hint="it is that of one axle with its wheels"),
    Relation(says="the natural frequency on these springs", of=_frequency, usual=(0.5, 3.3),
             unit=" Hz", hint="check springs, springs_per_axle and the axle's load"),
    Relation(says="the axle's pitch under full torque", of=_windup, usual=(0.05, 10),
             unit=" deg", hint="check the stiffness and its unit"),
    Relation(says="how far the axle can rise from its place", of=_stops("jounce", 1),
             usual=(3, 400), unit=" mm", hint="deflections count from the free spring"),
    Relation(says="how far the axle can sink from its place", of=_stops("full_rebound", -1),
             usual=(3, 500), unit=" mm", hint="deflections count from the free spring"),
    Relation(says="how far the axle can sink from where it stands unladen", of=_strap,
             usual=(0, 500), unit=" mm", hint="deflections count from the free spring, and the "
             "strap would hold it up there"),
)  # fmt: skip
"""What is held against each other, in the order of the file."""
