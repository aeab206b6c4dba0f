"""Forces on bearings, joints and spline."""

from collections.abc import Callable

import numpy as np

from cardan.base.arrays import FloatArray, stacked
from cardan.base.part import Part
from cardan.base.source import DERIVED, GWB, ISO21940
from cardan.quantity.declared import (
    LENGTHS,
    LOAD,
    REACH,
    RUBBER,
    SLIDING,
    TORQUE,
    Need,
    Of,
    Parts,
    Quantity,
    centre_bearings,
    hung,
    joints,
    last_shaft,
    of_line,
)
from cardan.quantity.points import Points
from cardan.quantity.response import Response


def _lettered(letters: str) -> Parts:
    return lambda _: tuple(Part("bearing", letter) for letter in letters)


def _end_bearings(letters: str) -> Of:
    return lambda r: stacked(r.end_bearings[letter] for letter in letters)


def _quasi_static(letters: str) -> dict[str, Of]:
    return {"quasi_static": lambda r: stacked(r.static_end_bearings[k] for k in letters)}


def _placed(letters: str, end: str) -> Need:
    return Need(
        gives=f"{end}_bearing_spacing_mm and {end}_bearing_overhang_mm",
        met=lambda r: np.isfinite(_end_bearings(letters)(r)),
    )


def _of_joints(r: Response) -> FloatArray:
    """Return what shakes each joint on rubber, (..., S, n) N; nan where nobody knows."""
    worst = r.worst_joints
    return np.full(r.angles.shape, np.nan) if worst is None else worst.running.dynamic


def _growth(r: Response) -> FloatArray:
    """Return how a line's swinging goes on at worst, (..., S) 1/s; nan where nobody knows."""
    worst = r.worst_growth
    shape = r.angles.shape[:-1]
    return np.full(shape, np.nan) if worst is None else worst.running.growth[..., 0]


def _on_own_rubber(r: Response) -> list[int]:
    """Return which bearings, from 0, hang in rubber that gives; all where nobody says of any."""
    bearings = r.line.centre_bearings
    return [k for k, b in enumerate(bearings) if b.stiffness] or list(range(len(bearings)))


def _stopped(r: Response) -> list[int]:
    """Return which bearings, from 0, somebody knows the stop of."""
    return [k for k, b in enumerate(r.line.centre_bearings) if b.travel is not None]


def _bearings(which: Callable[[Response], list[int]]) -> Parts:
    return lambda r: tuple(Part("centre bearing", k + 1) for k in which(r))


def _travel(r: Response) -> FloatArray:
    """Return how far each bearing goes across its rubber, (..., S, n-2) m; nan if nobody knows."""
    worst = r.worst_travel
    shape = *r.angles.shape[:-1], r.line.joint_count - 2
    return np.full(shape, np.nan) if worst is None else worst.running.peak


def _over_stop(r: Response) -> FloatArray:
    """Return that over how far the rubber goes, of those bearings of which somebody says it."""
    which = _stopped(r)
    if not which:  # and then it is not sought
        return np.empty((*r.angles.shape[:-1], 0))
    return _travel(r)[..., which] / r.stops[..., which]


def _where_farthest(which: Callable[[Response], list[int]]) -> Callable[[Response], Points | None]:
    """Return how to tell where bearings go farthest, each by itself."""

    def sought(r: Response) -> Points | None:
        chosen = which(r)
        return r.worst_travel.of_bearings(chosen) if chosen and r.worst_travel else None

    return sought


STEADY = Need(
    gives="a line whose swinging on its rubber does not grow (swing_growth)",
    met=lambda r: ~(_growth(r)[..., None] > 0),
)
"""Where swinging grows by itself no steady force is an answer."""

_TO_TRAVEL = (LENGTHS, TORQUE, REACH, RUBBER, STEADY)

_ON_RUBBER = (
    "At the worst operating point of the state, from standstill to top speed in every gear and "
    "direction, on the rubber: a steady response, which passing quickly does not reach. A rigid "
    "support would not feel it, so nothing is said where nobody gives the rubber's stiffness."
)

DECLARED = (
    Quantity(
        key="centre_bearing_static",
        name="Centre bearing, static force",
        symbol="Fs",
        unit="N",
        equation="Fs = |mean over a turn of the force on the bearing|, at the worst thrust",
        where={"worst thrust": "of the sliding fit: none, or its slip force either way"},
        source=DERIVED,
        use=_ON_RUBBER,
        of=lambda r: r.bearing_force("static"),
        sought=lambda r: r.worst.get("static"),
        on_rubber=True,
        parts=centre_bearings,
        needs=(LENGTHS, LOAD, STEADY),
        section="Centre bearings",
        methods={
            "rigid": lambda r: np.linalg.norm(r.loads.bearing_forces.static, axis=-1),
            "small_angle": lambda r: np.linalg.norm(r.small_angle_bearings[0], axis=-1),
        },
    ),
    Quantity(
        key="centre_bearing_dynamic",
        name="Centre bearing, dynamic force",
        symbol="Fd",
        unit="N",
        equation="Fd = F2 + F4 + F6, F = k (1 + iη) c,  [K (1 + iη) + T K_T + i W G − W² M] q = f",
        where={
            "F2, F4, F6": "0-to-peak along the major axis of the force ellipse of each order",
            "k, η": "stiffness and loss factor of the rubber",
            "c": "motion at the bearing, of the line's coordinates q",
            "K, M, G": "stiffness of rubber and tubes, mass, gyroscope",
            "K_T": "stiffness of the torque T, whose moments turn with the shafts",
            "f, W": "the crosses' moments on the shafts, whose rear yokes torque turns back by "
            "T L / (G J), and their frequency",
        },
        source=DERIVED,
        use=_ON_RUBBER,
        of=lambda r: r.bearing_force("dynamic"),
        sought=lambda r: r.worst.get("dynamic"),
        shaken=True,
        on_rubber=True,
        parts=centre_bearings,
        needs=(LENGTHS, TORQUE, REACH, RUBBER, STEADY),
        section="Centre bearings",
        methods={
            "rigid": lambda r: r.loads.bearing_forces.dynamic,
            "small_angle": lambda r: r.small_angle_bearings[1],
        },
    ),
    Quantity(
        key="centre_bearing_peak",
        name="Centre bearing, peak force",
        symbol="Fp",
        unit="N",
        equation="Fp = Fs + Fd + F1",
        where={
            "Fs, Fd": "static and dynamic force",
            "F1": "0-to-peak of the unbalance, where it is asked for",
        },
        source=DERIVED,
        use=_ON_RUBBER,
        of=lambda r: r.bearing_force("peak"),
        sought=lambda r: r.worst.get("peak"),
        shaken=True,
        on_rubber=True,
        parts=centre_bearings,
        needs=(LENGTHS, LOAD, REACH, RUBBER, STEADY),
        section="Centre bearings",
        methods={"rigid": lambda r: r.bearing_peaks},
    ),
    Quantity(
        key="centre_bearing_travel",
        name="Centre bearing, travel on its rubber",
        symbol="u",
        unit="mm",
        equation="u = us + u2 + u4 + u6 + u1,  us = |(Fv/kv, Fl/kl)|, of an order F / (k (1 + iη))",
        where={
            "us": "of torque and worst thrust; weight set the line where it hangs before",
            "v, l": "vertical and lateral, across the shaft",
            "u2, u4, u6": "0-to-peak along the major axis of the ellipse of each order",
            "u1": "of the unbalance, where it is asked for",
            "k, η": "stiffness and loss factor of the rubber",
        },
        source=DERIVED,
        use="At the worst operating point, which need not be that of the peak force where rubber "
        "is softer one way. On the bearing's own rubber: what a bracket told apart gives is not in "
        "it, that of a bracket within the stiffness is. The rubber goes on as it begins, beyond "
        "its stop too.",
        of=lambda r: _travel(r)[..., _on_own_rubber(r)],
        sought=_where_farthest(_on_own_rubber),
        shaken=True,
        on_rubber=True,
        parts=_bearings(_on_own_rubber),
        needs=_TO_TRAVEL,
        section="Centre bearings",
    ),
    Quantity(
        key="centre_bearing_travel_utilisation",
        name="Centre bearing, travel over its stop",
        symbol="u/u0",
        unit="1",
        equation="u / u0",
        where={
            "u": "how far the bearing goes on its rubber (centre_bearing_travel)",
            "u0": "travel of the rubber, from where the line hangs to its stop",
        },
        source=DERIVED,
        use="Asked of bearings whose travel_mm an application gives. Above 1 the rubber meets its "
        "stop: every force on that line's rubber is then one of rubber that goes on, and is not "
        "known.",
        of=_over_stop,
        sought=_where_farthest(_stopped),
        shaken=True,
        on_rubber=True,
        parts=_bearings(_stopped),
        needs=_TO_TRAVEL,
        section="Centre bearings",
    ),
    Quantity(
        key="swing_growth",
        name="Growth of swinging on rubber",
        symbol="λS",
        unit="per_s",
        equation="λS = max Re λ,  [(λ ± iΩ)² + (λ ± iΩ)(2 d + Ω G) + ω²] (A, B) = T (S B, S* A)/2",
        where={
            "d": "decay of a mode by what the rubber loses, η ω / 2",
            "S": "what order 2 of the crosses' moments makes of one mode in another, of 1 N m",
        },
        source=DERIVED,
        use="At the worst operating point. Above 0 the line swings by itself where twice its speed "
        "meets the sum of two modes, whatever shakes it; then no steady force is an answer. Of two "
        "modes it grows from T |Sij| = 4 √(ωi ωj di dj) on.",
        of=lambda r: _growth(r)[..., None][..., : len(hung(r))],
        sought=lambda r: r.worst_growth,
        on_rubber=True,
        parts=hung,
        needs=(LENGTHS, TORQUE, REACH, RUBBER),
        section="Centre bearings",
        contract="swing_growth_per_s",
    ),
    Quantity(
        key="joint_force",
        at_points=True,
        name="Joint force",
        symbol="Fj",
        unit="N",
        equation="Fj = max over a turn of |force through the joint centre|",
        source=DERIVED,
        use="At the worst thrust of the sliding fit, and with the torque that speeds the shafts "
        "up; on rigid centre bearings. The needles carry the torque besides.",
        of=lambda r: r.joint_forces,
        methods={"quasi_static": lambda r: r.loads.joint_forces.peak},
        parts=joints,
        needs=(LENGTHS, LOAD),
        section="Speed and strength",
        contract="joint_forces.worst_N",
    ),
    Quantity(
        key="joint_dynamic",
        name="Joint, dynamic force",
        symbol="Fk",
        unit="N",
        equation="Fk = F2 + F4 + F6,  F = Z q − f",
        where={
            "F2, F4, F6": "0-to-peak along the major axis of the force ellipse of each order",
            "Z": "what motion q of the line asks of a joint: stiffness, gyroscope and mass",
            "f": "the crosses' moments on it",
        },
        source=DERIVED,
        use="At the worst operating point, centre bearings on their rubber and flanges as they "
        "give; the first joint and the last shake the flanges of gearbox and axle. Steady: passing "
        "quickly does not reach it.",
        of=_of_joints,
        methods={"rigid": lambda r: r.loads.joint_forces.dynamic},
        sought=lambda r: r.worst_joints,
        shaken=True,
        on_rubber=True,
        parts=joints,
        needs=(LENGTHS, LOAD, REACH, RUBBER, STEADY),
        section="Centre bearings",
        contract="joint_forces.dynamic_N",
    ),
    Quantity(
        key="gearbox_bearing_force",
        at_points=True,
        name="Radial force on a gearbox bearing",
        symbol="FA, FB",
        unit="N",
        equation="FB = FQ − FA,  FA = (o × M − b FQ) / a; max over a turn of the size",
        where={
            "M, FQ": "moment and force square to the axis on the flange, at the joint centre",
            "o": "unit vector from the bearings to the joint",
            "a": "spacing of the bearings",
            "b": "overhang of the joint centre beyond the nearer one, B",
        },
        source=DERIVED,
        use="At the worst thrust of the sliding fit. GWB's catalogue, p. 46, gives two positions "
        "of one planar shaft, without thrust.",
        of=_end_bearings("AB"),
        methods=_quasi_static("AB"),
        parts=_lettered("AB"),
        needs=(LENGTHS, LOAD, _placed("AB", "gearbox")),
        section="Gearbox, axle and spline",
        contract="end_bearings_worst_N{}",
    ),
    Quantity(
        key="pinion_bearing_force",
        at_points=True,
        name="Radial force on a pinion bearing",
        symbol="FE, FF",
        unit="N",
        equation="FE = FQ − FF,  FF = (o × M − e FQ) / f; max over a turn of the size",
        where={
            "M, FQ": "moment and force square to the axis on the flange, at the joint centre",
            "o": "unit vector from the bearings to the joint",
            "f": "spacing of the bearings",
            "e": "overhang of the joint centre beyond the nearer one, E",
        },
        source=DERIVED,
        use="From the line alone, without the gears' forces. GWB's catalogue: see p. 46.",
        of=_end_bearings("EF"),
        methods=_quasi_static("EF"),
        parts=_lettered("EF"),
        needs=(LENGTHS, LOAD, _placed("EF", "pinion")),
        section="Gearbox, axle and spline",
        contract="end_bearings_worst_N{}",
    ),
    Quantity(
        key="spline_force",
        at_points=True,
        name="Slip force of the spline",
        symbol="Fa",
        unit="N",
        equation="Fa = T μ / rm",
        where={"μ": "friction (0.08 coated, 0.11 greased steel)", "rm": "mean spline radius"},
        source=GWB.at("p. 46"),
        of=of_line(lambda r: r.spline_force),
        parts=last_shaft,
        needs=(TORQUE, SLIDING),
        section="Gearbox, axle and spline",
        contract="spline_force_N",
    ),
    Quantity(
        key="unbalance_force",
        name="Unbalance force",
        symbol="Fu",
        unit="N",
        equation="Fu = m (G ω) / 2 at each end, e ω = G",
        where={"m": "shaft mass", "G": "balance grade, mm/s", "ω": "shaft speed"},
        source=ISO21940,
    ),
    Quantity(
        key="cross_force",
        at_points=True,
        name="Force on a journal of the cross",
        symbol="Fc",
        unit="N",
        equation="Fc = T / (a cos β)",
        where={"a": "between the middles of opposite needle rows"},
        source=DERIVED,
    ),
)
