"""A document in, results out, as the front draws them: keys, numbers, arrays, names.

Nothing is remembered that could not be told again: what is kept of the last documents saves
reading them twice. Lengths are in mm, angles in deg, as on the page; what a limit asks about
is in the unit its quantity is shown in, and None where nothing is known.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import islice
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from cardan import files
from cardan.base.errors import BadFile, CardanError, DesignError
from cardan.base.part import Point
from cardan.base.units import deg, mm, rpm
from cardan.base.verdict import GRADES, Limit, badness, worst
from cardan.files.manuscript import Manuscript, Raw
from cardan.files.placing import Changes, name_address, phase_address
from cardan.kinematics.chain import pin_phases, turn
from cardan.kinematics.equivalent import ae7_terms
from cardan.model.application import Installed
from cardan.model.layout import Layout
from cardan.model.parts import Shaft
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import Response
from cardan.report.compare import Variant, differences, effects
from cardan.report.drawing import worst_state
from cardan.report.inputs import inputs
from cardan.report.language import Language
from cardan.report.wording import cited, counted, move, notes, occasion, spoils, unanswered
from cardan.study.approval import approve
from cardan.study.drag import KINDS, STUB, Handle, dragged, handles
from cardan.study.driveline import Asked, asked, check
from cardan.study.finding import DRIVELINE
from cardan.study.ride import Reach, ride, under, way, winds
from cardan.study.sensitivity import Effect, Sensitivity, sensitivities
from cardan.web import changes, guides, heard, library, limits, revisions, script, seated, speeds
from cardan.web.changes import AT_ONCE, SOUGHT
from cardan.web.document import Document, Json, Tell, document, f, fs, g, gs, here, other

RIDE = 61
"""Places of a slider that its curves are drawn through."""
ROUND = 72
"""Points of a turn that the dial's curves are drawn through."""
PHASES = 37
"""Yoke phases from 0 to 180 deg that the dial's sum is drawn for."""

GRADE = 1e6
"""What a grade weighs against margins: a failure goes first."""

SEEN = 40
"""Entries that are written otherwise and tried one by one: more of them show somewhere."""

BRAKED = "windup brake"
WOUND = ("windup", BRAKED)
"""Kinds of states that stand as their torque winds the axle up; others stand without."""

HELD = ("held", "graded")
"""What is asked while a hand moves, each in a lane of its own."""


def _nobody(_: Json) -> None:
    """Tell nobody."""


def answer(question: Json, tell: Tell = _nobody) -> Json:
    """Return the answer to a question; what is wrong with its document is an answer too.

    A job that takes long is told of as it goes.
    """
    folder = Path(question["folder"]) if question.get("folder") else None
    text, name = question["text"], question["name"]
    say = Language(question["lang"]).typeset
    try:
        read = document(text, name, folder)
        edits = _edits(read, question)
        if edits:
            read = read.edited(edits, held=question["job"] in HELD)
            text = read.text
        if question["job"] in _JOBS:
            found = _JOBS[question["job"]](read, question, say, tell)
        else:
            found = _LONG[question["job"]](read, question["args"], say, tell)
    except CardanError as error:
        wrong = _problems(error, text, name, folder, say)
        if question["job"] == "guided":
            # Of the excerpt that was made: who filled the form in wrote no point in it.
            made = [p for p in wrong if p["line"]]
            for p in made:
                p |= {key: say.spelt(p[key]) for key in ("message", "hint", "value")}
        return {"text": text, "problems": wrong}
    return {"text": text, "edits": edits, **found}


def named(question: Json, text: str) -> list[list[str | int]]:
    """Return the files that a text just answered of names, each with what it was, as stamped."""
    folder = Path(question["folder"]) if question.get("folder") else None
    return [[str(b.path), *b.stamp] for b in document(text, question["name"], folder).beside]


def _problems(
    error: CardanError, text: str, name: str, folder: Path | None, say: Language
) -> list[Json]:
    """Return what is wrong with a document in the language, each with its place.

    Files of its folder go by their names there.
    """

    def told(said: str) -> str:
        return here(say.error(said), folder)

    if isinstance(error, BadFile):
        keys = ("key", "line", "column")
        of = Path(error.file)
        beside = f"{of.name}: " if folder and of.is_relative_to(folder) else ""
        return [
            {k: getattr(p, k) for k in keys}
            | {
                "message": f"{beside}{told(p.message)}",
                "hint": told(p.hint),
                "value": told(p.value),
            }
            for p in error.problems
        ]
    line = column = 0
    key = ""
    with suppress(CardanError):
        about = error.about if isinstance(error, DesignError) else ""
        if about and (found := files.place(document(text, name, folder).application, about)):
            line, column, key = found.line, found.column, found.key
    return [{"message": told(str(error)), "key": key, "value": "", "hint": "", "line": line,
             "column": column}]  # fmt: skip


def _edits(read: Document, question: Json) -> Changes:
    """Return the changes that a question makes to its document: by address, or by hand."""
    edits: Changes = dict(question.get("edits") or {})
    if drag := question.get("drag"):
        handle = Handle(kind=drag["kind"], number=drag["number"], line=drag["line"], ways="")
        assert handle.kind in KINDS
        by = np.array(drag["by_mm"], dtype=float) * mm
        edits |= dragged(read.application, handle, by, read.manuscript)
    return edits


# --------------------------------------------------------------------------- what is asked


def _live(read: Document, question: Json, say: Language, _: Tell) -> Json:
    """Return all that follows a change at once: lines, limits that need no operating points.

    Of a campaign it is what that names.
    """
    if of := read.recordings:
        return {"campaign": heard.listed(of, say)}
    app = read.application
    rows = [row for r in read.responses for row in _rows(r, say)]
    return {
        "title": app.title,
        "profile": app.profile,
        "states": [_state(read.responses[0], s, say) for s in range(len(app.states))],
        "worst": _foremost(read.responses[0]),
        "lines": [_line(r, read.manuscript, say) for r in read.responses],
        "obstacles": [_obstacle(o) for o in app.obstacles],
        "handles": _handles(read),
        "limits": rows,
        "pending": [row for r in read.responses for row in _pending(r, say)],
        "grade": _grade(rows),
        "warnings": [
            {"message": say.error(p.message), "key": p.key, "hint": say.error(p.hint),
             "line": p.line, "column": p.column, "value": say.error(p.value)}
            for p in app.warnings
        ],
        **_posed(read, question, say),
    }  # fmt: skip


def _held(read: Document, question: Json, say: Language, _: Tell) -> Json:
    """Return the numbers of the shown line that follow a hand."""
    shown = read.responses[_shown(read, question)]
    return {
        "lines": [{"name": shown.line.name, **_moving(shown)}],
        "obstacles": [_obstacle(o) for o in read.application.obstacles],
        **_posed(read, question, say),
    }


def _graded_held(read: Document, _: Json, __: Language, ___: Tell) -> Json:
    """Return the numbers of the limits that follow a hand."""
    asked_of = [(_id(r, a.limit, k), a) for r in read.responses for k, a in _at_once(r)]
    told = _graded([a for _, a in asked_of])
    rows = [{"id": name, **row} for (name, _), row in zip(asked_of, told, strict=True)]
    return {"limits": rows, "grade": _grade(rows)}


def _shown(read: Document, question: Json) -> int:
    """Return which line the page shows."""
    line = int((question.get("pose") or {}).get("line", 0))
    return min(max(line, 0), len(read.responses) - 1)


def _grade(rows: list[Json]) -> str | None:
    """Return the worst grade of some limits; None where none has a value."""
    grades = {g for row in rows for s in row["grades"] for g in s if g is not None}
    return worst([GRADES[g] for g in grades]) if grades else None


def _handles(read: Document) -> list[Json]:
    return [
        {"kind": h.kind, "number": h.number, "line": h.line, "ways": h.ways}
        for h in handles(read.application, read.manuscript)
    ]


def _pose(read: Document, question: Json, say: Language, _: Tell) -> Json:
    """Return a line where a slider has it, and what its curves are."""
    return _posed(read, question, say)


def _full(read: Document, _: Json, say: Language, __: Tell) -> Json:
    """Return the verdict, and the limits that are sought over all operating points."""
    found = approve(read.application)
    others = [c for f in found.findings if f.study != DRIVELINE for c in f.checks]
    return {
        "verdict": found.verdict,
        "counted": counted(found.checks, say),
        "missed": len(found.coverage.unanswered),
        "unanswered": unanswered(found, say),
        "notes": notes(found, say),
        "limits": [row for r in found.responses for row in _rows(r, say, SOUGHT)],
        "others": [other(c, found, say) for c in sorted(others, key=badness)],
    }


def _help(read: Document, _: Json, say: Language, __: Tell) -> Json:
    """Return what moving things does to each limit that does not pass, as edits to apply."""
    found = approve(read.application)
    helps: list[Json] = []
    for one in sensitivities(found):
        installed = next(i for i in read.application.lines if i.line.name == one.check.line)
        told = (e for e in one.helpful if isfinite(one.better(e)[1]))
        bars = [_bar(read, installed, one, e, say) for e in told]
        helps.append({**other(one.check, found, say), "bars": bars})
    return {"helps": helps}


def _ready(read: Document, _: Json, __: Language, ___: Tell) -> Json:
    """Return nothing; whoever asks about a hand on this document next need not wait for it."""
    for r in read.responses:
        list(_at_once(r))
    return {}


_JOBS = {
    "live": _live, "held": _held, "graded": _graded_held, "ready": _ready, "pose": _pose,
    "full": _full, "help": _help,
}  # fmt: skip


def _ghost(read: Document, _: Json, __: Language, ___: Tell) -> Json:
    """Return where another variant's lines run, to be drawn behind this one's."""
    lines = [
        {
            "name": r.line.name,
            "states": {
                name: _laid(r.layout[s], r.demand.installed)
                for s, name in enumerate(r.demand.states)
            },
            "angles": {name: fs(r.angles[s] / deg, 3) for s, name in enumerate(r.demand.states)},
        }
        for r in read.responses
    ]
    return {"lines": lines}


def _compare(read: Document, args: Json, say: Language, tell: Tell) -> Json:
    """Return variants beside the text itself: verdicts, what they say and what it does.

    Of the `same` file also what no row shows as it is rounded; of a campaign all that is written
    otherwise, and the lives of those that have been asked.
    """
    given = args.get("variants", [])
    first = "" if args.get("same", True) else read.name
    named = [
        (first, read),
        *((v["name"], document(v["text"], v["name"], read.folder)) for v in given),
    ]
    texts = [one.manuscript for _, one in named]
    every = dict.fromkeys(at for of in texts for at in of.addresses)
    rows = ((at, [of.written(at) or "-" for of in texts]) for at in every)
    written = {at: said for at, said in rows if len(set(said)) > 1}
    beside = {at: [one.named(at) for _, one in named] for at in written}
    beside = {at: of for at, of in beside.items() if all(of)}
    contents = [row for at, of in beside.items() for row in _contents(at, written[at], of, say)]
    if read.recordings:
        lives: list[dict[str, str]] = args.get("lives", [])
        gauges = dict.fromkeys(gauge for life in lives for gauge in life)
        return {
            "variants": [{"name": name, "verdict": None, "counted": {}} for name, _ in named],
            "differences": [
                *({"name": at, "values": of} for at, of in written.items() if at not in beside),
                *contents,
            ],
            "effects": [
                {
                    "name": f"{gauge}: {say('hours to failure')}",
                    "values": [life.get(gauge, "-") for life in lives],
                    "grades": [None] * len(lives),
                }
                for gauge in gauges
            ],
        }
    found: list[Variant] = []
    for k, (name, one) in enumerate(named):
        tell({"doing": name, "done": k, "of": len(named)})
        found.append(Variant(name=name, approval=approve(one.application)))
    return {
        "variants": [
            {
                "name": v.name, "verdict": v.approval.verdict,
                "counted": counted(v.approval.checks, say),
            }
            for v in found
        ],
        "differences": [
            *(
                {"name": d.name, "values": d.values} for d in differences(found, say)
                if d.name.rpartition(": ")[2] not in beside
            ),
            *(
                {"name": at, "values": of} for at, of in islice(written.items(), SEEN)
                if args.get("same", True) and at not in beside and _hidden(read, at, of, say)
            ),
            *contents,
        ],
        "effects": [
            {"name": e.name, "values": e.values, "grades": e.grades} for e in effects(found, say)
        ],
    }  # fmt: skip


def _contents(at: str, said: list[str], paths: list[list[Path]], say: Language) -> Iterator[Json]:
    """Give the row of a file that texts name at an address, where it is not the same one.

    One that a revision keeps counts as it was when that was frozen.
    """
    holds = {tuple(map(revisions.kept, of)) for of in paths}
    if len(holds) > 1 or None in next(iter(holds)):
        values = [_now(text, of[0], say) for text, of in zip(said, paths, strict=True)]
        yield {"name": say("{key}: other contents", key=at), "values": values}


def _now(said: str, path: Path, say: Language) -> str:
    """Return how a file is called, and whether it is there as it was when it was frozen."""
    now = revisions.held(path)
    if now is None:
        return say("{file}: is no longer there", file=said)
    return said if now == revisions.kept(path) else say("{file}: overwritten since", file=said)


def _hidden(read: Document, at: str, written: list[str], say: Language) -> bool:
    """Return whether inputs stay as they are where one entry is as others write it.

    What cannot be another by itself comes with others, which show.
    """
    tried: list[bool] = []
    for value in {*written} - {"-", read.manuscript.written(at)}:
        with suppress(CardanError):
            text = read.manuscript.with_({at: Raw(value)})
            other = files.loads(text, name=read.name, folder=read.folder, warn=False)
            tried.append(inputs(other, say) == inputs(read.application, say))
    return bool(tried) and all(tried)


_LONG = {
    "recording": heard.brought,
    "life": heard.lived,
    "drive": heard.driven,
    "campaign": heard.mixed,
    "bracket": seated.seated,
    "library": library.status,
    "report": library.report,
    "script": script.script,
    "limits": limits.listed,
    "deviate": limits.deviation,
    "fix": changes.corrections,
    "map": changes.surface,
    "moved": changes.moved,
    "yield": changes.tolerated,
    "ghost": _ghost,
    "compare": _compare,
    "guided": guides.guided,
    "pasted": guides.pasted,
    "speeds": speeds.speeds,
    "torsion": speeds.torsion,
}


# --------------------------------------------------------------------------- lines


def _state(r: Response, s: int, say: Language) -> Json:
    name = r.demand.states[s]
    return {"name": name, "said": say.state(name), "kind": r.kinds[s]}


def _line(r: Response, text: Manuscript, say: Language) -> Json:
    """Return a line: what it consists of, where that stands in a text, and where it runs."""
    line = r.line
    return {
        "name": line.name,
        "tubes": [f(s.tube.outer / mm) if s.tube else None for s in line.shafts],
        "tube_names": [_tube(s, say) for s in line.shafts],
        "joints": [s.name if s else "" for s in r.sizes],
        **_written(r.demand.installed, text),
        "movable": changes.told(r, say),
        "obstacles": [r.application.obstacles.index(o) for o in r.obstacles],
        **_moving(r),
    }


def _moving(r: Response) -> Json:
    """Return what of a line moves with a hand: where it runs, as installed and in each state."""
    installed = r.demand.installed
    return {
        "installed": _laid(installed.layout, installed),
        "states": [_laid(r.layout[s], installed) for s in range(len(r.demand.states))],
        "phases": [round(s.phase / deg, 3) for s in r.line.shafts],
        "angles": fs(r.angles / deg, 3),
        "side_angles": fs(r.side_angles / deg, 3),
        "top_angles": fs(r.top_angles / deg, 3),
        "positions": fs(r.positions / deg, 1),
        "side": fs(r.layout.side / deg, 3),
        "top": fs(r.layout.top / deg, 3),
        "lengths": fs(r.layout.lengths / mm, 1),
        "plunge": fs(r.spline_travel / mm, 4),
        "travel": fs(r.demand.travel / mm, 2),
        "torque": gs(r.demand.torque),
        "speed": gs(r.demand.speed / rpm),
        "clearance": [fs(c / mm, 4) for c in r.clearances],
        "phasors": _phasors(r),
        "equivalent": fs(r.excitation.torsional.angle / deg, 3),
        "rings": [_rings(r, s) for s in range(len(r.demand.states))],
    }


def _written(of: Installed, text: Manuscript) -> Json:
    """Return where phases and names of parts stand in a text, and which; "" where none does."""
    shafts, joints = range(1, len(of.line.shafts) + 1), range(1, of.line.joint_count + 1)
    tubes = [name_address(of, text, shaft=k) for k in shafts]
    sizes = [name_address(of, text, joint=k) for k in joints]
    return {
        "phase_at": [phase_address(of, k, text) for k in shafts],
        "tube_at": tubes,
        "tube_now": [text.written(at) or "" for at in tubes],
        "joint_at": sizes,
        "joint_now": [text.written(at) or "" for at in sizes],
    }


def _tube(shaft: Shaft, say: Language) -> str:
    """Return a shaft's tube as drawings name it: 120 × 4; nothing where none is known."""
    if shaft.tube is None:
        return ""
    return f"{say.short(shaft.tube.outer / mm)} × {say.short(shaft.tube.wall / mm)}"


def _laid(layout: Layout, installed: Installed) -> Json:
    """Return a layout (n, 3): joints, bearings, ends of the stubs at gearbox and pinion, mm."""
    p, d = layout.points, layout.directions
    stub = STUB * float(np.linalg.norm(p[-1] - p[0]))
    bearings = [
        p[k] - s.centre_bearing.from_rear_joint * d[k]
        for k, s in enumerate(installed.line.shafts, 1)
        if s.centre_bearing
    ]
    return {
        "joints": fs(p / mm, 2),
        "bearings": [fs(b / mm, 2) for b in bearings],
        "ends": [fs((p[0] - stub * d[0]) / mm, 2), fs((p[-1] + stub * d[-1]) / mm, 2)],
    }


def _phasors(r: Response) -> Any:
    """Return where the joints' sum gets to one by one in each state, (states, joints + 1, 2).

    As AE-7 has it, deg² along 0 and 45 deg.
    """
    side, top, phases = r.uneven
    ends = np.cumsum(ae7_terms(side, top, phases=phases), axis=-1) / deg**2
    ends = np.concatenate([np.zeros_like(ends[..., :1]), ends], axis=-1)
    return fs(np.stack([ends.real, ends.imag], axis=-1), 3)


def _rings(r: Response, s: int) -> list[Json]:
    """Return how large the sum may be at a state's speed, deg², by the grade it begins."""
    speed = float(r.demand.speed[s])
    if not speed > 0:
        return []
    return [
        {"grade": grade, "radius": f(bound / speed**2 / deg**2, 3)}
        for limit in r.application.limits
        if limit.quantity == "torsional_acceleration"
        for grade, bound in (("warn", limit.normal), ("fail", limit.maximum))
        if bound is not None
    ]


def _obstacle(o: Any) -> Json:
    return {
        "name": o.name, "line": o.line, "radius": f(o.radius / mm, 2), "share": o.travel_share,
        "start": [f(x / mm, 2) for x in o.start], "end": [f(x / mm, 2) for x in o.end],
    }  # fmt: skip


# --------------------------------------------------------------------------- limits


def _at_once(r: Response, quantities: frozenset[str] = AT_ONCE) -> Iterator[tuple[int, Asked]]:
    """Yield each limit that asks about a line somewhere, with its number."""
    for k, a in enumerate(asked(r, quantities=quantities)):
        if a.may.any():
            yield k, a


def _rows(r: Response, say: Language, quantities: frozenset[str] = AT_ONCE) -> Iterator[Json]:
    """Yield each limit of a line with its values, (states, parts), and where each was found."""
    every = list(_at_once(r, quantities))
    for (k, a), graded in zip(every, _graded([a for _, a in every]), strict=True):
        yield {
            **_limit(a.limit, r, k, say),
            "parts": [say.part(p) if p.kind != "line" else "" for p in a.parts],
            "kinds": [[p.kind, p.number, str(p.other)] for p in a.parts],
            **graded,
            **({"points": _points(r, a, say), "spots": _spots(r, a)} if a.spots else {}),
        }


def _graded(of: Sequence[Asked]) -> Iterator[Json]:
    """Yield the values of each limit with what it makes of them, (states, parts)."""
    if not of:
        return
    judged = [a.limit.judged(a.values) for a in of]
    known = [~np.isnan(a.values) for a in of]
    numbers = [
        *(a.values / QUANTITIES[a.limit.quantity].factor for a in of),
        *(np.where(k, margins, np.nan) for k, (_, margins) in zip(known, judged, strict=True)),
    ]
    # A hand waits for all of them: what is done to each number is done to all at once.
    told = iter(gs(np.concatenate([n.ravel() for n in numbers])))
    rows = [[list(islice(told, n.shape[1])) for _ in n] for n in numbers]
    for k, (values, margins) in enumerate(zip(rows[: len(of)], rows[len(of) :], strict=True)):
        grades = np.where(known[k], judged[k][0], -1).tolist()
        yield {
            "values": values,
            "margins": margins,
            "grades": [[None if g < 0 else g for g in row] for row in grades],
        }


def _foremost(r: Response) -> int:
    """Return the state with the worst of what is known at once; without limits, of most shaking."""
    worst = np.full(len(r.demand.states), -np.inf)
    for _, a in _at_once(r):
        known = ~np.isnan(a.values)
        bad = GRADE * a.limit.grades(a.values) - a.limit.margins(a.values)
        worst = np.maximum(worst, np.where(known, bad, -np.inf).max(axis=1))
    return int(worst.argmax()) if isfinite(worst.max()) else worst_state(r)


def _id(r: Response, limit: Limit, k: int) -> str:
    return f"{r.line.name}/{limit.quantity}/{k}"


def _limit(limit: Limit, r: Response, k: int, say: Language) -> Json:
    q = QUANTITIES[limit.quantity]

    def shown(value: float | None) -> float | None:
        return None if value is None else g(value / q.factor)

    return {
        "id": _id(r, limit, k),
        "quantity": limit.quantity,
        "line": r.line.name,
        "name": say.name(limit.quantity),
        "unit": q.unit_name,
        "sense": "band" if limit.band else limit.sense,
        "normal": shown(limit.normal),
        "maximum": shown(limit.maximum),
        "band": [shown(b) for b in limit.band] if limit.band else None,
        "required": limit.required,
        "source": cited(limit.source, say),
    }


def _points(r: Response, a: Asked, say: Language) -> list[list[str]]:
    """Return where in its state each value was found worst."""
    states, parts = a.values.shape
    return [
        [occasion(c, say) if (c := check(r, a, s, p)) else "" for p in range(parts)]
        for s in range(states)
    ]


def _spots(r: Response, a: Asked) -> list[list[Json | None]]:
    """Return under what torque in its state each value was found worst; None where its own."""
    assert a.spots is not None
    found: list[list[Json | None]] = []
    for s in range(len(a.values)):
        at = [a.spots.named((s, p)) if winds(r) else None for p in range(a.values.shape[1])]
        found.append([{"torque_Nm": g(q.torque), "way": q.direction} if q else None for q in at])
    return found


def _pending(r: Response, say: Language) -> Iterator[Json]:
    """Yield the limits whose values come with a later answer."""
    for k, limit in enumerate(m for m in r.application.limits if m.quantity in SOUGHT):
        if r.line.joint_count > 2:
            yield _limit(limit, r, k, say)


def _bar(
    read: Document, installed: Installed, of: Sensitivity, effect: Effect, say: Language
) -> Json:
    """Return what one move does to a check, what it spoils, and the edits that make it."""
    moved, value = of.better(effect)
    return {
        "said": move(moved, say),
        "spoilt": spoils(effect, say),
        "value": g(value / QUANTITIES[of.check.quantity].factor),
        "gain": g(of.gain(effect)),
        "edits": changes.edits(read, installed.line.name, [moved]),
    }


# --------------------------------------------------------------------------- sliders and dial


def _posed(read: Document, question: Json, say: Language) -> Json:
    """Return where sliders have a line, their reach and curves, and its turn; or why not.

    While a hand moves, curves that stand still meanwhile are left for later: not wanted.
    """
    asked_for: Mapping[str, Any] = question.get("pose") or {}
    wanted = question.get("want", ("curves", "turn"))
    travel, torque = asked_for.get("travel_mm"), asked_for.get("torque_Nm")
    free = travel is not None or torque is not None
    if not (free or wanted):
        return {}
    place_ = _shown(read, question)
    r = read.responses[place_]
    s = asked_for.get("state")
    s = _foremost(r) if s is None else min(max(int(s), 0), len(r.demand.states) - 1)
    reaches = read.reaches[place_]
    low, high = reaches.travel
    height = float(r.demand.travel[s]) if travel is None else float(np.clip(travel * mm, low, high))
    # A state stands unwound, but for one that is wound up by its torque.
    own = float(np.nan_to_num(r.demand.torque[s])) if r.kinds[s] in WOUND and not free else 0.0
    turned = float(np.clip(own if torque is None else torque, *reaches.torque))
    braked = asked_for.get("way") == "brake" and reaches.brakes if free else r.kinds[s] == BRAKED
    turned = min(turned, 0.0) if braked else turned
    posed: Json = {
        "line": place_,
        "state": None if free else s,
        "travel": f(height / mm, 2),
        "torque": f(turned, 0),
        "way": "brake" if braked else way(r, turned),
        "brakes": reaches.brakes,
        "travel_reach": [f(t / mm, 1) for t in reaches.travel],
        "torque_reach": [f(t, 0) for t in reaches.torque],
    }
    shown, k = r, s
    try:
        if free:
            if asked_for.get("way") and travel is None:
                posed["way"] = asked_for["way"]
                shown, k = under(r, Point("", posed["way"], 0.0, turned)), s
                height = float(shown.demand.travel[s])
                posed["travel"] = f(height / mm, 2)
            else:
                app, of = read.application, r.demand.installed
                shown, k = ride(app, of, travel=[height], torque=turned, brakes=braked), 0
            posed["at"] = _place(shown, k, r)
        if "curves" in wanted:
            posed |= _curves(read, r, reaches, height, turned, brakes=braked)
    except DesignError as error:
        posed["stuck"] = say.error(str(error))
        shown, k = r, s
    if "turn" in wanted:
        posed["turn"] = _turn(shown, k)
    return {"pose": posed}


def _place(r: Response, s: int, base: Response) -> Json:
    """Return a line in one place of its axle."""
    return {
        "laid": _laid(r.layout[s], r.demand.installed),
        "angles": fs(r.angles[s] / deg, 3),
        "side_angles": fs(r.side_angles[s] / deg, 3),
        "top_angles": fs(r.top_angles[s] / deg, 3),
        "positions": fs(r.positions[s] / deg, 1),
        "side": fs(r.layout.side[s] / deg, 3),
        "top": fs(r.layout.top[s] / deg, 3),
        "lengths": fs(r.layout.lengths[s] / mm, 1),
        "plunge": f(float(r.spline_travel[s]) / mm, 4),
        "clearance": fs(r.clearances[s] / mm, 4),
        "phasors": _phasors(r)[s],
        "equivalent": f(float(r.excitation.torsional.angle[s]) / deg, 3),
        "pitch": f(float(r.layout.side[s, -1] - base.demand.installed.layout.side[-1]) / deg, 3),
    }


def _curves(
    read: Document, r: Response, of: Reach, height: float, torque: float, *, brakes: bool
) -> Json:
    """Return what follows each slider while the other stays."""
    app, installed = read.application, r.demand.installed
    found: Json = {}
    most = min(of.torque[1], 0.0) if brakes else of.torque[1]
    for name, ends, unit in (("travel", of.travel, mm), ("torque", (of.torque[0], most), 1.0)):
        if not ends[1] > ends[0]:
            continue
        along = np.linspace(*ends, RIDE)
        at = {"travel": height, "torque": torque} | {name: along}
        over = ride(app, installed, travel=np.broadcast_to(at["travel"], along.shape),
                    torque=at["torque"], brakes=brakes)  # fmt: skip
        clear = over.clearances.min(axis=(-1, -2)) if over.obstacles else None
        found[f"over_{name}"] = {
            "x": fs(along / unit, 1),
            "angles": fs(over.angles.T / deg, 3),
            "equivalent": fs(over.excitation.torsional.angle / deg, 3),
            "plunge": fs(over.spline_travel / mm, 2),
            "clearance": None if clear is None else fs(clear / mm, 2),
        }
    return found


def _turn(r: Response, s: int) -> Json:
    """Return speed of every member round the turn, and the sum over the phase of each shaft."""
    layout, phases = r.layout, np.asarray(r.phases, dtype=float)
    one = turn(layout.directions[s], phases=phases, crosses=r.line.crosses, samples=ROUND)
    swept = np.linspace(0.0, np.pi, PHASES)
    side, top, _ = r.uneven
    over: list[Any] = []
    for k in range(phases.shape[-1]):
        tried = np.tile(phases, (PHASES, 1))
        tried[:, k] = swept
        terms = ae7_terms(side[s], top[s], phases=pin_phases(tried, r.line.crosses))
        over.append(fs(np.sqrt(np.abs(terms.sum(-1))) / deg, 3))
    speed = float(np.nan_to_num(r.demand.speed[s])) / rpm
    return {
        "theta": fs(np.linspace(0, 360, ROUND + 1), 1),
        "speed": fs(100 * (np.concatenate([one.speed, one.speed[:, :1]], axis=-1) - 1), 4),
        "rpm": f(speed, 0),
        "phases": fs(swept / deg, 1),
        "over_phase": over,
    }
