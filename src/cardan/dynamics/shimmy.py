r"""A steering column with universal joints, and the speed at which the wheels shimmy.

Five degrees of freedom: rotation of the left and right wheel about their kingpins, roll of
the axle, the steering gear, and the hand wheel at the other end of the column. The tyres
answer slip with a lag, the relaxation length; the wheels' spin couples kingpin and roll:

    I δ'' + c δ' + k_t (δ - s) + I_p (V/r) φ' + e F = 0            each wheel
    (σ/V) F' + F = C_α (δ + (e δ' + r φ')/V)                       each tyre
    I_φ φ'' + c_φ φ' + k_φ φ - I_p (V/r) (δ_L' + δ_R') + r (F_L + F_R) = 0    axle
    J_s s'' + c_s s' + k_t (2 s - δ_L - δ_R) + k_c (s - h) = 0     gear
    J_h h'' + c_h h' + k_c (h - s) = 0                             hand wheel

with play in the column's joints, k_c (s - h) works only beyond it. Sources: tyre and spin
terms, Pacejka, Tire and Vehicle Dynamics (2012), ch. 6; play in the column after Lu et al.
The arrangement is ours: the paper's data were not at hand, and its figures are not compared.
"""

from dataclasses import dataclass

import numpy as np

from cardan.base.arrays import ArrayLike, ComplexArray, FloatArray
from cardan.dynamics.chart import edges
from cardan.dynamics.periodic import eigenvalues


@dataclass(frozen=True, slots=True, kw_only=True)
class Steering:
    """Wheels, tyres, axle and column; the values given shimmy at 65 km/h and 7 Hz.

    Attributes
    ----------
    kingpin_inertia, kingpin_damping : kg m², N m s/rad
        I and c of one wheel about its kingpin.
    tie_stiffness : N m/rad
        k_t, of the linkage to one wheel.
    spin_inertia, radius : kg m², m
        I_p of one wheel about its axle, and r.
    trail : m
        e, mechanical and pneumatic.
    cornering, relaxation : N/rad, m
        C_α and σ of one tyre.
    axle_inertia, axle_damping, axle_stiffness : kg m², N m s/rad, N m/rad
        In roll.
    gear_inertia, gear_damping : kg m², N m s/rad
        J_s and c_s, at the kingpin's ratio.
    hand_inertia, hand_damping, column_stiffness : kg m², N m s/rad, N m/rad
        J_h, c_h and k_c, at the kingpin's ratio.
    play : rad
        Half the play in the column's joints, at the kingpin's ratio.
    """

    kingpin_inertia: float = 15.0
    kingpin_damping: float = 20.0
    tie_stiffness: float = 30e3
    spin_inertia: float = 14.0
    radius: float = 0.45
    trail: float = 0.03
    cornering: float = 80e3
    relaxation: float = 0.8
    axle_inertia: float = 120.0
    axle_damping: float = 1500.0
    axle_stiffness: float = 300e3
    gear_inertia: float = 5.0
    gear_damping: float = 100.0
    hand_inertia: float = 12.0
    hand_damping: float = 300.0
    column_stiffness: float = 15e3
    play: float = 0.0

    def rates(self, speed: ArrayLike) -> FloatArray:
        """Matrix (..., 12, 12) of z' = A z at a road speed m/s, play closed.

        z: δ_L, δ_R, φ, s, h, their rates, and the two tyre forces.
        """
        V = np.asarray(speed, dtype=float)
        A = np.zeros((*V.shape, 12, 12))
        A[..., range(5), range(5, 10)] = 1.0
        spin = self.spin_inertia * V / self.radius
        for wheel, force in ((0, 10), (1, 11)):
            A[..., 5 + wheel, wheel] = -self.tie_stiffness / self.kingpin_inertia
            A[..., 5 + wheel, 3] = self.tie_stiffness / self.kingpin_inertia
            A[..., 5 + wheel, 5 + wheel] = -self.kingpin_damping / self.kingpin_inertia
            A[..., 5 + wheel, 7] = -spin / self.kingpin_inertia
            A[..., 5 + wheel, force] = -self.trail / self.kingpin_inertia
            A[..., 7, 5 + wheel] = spin / self.axle_inertia
            A[..., 8, wheel] = self.tie_stiffness / self.gear_inertia
            A[..., force, wheel] = self.cornering * V / self.relaxation
            A[..., force, 5 + wheel] = self.cornering * self.trail / self.relaxation
            A[..., force, 7] = self.cornering * self.radius / self.relaxation
            A[..., force, force] = -V / self.relaxation
            A[..., 7, force] = -self.radius / self.axle_inertia
        A[..., 7, 2] = -self.axle_stiffness / self.axle_inertia
        A[..., 7, 7] = -self.axle_damping / self.axle_inertia
        A[..., 8, 3] = -(2 * self.tie_stiffness + self.column_stiffness) / self.gear_inertia
        A[..., 8, 4] = self.column_stiffness / self.gear_inertia
        A[..., 8, 8] = -self.gear_damping / self.gear_inertia
        A[..., 9, 4] = -self.column_stiffness / self.hand_inertia
        A[..., 9, 3] = self.column_stiffness / self.hand_inertia
        A[..., 9, 9] = -self.hand_damping / self.hand_inertia
        return A

    def exponents(self, speed: ArrayLike) -> ComplexArray:
        """Exponents (..., 12) 1/s of small motions, play closed."""
        return eigenvalues(self.rates(speed))

    def growth(self, speed: ArrayLike) -> FloatArray:
        """Fastest growth (...) 1/s at a road speed m/s; above 0 the wheels shimmy."""
        values = self.exponents(speed)
        # The steering as a whole runs free only by its tyres: no rigid motion to exclude.
        return values.real.max(-1)

    def onset(self, *, between: tuple[float, float] = (1.0, 60.0)) -> FloatArray:
        """Road speeds (crossings,) m/s at which shimmy begins or ends, rising."""
        return edges(self.growth, between=between, start=600)


def shimmy(
    steering: Steering, *, speed: float, duration: float, kick: float = 0.01, samples: int = 4000
) -> tuple[FloatArray, FloatArray]:
    """Integrate the motion after the left wheel is turned by `kick` rad, with play in the column.

    Returns
    -------
    time : (samples,) s
    state : (samples, 12)
        As `Steering.rates` orders it.

    Notes
    -----
    The tyres are linear: amplitudes above their onset of sliding (some 5 deg) mean no
    more than "it shimmies".
    """
    from scipy.integrate import solve_ivp

    A = steering.rates(speed)
    k, play = steering.column_stiffness, steering.play

    def rate(_: float, z: FloatArray) -> FloatArray:
        twist = z[3] - z[4]
        # What the column would do with its play closed, less what it does.
        missing = k * (twist - np.sign(twist) * max(abs(twist) - play, 0.0))
        out = A @ z
        out[8] += missing / steering.gear_inertia
        out[9] -= missing / steering.hand_inertia
        return out

    start = np.zeros(12)
    start[0] = kick
    times = np.linspace(0, duration, samples)
    done = solve_ivp(rate, (0, duration), start, t_eval=times, rtol=1e-8, atol=1e-10)
    return times, done.y.T
