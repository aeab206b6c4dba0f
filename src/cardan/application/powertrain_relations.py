"""Relations between engine, gears, axle ratio, tyre, speeds and torques."""

from dataclasses import replace
from itertools import pairwise
from math import nan

import numpy as np

from cardan.application.relation_context import (
    ComparedValue,
    ComparedValues,
    RelationContext,
    ratio,
)
from cardan.application.typical_values import typical_value
from cardan.core.units import g, t

MIN_CURVE_POINTS = 3
"""Points of a full-load curve from which its shape says something."""

MAX_GOVERNED_DROOP = 0.2
"""Share of speed within which a governor takes an engine's torque away: assumed."""

MAX_TYPED_DUTY_POINTS = 8
"""Points of a duty up to which a person has typed them: assumed."""

COASTING_TORQUE_SHARE = 0.02
"""Share of a duty's largest torque below which a point is unloaded; named cycles: 0.0125."""

LEAST_MASS_T = {"long-haul": 7.5, "refuse": 3.5, "construction": 3.5}
"""Mass, t, from which vehicles do what a duty cycle says, assumed: lorries of Regulation (EU)
2017/2400 have the mission long haul; below 3.5 t are vans. Below it other cycles load more."""

OTHER_DRIVES: dict[str, frozenset[str]] = {
    "distribution": frozenset({"4x4", "6x4", "6x6", "8x4", "8x8"}),
    "long-haul": frozenset({"4x4", "6x6", "8x8"}),
    "regional": frozenset({"4x4", "6x6", "8x8"}),
}
"""Drives of trucks whose groups have not the mission of a duty cycle: all-wheel drive has
construction and municipal utility, 6x4 and 8x4 no urban delivery."""

LEAST_CRAWLER_RATIO = 4.0
"""Ratio of an automatic's first gear from which it is a crawler, shorter than reverse: assumed."""

TYPICAL_PARTS = (
    "clutch.stiffness", "clutch.disc_inertia", "converter.pump_inertia",
    "converter.turbine_inertia", "gearbox.input_inertia", "axle.flange_inertia",
    "axle.pinion_inertia", "axle.pinion_stiffness", "axle.ring_inertia", "axle.housing_inertia",
    "wheels.inertia", "wheels.hub_inertia", "tyre.longitudinal_stiffness",
)  # fmt: skip
"""Quantities of the catalogue of typical values that are single numbers of a file."""

ENGINE = "engine.torque", "engine.speed"


# --- speed and torque of the file against engine and gears


def compare_top_speed(of: RelationContext) -> ComparedValues:
    """Top speed over that of the engine in its highest gear."""
    value = ratio(of.application.speed or None, of.top_speed)
    yield ComparedValue(("speed",), value, ("engine.speed", "gearbox.ratios"))


def compare_given_torque(of: RelationContext) -> ComparedValues:
    """Torque at the gearbox output over the engine's in its lowest gear."""
    value = ratio(of.application.torque or None, of.largest_torque)
    yield ComparedValue(("torque",), value, ("engine.torque", "gearbox.ratios"))


def compare_given_torque_over_what_engine_and_tyres_allow(of: RelationContext) -> ComparedValues:
    """Torque of the file over the smaller of the engine's in its lowest gear and the tyres'."""
    if of.application.torque is None or of.application.engine is None:
        return
    reached = RelationContext(application=replace(of.application, torque=None))
    leaving = [line for line in reached.lines if line.leaves_gearbox]
    if leaving and (demand := leaving[0].laden):
        line = leaving[0].installed
        given = of.application.torque * line.torque_ratio * line.torque_share
        value = ratio(given, float(demand.torque[0]))
        yield ComparedValue(("torque",), value, ("engine.torque", "gearbox.ratios"))


def compare_part_speeds(of: RelationContext) -> ComparedValues:
    """Speed of a state over the top speed of the gearbox output."""
    top = of.top_speed
    for k, state in enumerate(of.application.states, 1):
        against = ("engine.speed", "gearbox.ratios")
        yield ComparedValue((f"states[{k}].speed",), ratio(state.speed, top), against)


def compare_state_road_speed(of: RelationContext) -> ComparedValues:
    """Road speed at a state's own speed of the gearbox output, km/h."""
    tyre, line = of.application.tyre, next((one for one in of.lines if one.installed.axle), None)
    axle = line.installed.axle if line else None
    if tyre and line and axle:
        turns = line.installed.speed_ratio / axle.ratio
        radius = tyre.dynamic_radius or tyre.static_radius
        for k, state in enumerate(of.application.states, 1):
            value = (state.speed or nan) * turns * radius * 3.6
            against = f"{line.axle}.ratio", "tyre.dynamic_radius"
            yield ComparedValue((f"states[{k}].speed",), value, against)


def compare_duty_speeds(of: RelationContext) -> ComparedValues:
    """Speed of a duty point over the top speed of the gearbox output."""
    given = of.application.speed
    top = float(np.fmin(of.top_speed, nan if given is None else given))
    for k, point in enumerate(of.application.duty, 1):
        yield ComparedValue((f"duty[{k}].speed",), ratio(point.speed, top), ("speed",))


def compare_windup_speeds(of: RelationContext) -> ComparedValues:
    """Speed of a wind-up state over the engine's top speed in its lowest gear."""
    gearbox = of.application.gearbox
    for k, state in enumerate(of.application.states, 1):
        if gearbox and state.kind == "windup":
            lowest = of.top_speed * min(gearbox.ratios) / max(gearbox.ratios)
            against = ("engine.speed", "gearbox.ratios")
            yield ComparedValue((f"states[{k}].speed",), ratio(state.speed, lowest), against)


def compare_part_torques(of: RelationContext) -> ComparedValues:
    """Torque of a state over the largest at the gearbox output."""
    most = of.largest_torque
    for k, state in enumerate(of.application.states, 1):
        against = ("engine.torque", "gearbox.ratios")
        yield ComparedValue((f"states[{k}].torque",), ratio(state.torque, most), against)


def compare_duty_torques(of: RelationContext) -> ComparedValues:
    """Torque of a duty point over the largest at the gearbox output."""
    given = of.application.torque
    most = float(np.fmin(of.largest_torque, nan if given is None else given))
    for k, point in enumerate(of.application.duty, 1):
        yield ComparedValue((f"duty[{k}].torque",), ratio(point.torque, most), ("torque",))


def compare_largest_duty_torque(of: RelationContext) -> ComparedValues:
    """Largest torque of a duty over the largest at the gearbox output, at its slowest point.

    The point that pulls away carries most: a duty without it leaves out what wears most.
    """
    duty, given = of.application.duty, of.application.torque
    most = float(np.fmin(of.largest_torque, nan if given is None else given))
    if duty and most > 0:
        k = min(range(len(duty)), key=lambda one: duty[one].speed)
        value = max(point.torque for point in duty) / most
        against = ("torque",) if given is not None else ("engine.torque", "gearbox.ratios")
        yield ComparedValue((f"duty[{k + 1}].torque", "duty"), value, against)


def compare_duty_powers(of: RelationContext) -> ComparedValues:
    """Power of a duty point over the largest of its duty, unloaded points aside.

    A vehicle pulls away slowly and cruises fast: its power stays within one order of magnitude.
    Of a few points, as a person types them: classes of a measured trip hold what is rare.
    """
    duty = of.application.duty
    if not 1 < len(duty) <= MAX_TYPED_DUTY_POINTS:
        return
    power, most = max(p.torque * p.speed for p in duty), max(p.torque for p in duty)
    for k, p in enumerate(duty, 1):
        coasts = p.torque < COASTING_TORQUE_SHARE * most
        value = nan if coasts else ratio(p.torque * p.speed, power)
        others = [i for i in range(1, len(duty) + 1) if i != k]
        keys = f"duty[{k}].torque", f"duty[{k}]"
        against = (f"duty[{k}].speed", *(f"duty[{i}].torque" for i in others))
        yield ComparedValue(keys, value, against)


def compare_named_duty(of: RelationContext) -> ComparedValues:
    """1 if a duty cycle by name is not for a vehicle of this mass or drive, else 0.

    Regulation (EU) 2017/2400, annex I, gives each group of vehicles its missions.
    """
    cycle, vehicle = of.application.duty_cycle, of.application.vehicle
    if cycle is None or vehicle is None or not of.masses:
        return
    least = LEAST_MASS_T.get(cycle.name, 0.0)
    is_truck = of.heaviest >= LEAST_MASS_T["long-haul"]
    drives = OTHER_DRIVES.get(cycle.name, frozenset()) if is_truck else frozenset[str]()
    light, driven = of.heaviest < least, vehicle.drive in drives
    detail = f"{cycle.name}, " + (f"{of.heaviest:.3g} t < {least:g} t" if light else vehicle.drive)
    against = (of.heaviest_address,) if light else ("vehicle.drive",)
    yield ComparedValue(("duty",), float(light or driven), against, detail)


def compare_part_powers(of: RelationContext) -> ComparedValues:
    """Torque times speed of a state or duty point over the engine's largest power."""
    for k, p in enumerate(of.application.duty, 1):
        value = ratio(p.torque * p.speed, of.power)
        yield ComparedValue((f"duty[{k}].torque",), value, (f"duty[{k}].speed", *ENGINE))
    for k, s in enumerate(of.application.states, 1):
        if s.torque is not None and s.speed is not None:
            value = ratio(s.torque * s.speed, of.power)
            yield ComparedValue((f"states[{k}].torque",), value, (f"states[{k}].speed", *ENGINE))


def compare_coast_torque(of: RelationContext) -> ComparedValues:
    """Overrun torque over the engine's torque in its lowest gear."""
    value = ratio(of.application.coast_torque or None, of.largest_torque)
    yield ComparedValue(("coast_torque",), value, ("engine.torque", "gearbox.ratios"))


def compare_overrun_torque_over_drive_torque(of: RelationContext) -> ComparedValues:
    """Overrun torque over the torque that drives, both as the file gives them."""
    value = ratio(of.application.coast_torque, of.application.torque or None)
    yield ComparedValue(("coast_torque",), value, ("torque",))


def compare_retarder_torque(of: RelationContext) -> ComparedValues:
    """Torque of the retarder over the engine's in its lowest gear."""
    if gearbox := of.application.gearbox:
        value = ratio(gearbox.retarder_torque or None, of.largest_torque)
        yield ComparedValue(
            ("gearbox.retarder_torque",), value, ("engine.torque", "gearbox.ratios")
        )


def compare_retarder_per_tonne(of: RelationContext) -> ComparedValues:
    """Torque of the retarder for each tonne of the vehicle, N m/t."""
    if gearbox := of.application.gearbox:
        value = ratio(gearbox.retarder_torque or None, of.heaviest)
        yield ComparedValue(("gearbox.retarder_torque",), value, (of.heaviest_address,))


# --- engine


def compare_curve_speeds(of: RelationContext) -> ComparedValues:
    """Lowest over highest speed of the full-load curve of a combustion engine."""
    engine = of.application.engine
    if engine and not of.application.electric:
        # A curve that starts at rest is a motor's.
        value = ratio(min(engine.speed) or None, max(engine.speed))
        yield ComparedValue(("engine.speed",), value)


def compare_motor_speeds(of: RelationContext) -> ComparedValues:
    """Lowest over highest speed of the full-load curve of an electric motor."""
    engine = of.application.engine
    if engine and of.application.electric and len(engine.speed) > 1:
        value = ratio(min(engine.speed), max(engine.speed))
        yield ComparedValue(("prime_mover",), value, ("engine.speed",))


def compare_curve_dip(of: RelationContext) -> ComparedValues:
    """Torque of a point of the curve over the lower of the maxima on both sides."""
    curve = of.application.engine.torque if of.application.engine else ()
    for k in range(1, len(curve) - 1):
        beside = min(max(curve[:k]), max(curve[k + 1 :]))
        keys = f"engine.torque[{k + 1}]", "engine.torque"
        yield ComparedValue(keys, ratio(curve[k], beside))


def compare_curve_start(of: RelationContext) -> ComparedValues:
    """Torque at the lowest speed of the curve over its largest."""
    engine = of.application.engine
    if engine and len(engine.torque) > 1 and min(engine.speed) > 0:
        value = ratio(engine.torque[0], max(engine.torque))
        yield ComparedValue(("engine.torque[1]", "engine.torque"), value)


def compare_curve_end(of: RelationContext) -> ComparedValues:
    """Power at the end of the curve over its largest, if no governor's droop explains it."""
    engine = of.application.engine
    if engine is None or len(engine.speed) < MIN_CURVE_POINTS:
        return
    power = [n * torque for n, torque in zip(engine.speed, engine.torque, strict=True)]
    peak = max(range(len(power)), key=power.__getitem__)
    wide = 1 - engine.speed[peak] / engine.speed[-1] > MAX_GOVERNED_DROOP
    keys = f"engine.torque[{peak + 1}]", "engine.torque"
    yield ComparedValue(keys, ratio(power[-1], power[peak]) if wide else nan, ("engine.speed",))


def compare_curve_fall(of: RelationContext) -> ComparedValues:
    """Torque at the end of a combustion engine's curve over its largest."""
    engine = of.application.engine
    if engine and len(engine.torque) >= MIN_CURVE_POINTS and not of.application.electric:
        value = ratio(engine.torque[-1], max(engine.torque))
        yield ComparedValue((f"engine.torque[{len(engine.torque)}]", "engine.torque"), value)


def compare_brake_torque(of: RelationContext) -> ComparedValues:
    """Torque of the engine brake over the engine's own."""
    engine = of.application.engine
    if engine and engine.brake_torque:
        value = ratio(engine.brake_torque, max(engine.torque))
        yield ComparedValue(("engine.brake_torque",), value, ("engine.torque",))


def compare_rated_power(of: RelationContext) -> ComparedValues:
    """Largest torque times speed of the curve over the rated power."""
    if engine := of.application.engine:
        value = ratio(of.power, engine.power)
        yield ComparedValue(("engine.torque",), value, ("engine.power", "engine.speed"))


def compare_torque_per_tonne(of: RelationContext) -> ComparedValues:
    """Largest torque of the engine for each tonne of the vehicle, N m/t."""
    if engine := of.application.engine:
        value = ratio(max(engine.torque), of.heaviest)
        yield ComparedValue(("engine.torque",), value, (of.heaviest_address,))


def compare_power_per_tonne(of: RelationContext) -> ComparedValues:
    """Largest power of the engine for each tonne of the vehicle, kW/t."""
    value = ratio(of.power / 1e3, of.heaviest)
    yield ComparedValue(("engine.speed",), value, ("engine.torque", of.heaviest_address))


def compare_torque_per_litre(of: RelationContext) -> ComparedValues:
    """Largest torque of the engine over its displacement, N m/l."""
    if engine := of.application.engine:
        litres = None if engine.displacement is None else 1e3 * engine.displacement
        value = ratio(max(engine.torque), litres)
        yield ComparedValue(("engine.torque",), value, ("engine.displacement",))


def compare_cylinder_volume(of: RelationContext) -> ComparedValues:
    """Displacement of one cylinder, l."""
    engine = of.application.engine
    if engine and engine.displacement is not None:
        value = ratio(1e3 * engine.displacement, engine.cylinders)
        yield ComparedValue(("engine.cylinders",), value, ("engine.displacement",))


def compare_idle_speed(of: RelationContext) -> ComparedValues:
    """Idle speed over the highest of the curve."""
    if engine := of.application.engine:
        yield ComparedValue(
            ("engine.idle",), ratio(engine.idle, max(engine.speed)), ("engine.speed",)
        )


def compare_governed_speed(of: RelationContext) -> ComparedValues:
    """Governed speed over the highest of the curve."""
    if engine := of.application.engine:
        value = ratio(engine.governed, max(engine.speed))
        yield ComparedValue(("engine.governed",), value, ("engine.speed",))


def compare_clutch_capacity(of: RelationContext) -> ComparedValues:
    """Torque that the clutch holds over the engine's largest."""
    engine, clutch = of.application.engine, of.application.clutch
    if engine and clutch:
        value = ratio(clutch.capacity, max(engine.torque))
        yield ComparedValue(("clutch.capacity",), value, ("engine.torque",))


# --- gears


def compare_largest_ratio(of: RelationContext) -> ComparedValues:
    """Largest ratio of a gearbox of several."""
    if of.application.gearbox and len(of.application.gearbox.ratios) > 1:
        yield ComparedValue(("gearbox.ratios",), max(of.application.gearbox.ratios))


def compare_gear_spread(of: RelationContext) -> ComparedValues:
    """Largest over smallest ratio."""
    if of.application.gearbox:
        ratios = of.application.gearbox.ratios
        yield ComparedValue(("gearbox.ratios",), max(ratios) / min(ratios))


def compare_gear_steps(of: RelationContext) -> ComparedValues:
    """Ratio of a gear over that of the next; lowest and highest alone may stand for all."""
    ratios = of.application.gearbox.ratios if of.application.gearbox else ()
    for k, (low, high) in enumerate(pairwise(ratios if len(ratios) > 2 else ()), 1):
        yield ComparedValue((f"gearbox.ratios[{k}]", "gearbox.ratios"), low / high)


def compare_gear_progression(of: RelationContext) -> ComparedValues:
    """Lowest step between gears over the next."""
    ratios = of.application.gearbox.ratios if of.application.gearbox else ()
    if len(ratios) >= 3 and not of.has_converter:
        value = (ratios[0] / ratios[1]) / (ratios[1] / ratios[2])
        yield ComparedValue(("gearbox.ratios[1]", "gearbox.ratios"), value)


def compare_reverse_ratio(of: RelationContext) -> ComparedValues:
    """Reverse ratio over the lowest gear's, of a gearbox with a clutch."""
    if (gearbox := of.application.gearbox) and not of.has_converter:
        value = ratio(gearbox.reverse_ratio, max(gearbox.ratios))
        yield ComparedValue(("gearbox.reverse_ratio",), value, ("gearbox.ratios",))


def compare_automatic_reverse_ratio(of: RelationContext) -> ComparedValues:
    """Reverse ratio over the lowest gear's, of a gearbox with a converter."""
    if (gearbox := of.application.gearbox) and of.has_converter:
        value = ratio(gearbox.reverse_ratio, max(gearbox.ratios))
        yield ComparedValue(("gearbox.reverse_ratio",), value, ("gearbox.ratios",))


def compare_planetary_reverse_ratio(of: RelationContext) -> ComparedValues:
    """Reverse ratio over the lowest gear's, of a truck's automatic without a crawler gear."""
    truck = of.vehicle_class in ("medium truck", "heavy truck")
    gearbox = of.application.gearbox
    if truck and gearbox and of.has_converter and max(gearbox.ratios) < LEAST_CRAWLER_RATIO:
        value = ratio(gearbox.reverse_ratio, max(gearbox.ratios))
        yield ComparedValue(("gearbox.reverse_ratio",), value, ("gearbox.ratios",))


def compare_motor_gears(of: RelationContext) -> ComparedValues:
    """Gears behind an electric motor."""
    if of.application.electric and of.application.engine and of.application.gearbox:
        count = float(len(of.application.gearbox.ratios))
        yield ComparedValue(("prime_mover",), count, ("gearbox.ratios",))


# --- on the road


def compare_road_speed(of: RelationContext) -> ComparedValues:
    """Road speed at top speed of the gearbox output, km/h."""
    tyre = of.application.tyre
    for line in of.lines:
        axle = line.installed.axle
        if axle and tyre:
            speed = of.application.speed or of.top_speed
            speed *= line.installed.speed_ratio / axle.ratio
            value = speed * (tyre.dynamic_radius or tyre.static_radius) * 3.6
            against = ("speed" if of.application.speed else "engine.speed", "tyre.static_radius")
            yield ComparedValue((f"{line.axle}.ratio",), value, against)


def compare_governed_road_speed(of: RelationContext) -> ComparedValues:
    """Road speed at the top speed that the file gives, km/h."""
    tyre, speed = of.application.tyre, of.application.speed
    for line in of.lines:
        axle = line.installed.axle
        if axle and tyre and speed:
            radius = tyre.dynamic_radius or tyre.static_radius
            value = speed * line.installed.speed_ratio / axle.ratio * radius * 3.6
            against = ("speed", "tyre.dynamic_radius")
            yield ComparedValue((f"{line.axle}.ratio",), value, against)


def compare_gradeability(of: RelationContext) -> ComparedValues:
    """Push of the engine in its lowest gear over the weight at the largest mass."""
    tyre, gearbox = of.application.tyre, of.application.gearbox
    geared = [line for line in of.lines if line.installed.axle and line.leaves_gearbox]
    if not (tyre and geared and of.masses and of.application.engine):
        return
    line = geared[0].installed
    assert line.axle
    efficiency = line.axle.efficiency * (gearbox.efficiency if gearbox else 1.0)
    wheels = of.largest_torque * line.torque_ratio * line.axle.ratio * efficiency
    value = wheels / tyre.static_radius / (of.heaviest * t * g)
    against = ("engine.torque", f"{geared[0].axle}.ratio", of.heaviest_address)
    yield ComparedValue(("gearbox.ratios", "engine.torque"), value, against)


def compare_typical_parts(of: RelationContext) -> ComparedValues:
    """Value of a part of torsion over what is typical of the vehicle's class."""
    if of.vehicle_class is None:
        return
    application = of.application
    parts = {
        "clutch": application.clutch,
        "converter": application.converter,
        "wheels": application.wheels,
        "tyre": application.tyre,
        "axle": next((i.axle.rotors for i in application.lines if i.axle), None),
        "gearbox": application.gearbox.rotors if application.gearbox else None,
    }
    for quantity in TYPICAL_PARTS:
        part, name = quantity.split(".")
        value = getattr(parts[part], name, None)
        if isinstance(value, int | float) and value:  # 0: another number has it
            typical = typical_value(quantity, of.vehicle_class).value
            yield ComparedValue((quantity,), value / typical, (of.heaviest_address,))


def compare_shock_factor(of: RelationContext) -> ComparedValues:
    """Shock factor, if a limit is on a torque that it multiplies."""
    asked = {limit.quantity for limit in of.application.limits}
    driven = of.application.engine and of.application.vehicle
    if "joint_torque_utilisation" in asked and (driven or of.application.duty):
        yield ComparedValue(("shock_factor",), of.application.shock_factor, ("limits",))
