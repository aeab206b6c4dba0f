"""A line as one joint: how much it shakes, exactly and as the field approximates it.

A line excites its ends in three ways: torsionally, by what its pinion does at constant
gearbox speed; and by the inertia of its own shafts, driven from the gearbox (drive) or
from the axle (overrun). Each is given as the angle of the one joint that would do the same,
and as an angular acceleration.

Exactly, members turn as the phasors of `cardan.physics.kinematics.joint_chain` say. AE-7 adds the
squares of small complex joint angles instead, and everyone else in the field approximates AE-7.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import reduce
from itertools import accumulate
from math import ceil, pi
from operator import add
from typing import Any

import numpy as np

from cardan.core.arrays import (
    ArrayLike,
    ComplexArray,
    FloatArray,
    array_library_and_floats,
    array_namespace,
)
from cardan.core.compiled import POINT_LOOP_CASE_FACTOR, is_compiled_batch
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import deg, rpm
from cardan.physics.kinematics.compiled_excitation import CrestKernel, crest_kernel
from cardan.physics.kinematics.hooke_joint import irregularity, max_acceleration
from cardan.physics.kinematics.joint_chain import ChainRotation

SPICER_ACCELERATION_FACTOR = 3.3403e-6
"""rad/s² per rpm² deg², as Spicer's calculator prints it; exactly rpm² deg² = 3.3405e-6."""

PEAK_SEARCH_STARTS, PEAK_SEARCH_STEPS = 8, 5
"""Angles of half a turn to seek peaks from, at small phasors; steps that reach them."""

MAX_HIGHER_HARMONIC_SHARE = 0.1
"""Share of the first sine that the others may bend by for two peaks next to its own."""

THREE_HARMONIC_NEWTON_STEPS = 2
"""Steps that reach the peaks of three terms, each squaring what is left."""

PEAK_SEARCH_BLOCK_CASES = 2048
"""Cases whose peaks are sought at a time: more of them leave the processor's cache."""


def true_angle_from_tangents(side: ArrayLike, top: ArrayLike) -> FloatArray:
    """Return the true angle (...) rad of view angles: tan² β = tan² βv + tan² βh.

    Exact behind a member that is level in both views; `joint_chain.joint_angles` is exact always.
    Source: Elbe catalogue.
    """
    xp, side, top = array_library_and_floats(side, top)
    return xp.atan(xp.hypot(xp.tan(side), xp.tan(top)))


def true_angle_by_pythagoras(side: ArrayLike, top: ArrayLike) -> FloatArray:
    """Return the true angle (...) rad of view angles: β² = βv² + βh².

    Source: Souza (2014), table 3.
    """
    xp, side, top = array_library_and_floats(side, top)
    return xp.hypot(side, top)


TRUE_ANGLE_FORMULAS: dict[str, Callable[[ArrayLike, ArrayLike], FloatArray]] = {
    "elbe": true_angle_from_tangents,
    "pythagoras": true_angle_by_pythagoras,
}
"""Approximations of the true joint angle from its side and plan view angles, by name."""


def joint_plane_angle(side: ArrayLike, top: ArrayLike) -> FloatArray:
    """Position of the joint's plane, (...) rad in [0, 2π): atan2(βv, βh).

    Source: Souza (2014), table 3.
    """
    xp, side, top = array_library_and_floats(side, top)
    # Twice: a full turn is what is left of the tiniest negative angle the first time.
    return xp.atan2(side, top) % (2 * pi) % (2 * pi)


def joint_plane_quadrant(side: ArrayLike, top: ArrayLike) -> Any:
    """Quadrant of the joint's plane, (...) integers 1 to 4; 1 begins at position 0."""
    xp, angle = array_library_and_floats(joint_plane_angle(side, top))
    return xp.astype(xp.floor(angle / (pi / 2)), xp.int64) + 1


def angle_for_acceleration(acceleration: ArrayLike, *, speed: ArrayLike) -> FloatArray:
    """Largest angle (...) rad of a joint by itself, ω² β² = acceleration (...) rad/s².

    Source: Dana Spicer J3311-1, table of angles by speed (1000 rad/s²).
    """
    xp, acceleration, speed = array_library_and_floats(acceleration, speed)
    return xp.sqrt(acceleration) / speed


@dataclass(frozen=True, slots=True, kw_only=True)
class EquivalentSingleJoint:
    """The one joint that excites as much as a line does.

    Attributes
    ----------
    angle : (...) rad
        Equivalent angle, 2 atan √|E| with E the phasor, or sum of phasors, it stands for.
    acceleration : (...) rad/s²
        Largest angular acceleration over a turn.
    """

    angle: FloatArray
    acceleration: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class KinematicExcitation:
    """What a line does to its ends by turning.

    Attributes
    ----------
    torsional
        Of the pinion, the gearbox turning uniformly.
    drive, coast
        Of the sum over the shafts of their own accelerations, gearbox or pinion turning
        uniformly: AE-7's inertia excitation of shafts of equal inertia.
    drive_torque, coast_torque : (...) N m or None
        The torque to accelerate the real shafts; None where no inertias are given.
    irregularity : (...) 1
        Largest less smallest pinion speed over the gearbox's.
    """

    torsional: EquivalentSingleJoint
    drive: EquivalentSingleJoint
    coast: EquivalentSingleJoint
    drive_torque: FloatArray | None
    coast_torque: FloatArray | None
    irregularity: FloatArray


def excitation_of_rotating_chain(
    turn: ChainRotation, *, speed: ArrayLike, inertias: ArrayLike | None = None
) -> KinematicExcitation:
    """Excitation of a line, exactly.

    The pinion turns as one joint of angle β would drive it, so its peak and irregularity
    are that joint's. Seen from a pinion that turns uniformly, shaft j has the phasor
    (E_j - E_n)/(1 - E_j Ē_n).

    Parameters
    ----------
    turn
        The line, from `rotate_chain`; its samples do not matter.
    speed : (...) rad/s
        Speed of the gearbox, or in overrun of the pinion.
    inertias : (..., n-1) kg m²
        Polar mass moment of inertia of each shaft.

    Notes
    -----
    Members rigid. Source: derived from first principles.
    """
    xp, speed = array_library_and_floats(speed, like=turn.phasors)
    drive, coast = (
        EquivalentSingleJoint(
            angle=_angle(xp.abs(xp.sum(phasors, axis=-1))),
            acceleration=speed**2 * _largest_sum(phasors, xp.ones(phasors.shape[-1])),
        )
        for phasors in _seen(turn)
    )
    torques = None, None
    if inertias is not None:
        torques = shaft_inertia_torques(turn, speed=speed, inertias=inertias)
    joint = _angle(xp.abs(turn.phasors[..., -1]))
    return KinematicExcitation(
        torsional=EquivalentSingleJoint(
            angle=joint, acceleration=speed**2 * max_acceleration(joint)
        ),
        drive=drive,
        coast=coast,
        drive_torque=torques[0],
        coast_torque=torques[1],
        irregularity=irregularity(joint),
    )


def shaft_inertia_torques(
    turn: ChainRotation, *, speed: ArrayLike, inertias: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return the torques to accelerate the shafts, in drive and in overrun, (...) N m.

    Arguments are those of `excitation`.
    """
    _, speed, J = array_library_and_floats(speed, inertias, like=turn.phasors)
    drive, coast = (speed**2 * _largest_sum(phasors, J) for phasors in _seen(turn))
    return drive, coast


def _seen(turn: ChainRotation) -> tuple[ComplexArray, ComplexArray]:
    """Return the shafts' phasors (..., n-1) from a uniform gearbox, then from a uniform pinion."""
    xp = array_namespace(turn.phasors)
    shafts, pinion = turn.phasors[..., :-1], turn.phasors[..., -1:]
    return shafts, (shafts - pinion) / (1 - shafts * xp.conj(pinion))


def _angle(size: FloatArray) -> FloatArray:
    """Return the angle (...) rad of the joint whose phasor has a size, tan²(β/2) (...)."""
    xp = array_namespace(size)
    return 2 * xp.atan(xp.sqrt(size))


def ae7_excitation(
    side: ArrayLike,
    top: ArrayLike,
    *,
    phases: ArrayLike,
    speed: ArrayLike,
    inertias: ArrayLike | None = None,
) -> KinematicExcitation:
    r"""Excitation of a line by AE-7's phasors of small angles.

    $$P_j = \sum_{k \le j} s_k D_k^2, \quad D = \beta_h + i \beta_v, \quad
      \text{angle} = \sqrt{|P|}, \quad \text{acceleration} = \omega^2 |P|$$

    with P_n for the pinion, Σ P_j over the shafts in drive and Σ (P_j - P_n) in overrun, which
    is (n-k) and (k-1) times s_k D_k² joint by joint.

    Parameters
    ----------
    side, top : (..., n) rad
        View angles βv, βh of the joints: change of slope, down and to the right positive.
    phases : (..., n-1) rad
        Yoke phase ε of each shaft. s₁ = 1, and each shaft takes s on to -s e^{2iε}: an
        aligned one flips the sign of the next joint, a crossed one keeps it.
    speed : (...) rad/s
        Speed of the line.
    inertias : (..., n-1) kg m²
        Polar mass moment of inertia of each shaft.

    Notes
    -----
    The weights of drive and overrun take all shafts for equally heavy; the torques do not.
    Source: SAE AE-7, p. 50; odd yoke phases derived, confirmed against the exact chain.
    """
    xp, side, top, phases, speed = array_library_and_floats(side, top, phases, speed)
    terms = ae7_phasor_terms(side, top, phases=phases)
    steps = (terms[..., k] for k in range(terms.shape[-1]))
    *shafts, pinion = accumulate(steps)
    released = [shaft - pinion for shaft in shafts]

    def joint(phasor: ComplexArray) -> EquivalentSingleJoint:
        return EquivalentSingleJoint(
            angle=ae7_equivalent_angle(phasor), acceleration=ae7_acceleration([phasor], speed=speed)
        )

    def torque(phasors: list[ComplexArray]) -> FloatArray | None:
        if inertias is None:
            return None
        _, J = array_library_and_floats(inertias, like=pinion)
        return ae7_acceleration([J[..., j] * p for j, p in enumerate(phasors)], speed=speed)

    torsional = joint(pinion)
    return KinematicExcitation(
        torsional=torsional,
        drive=joint(sum(shafts, 0 * pinion)),
        coast=joint(sum(released, 0 * pinion)),
        drive_torque=torque(shafts),
        coast_torque=torque(released),
        irregularity=xp.sin(torsional.angle) * xp.tan(torsional.angle),
    )


def ae7_phasor_terms(side: ArrayLike, top: ArrayLike, *, phases: ArrayLike) -> ComplexArray:
    """Return what each joint adds to AE-7's phasor, s_k D_k² (..., n) rad², complex.

    The arguments are those of `ae7`; the sum over the joints is P_n, the pinion's.
    """
    xp, side, top, phases = array_library_and_floats(side, top, phases)
    of = (phases[..., k] for k in range(phases.shape[-1]))
    signs = accumulate(of, lambda s, phase: ae7_sign_of_next_joint(s, phase=phase), initial=1.0)
    steps = [ae7_phasor_term(s, side=side[..., k], top=top[..., k]) for k, s in enumerate(signs)]
    return xp.stack(xp.broadcast_arrays(*steps), axis=-1)


# AE-7 joint by joint: arrays run through these lines, and the workbook's formulas are made of them.


def ae7_sign_of_next_joint(sign: Any, *, phase: Any) -> Any:
    """Return s of the joint behind a shaft from that before it: -s e^{2iε}, complex (...)."""
    return -(sign * array_namespace(phase).exp(2j * phase))


def ae7_phasor_term(sign: Any, *, side: Any, top: Any) -> Any:
    """Return what a joint adds to the phasor, s (βh + i βv)², rad² complex (...)."""
    return sign * (top + 1j * side) ** 2


def ae7_equivalent_angle(phasor: Any) -> Any:
    """Return the equivalent angle of a phasor, √|P|, (...) rad."""
    xp = array_namespace(phasor)
    return xp.sqrt(xp.abs(phasor))


def ae7_acceleration(phasors: Sequence[Any], *, speed: Any) -> Any:
    """Return ω² |Σ P|, (...) rad/s²; of phasors times inertias (kg m²) a torque, N m."""
    first, *others = phasors
    return speed**2 * array_namespace(first).abs(sum(others, first))


def in_plane_excitation(
    side: ArrayLike,
    top: ArrayLike,
    *,
    phases: ArrayLike,
    speed: ArrayLike,
    inertias: ArrayLike | None = None,
) -> KinematicExcitation:
    """Excitation as if all joints lay in one plane: `ae7` of the true angles alone.

    For two shafts, aligned or crossed, β₁² ∓ β₂² ± β₃². It leaves out where the planes
    lie. Source: Souza (2014), eq. 11-14; more joints and odd phases as in AE-7.
    """
    true = true_angle_by_pythagoras(side, top)
    return ae7_excitation(0 * true, true, phases=phases, speed=speed, inertias=inertias)


def spicer_sine_squared_excitation(
    side: ArrayLike,
    top: ArrayLike,
    *,
    phases: ArrayLike,
    speed: ArrayLike,
    inertias: ArrayLike | None = None,
) -> KinematicExcitation:
    """`ae7` with accelerations ω² sin² of the equivalent angle, as some tools have it."""
    xp, speed = array_library_and_floats(speed, like=side)
    result = ae7_excitation(side, top, phases=phases, speed=speed, inertias=inertias)
    return _revalued(result, lambda angle: (speed * xp.sin(angle)) ** 2)


def spicer_rpm_and_degrees_excitation(
    side: ArrayLike,
    top: ArrayLike,
    *,
    phases: ArrayLike,
    speed: ArrayLike,
    inertias: ArrayLike | None = None,
) -> KinematicExcitation:
    """`ae7` with accelerations 3.3403e-6 N² θ², N in rpm and θ in degrees."""
    _, speed = array_library_and_floats(speed, like=side)
    result = ae7_excitation(side, top, phases=phases, speed=speed, inertias=inertias)
    return _revalued(
        result, lambda angle: SPICER_ACCELERATION_FACTOR * (speed / rpm * angle / deg) ** 2
    )


EXCITATION_APPROXIMATIONS: dict[str, Callable[..., KinematicExcitation]] = {
    "ae7": ae7_excitation,
    "in_plane": in_plane_excitation,
    "spicer_sine": spicer_sine_squared_excitation,
    "spicer_rpm": spicer_rpm_and_degrees_excitation,
}
"""The field's approximations of `excitation` by name; all take what `ae7` takes."""


def excitation_approximations(
    side: ArrayLike,
    top: ArrayLike,
    *,
    phases: ArrayLike,
    speed: ArrayLike,
    inertias: ArrayLike | None = None,
) -> dict[str, KinematicExcitation]:
    """`EXCITATION_APPROXIMATIONS` of a line, by name; arguments as of `ae7`."""
    return {
        name: of(side, top, phases=phases, speed=speed, inertias=inertias)
        for name, of in EXCITATION_APPROXIMATIONS.items()
    }


def _revalued(
    excitation: KinematicExcitation, acceleration: Callable[[FloatArray], FloatArray]
) -> KinematicExcitation:
    """Return the excitation with each acceleration following from its angle."""

    def joint(old: EquivalentSingleJoint) -> EquivalentSingleJoint:
        return replace(old, acceleration=acceleration(old.angle))

    return replace(
        excitation,
        torsional=joint(excitation.torsional),
        drive=joint(excitation.drive),
        coast=joint(excitation.coast),
    )


def _largest_sum(phasors: ComplexArray, weights: FloatArray) -> FloatArray:
    """Largest |sum over members| of weight times acceleration over ω², (...).

    `phasors` and `weights` are (..., members). With x = E z, z = e^{2iθ}, p = x/(1 - x)
    and g = p (1 + p), a member has -4 Im g, whose slopes by 2θ are as plain.
    """
    xp = array_namespace(phasors)
    members = range(phasors.shape[-1])
    if not members:  # a single joint has no shafts at all
        return 0 * xp.real(xp.sum(phasors, axis=-1))
    cases = (phasors[..., 0] + weights[..., 0]).shape

    def rows(values: Any) -> Any:
        """Return values (..., members) with the cases last, in one row: all at once."""
        each = [xp.broadcast_to(values[..., k], cases) for k in members]
        return xp.reshape(xp.stack(each), (len(members), -1))

    E = rows(phasors)
    J = weights[:, None] if weights.ndim == 1 else rows(weights)
    # Of points, variants and states: points of one design are too few to load a compiler for.
    many = (
        xp is np and len(cases) > 2 and is_compiled_batch(cases[-2:], points=POINT_LOOP_CASE_FACTOR)
    )
    kernel = crest_kernel() if many else None
    found = [
        _crest(E[:, some], J if J.shape[-1] == 1 else J[:, some], kernel)
        for some in _blocks(E.shape[-1], PEAK_SEARCH_BLOCK_CASES)
    ]
    return xp.reshape(found[0] if len(found) == 1 else xp.concat(found), cases)


def _crest(E: Any, J: Any, kernel: CrestKernel | None) -> Any:
    """Return the largest sums (C,) of phasors (members, C) by weights (members, C or 1).

    The sum is -4 Im Σ k c_k z^k, c_k = Σ J E^k. Where the bends of all beyond c₁ are smaller
    than its own there is one peak on either side, next to those of c₁ z; Σ k³ e^k from k = 2
    on is below 8 e²/(1 - e)⁴. Three terms lead there but for a hundred thousandth, and the
    parabola that touches the sum itself has its height to rounding. Else peaks are followed
    uphill from several z at once, because which of two of nearly equal height is the higher
    cannot be known beforehand.
    """
    xp = array_namespace(E)
    if kernel is not None:
        sums, plain = np.empty(E.shape[1]), np.empty(E.shape[1], dtype=bool)
        rows = (np.ascontiguousarray(v) for v in (E, J))
        kernel(*rows, MAX_HIGHER_HARMONIC_SHARE, THREE_HARMONIC_NEWTON_STEPS, sums, plain)
        if plain.all():
            return sums
    e2 = _square(E)
    first = _summed(J * E)
    most = xp.sqrt(_square(first))
    near = (1 - xp.sqrt(e2)) ** 2
    plain = _summed(xp.abs(J) * 8 * e2 / near**2) <= MAX_HIGHER_HARMONIC_SHARE * most
    if bool(xp.all(plain)):
        return _plain(E, J, first=first, most=most)

    def of(some: Any) -> tuple[Any, Any]:
        """Return phasors and weights of some cases; weights that all share as they are."""
        return xp.take(E, some, axis=1), J if J.shape[1] == 1 else xp.take(J, some, axis=1)

    (easy,), (left,) = xp.nonzero(plain), xp.nonzero(~plain)
    # The larger a phasor, the narrower its peak.
    starts = ceil(PEAK_SEARCH_STARTS / (1 - float(xp.sqrt(xp.max(xp.take(e2, left, axis=1))))))
    found = [
        _plain(*of(easy), first=xp.take(first, easy), most=xp.take(most, easy)),
        *(
            _followed(*of(left[k]), starts=starts)
            for k in _blocks(left.shape[0], max(1, PEAK_SEARCH_BLOCK_CASES // starts))
        ),
    ]
    return xp.take(xp.concat(found), xp.argsort(xp.concat([easy, left])), axis=0)


def _blocks(count: int, size: int) -> list[slice]:
    """Return blocks of so many cases, of a size each; one of none."""
    return [slice(k, min(k + size, count)) for k in range(0, max(count, 1), size)]


def _plain(E: Any, J: Any, *, first: Any, most: Any) -> Any:
    """Return the sums at peaks next to those of the `first` term (C,), of sizes `most` (C,)."""
    xp = array_namespace(E)
    x = E * (1j * xp.conj(first) / xp.where(most > 0, most, 1.0))
    square = x * x
    second, third = 2 * _summed(J * square), 3 * _summed(J * square * x)
    z = xp.asarray([[1.0 + 0j], [-1.0 + 0j]])
    for _ in range(THREE_HARMONIC_NEWTON_STEPS):
        z2 = z * z
        a, b, c = 1j * most * z, second * z2, third * (z2 * z)
        z = _uphill(z, xp.real(a + 2 * b + 3 * c), xp.imag(a + 4 * b + 9 * c))
    swing, slope, bend = _swing(x[:, None, :], J[:, None, :], z)
    rise = slope**2 / (2 * xp.where(most > 0, xp.abs(bend), 1.0))
    return 4 * xp.max(xp.abs(swing) + rise, axis=0)


def _summed(of: Any) -> Any:
    """Return the sum of members (members, ...): a few long rows, one added to the other."""
    return reduce(add, (of[k, ...] for k in range(of.shape[0])))


def _square(values: Any) -> Any:
    """Return the squares of sizes of complex numbers."""
    xp = array_namespace(values)
    return xp.real(values) ** 2 + xp.imag(values) ** 2


def _followed(E: Any, J: Any, *, starts: int) -> Any:
    """Return the largest sums (C,), followed uphill from so many z."""
    xp = array_namespace(E)
    z = xp.exp(2j * pi / starts * xp.arange(starts, dtype=J.dtype))[:, None]
    largest = 0 * xp.real(z)
    for _ in range(PEAK_SEARCH_STEPS):
        swing, slope, bend = _swing(E[:, None, :], J[:, None, :], z)
        largest = xp.maximum(largest, xp.abs(swing))
        z = _uphill(z, slope, bend)
    return 4 * xp.max(largest, axis=0)


def _swing(E: Any, J: Any, z: Any) -> tuple[Any, Any, Any]:
    """Return Im Σ J g at z (starts, C), its slope, and its bend with the sign turned."""
    xp = array_namespace(E)
    gain = 1 / (1 - E * z)
    p = gain - 1
    g = p * gain
    return (
        xp.imag(_summed(J * g)),
        xp.real(_summed(J * (g * (gain + p)))),
        xp.imag(_summed(J * (g + 6 * (g * g)))),
    )


def _uphill(z: Any, slope: Any, bend: Any) -> Any:
    """Return z a step on: Newton's near a peak, the whole way to it where all is a pure sine."""
    xp = array_namespace(slope)
    size = xp.sqrt(slope**2 + bend**2) + 1e-300  # a straight line has neither
    return z * (xp.abs(bend) / size + 1j * (slope / size * xp.sign(bend)))
