"""Forces on bearings, joints and spline."""

from collections.abc import Callable
from functools import partial

import numpy as np

from cardan.checks.line_response import LineResponse
from cardan.checks.operating_point_results import OperatingPointResults
from cardan.checks.quantities.declaration import (
    NEEDS_MOUNT_STIFFNESS,
    NEEDS_SHAFT_LENGTHS,
    NEEDS_SPEED_ZERO_ALLOWED,
    NEEDS_SPLINE_RADIUS,
    NEEDS_TORQUE,
    NEEDS_TORQUE_WEIGHT_OR_UNBALANCE,
    PartSelector,
    Quantity,
    QuantityFunction,
    Requirement,
    all_centre_bearings,
    all_joints,
    last_shaft,
    line_on_rubber,
    make_whole_line_quantity_function,
)
from cardan.core.arrays import BoolArray, FloatArray, stack_on_last_axis
from cardan.core.labels import Part
from cardan.core.provenance import GWB_CATALOGUE, ISO_21940_11, SOURCE_DERIVED, Source
from cardan.core.verdict import Limit


def _lettered(letters: str) -> PartSelector:
    return lambda _: tuple(Part("bearing", letter) for letter in letters)


def _end_bearings(letters: str) -> QuantityFunction:
    return lambda r: stack_on_last_axis(
        r.rigid_loads.end_bearing_forces[letter] for letter in letters
    )


def _rated(letters: str, end: str) -> PartSelector:
    """Return the function that finds which bearings of an end are rated: both or none."""
    return lambda r: (
        _lettered(letters)(r) if getattr(r.line, f"{end}_bearing_rating") is not None else ()
    )


def _within_rating(quantity: str) -> Limit:
    """Return the limit of a share of a rating that an application gives."""
    source = Source(
        "By definition of the rating, which the application gives", how_read="by definition"
    )
    return Limit(quantity=quantity, maximum=1.0, source=source)


def _end_bearing_utilisation(letters: str, end: str) -> QuantityFunction:
    """Return how to compute the worst force on each bearing of an end over its rating.

    At any operating point on rigid centre bearings, and what shakes the joint on rubber by its
    lever on the bearing: an upper estimate, as if both were largest at one place of the turn.
    """

    def utilisation(r: LineResponse) -> FloatArray:
        line = r.line
        rating, spacing, overhang = (
            getattr(line, f"{end}_bearing_{name}") for name in ("rating", "spacing", "overhang")
        )
        force = _end_bearings(letters)(r)
        if rating is None:
            return force[..., :0]
        if spacing is None or overhang is None:
            return force  # nan
        if r.operating_envelope is not None:
            there = _end_bearings(letters)(r.operating_envelope.response)
            there = there[:, 0] if force.ndim == 2 else there
            force = np.fmax(force, np.fmax.reduce(there, axis=0))
        far, near = overhang / spacing, (spacing + overhang) / spacing
        order = (far, near) if letters == "AB" else (near, far)
        held = rating if letters == "AB" else rating[::-1]
        shaken = r.mount_loads.worst_joint_forces
        if shaken is not None:
            joint = shaken.results.dynamic[..., 0 if end == "gearbox" else -1]
            force = force + joint[..., None] * stack_on_last_axis(order)
        return force / stack_on_last_axis(held)

    return utilisation


def _quasi_static(letters: str) -> dict[str, QuantityFunction]:
    return {
        "quasi_static": lambda r: stack_on_last_axis(
            r.rigid_loads.static_end_bearing_forces[k] for k in letters
        )
    }


def _placed(end: str) -> Requirement:
    return Requirement(
        required_input=f"{end}_bearing_spacing_mm and {end}_bearing_overhang_mm",
        is_met=lambda r: np.array([[
            None not in (getattr(r.line, f"{end}_bearing_{k}") for k in ("spacing", "overhang"))
        ]]),
    )  # fmt: skip


def _of_joints(r: LineResponse) -> FloatArray:
    """Return what shakes each joint on rubber, (..., S, n) N; nan where unknown.

    On rigid bearings that is what statics gives at the state's own torque.
    """
    worst = r.mount_loads.worst_joint_forces
    if worst is None and r.mounts.is_rigid and r.line.joint_count > 2:
        return r.rigid_loads.joint_loads.joint_forces.dynamic
    return np.full(r.joint_angles.shape, np.nan) if worst is None else worst.results.dynamic


def _growth(r: LineResponse) -> FloatArray:
    """Return how a line's swinging goes on at worst, (..., S) 1/s; nan where unknown."""
    worst = r.mount_loads.worst_growth_rate
    shape = r.joint_angles.shape[:-1]
    return np.full(shape, np.nan) if worst is None else worst.results.growth[..., 0]


def _on_own_rubber(r: LineResponse) -> list[int]:
    """Return which bearings, from 0, hang in rubber that gives."""
    return [k for k, b in enumerate(r.line.centre_bearings) if b.stiffness]


def _stopped(r: LineResponse) -> list[int]:
    """Return which bearings, from 0, have a known stop."""
    return [k for k, b in enumerate(r.line.centre_bearings) if b.travel is not None]


def _bearings(which: Callable[[LineResponse], list[int]]) -> PartSelector:
    return lambda r: tuple(Part("centre bearing", k + 1) for k in which(r))


def _travel(r: LineResponse) -> FloatArray:
    """Return how far each bearing goes across its rubber, (..., S, n-2) m; nan if unknown."""
    worst = r.mount_loads.worst_bearing_travel
    shape = *r.joint_angles.shape[:-1], r.line.joint_count - 2
    return np.full(shape, np.nan) if worst is None else worst.results.peak


def _over_stop(r: LineResponse) -> FloatArray:
    """Return that over how far the rubber goes, of those bearings where it is given."""
    which = _stopped(r)
    if not which:  # and then it is not sought
        return np.empty((*r.joint_angles.shape[:-1], 0))
    return _travel(r)[..., which] / r.mount_loads.mount_stop_travel[..., which]


def _where_farthest(
    which: Callable[[LineResponse], list[int]],
) -> Callable[[LineResponse], OperatingPointResults | None]:
    """Return the function that finds where bearings go farthest, each by itself."""

    def sought(r: LineResponse) -> OperatingPointResults | None:
        chosen = which(r)
        return (
            r.mount_loads.worst_bearing_travel.for_bearings(chosen)
            if chosen and r.mount_loads.worst_bearing_travel
            else None
        )

    return sought


NEEDS_STABLE_LINE = Requirement(
    required_input="a line whose swinging on its rubber does not grow (swing_growth)",
    is_met=lambda r: ~(_growth(r)[..., None] > 0),
)
"""Where swinging grows by itself no steady force is an answer."""


def _of_stroke(r: LineResponse, name: str) -> FloatArray:
    """Return what thrust does over the stroke, (..., S, 1); nan of a line not on rubber."""
    found = r.mounts.stroke_thrust
    shape = r.joint_angles.shape[:-1]
    return (np.full(shape, np.nan) if found is None else getattr(found, name))[..., None]


def _dead_load(r: LineResponse) -> FloatArray:
    """Return what bearings carry under the whole slip force, (..., S, n-2) N."""
    found = r.mounts.stroke_thrust
    shape = *r.joint_angles.shape[:-1], r.line.joint_count - 2
    return np.full(shape, np.nan) if found is None else found.dead_load


NEEDS_THRUST_EQUILIBRIUM = Requirement(
    required_input="states full rebound and bump (`jounce`): the spline's slip force passes the "
    "line's critical compression, and only the suspension's stroke limits it",
    is_met=lambda r: (
        np.array([[True]])
        if r.mounts.stroke_thrust is None
        else r.mounts.stroke_thrust.is_evaluated[..., None]
    ),
)
"""Where friction holds more than the line on its rubber can carry."""


def _within_stop(r: LineResponse, kind: str) -> BoolArray:
    """Return whether rubber stays within a stop that is known, or is solved with it, (..., n-2)."""
    worst = r.mount_loads.worst_bearing_travel if _stopped(r) else None
    if worst is None:
        return np.ones((1, 1), dtype=bool)
    beyond = getattr(worst.results, kind) > r.mount_loads.mount_stop_travel
    return ~beyond | r.mount_loads.is_solved_at_stop


NEEDS_MEAN_WITHIN_STOP, NEEDS_PEAK_WITHIN_STOP = (
    Requirement(
        required_input="rubber that stays within its stop (travel_mm): beyond it linear rubber "
        "says too little",
        is_met=partial(_within_stop, kind=kind),
        leaves_lower_bound=True,
    )
    for kind in ("static", "peak")
)
"""Beyond its stop rubber is 5 to 20 times as stiff: the crest is higher, and at another speed."""


def _any_stop_margin(r: LineResponse) -> FloatArray:
    """Return the share of the travel to a stop that the nearest bearing has left, (..., S, 1)."""
    return r.mount_loads.stop_margin("peak").min(axis=-1, keepdims=True, initial=1.0)


_TO_TRAVEL = (
    NEEDS_SHAFT_LENGTHS,
    NEEDS_TORQUE,
    NEEDS_SPEED_ZERO_ALLOWED,
    NEEDS_MOUNT_STIFFNESS,
    NEEDS_STABLE_LINE,
    NEEDS_THRUST_EQUILIBRIUM,
)

_TO_THRUST = (
    NEEDS_SHAFT_LENGTHS,
    NEEDS_TORQUE,
    NEEDS_SPLINE_RADIUS,
    NEEDS_MOUNT_STIFFNESS,
)

_ON_RUBBER = (
    "At the worst operating point of the state, from standstill to top speed in every gear and "
    "direction, on the rubber: a steady response, which passing quickly does not reach. A bearing "
    "without a stiffness is rigid and carries the static force at any speed: on rubber, where an "
    "order is in resonance with a mode, it is several times as large. Rubber is linear up to its "
    "stop (15 mm, assumed, where travel_mm is not given), and 5 to 20 times as stiff beyond it "
    "(assumed): the largest motion that is stable, by harmonic balance. If that is not solved, "
    "limits hold a lower bound, which never passes."
)


def _rated_end_bearings(
    letters: str, end: str, *, name: str, equation: str, validity: str
) -> Quantity:
    """Return the utilisation of the rated bearings, `letters`, of an end of the line."""
    return Quantity(
        key=f"{end}_bearing_utilisation",
        name=name,
        symbol="F/F0",
        unit="1",
        equation=equation,
        symbol_meanings={
            ", ".join(
                f"F{x}" for x in letters
            ): f"largest force at any operating point ({end}_bearing_force)",
            "Fk": "what shakes the joint on rubber (joint_dynamic); 0 on rigid centre bearings",
            "a, b": "spacing of the bearings, overhang of the joint beyond the nearer one",
            "F0": "rating of the bearing: radial force that the line may put on it",
        },
        source=SOURCE_DERIVED,
        validity=validity,
        compute=_end_bearing_utilisation(letters, end),
        validity_margin=_any_stop_margin,
        depends_on_mounts=True,
        parts=_rated(letters, end),
        limit_by_definition=_within_rating(f"{end}_bearing_utilisation"),
        requirements=(
            NEEDS_SHAFT_LENGTHS,
            NEEDS_TORQUE_WEIGHT_OR_UNBALANCE,
            NEEDS_SPEED_ZERO_ALLOWED,
            NEEDS_MOUNT_STIFFNESS,
            _placed(end),
        ),
        section="Gearbox, axle and spline",
    )


DECLARATIONS = (
    Quantity(
        key="centre_bearing_static",
        name="Centre bearing, static force",
        symbol="Fs",
        unit="N",
        equation="Fs = |mean over a turn of the force on the bearing|, at the worst thrust",
        symbol_meanings={
            "worst thrust": "of the sliding fit: none, or what the suspension's stroke reaches "
            "either way within the slip force, at the place where the axle then is; of a line "
            "whose stroke is unknown the whole slip force"
        },
        source=SOURCE_DERIVED,
        validity=_ON_RUBBER,
        compute=lambda r: r.mount_loads.evaluated_force("static"),
        validity_margin=lambda r: r.mount_loads.force_validity_margin("static"),
        lower_bound=lambda r: r.mount_loads.force_at_stop("static"),
        find_worst_points=lambda r: r.mount_loads.points_of_evaluated_force("static"),
        depends_on_mounts=True,
        parts=all_centre_bearings,
        requirements=(
            NEEDS_SHAFT_LENGTHS,
            NEEDS_TORQUE_WEIGHT_OR_UNBALANCE,
            NEEDS_STABLE_LINE,
            NEEDS_THRUST_EQUILIBRIUM,
            NEEDS_MEAN_WITHIN_STOP,
        ),
        section="Centre bearings",
        approximations={
            "rigid": lambda r: np.linalg.norm(
                r.rigid_loads.joint_loads.bearing_forces.static, axis=-1
            ),
            "small_angle": lambda r: np.linalg.norm(
                r.rigid_loads.small_angle_bearing_forces[0], axis=-1
            ),
        },
    ),
    Quantity(
        key="centre_bearing_dynamic",
        name="Centre bearing, dynamic force",
        symbol="Fd",
        unit="N",
        equation="Fd = F2 + F4 + F6, F = k (1 + iη) c,  [K (1 + iη) + T K_T + i W G − W² M] q = f",
        symbol_meanings={
            "F2, F4, F6": "0-to-peak along the major axis of the force ellipse of each order",
            "k, η": "stiffness and loss factor of the rubber",
            "c": "motion at the bearing, of the line's coordinates q",
            "K, M, G": "stiffness of rubber and tubes, mass, gyroscope",
            "K_T": "stiffness of the torque T, whose moments turn with the shafts",
            "f, W": "the crosses' moments on the shafts, whose rear yokes torque turns back by "
            "T L / (G J), and their frequency",
        },
        source=SOURCE_DERIVED,
        validity=_ON_RUBBER,
        compute=lambda r: r.mount_loads.evaluated_force("dynamic"),
        validity_margin=lambda r: r.mount_loads.force_validity_margin("dynamic"),
        lower_bound=lambda r: r.mount_loads.force_at_stop("dynamic"),
        unproved_margin=lambda r, most: r.mount_loads.unproved_margin("dynamic", most),
        find_worst_points=lambda r: r.mount_loads.points_of_evaluated_force("dynamic"),
        has_resonance=True,
        depends_on_mounts=True,
        parts=all_centre_bearings,
        requirements=(
            NEEDS_SHAFT_LENGTHS,
            NEEDS_TORQUE,
            NEEDS_SPEED_ZERO_ALLOWED,
            NEEDS_MOUNT_STIFFNESS,
            NEEDS_STABLE_LINE,
            NEEDS_PEAK_WITHIN_STOP,
        ),
        section="Centre bearings",
        approximations={
            "rigid": lambda r: r.rigid_loads.joint_loads.bearing_forces.dynamic,
            "small_angle": lambda r: r.rigid_loads.small_angle_bearing_forces[1],
        },
    ),
    Quantity(
        key="centre_bearing_peak",
        name="Centre bearing, peak force",
        symbol="Fp",
        unit="N",
        equation="Fp = Fs + Fd + F1",
        symbol_meanings={
            "Fs, Fd": "static and dynamic force",
            "F1": "0-to-peak of the unbalance, if it is evaluated",
        },
        source=SOURCE_DERIVED,
        validity=_ON_RUBBER,
        compute=lambda r: r.mount_loads.evaluated_force("peak"),
        validity_margin=lambda r: r.mount_loads.force_validity_margin("peak"),
        lower_bound=lambda r: r.mount_loads.force_at_stop("peak"),
        unproved_margin=lambda r, most: r.mount_loads.unproved_margin("peak", most),
        find_worst_points=lambda r: r.mount_loads.points_of_evaluated_force("peak"),
        has_resonance=True,
        depends_on_mounts=True,
        parts=all_centre_bearings,
        requirements=(
            NEEDS_SHAFT_LENGTHS,
            NEEDS_TORQUE_WEIGHT_OR_UNBALANCE,
            NEEDS_SPEED_ZERO_ALLOWED,
            NEEDS_MOUNT_STIFFNESS,
            NEEDS_STABLE_LINE,
            NEEDS_THRUST_EQUILIBRIUM,
            NEEDS_PEAK_WITHIN_STOP,
        ),
        section="Centre bearings",
        approximations={"rigid": lambda r: r.rigid_loads.rigid_bearing_peaks},
    ),
    Quantity(
        key="centre_bearing_travel",
        name="Centre bearing, travel",
        symbol="u",
        unit="mm",
        equation="u = us + u2 + u4 + u6 + u1,  us = |(Fv/kv, Fl/kl)|, of an order F / (k (1 + iη))",
        symbol_meanings={
            "us": "of torque and worst thrust; weight set the line where it hangs before",
            "v, l": "vertical and lateral, across the shaft",
            "u2, u4, u6": "0-to-peak along the major axis of the ellipse of each order",
            "u1": "of the unbalance, if it is evaluated",
            "k, η": "stiffness and loss factor of the rubber",
        },
        source=SOURCE_DERIVED,
        validity="At the worst operating point, which need not be that of the peak force where "
        "rubber is softer one way. On the bearing's own rubber: the deflection of a separate "
        "bracket is not in it, that of a bracket within the stiffness is. The rubber stays linear, "
        "beyond its stop too.",
        compute=lambda r: _travel(r)[..., _on_own_rubber(r)],
        find_worst_points=_where_farthest(_on_own_rubber),
        has_resonance=True,
        depends_on_mounts=True,
        parts=_bearings(_on_own_rubber),
        requirements=_TO_TRAVEL,
        section="Centre bearings",
    ),
    Quantity(
        key="centre_bearing_travel_utilisation",
        name="Centre bearing, travel / stop",
        symbol="u/u0",
        unit="1",
        equation="u / u0",
        symbol_meanings={
            "u": "how far the bearing goes on its rubber (centre_bearing_travel)",
            "u0": "travel of the rubber, from where the line hangs to its stop",
        },
        source=SOURCE_DERIVED,
        validity="Of bearings whose travel_mm an application gives. Above 1 the rubber "
        "meets its stop, and forces are those of a bearing that is stiffer beyond it.",
        compute=_over_stop,
        find_worst_points=_where_farthest(_stopped),
        has_resonance=True,
        depends_on_mounts=True,
        parts=_bearings(_stopped),
        requirements=_TO_TRAVEL,
        section="Centre bearings",
    ),
    Quantity(
        key="spline_compression_utilisation",
        name="Thrust / critical compression",
        symbol="P/Pk",
        unit="1",
        equation="P / Pk, det(K + T K_T − Pk G) = 0",
        symbol_meanings={
            "P": "compression that the spline's friction and the suspension's stroke reach: "
            "l(P) = l of the held spline, at most T μ / rm",
            "K, K_T": "stiffness of rubber and tubes, and of the torque T",
            "G": "x' G x = Σ Dj² / Lj, Dj the lateral offset across shaft j, Lj its length",
        },
        source=SOURCE_DERIVED,
        validity="At the state's largest torque, at worst over the stroke; of a line whose "
        "stroke is unknown with the whole slip force. At 1 the line on its rubber buckles; "
        "forces of thrust grow as 1 / (1 − P/Pk).",
        compute=lambda r: _of_stroke(r, "utilisation")[..., : len(line_on_rubber(r))],
        depends_on_mounts=True,
        parts=line_on_rubber,
        requirements=_TO_THRUST,
        section="Centre bearings",
        json_path="spline_compression_utilisation",
    ),
    Quantity(
        key="centre_bearing_dead_load",
        name="Centre bearing, spline thrust as a dead load (upper estimate)",
        symbol="Fd0",
        unit="N",
        equation="Fd0 = |mean force at P = T μ / rm|, q = (K + T K_T − P G)⁻¹ (f + P g)",
        symbol_meanings={
            "f, g": "the crosses' mean moments, and how the coordinates q lengthen the spline"
        },
        source=SOURCE_DERIVED,
        validity="Where the state has the axle, as if the whole slip force pushed however far "
        "the spline goes in: spline_dead_load_shortening says how far, spline_stroke_shortening "
        "what the suspension does. Not evaluated where that passes the critical compression.",
        compute=_dead_load,
        depends_on_mounts=True,
        parts=all_centre_bearings,
        requirements=_TO_THRUST,
        section="Centre bearings",
        json_path="centre_bearings.dead_load_N",
    ),
    Quantity(
        key="spline_dead_load_shortening",
        name="Shortening of the spline that a dead load needs",
        symbol="Δl0",
        unit="mm",
        equation="Δl0 = l(T μ / rm) − l(0)",
        source=SOURCE_DERIVED,
        compute=lambda r: _of_stroke(r, "dead_load_shortening"),
        depends_on_mounts=True,
        parts=last_shaft,
        requirements=_TO_THRUST,
        section="Centre bearings",
        json_path="spline_dead_load_shortening_mm",
    ),
    Quantity(
        key="spline_stroke_shortening",
        name="Shortening of the spline over the suspension's stroke",
        symbol="Δl",
        unit="mm",
        equation="Δl = max l − min l over the stroke, at the state's largest torque and at rest",
        source=SOURCE_DERIVED,
        validity="Between the places that the states give the axle.",
        compute=lambda r: _of_stroke(r, "shortening"),
        depends_on_mounts=True,
        parts=last_shaft,
        requirements=_TO_THRUST,
        section="Centre bearings",
        json_path="spline_stroke_shortening_mm",
    ),
    Quantity(
        key="swing_growth",
        name="Stability on the rubber mounts",
        symbol="λS",
        unit="per_s",
        equation="λS = max Re λ,  [(λ ± iΩ)² + (λ ± iΩ)(2 d + Ω G) + ω²] (A, B) = T (S B, S* A)/2",
        symbol_meanings={
            "d": "decay of a mode by what the rubber loses, η ω / 2",
            "S": "what order 2 of the crosses' moments makes of one mode in another, of 1 N m",
        },
        source=SOURCE_DERIVED,
        validity="At the worst operating point. Above 0 the line swings by itself where twice "
        "its speed "
        "meets the sum of two modes, whatever shakes it; then no steady force is an answer. Of two "
        "modes it grows from T |Sij| = 4 √(ωi ωj di dj) on.",
        compute=lambda r: _growth(r)[..., None][..., : len(line_on_rubber(r))],
        find_worst_points=lambda r: r.mount_loads.worst_growth_rate,
        depends_on_mounts=True,
        parts=line_on_rubber,
        requirements=(
            NEEDS_SHAFT_LENGTHS,
            NEEDS_TORQUE,
            NEEDS_SPEED_ZERO_ALLOWED,
            NEEDS_MOUNT_STIFFNESS,
        ),
        section="Centre bearings",
        json_path="swing_growth_per_s",
    ),
    Quantity(
        key="joint_force",
        at_all_points=True,
        name="Joint force",
        symbol="Fj",
        unit="N",
        equation="Fj = max over a turn of |force through the joint centre|",
        source=SOURCE_DERIVED,
        validity="At the worst thrust of the sliding fit, and with the torque that speeds the "
        "shafts "
        "up; on rigid centre bearings. The needles carry the torque besides.",
        compute=lambda r: r.rigid_loads.joint_forces,
        validity_margin=_any_stop_margin,
        approximations={"quasi_static": lambda r: r.rigid_loads.joint_loads.joint_forces.peak},
        parts=all_joints,
        requirements=(NEEDS_SHAFT_LENGTHS, NEEDS_TORQUE_WEIGHT_OR_UNBALANCE),
        section="Speed and strength",
        json_path="joint_forces.worst_N",
    ),
    Quantity(
        key="joint_dynamic",
        name="Joint, dynamic force",
        symbol="Fk",
        unit="N",
        equation="Fk = F2 + F4 + F6,  F = Z q − f",
        symbol_meanings={
            "F2, F4, F6": "0-to-peak along the major axis of the force ellipse of each order",
            "Z": "what motion q of the line requires of a joint: stiffness, gyroscope and mass",
            "f": "the crosses' moments on it",
        },
        source=SOURCE_DERIVED,
        validity="At the worst operating point, centre bearings on their rubber and flanges as "
        "they "
        "give; the first joint and the last shake the flanges of gearbox and axle. Steady: passing "
        "quickly does not reach it.",
        compute=_of_joints,
        approximations={"rigid": lambda r: r.rigid_loads.joint_loads.joint_forces.dynamic},
        validity_margin=_any_stop_margin,
        find_worst_points=lambda r: r.mount_loads.worst_joint_forces,
        has_resonance=True,
        depends_on_mounts=True,
        parts=all_joints,
        requirements=(
            NEEDS_SHAFT_LENGTHS,
            NEEDS_TORQUE_WEIGHT_OR_UNBALANCE,
            NEEDS_SPEED_ZERO_ALLOWED,
            NEEDS_MOUNT_STIFFNESS,
            NEEDS_STABLE_LINE,
        ),
        section="Centre bearings",
        json_path="joint_forces.dynamic_N",
    ),
    Quantity(
        key="gearbox_bearing_force",
        at_all_points=True,
        name="Radial force on a gearbox bearing",
        symbol="FA, FB",
        unit="N",
        equation="FB = FQ − FA,  FA = (o × M − b FQ) / a; max over a turn of the size",
        symbol_meanings={
            "M, FQ": "moment and force square to the axis on the flange, at the joint centre",
            "o": "unit vector from the bearings to the joint",
            "a": "spacing of the bearings",
            "b": "overhang of the joint centre beyond the nearer one, B",
        },
        source=SOURCE_DERIVED,
        validity="At the worst thrust of the sliding fit. GWB's catalogue, p. 46, gives two "
        "positions "
        "of one planar shaft, without thrust.",
        compute=_end_bearings("AB"),
        validity_margin=_any_stop_margin,
        approximations=_quasi_static("AB"),
        parts=_lettered("AB"),
        requirements=(
            NEEDS_SHAFT_LENGTHS,
            NEEDS_TORQUE_WEIGHT_OR_UNBALANCE,
            _placed("gearbox"),
        ),
        section="Gearbox, axle and spline",
        json_path="end_bearings_worst_N{}",
    ),
    Quantity(
        key="pinion_bearing_force",
        at_all_points=True,
        name="Radial force on a pinion bearing",
        symbol="FE, FF",
        unit="N",
        equation="FE = FQ − FF,  FF = (o × M − e FQ) / f; max over a turn of the size",
        symbol_meanings={
            "M, FQ": "moment and force square to the axis on the flange, at the joint centre",
            "o": "unit vector from the bearings to the joint",
            "f": "spacing of the bearings",
            "e": "overhang of the joint centre beyond the nearer one, E",
        },
        source=SOURCE_DERIVED,
        validity="From the line alone, without the gears' forces. GWB's catalogue: see p. 46.",
        compute=_end_bearings("EF"),
        validity_margin=_any_stop_margin,
        approximations=_quasi_static("EF"),
        parts=_lettered("EF"),
        requirements=(
            NEEDS_SHAFT_LENGTHS,
            NEEDS_TORQUE_WEIGHT_OR_UNBALANCE,
            _placed("pinion"),
        ),
        section="Gearbox, axle and spline",
        json_path="end_bearings_worst_N{}",
    ),
    _rated_end_bearings(
        "AB",
        "gearbox",
        name="Force on a gearbox bearing over its rating",
        equation="(FA + Fk b/a) / F0, (FB + Fk (a + b)/a) / F0",
        validity="Of bearings whose rating an application gives. An upper estimate: the "
        "force on rigid centre bearings and what rubber adds are taken where they add up.",
    ),
    _rated_end_bearings(
        "EF",
        "pinion",
        name="Force on a pinion bearing over its rating",
        equation="(FF + Fk b/a) / F0, (FE + Fk (a + b)/a) / F0",
        validity="Of bearings whose rating an application gives. An upper estimate: the "
        "force on rigid centre bearings and what rubber adds are taken where they add up. "
        "Without the gears' forces: the rating is what they leave.",
    ),
    Quantity(
        key="spline_force",
        at_all_points=True,
        name="Slip force of the spline",
        symbol="Fa",
        unit="N",
        equation="Fa = T μ / rm",
        symbol_meanings={
            "μ": "friction (0.08 coated, 0.11 greased steel)",
            "rm": "mean spline radius",
        },
        source=GWB_CATALOGUE.with_place("p. 46"),
        compute=make_whole_line_quantity_function(lambda r: r.inputs.spline_force),
        parts=last_shaft,
        requirements=(NEEDS_TORQUE, NEEDS_SPLINE_RADIUS),
        section="Gearbox, axle and spline",
        json_path="spline_force_N",
    ),
    Quantity(
        key="unbalance_force",
        name="Unbalance force",
        symbol="Fu",
        unit="N",
        equation="Fu = m (G ω) / 2 at each end, e ω = G",
        symbol_meanings={"m": "shaft mass", "G": "balance grade, mm/s", "ω": "shaft speed"},
        source=ISO_21940_11,
    ),
    Quantity(
        key="cross_force",
        at_all_points=True,
        name="Force on a journal of the cross",
        symbol="Fc",
        unit="N",
        equation="Fc = T / (a cos β)",
        symbol_meanings={"a": "between the middles of opposite needle rows"},
        source=SOURCE_DERIVED,
    ),
)
