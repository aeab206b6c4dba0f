"""The odds of failure: a limit state of scattered quantities, by FORM and by Monte Carlo.

A limit state is any function of the quantities, `limit(x)` with x (..., n) on the last axis,
negative where the part fails. Variables turn standard normal numbers into quantities.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Protocol, TypeAlias

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.errors import ConvergenceError, DesignError

LimitState: TypeAlias = Callable[[FloatArray], FloatArray]


MAX_STALLED_STEPS = 4
"""Steps one after the other that lead nowhere: there the limit state jumps."""

MIN_DESIGN_POINT_TOLERANCE_STD = 1e-8
"""Standard deviations by which a design point is known at least, by central differences."""

MAX_BETA = 38.0
"""Standard deviations beyond which a chance is below the smallest number there is."""


def _normal_tail_probability(beta: float) -> float:
    """Return Φ(-β), where 1 - Φ(β) is 0 to a machine too."""
    return 0.5 * math.erfc(beta / math.sqrt(2))


class RandomVariable(Protocol):
    """A scattered quantity: its value (...) where a standard normal number is u (...)."""

    def value(self, u: FloatArray) -> FloatArray:
        """Return the quantile of the standard normal u."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Normal:
    """Normal with mean and standard deviation."""

    mean: float
    deviation: float

    def value(self, u: FloatArray) -> FloatArray:
        """Return mean + deviation u."""
        return self.mean + self.deviation * u


@dataclass(frozen=True, slots=True, kw_only=True)
class Lognormal:
    """Lognormal with median and coefficient of variation."""

    median: float
    cov: float

    def __post_init__(self) -> None:
        if not (self.median > 0 and self.cov >= 0):
            msg = f"a lognormal needs median above 0 and COV not below, got {self}"
            raise DesignError(msg)

    def value(self, u: FloatArray) -> FloatArray:
        """Return median exp(u √ln(1 + COV²))."""
        return self.median * np.exp(u * math.sqrt(math.log1p(self.cov**2)))


def _values(u: FloatArray, variables: Sequence[RandomVariable]) -> FloatArray:
    return np.stack([v.value(u[..., k]) for k, v in enumerate(variables)], axis=-1)


@dataclass(frozen=True)
class FormResult:
    """A first-order answer: how far failure lies, and towards what.

    Attributes
    ----------
    beta : 1
        Reliability index: distance of the design point in standard normal space.
    design_point : (n,)
        Values of the quantities at the most likely failure.
    u : (n,) 1
        The same in standard normal space.
    importance : (n,) 1
        Share of β² each quantity carries; sums to 1.
    sampled
        Whether Monte Carlo met it, and it is no design point: then Φ(-β) means nothing.
    """

    beta: float
    design_point: FloatArray
    u: FloatArray
    importance: FloatArray
    sampled: bool = False

    @property
    def failure_probability(self) -> float:
        """Probability of failure Φ(-β)."""
        return _normal_tail_probability(self.beta)


def first_order_reliability(
    limit: LimitState,
    variables: Sequence[RandomVariable],
    *,
    start: FloatArray | None = None,
    tolerance: float = 1e-10,
    steps: int = 200,
    beyond: float = MAX_BETA,
) -> FormResult:
    """First-order reliability method: the nearest point of failure.

    Parameters
    ----------
    limit
        g(x) of x (..., n); fails below 0. Smooth near the design point.
    variables
        The n scattered quantities, independent.
    start : (n,) 1
        Where the search begins in standard normal space; in the middle by default. From
        elsewhere it may find another way to fail (`ways`).
    tolerance
        Of the design point, in standard deviations.
    steps, beyond
        Before giving up; and standard deviations, where no failure counts.

    Raises
    ------
    ConvergenceError
        If no design point was found; start nearer or smooth the limit state.

    Notes
    -----
    Hasofer & Lind (1974), Rackwitz & Fiessler (1978), with the step length of Zhang & Der
    Kiureghian (1995). Exact where the limit state is linear in standard normal space, as it
    is for logarithms of lognormals. Central differences, evaluated together.
    """

    def gradient(u: FloatArray) -> tuple[float, FloatArray]:
        g, slope = _limit_state_gradients(limit, variables, u[None])
        return float(g[0]), slope[0]

    u = np.zeros(len(variables))
    g, slope = gradient(u)
    scale = max(abs(g), float(np.linalg.norm(slope))) or 1.0  # g is 0 where the median just fails
    sign = 1.0 if g >= 0 else -1.0
    if start is not None:
        u = start
        g, slope = gradient(u)
    stuck = 0
    for _ in range(steps):
        size2 = float(slope @ slope)
        if not (math.isfinite(size2) and size2 > 0) or u @ u > beyond**2:
            break
        towards = (slope @ u - g) / size2 * slope - u
        # Where no step leads nearer, this is all that differences show.
        near = max(tolerance, MIN_DESIGN_POINT_TOLERANCE_STD) if stuck else tolerance
        if np.linalg.norm(towards) < near and abs(g) < 1e-8 * scale:
            beta = sign * float(np.linalg.norm(u))
            share = u**2 / (u @ u) if beta else np.zeros(u.size)
            return FormResult(beta, _values(u, variables), u, share)
        # Shorten the step until distance plus a price for missing the surface gets less.
        price = 2 * np.linalg.norm(u) / math.sqrt(size2) + 10 / scale
        merit = 0.5 * u @ u + price * abs(g)
        step = 1.0
        while step > 1e-4:
            trial = u + step * towards
            value = float(limit(_values(trial[None], variables))[0])
            if math.isfinite(value) and 0.5 * trial @ trial + price * abs(value) < merit:
                break
            step /= 2
        stuck = stuck + 1 if step <= 1e-4 else 0
        if stuck == MAX_STALLED_STEPS:
            break
        u = u + step * towards
        g, slope = gradient(u)
    msg = f"no design point within {steps} steps; the limit state is {g:g} at u = {u}"
    raise ConvergenceError(msg)


def _limit_state_gradients(
    limit: LimitState, variables: Sequence[RandomVariable], u: FloatArray, *, h: float = 1e-5
) -> tuple[FloatArray, FloatArray]:
    """Return g (P,) and its slopes (P, n) at points (P, n), by central differences, at once."""
    n = u.shape[-1]
    steps = h * np.concatenate([np.zeros((1, n)), np.eye(n), -np.eye(n)])
    g = limit(_values((u[:, None] + steps).reshape(-1, n), variables)).reshape(len(u), -1)
    return g[:, 0], (g[:, 1 : n + 1] - g[:, n + 1 :]) / (2 * h)


def find_failure_mode_design_points(
    limit: LimitState,
    variables: Sequence[RandomVariable],
    *,
    reach: float = 4.0,
    far: float = 6.0,
    most: int = 8,
    tolerance: float = 1e-10,
) -> tuple[FormResult, ...]:
    """Return the ways to fail, nearest first: a limit that is the worst of several has several.

    Parameters
    ----------
    limit, variables, tolerance
        As of `form`.
    reach
        How far out the search begins, in standard deviations, besides from the middle.
    far
        What lies farther away is found from the middle alone, and at twice that not at all.
    most
        Ways that are sought, at most.

    Notes
    -----
    The search of `form` begins in the middle, and where planes through the ends of the axes
    say that failure is nearest: those `2 most` ends where least is left. One way is another
    where it lies a standard deviation from it. What no end of an axis leads to is not found.
    Where the limit state jumps, and no search ends, the nearest of 512 draws twice as wide that
    fail stands for a design point: samples about it are weighted back as well.
    Where the median fails already, the nearest edge of that is all.
    """
    found: list[FormResult] = []

    def seek(start: FloatArray | None, steps: int) -> None:
        try:
            one = first_order_reliability(
                limit, variables, start=start, tolerance=tolerance, steps=steps, beyond=2 * far
            )
        except ConvergenceError:
            return
        if start is None or (0 <= one.beta < far and _is_new_failure_mode(one.u, found)):
            found.append(one)

    seek(None, 100)
    if found and found[0].beta <= 0:
        return tuple(found)
    axes = np.eye(len(variables))
    # A little off the axes: on them two parts of a line often stand alike.
    aside = np.random.default_rng(0).normal(scale=0.1, size=(2 * len(axes), len(axes)))
    ends = reach * (np.concatenate([axes, -axes]) + aside)
    left = limit(_values(ends, variables))
    ends = ends[np.argsort(left, kind="stable")[: 2 * most]]
    g, slope = _limit_state_gradients(limit, variables, ends)
    with np.errstate(divide="ignore", invalid="ignore"):
        planes = (((slope * ends).sum(-1) - g) / (slope**2).sum(-1))[:, None] * slope
    away = np.linalg.norm(planes, axis=-1)
    for k in np.argsort(away, kind="stable"):
        if away[k] < far and len(found) < most and _is_new_failure_mode(planes[k], found):
            seek(planes[k], 30)  # such a plane is near, or between two ways and shows neither
    if found:
        return tuple(sorted(found, key=lambda f: f.beta))
    return tuple(o for o in (_nearest_sampled_failure(limit, variables),) if o and o.beta < far)


def _nearest_sampled_failure(
    limit: LimitState, variables: Sequence[RandomVariable], *, draws: int = 512
) -> FormResult | None:
    """Return the nearest failure that samples twice as wide meet; None where they meet none."""
    u = 2 * np.random.default_rng(0).standard_normal((draws, len(variables)))
    fails = u[limit(_values(u, variables)) < 0]
    if not len(fails):
        return None
    nearest = fails[np.linalg.norm(fails, axis=-1).argmin()]
    way = np.linspace(0, 1, 65)[1:, None] * nearest
    nearest = way[(limit(_values(way, variables)) < 0).argmax()]
    beta = float(np.linalg.norm(nearest))
    return FormResult(
        beta, _values(nearest, variables), nearest, (nearest / beta) ** 2, sampled=True
    )


def _is_new_failure_mode(u: FloatArray, found: Sequence[FormResult]) -> bool:
    """Return whether a point is no way to fail that was found."""
    return all(np.linalg.norm(u - f.u) > 1.0 for f in found)


@dataclass(frozen=True)
class SormResult:
    """A second-order answer: how the surface of failure bends at the design point.

    Attributes
    ----------
    failure_probability
        Probability of failure.
    curvatures : (n - 1,) 1
        Of the surface at the design point; above 0 it bends away from the safe median.
    """

    failure_probability: float
    curvatures: FloatArray

    @property
    def beta(self) -> float:
        """Reliability index -Φ⁻¹(failure)."""
        return ProbabilityEstimate(self.failure_probability, 0.0).beta


def second_order_reliability(
    limit: LimitState, variables: Sequence[RandomVariable], *, around: FormResult, h: float = 1e-3
) -> SormResult:
    """Second-order reliability method about FORM's design point.

    Pf = Φ(-β) Π (1 + ψ κ)^(-1/2), ψ = φ(β)/Φ(-β): Breitung, J. Eng. Mech. 110 (1984), with the
    factor of Hohenbichler & Rackwitz, J. Eng. Mech. 114 (1988). By central differences over `h`
    standard deviations, n² + 2 n + 1 points in two goes.

    Raises
    ------
    ConvergenceError
        If the surface closes about the median faster than second order knows: sample instead.
    """
    from scipy.special import erfcx

    u, n = around.u, around.u.size
    step = h * np.eye(n)
    ends = limit(_values(np.concatenate([u + step, u - step]), variables))
    slope = (ends[:n] - ends[n:]) / (2 * h)
    # Across the way to the failure: one direction by itself, and each two of them together.
    q, _ = np.linalg.qr(np.concatenate([slope[:, None], np.eye(n)], axis=1))
    across = h * q[:, 1:n].T
    one, other = np.triu_indices(n - 1, k=1)
    steps = np.concatenate([across, across[one] + across[other]])
    g = limit(_values(np.concatenate([u[None], u + steps, u - steps]), variables))
    bends = (g[1 : len(steps) + 1] + g[len(steps) + 1 :] - 2 * g[0]) / h**2
    hessian = np.diag(bends[: n - 1])
    hessian[one, other] = (bends[n - 1 :] - bends[one] - bends[other]) / 2
    curvatures = np.linalg.eigvalsh(hessian, UPLO="U") / float(np.linalg.norm(slope))
    side = 1.0 if around.beta >= 0 else -1.0
    ratio = math.sqrt(2 / math.pi) / float(erfcx(abs(around.beta) / math.sqrt(2)))
    bend = 1 + ratio * side * curvatures
    if not (bend > 0).all():
        msg = (
            f"the surface of failure bends by {curvatures.min():.3g} where it is nearest: sample it"
        )
        raise ConvergenceError(msg)
    share = _normal_tail_probability(abs(around.beta)) / math.sqrt(float(np.prod(bend)))
    return SormResult(share if side > 0 else 1 - share, curvatures)


@dataclass(frozen=True, slots=True)
class ProbabilityEstimate:
    """A sampled probability and its standard error."""

    failure_probability: float
    standard_error: float

    @property
    def beta(self) -> float:
        """Reliability index -Φ⁻¹(failure)."""
        if not 0 < self.failure_probability < 1:
            return math.inf if self.failure_probability <= 0 else -math.inf
        return -NormalDist().inv_cdf(self.failure_probability)


def monte_carlo(
    limit: LimitState,
    variables: Sequence[RandomVariable],
    *,
    samples: int,
    seed: int,
    around: FormResult | Sequence[FormResult] = (),
) -> ProbabilityEstimate:
    """Probability of failure by sampling, whatever the limit state's shape.

    With `around`, samples are drawn about FORM's design points in turn and weighted back
    (importance sampling of a mixture): a thousand do the work of millions when failure is rare.
    """
    about = (around,) if isinstance(around, FormResult) else around
    centres = np.stack([f.u for f in about]) if about else np.zeros((1, len(variables)))
    rng = np.random.default_rng(seed)
    total = squares = 0.0
    left = samples
    while left:
        n = min(left, 1 << 17)
        u = rng.standard_normal((n, len(variables))) + centres[np.arange(n) % len(centres)]
        weight = 1 / np.exp(u @ centres.T - 0.5 * (centres**2).sum(-1)).mean(-1)
        fails = np.where(limit(_values(u, variables)) <= 0, weight, 0.0)
        total, squares, left = total + fails.sum(), squares + (fails**2).sum(), left - n
    mean = total / samples
    return ProbabilityEstimate(
        float(mean), math.sqrt(max(squares / samples - mean**2, 0.0) / samples)
    )


def sn_limit_state(*, slope: float, load: float) -> LimitState:
    """Limit state ln(A Δ / (B^m N E[S^m])) of an S-N curve, x = (A, Δ, B).

    A: cycles times stress^m the material bears; Δ: damage at failure; B: what the stress
    scale is wrong by; `load`: N E[S^m] of the required life. In logs it is linear, so FORM
    is exact for lognormals. Source: Wirsching, J. Struct. Eng. 110 (1984).
    """

    def limit(x: FloatArray) -> FloatArray:
        return np.log(x[..., 0]) + np.log(x[..., 1]) - slope * np.log(x[..., 2]) - math.log(load)

    return limit
