"""Critical speeds: of one tube as the handbooks give them, of the whole line as beams.

The handbooks' tube is uniform, slender and held at both joint centres. The line as beams
(`cardan.physics.strength.beams`) keeps what they leave out: shear and rotary inertia of the tubes,
gyroscopic moments, the masses of yokes and spline, and that shafts hang on soft bearings
and on each other.
"""

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, array_library_and_floats
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import g, inch, rpm
from cardan.physics.strength.beams import BeamMatrices, BeamModel, assemble_beams

ELEMENTS_PER_SPAN = 4
"""Beam elements from joint to joint, or to the bearing: the lowest speed is 0.1 % high."""

MIN_SHAFT_BENDING_SHARE_OF_MODE_ENERGY = 0.1
"""Share of the elastic energy from which on shafts bend, and not swing on what holds them.

A line on truck rubber swings with 0.003 at most and bends with 0.99. Flanges that give share a
mode with the tube, and its speed is then below that on rigid ones: which it is of them is no
matter, it bends the tube. At a tenth a swing is three times slower than what it bends."""

HALF_CRITICAL_SPEED_RATIO_RANGE = (0.42, 0.58)
"""Shares of the critical speed where the joints, twice a turn, shake it (SAE AE-7 p. 267)."""


def slender_tube_critical_speed(
    length: ArrayLike,
    *,
    outer: ArrayLike,
    inner: ArrayLike,
    youngs_modulus: ArrayLike,
    density: ArrayLike,
) -> FloatArray:
    r"""Critical speed of a uniform tube pinned at its joint centres.

    $$\omega_c = \frac{\pi^2}{L^2} \sqrt{\frac{E (D^2 + d^2)}{16 \rho}}$$

    Parameters
    ----------
    length : (...) m
        Distance of the joint centres.
    outer, inner : (...) m
        Diameters of the tube.
    youngs_modulus : (...) Pa
    density : (...) kg/m³

    Returns
    -------
    (...) rad/s

    Notes
    -----
    Slender tube, rigid supports, no yokes: `synchronous_whirl_modes` keeps what this leaves out.
    Source: SAE AE-7 p. 267; Souza (2014) eq. 5, after Dent (1921). A public calculator
    prints 7200 rpm for 48 in x 3 in x 0.12 in of steel, E = 200 GPa; its own formula
    gives 8284.

    Examples
    --------
    >>> steel = {"youngs_modulus": 200e9, "density": 7850}
    >>> tube = {"outer": 3 * inch, "inner": 2.76 * inch}
    >>> round(float(slender_tube_critical_speed(48 * inch, **tube, **steel) / rpm))
    8284
    """
    xp, L, D, d, E, rho = array_library_and_floats(length, outer, inner, youngs_modulus, density)
    return (xp.pi / L) ** 2 * xp.sqrt(E * (D**2 + d**2) / (16 * rho))


def inch_formula_critical_speed(
    length: ArrayLike, *, outer: ArrayLike, inner: ArrayLike
) -> FloatArray:
    """Critical speed of a steel tube by the trade's formula, (...) rad/s of (...) m.

    n = 4 705 000 √(OD² + ID²) / L² in rpm and inches: `slender_tube_critical_speed` of steel with
    29·10⁶ psi and 0.281 lb/in³, but for g = 386.4 in/s², which makes it 0.04 % higher.
    Source: SAE AE-7 p. 267.

    Examples
    --------
    >>> round(inch_formula_critical_speed(60 * inch, outer=3.5 * inch, inner=3.26 * inch) / rpm)
    6251
    """
    xp, L, D, d = array_library_and_floats(length, outer, inner)
    return 4_705_000 * xp.sqrt(D**2 + d**2) * inch / L**2 * rpm


def self_weight_sag(
    length: ArrayLike, *, mass_per_length: ArrayLike, bending_stiffness: ArrayLike
) -> FloatArray:
    """Deflection of a pinned tube under its own weight, (...) m: 5 q L⁴ / (384 E I).

    `length` in m, `mass_per_length` q/g in kg/m, `bending_stiffness` E I in N m², all (...).
    Source: Souza (2014) eq. 4.
    """
    _, L, m, EI = array_library_and_floats(length, mass_per_length, bending_stiffness)
    return 5 * m * g * L**4 / (384 * EI)


@dataclass(frozen=True, slots=True, kw_only=True)
class WhirlModes:
    """Ways in which a line whirls, slowest first.

    Attributes
    ----------
    frequency : (..., m) rad/s
        Infinite where the line has no more of them.
    forward_share : (..., m) 1
        Share that whirls with the rotation: 1 forward, 0 backward, 1/2 to and fro.
    bending_share : (..., m) 1
        Share of the elastic energy that the shafts hold; the bearings hold the rest.
    station : (..., p) m
        Places along the line, counted from the first joint.
    shape : (..., m, p, 2) 1
        Vertical and lateral amplitude there, a quarter turn apart in time; the largest
        radius is 1.
    """

    frequency: FloatArray
    forward_share: FloatArray
    bending_share: FloatArray
    station: FloatArray
    shape: FloatArray


def synchronous_whirl_modes(
    beams: BeamModel, *, modes: int | None = None, elements: int = ELEMENTS_PER_SPAN
) -> WhirlModes:
    r"""Return synchronous whirl: the speeds at which a line whirls just once a turn.

    For whirl $v \cos \omega t$, $w \sin \omega t$ at $\omega = \Omega$ the gyroscopic
    term is symmetric,

    $$K x = \Omega^2 \left( M - \begin{bmatrix} 0 & G \\ G^T & 0 \end{bmatrix} \right) x,
    \qquad x = (v, w)$$

    so one symmetric problem holds every critical speed, on bearings of any kind.

    Parameters
    ----------
    beams
        The line.
    modes
        How many to return, backward ones among them; all by default.
    elements
        From joint to joint, or to the bearing; half as many behind it.

    Returns
    -------
    WhirlModes
        Their frequencies are the speeds.

    Notes
    -----
    Timoshenko beams with consistent mass and gyroscopic matrices, after Nelson, A finite
    rotating shaft element using Timoshenko beam theory, J. Mechanical Design 102 (1980).
    Speeds are too high, by (π/n)⁴/1440 + s (π/n)²/24 for n elements in a half wave with a
    share s of their energy in shear, for which s = E I π²/(κ G A L²) is small.
    """
    system = assemble_beams(beams, elements)
    vertical, lateral = system.flexibility[..., 0, :, :], system.flexibility[..., 1, :, :]
    G = system.gyroscopic
    inverse, x = np.linalg.eigh(np.block([[vertical, -G], [-G.mT, lateral]]))
    return _modes(system, inverse, _planes(x), modes)


def line_critical_speed(modes: WhirlModes) -> FloatArray:
    """Return the lowest critical speed (...) rad/s that bends the shafts.

    It is the lowest of `synchronous_whirl_modes` in which the shafts hold more than
    `MIN_SHAFT_BENDING_SHARE_OF_MODE_ENERGY` of the elastic energy. On rubber a line bounces at a
    lower speed, `bearing_resonance_speed`.
    """
    return _lowest(modes, modes.bending_share > MIN_SHAFT_BENDING_SHARE_OF_MODE_ENERGY)


def bearing_resonance_speed(modes: WhirlModes) -> FloatArray:
    """Return the lowest speed (...) rad/s at which the line bounces on its centre bearings.

    Trucks run through it every time they start, and the rubber damps it; what matters is
    that they do not stay there, nor at half of it, where the joints excite it. Infinite on
    rigid bearings.
    """
    return _lowest(modes, modes.bending_share <= MIN_SHAFT_BENDING_SHARE_OF_MODE_ENERGY)


def _lowest(
    modes: WhirlModes, chosen: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
) -> FloatArray:
    """Return the lowest of the chosen modes that unbalance excites.

    Unbalance goes round with the shaft: whirl less than a hundredth forward answers it less
    than a hundredth as much. On bearings alike in both directions every other mode is
    purely backward.
    """
    return np.where(chosen & (modes.forward_share > 0.01), modes.frequency, np.inf).min(-1)


def _planes(x: FloatArray) -> FloatArray:
    """Split vectors (..., 2N, m) into those of the two planes (..., 2, N, m)."""
    return x.reshape(*x.shape[:-2], 2, x.shape[-2] // 2, x.shape[-1])


def _modes(
    system: BeamMatrices, inverse: FloatArray, whirl: FloatArray, modes: int | None
) -> WhirlModes:
    """Return modes of 1/ω² (..., m), the last the slowest, and whirl (..., 2, N, m)."""
    inverse, whirl = inverse[..., ::-1][..., :modes], whirl[..., ::-1][..., :modes]
    across = (whirl[..., 0, :, :] * (system.mass @ whirl[..., 1, :, :])).sum(-2)
    moving = (whirl * (system.flexibility @ whirl)).sum((-3, -2))
    held = ((system.bearing_strain @ whirl) ** 2).sum((-3, -2)) / (whirl**2).sum((-3, -2))
    shape = np.moveaxis(system.displacement @ whirl, (-1, -3), (-3, -1))
    size = np.sqrt((shape**2).sum(-1).max(-1))[..., None, None]
    # What neither bends nor moves, like a rigid bearing, has 1/ω² of 0, but for rounding.
    inverse = np.where(inverse > 1e-12 * inverse[..., :1], inverse, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return WhirlModes(
            frequency=inverse**-0.5,
            forward_share=0.5 + across / moving,
            bending_share=1 - held,
            station=system.station,
            shape=shape / size,
        )
