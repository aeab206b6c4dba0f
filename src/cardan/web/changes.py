"""What to change: corrections, maps of two moves, and what remains where moves scatter."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from cardan.base.verdict import GRADES
from cardan.files.placing import Changes, mounted, phased, placed
from cardan.model.application import Adjustable
from cardan.model.movable import MOVABLES
from cardan.quantity.quantities import ANSWERED
from cardan.quantity.response import Response
from cardan.report.language import Language
from cardan.report.wording import badness, movable, move
from cardan.study.fix import Proposal, fix
from cardan.study.maps import Outcomes, field, movables, outcomes, scattered, share
from cardan.study.moves import Move, adjustables, corrected
from cardan.web.document import Document, Json, Tell, f, fs, g, other

SOUGHT = frozenset(k for k, q in ANSWERED.items() if q.sought)
"""Quantities that are sought over all operating points: a later answer than the others."""
AT_ONCE = frozenset(ANSWERED) - SOUGHT

LEVELS = (9, 17, 33)
"""Cells along each side of a map, as it gets finer."""

PATIENT = (9, 13)
"""The same where bearing forces are sought over all points in every cell."""

BATCH = 128
"""Cases of a yield that are told at a time."""


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
            "id": _id(a), "said": name(a, say), "unit": m.unit, "low": f(a.low / m.worth, 3),
            "high": f(a.high / m.worth, 3), "step": f(m.resolution / m.worth, 3),
            "free": (a.what, a.part) in free, "choice": m.choice,
        }
        for a in movables(r) for m in (MOVABLES[a.what],)
    ]  # fmt: skip


def _id(a: Adjustable) -> str:
    return f"{a.what} {a.part}"


def name(a: Adjustable, say: Language) -> str:
    """Return what may be moved, in few words."""
    words = {
        "bearing_height": say("height of bearing {part}", part=a.part),
        "bearing_side": say("side of bearing {part}", part=a.part),
        "shim": say("shim of the axle"),
        "phase": say("phase of shaft {part}", part=a.part),
        "bearing_stiffness": say("stiffness of all rubber"),
        "bearing_loss": say("loss factor of all rubber"),
        "bearing_place": say("place of all bearings"),
    }
    return words.get(a.what) or movable(a, say)


def _response(read: Document, args: Json) -> Response:
    return read.responses[min(int(args.get("line", 0)), len(read.responses) - 1)]


def corrections(read: Document, args: Json, say: Language, tell: Tell) -> Json:
    """Return corrections of a line with what each moves, gives, and would edit."""
    r = _response(read, args)
    tell({"doing": say("looking for corrections"), "done": 0, "of": 1})
    free = {_id(a) for a in adjustables(r)}
    hold = [name for name in args.get("hold", []) if name in free]
    found = fix(
        read.application, line=r.line.name, hold=hold, count=6,
        tell=lambda done, of: tell({"done": done, "of": of}),
    )  # fmt: skip
    return {
        "line": r.line.name,
        "proposals": [_proposal(read, p, say) for p in found],
    }


def _proposal(read: Document, p: Proposal, say: Language) -> Json:
    bad = sorted((c for c in p.checks if c.grade != "pass"), key=badness)[:3]
    return {
        "verdict": p.verdict,
        "cost": f(p.cost, 4),
        "margin": g(p.margin),
        "before": g(p.before),
        "moves": [move(m, say) for m in p.moves],
        "counts": {grade: sum(c.grade == grade for c in p.checks) for grade in GRADES},
        "left": [other(c, p.approval, say) for c in bad],
        "edits": edits(read, p.line, p.moves),
    }


# --------------------------------------------------------------------------- maps


def surface(read: Document, args: Json, say: Language, tell: Tell) -> Json:
    """Return the worst limit over a field of two moves; coarse maps are told before."""
    r = _response(read, args)
    every = {_id(a): a for a in movables(r)}
    names = [args.get(key, "") for key in ("x", "y")]
    known = [every[n] for n in names if n in every]
    pair = known if len(known) == 2 and names[0] != names[1] else list(every.values())[:2]
    if len(pair) < 2:
        return {"x": None, "y": None}
    sought = args.get("sought") is True
    levels = PATIENT if sought else LEVELS
    found: Json = {}
    for k, count in enumerate(levels):
        found = _map(r, pair, count, sought=sought, say=say)
        if k + 1 < len(levels):
            tell({"map": found, "done": k + 1, "of": len(levels)})
    return found


def _map(r: Response, pair: list[Adjustable], count: int, *, sought: bool, say: Language) -> Json:
    across, up = pair
    amounts = field(across, up, count)
    got = outcomes(r, (across, up), amounts, quantities=AT_ONCE)
    if sought:
        got = got.beside(outcomes(r, (across, up), amounts, quantities=SOUGHT))
    names = [say.name(m.quantity) for m in got.limits]
    return {
        **{
            key: {
                "id": _id(a), "said": name(a, say), "unit": MOVABLES[a.what].unit,
                "values": fs(np.linspace(a.low, a.high, count) / MOVABLES[a.what].worth, 3),
            }
            for key, a in (("x", across), ("y", up))
        },
        "sought": sought,
        "grades": got.grade.reshape(count, count).tolist(),
        "margins": fs(got.margin.reshape(count, count), 4),
        "decides": got.decides.reshape(count, count).tolist(),
        "names": names,
    }  # fmt: skip


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
    every = {_id(a): a for a in movables(r)}
    rows = [row for row in args.get("sigmas", []) if row["id"] in every and row["amount"] > 0]
    if not rows:
        return {"count": 0}
    movable_ = tuple(every[row["id"]] for row in rows)
    sigmas = [row["amount"] * MOVABLES[a.what].worth for row, a in zip(rows, movable_, strict=True)]
    quantities = ANSWERED if args.get("sought") is True else AT_ONCE
    count = int(args.get("count", 4096))
    grades: list[Any] = []
    margins: list[Any] = []
    lost: dict[str, int] = {}
    found: Json = {}
    for k in range(max(1, count // BATCH)):
        amounts = scattered(sigmas, count=BATCH, seed=k)
        got: Outcomes = outcomes(r, movable_, amounts, quantities=quantities)
        grades.append(got.grade)
        margins.append(got.margin)
        for limit, row in zip(got.limits, got.grades, strict=True):
            name = say.name(limit.quantity)
            lost[name] = lost.get(name, 0) + int((row == len(GRADES) - 1).sum())
        found = _yield(np.concatenate(grades), np.concatenate(margins), lost)
        tell({"yield": found, "done": (k + 1) * BATCH, "of": count})
    return found


def _yield(grades: Any, margins: Any, lost: dict[str, int]) -> Json:
    count = len(grades)
    ends = np.linspace(-1, 1, 25)
    bins = [np.histogram(np.clip(margins[grades == k], -1, 1), bins=ends)[0] for k in range(3)]
    return {
        "count": count,
        "shares": {
            grade: [f(v, 4) for v in share(int((grades == k).sum()), count)]
            for k, grade in enumerate(GRADES)
        },
        "yield": [f(v, 4) for v in share(int((grades < len(GRADES) - 1).sum()), count)],
        "lost": [
            {"name": name, "share": f(n / count, 4)}
            for name, n in sorted(lost.items(), key=lambda item: -item[1])[:6] if n
        ],
        "margins": fs((ends[1:] + ends[:-1]) / 2, 3),
        "cases": [b.tolist() for b in bins],
    }  # fmt: skip
