"""Relations between the values of shafts, joints, bearings and where a line runs."""

from collections.abc import Iterator
from itertools import pairwise
from math import nan

import numpy as np

from cardan.application.relation_context import (
    ComparedValue,
    ComparedValues,
    LineContext,
    RelationContext,
    ratio,
)
from cardan.application.source_location import locate_yaml_address
from cardan.application.typical_values import find_csv_row_by_name, shipped_csv_rows
from cardan.core.arrays import FloatArray
from cardan.core.units import GPa, MPa, deg, mm
from cardan.model.layout import Layout
from cardan.model.parts import JointKind, Tube
from cardan.physics.kinematics.joint_chain import rotate_chain

MIN_COMPARED_EQUIVALENT_ANGLE = 0.8 * deg
"""Below it a line turns evenly however its yokes stand."""

VEHICLE_PROFILES = frozenset({"body-builder", "van", "medium-truck", "heavy-truck"})
"""Profiles whose limits are for the driveline of a road vehicle."""

LEAST_COMPARED_ANGLE = 0.1 * deg
"""Equivalent angle of a line that turns evenly: what is compared with it stays a number."""

STEEL_MODULUS_RANGE = (150 * GPa, 250 * GPa)
"""Young's modulus of what is taken for steel, Pa."""

NEEDED_STROKE_SHARE = 0.3
"""Share of a spline's stroke that states use, from which a long one is for the suspension."""

LARGEST_ANGLE_OF_KIND: dict[JointKind, float] = {
    "cross": 45 * deg,
    "double cardan": 50 * deg,
    "rzeppa": 52 * deg,
    "tripod": 26 * deg,
    "flexible disc": 8 * deg,
}
"""Largest angle that joints of a kind are built for, rad.

Fixed ball joints have 47 to 52 deg, plunging tripods 23 to 26: Seherr-Thoss, Schmelz & Aucktor
(2006), unverified; others assumed. A tripod without plunge is not compared.
"""

PRINTED_SIZE_TOLERANCE = 0.01
"""Makers print the sizes of inch tubes in mm, rounded."""

ROUNDED_DIAMETER_TOLERANCE = 0.005
"""The same of a diameter: 102 for 101.6 mm."""


# --- shafts


def compare_slenderness(of: RelationContext) -> ComparedValues:
    """Length of a shaft over its tube's diameter."""
    for line in of.lines:
        for at, shaft, length in line.shafts:
            if shaft.tube:
                keys = f"{at}.length", f"{line.at}.points", f"{at}.tube.outer", f"{at}.tube"
                yield ComparedValue(keys, length / shaft.tube.outer, (f"{at}.tube",))


def compare_tube_thinness(of: RelationContext) -> ComparedValues:
    """Diameter of a tube over its wall."""
    for at, shaft, _ in of.shafts:
        tube = shaft.tube
        if tube and tube.inner > 1e-3 * tube.outer:  # a solid bar is meant
            keys = f"{at}.tube.wall", f"{at}.tube"
            yield ComparedValue(keys, tube.outer / tube.wall, (f"{at}.tube.outer",))


def compare_tube_digits(of: RelationContext) -> ComparedValues:
    """1 if a tube's diameter, of no catalogue, is one of a catalogue with two digits exchanged."""
    for at, shaft, _ in of.shafts:
        if isinstance(shaft.tube, Tube):
            outer = shaft.tube.outer / mm
            text = f"{outer:.6g}"
            others = [] if _is_catalogue_diameter(outer) else _exchanged_digits(text)
            known = next((other for other in others if _is_catalogue_diameter(float(other))), "")
            keys = f"{at}.tube.outer", f"{at}.tube"
            yield ComparedValue(keys, float(bool(known)), detail=f"{text} mm, {known} mm")


def _is_catalogue_diameter(outer: float) -> bool:
    known = {float(row["outer_mm"]) for row in shipped_csv_rows("tubes.csv")}
    return any(abs(outer / size - 1) < ROUNDED_DIAMETER_TOLERANCE for size in known)


def _exchanged_digits(number: str) -> Iterator[str]:
    """Yield a number's text with each two neighbouring digits exchanged, a point between aside."""
    places = [k for k, character in enumerate(number) if character.isdigit()]
    for a, b in pairwise(places):
        if number[a] != number[b]:
            text = list(number)
            text[a], text[b] = text[b], text[a]
            yield "".join(text)


def compare_bearing_place(of: RelationContext) -> ComparedValues:
    """Distance of a centre bearing from the rear joint over the shaft's length."""
    for line in of.lines:
        for at, shaft, length in line.shafts:
            if bearing := shaft.centre_bearing:
                keys = (f"{at}.centre_bearing.from_rear_joint",)
                against = (f"{at}.length", f"{line.at}.points")
                yield ComparedValue(keys, bearing.from_rear_joint / length, against)


def compare_shafts_alike(of: RelationContext) -> ComparedValues:
    """Longest over shortest shaft of a line, at the shorter one that is odd."""
    for line in of.lines:
        shafts = [(length, at) for at, _, length in line.shafts]
        if len(shafts) > 1:
            (shortest, at), (longest, other) = min(shafts), max(shafts)
            keys = f"{at}.length", f"{line.at}.points"
            yield ComparedValue(keys, longest / shortest, (f"{other}.length",))


def compare_spline_size(of: RelationContext) -> ComparedValues:
    """Mean diameter of a spline over the tube's."""
    for at, shaft, _ in of.shafts:
        if shaft.spline and shaft.tube and shaft.spline.mean_radius:
            keys = (f"{at}.spline.mean_radius",)
            value = 2 * shaft.spline.mean_radius / shaft.tube.outer
            yield ComparedValue(keys, value, (f"{at}.tube",))


def compare_spline_place(of: RelationContext) -> ComparedValues:
    """Place of a spline from its front joint over the shaft's length."""
    for line in of.lines:
        for at, shaft, length in line.shafts:
            if shaft.spline and shaft.spline.from_front_joint:  # 0: not given
                keys = (f"{at}.spline.from_front_joint",)
                value = shaft.spline.from_front_joint / length
                yield ComparedValue(keys, value, (f"{at}.length", f"{line.at}.points"))


def compare_spline_travel(of: RelationContext) -> ComparedValues:
    """Travel of a spline in one direction over the shaft's length."""
    for line in of.lines:
        for at, shaft, length in line.shafts:
            for name in ("plunge", "draw"):
                travel = getattr(shaft.spline, name, None)
                against = (f"{at}.length", f"{line.at}.points")
                yield ComparedValue((f"{at}.spline.{name}",), ratio(travel, length), against)


def compare_spline_balance(of: RelationContext) -> ComparedValues:
    """Travel of a spline in shortening over that in lengthening."""
    for at, shaft, _ in of.shafts:
        if shaft.spline:
            value = ratio(shaft.spline.plunge, shaft.spline.draw)
            keys = (f"{at}.spline.{'plunge' if value > 1 else 'draw'}",)
            other = f"{at}.spline.{'draw' if value > 1 else 'plunge'}"
            yield ComparedValue(keys, value, (other,))


def compare_spline_stroke(of: RelationContext) -> ComparedValues:
    """Way between a spline's stops, mm, where its states do not need so much.

    A long-travel suspension takes up a large part of a long spline; nan there.
    """
    for line in of.lines:
        used = _length_changes(line)
        for k, (at, shaft, _) in enumerate(line.shafts):
            spline = shaft.spline
            if spline and spline.plunge is not None and spline.draw is not None:
                stroke = spline.plunge + spline.draw
                needed = used is not None and used[k] > NEEDED_STROKE_SHARE * stroke
                keys = f"{at}.spline.{'plunge' if spline.plunge >= spline.draw else 'draw'}"
                others = f"{at}.spline.plunge", f"{at}.spline.draw"
                yield ComparedValue((keys,), nan if needed else stroke / mm, others)


def compare_stroke_over_diameter(of: RelationContext) -> ComparedValues:
    """Way between a spline's stops over its mean diameter, of those that are given both."""
    for at, shaft, _ in of.shafts:
        spline = shaft.spline
        if spline and spline.mean_radius and spline.plunge is not None and spline.draw is not None:
            value = (spline.plunge + spline.draw) / (2 * spline.mean_radius)
            longer = f"{at}.spline.{'plunge' if spline.plunge >= spline.draw else 'draw'}"
            others = f"{at}.spline.plunge", f"{at}.spline.draw", f"{at}.spline.mean_radius"
            yield ComparedValue((longer,), value, others)


def _length_changes(line: LineContext) -> FloatArray | None:
    """Longest less shortest of each shaft in all states, m; None if that is not known."""
    if line.in_states is None:
        return None
    lengths = line.in_states.layout.lengths
    return lengths.max(axis=-2) - lengths.min(axis=-2) if lengths.ndim == 2 else None


def compare_spline_mass(of: RelationContext) -> ComparedValues:
    """Mass of a spline over that of its tube."""
    for at, shaft, length in of.shafts:
        if shaft.spline and shaft.spline.mass and shaft.tube:
            value = shaft.spline.mass / (shaft.tube.mass_per_length * length)
            yield ComparedValue((f"{at}.spline.mass",), value, (f"{at}.tube",))


def compare_yoke_mass(of: RelationContext) -> ComparedValues:
    """Mass of a shaft's heavier yoke over that of its tube."""
    for at, shaft, length in of.shafts:
        if shaft.tube:
            tube = shaft.tube.mass_per_length * length
            value = ratio(max(shaft.yoke_mass) or None, tube)
            yield ComparedValue((f"{at}.yoke_mass",), value, (f"{at}.tube",))


def compare_yokes_alike(of: RelationContext) -> ComparedValues:
    """Mass of a shaft's heavier yoke over that of its lighter one."""
    for at, shaft, _ in of.shafts:
        value = ratio(max(shaft.yoke_mass) or None, min(shaft.yoke_mass))
        yield ComparedValue((f"{at}.yoke_mass",), value)


def compare_tubes_alike(of: RelationContext) -> ComparedValues:
    """Diameter of a shaft's tube over that of shaft 1 of its line."""
    for line in of.lines:
        tubes = [(at, shaft.tube) for at, shaft, _ in line.shafts if shaft.tube]
        for at, tube in tubes[1:]:
            keys = f"{at}.tube.outer", f"{at}.tube"
            yield ComparedValue(keys, tube.outer / tubes[0][1].outer, (f"{tubes[0][0]}.tube",))


def compare_yoke_size(of: RelationContext) -> ComparedValues:
    """Mass of a shaft's heavier yoke over the peak torque of its joint, kg per kN m."""
    for line in of.lines:
        for k, (at, shaft, _) in enumerate(line.shafts, 1):
            known = _peak_torques_of_crosses(line, k)
            value = ratio(max(shaft.yoke_mass) or None, max(known, default=nan) / 1e3)
            yield ComparedValue((f"{at}.yoke_mass",), value, (f"{line.at}.joints",))


def compare_given_inertia(of: RelationContext) -> ComparedValues:
    """Given polar inertia of a shaft over that of its tube."""
    for at, shaft, length in of.shafts:
        if shaft.tube:
            own = shaft.tube.polar_inertia_per_length * length
            value = ratio(shaft.polar_inertia_given, own)
            yield ComparedValue((f"{at}.polar_inertia",), value, (f"{at}.tube",))


def compare_strengths(of: RelationContext) -> ComparedValues:
    """Yield over ultimate strength of a tube's material."""
    for at, shaft, _ in of.shafts:
        if shaft.tube:
            m = shaft.tube.material
            keys = f"{at}.tube.material.ultimate", f"{at}.tube.material", f"{at}.tube"
            value = ratio(m.yield_strength, m.ultimate_strength)
            yield ComparedValue(keys, value, (f"{at}.tube.material.yield",))


def compare_yield_strain(of: RelationContext) -> ComparedValues:
    """Yield strength over Young's modulus of a tube's material, per mille."""
    for at, shaft, _ in of.shafts:
        if isinstance(shaft.tube, Tube):
            m = shaft.tube.material
            keys = f"{at}.tube.material.yield", f"{at}.tube.material", f"{at}.tube"
            value = 1e3 * ratio(m.yield_strength, m.youngs_modulus)
            yield ComparedValue(keys, value, (f"{at}.tube.material.youngs_modulus",))


def compare_steel_yield(of: RelationContext) -> ComparedValues:
    """Yield strength of a tube's steel, MPa."""
    low, high = STEEL_MODULUS_RANGE
    for at, shaft, _ in of.shafts:
        if isinstance(shaft.tube, Tube) and low < shaft.tube.material.youngs_modulus < high:
            keys = f"{at}.tube.material.yield", f"{at}.tube.material", f"{at}.tube"
            strength = shaft.tube.material.yield_strength
            yield ComparedValue(keys, ratio(strength, MPa))


def compare_sound_speed(of: RelationContext) -> ComparedValues:
    """Speed of sound along a bar of a tube's material, sqrt(E/rho), m/s."""
    for at, shaft, _ in of.shafts:
        if isinstance(shaft.tube, Tube):
            m = shaft.tube.material
            material = f"{at}.tube.material"
            keys = f"{material}.youngs_modulus", material, f"{at}.tube"
            value = (m.youngs_modulus / m.density) ** 0.5
            yield ComparedValue(keys, value, (f"{material}.density",))


# --- bearings


def compare_rubber_loss(of: RelationContext) -> ComparedValues:
    """Loss factor of the rubber of a centre bearing, and of all rubber of a line."""
    for line in of.lines:
        for at, shaft, _ in line.shafts:
            if shaft.centre_bearing:
                value = ratio(shaft.centre_bearing.loss_factor, 1.0)
                yield ComparedValue((f"{at}.centre_bearing.loss_factor",), value)
    if torsion := of.application.torsion:
        yield ComparedValue(("torsion.rubber_loss",), ratio(torsion.rubber_loss, 1.0))


def compare_rubber_directions(of: RelationContext) -> ComparedValues:
    """Vertical over lateral stiffness of a centre bearing."""
    for at, shaft, _ in of.shafts:
        if (bearing := shaft.centre_bearing) and bearing.stiffness:
            own = f"{at}.centre_bearing"
            keys, against = (f"{own}.vertical_stiffness",), (f"{own}.lateral_stiffness",)
            yield ComparedValue(keys, ratio(*bearing.stiffness), against)


def compare_flange_directions(of: RelationContext) -> ComparedValues:
    """Vertical over lateral stiffness of a flange."""
    for line in of.lines:
        for end in ("gearbox", "pinion"):
            flange = getattr(line.installed.line, f"{end}_flange")
            if flange.stiffness:
                own = f"{line.at}.{end}_flange"
                keys, against = (f"{own}.vertical_stiffness",), (f"{own}.lateral_stiffness",)
                yield ComparedValue(keys, ratio(*flange.stiffness), against)


def compare_rubber_bounce(of: RelationContext) -> ComparedValues:
    """Natural frequency of the shafts' weight on a centre bearing, Hz.

    Half of each shaft that meets at the bearing, with yokes and spline, on its vertical stiffness.
    """
    for line in of.lines:
        shafts = list(line.shafts)
        for k, (at, shaft, _) in enumerate(shafts[:-1]):
            bearing, pair = shaft.centre_bearing, [s for _, s, _ in shafts[k : k + 2]]
            if bearing and bearing.stiffness and all(s.tube for s in pair):
                mass = sum(s.mass for s in pair) / 2
                value = (bearing.stiffness[0] / mass) ** 0.5 / (2 * np.pi)
                keys = (f"{at}.centre_bearing.vertical_stiffness", f"{at}.centre_bearing.stiffness")
                yield ComparedValue(keys, value, (f"{at}.tube", f"{at}.yoke_mass"))


def compare_rubber_axial(of: RelationContext) -> ComparedValues:
    """Stiffness of a centre bearing along the shaft over that across it."""
    for at, shaft, _ in of.shafts:
        if (bearing := shaft.centre_bearing) and bearing.stiffness:
            value = ratio(bearing.axial_stiffness, max(bearing.stiffness))
            keys = (f"{at}.centre_bearing.axial_stiffness",)
            yield ComparedValue(keys, value, (f"{at}.centre_bearing.vertical_stiffness",))


def compare_flange_stiffness(of: RelationContext) -> ComparedValues:
    """Stiffness of a flange over that of the line's firmest rubber."""
    for line in of.lines:
        soft = [s.centre_bearing.stiffness for _, s, _ in line.shafts if s.centre_bearing]
        firm = max((max(k) for k in soft if k), default=None)
        for end in ("gearbox", "pinion"):
            flange = getattr(line.installed.line, f"{end}_flange")
            if flange.stiffness:
                keys = tuple(f"{line.at}.{end}_flange.{n}stiffness" for n in ("", "vertical_"))
                against = (f"{line.at}.shafts[1].centre_bearing",)
                yield ComparedValue(keys, ratio(min(flange.stiffness), firm), against)


# --- joints


def compare_joint_ratings(of: RelationContext) -> ComparedValues:
    """Fatigue ratings of a joint over its peak torque."""
    for line in of.lines:
        for k, joint in enumerate(line.installed.line.joints, 1):
            if joint is None:
                continue
            ratings = {"reversing": joint.reversing_torque, "pulsating": joint.pulsating_torque}
            for name, rating in ratings.items():
                keys = f"{line.at}.joints.{name}", f"{line.at}.joints[{k}].{name}"
                yield ComparedValue(keys, ratio(rating, joint.peak_torque), (f"{line.at}.joints",))


def compare_joint_bearing_rating(of: RelationContext) -> ComparedValues:
    """Torque rating of a cross's needle bearings over the joint's peak torque."""
    for line in of.lines:
        for k, joint in enumerate(line.installed.line.joints, 1):
            if joint and joint.kind in ("cross", "double cardan"):
                keys = f"{line.at}.joints.bearing_Td", f"{line.at}.joints[{k}].bearing_Td"
                rating = ratio(joint.bearing_torque, joint.peak_torque)
                yield ComparedValue(keys, rating, (f"{line.at}.joints",))


def compare_roller_rating(of: RelationContext) -> ComparedValues:
    """Torque rating of a Rzeppa or tripod joint's balls or rollers over its peak torque."""
    for line in of.lines:
        for k, joint in enumerate(line.installed.line.joints, 1):
            if joint and joint.kind in ("rzeppa", "tripod"):
                rating = ratio(joint.bearing_torque, joint.peak_torque)
                keys = f"{line.at}.joints.bearing_Td", f"{line.at}.joints[{k}].bearing_Td"
                yield ComparedValue(keys, rating, (f"{line.at}.joints[{k}].peak",))


def compare_rated_angle(of: RelationContext) -> ComparedValues:
    """Angle that a joint's life is rated at over its largest angle."""
    for line in of.lines:
        for k, joint in enumerate(line.installed.line.joints, 1):
            if joint:
                value = ratio(joint.rated_angle, joint.angle_max)
                at = f"{line.at}.joints[{k}]"
                keys = f"{at}.rated_angle", f"{line.at}.joints"
                yield ComparedValue(keys, value, (f"{at}.angle_max",))


def compare_angle_of_kind(of: RelationContext) -> ComparedValues:
    """Largest angle of a joint over that which joints of its kind are built for."""
    for line in of.lines:
        for k, joint in enumerate(line.installed.line.joints, 1):
            if joint and not (joint.kind == "tripod" and joint.plunge is None):
                value = ratio(joint.angle_max, LARGEST_ANGLE_OF_KIND[joint.kind])
                keys = f"{line.at}.joints[{k}].angle_max", f"{line.at}.joints"
                yield ComparedValue(keys, value, (f"{line.at}.joints[{k}].kind",))


def compare_joint_reserve(of: RelationContext) -> ComparedValues:
    """Peak torque of a joint over the line's largest torque with the shock factor."""
    for line in of.lines:
        share = line.installed.torque_ratio * line.installed.torque_share
        given = of.application.torque
        torque = share * of.application.shock_factor * (given or of.largest_torque)
        source = "torque" if of.application.torque is not None else "engine.torque"
        for k, joint in enumerate(line.installed.line.joints, 1):
            if joint:
                keys = f"{line.at}.joints[{k}]", f"{line.at}.joints"
                against = (source, "gearbox.ratios") if source == "engine.torque" else (source,)
                yield ComparedValue(keys, ratio(joint.peak_torque, torque or None), against)


def compare_double_cardan_distance(of: RelationContext) -> ComparedValues:
    """Distance of the crosses of a double cardan joint over the diameter of the tube next to it."""
    for line in of.lines:
        shafts = [shaft for _, shaft, _ in line.shafts]
        for k, joint in enumerate(line.installed.line.joints, 1):
            tube = shafts[min(k, len(shafts)) - 1].tube
            if joint and joint.kind == "double cardan" and tube:
                keys = f"{line.at}.joints[{k}].centre_distance", f"{line.at}.joints[{k}]"
                value = ratio(joint.centre_distance, tube.outer)
                yield ComparedValue(keys, value, (f"{line.at}.shafts[{min(k, len(shafts))}].tube",))


def compare_joints_alike(of: RelationContext) -> ComparedValues:
    """Largest over smallest peak torque of a line's crosses."""
    for line in of.lines:
        joints = line.installed.line.joints
        peaks = [j.peak_torque for j in joints if j and j.kind == "cross" and j.peak_torque]
        if len(peaks) > 1:
            yield ComparedValue((f"{line.at}.joints",), max(peaks) / min(peaks))


def compare_joint_series(of: RelationContext) -> ComparedValues:
    """Return the number of makers' series that a line's crosses are of."""
    for line in of.lines:
        crosses = [j for j in line.installed.line.joints if j and j.kind == "cross" and j.series]
        series = dict.fromkeys(j.series for j in crosses)
        if series:
            detail = ", ".join(dict.fromkeys(f"{j.name} ({j.series})" for j in crosses))
            yield ComparedValue((f"{line.at}.joints",), float(len(series)), detail=detail)


def compare_speed_angle_product(of: RelationContext) -> ComparedValues:
    """Largest speed times angle of a joint over the product of its largest speed and angle."""
    for line in of.lines:
        for k, joint in enumerate(line.installed.line.joints, 1):
            if joint and joint.speed_max and joint.angle_max:
                value = ratio(joint.speed_angle_max, joint.speed_max * joint.angle_max)
                at = f"{line.at}.joints[{k}]"
                against = f"{at}.speed_max", f"{at}.angle_max"
                yield ComparedValue((f"{at}.n_beta_max", f"{line.at}.joints"), value, against)


def _peak_torques_of_crosses(line: LineContext, shaft: int) -> list[float]:
    """Return the known peak torques, N m, of the crosses at both ends of a shaft, from 1."""
    ends = line.installed.line.joints[shaft - 1 : shaft + 1]
    return [j.peak_torque for j in ends if j and j.kind == "cross" and j.peak_torque]


def _tubes_with_crosses(
    of: RelationContext,
) -> Iterator[tuple[tuple[str, str], str, Tube, list[float]]]:
    """Yield each tube between crosses of known peak torques: their keys, its shaft's, it, they."""
    for line in of.lines:
        for k, (at, shaft, _) in enumerate(line.shafts, 1):
            peaks = _peak_torques_of_crosses(line, k)
            if peaks and isinstance(shaft.tube, Tube):
                yield (f"{line.at}.joints[{k}]", f"{line.at}.joints"), at, shaft.tube, peaks


def compare_joint_over_tube(of: RelationContext) -> ComparedValues:
    """Peak torque of a shaft's smaller cross over the torque at which its tube yields.

    Tubes yield in shear at 1/sqrt(3) of their yield strength, after von Mises.
    """
    for keys, at, tube, peaks in _tubes_with_crosses(of):
        if tube.material.yield_strength:
            shear = tube.material.yield_strength / 3**0.5
            holds = shear * 4 * tube.second_moment / tube.outer
            yield ComparedValue(keys, min(peaks) / holds, (f"{at}.tube",))


def compare_tube_at_joint_peak(of: RelationContext) -> ComparedValues:
    """Shear in a tube at the peak torque of its joints, MPa."""
    for keys, at, tube, peaks in _tubes_with_crosses(of):
        stress = min(peaks) * tube.outer / 4 / tube.second_moment
        yield ComparedValue(keys, stress / MPa, (f"{at}.tube",))


def compare_tube_for_joint(of: RelationContext) -> ComparedValues:
    """Diameter of a tube (mm) over the cube root of its joint's peak torque (N m).

    Shear at the peak torque is alike in tubes of one shape if their diameters keep to that root.
    """
    for joints, at, tube, peaks in _tubes_with_crosses(of):
        value = _diameter_for_torque(tube, max(peaks))
        yield ComparedValue((f"{at}.tube.outer", f"{at}.tube"), value, joints)


def compare_tube_for_torque(of: RelationContext) -> ComparedValues:
    """Diameter of a tube (mm) over the cube root of its torque with shocks (N m).

    Of shafts without a cross that has a peak torque.
    """
    for line in of.lines:
        share = line.installed.torque_ratio * line.installed.torque_share
        given = of.application.torque
        torque = share * of.application.shock_factor * (given or of.largest_torque)
        for k, (at, shaft, _) in enumerate(line.shafts, 1):
            rated = bool(_peak_torques_of_crosses(line, k))
            if isinstance(shaft.tube, Tube) and torque and not rated:
                tube = f"{at}.tube.outer", f"{at}.tube"
                keys, against = (tube, ("engine.torque",)) if given is None else (("torque",), tube)
                yield ComparedValue(keys, _diameter_for_torque(shaft.tube, torque), against)


def _diameter_for_torque(tube: Tube, torque: float) -> float:
    return tube.outer / mm / torque ** (1 / 3)


def compare_tube_shear(of: RelationContext) -> ComparedValues:
    """Shear in a tube under the torque that the file gives, MPa."""
    for line in of.lines:
        share = line.installed.torque_ratio * line.installed.torque_share
        for at, shaft, _ in line.shafts:
            if shaft.tube and of.application.torque:
                polar = 2 * shaft.tube.second_moment
                stress = of.application.torque * share * shaft.tube.outer / 2 / polar
                yield ComparedValue(("torque",), stress / MPa, (f"{at}.tube",))


def compare_published_joint(of: RelationContext) -> ComparedValues:
    """Peak torque of a shaft's larger joint over that of the joint a maker prints with its tube."""
    for keys, at, tube, peaks in _tubes_with_crosses(of):
        yield ComparedValue(keys, ratio(max(peaks), _published_peak(tube)), (f"{at}.tube",))


def _published_peak(tube: Tube) -> float | None:
    """Peak torque of the joint that a maker prints with a tube, N m; None if there is none."""
    for row in shipped_csv_rows("tube_joints.csv"):
        size = float(row["outer_mm"]) * mm, float(row["wall_mm"]) * mm
        if np.allclose((tube.outer, tube.wall), size, rtol=PRINTED_SIZE_TOLERANCE):
            joint, _ = find_csv_row_by_name("joints.csv", row["joint"])
            return float(joint["peak_Nm"]) if joint and joint["peak_Nm"] else None
    return None


# --- yokes


def compare_yoke_phase(of: RelationContext) -> ComparedValues:
    """Distance of a yoke phase from 0 or 90 deg, deg."""
    for at, shaft, _ in of.shafts:
        phase = shaft.phase / deg
        nearest = min((0.0, 90.0), key=lambda usual: abs(phase - usual))
        yield ComparedValue((f"{at}.phase",), abs(phase - nearest))


def compare_yokes_out_of_line(of: RelationContext) -> ComparedValues:
    """Equivalent angle of a line as its yokes stand over that with all in line."""
    for line in of.lines:
        phases = np.array(line.installed.line.phases)
        if not phases.any() or set(line.installed.line.joint_kinds) != {"cross"}:
            continue
        given, aligned = (
            float(_equivalent_angle(line, phases=p)) for p in (phases, np.zeros_like(phases))
        )
        if given < MIN_COMPARED_EQUIVALENT_ANGLE:
            continue
        for k, phase in enumerate(phases, 1):
            if phase:
                keys = (f"{line.at}.shafts[{k}].phase",)
                against = (f"{line.at}.points", f"{line.at}.slopes")
                yield ComparedValue(keys, given / max(aligned, LEAST_COMPARED_ANGLE), against)


def _equivalent_angle(line: LineContext, *, phases: FloatArray) -> FloatArray:
    """Angle of the one joint that would turn the pinion as unevenly, rad."""
    turned = rotate_chain(
        line.installed.layout.directions, phases=phases, crosses=line.installed.line.is_cross
    )
    return 2 * np.arctan(np.sqrt(np.abs(turned.phasors[..., -1])))


# --- where a line runs


def compare_lost_sign(of: RelationContext) -> ComparedValues:
    """Bend next to a member that would lie straight if its slope had another sign, deg."""
    for line in of.lines:
        given = [(line.at, line.installed.layout)]
        for k, state in enumerate(of.application.states, 1):
            name = line.installed.line.name
            if own := (state.layouts or {}).get(name):
                inside = locate_yaml_address(of.application, f"states[{k}].drivelines.{name}")
                nested = inside and inside.key.endswith(name)
                given.append((f"states[{k}]" + (f".drivelines.{name}" if nested else ""), own))
        for at, layout in given:
            yield from _lost_in(of, at, layout)


def _lost_in(of: RelationContext, at: str, layout: Layout) -> ComparedValues:
    points, side = layout.points, layout.side
    found = locate_yaml_address(of.application, f"{at}.points")
    if found and ".points" in found.key:
        ends = (f"{at}.gearbox_slope.side", 0), (f"{at}.pinion_slope.side", len(side) - 1)
        for k in range(1, len(points)):
            turned = points * np.where(np.arange(len(points))[:, None] == k, [1, 1, -1], 1)
            steps = np.diff(turned, axis=0)
            other = np.array([side[0], *np.arctan2(-steps[:, 2], steps[:, 0]), side[-1]])
            bend = _sign_bend(side, other, slice(k - 1, k + 2))
            yield ComparedValue((f"{at}.points[{k + 1}]",), bend)
    else:
        ends = tuple((f"{at}.slopes.side", k) for k in range(len(side)))
    for key, k in ends:
        other = np.where(np.arange(len(side)) == k, -side, side)
        yield ComparedValue((key,), _sign_bend(side, other, slice(max(k - 1, 0), k + 1)))


def _sign_bend(side: FloatArray, other: FloatArray, joints: slice) -> float:
    """Return the larger bend (deg) at some joints; nan where another sign is no better."""
    now, then = (float(np.abs(np.diff(s))[joints].max()) / deg for s in (side, other))
    return now if then < 3 else nan


def compare_gearbox_slope(of: RelationContext) -> ComparedValues:
    """Slope of the gearbox of a vehicle with its engine ahead of the line, deg; falling positive.

    Of combustion engines: a motor stands as its frame lets it.
    """
    application = of.application
    profile = application.profile.partition(",")[0]
    if application.electric or not (application.vehicle or profile in VEHICLE_PROFILES):
        return
    for line in of.lines:
        if line.leaves_gearbox and line.installed.drives == "rear" and not line.installed.forward:
            keys = f"{line.at}.gearbox_slope.side", f"{line.at}.slopes.side"
            slope = float(line.installed.layout.side[0]) / deg
            yield ComparedValue(keys, slope, (f"{line.at}.pinion_slope", f"{line.at}.points"))


def compare_inner_bend(of: RelationContext) -> ComparedValues:
    """Angle of a cross between two shafts in the reference state, deg."""
    for line in of.lines:
        d, kinds = line.installed.layout.directions, line.installed.line.joint_kinds
        for k in range(1, len(kinds) - 1):
            angle = float(np.arccos(np.clip(d[k] @ d[k + 1], -1, 1))) / deg
            keys = f"{line.at}.points[{k + 1}]", f"{line.at}.slopes.side", f"{line.at}"
            against = f"{line.at}.points[{k}]", f"{line.at}.points[{k + 2}]"
            yield ComparedValue(keys, angle if kinds[k] == "cross" else nan, against)


def compare_fixed_joints(of: RelationContext) -> ComparedValues:
    """Distance of a joint between two shafts in a state's points from its place in the line's, mm.

    A bearing on frame or foundation carries it. Of states with points for a line that has some.
    """
    for line in of.lines:
        given = locate_yaml_address(of.application, f"{line.at}.points")
        for k, state in enumerate(of.application.states, 1):
            own = (state.layouts or {}).get(line.installed.line.name)
            found = locate_yaml_address(of.application, f"states[{k}].points")
            if own and given and found and ".points" in given.key and ".points" in found.key:
                moved = np.linalg.norm(own.points - line.installed.layout.points, axis=-1)[1:-1]
                for n, distance in enumerate(moved.tolist(), 2):
                    keys = f"states[{k}].points[{n}]", f"states[{k}].points"
                    yield ComparedValue(keys, distance / mm, (f"{line.at}.points[{n}]",))


def compare_line_drop(of: RelationContext) -> ComparedValues:
    """Side slope from joint 1 to the last less the mean slope of gearbox and pinion, deg."""
    yield from _chord_slopes(of, view="side")


def compare_line_offset(of: RelationContext) -> ComparedValues:
    """Slope from joint 1 to the last less that of gearbox and pinion, from above, deg."""
    yield from _chord_slopes(of, view="top")


def _chord_slopes(of: RelationContext, *, view: str) -> ComparedValues:
    for line in of.lines:
        layout, crosses = line.installed.layout, line.installed.line.joint_kinds
        found = locate_yaml_address(of.application, f"{line.at}.points")
        if set(crosses) != {"cross"} or not (found and ".points" in found.key):
            continue
        across = layout.points[-1] - layout.points[0]
        if view == "side":
            chord, ends = np.arctan2(-across[2], across[0]), layout.side[[0, -1]]
        else:
            chord, ends = np.arctan2(across[1], across[0]), layout.top[[0, -1]]
        against = tuple(f"{line.at}.{end}_slope" for end in ("gearbox", "pinion"))
        value = abs(float(chord - np.mean(ends))) / deg
        keys = (f"{line.at}.points[{len(layout.points)}]", f"{line.at}.points")
        yield ComparedValue(keys, value, against)
