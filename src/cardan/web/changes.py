"""What to change: corrections, maps of two moves, and what remains where moves scatter."""

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from cardan.base.arrays import FloatArray, IntArray
from cardan.base.errors import CardanError
from cardan.base.verdict import GRADES, VERDICTS, Unanswered
from cardan.files.pasted import entered
from cardan.files.placing import Changes, mounted, phased, placed
from cardan.model.application import Adjustable
from cardan.model.movable import MOVABLES
from cardan.model.movable import movable as names_of
from cardan.model.variants import Ask
from cardan.quantity.quantities import ANSWERED
from cardan.quantity.response import Response
from cardan.report.language import Language
from cardan.report.wording import left, move, moves, scattered, survives, won
from cardan.study.approval import Approval
from cardan.study.fix import Proposal, fix
from cardan.study.moves import Move, adjustables, corrected, movables
from cardan.study.reduce import MAY, clopper_pearson
from cardan.study.sweep import CHUNK, NOTHING, Answers, Bench, Spread, variants_of, verdicts
from cardan.web import script
from cardan.web.document import Document, Json, Tell, f, fs, g

SOUGHT = frozenset(k for k, q in ANSWERED.items() if q.sought)
"""Quantities that are sought over all operating points: a later answer than the others."""
AT_ONCE = frozenset(ANSWERED) - SOUGHT
AT_ONCE_IN_ORDER = tuple(k for k in ANSWERED if k in AT_ONCE)

CELLS, PATIENT = 33, 13
"""Cells along each side of a map, and where bearing forces are sought in every cell."""

STEPS = (4, 2, 1)
"""A map is told as it gets finer: every fourth cell of its rows and columns first."""

BATCH = 128
"""Cases of a yield that are told at a time."""

PROPOSED = 6
"""Corrections at most."""

SURE = 0.95
"""How sure the interval is that a yield is told with."""

FAIL, INCOMPLETE = VERDICTS.index("fail"), VERDICTS.index("incomplete")


def edits(read: Document, line: str, moves: Sequence[Move]) -> Changes:
    """Return the edits of a document that moves of a workshop come to."""
    r = next(r for r in read.responses if r.line.name == line)
    installed = r.demand.installed
    after = corrected(r, tuple(m.adjustable for m in moves), np.array([m.amount for m in moves]))
    new = next(i for i in after.lines if i.line.name == line)
    found = placed(installed, new.layout, read.manuscript)
    found |= phased(installed, new.line.phases, read.manuscript)
    return found | mounted(installed, new.line, read.manuscript)


def told(r: Response, say: Language) -> list[Json]:
    """Return what can be moved of a line, by names that `hold` knows."""
    free = {(a.what, a.part) for a in adjustables(r)}
    return [
        {
            "id": _id(a), "said": moves(a, say), "unit": m.unit, "low": f(a.low / m.worth, 3),
            "high": f(a.high / m.worth, 3), "step": f(m.resolution / m.worth, 3),
            "free": (a.what, a.part) in free, "choice": m.choice,
        }
        for a in movables(r) for m in (MOVABLES[a.what],)
    ]  # fmt: skip


def _id(a: Adjustable) -> str:
    return f"{a.what} {a.part}"


def _response(read: Document, args: Json) -> Response:
    return read.responses[min(int(args.get("line", 0)), len(read.responses) - 1)]


def corrections(read: Document, args: Json, say: Language, tell: Tell) -> Json:
    """Return corrections of a line with what each moves, gives, and would edit.

    The best that is known is told from the first on.
    """
    r = _response(read, args)
    tell({"doing": say("looking for corrections")})
    free = {_id(a) for a in adjustables(r)}
    hold = [name for name in args.get("hold", []) if name in free]
    found = fix(
        read.application, line=r.line.name, hold=hold, count=PROPOSED,
        tell=lambda done, of: tell({"done": done, "of": of} if of > 1 else {}),
        show=lambda p: tell({"proposals": [_proposal(read, p, say)]}),
    )  # fmt: skip
    return {
        "line": r.line.name,
        "command": script.fix(read.name, r.line.name, hold, say, PROPOSED),
        "scatter": scattered(found[0].trucks, say) if found else "",
        "proposals": [_proposal(read, p, say) for p in found],
    }


def _least(of: Approval) -> float | None:
    return None if of.smallest_margin is None else g(of.smallest_margin)


def _proposal(read: Document, p: Proposal, say: Language) -> Json:
    return {
        "verdict": p.verdict,
        "cost": f(p.cost, 4),
        "margin": _least(p.approval),
        "before": _least(p.installed),
        "moves": [move(m, say) for m in p.moves],
        "survives": [won(p, say), *survives(p.survival, p.trucks, say)],
        "counts": {grade: sum(c.grade == grade for c in p.checks) for grade in GRADES},
        "left": left(p, say),
        "edits": edits(read, p.line, p.moves),
    }


# --------------------------------------------------------------------------- variants


def _bench(read: Document, *, sought: bool, **study: dict[str, Spread]) -> Bench:
    """Return where variants of a document are asked, of all its lines."""
    limits = () if sought else AT_ONCE_IN_ORDER
    try:
        return Bench.of(read.application, variants_of(**study, ask=Ask(limits=limits)))
    except ValueError as error:
        raise CardanError(str(error)) from None


def _names(read: Document) -> dict[tuple[str, str, int], str]:
    """Return what a study calls things that move, by line, kind and part."""
    every = names_of(i.line for i in read.application.lines)
    return {(a.line, a.what, a.part): name for name, a in every.items()}


def _elsewhere(bench: Bench) -> list[Unanswered]:
    """Return what is required, has no answer as it stands, and is not asked of variants."""
    mine = {(line, limit.quantity) for line, limit in bench.limits}
    missed = bench.installed.coverage.missed
    return [u for u in missed if (u.line, u.quantity) not in mine]


def _ask(bench: Bench, *, sought: bool, elsewhere: bool) -> dict[str, Any]:
    """Return what a command has to ask so that its answer is that of a bench.

    Limits that are named leave the others out, so none is where one of those has no answer.
    """
    mine = {limit.quantity for _, limit in bench.limits}
    return {} if sought or elsewhere else {"limits": [k for k in AT_ONCE_IN_ORDER if k in mine]}


def _limits(bench: Bench, say: Language) -> list[str]:
    several = len(bench.application.lines) > 1
    return [
        say.list(line if several else "", say.name(limit.quantity)) for line, limit in bench.limits
    ]


# --------------------------------------------------------------------------- maps


def surface(read: Document, args: Json, say: Language, tell: Tell) -> Json:
    """Return what all lines come to over a field of two moves; coarse maps are told before."""
    r = _response(read, args)
    every = {_id(a): a for a in movables(r) if a.low < a.high}
    ids = [args.get(key, "") for key in ("x", "y")]
    known = [every[n] for n in ids if n in every]
    pair = known if len(known) == 2 and ids[0] != ids[1] else list(every.values())[:2]
    if len(pair) < 2:
        return {"x": None, "y": None}
    sought = args.get("sought") is True
    count = PATIENT if sought else CELLS
    called = _names(read)
    vary: dict[str, Spread] = {
        called[a.line, a.what, a.part]: {"grid": [g(a.low / m.worth), g(a.high / m.worth), count]}
        for a in pair for m in (MOVABLES[a.what],)
    }  # fmt: skip
    bench = _bench(read, sought=sought, vary=vary)
    cells = _Cells(bench, say)
    ask = {"maps": [list(vary)], **_ask(bench, sought=sought, elsewhere=bool(cells.elsewhere))}
    commands = script.study(read.name, "map", count * count, say, vary=vary, ask=ask)
    place = np.arange(count * count).reshape(count, count)  # the first varies fastest
    found: Json = {}
    for step in STEPS:
        wanted = place[::step, ::step]
        cells.ask(wanted.ravel(), lambda done: tell({"done": done, "of": count * count}))
        found = {
            **{
                key: {
                    "id": _id(a), "said": moves(a, say), "unit": MOVABLES[a.what].unit,
                    "values": fs(cells.inputs[at, k], 3),
                }
                for k, (key, a, at) in enumerate(
                    (("x", pair[0], wanted[0]), ("y", pair[1], wanted[:, 0]))
                )
            },
            "sought": sought,
            "commands": commands,
            **cells.told(wanted),
        }  # fmt: skip
        if step > 1:
            tell({"map": found})
    return found


class _Cells:
    """Cells of a map, each asked once."""

    def __init__(self, bench: Bench, say: Language) -> None:
        self.bench, self.say = bench, say
        whole = bench.whole(1)
        self.inputs = bench.drawing.values(0, whole)
        self.elsewhere = _elsewhere(bench)
        self.names = [*_limits(bench, say), *(say.name(u.quantity) for u in self.elsewhere[:1])]
        self.verdict = np.full(whole, -1)
        self.margin = np.full(whole, np.nan)
        self.decides = np.full(whole, -1)

    def ask(self, places: IntArray, tell: Callable[[int], None]) -> None:
        """Ask the cells that have no answer yet."""
        new = places[self.verdict[places] < 0]
        for first in range(0, new.size, CHUNK):
            tell(int((self.verdict >= 0).sum()))
            at = new[first : first + CHUNK]
            self._enter(at, self.bench.ask(self.inputs[at]))

    def _enter(self, at: IntArray, a: Answers) -> None:
        self.verdict[at] = verdicts(a, elsewhere=bool(self.elsewhere))
        worst = np.array([*map(VERDICTS.index, GRADES), NOTHING])[a.grades]  # the last: nothing
        worst = np.where(a.missed, np.maximum(worst, INCOMPLETE), worst)
        left = a.deciding
        among = np.where(worst == worst.max(axis=0), left, np.inf)
        decides = np.where(np.isinf(among).all(axis=0), worst.argmax(axis=0), among.argmin(axis=0))
        self.margin[at] = np.take_along_axis(a.margins, decides[None], axis=0)[0]
        if self.elsewhere:
            decides[worst.max(axis=0) < INCOMPLETE] = len(a.grades)
        self.decides[at] = decides
        for k in at[a.refused].tolist():  # each says for itself why it cannot exist
            self.decides[k] = self._named(self.bench.ask(self.inputs[[k]]).why)

    def _named(self, why: str) -> int:
        said = self.say("cannot be built: {why}", why=self.say.error(why))
        if said not in self.names:
            self.names.append(said)
        return self.names.index(said)

    def told(self, wanted: IntArray) -> Json:
        """Return some of the cells, as rows and columns."""
        return {
            "verdicts": self.verdict[wanted].tolist(),
            "margins": fs(self.margin[wanted], 4),
            "decides": self.decides[wanted].tolist(),
            "names": list(self.names),
        }


def moved(read: Document, args: Json, _: Language, __: Tell) -> Json:
    """Return the edits of moves by their amounts, each in the unit it is shown in."""
    r = _response(read, args)
    every = {_id(a): a for a in movables(r)}
    moves = [
        Move(adjustable=a, amount=row["amount"] * MOVABLES[a.what].worth)
        for row in args.get("moves", [])
        if (a := every.get(row["id"])) and row["amount"]
    ]
    return {"edits": edits(read, r.line.name, moves) if moves else {}}


# --------------------------------------------------------------------------- yield


def tolerated(read: Document, args: Json, say: Language, tell: Tell) -> Json:
    """Return the share that may be built where moves scatter, told as it becomes surer."""
    r = _response(read, args)
    every, called = {_id(a): a for a in movables(r)}, _names(read)
    amounts = ((every.get(row["id"]), row["amount"]) for row in args.get("sigmas", []))
    sigmas: dict[str, Spread] = {
        called[a.line, a.what, a.part]: {"normal": amount}
        for a, typed in amounts if a and (amount := _sigma(typed, a, say)) > 0
    }  # fmt: skip
    if not sigmas:
        return {"count": 0}
    bench = _bench(read, sought=args.get("sought") is True, tolerances=sigmas)
    elsewhere, limits = _elsewhere(bench), _limits(bench, say)
    count = max(1, int(args.get("count", 4096)))
    ask = _ask(bench, sought=args.get("sought") is True, elsewhere=bool(elsewhere))
    commands = script.study(read.name, "yield", count, say, tolerances=sigmas, ask=ask)
    found: list[IntArray] = []
    margins: list[FloatArray] = []
    lost: Counter[str] = Counter()
    told: Json = {}
    for start in range(0, count, BATCH):
        rows = bench.rows(start, min(start + BATCH, count))
        found.append(verdicts(rows.answers, elsewhere=bool(elsewhere)))
        margins.append(rows.margins)
        for said, grades, missed in zip(
            limits, rows.answers.grades, rows.answers.missed, strict=True
        ):
            lost[said] += int(((grades == GRADES.index("fail")) | missed).sum())
        lost[say("cannot be built")] += int(rows.answers.refused.sum())
        if elsewhere:
            lost[say.name(elsewhere[0].quantity)] += rows.count
        told = _yield(np.concatenate(found), np.concatenate(margins), lost)
        told["commands"] = commands
        tell({"yield": told, "done": start + rows.count, "of": count})
    return told


def _sigma(typed: str, of: Adjustable, say: Language) -> float:
    """Return a standard deviation that was typed; what is left empty does not scatter."""
    try:
        found = entered(typed, decimal=say.decimal) if typed.strip() else 0.0
        if found < 0:
            msg = "must be 0 or more"
            raise ValueError(msg)
    except ValueError as error:
        msg = f"{moves(of, say)}: {say.error(str(error))}, {typed!r}"
        raise CardanError(msg) from None
    return found


def _yield(of: IntArray, margins: FloatArray, lost: Counter[str]) -> Json:
    count, ends = of.size, np.linspace(-1, 1, 25)
    # What cannot be built has no margin, and less than any that does.
    left = np.clip(np.nan_to_num(margins, nan=-1.0), -1, 1)

    def share(hits: int) -> list[float | None]:
        return [f(v, 4) for v in (hits / count, *clopper_pearson(hits, count, confidence=SURE))]

    return {
        "count": count,
        "shares": {v: share(int((of == k).sum())) for k, v in enumerate(VERDICTS)},
        "yield": share(int((of <= MAY).sum())),
        "lost": [{"name": said, "share": f(n / count, 4)} for said, n in lost.most_common(6) if n],
        "margins": fs((ends[1:] + ends[:-1]) / 2, 3),
        "cases": [np.histogram(left[of == k], bins=ends)[0].tolist() for k in range(len(VERDICTS))],
    }
