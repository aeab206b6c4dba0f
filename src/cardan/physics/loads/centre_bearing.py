r"""What centre bearings carry as the line runs: torque, weight, thrust, unbalance, on rubber.

The mean force sets the rubber down, and what comes twice a turn shakes the line where that
leaves it; the crosses' moments follow both, so orders 0, 2 and 4 are found together. The
shafts' inertia adds to orders 4 and 6, and unbalance makes order 1.

A spline that sticks holds any thrust between plus and minus its slip force, and a moving
suspension drives it towards either end: the mean force is the worst of none and of both. On
rubber a thrust is a stiffness too (`cardan.physics.loads.spline_thrust`).
"""

from functools import cached_property

import numpy as np

from cardan.core.arrays import (
    ArrayLike,
    ComplexArray,
    FloatArray,
    stack_keeping_parts_contiguous,
    stack_on_last_axis,
)
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import mm
from cardan.model.layout import Layout, layout_from_points, unit_vector
from cardan.model.parts import Line
from cardan.physics.kinematics.joint_chain import ChainRotation, cross_product, rotate_chain
from cardan.physics.loads.half_turn_fourier import HalfTurnSeries, semi_major_axis
from cardan.physics.loads.rubber_mount import HarmonicMotion, MountedLine
from cardan.physics.loads.statics import (
    DEFAULT_BALANCE_GRADE_MM_S,
    JointLoads,
    bearing_forces_of_weight_and_thrust,
    joint_loads,
    unbalance_forces,
)

BEARING_FORCE_ORDERS = (2, 4, 6)
"""Orders of the joints; on rigid bearings those above 2 come through inertia alone."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ThrustEffect:
    """What thrust in the sliding fit does to a line on rubber, pushed in and drawn out.

    Attributes
    ----------
    force : (2, ..., n-2, 3) N
        What it adds to the mean force on each bearing, where that makes it largest.
    thrust : (2, ..., n-2) N
        That thrust: tension above 0.
    shaft_ends : (2, ..., n-1, 2, 3) m
        How far it moves the ends of each shaft where the line lies.
    """

    force: FloatArray
    thrust: FloatArray
    shaft_ends: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class BearingForces:
    """Forces on the centre bearings, cases on leading axes; or how far their rubber gives, in m.

    Attributes
    ----------
    mean : (..., n-2, 3) N
        With the thrust that makes it largest.
    thrust : (..., n-2) N
        That thrust in the sliding fit, signed.
    order1 : (..., n-2) N
        0-to-peak of what unbalance makes, its heavy spots where they add up.
    waves : (..., n-2, 3, 3) N
        Complex amplitudes of orders 2, 4 and 6, the force Re c e^{ikθ}; θ rises with time,
        however the line turns.
    """

    mean: FloatArray
    thrust: FloatArray
    order1: FloatArray
    waves: ComplexArray

    @cached_property
    def static(self) -> FloatArray:
        """Size of the mean, (..., n-2) N."""
        return np.linalg.norm(self.mean, axis=-1)

    @cached_property
    def order_amplitudes(self) -> FloatArray:
        """0-to-peak along the major axis of orders 2, 4 and 6, (..., n-2, 3) N."""
        return semi_major_axis(self.waves)

    @cached_property
    def dynamic(self) -> FloatArray:
        """What shakes the bearing twice a turn and faster, 0-to-peak: at most, (..., n-2) N."""
        return self.order_amplitudes.sum(-1)

    @cached_property
    def peak(self) -> FloatArray:
        """The largest force: mean, orders and unbalance where they all add up, (..., n-2) N."""
        return self.static + self.dynamic + self.order1

    @property
    def half_turn_series(self) -> HalfTurnSeries:
        """The force round the turn, without unbalance, (..., n-2) of three components."""
        return HalfTurnSeries(
            np.concatenate([self.mean[..., None, :].astype(complex), self.waves], axis=-2)
        )


def bearing_forces(
    layout: Layout,
    line: Line,
    phases: ArrayLike,
    *,
    torque: ArrayLike,
    speed: ArrayLike,
    held: MountedLine | None = None,
    inertias: FloatArray | None = None,
    gravity: float = 0.0,
    slip: ArrayLike = 0.0,
    thrust: ThrustEffect | None = None,
    balanced_at: ArrayLike | None = None,
    gives: bool = False,
) -> BearingForces:
    """Return what the centre bearings carry at a torque and a speed.

    Parameters
    ----------
    layout, line, phases
        Where the line runs before its rubber gives, (..., n, 3); its parts; their yoke phases
        (..., n-1) rad without torque.
    torque, speed : (...) N m, rad/s
        Of the gearbox output, signed both: below 0 it turns backwards.
    held
        How the line can move on its rubber (`mounted_line`), close to that layout; None takes
        bearings as rigid, and needs no masses.
    inertias : (..., n-1) kg m²
        Polar inertias of the shafts; None leaves their torque out.
    gravity : m/s²
        For the weight; 0 leaves it out. The layout is one of a line that already hangs.
    slip : (...) N
        Thrust at which the sliding fit slips, for rigid bearings.
    thrust
        What thrust does to a line on rubber; None leaves it out there.
    balanced_at : (...) rad/s
        Speed for which the shafts are balanced; None leaves unbalance out.
    gives
        Return how far that makes the rubber of `held` give across the shafts, in m for N, from
        where the line hangs: the weight set it there before.
    """
    torque, speed = np.asarray(torque, dtype=float), np.asarray(speed, dtype=float)
    turned, carried = loads_of_turning_line(
        layout, line, phases, torque=torque, speed=speed, inertias=inertias
    )
    found = {k: carried.bearing_forces.order(k) for k in (0, *BEARING_FORCE_ORDERS)}
    if held is not None:
        # Statics, and what moving adds to them: so modes that `held` leaves out bear their share.
        for k, (push, moved) in _swinging(
            held, carried, turned, torque=torque, speed=speed
        ).items():
            found[k] = found[k] + moved.bearing_forces - held.static_bearing_forces(push)
    weight, pulled = bearing_forces_of_weight_and_thrust(layout, line, gravity=gravity)
    if gives:
        assert held is not None  # what is rigid gives nothing
        lossy = np.sign(speed)
        found = {k: held.rubber_deflection(f, lossy=lossy if k else 0.0) for k, f in found.items()}
        weight = 0 * weight
    steady = found[0].real + weight
    mean, drawn = steady, np.zeros(steady.shape[:-1])
    if held is None:
        drawn = _worst_thrust(steady, pulled, slip=slip)
        mean = steady + drawn[..., None] * pulled
    elif thrust is not None:
        more = thrust.force
        if gives:
            more = held.rubber_deflection(more).real
        mean, drawn = _worst_effect(steady, more, thrust.thrust)
    nothing = 0 * found[2]
    return BearingForces(
        mean=mean,
        thrust=drawn,
        order1=_once(
            layout, line, held, torque=torque, speed=speed, balanced_at=balanced_at, gives=gives
        ),
        waves=_as_time_goes(
            stack_keeping_parts_contiguous(
                [found.get(k, nothing) for k in BEARING_FORCE_ORDERS], axis=-2
            ),
            speed,
        ),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class ShaftEndDisplacements:
    """Where rubber lets a line go as it runs: the two ends of each shaft, (..., n-1, 2, 3) m.

    Attributes
    ----------
    mean
        Of torque alone, from where the line hangs.
    thrust : (2, ..., n-1, 2, 3)
        What thrust in the sliding fit adds, pushed in and drawn out; None where unknown.
    waves : (..., K, n-1, 2, 3)
        Complex amplitudes of orders 2, 4 and 6, and of each heavy spot of the unbalance.
    """

    mean: FloatArray
    thrust: FloatArray | None
    waves: ComplexArray


def shaft_end_displacements(
    layout: Layout,
    line: Line,
    phases: ArrayLike,
    *,
    torque: ArrayLike,
    speed: ArrayLike,
    held: MountedLine,
    inertias: FloatArray | None = None,
    thrust: ThrustEffect | None = None,
    balanced_at: ArrayLike | None = None,
) -> ShaftEndDisplacements:
    """Return where a line goes on its rubber, brackets and flanges.

    Arguments as `bearing_forces` has them.
    """
    torque, speed = np.asarray(torque, dtype=float), np.asarray(speed, dtype=float)
    turned, carried = loads_of_turning_line(
        layout, line, phases, torque=torque, speed=speed, inertias=inertias
    )
    swinging = _swinging(held, carried, turned, torque=torque, speed=speed).values()
    each = [moved.coordinates for _, moved in swinging]
    if balanced_at is not None:
        ω2 = speed[..., None, None] ** 2
        pushes = ω2 * unbalance_excitation(line, held, balanced_at=balanced_at)
        once = held.response_to_each(pushes, frequency=speed, speed=speed, torque=torque)
        each += list(np.moveaxis(once.coordinates, -2, 0))
    gone = held.shaft_end_motion(np.stack(np.broadcast_arrays(*each), axis=-2))
    return ShaftEndDisplacements(
        mean=gone[..., 0, :, :, :].real,
        thrust=thrust and thrust.shaft_ends,
        waves=gone[..., 1:, :, :, :],
    )


def layout_settled_under_torque(
    layout: Layout, line: Line, phases: ArrayLike, *, torque: ArrayLike, held: MountedLine
) -> Layout:
    """Return where a line runs whose bearings torque (...) N m has moved on their rubber.

    By the mean moments of its crosses alone: thrust passes, and what order 2 adds is a tenth.
    """
    torque = np.asarray(torque, dtype=float)
    _, carried = loads_of_turning_line(layout, line, phases, torque=torque, speed=0 * torque)
    moved = held.response(
        held.forces_from_joint_moments(carried.joint_moments.order(0)), torque=torque
    )
    joints = held.shaft_end_motion(moved.coordinates[..., None, :]).real[..., 0, 1:, 0, :]
    none = np.zeros_like(joints[..., :1, :])
    d = layout.directions
    return layout_from_points(
        layout.points + np.concatenate([none, joints, none], axis=-2),
        gearbox=d[..., 0, :],
        pinion=d[..., -1, :],
    )


def joint_forces(
    layout: Layout,
    line: Line,
    phases: ArrayLike,
    *,
    torque: ArrayLike,
    speed: ArrayLike,
    held: MountedLine,
    cut: MountedLine,
    inertias: FloatArray | None = None,
    gravity: float = 0.0,
    balanced_at: ArrayLike | None = None,
) -> BearingForces:
    """Return what the joints carry as the line runs on its rubber, the flanges' among them.

    `cut` is `held` with breaks at its joints (`mounted_line`); other arguments are those of
    `bearing_forces`. Forces (..., n) are those of each joint on the member behind it, without
    thrust.
    """
    torque, speed = np.asarray(torque, dtype=float), np.asarray(speed, dtype=float)
    turned, carried = loads_of_turning_line(
        layout, line, phases, torque=torque, speed=speed, inertias=inertias
    )
    found = {k: carried.joint_forces.order(k) for k in (0, *BEARING_FORCE_ORDERS)}
    breaks = _JointCompatibility(cut, line.joint_count, torque=torque, speed=speed)
    swinging = _swinging(held, carried, turned, torque=torque, speed=speed)
    followed = breaks.followed(turned, {k: m.coordinates for k, (_, m) in swinging.items()})
    for k, (push, moved) in swinging.items():
        still = held.static_deflection(push)
        found[k] = found[k] + breaks.force(
            breaks.taken(moved.coordinates, k) - breaks.taken(still, 0, torque=0.0)
            - followed.get(k, 0.0)
        )  # fmt: skip
    still = joint_loads(layout, turned, line, torque=0.0, gravity=gravity, elastic=True)
    steady = still.joint_forces.static + found[0].real
    none = np.zeros(steady.shape[:-1])
    order1 = none
    if balanced_at is not None:
        ω2 = speed[..., None, None] ** 2
        pushes = ω2 * unbalance_excitation(line, held, balanced_at=balanced_at)
        moved = held.response_to_each(pushes, frequency=speed, speed=speed, torque=torque)
        own = ω2 * unbalance_excitation(line, cut, balanced_at=balanced_at)[..., breaks.rows]
        order1 = semi_major_axis(breaks.force(breaks.taken(moved.coordinates, 1, each=True) - own))
        order1 = order1.sum(-2)
    nothing = 0 * found[2]
    return BearingForces(
        mean=steady,
        thrust=none,
        order1=order1,
        waves=_as_time_goes(
            stack_keeping_parts_contiguous(
                [found.get(k, nothing) for k in BEARING_FORCE_ORDERS], axis=-2
            ),
            speed,
        ),
    )


class _JointCompatibility:
    """What a line's motion requires of its joints: rows of `cut` that nothing moves along.

    N of its coordinates are the line's own; `rows` are the 3 n of the breaks.
    """

    def __init__(
        self, cut: MountedLine, joints: int, *, torque: FloatArray, speed: FloatArray
    ) -> None:
        self.cut, self.joints, self.torque, self.speed = cut, joints, torque, speed
        size, seats = cut.mass.shape[-1], cut.bracket_mode_count
        first = size - seats - 3 * joints
        self.rows = slice(first, size - seats)
        self.own = np.r_[:first, size - seats : size]

    def taken(
        self,
        moved: ComplexArray,
        order: int,
        *,
        torque: ArrayLike | None = None,
        each: bool = False,
    ) -> ComplexArray:
        """Return what a motion (..., N) at an order of the speed requires, (..., 3 n) N."""
        T = self.torque if torque is None else np.asarray(torque, dtype=float)
        K = self.cut.dynamic_stiffness(order * self.speed, self.speed, T)[..., self.rows, :][
            ..., self.own
        ]
        return ((K[..., None, :, :] if each else K) @ moved[..., None])[..., 0]

    def followed(
        self, turned: ChainRotation, motions: dict[int, ComplexArray]
    ) -> dict[int, ComplexArray | FloatArray]:
        """Return what the crosses' moments do on the breaks as they follow the motion."""
        pushes, bends = self.cut.order2_coupling_factors(turned)
        left = self.torque[..., None, None] * pushes[..., self.rows].mT
        right = bends[..., self.own]
        q0, q2 = (right @ motions[k][..., None] for k in (0, 2))
        back = np.conj(right) @ motions[4][..., None]
        return {
            0: ((left @ np.conj(q2))[..., 0]).real / 2,
            2: (left @ q0)[..., 0] + (np.conj(left) @ back)[..., 0] / 2,
            4: (left @ q2)[..., 0] / 2,
        }

    def force(self, rows: ComplexArray) -> ComplexArray:
        """Return forces on the members behind the joints, (..., n, 3) N."""
        found = rows.reshape(*rows.shape[:-1], self.joints, 3)
        # At the last one it is the shaft that the axle holds.
        return found * np.where(np.arange(self.joints) == self.joints - 1, -1.0, 1.0)[:, None]


def loads_of_turning_line(
    layout: Layout,
    line: Line,
    phases: ArrayLike,
    *,
    torque: FloatArray,
    speed: FloatArray,
    inertias: FloatArray | None = None,
) -> tuple[ChainRotation, JointLoads]:
    """Return a line's turn as torque twists its shafts, and what it carries on rigid bearings."""
    under = line.phases_under_torque(phases, torque)
    turned = rotate_chain(layout.directions, phases=under, crosses=line.is_cross, samples=16)
    # Which end turns uniformly, engine or wheels, makes a difference of the angle squared.
    return turned, joint_loads(
        layout,
        turned,
        line,
        torque=torque,
        inertias=inertias,
        speed=speed,
        highest=BEARING_FORCE_ORDERS[-1],
    )


def _swinging(
    held: MountedLine,
    carried: JointLoads,
    turned: ChainRotation,
    *,
    torque: FloatArray,
    speed: FloatArray,
) -> dict[int, tuple[ComplexArray, HarmonicMotion]]:
    """Return order by order what pushes the coordinates, and how the line moves."""
    moments = carried.joint_moments
    tied = (0, 2, 4)
    others = [k for k in BEARING_FORCE_ORDERS if k not in tied and k < 2 * moments.waves.shape[-2]]
    pushes = {k: held.forces_from_joint_moments(moments.order(k)) for k in (*tied, *others)}
    found = held.harmonic_balance(
        [pushes[k] for k in tied], held.order2_coupling_factors(turned), speed=speed, torque=torque
    )
    motions: dict[int, HarmonicMotion] = dict(zip(tied, found, strict=True))
    for k in others:
        motions[k] = held.response(pushes[k], frequency=k * speed, speed=speed, torque=torque)
    return {k: (pushes[k], motions[k]) for k in motions}


def _as_time_goes(waves: ComplexArray, speed: FloatArray) -> ComplexArray:
    """Return waves (..., n, K, 3) by an angle that rises where the line turns backwards too."""
    return np.where(speed[..., None, None, None] < 0, np.conj(waves), waves)


def _worst_thrust(force: FloatArray, pulled: FloatArray, *, slip: ArrayLike) -> FloatArray:
    """Return the thrust (..., n-2) N that makes a mean force (..., n-2, 3) N largest.

    It is plus or minus the slip force, or none. `pulled` is what 1 N of thrust adds; `slip`
    (...) N the size it may have.
    """
    slip = np.nan_to_num(np.asarray(slip, dtype=float))[..., None]
    alone, drawn, pushed = (
        np.linalg.norm(force + sign * slip[..., None] * pulled, axis=-1) for sign in (0, 1, -1)
    )
    more = np.maximum(drawn, pushed)
    return slip * np.where(more > alone, np.where(drawn >= pushed, 1.0, -1.0), 0.0)


def _worst_effect(
    force: FloatArray, more: FloatArray, thrust: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return a mean force (..., n-2, 3) with what makes it largest, and that thrust (..., n-2).

    Of two, `more` (2, ..., n-2, 3) N with `thrust` (2, ..., n-2) N, or of none.
    """
    most, drawn = force, np.zeros(force.shape[:-1])
    for added, of in zip(more, thrust, strict=True):
        tried = force + added
        larger = np.linalg.norm(tried, axis=-1) > np.linalg.norm(most, axis=-1)
        most = np.where(larger[..., None], tried, most)
        drawn = np.where(larger, of, drawn)
    return most, drawn


def _once(
    layout: Layout,
    line: Line,
    held: MountedLine | None,
    *,
    torque: FloatArray,
    speed: FloatArray,
    balanced_at: ArrayLike | None,
    gives: bool = False,
) -> FloatArray:
    """Return 0-to-peak of what the permissible unbalance of every end makes, (..., n-2) N.

    m/2 (G/ω₀) ω² at each end of each shaft, by ISO 21940-11; the ends' heavy spots where
    they act together on the bearing in question.
    """
    cases = np.broadcast_shapes(layout.points.shape[:-2], speed.shape)
    if balanced_at is None:
        return np.zeros((*cases, len(line.shafts) - 1))
    if held is None:
        return unbalance_forces(layout, line, speed=speed, balanced_at=balanced_at).bearing_forces
    # Each end by itself: motion of that end, against what turns there.
    pushes = speed[..., None, None] ** 2 * unbalance_excitation(line, held, balanced_at=balanced_at)
    moved = held.response_to_each(pushes, frequency=speed, speed=speed, torque=torque)
    force = moved.bearing_forces
    if gives:
        force = held.rubber_deflection(force, lossy=np.sign(speed), each=True)
    return semi_major_axis(force).sum(-2)


def unbalance_excitation(line: Line, held: MountedLine, *, balanced_at: ArrayLike) -> ComplexArray:
    """Return what the permissible unbalance does at 1 rad/s, (..., 2 (n-1), N) N s².

    On the coordinates, of the front end of each shaft, then of the rear ones: m/2 (G/ω₀) at
    each, going round; nothing where ω₀ is 0.
    """
    grades = stack_on_last_axis(
        DEFAULT_BALANCE_GRADE_MM_S if s.balance_grade is None else s.balance_grade
        for s in line.shafts
    )
    at = np.asarray(balanced_at, dtype=float)[..., None]
    force = stack_on_last_axis(s.mass for s in line.shafts) / 2 * grades * mm
    force = force * np.where(at > 0, 1 / np.where(at > 0, at, 1.0), 0.0)
    side = unit_vector(cross_product(held.shaft_directions, np.array([0.0, 0.0, 1.0])))
    turning = force[..., None] * (side - 1j * cross_product(held.shaft_directions, side))
    return np.concatenate(
        [(turning[..., None, :] @ end)[..., 0, :] for end in (held.front, held.rear)], axis=-2
    )
