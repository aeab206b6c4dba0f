r"""Centre-bearing forces at small angles, in closed form.

At small angles a shaft's two joints leave over a mean couple and one that turns with the
shaft. With the change of direction at joint k as a complex number across the line, y + i z,
which is Δ_k = plan view angle less i times side view angle, and the torque T,

$$q_k = \frac{\Delta_k + \Delta_{k+1}
        + (s_k \Delta_k^* - s_{k+1} \Delta_{k+1}^*)\, e^{2 i \theta}}{L_k},
\qquad s_1 = 1,\ s_{k+1} = -s_k e^{2 i \psi_k}$$

is that couple as a force i T q_k / 2 at either end of shaft k, whose yoke phase is ψ_k.
"""

from typing import Any

import numpy as np

from cardan.core.arrays import ArrayLike, ComplexArray, stack_on_last_axis
from cardan.model.layout import Layout
from cardan.model.parts import Line
from cardan.physics.kinematics.joint_chain import yoke_phases_as_if_all_crosses
from cardan.physics.loads.half_turn_fourier import HalfTurnSeries

# Arrays run through these lines, and the workbook's formulas are made of them.


def residual_angles(front: Any, rear: Any, *, signs: tuple[Any, Any]) -> tuple[Any, Any]:
    """Return what a shaft's two joints leave over, Δ + Δ' and s Δ* − s' Δ'*, complex (...) rad."""
    return front + rear, signs[0] * front.conj() - signs[1] * rear.conj()


def shaft_end_force_of_couple(left: Any, *, torque: Any, length: Any) -> Any:
    """Return the couple of what is left over as a force at the shaft's ends, complex (...) N."""
    return 0.5j * torque * left / length


def bearing_force(couple: Any, *, beyond: Any, length: Any, overhang: Any) -> Any:
    """Return the force on a bearing ahead of a shaft's rear joint, which `beyond` pushes at."""
    return length * (couple - beyond) / (length - overhang)


def small_angle_bearing_forces(layout: Layout, line: Line, *, torque: ArrayLike) -> HalfTurnSeries:
    r"""Force on each centre bearing to first order in the joint angles.

    $$B_k = \frac{L_k}{l_k} \left( \frac{i T}{2} q_k - F_{k+1} \right), \qquad
      F_k = F_{k+1} + B_k, \qquad F_{n-1} = \frac{i T}{2} q_{n-1}$$

    with l_k from the front joint of shaft k to its bearing and F_k the force of joint k on
    shaft k. Two shafts with the bearing at joint 2 give the handbook pair: static
    T/2 \|(Δ₁+Δ₂)/L₁ − (Δ₂+Δ₃)/L₂\|, twice a turn
    T/2 \|(s₁Δ₁* − s₂Δ₂*)/L₁ − (s₂Δ₂* − s₃Δ₃*)/L₂\|.

    Parameters
    ----------
    layout, line
        Where the line runs; its phases and bearings.
    torque : (...) N m
        Torque of the gearbox output.

    Returns
    -------
    HalfTurnSeries
        Waves (..., n-2, 2, 3) N.

    Notes
    -----
    Short of the exact force by about β². Either axial freedom gives the same: what it
    changes is of second order. Source: derived from first principles.
    """
    bend = np.diff(layout.top - 1j * layout.side, axis=-1)
    steps = -np.exp(
        2j * yoke_phases_as_if_all_crosses(stack_on_last_axis(line.phases), line.is_cross)
    )
    s = np.cumprod(np.concatenate([np.ones_like(steps[..., :1]), steps], axis=-1), axis=-1)
    s = s * np.array(line.is_cross)  # only crosses swing
    left = residual_angles(bend[..., :-1], bend[..., 1:], signs=(s[..., :-1], s[..., 1:]))
    lengths = layout.lengths[..., None]
    # The two columns are factors of 1 and of e^{2iθ}.
    turning = np.asarray(torque, dtype=float)[..., None, None]
    couple = shaft_end_force_of_couple(
        np.stack(np.broadcast_arrays(*left), axis=-1), torque=turning, length=lengths
    )
    overhangs = stack_on_last_axis(
        s.centre_bearing.from_rear_joint if s.centre_bearing else 0.0 for s in line.shafts
    )[..., None]
    joint, bearings = couple[..., -1, :], []
    for k in reversed(range(len(line.shafts) - 1)):
        force = bearing_force(
            couple[..., k, :], beyond=joint, length=lengths[..., k, :],
            overhang=overhangs[..., k, :],
        )  # fmt: skip
        joint = joint + force
        bearings.append(force)
    across: ComplexArray = np.stack(np.broadcast_arrays(joint, *bearings)[::-1], axis=-2)
    across = across[..., :-1, :]
    # y + i z as vectors: the mean lies still, the swing goes round with θ.
    mean, swing = across[..., 0], across[..., 1]
    still = np.stack([0 * mean, mean.real, mean.imag], axis=-1)
    round_ = np.stack([0 * swing, swing, -1j * swing], axis=-1)
    return HalfTurnSeries(np.stack([still, round_], axis=-2).astype(np.complex128))
