"""What to change: bearing heights and sides, axle shim and yoke phases, over all states.

Every trial is one case on a leading axis of the same response that `assess` uses, so the
search asks for hundreds of layouts at a time, and what it promises is what a check of the
corrected application gives.
"""

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any, Literal, TypeAlias

import numpy as np

from cardan.base.arrays import BoolArray, FloatArray
from cardan.base.errors import DesignError
from cardan.base.verdict import VERDICTS, Check, Unanswered, Verdict, worst
from cardan.demand.states import demand, resolve
from cardan.model.application import Adjustable, Application
from cardan.model.movable import MOVABLES
from cardan.quantity.response import Response, respond
from cardan.study.driveline import asked, checks_of, unanswered_of
from cardan.study.moves import Move, adjustables, tried

RESERVE = 0.02
"""Margin the least correction keeps, so that rounding it does not undo it."""

TRIALS = 48
"""Trials spread over each way that is free before the search follows the best of them."""

PLENTY = 10.0
"""Margins are cut here."""

STILL = 1e-9
"""A margin that changes by less than this in every trial is not for moving to answer."""

Smooth: TypeAlias = Callable[[FloatArray], tuple[Any, FloatArray]]
Bound: TypeAlias = Literal["normal", "maximum"]


@dataclass(frozen=True, kw_only=True)
class Proposal:
    """A correction of one line, and the verdict it gives.

    `margin` is the smallest margin to a warning among the limits that moving can change,
    `before` the same as installed. `checks` are all those of the corrected line, and
    `unanswered` what nothing moved can answer.
    """

    line: str
    moves: tuple[Move, ...]
    before: float
    margin: float
    checks: tuple[Check, ...]
    unanswered: tuple[Unanswered, ...]

    @property
    def cost(self) -> float:
        """Sum of the shares of their ranges that the moves use."""
        return sum(m.cost for m in self.moves)

    @property
    def verdict(self) -> Verdict:
        """What an approval of the corrected line comes to."""
        found: list[Verdict] = [c.grade for c in self.checks]
        missed = any(u.limit.required for u in self.unanswered)
        return worst([*found, "incomplete"] if missed else found)


def margins(response: Response, *, to: Bound) -> FloatArray:
    """Return every margin of a line, (..., limits x states x parts), cut where it is plenty."""
    cases = response.layout.points.shape[:-3]
    each = [q.limit.margin(q.values, to=to) for q in asked(response)]
    full = [np.broadcast_to(m, (*cases, *m.shape[-2:])).reshape(*cases, -1) for m in each]
    # A limit that does not ask is as good as one satisfied many times over.
    return np.nan_to_num(np.minimum(np.concatenate(full, axis=-1), PLENTY), nan=PLENTY)


@dataclass(frozen=True)
class _Search:
    """The margins of one line as a function of where its ways stand, from -1 to 1.

    Yokes are turned by fixed amounts `turns` (movable); of the stepless ways those named in
    `free` move in proportion, the others stay at 0. `changed` tells the margins that moving
    can change at all from those it is not for moving to answer.
    """

    response: Response
    movable: tuple[Adjustable, ...]
    turns: FloatArray
    free: tuple[int, ...]
    changed: BoolArray

    def amounts(self, positions: FloatArray) -> FloatArray:
        """Return the amounts (V, movable) at positions (V, free)."""
        found = np.tile(self.turns, (len(positions), 1))
        for at, k in zip(positions.T, self.free, strict=True):
            adjustable = self.movable[k]
            found[:, k] = np.where(at > 0, adjustable.high, -adjustable.low) * at
        return found

    def margins(self, positions: FloatArray, *, to: Bound) -> FloatArray:
        """Return the margins (V, ...) that moving changes."""
        response = tried(self.response, self.movable, self.amounts(positions))
        return margins(response, to=to)[:, self.changed]

    def best(self, *, to: Bound) -> tuple[FloatArray, float]:
        """Return the position of the largest smallest margin, and that margin."""
        spread = _spread(len(self.free))
        found = self.margins(spread, to=to).min(-1)
        start = spread[np.argmax(found)]

        def room(z: FloatArray) -> tuple[float, FloatArray]:
            return -z[-1], np.append(np.zeros(len(z) - 1), -1.0)

        def beyond(z: FloatArray) -> tuple[FloatArray, FloatArray]:
            margin, slope = self._smooth(z[:-1], to=to)
            return margin - z[-1], np.column_stack([slope, -np.ones(len(margin))])

        top = self._solve(np.append(start, found.max()), cost=room, needed=beyond)[:-1]
        reached = float(self.margins(top[None], to=to).min())
        return (top, reached) if reached > found.max() else (start, float(found.max()))

    def least(self, start: FloatArray, *, to: Bound) -> FloatArray:
        """Return the position nearest to 0 that keeps every margin in reserve."""

        def way(x: FloatArray) -> tuple[float, FloatArray]:
            return float(x @ x), 2 * x

        def kept(x: FloatArray) -> tuple[FloatArray, FloatArray]:
            margin, slope = self._smooth(x, to=to)
            return margin - RESERVE, slope

        return self._solve(start, cost=way, needed=kept)

    def _smooth(self, at: FloatArray, *, to: Bound) -> tuple[FloatArray, FloatArray]:
        """Return margins and their slopes at a position, from one batch of neighbours."""
        step = 1e-5
        found = self.margins(np.vstack([at, at + step * np.eye(len(at))]), to=to)
        return found[0], (found[1:] - found[0]).T / step

    def _solve(self, start: FloatArray, *, cost: Smooth, needed: Smooth) -> FloatArray:
        """Follow a cost downhill while what is needed stays above 0."""
        from scipy.optimize import minimize  # slow to import: only `fix` waits for it

        ways = len(self.free)
        bounds = [(-1.0, 1.0)] * ways + [(-np.inf, np.inf)] * (len(start) - ways)
        found = minimize(
            cost,
            start,
            jac=True,
            bounds=bounds,
            method="SLSQP",
            constraints={
                "type": "ineq",
                "fun": lambda z: needed(z)[0],
                "jac": lambda z: needed(z)[1],
            },
            options={"maxiter": 40, "ftol": 1e-6},
        )
        return np.clip(found.x, *np.transpose(bounds))


def _spread(ways: int) -> FloatArray:
    """Return positions (V, ways) spread over all ways, the middle first."""
    positions = np.random.default_rng(1).uniform(-1, 1, (1 + TRIALS * ways, ways))
    positions[0] = 0.0
    return positions


def fix(
    application: Application,
    *,
    line: str | None = None,
    hold: Collection[str] = (),
    count: int = 6,
    tell: Callable[[int, int], None] | None = None,
) -> tuple[Proposal, ...]:
    """Propose corrections of a line, for all its states at once.

    Parameters
    ----------
    application
        Its `adjustables` say what may move and how far; without any, centre bearings by
        30 mm, the axle by 3 deg of shim, and every shaft aligned or crossed.
    line
        Which line; by default the one with the worst check.
    hold
        What stays where it is, by name: "bearing_height", or "phase 2" for one part.
    count
        How many proposals at most.
    tell
        Called with how many choices of yoke phases are searched, and of how many.

    Returns
    -------
    tuple of Proposal
        Best verdict first, then the cheapest; none is beaten by another that costs less
        and leaves more margin.

    Raises
    ------
    DesignError
        If the application has no such line, or nothing of a name to hold.

    Notes
    -----
    Spread trials find the region, sequential quadratic programming the place in it: the
    largest smallest margin, and the least ways to where nothing warns and nothing fails.
    """
    response = _line(application, line)
    movable = _unheld(adjustables(response), hold)
    before = respond(application, response.demand)
    found = {p.moves: p for p in _proposals(before, movable, tell)}
    ranked = sorted(found.values(), key=lambda p: (VERDICTS.index(p.verdict), p.cost, -p.margin))
    return tuple(_unbeaten(ranked))[:count]


def _unheld(movable: tuple[Adjustable, ...], hold: Collection[str]) -> tuple[Adjustable, ...]:
    """Return what may move after all; a name nothing goes by is refused."""
    names = {a: (a.what, f"{a.what} {a.part}") for a in movable}
    known = {name for both in names.values() for name in both}
    for name in hold:
        if name not in known:
            msg = f"nothing that may move is called {name}; there are: {', '.join(sorted(known))}"
            raise DesignError(msg)
    return tuple(a for a, both in names.items() if not set(both) & set(hold))


def _line(application: Application, name: str | None) -> Response:
    """Return the line of a name, or the one with the worst check."""
    responses = {
        i.line.name: respond(application, demand(resolve(application, i)))
        for i in application.lines
    }
    if name is None:
        return min(responses.values(), key=lambda r: float(margins(r, to="normal").min()))
    if name not in responses:
        msg = f"there is no line {name}; the application has {', '.join(responses)}"
        raise DesignError(msg)
    return responses[name]


def _proposals(
    response: Response, movable: tuple[Adjustable, ...], tell: Callable[[int, int], None] | None
) -> Iterator[Proposal]:
    """Yield every proposal worth comparing: each way alone, all together, each yoke turned."""
    ways = tuple(k for k, a in enumerate(movable) if not MOVABLES[a.what].choice)
    turnings = list(_turnings(response, movable))
    everything = _Search(response, movable, turnings[0], ways, np.array([], dtype=bool))
    trials = np.concatenate([everything.amounts(_spread(len(ways))), np.stack(turnings)])
    every = margins(tried(response, movable, trials), to="normal")
    changed = np.ptp(every, axis=0) > STILL
    if not changed.any():
        return
    for k, turns in enumerate(turnings):
        if tell:
            tell(k, len(turnings))
        if turns.any():
            yield _proposal(response, movable, turns, changed)
        alone = [] if turns.any() or len(ways) < 2 else [(k,) for k in ways]
        for free in [*alone, *([ways] if ways else [])]:
            search = _Search(response, movable, turns, free, changed)
            for position in _positions(search):
                amounts = _rounded(movable, search.amounts(position[None])[0])
                if amounts.any():
                    yield _proposal(response, movable, amounts, changed)


def _positions(search: _Search) -> Iterator[FloatArray]:
    """Yield where the smallest margin is largest, and the least ways to no warning, no fail."""
    for bound in ("normal", "maximum"):
        top, margin = search.best(to=bound)
        yield top
        if margin > RESERVE:
            yield search.least(top, to=bound)


def _turnings(response: Response, movable: tuple[Adjustable, ...]) -> Iterator[FloatArray]:
    """Yield the amounts (movable) of every choice of yoke phases, as installed first."""
    choices = []
    for adjustable in movable:
        turns = [0.0]
        if MOVABLES[adjustable.what].choice:
            turns += _ends(response, adjustable)
        choices.append(list(dict.fromkeys(t for t in turns if t == 0 or abs(t) > 1e-9)))
    yield from (np.array(choice) for choice in product(*choices))


def _ends(response: Response, adjustable: Adjustable) -> list[float]:
    """Return how far yokes turn to the ends of their range, which count from the aligned."""
    installed = response.line.phases[adjustable.part - 1]
    return [bound - installed for bound in (adjustable.low, adjustable.high)]


def _rounded(movable: tuple[Adjustable, ...], amounts: FloatArray) -> FloatArray:
    """Return the amounts in steps a workshop can set."""
    steps = np.array([MOVABLES[a.what].resolution for a in movable])
    whole = np.where(steps > 0, steps, 1.0)
    return np.where(steps > 0, np.round(amounts / whole) * whole, amounts)


def _proposal(
    response: Response, movable: tuple[Adjustable, ...], amounts: FloatArray, changed: BoolArray
) -> Proposal:
    """Return the proposal that moves things by these amounts, with the checks it gives."""
    both = tried(response, movable, np.stack([np.zeros_like(amounts), amounts]))
    before, after = margins(both, to="normal")[:, changed].min(-1)
    corrected = tried(response, movable, amounts)
    return Proposal(
        line=response.line.name,
        moves=tuple(
            Move(adjustable=a, amount=float(x))
            for a, x in zip(movable, amounts, strict=True)
            if x != 0
        ),
        before=float(before),
        margin=float(after),
        checks=tuple(checks_of(corrected)),
        unanswered=tuple(unanswered_of(corrected)),
    )


def _unbeaten(ranked: list[Proposal]) -> Iterator[Proposal]:
    """Yield the proposals that none before them beats in cost, margin and verdict."""
    best = -np.inf
    grade: Verdict | None = None
    for proposal in ranked:
        if proposal.verdict != grade:
            grade = proposal.verdict
        if proposal.margin > best + 1e-6:
            best = proposal.margin
            yield proposal
