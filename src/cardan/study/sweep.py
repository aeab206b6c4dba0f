"""Variants of an application: some numbers vary, and every limit is asked of all at once.

What varies is a number of the file by its address, or something that a workshop can move by
its key in the file's `adjust`. The driveline in its states answers, by the same code and with
the same margins as one application.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from cardan.base.arrays import BoolArray, FloatArray, IntArray
from cardan.base.errors import BadFile, DesignError, Problem
from cardan.base.frozen import dataclass
from cardan.base.verdict import GRADES, VERDICTS, Limit, Verdict
from cardan.demand.states import demand, resolve
from cardan.files.change import addresses, change
from cardan.files.study import of_numbers
from cardan.model import variants as model
from cardan.model.application import Adjustable, Application
from cardan.model.movable import MOVABLES, meant, movable
from cardan.model.variants import MOST, Ask, Variants
from cardan.quantity.quantities import ANSWERED
from cardan.quantity.response import Response, respond
from cardan.study.approval import Approval, assess
from cardan.study.draw import Drawing, Points, drawing
from cardan.study.driveline import Asked, asked
from cardan.study.finding import DRIVELINE, Tell, silent
from cardan.study.moves import acts_on, tried

CHUNK = 128
"""Variants at a time: fewer pay more for each step, more of them leave the processor's cache."""

Spread: TypeAlias = Sequence[float] | Mapping[str, Any] | model.Spread
"""How a number varies: [low, high], or a table of one of `KINDS`."""

KINDS = ("choice", "grid", "normal", "uniform")
"""One of some values; each of them; about its own value by a standard deviation or half width."""

NOTHING = -1
"""In place of a grade: no state or part of a variant got an answer."""


@dataclass(frozen=True, kw_only=True)
class Varied:
    """A number in each variant, (V,), in the unit its name ends in."""

    name: str
    values: FloatArray


@dataclass(frozen=True, kw_only=True)
class Held:
    """What one limit came to in each variant, where it is worst.

    Attributes
    ----------
    line, limit
        The limit, and the line that it asks about.
    values, margins : (V,) SI, 1
        Of the state and part that is worst; nan where nothing answered.
    grades : (V,)
        Places in `GRADES`, `NOTHING` where nothing answered.
    missed : (V,)
        Whether something that the limit requires got no answer.
    """

    line: str
    limit: Limit
    values: FloatArray
    margins: FloatArray
    grades: IntArray
    missed: BoolArray


@dataclass(frozen=True, kw_only=True)
class Answers:
    """What L limits come to in V variants, each where it is worst.

    Attributes
    ----------
    values, margins : (L, V) SI, 1
    left : (L, V) 1
        Margin to the maximum, whatever grade it comes to; nan where there is none.
    grades : (L, V)
    missed : (L, V)
    mass : (V,) kg
        Of all shafts; nan where one has no tube.
    refused : (V,)
        Whether the driveline cannot exist so.
    why : str
        What the first of those says.
    """

    values: FloatArray
    margins: FloatArray
    left: FloatArray
    grades: IntArray
    missed: BoolArray
    mass: FloatArray
    refused: BoolArray
    why: str = ""

    @property
    def deciding(self) -> FloatArray:
        """The margins (L, V) of the worst grade a variant comes to; infinite beside them."""
        known = ~np.isnan(self.margins)
        grades = np.where(known, self.grades, -1)
        return np.where(known & (grades == grades.max(axis=0)), self.margins, np.inf)

    @classmethod
    def together(cls, parts: Sequence["Answers"]) -> "Answers":
        """Return several one after the other."""
        return cls(
            **{
                f.name: np.concatenate([getattr(p, f.name) for p in parts], axis=-1)
                for f in fields(cls)
                if f.name != "why"
            },
            why=next((p.why for p in parts if p.why), ""),
        )


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """What variants of an application come to.

    `installed` is the approval of the application as it stands; what its limits miss of
    studies other than the driveline's, every variant misses too.

    Attributes
    ----------
    names, inputs : (V, names)
        What varies, in the unit its name ends in.
    limits
        Each limit, and the line that it asks about.
    answers
        What each came to.
    own : (V,)
        Which variants are drawn by themselves: shares count those.
    unit : (V, factors)
        The points of the unit cube they were made of.
    """

    installed: Approval
    names: tuple[str, ...]
    inputs: FloatArray
    limits: tuple[tuple[str, Limit], ...]
    answers: Answers
    own: BoolArray
    unit: FloatArray
    narrowed: bool = False
    """Whether some limits alone were asked: others then leave nothing incomplete."""

    @property
    def count(self) -> int:
        """How many variants there are."""
        return len(self.inputs)

    @property
    def varied(self) -> tuple[Varied, ...]:
        """Each number that varies."""
        return tuple(
            Varied(name=n, values=v) for n, v in zip(self.names, self.inputs.T, strict=True)
        )

    @property
    def held(self) -> tuple[Held, ...]:
        """What each limit came to."""
        a = self.answers
        return tuple(
            Held(
                line=line, limit=limit, values=a.values[k], margins=a.margins[k],
                grades=a.grades[k], missed=a.missed[k],
            )
            for k, (line, limit) in enumerate(self.limits)
        )  # fmt: skip

    @cached_property
    def grades(self) -> IntArray:
        """What each variant comes to, (V,) places in `VERDICTS`, as an approval has it."""
        elsewhere = not self.narrowed and missed_elsewhere(self.installed)
        return verdicts(self.answers, elsewhere=elsewhere)

    @property
    def verdicts(self) -> tuple[Verdict, ...]:
        """What each variant comes to."""
        return tuple(VERDICTS[g] for g in self.grades.tolist())

    @cached_property
    def margins(self) -> FloatArray:
        """The smallest margin of each variant (V,), as an approval has it; nan without any."""
        smallest = self.answers.deciding.min(axis=0, initial=np.inf)
        return np.where(np.isinf(smallest), np.nan, smallest)

    @property
    def shares(self) -> dict[Verdict, float]:
        """The share of variants that comes to each verdict."""
        of = self.grades[self.own]
        counts = np.bincount(of, minlength=len(VERDICTS)) / of.size
        return dict(zip(VERDICTS, counts.tolist(), strict=True))

    @property
    def yield_(self) -> float:
        """The share of variants that may be built: they pass or only warn."""
        return self.shares["pass"] + self.shares["warn"]

    def named(self) -> Iterator[tuple[str, Held]]:
        """Yield each limit with a name of its own: its quantity, line and place among several."""
        yield from zip(named(self.limits), self.held, strict=True)


def named(limits: Sequence[tuple[str, Limit]]) -> tuple[str, ...]:
    """Return names of limits that tell them apart: quantity, line, place among several."""
    several = len({line for line, _ in limits}) > 1
    names = [f"{line}.{m.quantity}" if several else m.quantity for line, m in limits]
    return tuple(
        f"{name}[{names[: k + 1].count(name)}]" if names.count(name) > 1 else name
        for k, name in enumerate(names)
    )


def missed_elsewhere(installed: Approval) -> bool:
    """Return whether a limit of another study is required and has no answer."""
    found = (f for f in installed.findings if f.study != DRIVELINE)
    return any(u.limit.required for f in found for u in f.unanswered)


def verdicts(of: Answers, *, elsewhere: bool) -> IntArray:
    """Return what variants come to, (V,) places in `VERDICTS`; what cannot exist fails."""
    places = np.array([VERDICTS.index(g) for g in GRADES])
    known = np.where(of.grades == NOTHING, VERDICTS.index("pass"), places[of.grades])
    worst = known.max(axis=0, initial=0)
    missed = of.missed.any(axis=0) | (of.grades == NOTHING).all(axis=0) | elsewhere
    worst = np.where(missed, np.maximum(worst, VERDICTS.index("incomplete")), worst)
    return np.where(of.refused, VERDICTS.index("fail"), worst)


def sweep(
    application: Application,
    vary: Mapping[str, Spread],
    *,
    tolerances: Mapping[str, Spread] | None = None,
    count: int = 10_000,
    seed: int = 0,
    tell: Tell = silent,
) -> Sweep:
    """Return what variants of an application come to, each of them kept.

    Parameters
    ----------
    application
        As read from a file.
    vary
        By the address of a number (`driveline.shafts[2].tube.wall_mm`) or the key of a thing
        that can be moved (`bearing_height_mm[1]`, `shim_deg`, `phase_deg[2]`; with several
        lines `front.shim_deg`): `[low, high]`, `{"choice": [...]}`, `{"grid": [low, high,
        how many]}`, `{"normal": sigma}` or `{"uniform": half}`, in the unit of the key. The
        last two go about the number as it is; moves count from where a part is installed.
        `[*]` stands for every part, each with its own value.
    tolerances
        What scatters about that, `{"normal": sigma}` or `{"uniform": half}`.
    count
        How many variants. Without tolerances a power of 2 spreads most evenly.
    seed
        Of the points.
    tell
        Told how far it has come.

    Raises
    ------
    ValueError
        If nothing goes by a name, or does not vary as is asked.

    Notes
    -----
    Sobol points, scrambled after Owen, without tolerances; else by dice. Source: Sobol
    (1967); Owen (1998). What cannot exist in a variant, a file with such a number or a chain
    that locks, makes that variant fail, and is told in `answers`.
    """
    bench = Bench.of(application, variants_of(vary, tolerances), seed=seed)
    return bench.rows(0, bench.whole(count), tell=tell)


def variants_of(
    vary: Mapping[str, Spread] | None = None,
    tolerances: Mapping[str, Spread] | None = None,
    *,
    ask: Ask | None = None,
) -> Variants:
    """Return a study as a file would say it.

    Raises
    ------
    ValueError
        If something does not vary as is asked.
    """
    return Variants(
        vary={name: _spread(name, s) for name, s in (vary or {}).items()},
        tolerances={name: _spread(name, s) for name, s in (tolerances or {}).items()},
        ask=ask or Ask(),
    )


def _spread(name: str, spread: Spread) -> model.Spread:
    if isinstance(spread, model.Spread):
        return spread
    if isinstance(spread, Mapping):
        kind, *others = spread or {"": None}
        if kind not in KINDS or others:
            msg = f"{name} varies by one of {', '.join(KINDS)}, got {dict(spread)}"
            raise ValueError(msg)
        amount = np.asarray(spread[kind], dtype=float)
        if kind == "choice" and amount.ndim == 1 and amount.size:
            return model.Spread(kind=kind, values=tuple(amount.tolist()))
        if kind == "grid" and amount.shape == (3,) and amount[0] < amount[1] and amount[2] >= 2:
            places = np.linspace(amount[0], amount[1], int(amount[2]))
            return model.Spread(kind=kind, values=tuple(places.tolist()))
        if kind in ("normal", "uniform") and amount.ndim == 0 and amount > 0:
            return model.Spread(kind=kind, values=(float(amount),))
        needs = {"choice": "values", "grid": "[low, high, how many]"}
        msg = f"{name}: {kind} needs {needs.get(kind, 'a number above 0')}"
        raise ValueError(msg)
    ends = np.asarray(spread, dtype=float)
    if ends.shape != (2,) or not ends[0] < ends[1]:
        msg = f"{name} varies over [low, high], got {spread}"
        raise ValueError(msg)
    return model.Spread(kind="range", values=tuple(ends.tolist()))


# --------------------------------------------------------------------------- asking


@dataclass(frozen=True, kw_only=True)
class Bench:
    """An application with where its variants lie: any stretch of them can be asked.

    Attributes
    ----------
    installed
        The approval of the application as it stands.
    drawing
        Where the variants lie.
    single
        Numbers that the arrays cannot hold: with these a file is read for each variant.
    """

    installed: Approval
    drawing: Drawing
    single: tuple[str, ...] = ()
    quantities: tuple[str, ...] = ()
    """Whose limits count; all where none is named."""

    @classmethod
    def of(
        cls,
        application: Application,
        variants: Variants,
        *,
        seed: int = 0,
        points: Points | None = None,
    ) -> "Bench":
        """Return the bench of a study.

        Raises
        ------
        ValueError
            If nothing goes by a name.
        BadFile
            If a number cannot be what it may become at the ends of its range.
        """
        known = names(application)
        drawn = drawing(variants, known, seed=seed, points=points)
        bench = cls(installed=assess(application), drawing=drawn, quantities=variants.ask.limits)
        if not bench.limits:
            msg = f"ask: no limit asks about {', '.join(variants.ask.limits) or 'this line'}"
            raise ValueError(msg)
        for k, name in enumerate(drawn.names):
            for end in _ends(drawn, k) if name not in bench._moves else ():
                try:
                    with_numbers(application, {name: end})
                except BadFile as error:
                    raise _beyond(variants, name, end, error) from error
        single = tuple(n for n in drawn.names if n not in bench._moves and not bench._holds(n))
        return replace(bench, single=single)

    @property
    def application(self) -> Application:
        """The application as it stands."""
        return self.installed.application

    def whole(self, count: int) -> int:
        """Return how many variants there are if so many are asked for: whole grids.

        One grid where nothing is drawn: a second would be the same.
        """
        if not 1 <= count <= MOST:
            msg = f"a study has from 1 to {MOST} variants (--n), got {count}"
            raise ValueError(msg)
        period = self.drawing.period
        return -(-count // period) * period if self.drawing.factors else period

    @cached_property
    def limits(self) -> tuple[tuple[str, Limit], ...]:
        """Each limit with the line that it asks about."""
        return tuple(
            (r.line.name, limit)
            for r in self.installed.responses
            for limit in dict.fromkeys(q.limit for q in self._questions(r))
        )

    @cached_property
    def _places(self) -> dict[str, tuple[int, ...]]:
        """By line, which of its limits each question is about: a bound that varies is the same."""
        found: dict[str, tuple[int, ...]] = {}
        for r in self.installed.responses:
            each = [q.limit for q in self._questions(r)]
            found[r.line.name] = tuple(map(list(dict.fromkeys(each)).index, each))
        return found

    @cached_property
    def chunk(self) -> int:
        """Variants at a time: twice `CHUNK` where no limit asks about a line on its rubber."""
        rubber = any(ANSWERED[limit.quantity].on_rubber for _, limit in self.limits)
        return CHUNK if rubber else 2 * CHUNK

    def _questions(self, response: Response) -> tuple[Asked, ...]:
        """Return what is asked of a line."""
        among = self.quantities or ANSWERED
        return tuple(q for q in asked(response, quantities=among) if q.parts)

    def rows(
        self,
        start: int,
        stop: int,
        *,
        tell: Tell = silent,
        go_on: Callable[[], bool] = lambda: True,
    ) -> Sweep:
        """Return variants from a place to another, each of them kept.

        `go_on` is asked between chunks; where it says no a `KeyboardInterrupt` is raised.
        """
        parts: list[Answers] = []
        unit = self.drawing.unit(start, stop)
        inputs = self.drawing.of(unit, start)
        for first in range(0, len(inputs), self.chunk):
            if not go_on():
                raise KeyboardInterrupt
            tell("sweep", first, len(inputs))
            parts.append(self.ask(inputs[first : first + self.chunk]))
        return self.sweep(inputs, Answers.together(parts), unit, self.drawing.own(start, stop))

    def sweep(
        self, inputs: FloatArray, answers: Answers, unit: FloatArray, own: BoolArray
    ) -> Sweep:
        """Return variants with what they came to."""
        return Sweep(
            installed=self.installed,
            names=self.drawing.names,
            inputs=inputs,
            limits=self.limits,
            answers=answers,
            own=own,
            unit=unit,
            narrowed=bool(self.quantities),
        )

    def ask(self, inputs: FloatArray) -> Answers:
        """Return what limits come to where the inputs (V, names) are these."""
        try:
            if self.single and len(inputs) > 1:
                return Answers.together([self.ask(row[None]) for row in inputs])
            return self._asked(inputs)
        except (BadFile, DesignError) as error:
            if len(inputs) == 1:
                return self._refused(str(error))
            middle = len(inputs) // 2
            return Answers.together([self.ask(inputs[:middle]), self.ask(inputs[middle:])])

    def _asked(self, inputs: FloatArray) -> Answers:
        """Return what limits come to; all variants must be able to exist."""
        count, moves = len(inputs), self._moves
        one = bool(self.single)
        numbers: dict[str, Any] = {
            name: float(column[0]) if one else column
            for name, column in zip(self.drawing.names, inputs.T, strict=True)
            if name not in moves
        }
        found: list[Answers] = []
        for response in self._responses(numbers):
            mine = [k for k, n in enumerate(self.drawing.names) if n in moves
                    and acts_on(response, moves[n])]  # fmt: skip
            if mine:
                parts = tuple(moves[self.drawing.names[k]] for k in mine)
                worth = np.array([MOVABLES[p.what].worth for p in parts])
                response = tried(response, parts, inputs[:, mine] * worth)
            places = self._places[response.line.name]
            found.append(_answers(response, self._questions(response), places, count))
        return replace(
            found[0],
            **{
                f.name: np.concatenate([getattr(a, f.name) for a in found])
                for f in fields(Answers)
                if f.name in ("values", "margins", "left", "grades", "missed")
            },
            mass=sum((a.mass for a in found), np.zeros(count)),
        )

    def _responses(self, numbers: Mapping[str, Any]) -> tuple[Response, ...]:
        """Return what each line does with other numbers; without any, what it does already."""
        if not numbers:
            return self.installed.responses
        changed = with_numbers(self.application, numbers)
        return tuple(respond(changed, demand(resolve(changed, line))) for line in changed.lines)

    def _refused(self, why: str) -> Answers:
        """Return what a variant comes to that cannot exist."""
        nothing = np.full((len(self.limits), 1), np.nan)
        return Answers(
            values=nothing,
            margins=nothing,
            left=nothing,
            grades=np.full(nothing.shape, NOTHING),
            missed=np.zeros(nothing.shape, dtype=bool),
            mass=np.array([np.nan]),
            refused=np.array([True]),
            why=why,
        )

    @cached_property
    def _moves(self) -> dict[str, Adjustable]:
        every = movable(i.line for i in self.application.lines)
        return {n: every[n] for n in self.drawing.names if n in every}

    def _holds(self, name: str) -> bool:
        """Return whether the arrays can hold variants of a number."""
        at = self.drawing.at[self.drawing.names.index(name)]
        try:
            changed = with_numbers(self.application, {name: np.array([at, at])})
            for line in changed.lines:
                self._questions(respond(changed, demand(resolve(changed, line))))
        except (BadFile, DesignError):
            return False
        return True


def with_numbers(application: Application, numbers: Mapping[str, Any]) -> Application:
    """Return an application with other numbers, held against the limits that it has now."""
    was = application.written.application if application.written else None
    if not numbers:
        return application
    if was is None or application.limits is was.limits:
        return change(application, numbers)
    found = change(replace(application, limits=was.limits, profile=was.profile), numbers)
    return replace(found, limits=application.limits, profile=application.profile)


def names(application: Application) -> dict[str, float]:
    """Return every number that may vary, as it is, by name.

    Raises
    ------
    ValueError
        If one has variants already.
    """
    written = application.written
    base = written.application if written else None
    numbers: dict[str, Any] = dict(
        addresses(replace(base, written=written) if base and written else application)
    )
    if written is not None:
        numbers |= written.single
    found: dict[str, float] = {}
    for at in of_numbers(numbers):
        if np.ndim(numbers[at]):
            msg = f"{at} has variants already: ask for variants of the application as it was read"
            raise ValueError(msg)
        found[at] = float(numbers[at])
    return found | dict.fromkeys(movable(i.line for i in application.lines), 0.0)


def _beyond(of: Variants, name: str, end: float, error: BadFile) -> BadFile:
    """Return the error of a number at an end of what it varies over, where the study says so."""
    first = error.problems[0]
    why = first.message if first.key == name else f"{first.key}: {first.message}"
    written = next((w for w in of.places if name in meant(w, [name])), "")
    line, column = of.places.get(written, (0, 0))
    told = f"cannot be {end:g}, up to where the study has it vary: {why}"
    problem = Problem(message=told, key=f"vary.{name}", line=line, column=column)
    return BadFile(of.file or error.file, (problem,))


def _ends(of: Drawing, k: int) -> tuple[float, ...]:
    """Return the ends of what an input is chosen from; of what scatters nobody knows them."""
    decided = [f.spread for f in (*of.factors, *of.grids) if f.input == k and not f.tolerance]
    return tuple(
        end
        for s in decided
        for end in (
            (min(s.values), max(s.values))
            if s.kind in ("range", "grid", "choice")
            else (of.at[k] - s.values[0], of.at[k] + s.values[0])
            if s.kind == "uniform"
            else ()
        )
    )


def _answers(
    response: Response, questions: Sequence[Asked], places: Sequence[int], count: int
) -> Answers:
    """Return what each limit of a line comes to; the same of several parts is one."""
    # What nothing varied changes has no axis of variants: asked once, for all of them.
    every: dict[int, list[Asked]] = {}
    for place, question in zip(places, questions, strict=True):
        every.setdefault(place, []).append(question)
    shape = (len(every), count)
    values, margins, left = (np.empty(shape) for _ in range(3))
    grades, missed = np.empty(shape, dtype=int), np.empty(shape, dtype=bool)
    for k, alike in every.items():
        found, asks = (_side_by_side([getattr(q, n) for q in alike]) for n in ("values", "asks"))
        known = ~np.isnan(found)
        graded = np.where(known, _side_by_side([q.limit.grades(q.values) for q in alike]), NOTHING)
        free = _side_by_side([q.limit.margins(q.values) for q in alike])
        worst = graded.max(axis=-1, initial=NOTHING)
        among = known & (graded == worst[:, None])
        at = np.where(among, free, np.inf).argmin(axis=-1)[:, None]
        values[k] = np.take_along_axis(found, at, axis=-1)[:, 0]
        margins[k] = np.take_along_axis(free, at, axis=-1)[:, 0]
        last = _side_by_side([_to_failure(q) for q in alike])
        least = np.where(np.isnan(last), np.inf, last).min(axis=-1)
        left[k] = np.where(np.isinf(least), np.nan, least)
        grades[k] = worst
        missed[k] = alike[0].limit.required & (asks & ~known).any(axis=-1)
    mass = sum((np.asarray(s.mass, dtype=float) for s in response.line.shafts), np.zeros(()))
    return Answers(
        values=values,
        margins=margins,
        left=left,
        grades=grades,
        missed=missed,
        mass=np.broadcast_to(mass.reshape(-1) if mass.ndim else mass, count).copy(),
        refused=np.zeros(count, dtype=bool),
    )


def _to_failure(of: Asked) -> FloatArray:
    """Return the margin to the maximum of each state and part; nan where there is none."""
    if of.limit.maximum is None:
        return np.full_like(of.values, np.nan)
    return of.limit.margin(of.values, to="maximum")


def _side_by_side(of: list[Any]) -> Any:
    """Return arrays (..., states, parts) of V variants, or of none, as (V, all together)."""
    flat = [v.reshape(-1, v.shape[-2] * v.shape[-1]) for v in of]
    rows = max(len(v) for v in flat)
    return np.concatenate([np.broadcast_to(v, (rows, v.shape[1])) for v in flat], axis=1)
