"""Relations between loads, wheelbase, tyre, axle, suspension and limit profile."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise
from math import nan

from cardan.application.relation_context import (
    ComparedValue,
    ComparedValues,
    LineContext,
    RelationContext,
    ratio,
)
from cardan.application.source_location import locate_yaml_address
from cardan.core.errors import DesignError
from cardan.core.units import deg, g, kN, mm
from cardan.model.application import STATE_KIND_GROUPS, VehicleState
from cardan.model.vehicle import SuspensionState
from cardan.physics.vehicle.axle_loads import driven_axle_count
from cardan.physics.vehicle.suspension import (
    deflection_in_state,
    load_per_spring,
    spring_load,
)

USUAL_PINION_AHEAD = 0.4
"""m ahead of the wheels, where a file does not say: assumed, 0.27 to 0.52 in the examples."""

UNLADEN_STATE_KINDS: tuple[SuspensionState, ...] = ("curb", "empty")
"""Kinds of state in which springs carry least on the road."""

TRAILING_ARM_PITCH = (-1.3, -0.7)
"""Pitch rate times link radius of an axle that a trailing arm holds rigidly: -1 by geometry."""

LINK_OF_HALF_LEAF = 0.75
"""Length of the equivalent link over the front half of a leaf spring: SAE J788."""

LADEN, UNLADEN = "vehicle.loads.gvw", "vehicle.loads.empty"


EXPECTED_STATES: tuple[tuple[str, ...], ...] = (
    ("empty",), ("gvw",), ("full rebound", "rebound"), ("jounce",), ("windup",)
)  # fmt: skip
"""Kinds of state that limits of a vehicle are for: of each tuple, one."""

VEHICLE_PROFILES = frozenset({"van", "medium-truck", "heavy-truck"})
"""Profiles whose limits are for a vehicle on springs."""


# --- states


def compare_missing_states(of: RelationContext) -> ComparedValues:
    """Kinds of state that a vehicle's limits expect and the file lacks."""
    application = of.application
    springs = [line.suspension[1] for line in of.lines if line.suspension]
    if not springs or application.profile.partition(",")[0] not in VEHICLE_PROFILES:
        return
    given = {state.limit_state_kind for state in application.states}
    stiff = any(spring.windup_stiffness is not None for spring in springs)
    missing = [
        kinds[0]
        for kinds in EXPECTED_STATES
        if not given.intersection(kinds) and (stiff or kinds != ("windup",))
    ]
    yield ComparedValue(("states",), float(len(missing)), ("limits",), ", ".join(missing))


def compare_states_alike(of: RelationContext) -> ComparedValues:
    """1 for each state whose values are all those of a state before it, else 0."""
    states = of.application.states
    for k, state in enumerate(states):
        at, alike = f"states[{k + 1}]", [s.name for s in states[:k] if _same_state(s, state)]
        yield ComparedValue((at,), float(bool(alike)), detail=", ".join([*alike[:1], state.name]))


def _same_state(one: VehicleState, other: VehicleState) -> bool:
    """Whether two states evaluate the same; those with points of their own are not compared."""
    if one.layouts or other.layouts:
        return False
    kinds = one.limit_state_kind, other.limit_state_kind
    return kinds[0] == kinds[1] and replace(one, name="", kind=None) == replace(
        other, name="", kind=None
    )


# --- loads


def compare_load_states_alike(of: RelationContext) -> ComparedValues:
    """1 for each load state whose values are all those of one before it, else 0."""
    vehicle = of.application.vehicle
    loads = vehicle.loads if vehicle else ()
    for k, load in enumerate(loads):
        alike = [o.name for o in loads[:k] if replace(o, name=load.name) == load]
        at = f"vehicle.loads.{load.name}"
        against = tuple(f"vehicle.loads.{name}" for name in alike[:1])
        detail = ", ".join([*alike[:1], load.name])
        yield ComparedValue((at,), float(bool(alike)), against, detail)


def compare_lighter(light: str, heavy: str) -> Callable[[RelationContext], ComparedValues]:
    """Return the relation of the mass in one load state over that in another."""

    def masses(of: RelationContext) -> ComparedValues:
        for name, other in ((light, heavy), (heavy, light)):  # either may be wrong
            at, against = f"vehicle.loads.{name}", f"vehicle.loads.{other}"
            keys = f"{at}.mass", f"{at}.front_axle", at
            value = ratio(of.masses.get(light), of.masses.get(heavy))
            yield ComparedValue(keys, value, (against,))

    return masses


def compare_centre_height(of: RelationContext) -> ComparedValues:
    """Height of the centre of gravity over the wheelbase."""
    if vehicle := of.application.vehicle:
        for load in vehicle.loads:
            keys = (f"vehicle.loads.{load.name}.cg_height",)
            value = ratio(load.cg_height, vehicle.wheelbase)
            yield ComparedValue(keys, value, ("vehicle.wheelbase",))


def compare_centre_over_tyre(of: RelationContext) -> ComparedValues:
    """Height of the centre of gravity over the tyre's radius."""
    if (vehicle := of.application.vehicle) and (tyre := of.application.tyre):
        for load in vehicle.loads:
            keys = (f"vehicle.loads.{load.name}.cg_height",)
            value = ratio(load.cg_height, tyre.static_radius)
            yield ComparedValue(keys, value, ("tyre.static_radius",))


def compare_payload_height(of: RelationContext) -> ComparedValues:
    """Height of the payload's centre of gravity over the tyre's radius."""
    vehicle, tyre = of.application.vehicle, of.application.tyre
    loads = {load.name: load for load in vehicle.loads} if vehicle else {}
    empty, laden = loads.get("empty"), loads.get("gvw")
    if not (tyre and empty and laden and empty.cg_height and laden.cg_height):
        return
    light, heavy = of.masses["empty"], of.masses["gvw"]
    moment = heavy * laden.cg_height - light * empty.cg_height
    value = ratio(ratio(moment, heavy - light), tyre.static_radius)
    yield ComparedValue((f"{LADEN}.cg_height",), value, (f"{UNLADEN}.cg_height",))


def compare_centre_rise(of: RelationContext) -> ComparedValues:
    """Height of the centre of gravity empty over that at gvw."""
    vehicle = of.application.vehicle
    loads = {load.name: load for load in vehicle.loads} if vehicle else {}
    if {"empty", "gvw"} <= set(loads):
        value = ratio(loads["empty"].cg_height, loads["gvw"].cg_height)
        yield ComparedValue((f"{UNLADEN}.cg_height",), value, (f"{LADEN}.cg_height",))


def compare_payload_place(of: RelationContext) -> ComparedValues:
    """Share of the payload that the rear axles carry."""
    vehicle = of.application.vehicle
    if vehicle is None or any(line.installed.forward for line in of.lines):
        return
    rear: dict[str, float] = {}
    for load in vehicle.loads:
        if load.rear_load is not None:
            rear[load.name] = load.rear_load / g
        elif load.mass is not None and load.cg_behind_front is not None:
            rear[load.name] = load.mass * load.cg_behind_front / vehicle.wheelbase
    if {"empty", "gvw"} <= set(rear):
        added = of.masses["gvw"] - of.masses["empty"]
        value = ratio(rear["gvw"] - rear["empty"], added)
        keys = f"{LADEN}.rear_axle", f"{LADEN}.cg_behind_front", LADEN
        yield ComparedValue(keys, value, (f"{LADEN}.front_axle", UNLADEN))


def compare_front_share(of: RelationContext) -> ComparedValues:
    """Share of the load on the front axle."""
    if vehicle := of.application.vehicle:
        for load in vehicle.loads:
            if load.front_load is not None and load.rear_load is not None:
                at = f"vehicle.loads.{load.name}"
                value = ratio(load.front_load, load.front_load + load.rear_load)
                yield ComparedValue((f"{at}.front_axle", at), value, (f"{at}.rear_axle",))


def compare_centre_place(of: RelationContext) -> ComparedValues:
    """Place of the centre of gravity behind the front axle over the wheelbase."""
    if vehicle := of.application.vehicle:
        for load in vehicle.loads:
            keys = (f"vehicle.loads.{load.name}.cg_behind_front",)
            value = ratio(load.cg_behind_front, vehicle.wheelbase)
            yield ComparedValue(keys, value, ("vehicle.wheelbase",))


def compare_axle_weight(of: RelationContext) -> ComparedValues:
    """Load of each axle, t."""
    if vehicle := of.application.vehicle:
        for load in vehicle.loads:
            at = f"vehicle.loads.{load.name}"
            front = ratio(load.front_load, vehicle.front_group * kN * g)
            rear = ratio(load.rear_load, vehicle.rear_group * kN * g)
            yield ComparedValue((f"{at}.front_axle",), front, ("vehicle.drive",))
            yield ComparedValue((f"{at}.rear_axle",), rear, ("vehicle.drive",))


def compare_profile_mass(profile: str) -> Callable[[RelationContext], ComparedValues]:
    """Return the relation of the largest mass, t, to the profile that limits are from."""

    def mass(of: RelationContext) -> ComparedValues:
        if of.application.profile.partition(",")[0] == profile:
            yield ComparedValue(("limits",), of.heaviest, (of.heaviest_address,))

    return mass


# --- wheels and axle


def compare_tyre_size(of: RelationContext) -> ComparedValues:
    """Radius of the loaded tyre, mm."""
    if tyre := of.application.tyre:
        value = tyre.static_radius / mm
        yield ComparedValue(("tyre.static_radius",), value, (of.heaviest_address,))


def compare_rolling_radius(of: RelationContext) -> ComparedValues:
    """Radius of the tyre as it rolls over that as it stands."""
    if tyre := of.application.tyre:
        value = ratio(tyre.dynamic_radius, tyre.static_radius)
        yield ComparedValue(("tyre.dynamic_radius",), value, ("tyre.static_radius",))


def compare_pinion_ahead(of: RelationContext) -> ComparedValues:
    """Distance of the last joint ahead of the wheel centre, in tyre radii."""
    for line in of.lines:
        axle, tyre = line.installed.axle, of.application.tyre
        if axle and tyre and axle.pinion_joint[0]:
            keys = f"{line.axle}.pinion.ahead", f"{line.axle}.pinion.behind"
            value = -axle.pinion_joint[0] / tyre.static_radius
            yield ComparedValue(keys, value, ("tyre.static_radius",))


def compare_pinion_height(of: RelationContext) -> ComparedValues:
    """Height of a through-driven axle's joint from the wheel centre, in tyre radii."""
    yield from _pinion_heights(of, several=True)


def compare_single_pinion_height(of: RelationContext) -> ComparedValues:
    """Height of a single driven axle's joint from the wheel centre, in tyre radii."""
    yield from _pinion_heights(of, several=False)


def _pinion_heights(of: RelationContext, *, several: bool) -> ComparedValues:
    """Through drives raise the pinion of the axle ahead."""
    for line in of.lines:
        axle, tyre, vehicle = line.installed.axle, of.application.tyre, of.application.vehicle
        single = vehicle is not None and vehicle.driven_rear <= 1
        if axle and tyre and several != single:
            keys = f"{line.axle}.pinion.above", f"{line.axle}.pinion.below"
            value = abs(axle.pinion_joint[1]) / tyre.static_radius
            yield ComparedValue(keys, value, ("tyre.static_radius",))


def compare_output_behind(of: RelationContext) -> ComparedValues:
    """Distance of joint 1 behind the wheels of the axle it leaves, in tyre radii."""
    yield from _output_joints(of, 0, ("behind", "ahead"))


def compare_output_height(of: RelationContext) -> ComparedValues:
    """Height of joint 1 above the wheels of the axle it leaves, in tyre radii."""
    yield from _output_joints(of, 1, ("above", "below"))


def _output_joints(of: RelationContext, axis: int, ways: tuple[str, str]) -> ComparedValues:
    for line in of.lines:
        joint, tyre = line.installed.output_joint, of.application.tyre
        if joint and tyre:
            keys = tuple(f"{line.at}.output_joint.{way}" for way in ways)
            value = joint[axis] / tyre.static_radius
            yield ComparedValue(keys, value, ("tyre.static_radius",))


def compare_transfer_case_reach(of: RelationContext) -> ComparedValues:
    """Reach of the lines to the front and the rear axle together over the wheelbase.

    Both leave a transfer case; its outputs stand apart by no more than its own length.
    """
    vehicle = of.application.vehicle
    reach: dict[str, list[tuple[LineContext, float]]] = {"front": [], "rear": []}
    for line in of.lines:
        axle = line.installed.axle
        if vehicle and axle and line.leaves_gearbox and line.installed.drives in reach:
            x = line.installed.layout.points[:, 0]
            length = float(x[-1] - x[0]) - axle.pinion_joint[0]
            reach[line.installed.drives].append((line, length))
    if vehicle and all(len(some) == 1 for some in reach.values()) and vehicle.rear_group == 1:
        (front, ahead), (rear, behind) = reach["front"][0], reach["rear"][0]
        value = (ahead + behind) / vehicle.wheelbase
        yield ComparedValue(
            ("vehicle.wheelbase",), value, (f"{front.at}.points", f"{rear.at}.points")
        )


def compare_line_reach(of: RelationContext) -> ComparedValues:
    """Length from joint 1 to the axle over the wheelbase."""
    for line in of.lines:
        vehicle, axle = of.application.vehicle, line.installed.axle
        if vehicle and line.installed.drives == "rear" and not line.installed.forward:
            x = line.installed.layout.points[:, 0]
            ahead = -axle.pinion_joint[0] if axle else 0.0
            value = (x[-1] - x[0] + ahead) / vehicle.wheelbase
            yield ComparedValue(("vehicle.wheelbase",), value, (f"{line.at}.points",))


def compare_gearbox_place(of: RelationContext) -> ComparedValues:
    """Distance of joint 1 behind the front axle, m, as wheelbase and line say."""
    vehicle = of.application.vehicle
    rear = [
        line
        for line in of.lines
        if line.installed.drives == "rear" and line.leaves_gearbox and not line.installed.forward
    ]
    if vehicle and len(rear) == 1:
        line = rear[0].installed
        x = line.layout.points[:, 0]
        behind = line.axle.pinion_joint[0] if line.axle else -USUAL_PINION_AHEAD
        value = vehicle.wheelbase - (x[-1] - x[0]) + behind
        against = (f"{rear[0].at}.points", f"{rear[0].at}.shafts[1].length",
                   f"{rear[0].axle}.pinion")  # fmt: skip
        yield ComparedValue(("vehicle.wheelbase",), float(value), against)


# --- suspension


def compare_unsprung_mass(of: RelationContext) -> ComparedValues:
    """Unsprung mass over what its axle carries."""
    for line in of.lines:
        if line.suspension and line.reference and line.suspension[1].unsprung_mass:
            at, suspension = line.suspension
            load = float(line.reference.axle_load[0])
            value = ratio(suspension.unsprung_mass * g, load)
            yield ComparedValue((f"{at}.unsprung_mass",), value, (LADEN,))


def compare_ride_frequency(of: RelationContext) -> ComparedValues:
    """Natural frequency on the springs at gvw, Hz."""
    for line in of.lines:
        if line.suspension and line.laden:
            at = line.suspension[0]
            keys = f"{at}.spring.rates", f"{at}.spring.load", f"{at}.spring"
            value = float(line.laden.suspension_frequency[0])
            yield ComparedValue(keys, value, (f"{at}.springs_per_axle", LADEN))


def compare_spring_progression(of: RelationContext) -> ComparedValues:
    """Second over first rate of a spring that is given by its rates."""
    for line in of.lines:
        at, suspension = line.suspension or ("", None)
        if suspension and _has_helper(of, at):
            load, travel = suspension.spring.load, suspension.spring.deflection
            first, second = (
                (load[k + 1] - load[k]) / (travel[k + 1] - travel[k]) for k in range(2)
            )
            keys = (f"{at}.spring.rates", f"{at}.spring")
            yield ComparedValue(keys, second / first)


def compare_spring_steps(of: RelationContext) -> ComparedValues:
    """Rate of each part of a spring's table over that of the part before."""
    for line in of.lines:
        at, suspension = line.suspension or ("", None)
        if suspension and not _has_helper(of, at):
            load, travel = suspension.spring.load, suspension.spring.deflection
            rates = [
                ratio(b - a, y - x)
                for (a, b), (x, y) in zip(pairwise(load), pairwise(travel), strict=True)
            ]
            for k, (first, second) in enumerate(pairwise(rates), 2):
                keys = f"{at}.spring.load[{k}]", f"{at}.spring.load", f"{at}.spring"
                yield ComparedValue(keys, ratio(second, first), (f"{at}.spring.deflection",))


def compare_helper_contact(of: RelationContext) -> ComparedValues:
    """Deflection at gvw over that at which the second rate begins."""
    for line in of.lines:
        at, suspension = line.suspension or ("", None)
        if suspension and line.laden and _has_helper(of, at):
            with suppress(DesignError):
                load = float(line.laden.axle_load[0])
                rest = float(deflection_in_state(suspension, "gvw", axle_load=load))
                value = ratio(rest, suspension.spring.deflection[1])
                against = (f"{at}.spring.rates", LADEN)
                yield ComparedValue((f"{at}.spring.contact",), value, against)


def _has_helper(of: RelationContext, suspension: str) -> bool:
    """Whether a suspension's spring is given by two rates and where the second begins."""
    found = locate_yaml_address(of.application, f"{suspension}.spring.contact")
    return found is not None and ".contact" in found.key


def compare_leaf_length(of: RelationContext) -> ComparedValues:
    """Front half length of a leaf spring, mm."""
    for line in of.lines:
        at, suspension = line.suspension or ("", None)
        key = f"{at}.linkage.front_half_length"
        found = locate_yaml_address(of.application, key)
        if suspension and found and "front_half_length" in found.key:
            half = ratio(suspension.linkage.radius, LINK_OF_HALF_LEAF * mm)
            yield ComparedValue((key,), half, (LADEN,))


def compare_link_length(of: RelationContext) -> ComparedValues:
    """Length of a rear axle's equivalent link over the wheelbase."""
    for line in of.lines:
        at, suspension = line.suspension or ("", None)
        if suspension and of.application.vehicle and line.installed.drives == "rear":
            keys = f"{at}.linkage.radius", f"{at}.linkage.front_half_length", f"{at}.linkage"
            value = ratio(suspension.linkage.radius, of.application.vehicle.wheelbase)
            yield ComparedValue(keys, value, ("vehicle.wheelbase",))


def compare_link_angle(of: RelationContext) -> ComparedValues:
    """Angle of a rear axle's equivalent link on the road, pivot above the axle positive, deg."""
    for line in of.lines:
        at, suspension = line.suspension or ("", None)
        rides = suspension and suspension.reference in STATE_KIND_GROUPS["riding"]
        if suspension and rides and suspension.linkage.radius and line.installed.drives == "rear":
            value = suspension.linkage.angle / deg
            yield ComparedValue((f"{at}.linkage.angle",), value)


def compare_pitch_rate(of: RelationContext) -> ComparedValues:
    """Pitch of a rear axle for each mm that it rises, deg/mm."""
    for line in of.lines:
        at, suspension = line.suspension or ("", None)
        if suspension and suspension.linkage.radius and line.installed.drives == "rear":
            link = suspension.linkage
            low, high = TRAILING_ARM_PITCH
            held = low <= link.pitch_rate * (link.radius or nan) <= high
            value = nan if held else link.pitch_rate / deg * mm
            against = (f"{at}.linkage.front_half_length", f"{at}.linkage.radius")
            yield ComparedValue((f"{at}.linkage.pitch_rate",), value, against)


def compare_pitch_for_link(of: RelationContext) -> ComparedValues:
    """Pitch of a rear axle on its link over that of a rigid arm of the link's length.

    0 for links that keep the pitch; else unequal halves of a leaf, or rods that converge.
    """
    for line in of.lines:
        at, suspension = line.suspension or ("", None)
        if suspension and line.installed.drives == "rear" and suspension.linkage.pitch_rate:
            link = suspension.linkage
            value = abs(link.pitch_rate) * (link.radius or nan)
            against = (f"{at}.linkage.front_half_length", f"{at}.linkage.radius")
            yield ComparedValue((f"{at}.linkage.pitch_rate",), value, against)


def compare_axle_windup(of: RelationContext) -> ComparedValues:
    """Pitch of the axle under its largest torque, deg."""
    for line in of.lines:
        axle, vehicle = line.installed.axle, of.application.vehicle
        if not (line.suspension and line.reference and axle):
            continue
        at, suspension = line.suspension
        behind = driven_axle_count(vehicle, drives=line.installed.drives) if vehicle else 1
        torque = float(line.reference.torque[0]) * axle.ratio * axle.efficiency
        torque = ratio(torque, behind * line.installed.load_share)
        value = ratio(torque, suspension.windup_stiffness) / deg
        against = ("engine.torque", f"{line.axle}.ratio")
        yield ComparedValue((f"{at}.windup_stiffness",), value, against)


def compare_leaf_windup(of: RelationContext) -> ComparedValues:
    """Wind-up stiffness of an axle over that of its leaf springs as pairs of cantilevers.

    Halves of length a with half of a spring's last rate k each: K = k a^2 for each spring.
    """
    for line in of.lines:
        at, suspension = line.suspension or ("", None)
        key = f"{at}.linkage.front_half_length"
        found = locate_yaml_address(of.application, key)
        if suspension and found and "front_half_length" in found.key:
            spring, half = suspension.spring, (suspension.linkage.radius or nan) / LINK_OF_HALF_LEAF
            rate = ratio(
                spring.load[-1] - spring.load[-2], spring.deflection[-1] - spring.deflection[-2]
            )
            value = ratio(suspension.windup_stiffness, suspension.springs_per_axle * rate * half**2)
            yield ComparedValue((f"{at}.windup_stiffness",), value, (f"{at}.spring", key))


def compare_brake_hold(of: RelationContext) -> ComparedValues:
    """Brake torque on an axle over what its tyres hold at gvw."""
    for line in of.lines:
        tyre, (at, suspension) = of.application.tyre, line.suspension or ("", None)
        if suspension and tyre and line.laden and suspension.brake_torque:
            holds = tyre.friction * float(line.laden.axle_load[0]) * tyre.static_radius
            against = ("tyre.friction", LADEN)
            value = suspension.brake_torque / holds
            yield ComparedValue((f"{at}.brake_torque",), value, against)


def compare_given_travel(of: RelationContext) -> ComparedValues:
    """Travel or articulation of a state over the way between the stops; nan where it is 0."""
    for line in of.lines:
        at, suspension = line.suspension or ("", None)
        low = suspension.full_rebound_deflection if suspension else None
        high = suspension.jounce_deflection if suspension else None
        if low is None or high is None:
            continue
        against = (f"{at}.full_rebound_deflection", f"{at}.jounce_deflection")
        for k, state in enumerate(of.application.states, 1):
            for name, moved in (("travel", state.travel), ("articulation", state.articulation)):
                value = ratio(abs(moved or nan), high - low)
                yield ComparedValue((f"states[{k}].{name}",), value, against)


def compare_stop_distance(name: str, sign: int) -> Callable[[RelationContext], ComparedValues]:
    """Return the relation of a stop's place to where the axle stands, mm."""

    def distance(of: RelationContext) -> ComparedValues:
        for line in of.lines:
            if not (line.suspension and line.reference):
                continue
            at, suspension = line.suspension
            key, stop = f"{at}.{name}_deflection", getattr(suspension, f"{name}_deflection")
            if stop is None and name == "jounce" and suspension.spring.ends:
                key, stop = f"{at}.spring.deflection", suspension.spring.deflection[-1]
            load = float(line.reference.axle_load[0])
            with suppress(DesignError):
                rest = deflection_in_state(suspension, suspension.reference, axle_load=load)
                if stop is not None and suspension.reference not in (name, "rebound"):
                    value = 1e3 * sign * (stop - float(rest))
                    yield ComparedValue((key,), value, (f"{at}.spring", LADEN))

    return distance


def compare_stop_load(of: RelationContext) -> ComparedValues:
    """Load of a spring at its bump stop over that at gvw."""
    for line in of.lines:
        at, suspension = line.suspension or ("", None)
        if suspension and line.laden:
            own = float(load_per_spring(suspension, float(line.laden.axle_load[0])))
            keys = f"{at}.spring.rates", f"{at}.spring.load", f"{at}.spring"
            against = f"{at}.jounce_deflection", f"{at}.springs_per_axle", LADEN
            with suppress(DesignError):
                stop = float(
                    spring_load(suspension.spring, deflection_in_state(suspension, "jounce"))
                )
                yield ComparedValue(keys, ratio(stop, own), against)


def compare_unladen_strap(of: RelationContext) -> ComparedValues:
    """Distance that the axle can sink from where it stands unladen, mm."""
    kinds = {state.kind for state in of.application.states}
    for line in of.lines:
        at, suspension = line.suspension or ("", None)
        strap = suspension.full_rebound_deflection if suspension else None
        for kind in UNLADEN_STATE_KINDS:
            stands = line.standing(kind) if kind in kinds else None
            if suspension and strap is not None and stands and suspension.reference != kind:
                load = float(stands.axle_load[0])
                with suppress(DesignError):
                    rest = float(deflection_in_state(suspension, kind, axle_load=load))
                    value = 1e3 * (rest - strap)
                    against = (f"{at}.spring", f"vehicle.loads.{kind}")
                    yield ComparedValue((f"{at}.full_rebound_deflection",), value, against)
