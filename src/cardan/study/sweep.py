"""A study of variants: some numbers vary, and every limit is asked of every variant at once.

What varies is a number of the file by its address, or something that a workshop can move by
its key in the file's `adjust`. The driveline in its states answers, by the same code and with
the same margins as one application.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from cardan.base.arrays import BoolArray, FloatArray, IntArray
from cardan.base.verdict import GRADES, VERDICTS, Limit, Verdict
from cardan.border.table import nearest
from cardan.demand.states import demand, resolve
from cardan.files.change import addresses, change
from cardan.model.application import Adjustable, Application
from cardan.model.movable import MOVABLES
from cardan.quantity.response import Response, respond
from cardan.study.approval import Approval, assess
from cardan.study.driveline import Asked, asked
from cardan.study.finding import DRIVELINE, Tell, silent
from cardan.study.fix import tried

CHUNK = 1000
"""Variants at a time: their arrays stay in the processor's cache."""

Spread: TypeAlias = Sequence[float] | Mapping[str, Any]
"""How a number varies: [low, high], or a table of one of `KINDS`."""

KINDS = ("choice", "normal", "uniform")
"""One of some values; about its own value by a standard deviation; by a half width."""

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
class Sweep:
    """What variants of an application come to.

    `installed` is the approval of the application as it stands; what its limits miss of
    studies other than the driveline's, every variant misses too.
    """

    installed: Approval
    varied: tuple[Varied, ...]
    held: tuple[Held, ...]

    @property
    def count(self) -> int:
        """How many variants there are."""
        return self.varied[0].values.size

    @property
    def grades(self) -> IntArray:
        """What each variant comes to, (V,) places in `VERDICTS`, as an approval has it."""
        places = np.array([VERDICTS.index(g) for g in GRADES])
        found = np.array([h.grades for h in self.held]).reshape(len(self.held), self.count)
        known = np.where(found == NOTHING, VERDICTS.index("pass"), places[found])
        worst = known.max(axis=0, initial=0)
        missed = np.array([h.missed for h in self.held]).reshape(found.shape).any(axis=0)
        silent = (found == NOTHING).all(axis=0)
        missed = missed | silent | self._elsewhere
        return np.where(missed, np.maximum(worst, VERDICTS.index("incomplete")), worst)

    @property
    def _elsewhere(self) -> bool:
        """Whether a limit of another study is required and has no answer."""
        found = (f for f in self.installed.findings if f.study != DRIVELINE)
        return any(u.limit.required for f in found for u in f.unanswered)

    @property
    def verdicts(self) -> tuple[Verdict, ...]:
        """What each variant comes to."""
        return tuple(VERDICTS[g] for g in self.grades.tolist())

    @property
    def margins(self) -> FloatArray:
        """The smallest margin of the limits where each is worst, (V,); nan without an answer."""
        found = np.array([h.margins for h in self.held]).reshape(len(self.held), self.count)
        smallest = np.nan_to_num(found, nan=np.inf).min(axis=0, initial=np.inf)
        return np.where(np.isinf(smallest), np.nan, smallest)

    @property
    def shares(self) -> dict[Verdict, float]:
        """The share of variants that comes to each verdict."""
        counts = np.bincount(self.grades, minlength=len(VERDICTS)) / self.count
        return dict(zip(VERDICTS, counts.tolist(), strict=True))

    @property
    def yield_(self) -> float:
        """The share of variants that may be built: they pass or only warn."""
        return self.shares["pass"] + self.shares["warn"]

    def named(self) -> Iterator[tuple[str, Held]]:
        """Yield each limit with a name of its own: its quantity, line and place among several."""
        several = len(self.installed.application.lines) > 1
        names = [f"{h.line}.{h.limit.quantity}" if several else h.limit.quantity for h in self.held]
        for k, (name, held) in enumerate(zip(names, self.held, strict=True)):
            alike = names.count(name) > 1
            yield (f"{name}[{names[: k + 1].count(name)}]" if alike else name), held


@dataclass(frozen=True, kw_only=True)
class _Ways:
    """What varies: numbers of the file, and things of lines that are moved."""

    numbers: dict[str, FloatArray]
    moved: dict[str, tuple[Adjustable, ...]]
    """By line."""
    amounts: dict[str, FloatArray]
    """By line, (V, moved) SI."""


def sweep(
    application: Application,
    vary: Mapping[str, Spread],
    *,
    count: int = 10_000,
    seed: int = 0,
    tell: Tell = silent,
) -> Sweep:
    """Return what variants of an application come to, spread evenly over all that varies.

    Parameters
    ----------
    application
        As read from a file.
    vary
        By the address of a number (`driveline.shafts[2].tube.wall_mm`) or the key of a thing
        that can be moved (`bearing_height_mm[1]`, `shim_deg`, `phase_deg[2]`; with several
        lines `front.shim_deg`): `[low, high]`, `{"choice": [...]}`, `{"normal": sigma}` or
        `{"uniform": half}`, in the unit of the key. The last two go about the number as it
        is; moves count from where a part is installed. `[*]` stands for every part, each
        with its own value.
    count
        How many variants. A power of 2 spreads most evenly.
    seed
        Of the scrambling of the points.
    tell
        Told how far it has come.

    Raises
    ------
    ValueError
        If nothing goes by a name, or does not vary as is asked.
    BadFile
        If a number cannot be what it is to become.
    DesignError
        If the driveline cannot exist in a variant.

    Notes
    -----
    Sobol points, scrambled after Owen. Source: Sobol (1967); Owen (1998).
    """
    installed = assess(application)
    varied = _sampled(application, vary, count=count, seed=seed)
    ways = _ways(application, varied)
    lines: dict[int, list[list[Held]]] = {}
    for start in range(0, count, CHUNK):
        tell("sweep", start, count)
        part = slice(start, min(start + CHUNK, count))
        numbers = {at: values[part] for at, values in ways.numbers.items()}
        changed = change(application, numbers) if numbers else application
        for k, line in enumerate(changed.lines):
            response = respond(changed, demand(resolve(changed, line)))
            if movable := ways.moved.get(line.line.name):
                response = tried(response, movable, ways.amounts[line.line.name][part])
            lines.setdefault(k, []).append(list(_held(response, part.stop - start)))
    return Sweep(
        installed=installed,
        varied=varied,
        held=tuple(
            _together(same) for chunks in lines.values() for same in zip(*chunks, strict=True)
        ),
    )


# --------------------------------------------------------------------------- limits


def _held(response: Response, count: int) -> Iterator[Held]:
    """Yield what each limit of a line comes to; the same of several parts is one."""
    found: dict[Limit, Held] = {}
    for question in (q for q in asked(response) if q.parts):
        one, before = _worst(response, question, count), found.get(question.limit)
        found[question.limit] = _worse(before, one) if before else one
    yield from found.values()


def _worst(response: Response, question: Asked, count: int) -> Held:
    """Return the worst state and part of each variant."""
    limit = question.limit
    # What nothing varied changes has no axis of variants: asked once, for all of them.
    values = question.values.reshape(-1, question.values.shape[-2] * question.values.shape[-1])
    asks = question.asks.reshape(values.shape)
    known = ~np.isnan(values)
    grades = np.where(known, limit.grades(values), NOTHING)
    margins = limit.margins(values)
    worst = grades.max(axis=-1, initial=NOTHING)
    among = known & (grades == worst[:, None])
    at = np.where(among, margins, np.inf).argmin(axis=-1)[:, None]
    missed = limit.required & (asks & ~known).any(axis=-1)

    def spread(found: Any) -> Any:
        return np.broadcast_to(found, count)

    return Held(
        line=response.line.name,
        limit=limit,
        values=spread(np.take_along_axis(values, at, axis=-1)[:, 0]),
        margins=spread(np.take_along_axis(margins, at, axis=-1)[:, 0]),
        grades=spread(worst),
        missed=spread(missed),
    )


def _worse(one: Held, other: Held) -> Held:
    """Return the worse of two answers to the same limit in each variant."""
    closer = (other.margins < one.margins) | np.isnan(one.margins)
    worse = (other.grades > one.grades) | ((other.grades == one.grades) & closer)
    return Held(
        line=one.line,
        limit=one.limit,
        values=np.where(worse, other.values, one.values),
        margins=np.where(worse, other.margins, one.margins),
        grades=np.where(worse, other.grades, one.grades),
        missed=one.missed | other.missed,
    )


def _together(chunks: Sequence[Held]) -> Held:
    """Return the answers to one limit of all variants."""
    return Held(
        line=chunks[0].line,
        limit=chunks[0].limit,
        values=np.concatenate([c.values for c in chunks]),
        margins=np.concatenate([c.margins for c in chunks]),
        grades=np.concatenate([c.grades for c in chunks]),
        missed=np.concatenate([c.missed for c in chunks]),
    )


# --------------------------------------------------------------------------- what varies


def _sampled(
    application: Application, vary: Mapping[str, Spread], *, count: int, seed: int
) -> tuple[Varied, ...]:
    """Return every number that varies, in each variant."""
    from scipy.stats.qmc import Sobol  # slow to import: only a sweep waits for it

    if count < 1:
        msg = f"a study needs at least one variant, got {count}"
        raise ValueError(msg)
    known = {**addresses(application), **dict.fromkeys(_movable(application), 0.0)}
    spreads = dict(_spreads(vary, known))
    if not spreads:
        msg = "nothing varies: name the address of a number, or a thing that can be moved"
        raise ValueError(msg)
    points = Sobol(len(spreads), rng=np.random.default_rng(seed))
    unit = points.random_base2(int(count - 1).bit_length())[:count]
    return tuple(
        Varied(name=name, values=_values(name, spread, at=known[name], unit=u))
        for (name, spread), u in zip(spreads.items(), unit.T, strict=True)
    )


def _spreads(vary: Mapping[str, Spread], known: Mapping[str, Any]) -> Iterator[tuple[str, Spread]]:
    """Yield what varies by its name, for `[*]` one after the other."""
    for name, spread in vary.items():
        meant = [name] if name in known else []
        if "[*]" in name:
            pattern = re.compile(re.escape(name).replace(r"\[\*\]", r"\[\d+\]"))
            meant = [k for k in known if pattern.fullmatch(k)]
        if not meant:
            msg = f"no number has the address {name}; {nearest(name.replace('*', '1'), known)}"
            raise ValueError(msg)
        yield from ((one, spread) for one in meant)


def _values(name: str, spread: Spread, *, at: Any, unit: FloatArray) -> FloatArray:
    """Return the values of a number at points (V,) spread over (0, 1)."""
    from scipy.special import ndtri

    if isinstance(spread, Mapping):
        kind, *others = spread or {"": None}
        if kind not in KINDS or others:
            msg = f"{name} varies by one of {', '.join(KINDS)}, got {dict(spread)}"
            raise ValueError(msg)
        amount = np.asarray(spread[kind], dtype=float)
        if kind == "choice" and amount.ndim == 1 and amount.size:
            return amount[(unit * amount.size).astype(int)]
        if kind != "choice" and np.ndim(at):
            msg = f"{name} has variants already: give it [low, high] or a choice"
            raise ValueError(msg)
        if kind != "choice" and amount.ndim == 0 and amount > 0:
            tail = np.clip(unit, 2.0**-32, 1 - 2.0**-32)  # a point may lie on the edge
            return at + amount * (ndtri(tail) if kind == "normal" else 2 * unit - 1)
        msg = f"{name}: {kind} needs {'values' if kind == 'choice' else 'a number above 0'}"
        raise ValueError(msg)
    ends = np.asarray(spread, dtype=float)
    if ends.shape != (2,) or not ends[0] < ends[1]:
        msg = f"{name} varies over [low, high], got {spread}"
        raise ValueError(msg)
    return ends[0] + unit * (ends[1] - ends[0])


def _movable(application: Application) -> dict[str, Adjustable]:
    """Return what can be moved by its name: the key of the file's `adjust`, and which part."""
    several = len(application.lines) > 1
    found: dict[str, Adjustable] = {}
    for line in (i.line for i in application.lines):
        for m in MOVABLES.values():
            for part in range(1, m.count(line) + 1):
                name = f"{m.key}_{m.unit}" + ("" if m.of in ("axle", "line") else f"[{part}]")
                found[f"{line.name}.{name}" if several else name] = Adjustable(
                    what=m.key, part=part, low=m.reach[0], high=m.reach[1], line=line.name
                )
    return found


def _ways(application: Application, varied: tuple[Varied, ...]) -> _Ways:
    """Return what varies, apart as the file's numbers and as moves of each line."""
    movable = _movable(application)
    moves = [(movable[v.name], v.values) for v in varied if v.name in movable]
    lines = dict.fromkeys(a.line for a, _ in moves)
    return _Ways(
        numbers={v.name: v.values for v in varied if v.name not in movable},
        moved={line: tuple(a for a, _ in moves if a.line == line) for line in lines},
        amounts={
            line: np.stack(
                [MOVABLES[a.what].worth * x for a, x in moves if a.line == line], axis=-1
            )
            for line in lines
        },
    )
