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

import numpy as np

from cardan.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
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
_LARGEST_JUMP = 0.3
"""Of the travel to the stop, off where it was expected: more is another motion."""
_MOST_STEPS = 1000
_RESIDUAL_SHARE = 1e-4
"""Of the travel to the stop, below which Newton's method ends."""

_LAST_TIED_ORDER = 4
_PLACES_OF_ORDERS = tuple(zip(range(1, 2 * len(STOP_ORDERS), 2), STOP_ORDERS, strict=True))
_COMPONENTS = 1 + 2 * len(STOP_ORDERS)


def _basis(samples: int) -> FloatArray:
    """Return what components are at angles of a half turn, (samples, M)."""
    angles = np.pi / samples * np.outer(np.arange(samples), np.array(STOP_ORDERS))
    found = np.ones((samples, _COMPONENTS))
    found[:, 1::2], found[:, 2::2] = np.cos(angles), -np.sin(angles)
    return found


_BASIS, _FINE_BASIS = _basis(SAMPLES), _basis(FINE_SAMPLES)
_PROJECTION = 2 * _BASIS.T / SAMPLES
_PROJECTION[0] /= 2
_PAIRS = (_PROJECTION[:, None, :] * _BASIS.T).reshape(-1, SAMPLES)


@dataclass(frozen=True, kw_only=True, eq=False)
class StoppedLine:
    """Lines whose rubber has stops, at speeds Q of cases C; B bearings, two directions each.

    Attributes
    ----------
    free : (Q, C, M, 2 B) m
        Travel on linear rubber across the shafts, M components: mean, then real and imaginary
        part of each of `STOP_ORDERS`.
    receptance : (Q, C, M 2B, M 2B) m/N
        What a stop's forces at the bearings move them, with what it loses; components as `free`
        has them.
    stiffness : (C, B, 2) N/m
    stop : (C, B) m
        Travel to the stop; inf where there is none.
    ratio : (C, B)
        Stiffness beyond it over that before it.
    """

    free: FloatArray
    receptance: FloatArray
    stiffness: FloatArray
    stop: FloatArray
    ratio: FloatArray

    def select_cases(self, which: IntArray) -> "StoppedLine":
        """Return some of the cases."""
        return StoppedLine(
            free=self.free[:, which],
            receptance=self.receptance[:, which],
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


def stop_forces(
    travel: FloatArray, *, stiffness: FloatArray, stop: FloatArray, ratio: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return what stops add to the rubber's force, (..., B, 2) N, and its slope (..., B, 2, 2).

    For `travel` (C, J, B, 2) m at J instants, stiffness (C, B, 2) N/m, stop and ratio (C, B) m, 1.
    """
    square = travel[..., 0] ** 2 + travel[..., 1] ** 2
    force, slope = np.zeros_like(travel), np.zeros((*travel.shape, 2))
    there = np.nonzero(square > stop[:, None] ** 2)
    if not len(there[0]):
        return force, slope
    of = there[0], there[2]
    x, K, more = travel[there], stiffness[of], ratio[of] - 1
    u = np.sqrt(square[there])
    gap = u - stop[of]
    g = gap / u
    n1, n2 = x[:, 0] / u, x[:, 1] / u
    k = K[:, 0] * n1**2 + K[:, 1] * n2**2
    # V = (r - 1) k gap²/2, and k' = 2 s/u across n.
    s1, s2 = (K[:, 0] - k) * n1, (K[:, 1] - k) * n2
    force[there] = (more * gap)[:, None] * np.stack([k * n1 + g * s1, k * n2 + g * s2], axis=-1)
    rest = g * (1 - g)
    both = k * (1 - g)  # k n n' + g (k (1 - n n') + 2 (n s' + s n')) + g² (K - k - 2 (n s' + s n'))
    slope[(*there, 0, 0)] = more * (
        both * n1 * n1 + g * k + 4 * rest * n1 * s1 + g**2 * (K[:, 0] - k)
    )
    slope[(*there, 1, 1)] = more * (
        both * n2 * n2 + g * k + 4 * rest * n2 * s2 + g**2 * (K[:, 1] - k)
    )
    slope[(*there, 0, 1)] = slope[(*there, 1, 0)] = more * (
        both * n1 * n2 + 2 * rest * (n1 * s2 + n2 * s1)
    )
    return force, slope


def stop_receptance(
    on: MountedLine,
    coupling: ComplexArray,
    *,
    speed: FloatArray,
    torque: FloatArray,
    compression: FloatArray,
) -> FloatArray:
    """Return what a stop's forces at the bearings move them, (..., M 2B, M 2B) m/N.

    Of a line in small motion at a speed rad/s under a torque N m, signed, whose order 2
    (`coupling` (..., N, N) of 1 N m, `MountedLine.order2_coupling`) ties orders 0, 2 and 4.
    A compression (...) N of the spline, which slides, takes stiffness off the mean.
    Components as `StoppedLine.free` has them, by the angle of the turn.
    """
    N = on.mass.shape[-1]
    across = on.bearing[..., :2, :].reshape(*on.bearing.shape[:-3], -1, N)
    loss = np.sign(speed)[..., None] * np.repeat(on.loss, 2, axis=-1)
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
    rows = np.broadcast_to(across, (*cases, size, N))
    found = np.zeros((*cases, _COMPONENTS, size, _COMPONENTS, size))
    for at, order in _PLACES_OF_ORDERS:
        D = on.dynamic_stiffness(order * speed, speed, torque)
        if order <= _LAST_TIED_ORDER:
            tied[..., at, :, at, :] = tied[..., at + 1, :, at + 1, :] = D.real
            tied[..., at, :, at + 1, :], tied[..., at + 1, :, at, :] = -D.imag, D.imag
        else:
            H = rows @ np.linalg.solve(D, rows.mT.astype(complex))
            found[..., at, :, at, :] = found[..., at + 1, :, at + 1, :] = H.real
            found[..., at, :, at + 1, :], found[..., at + 1, :, at, :] = -H.imag, H.imag
    each = np.zeros((*cases, 5, N, 5, size))
    for k in range(5):
        each[..., k, :, k, :] = rows.mT
    pushes = each.reshape(*cases, 5 * N, 5 * size)
    moved = pushes.mT @ np.linalg.solve(tied.reshape(*cases, 5 * N, 5 * N), pushes)
    found[..., :5, :, :5, :] = moved.reshape(*cases, 5, size, 5, size)
    for at, order in _PLACES_OF_ORDERS:  # of what is lost, order by order: times 1 + i η m/2
        lost = order / 2 * loss[..., None, None, :]
        real, imaginary = found[..., at, :].copy(), found[..., at + 1, :].copy()
        found[..., at, :] = real + lost * imaginary
        found[..., at + 1, :] = imaginary - lost * real
    return found.reshape(*cases, _COMPONENTS * size, _COMPONENTS * size)


@dataclass(frozen=True, kw_only=True, eq=False)
class ForcesAtStop:
    """Forces on bearings whose rubber meets its stop, (..., B) N.

    Attributes
    ----------
    static, dynamic
        Size of the mean; largest size of the rest round the half turn.
    travel : (..., B) m
        Largest way across the shaft.
    """

    static: FloatArray
    dynamic: FloatArray
    travel: FloatArray


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
    """Return what bearings carry in a motion with stops: of a stop its elastic force.

    What it loses is in the motion. A damper's force jumps where a stop is met, rubber's does not.

    Parameters
    ----------
    travel, free : (..., M, 2 B) m
        With stops, and on linear rubber.
    linear : (..., M, 3 B) N
        Force on linear rubber, across the shaft, then along it, bearing by bearing.
    stiffness, loss, stop, ratio : (..., B, 2) N/m, (..., B) signed as the speed, (..., B) m, 1
    """
    size = travel.shape[-1]
    lead, bearings = travel.shape[:-2], size // 2
    more = stiffness.reshape(*stiffness.shape[:-2], 1, size) * (travel - free)
    eta = np.repeat(loss, 2, axis=-1)
    for at, _ in _PLACES_OF_ORDERS:
        real, imaginary = more[..., at, :].copy(), more[..., at + 1, :].copy()
        more[..., at, :] = real - eta * imaginary
        more[..., at + 1, :] = imaginary + eta * real
    rubber = np.broadcast_to(linear, (*lead, *linear.shape[-2:]))
    rubber = rubber.reshape(*lead, -1, bearings, 3).copy()
    rubber[..., :2] += more.reshape(*lead, -1, bearings, 2)
    force = (_FINE_BASIS @ rubber.reshape(*lead, -1, 3 * bearings)).reshape(*lead, -1, bearings, 3)
    x = (_FINE_BASIS @ travel).reshape(*lead, -1, bearings, 2)
    pushed, _ = stop_forces(x, stiffness=stiffness, stop=stop, ratio=ratio)
    force[..., :2] += pushed
    mean = force.mean(axis=-3)
    swing = np.linalg.norm(force - mean[..., None, :, :], axis=-1).max(-2)
    far = np.sqrt((x**2).sum(-1).max(-2))
    return ForcesAtStop(static=np.linalg.norm(mean, axis=-1), dynamic=swing, travel=far)


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
    return _BASIS @ of


def at_places(values: FloatArray, place: FloatArray, cases: IntArray | None = None) -> FloatArray:
    """Return values (Q, C, ...) at places (T, C) or (C,) between the speeds, linear between two.

    Of all cases, or of those that `cases` names.
    """
    last = len(values) - 1
    of = np.arange(values.shape[1]) if cases is None else cases
    low = np.clip(np.floor(np.nan_to_num(place)), 0, max(last - 1, 0)).astype(int)
    share = np.nan_to_num(place) - low
    share = share.reshape(*share.shape, *(1,) * (values.ndim - 2))
    return (1 - share) * values[low, of] + share * values[np.minimum(low + 1, last), of]


def all_motions(line: StoppedLine) -> StoppedMotion:
    """Return how lines with stops move, followed up the speeds, and down where that has others.

    A stop that is met now and then stiffens a line: its large motions begin at low speeds. Of
    one that leaves its stop now and then they begin at high ones.
    """
    up = followed_motion(line)
    mean = line.free[..., 0, :]
    far = np.linalg.norm(mean.reshape(*mean.shape[:-1], -1, 2), axis=-1)
    rests = np.flatnonzero((far > line.stop).any(axis=(0, -1)))
    if not len(rests):
        return up
    down = followed_motion(line.select_cases(rests), backwards=True)
    place = np.full((len(down.place), up.place.shape[1]), np.nan)
    travel = np.zeros((len(down.place), *up.travel.shape[1:]))
    place[:, rests], travel[:, rests] = down.place, down.travel
    return StoppedMotion(
        place=np.concatenate([up.place, place]), travel=np.concatenate([up.travel, travel])
    )


def followed_motion(line: StoppedLine, *, backwards: bool = False) -> StoppedMotion:
    """Return how lines with stops move, followed from the first speed to the last.

    Or from the last to the first. On from a large motion it stays large, as far as there is one:
    steps are halved where it turns back, and at `_LEAST_STEP` it is lost, and falls to the next
    one that is found from linear rubber.
    """
    count, cases = line.free.shape[:2]
    sense = -1.0 if backwards else 1.0
    place = np.full(cases, count - 1.0 if backwards else 0.0)
    end = 0.0 if backwards else count - 1.0
    travel, ok = _begun_at(line, place, np.arange(cases))
    places, travels = [np.where(ok, place, np.nan)], [travel]
    before, step, slope = travel.copy(), np.ones(cases), np.zeros_like(travel)
    is_lost = ~ok
    while len(places) < _MOST_STEPS:
        some = np.flatnonzero(sense * (end - place) > 1e-9)
        if not len(some):
            break
        ahead = sense * place[some]  # no step passes a speed of the grid: crests are among them
        h = np.minimum(step[some], np.floor(ahead + 1e-9) + 1 - ahead)
        there = place[some] + sense * h
        lost = is_lost[some]
        guess = before[some] + h[:, None, None] * slope[some]
        found, ok = _solved_at(line, there, some, guess)
        away = np.abs(found - guess).max((1, 2)) > _LARGEST_JUMP * line.stop[some].min(-1)
        ok &= lost | ~away
        if (begun := lost & ~ok).any():
            found[begun], ok[begun] = _begun_at(line, there[begun], some[begun])
        # Where it turns back: once more from there at the next place, then from linear rubber.
        short = ~ok & ~lost & (h > _LEAST_STEP)
        step[some] = np.where(short, h / 2, np.where(ok & ~lost, np.minimum(2 * h, 1.0), 1.0))
        straight = (ok & ~lost)[:, None, None]
        slope[some] = np.where(
            short[:, None, None],
            slope[some],
            np.where(straight, (found - before[some]) / h[:, None, None], 0.0),
        )
        good, on = some[ok], some[~short]
        before[good], place[on] = found[ok], there[~short]
        is_lost[on] = ~ok[~short]
        at, of = np.full(cases, np.nan), before.copy()
        at[good] = there[ok]
        places.append(at)
        travels.append(of)
    return StoppedMotion(place=np.stack(places), travel=np.stack(travels))


def _begun_at(line: StoppedLine, place: FloatArray, some: IntArray) -> tuple[FloatArray, BoolArray]:
    """Return motions of `some` cases at places from linear rubber on, by ever stiffer stops."""
    guess = at_places(line.free, place, some)
    ok = np.ones(len(some), dtype=bool)
    for share in _STIFFENING:
        guess, ok = _solved_at(line, place, some, guess, share=share)
    return guess, ok


def _solved_at(
    line: StoppedLine, place: FloatArray, some: IntArray, guess: FloatArray, *, share: float = 1.0
) -> tuple[FloatArray, BoolArray]:
    """Return the motions of `some` cases at places, (C', M, 2B), and whether there is one.

    With their ratio of stiffness to the power of `share`.
    """
    free = at_places(line.free, place, some)
    stop = line.stop[some]
    found, ok = free.copy(), np.ones(len(some), dtype=bool)
    on = np.flatnonzero(_reaches(free, stop) | _reaches(guess, stop))
    if len(on):
        X, ok[on] = _newton(
            guess[on].reshape(len(on), -1),
            free[on].reshape(len(on), -1),
            at_places(line.receptance, place[on], some[on]),
            line.stiffness[some[on]], stop[on], line.ratio[some[on]] ** share,
            bearings=stop.shape[-1],
        )  # fmt: skip
        found[on] = X.reshape(len(on), *free.shape[1:])
    return found, ok


def _reaches(travel: FloatArray, stop: FloatArray) -> BoolArray:
    """Return whether a motion (C, M, 2 B) reaches a stop (C, B), in its largest sum at least."""
    x = round_the_half_turn(travel)
    far = (x.reshape(*x.shape[:-1], -1, 2) ** 2).sum(-1).max(-2)
    return (far > stop**2).any(-1)


def _newton(
    start: FloatArray,
    free: FloatArray,
    moves: FloatArray,
    stiffness: FloatArray,
    stop: FloatArray,
    ratio: FloatArray,
    *,
    bearings: int,
) -> tuple[FloatArray, BoolArray]:
    """Return X (C, M 2B) of X = X₀ - C F(X), and whether it is found and stable."""
    cases, unknown = start.shape
    size = 2 * bearings
    one = np.eye(unknown)
    least = _RESIDUAL_SHARE * np.where(np.isfinite(stop), stop, np.inf).min(-1)

    def pushed(X: FloatArray, some: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the residual and Newton's matrix."""
        count = len(X)
        x = round_the_half_turn(X.reshape(count, _COMPONENTS, size))
        force, slope = stop_forces(
            x.reshape(count, SAMPLES, bearings, 2),
            stiffness=stiffness[some], stop=stop[some], ratio=ratio[some],
        )  # fmt: skip
        F = (_PROJECTION @ force.reshape(count, SAMPLES, size)).reshape(count, unknown)
        flat = slope.reshape(count, SAMPLES, bearings * 4)
        D = (_PAIRS @ flat).reshape(count, _COMPONENTS, _COMPONENTS, bearings, 2, 2)
        J = np.zeros((count, _COMPONENTS, bearings, 2, _COMPONENTS, bearings, 2))
        for b in range(bearings):
            J[:, :, b, :, :, b, :] = D[:, :, :, b].transpose(0, 1, 3, 2, 4)
        left = X - free[some] + (moves[some] @ F[..., None])[..., 0]
        return left, one + moves[some] @ J.reshape(count, unknown, unknown)

    X, ok = start.copy(), np.zeros(cases, dtype=bool)
    some = np.arange(cases)
    left, matrix = pushed(X, some)
    for _ in range(_ITERATIONS):
        size_now = np.abs(left).max(-1)
        done = size_now <= least[some]
        if done.any():
            here = np.linalg.slogdet(matrix[done])[0] > 0
            ok[some[done]] = here
            some, left, matrix, size_now = some[~done], left[~done], matrix[~done], size_now[~done]
            if not len(some):
                break
        X[some] -= np.linalg.solve(matrix, left[..., None])[..., 0]
        left, matrix = pushed(X[some], some)
    return X, ok
