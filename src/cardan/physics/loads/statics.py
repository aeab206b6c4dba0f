r"""Joint and bearing forces round a turn, exactly and without going round.

A cross hands on no moment about its own pins, so the moment it puts on the member behind
lies along its normal. With the driving pin axis a, the directions d_{k-1} and d_k of the
members and the torque T_{k-1} before the joint,

$$M_k = T_{k-1}\,\frac{d_k - a\,(a \cdot d_k)}{d_{k-1} \cdot d_k}$$

Member k-1 turns as one joint with the phasor E would drive it (`kinematics.joint_chain`), so its
torque is T (1 + |E|² - 2 Re E e^{2iθ}) / (1 - |E|²) and its pin axis w = S e^{iθ} turns by
e^{-i arg(1 - E e^{2iθ})}. In the product T w² every order but 0 and 2 cancels: under a
constant gearbox torque each moment, and so each force, is a mean and one ellipse at twice
the shaft's speed, and nothing else.

A joint of constant velocity puts its moment along the bisector of its members,
T_{k-1} (d_{k-1} + d_k)/(1 + d_{k-1} · d_k): steady, T tan(β/2) across each of them.

A shaft does not tilt as it turns. What its two joints' moments leave over across it becomes
a couple of forces at its joints and its bearing, which statics alone finds, from the last
shaft forward. Source: derived from first principles; confirmed with independent multibody
engines.
"""

from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import (
    ArrayLike,
    ComplexArray,
    FloatArray,
    array_library_and_floats,
    array_namespace,
    first_axis_last,
    stack_keeping_parts_contiguous,
    stack_on_last_axis,
    stack_vectors_on_last_axes,
)
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import mm
from cardan.model.layout import Layout, unit_vector
from cardan.model.parts import Line
from cardan.physics.kinematics.joint_chain import ChainRotation, cross_product, dot_product
from cardan.physics.loads.half_turn_fourier import HalfTurnSeries, semi_major_axis

DEFAULT_BALANCE_GRADE_MM_S = 16.0
"""Balance grade of cardan shafts, mm/s: ISO 21940-11, table 1."""

_Ends: TypeAlias = tuple[Any, Any]
"""Forces on the front and on the rear end of each shaft, (..., n-1, K, 3) each."""


@dataclass(frozen=True)
class JointLoads:
    """What a line's joints and bearings carry round a turn; cases on leading axes.

    Attributes
    ----------
    joint_forces : waves (..., n, K, 3) N
        Force of each joint on the member behind it, through the joint centre. The member
        ahead gets the opposite.
    joint_moments : waves (..., n, K, 3) N m
        Moment of each cross on the member behind it, about the joint centre.
    bearing_forces : waves (..., n-2, K, 3) N
        Force of each hung shaft on its centre bearing.
    torques : waves (..., n+1, K, 1) N m
        Torque each member hands to the joint behind it; for the pinion, what arrives.
    """

    joint_forces: HalfTurnSeries
    joint_moments: HalfTurnSeries
    bearing_forces: HalfTurnSeries
    torques: HalfTurnSeries

    @property
    def gearbox_force(self) -> HalfTurnSeries:
        """Force, N, of the line on the gearbox flange, through joint 1."""
        return HalfTurnSeries(-self.joint_forces.waves[..., 0, :, :])

    @property
    def gearbox_moment(self) -> HalfTurnSeries:
        """Moment, N m, of the line on the gearbox flange about joint 1."""
        return HalfTurnSeries(-self.joint_moments.waves[..., 0, :, :])

    @property
    def pinion_force(self) -> HalfTurnSeries:
        """Force, N, of the line on the pinion flange, through joint n."""
        return HalfTurnSeries(self.joint_forces.waves[..., -1, :, :])

    @property
    def pinion_moment(self) -> HalfTurnSeries:
        """Moment, N m, of the line on the pinion flange about joint n."""
        return HalfTurnSeries(self.joint_moments.waves[..., -1, :, :])


def joint_loads(
    layout: Layout,
    turn: ChainRotation,
    line: Line,
    *,
    torque: ArrayLike,
    inertias: ArrayLike | None = None,
    accelerations: ArrayLike = 0.0,
    speed: ArrayLike | None = None,
    highest: int = 6,
    gravity: float = 0.0,
    thrust: ArrayLike = 0.0,
    elastic: bool = False,
) -> JointLoads:
    """Return the loads of a line round a turn, exactly, whatever its layout and phases.

    Parameters
    ----------
    layout, turn
        Where the line runs, and its turn (`turn(layout.directions, phases=line.phases)`).
    line
        Gives each bearing's place on its shaft, the axial freedom, and the masses.
    torque : (...) N m
        Torque of the gearbox output on the line, the same all round the turn; negative in
        overrun.
    inertias : (..., n-1) kg m²
        Polar inertias of the shafts, where speeding them up is to count.
    accelerations : (..., n, N) rad/s²
        Of each member at N equally spaced angles of a turn: ω² `turn.acceleration` where
        the gearbox turns uniformly at ω, or ω² `turn.coast_acceleration` where the pinion
        does.
    speed : (...) rad/s
        Of a gearbox that turns uniformly, in place of `accelerations`: no angle is sampled.
    highest
        The last order then reported.
    gravity : m/s²
        Pulls tubes and yokes down; 0 leaves weight out.
    thrust : (...) N
        Tension in the sliding fit: in the last shaft, or along a floating gearbox flange.
        Friction puts any value between plus and minus `spline_slip_force` there.
    elastic
        Whether flexible discs resist their angles (`elastic_joint_moments`); like weight, this is
        there without torque.

    Returns
    -------
    JointLoads
        Orders 0 and 2, exactly; with `inertias` up to N/2, or to `highest`. Each contribution is
        linear, so torque, weight and thrust can be separated.

    Notes
    -----
    Quasi-static: rigid members, bearings that hold their shaft across its axis only,
    crosses without mass. Source: derived from first principles; confirmed with independent
    multibody engines.
    """
    _, _, torque, thrust = array_library_and_floats(layout.directions, torque, thrust)
    torques, moments = _transmission(layout, turn)
    if inertias is None:
        torques, moments = (
            HalfTurnSeries(torque[..., None, None, None] * w) for w in (torques, moments)
        )
    else:
        if speed is None:
            sampled = torque[..., None, None] - _spent(
                turn, *array_library_and_floats(inertias, accelerations)[1:]
            )
            power = list(np.moveaxis(HalfTurnSeries.from_samples(sampled[..., None]).waves, -2, 0))
            orders = len(power)
        else:
            orders = highest // 2 + 1
            power = [torque[..., None, None] * np.ones(turn.phasors.shape[-1] + 1)[:, None]]
            power += _spent_evenly(
                turn, *array_library_and_floats(inertias, speed)[1:], orders=orders
            )
        torques, moments = (
            HalfTurnSeries(_times([p[..., : w.shape[-3], :] for p in power], w, orders=orders))
            for w in (torques, moments)
        )
    if elastic and line.joint_bending_stiffnesses is not None:
        steady = np.eye(moments.waves.shape[-2], 1)
        bent = elastic_joint_moments(layout, line)[..., None, :] * steady
        moments = HalfTurnSeries(moments.waves + bent)
    with np.errstate(invalid="warn" if line.has_lengths else "ignore"):
        joints, bearings = _steady(layout, line, moments.waves, gravity=gravity, thrust=thrust)
    return JointLoads(
        joint_forces=HalfTurnSeries(joints),
        joint_moments=moments,
        bearing_forces=HalfTurnSeries(bearings),
        torques=torques,
    )


def elastic_joint_moments(layout: Layout, line: Line) -> FloatArray:
    """Return the moment of each flexible disc on the member behind it, (..., n, 3) N m.

    Its bending stiffness times its angle, towards the line of the member ahead; 0 of other joints.
    Steady, however the line turns: to first order a disc is alike all round.
    """
    u, v = layout.directions[..., :-1, :], layout.directions[..., 1:, :]
    back = cross_product(v, u)
    sine = np.sqrt(dot_product(back, back))
    angle = np.arctan2(sine, dot_product(u, v))
    stiffness = stack_on_last_axis(line.joint_bending_stiffnesses or (0.0,) * line.joint_count)
    return (stiffness * angle / np.where(sine > 0, sine, 1.0))[..., None] * back


def bearing_forces_of_weight_and_thrust(
    layout: Layout, line: Line, *, gravity: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Return the forces on the bearings of weight and of 1 N of thrust, (..., n-2, 3) N each.

    As `joint_loads` has them without a torque, and without how the line turns. With the
    weight stands what flexible discs resist their angles with.
    """
    two = np.zeros((2, 1)), np.zeros((2, 1))
    two[0][0], two[1][1] = 1.0, 1.0
    still = 0 * layout.directions[..., 1:, None, :] * two[0]
    if line.joint_bending_stiffnesses is not None:
        still = still + elastic_joint_moments(layout, line)[..., None, :] * two[0]
    weights = shaft_end_weights(line, gravity)[..., None, :] * two[0]
    _, bearings = _carried(
        layout,
        line,
        still,
        ends=(weights[..., 0, :, :], weights[..., 1, :, :]),
        thrust=two[1],
    )
    return bearings[..., 0, :], bearings[..., 1, :]


def _steady(
    layout: Layout, line: Line, moments: Any, *, gravity: float, thrust: Any
) -> tuple[Any, Any]:
    """Return the forces of joints and on bearings of moments (..., n, K, 3), weight and thrust."""
    xp = array_namespace(moments)
    # Weight and thrust act on order 0 alone.
    steady = xp.asarray(np.eye(moments.shape[-2], 1))
    weights = xp.asarray(shaft_end_weights(line, gravity))[..., None, :] * steady
    return _carried(
        layout,
        line,
        moments,
        ends=(weights[..., 0, :, :], weights[..., 1, :, :]),
        thrust=thrust[..., None, None] * steady,
    )


def _transmission(layout: Layout, turn: ChainRotation) -> tuple[Any, Any]:
    """Return torques (..., n+1, 2, 1) and moments (..., n, 2, 3) per gearbox torque.

    Orders 0 and 2 of 1/speed, and of the crosses' moments: with F the frame of a joint,
    c = d_k . F and G = S² c F, the product of torque and a (a . d_k) has no others.
    """
    xp = array_namespace(turn.phasors)
    E = xp.concat([0 * turn.phasors[..., :1], turn.phasors], axis=-1)
    e2 = xp.real(E * xp.conj(E))
    torques = xp.stack([1 + e2, -2 * E], axis=-1) / (1 - e2)[..., None]
    u, v, F = layout.directions[..., :-1, :], layout.directions[..., 1:, :], turn.frames
    c = dot_product(v, F)
    G = (turn.initial_pins**2 * c)[..., None] * F
    h = v - xp.real(xp.conj(c)[..., None] * F) / 2
    e, e2 = E[..., :-1, None], e2[..., :-1, None]
    mean = (1 + e2) * h + xp.real(xp.conj(e) * G)
    swing = -2 * e * h - (G + e**2 * xp.conj(G)) / 2
    moments = (
        stack_keeping_parts_contiguous([mean + 0 * swing, swing], axis=-2)
        / (dot_product(u, v)[..., None] * (1 - e2))[..., None]
    )
    if not all(turn.crosses):
        halfway = (u + v) / (1 + dot_product(u, v))[..., None]
        even = torques[..., :-1, :, None] * halfway[..., None, :]
        kinds = xp.asarray(turn.crosses)[:, None, None]
        moments = kinds * moments + (1 - kinds) * even
    return torques[..., None], moments


def _spent(turn: ChainRotation, inertias: FloatArray, accelerations: FloatArray) -> FloatArray:
    """Return the power (..., n+1, N) over gearbox speed that shafts up to each member take."""
    taken = inertias[..., None] * accelerations[..., :-1, :] * turn.speed[..., :-1, :]
    taken = np.cumsum(taken, axis=-2)
    return np.concatenate([0 * taken[..., :1, :], taken, taken[..., -1:, :]], axis=-2)


def _spent_evenly(
    turn: ChainRotation, inertias: FloatArray, speed: FloatArray, *, orders: int
) -> list[ComplexArray]:
    """Return waves of orders 2 to 2 `orders` of minus that power, (..., n+1, 1) each.

    Where the gearbox turns uniformly, a member's w² is that of Poisson's kernel of E: of order
    2 k it has 2 E^k (k + 1 + 2 |E|²/(1 - |E|²)), and J w w' is half of its derivative.
    """
    E = turn.phasors[..., :-1]
    e2 = (E * np.conj(E)).real
    more, wave = 2 * e2 / (1 - e2), -2j * speed[..., None] ** 2 * inertias
    found: list[ComplexArray] = []
    for k in range(1, orders + 1):
        wave = wave * E
        each = np.moveaxis(k * (k + 1 + more) * wave, -1, 0)
        up_to = [0 * each[0], each[0]]
        for own in each[1:]:
            up_to.append(up_to[-1] + own)
        found.append(first_axis_last(np.stack([*up_to, up_to[-1]]))[..., None])
    return found


def _times(power: list[Any], waves: Any, *, orders: int) -> Any:
    """Return a power's waves (..., m, 1) times waves (..., m, 2, c) of orders 0 and 2 alone.

    Re P z^j Re A z is (Re A P z^(j+1) + Re Ā P z^(j-1))/2; so many orders of the product.
    """
    mean, swing = waves[..., 0, :].real, waves[..., 1, :] / 2
    back = np.conj(swing)
    found = [p * mean for p in power[:orders]]
    for j in range(1, orders):
        # The mean has no half on either side.
        found[j] = found[j] + power[j - 1] * (2 * swing if j == 1 else swing)
    for j, p in enumerate(power[1 : orders + 1]):
        found[j] = found[j] + p * back
    found[0] = found[0].real + 0j
    return stack_keeping_parts_contiguous(found, axis=-2)


def shaft_end_weights(line: Line, gravity: float) -> FloatArray:
    """Weight on the front and rear end of each shaft, (..., n-1, 2, 3) N."""
    return _end_masses(line)[..., None] * np.array([0.0, 0.0, -gravity])


def _end_masses(line: Line) -> FloatArray:
    """Mass that weighs on the front and rear end of each shaft, (..., n-1, 2) kg.

    Half the tube, the end's own yoke, and the spline by its place between the joints.
    """
    masses: list[tuple[float, float]] = []
    for shaft in line.shafts:
        spline, at = 0.0, 0.0
        if shaft.spline:
            spline, at = shaft.spline.mass, shaft.spline.from_front_joint / shaft.length
        tube = shaft.mass - sum(shaft.yoke_mass) - spline
        front, rear = shaft.yoke_mass
        masses.append((tube / 2 + front + spline * (1 - at), tube / 2 + rear + spline * at))
    return stack_vectors_on_last_axes(masses, size=2)


def _carried(
    layout: Layout, line: Line, moments: Any, *, ends: _Ends, thrust: Any
) -> tuple[Any, Any]:
    """Return the forces that hold every shaft still, order by order.

    The crosses' `moments` (..., n, K, 3), forces on both `ends` of the shafts, through
    their joint centres, and the `thrust` (..., K, 1) in the sliding fit require forces
    (..., n, K, 3) of the joints on the members behind them and (..., n-2, K, 3) of the
    shafts on their bearings.
    """
    along = layout.directions[..., 1:-1, None, :]
    couples = cross_product(along, moments[..., :-1, :, :] - moments[..., 1:, :, :])
    if line.axial_freedom == "last_shaft":
        return _held(layout, line, couples, ends=ends, tension=thrust)
    # The last shaft does not slide: it pulls as hard as leaves the flange free.
    joints, bearings = _held(layout, line, couples, ends=ends, tension=0 * thrust)
    still = 0 * along
    pulled, pushed = _held(layout, line, still, ends=(still, still), tension=1.0)
    flange = layout.directions[..., :1, :]
    short = dot_product(joints[..., 0, :, :], flange) + thrust[..., 0]
    pull = -(short / dot_product(pulled[..., 0, :, :], flange))[..., None, :, None]
    return joints + pull * pulled, bearings + pull * pushed


def _held(
    layout: Layout, line: Line, couples: Any, *, ends: _Ends, tension: Any
) -> tuple[Any, Any]:
    """Return the forces of the joints and on the bearings, from the last shaft forward.

    A couple (..., n-1, K, 3) is d x m of what the two crosses' moments leave on a shaft.
    """
    xp = array_namespace(couples)
    along = layout.directions[..., 1:-1, None, :]
    steps = (layout.points[..., 1:, :] - layout.points[..., :-1, :])[..., None, :]
    lengths = xp.sqrt(dot_product(steps, steps))[..., None]
    overhangs = xp.asarray(bearing_overhangs(line))[..., None, None]
    front, rear = ends
    behind = -couples[..., -1, :, :] / lengths[..., -1, :, :] - tension * along[..., -1, :, :]
    joints = [behind + rear[..., -1, :, :], behind - front[..., -1, :, :]]
    bearings: list[Any] = []
    for k in reversed(range(len(line.shafts) - 1)):
        d, length = along[..., k, :, :], lengths[..., k, :, :]
        arm = length - overhangs[..., k, :, :]
        behind = joints[-1] - rear[..., k, :, :]
        across = behind - dot_product(behind, d)[..., None] * d
        held = (couples[..., k, :, :] + length * across) / arm
        joints.append(behind - held - front[..., k, :, :])
        bearings.append(-held)
    # The front ones may have more variants than the rear ones: of the bearings' places.
    last_one, *others = xp.broadcast_arrays(*joints, *bearings)
    behind, held = others[: len(bearings) + 1], others[len(bearings) + 1 :]
    on_bearings = stack_keeping_parts_contiguous([last_one, *held[::-1]], axis=-3)[..., 1:, :, :]
    return stack_keeping_parts_contiguous([*behind[::-1], last_one], axis=-3), on_bearings


def bearing_overhangs(line: Line) -> FloatArray:
    """Rear joint of each shaft behind its bearing, (..., n-1) m."""
    bearings = [s.centre_bearing for s in line.shafts]
    return stack_on_last_axis(b.from_rear_joint if b else 0.0 for b in bearings)


def spline_slip_force(
    torque: ArrayLike, *, friction: ArrayLike, mean_radius: ArrayLike
) -> FloatArray:
    """Return the axial force (...) N that slides a spline under torque: T μ / r_m.

    `mean_radius` (...) m is that of the splines; μ is 0.08 coated, 0.11 greased steel.
    Until it is passed the spline can hold any thrust between plus and minus this. Source:
    Dana GWB, Cardan shafts for industrial applications, load on bearings of the connected
    units; its factor cos β leaves what reaches the thrust bearing of the unit, along its axis.
    """
    return np.abs(np.asarray(torque, float)) * np.asarray(friction) / np.asarray(mean_radius)


@dataclass(frozen=True)
class UnbalanceForces:
    """Forces once a turn whose place on the shaft is unknown: their sizes at worst.

    Attributes
    ----------
    joint_forces : (..., n) N
        0-to-peak, at each joint.
    bearing_forces : (..., n-2) N
        0-to-peak, on each centre bearing.
    """

    joint_forces: FloatArray
    bearing_forces: FloatArray


def unbalance_forces(
    layout: Layout,
    line: Line,
    *,
    speed: ArrayLike,
    balanced_at: ArrayLike | None = None,
    grade: float = DEFAULT_BALANCE_GRADE_MM_S,
) -> UnbalanceForces:
    r"""Return the forces once a turn of the unbalance that each shaft's balance grade leaves.

    $$F = \frac{m}{2}\,\frac{G}{\omega_0}\,\omega^2 \quad\text{at each end of each shaft}$$

    Parameters
    ----------
    layout, line
        Where the line runs; its masses, bearings and axial freedom.
    speed : (...) rad/s
        Shaft speed ω.
    balanced_at : (...) rad/s
        Service speed ω₀ the shafts are balanced for; by default the speed itself.
    grade : mm/s
        Grade G of shafts that name none.

    Returns
    -------
    UnbalanceForces
        Worst case: the heavy spots of all ends act together on the part in question. As
        they may meet any position of the yokes too, a peak with unbalance is the peak
        without it plus this.

    Notes
    -----
    Rigid rotors, permissible unbalance shared equally by the two ends, speed taken as
    uniform. Source: ISO 21940-11:2016, table 1.
    """
    speed = np.asarray(speed, dtype=float)
    pace = speed if balanced_at is None else speed**2 / np.asarray(balanced_at, dtype=float)
    grades = stack_on_last_axis(
        grade if s.balance_grade is None else s.balance_grade for s in line.shafts
    )
    masses = stack_on_last_axis(s.mass for s in line.shafts)
    force = masses / 2 * grades * mm * pace[..., None]
    d = layout.directions[..., 1:-1, :]
    side = unit_vector(cross_product(d, np.array([0.0, 0.0, 1.0])))
    turning = force[..., None, None] * (side - 1j * cross_product(d, side))[..., None, :]
    # On a first axis each source by itself: the front ends of the shafts, then the rear.
    count = len(line.shafts)
    alone = np.eye(count).reshape(count, *[1] * (turning.ndim - 3), count, 1, 1) * turning
    none = np.zeros_like(alone)
    ends = np.concatenate([alone, none]), np.concatenate([none, alone])
    still = 0 * layout.directions[..., 1:, None, :]
    with np.errstate(invalid="warn" if line.has_lengths else "ignore"):
        found = _carried(layout, line, still, ends=ends, thrust=np.zeros((1, 1)))
    joints, bearings = (semi_major_axis(f[..., 0, :]).sum(axis=0) for f in found)
    return UnbalanceForces(joint_forces=joints, bearing_forces=bearings)
