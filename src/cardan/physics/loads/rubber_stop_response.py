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

from cardan.core.arrays import BoolArray, FloatArray, IntArray
from cardan.core.lazy_dataclass import dataclass
from cardan.physics.loads.rubber_stop_newton import NewtonSolution
from cardan.physics.loads.rubber_stop_receptance import StoppedLine, at_places

STOP_STIFFNESS_RANGE = (5.0, 20.0)
"""Stiffness of rubber beyond its stop over that before it: assumed where no file gives it."""

_LEAST_STEP = 1 / 16
"""Of the way between two speeds, at which a motion that is followed is given up as lost."""
_STIFFENING = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Powers of the ratio of stiffness by which a motion is found from that of linear rubber."""
_FOLLOWED = len(_STIFFENING)
_SHARES = np.append(_STIFFENING, 1.0)
_LARGEST_JUMP = 0.3
"""Of the travel to the stop, off where it was expected: more is another motion."""
_MOST_STEPS = 8000


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
    under_way = NewtonSolution.of(line)
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
