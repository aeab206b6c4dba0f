"""Newton's method for lines whose rubber meets its stop, many cases at once.

The equations: `cardan.physics.loads.rubber_stop_response`.
"""

import numpy as np

from cardan.core.arrays import BoolArray, FloatArray, IntArray
from cardan.core.lazy_dataclass import dataclass
from cardan.physics.loads.rubber_stop_contact import (
    BASIS,
    COMPONENTS,
    PAIRS,
    PLACES_OF_PAIRS,
    PROJECTION,
    SAMPLES,
    StopContact,
)
from cardan.physics.loads.rubber_stop_receptance import StoppedLine, at_places, moved_by

_ITERATIONS = 6
_LARGEST_STRAY = 1.0
"""Of the travel to the stop, off its guess at which a motion that is followed is given up.

None comes back: of 19 000 motions found on examples and their variants none went beyond 0.65.
"""
_HOPELESS_RESIDUAL = 1.0
"""Of the travel to the stop: the last step of Newton's method has not made up for more than 0.6."""
_RESIDUAL_SHARE = 1e-4
"""Of the travel to the stop, below which Newton's method ends."""
_BLOCK_MATRICES = 24
"""Of one bearing, put together at once: more of them leave the cache."""


@dataclass(frozen=True, kw_only=True, eq=False)
class NewtonSolution:
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
    def of(cls, line: StoppedLine) -> "NewtonSolution":
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
            **{
                name: np.zeros(cases, dtype=bool)
                for name in ("is_busy", "is_linear", "is_followed")
            },
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
        """Take steps until a quarter of the cases end; return these, X, and whether it is a motion.

        It is none where Newton's method does not end, or at an unstable one.
        """
        linear = np.flatnonzero(self.is_busy & self.is_linear)
        some = np.flatnonzero(self.is_busy & ~self.is_linear)
        ended, ok = [linear], [np.ones(len(linear), dtype=bool)]
        enough = (3 * len(some) + 3) // 4
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
    def of(cls, solution: NewtonSolution, some: IntArray) -> "_Pushes":
        """Return those of `some` cases as far as they are."""
        line, X = solution.line, solution.X[some]
        count, _, size = X.shape
        x = np.ascontiguousarray(X.mT).reshape(-1, COMPONENTS) @ BASIS
        x = x.reshape(count, size // 2, 2, SAMPLES)
        met = (x[:, :, 0] ** 2 + x[:, :, 1] ** 2).max(axis=-1) > line.stop[some] ** 2
        case, bearing = np.nonzero(met)
        own = some[case], bearing
        contact = StopContact.of(
            x[met], stiffness=line.stiffness[own], stop=line.stop[own], ratio=solution.ratio[own]
        )
        push = np.zeros((*met.shape, 2, COMPONENTS))
        push[met] = (contact.force.reshape(-1, SAMPLES) @ PROJECTION).reshape(-1, 2, COMPONENTS)
        force = push.transpose(0, 3, 1, 2).reshape(count, -1, 1)
        left = X - solution.free[some]
        left += moved_by(solution.tied[some], solution.alone[some], force).reshape(X.shape)
        first = np.searchsorted(case, np.arange(count))
        return cls(some=some, left=left, met=met, first=first, contact=contact)

    def advance(self, solution: NewtonSolution, done: BoolArray, goes_on: BoolArray) -> BoolArray:
        """Take a step in cases that go on; return whether those that are `done` are stable, (C',).

        Cases whose stops are met at the same bearings are solved at once, these bearings alone:
        the others follow.
        """
        stable = np.ones(len(done), dtype=bool)
        asked = np.flatnonzero(done | goes_on)
        codes = self.met[asked] @ (1 << np.arange(self.met.shape[1]))
        slopes = (self.contact.slope.reshape(-1, SAMPLES) @ PAIRS).reshape(-1, 3 * PAIRS.shape[1])
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
        self, solution: NewtonSolution, slopes: FloatArray, rows: IntArray, ended: int
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
        matrix = moved_by(*moves, J)
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
            push[..., own] = (J[ended:] @ moved).reshape(going, COMPONENTS, -1)
            back = moved_by(tied[ended:], alone[ended:], push.reshape(going, -1, 1))
            step = step - back.reshape(step.shape)
        solution.X[some[ended:]] -= step
        return stable


def _by_components(slopes: FloatArray) -> FloatArray:
    """Return slopes (C', B', 3 K) by pairs of components as matrices, (C', M 2B', M 2B')."""
    count, bearings = slopes.shape[:2]
    each = np.take(slopes, PLACES_OF_PAIRS.ravel(), axis=2)
    each = each.reshape(count, bearings, *PLACES_OF_PAIRS.shape)
    if bearings == 1:
        return each.reshape(count, 2 * COMPONENTS, -1)
    found = np.zeros((count, COMPONENTS, bearings, 2, COMPONENTS, bearings, 2))
    for b in range(bearings):
        found[:, :, b, :, :, b, :] = each[:, b]
    return found.reshape(count, COMPONENTS * 2 * bearings, -1)


def _part(receptance: FloatArray, own: IntArray, parts: int) -> FloatArray:
    """Return the receptance (..., `parts` D, `parts` D) of some of D travels and forces."""
    size = receptance.shape[-1] // parts
    which = np.ravel(size * np.arange(parts)[:, None] + own)
    return receptance[..., which[:, None], which]


def _reaches(travel: FloatArray, stop: FloatArray) -> BoolArray:
    """Return whether a motion (C, M, 2 B) reaches a stop (C, B), in its largest sum at least."""
    x = np.ascontiguousarray(travel.mT).reshape(-1, COMPONENTS) @ BASIS
    x = x.reshape(*stop.shape, 2, SAMPLES)
    return ((x[:, :, 0] ** 2 + x[:, :, 1] ** 2).max(axis=-1) > stop**2).any(axis=-1)
