r"""A line whose rubber meets its stop: harmonic balance on piecewise-linear springs.

Up to its stop the rubber of a centre bearing is linear; beyond it the bearing is r times as stiff,
in every direction across the shaft. With x the travel across the shaft, u = |x|, u₀ the travel to
the stop and k(x) = x'Kx/u² the stiffness of the rubber in the direction of x, the stop adds

$$F_s(x) = \nabla V, \qquad V = (r - 1)\, k(x)\, \max(u - u_0, 0)^2 / 2$$

to the force of the rubber, and loses energy as a damper with the rubber's loss factor η at order 2,
η/(2 Ω) of the rate of that force. The line is linear in everything else. So its motion at the
bearings is what it is without stops, less what the stops push it back by its own receptance, order
by order of a half turn:

$$X_n = X_{0,n} - \sum_m C_{nm}(\Omega)\, (1 + i η m/2)\, \hat F_{s,m}(X)$$

Newton's method solves this for the orders in `STOP_ORDERS`, with the force sampled round the half
turn (alternating frequency-time). A stop has several answers at one speed: solutions are followed
along the speed both ways, so the branch of the largest motion is found up to where it ends; the
branch between, where the determinant of Newton's matrix is negative, is unstable and left out.

Source: Cameron and Griffin (1989), J. Appl. Mech. 56, 149 (alternating frequency-time); Krack and
Gross (2019), Harmonic Balance for Nonlinear Vibration Problems.
"""

from dataclasses import replace

import numpy as np

from cardan.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from cardan.core.batched_linalg import broadcast_cases, matrix_axes_first, matrix_product, solve
from cardan.core.lazy_dataclass import dataclass
from cardan.physics.loads.rubber_mount import MountedLine

STOP_STIFFNESS_RANGE = (5.0, 20.0)
"""Stiffness of rubber beyond its stop over that before it: assumed where no file gives it."""

STOP_ORDERS = (2, 4, 6, 8, 10, 12, 14, 16, 18, 20)
"""Orders of the motion apart from its mean: a stop's push has more of them than its motion."""

SAMPLES = 64
"""Of the half turn, at which a stop's force is evaluated."""

FINE_SAMPLES = 192
"""The same of a motion that is found."""

_ITERATIONS = 6
_LEAST_STEP = 1 / 16
"""Of the way between two speeds, at which a motion that is followed is given up as lost."""
_STIFFENING = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Powers of the ratio of stiffness by which a motion is found from that of linear rubber."""
_FOLLOWED = len(_STIFFENING)
_SHARES = np.append(_STIFFENING, 1.0)
_LARGEST_JUMP = 0.3
"""Of the travel to the stop, off where it was expected: more is another motion."""
_LARGEST_STRAY = 1.0
"""The same while Newton's method is under way, at which a motion that is followed is given up."""
_HOPELESS_RESIDUAL = 1.0
"""Of the travel to the stop: one step of Newton's method has not made up for more."""
_MOST_STEPS = 8000
_RESIDUAL_SHARE = 1e-4
"""Of the travel to the stop, below which Newton's method ends."""
_BLOCK_MOTIONS = 128
"""Evaluated at once: more of them leave the cache."""
_BLOCK_MATRICES = 24
"""The same of Newton's matrices of one bearing."""
_LEAST_TRAVEL_M = 1e-300
"""Which has a direction."""

_LAST_TIED_ORDER = 4
_PLACES_OF_ORDERS = tuple(zip(range(1, 2 * len(STOP_ORDERS), 2), STOP_ORDERS, strict=True))
_COMPONENTS = 1 + 2 * len(STOP_ORDERS)
_TIED_COMPONENTS = 1 + 2 * sum(order <= _LAST_TIED_ORDER for order in STOP_ORDERS)


def _basis(samples: int) -> FloatArray:
    """Return what components are at angles of a half turn, (M, samples)."""
    angles = np.pi / samples * np.outer(np.array(STOP_ORDERS), np.arange(samples))
    found = np.ones((_COMPONENTS, samples))
    found[1::2], found[2::2] = np.cos(angles), -np.sin(angles)
    return found


_BASIS, _FINE_BASIS = _basis(SAMPLES), _basis(FINE_SAMPLES)
_PROJECTION = np.ascontiguousarray(2 * _BASIS.T / SAMPLES)
_PROJECTION[:, 0] /= 2


def _pair_projections() -> tuple[FloatArray, IntArray]:
    """Return what a slope at `SAMPLES` makes of pairs of components, (SAMPLES, K), each once.

    Then which of K is the force's component i of a travel's component j, (M, 2, M, 2), of slopes
    along the axes and across between, of 3 K. Products of two are the same both ways, but for
    the mean's half share.
    """
    i, j = np.indices((_COMPONENTS, _COMPONENTS))
    own = np.argwhere((i <= j) | (j == 0))
    place = np.zeros((_COMPONENTS, _COMPONENTS), dtype=int)
    place[tuple(own.T)] = np.arange(len(own))
    place = np.where((i > j) & (j > 0), place.T, place)
    found = _PROJECTION[:, own[:, 0]] * _BASIS.T[:, own[:, 1]]
    kinds = np.array([[0, 2], [2, 1]])
    each = len(own) * kinds[None, :, None, :] + place[:, None, :, None]
    return np.ascontiguousarray(found), each


_PAIRS, _PLACES_OF_PAIRS = _pair_projections()


@dataclass(frozen=True, kw_only=True, eq=False)
class StopReceptance:
    """What a stop's forces at the bearings move them, with what it loses, at speeds Q; m/N.

    Attributes
    ----------
    tied : (Q, U, 5 2B, 5 2B)
        Of the mean and orders 2 and 4, which the torque ties to one another, components as
        `StoppedLine.free` has them.
    alone : (Q, W, K, 4 B, 4 B)
        Of each order above: the real parts, then the imaginary ones.
    tied_of, alone_of : (C,)
        Which of the lines U and W each case is.
    """

    tied: FloatArray
    alone: FloatArray
    tied_of: IntArray
    alone_of: IntArray

    def select_cases(self, which: IntArray) -> "StopReceptance":
        """Return that of some of the cases."""
        return replace(self, tied_of=self.tied_of[which], alone_of=self.alone_of[which])

    def at_places(self, place: FloatArray, cases: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return `tied` and `alone` of cases (C',) at a place of the speeds each."""
        return (
            at_places(self.tied, place, self.tied_of[cases]),
            at_places(self.alone, place, self.alone_of[cases]),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class StoppedLine:
    """Lines whose rubber has stops, at speeds Q of cases C; B bearings, two directions each.

    Attributes
    ----------
    free : (Q, C, M, 2 B) m
        Travel on linear rubber across the shafts, M components: mean, then real and imaginary
        part of each of `STOP_ORDERS`.
    receptance
        What a stop's forces at the bearings move them.
    stiffness : (C, B, 2) N/m
    stop : (C, B) m
        Travel to the stop; inf where there is none.
    ratio : (C, B)
        Stiffness beyond it over that before it.
    """

    free: FloatArray
    receptance: StopReceptance
    stiffness: FloatArray
    stop: FloatArray
    ratio: FloatArray

    def select_cases(self, which: IntArray) -> "StoppedLine":
        """Return some of the cases."""
        return StoppedLine(
            free=self.free[:, which],
            receptance=self.receptance.select_cases(which),
            stiffness=self.stiffness[which],
            stop=self.stop[which],
            ratio=self.ratio[which],
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class StoppedMotion:
    """Motions of lines with stops, T for each of C cases, where they were found along the speed.

    Attributes
    ----------
    place : (T, C)
        Which speed of the line's grid, fractions between two; nan where there is no motion.
    travel : (T, C, M, 2 B) m
        Across the shafts, components as `StoppedLine.free` has them.
    """

    place: FloatArray
    travel: FloatArray

    def select_cases(self, which: IntArray) -> "StoppedMotion":
        """Return those of some of the cases."""
        return StoppedMotion(place=self.place[:, which], travel=self.travel[:, which])


@dataclass(frozen=True, kw_only=True, eq=False)
class StopContact:
    """Bearings P at J instants, and how far each is beyond its stop.

    Attributes
    ----------
    K1, K2, k : (P, 1), (P, 1), (P, J) N/m
        Stiffness of the rubber along its axes, and in the direction of the travel.
    x, y, n1, n2 : (P, J) m, 1
        Travel across the shaft, and its direction.
    beyond, within : (P, J)
        Shares of the travel beyond the stop, and up to it.
    more : (P, 1)
        Stiffness that the stop adds, over that of the rubber.
    """

    K1: FloatArray
    K2: FloatArray
    k: FloatArray
    x: FloatArray
    y: FloatArray
    n1: FloatArray
    n2: FloatArray
    beyond: FloatArray
    within: FloatArray
    more: FloatArray

    @classmethod
    def of(
        cls, travel: FloatArray, *, stiffness: FloatArray, stop: FloatArray, ratio: FloatArray
    ) -> "StopContact":
        """Return it of `travel` (P, 2, J) m, stiffness (P, 2) N/m, stop and ratio (P,)."""
        x, y = travel[:, 0], travel[:, 1]
        u = np.maximum(np.sqrt(x * x + y * y), _LEAST_TRAVEL_M)
        beyond = np.maximum(1 - stop[:, None] / u, 0.0)
        n1, n2 = x / u, y / u
        K1, K2 = stiffness[:, :1], stiffness[:, 1:]
        return cls(
            K1=K1, K2=K2, k=K1 * (n1 * n1) + K2 * (n2 * n2),
            x=x, y=y, n1=n1, n2=n2,
            beyond=beyond, within=1 - beyond, more=ratio[:, None] - 1,
        )  # fmt: skip

    @property
    def force(self) -> FloatArray:
        """What stops add to the rubber's force, (P, 2, J) N: the gradient of V."""
        found = np.empty((len(self.x), 2, self.x.shape[-1]))
        size, same = self.more * self.beyond, self.within * self.k
        found[:, 0] = size * self.x * (self.beyond * self.K1 + same)
        found[:, 1] = size * self.y * (self.beyond * self.K2 + same)
        return found

    @property
    def slope(self) -> FloatArray:
        """Its derivatives by the travel, (P, 3, J) N/m: along the axes, and across between."""
        n1, n2, s = self.n1, self.n2, self.beyond
        # With s = beyond, a = within: s² K + s a k + (a² - 3 s a) k n n' + 2 s a (K n n' + n n' K)
        both, same = s * self.within, self.within * self.k
        along = np.where(s > 0, self.within * same, 0.0) - 3 * both * self.k
        K1, K2 = self.K1, self.K2
        found = np.empty((len(s), 3, s.shape[-1]))
        found[:, 0] = s * (s * K1 + same) + n1 * n1 * (along + 4 * K1 * both)
        found[:, 1] = s * (s * K2 + same) + n2 * n2 * (along + 4 * K2 * both)
        found[:, 2] = n1 * n2 * (along + 2 * (K1 + K2) * both)
        found *= self.more[:, None]
        return found


def tied_receptance(
    on: MountedLine,
    coupling: ComplexArray,
    *,
    speed: FloatArray,
    torque: FloatArray,
    compression: FloatArray,
) -> FloatArray:
    """Return `StopReceptance.tied` of lines, (..., 5 2B, 5 2B) m/N.

    Of a line in small motion at a speed rad/s under a torque N m, signed, whose order 2
    (`coupling` (..., N, N) of 1 N m, `MountedLine.order2_coupling`) ties orders 0, 2 and 4.
    A compression (...) N of the spline, which slides, takes stiffness off the mean.
    """
    N = on.mass.shape[-1]
    across = _across(on)
    S = torque[..., None, None] * coupling / 2
    Sr, Si = S.real, S.imag
    cases, size = np.broadcast_shapes(S.shape[:-2], speed.shape), across.shape[-2]
    tied = np.zeros((*cases, 5, N, 5, N))
    tied[..., 0, :, 0, :] = (
        on.stiffness_under_torque(torque) - compression[..., None, None] * on.geometric
    )
    tied[..., 0, :, 1, :], tied[..., 0, :, 2, :] = -Sr, -Si
    tied[..., 1, :, 0, :], tied[..., 2, :, 0, :] = -2 * Sr, -2 * Si
    tied[..., 1, :, 3, :], tied[..., 1, :, 4, :] = -Sr, -Si
    tied[..., 2, :, 3, :], tied[..., 2, :, 4, :] = Si, -Sr
    tied[..., 3, :, 1, :], tied[..., 3, :, 2, :] = -Sr, Si
    tied[..., 4, :, 1, :], tied[..., 4, :, 2, :] = -Si, -Sr
    for at, order in _PLACES_OF_ORDERS[: _TIED_COMPONENTS // 2]:
        D = on.dynamic_stiffness(order * speed, speed, torque)
        tied[..., at, :, at, :] = tied[..., at + 1, :, at + 1, :] = D.real
        tied[..., at, :, at + 1, :], tied[..., at + 1, :, at, :] = -D.imag, D.imag
    each = np.zeros((*cases, 5, N, 5, size))
    for k in range(5):
        each[..., k, :, k, :] = across.mT
    pushes = each.reshape(*cases, 5 * N, 5 * size)
    moved = pushes.mT @ np.linalg.solve(tied.reshape(*cases, 5 * N, 5 * N), pushes)
    found = moved.reshape(*cases, 5, size, 5, size)
    for at, order in _PLACES_OF_ORDERS[: _TIED_COMPONENTS // 2]:
        lost = order / 2 * _loss(on, speed)[..., None, None, :]  # times 1 + i η m/2
        real, imaginary = found[..., at, :].copy(), found[..., at + 1, :].copy()
        found[..., at, :] = real + lost * imaginary
        found[..., at + 1, :] = imaginary - lost * real
    return found.reshape(*cases, 5 * size, 5 * size)


def receptance_alone(on: MountedLine, *, speed: FloatArray, torque: FloatArray) -> FloatArray:
    """Return `StopReceptance.alone` of the same lines, (..., K, 4 B, 4 B) m/N."""
    orders = np.array([order for order in STOP_ORDERS if order > _LAST_TIED_ORDER], dtype=float)
    each, rows = orders.reshape(-1, *(1,) * speed.ndim), _across(on)
    axes = max(each.ndim, len(on.case_last_matrices.cases))
    line = on.case_last_matrices.select_cases(slice(None), axes)
    across = broadcast_cases(matrix_axes_first(rows, of=2), axes, of=2)
    D = line.dynamic_stiffness(each * speed, speed, torque)
    H = np.moveaxis(matrix_product(across, solve(D, across.swapaxes(0, 1))), (2, 0, 1), (-3, -2, -1))
    H = H * (1 + 0.5j * orders[:, None, None] * _loss(on, speed)[..., None, None, :])
    size = H.shape[-1]
    found = np.empty((*H.shape[:-2], 2, size, 2, size))
    found[..., 0, :, 0, :] = found[..., 1, :, 1, :] = H.real
    found[..., 0, :, 1, :], found[..., 1, :, 0, :] = -H.imag, H.imag
    return found.reshape(*H.shape[:-2], 2 * size, 2 * size)


def _across(on: MountedLine) -> FloatArray:
    """Return the bearings' motions across the shafts, (..., 2 B, N)."""
    return on.bearing[..., :2, :].reshape(*on.bearing.shape[:-3], -1, on.mass.shape[-1])


def _loss(on: MountedLine, speed: FloatArray) -> FloatArray:
    """Return the loss factors of each travel, signed as the speed, (..., 2 B)."""
    return np.sign(speed)[..., None] * np.repeat(on.loss, 2, axis=-1)


@dataclass(frozen=True, kw_only=True, eq=False)
class ForcesAtStop:
    """Forces on bearings whose rubber meets its stop, (P, B) N.

    Attributes
    ----------
    static, dynamic
        Size of the mean; largest size of the rest round the half turn.
    """

    static: FloatArray
    dynamic: FloatArray


def forces_at_stop(
    travel: FloatArray,
    free: FloatArray,
    linear: FloatArray,
    *,
    stiffness: FloatArray,
    loss: FloatArray,
    stop: FloatArray,
    ratio: FloatArray,
) -> ForcesAtStop:
    """Return what bearings carry in P motions with stops: of a stop its elastic force.

    What it loses is in the motion. A damper's force jumps where a stop is met, rubber's does not.

    Parameters
    ----------
    travel, free : (P, M, 2 B) m
        With stops, and on linear rubber.
    linear : (P, M, 3 B) N
        Force on linear rubber, across the shaft, then along it, bearing by bearing.
    stiffness, loss, stop, ratio : (P, B, 2) N/m, (P, B) signed as the speed, (P, B) m, 1
    """
    count, _, size = travel.shape
    more = stiffness.reshape(count, 1, size) * (travel - free)
    eta = np.repeat(loss, 2, axis=-1)
    for at, _ in _PLACES_OF_ORDERS:
        real, imaginary = more[:, at].copy(), more[:, at + 1].copy()
        more[:, at] = real - eta * imaginary
        more[:, at + 1] = imaginary + eta * real
    rubber = linear.reshape(count, _COMPONENTS, size // 2, 3).copy()
    rubber[..., :2] += more.reshape(count, _COMPONENTS, size // 2, 2)
    static, dynamic = np.empty(stop.shape), np.empty(stop.shape)
    for b in range(size // 2):
        for start in range(0, count, _BLOCK_MOTIONS):
            some = slice(start, start + _BLOCK_MOTIONS)
            force = _round_the_half_turn_finely(rubber[some, :, b])
            force[:, :2] += StopContact.of(
                _round_the_half_turn_finely(travel[some, :, 2 * b : 2 * b + 2]),
                stiffness=stiffness[some, b], stop=stop[some, b], ratio=ratio[some, b],
            ).force  # fmt: skip
            mean = force.mean(axis=-1)
            force -= mean[..., None]
            static[some, b] = np.linalg.norm(mean, axis=-1)
            dynamic[some, b] = np.sqrt((force * force).sum(axis=1).max(axis=-1))
    return ForcesAtStop(static=static, dynamic=dynamic)


def largest_travel(travel: FloatArray) -> FloatArray:
    """Return the largest way across the shaft round the half turn of P motions, (P, B) m.

    `travel` (P, M, 2 B) m are components as `StoppedLine.free` has them.
    """
    found = np.empty((len(travel), travel.shape[-1] // 2))
    for b in range(found.shape[1]):
        for start in range(0, len(travel), _BLOCK_MOTIONS):
            some = slice(start, start + _BLOCK_MOTIONS)
            x = _round_the_half_turn_finely(travel[some, :, 2 * b : 2 * b + 2])
            found[some, b] = np.sqrt((x[:, 0] ** 2 + x[:, 1] ** 2).max(axis=-1))
    return found


def _round_the_half_turn_finely(of: FloatArray) -> FloatArray:
    """Return components (P, M, D) at `FINE_SAMPLES` angles of a half turn, (P, D, FINE_SAMPLES)."""
    found = np.ascontiguousarray(of.mT).reshape(-1, _COMPONENTS) @ _FINE_BASIS
    return found.reshape(len(of), -1, FINE_SAMPLES)


def components(mean: FloatArray, waves: ComplexArray) -> FloatArray:
    """Return a mean (..., D) and orders 2, 4, ... (..., K, D) as components (..., M, D)."""
    found = np.zeros((*mean.shape[:-1], _COMPONENTS, mean.shape[-1]))
    found[..., 0, :] = mean
    count = 2 * waves.shape[-2]
    found[..., 1 : 1 + count : 2, :] = waves.real
    found[..., 2 : 2 + count : 2, :] = waves.imag
    return found


def round_the_half_turn(of: FloatArray) -> FloatArray:
    """Return components (..., M, D) at `SAMPLES` angles of a half turn, (..., SAMPLES, D)."""
    return _BASIS.T @ of


def at_places(values: FloatArray, place: FloatArray, cases: IntArray | None = None) -> FloatArray:
    """Return values (Q, C, ...) at places (T, C) or (C,) between the speeds, linear between two.

    Of all cases, or of those that `cases` names.
    """
    last = len(values) - 1
    of = np.arange(values.shape[1]) if cases is None else cases
    place = np.where(np.isnan(place), 0.0, place)
    low = np.minimum(place.astype(int), max(last - 1, 0))
    share = place - low
    share = share.reshape(*share.shape, *(1,) * (values.ndim - 2))
    if not share.any():
        return values[low, of]
    return (1 - share) * values[low, of] + share * values[np.minimum(low + 1, last), of]


def all_motions(line: StoppedLine) -> StoppedMotion:
    """Return how lines with stops move, followed up the speeds, and down where that has others.

    A stop that is met now and then stiffens a line: its large motions begin at low speeds. Of
    one that leaves its stop now and then they begin at high ones.
    """
    mean = line.free[..., 0, :]
    far = np.linalg.norm(mean.reshape(*mean.shape[:-1], -1, 2), axis=-1)
    rests = np.flatnonzero((far > line.stop).any(axis=(0, -1)))
    cases = line.free.shape[1]
    if not len(rests):
        return followed_motion(line)
    every = np.concatenate([np.arange(cases), rests])
    both = followed_motion(line.select_cases(every), backwards=np.arange(len(every)) >= cases)
    place = np.full((len(both.place), cases), np.nan)
    travel = np.zeros((*place.shape, *both.travel.shape[2:]))
    place[:, rests], travel[:, rests] = both.place[:, cases:], both.travel[:, cases:]
    return StoppedMotion(
        place=np.concatenate([both.place[:, :cases], place]),
        travel=np.concatenate([both.travel[:, :cases], travel]),
    )


def followed_motion(line: StoppedLine, *, backwards: BoolArray | bool = False) -> StoppedMotion:
    """Return how lines with stops move, followed from the first speed to the last.

    Or from the last to the first, of cases (C,) that are followed `backwards`. On from a large
    motion it stays large, as far as there is one: steps are halved where it turns back, and at
    `_LEAST_STEP` it is lost, and falls to the next one that is found from linear rubber, by ever
    stiffer stops. Newton's steps of all cases are taken in one batch, each case at its own place.
    """
    count, cases = line.free.shape[:2]
    sense = np.where(backwards, -1.0, np.ones(cases))
    end = np.where(sense < 0, 0.0, count - 1.0)
    place = np.where(sense < 0, float(count), -1.0)  # one before the first
    there, h, step = place.copy(), np.ones(cases), np.ones(cases)
    before, slope = at_places(line.free, place + sense), np.zeros_like(line.free[0])
    is_lost, is_first = (np.ones(cases, dtype=bool) for _ in range(2))
    stage = np.zeros(cases, dtype=int)  # of `_STIFFENING`; after the last it is followed
    begun = before.copy()
    under_way = _NewtonSolution.of(line)
    told: list[tuple[IntArray, FloatArray, FloatArray]] = []
    fresh: IntArray = np.arange(cases)
    for _ in range(_MOST_STEPS):
        ahead = sense[fresh] * place[fresh]  # no step passes a speed of the grid: crests are there
        h[fresh] = np.minimum(step[fresh], np.floor(ahead + 1e-9) + 1 - ahead)
        there[fresh] = place[fresh] + sense[fresh] * h[fresh]
        begins = (stage[fresh] < _FOLLOWED)[:, None, None]
        guess = np.where(begins, begun[fresh], before[fresh] + h[fresh, None, None] * slope[fresh])
        under_way.begin(
            fresh,
            there[fresh],
            guess,
            share=_SHARES[stage[fresh]],
            is_followed=~begins[:, 0, 0] & ~is_lost[fresh],
        )
        some, found, ok = under_way.advance()
        lost, begins = is_lost[some], stage[some] < _FOLLOWED
        away = under_way.strays(some) > _LARGEST_JUMP
        ok &= lost | ~away
        # What is lost and not found on from where it was begins from linear rubber.
        stage[some[begins]] += 1
        begun[some[begins]] = found[begins]
        again = lost & ~ok & ~begins
        stage[some[again]] = 0
        begun[some[again]] = at_places(line.free, there[some[again]], some[again])
        rest = some[again | (stage[some] < _FOLLOWED)]
        ended = ~again & (stage[some] == _FOLLOWED)
        some, found, ok, lost = some[ended], found[ended], ok[ended], lost[ended]
        # Where it turns back: once more from there at the next place, then from linear rubber.
        went = h[some]
        short = ~ok & ~lost & (went > _LEAST_STEP)
        straight = ok & ~lost
        step[some] = np.where(short, went / 2, np.where(straight, np.minimum(2 * went, 1.0), 1.0))
        bent = np.where(straight[:, None, None], (found - before[some]) / went[:, None, None], 0.0)
        slope[some] = np.where(short[:, None, None], slope[some], bent)
        known, on = ok | is_first[some], some[~short]
        before[some[known]], place[on] = found[known], there[on]
        is_first[some] = False
        is_lost[on] = ~ok[~short]
        told.append((some[ok], there[some[ok]], found[ok]))
        fresh = np.concatenate([rest, some[sense[some] * (end[some] - place[some]) > 1e-9]])
        if not (len(fresh) or under_way.is_busy.any()):
            break
    return _by_case(told, cases)


def _by_case(told: list[tuple[IntArray, FloatArray, FloatArray]], cases: int) -> StoppedMotion:
    """Return motions that were found one after another, cases with their places and travel."""
    case, place, travel = (np.concatenate(v) for v in zip(*told, strict=True))
    order = np.argsort(case, kind="stable")
    counts = np.bincount(case, minlength=cases)
    row = np.empty_like(case)
    row[order] = np.arange(len(case)) - np.repeat(np.cumsum(counts) - counts, counts)
    places = np.full((max(int(counts.max()), 1), cases), np.nan)
    travels = np.zeros((*places.shape, *travel.shape[1:]))
    places[row, case], travels[row, case] = place, travel
    return StoppedMotion(place=places, travel=travels)


@dataclass(frozen=True, kw_only=True, eq=False)
class _NewtonSolution:
    """Solutions of X = X₀ - C F(X) of cases, each as far as its Newton's method is.

    Attributes
    ----------
    X, free, guess : (C, M, 2 B) m
        As far as found, on linear rubber, and where it began.
    tied, alone
        Receptances of the cases, as `StopReceptance` has them.
    ratio : (C, B)
    steps : (C,)
    is_busy, is_linear, is_followed : (C,)
        Whether a case is being solved; whether its rubber meets no stop; whether X is used only
        where Newton's method ends near the guess.
    nearest : (C,) m
        Least travel to a stop.
    """

    line: StoppedLine
    X: FloatArray
    free: FloatArray
    guess: FloatArray
    tied: FloatArray
    alone: FloatArray
    ratio: FloatArray
    steps: IntArray
    is_busy: BoolArray
    is_linear: BoolArray
    is_followed: BoolArray
    nearest: FloatArray

    @classmethod
    def of(cls, line: StoppedLine) -> "_NewtonSolution":
        """Return that of no case."""
        cases = line.free.shape[1]
        return cls(
            line=line,
            **{name: np.zeros_like(line.free[0]) for name in ("X", "free", "guess")},
            **{
                name: np.zeros((cases, *getattr(line.receptance, name).shape[2:]))
                for name in ("tied", "alone")
            },
            ratio=line.ratio.copy(),
            steps=np.zeros(cases, dtype=int),
            **{name: np.zeros(cases, dtype=bool) for name in ("is_busy", "is_linear", "is_followed")},
            nearest=line.stop.min(-1),
        )  # fmt: skip

    def begin(
        self,
        some: IntArray,
        place: FloatArray,
        guess: FloatArray,
        *,
        share: FloatArray,
        is_followed: BoolArray,
    ) -> None:
        """Begin `some` cases at places, with their ratio of stiffness to the power of `share`."""
        if not len(some):
            return
        line, stop = self.line, self.line.stop[some]
        free = at_places(line.free, place, some)
        beyond = _reaches(guess, stop)
        beyond[~beyond] = _reaches(free[~beyond], stop[~beyond])
        self.X[some] = np.where(beyond[:, None, None], guess, free)
        self.free[some], self.guess[some], self.is_followed[some] = free, guess, is_followed
        self.steps[some], self.is_busy[some], self.is_linear[some] = 0, True, ~beyond
        on = some[beyond]
        self.tied[on], self.alone[on] = line.receptance.at_places(place[beyond], on)
        self.ratio[on] = line.ratio[on] ** share[beyond, None]

    def advance(self) -> tuple[IntArray, FloatArray, BoolArray]:
        """Take steps until half of the cases end; return these, X, and whether it is a motion.

        It is none where Newton's method does not end, or at an unstable one.
        """
        linear = np.flatnonzero(self.is_busy & self.is_linear)
        some = np.flatnonzero(self.is_busy & ~self.is_linear)
        ended, ok = [linear], [np.ones(len(linear), dtype=bool)]
        enough = (len(some) + 1) // 2
        while len(some) and len(some) >= enough:
            at = _Pushes.of(self, some)
            left = np.abs(at.left).max(axis=(1, 2)) / self.nearest[some]
            done = left <= _RESIDUAL_SHARE
            to_go = _ITERATIONS - self.steps[some]
            lost = (to_go == 1) | ((to_go == 2) & (left > _HOPELESS_RESIDUAL))
            lost = self.is_followed[some] & (lost | (self.strays(some) > _LARGEST_STRAY))
            stable = at.advance(self, done, ~done & ~lost)
            self.steps[some] += ~done
            last = lost | (to_go == 1)
            over = done | last
            if over.any():
                ended.append(some[over])
                ok.append((done & stable)[over])
                some = some[~over]
        every = np.concatenate(ended)
        self.is_busy[every] = False
        return every, self.X[every], np.concatenate(ok)

    def strays(self, some: IntArray) -> FloatArray:
        """Return how far X is off its guess in some cases, of the travel to the stop, (C',)."""
        return np.abs(self.X[some] - self.guess[some]).max(axis=(1, 2)) / self.nearest[some]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Pushes:
    """What stops do to cases C' of a Newton's method, at P contacts of bearings with their stops.

    Attributes
    ----------
    some : (C',)
    left : (C', M, 2 B) m
        Residual of X = X₀ - C F(X).
    met : (C', B)
        Which bearings meet their stops.
    first : (C',)
        Contact of each case's first one, or where it would be.
    contact
        What stops do to these, in order.
    """

    some: IntArray
    left: FloatArray
    met: BoolArray
    first: IntArray
    contact: StopContact

    @classmethod
    def of(cls, solution: _NewtonSolution, some: IntArray) -> "_Pushes":
        """Return those of `some` cases as far as they are."""
        line, X = solution.line, solution.X[some]
        count, _, size = X.shape
        x = np.ascontiguousarray(X.mT).reshape(-1, _COMPONENTS) @ _BASIS
        x = x.reshape(count, size // 2, 2, SAMPLES)
        met = (x[:, :, 0] ** 2 + x[:, :, 1] ** 2).max(axis=-1) > line.stop[some] ** 2
        case, bearing = np.nonzero(met)
        own = some[case], bearing
        contact = StopContact.of(
            x[met], stiffness=line.stiffness[own], stop=line.stop[own], ratio=solution.ratio[own]
        )
        push = np.zeros((*met.shape, 2, _COMPONENTS))
        push[met] = (contact.force.reshape(-1, SAMPLES) @ _PROJECTION).reshape(-1, 2, _COMPONENTS)
        force = push.transpose(0, 3, 1, 2).reshape(count, -1, 1)
        left = X - solution.free[some]
        left += _moved_by(solution.tied[some], solution.alone[some], force).reshape(X.shape)
        first = np.searchsorted(case, np.arange(count))
        return cls(some=some, left=left, met=met, first=first, contact=contact)

    def advance(
        self, solution: _NewtonSolution, done: BoolArray, goes_on: BoolArray
    ) -> BoolArray:
        """Take a step in cases that go on; return whether those that are `done` are stable, (C',).

        Cases whose stops are met at the same bearings are solved at once, these bearings alone:
        the others follow.
        """
        stable = np.ones(len(done), dtype=bool)
        asked = np.flatnonzero(done | goes_on)
        codes = self.met[asked] @ (1 << np.arange(self.met.shape[1]))
        slopes = (self.contact.slope.reshape(-1, SAMPLES) @ _PAIRS).reshape(-1, 3 * _PAIRS.shape[1])
        for code in set(codes.tolist()):
            alike = asked[codes == code]
            if not code:
                alike = alike[goes_on[alike]]
                solution.X[self.some[alike]] -= self.left[alike]
                continue
            at_once = max(1, _BLOCK_MATRICES // int(self.met[alike[0]].sum()) ** 2)
            for start in range(0, len(alike), at_once):
                rows = alike[start : start + at_once]
                rows = np.concatenate([rows[~goes_on[rows]], rows[goes_on[rows]]])
                ended = len(rows) - int(goes_on[rows].sum())
                stable[rows[:ended]] = self._solve(solution, slopes, rows, ended)
        return stable

    def _solve(
        self, solution: _NewtonSolution, slopes: FloatArray, rows: IntArray, ended: int
    ) -> BoolArray:
        """Take a step in cases that meet the same stops, but those that ended, which come first.

        Return whether these are stable. `slopes` are those of contacts by pairs of components.
        """
        met, some, left = np.flatnonzero(self.met[rows[0]]), self.some[rows], self.left[rows]
        tied, alone = solution.tied[some], solution.alone[some]
        contacts = self.first[rows, None] + np.arange(len(met))
        J = _by_components(slopes[contacts])
        every, own = len(met) == self.met.shape[1], np.ravel(2 * met[:, None] + [0, 1])
        moves = (tied, alone) if every else (_part(tied, own, 5), _part(alone, own, 2))
        matrix = _moved_by(*moves, J)
        matrix.reshape(len(rows), -1)[:, :: matrix.shape[-1] + 1] += 1
        stable = np.linalg.slogdet(matrix[:ended])[0] > 0 if ended else np.ones(0, dtype=bool)
        if ended == len(rows):
            return stable
        step, going = left[ended:], len(rows) - ended
        moved = np.linalg.solve(matrix[ended:], step[..., own].reshape(going, -1, 1))
        if every:
            step = moved.reshape(step.shape)
        else:
            push = np.zeros_like(step)
            push[..., own] = (J[ended:] @ moved).reshape(going, _COMPONENTS, -1)
            back = _moved_by(tied[ended:], alone[ended:], push.reshape(going, -1, 1))
            step = step - back.reshape(step.shape)
        solution.X[some[ended:]] -= step
        return stable


def _by_components(slopes: FloatArray) -> FloatArray:
    """Return slopes (C', B', 3 K) by pairs of components as matrices, (C', M 2B', M 2B')."""
    count, bearings = slopes.shape[:2]
    each = np.take(slopes, _PLACES_OF_PAIRS.ravel(), axis=2)
    each = each.reshape(count, bearings, *_PLACES_OF_PAIRS.shape)
    if bearings == 1:
        return each.reshape(count, 2 * _COMPONENTS, -1)
    found = np.zeros((count, _COMPONENTS, bearings, 2, _COMPONENTS, bearings, 2))
    for b in range(bearings):
        found[:, :, b, :, :, b, :] = each[:, b]
    return found.reshape(count, _COMPONENTS * 2 * bearings, -1)


def _part(receptance: FloatArray, own: IntArray, parts: int) -> FloatArray:
    """Return the receptance (..., `parts` D, `parts` D) of some of D travels and forces."""
    size = receptance.shape[-1] // parts
    which = np.ravel(size * np.arange(parts)[:, None] + own)
    return receptance[..., which[:, None], which]


def _moved_by(tied: FloatArray, alone: FloatArray, forces: FloatArray) -> FloatArray:
    """Return what receptances as `StopReceptance` has them make of forces (C', M D, R)."""
    first = tied.shape[-1]
    found = np.empty_like(forces)
    found[:, :first] = tied @ forces[:, :first]
    rest = forces[:, first:].reshape(*alone.shape[:-1], -1)
    found[:, first:] = (alone @ rest).reshape(len(forces), -1, forces.shape[-1])
    return found


def _reaches(travel: FloatArray, stop: FloatArray) -> BoolArray:
    """Return whether a motion (C, M, 2 B) reaches a stop (C, B), in its largest sum at least."""
    x = np.ascontiguousarray(travel.mT).reshape(-1, _COMPONENTS) @ _BASIS
    x = x.reshape(*stop.shape, 2, SAMPLES)
    return ((x[:, :, 0] ** 2 + x[:, :, 1] ** 2).max(axis=-1) > stop**2).any(axis=-1)
