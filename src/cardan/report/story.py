"""The story a report tells, before any medium shapes it: chapters of tables and figures.

The page, the printed document and whatever comes after them tell the same story, in the
same order and the same words, because this is all they have to tell it from.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from cardan import __version__
from cardan.base.units import rpm
from cardan.base.verdict import Check, Grade, worst
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import Response
from cardan.report.compare import Compared, Variant, differences, effects
from cardan.report.drawing import drawings
from cardan.report.inputs import inputs
from cardan.report.language import Language
from cardan.report.plots import plots
from cardan.report.sheet import Row, line_title, sections
from cardan.report.stability import basis, campbell, distances, forced, named, worst_of_parts
from cardan.report.svg import Figure
from cardan.report.wording import (
    badness,
    cited,
    counts,
    move,
    moves_that_help,
    notes,
    place,
    problem,
    sense,
    sentence,
    worst_of_each,
)
from cardan.study.assess import Assessment, checks_of
from cardan.study.fix import Proposal
from cardan.study.sensitivity import Sensitivity
from cardan.study.stability import KEPT_FROM_RESONANCE, STEADY, Stability


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table: the first `words` columns are text, the others numbers.

    `grades` colours cells, "" leaves one plain; `row_heads` says whether the first column
    names its row.
    """

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    words: int = 1
    grades: tuple[tuple[str, ...], ...] = ()
    blank: bool = False


@dataclass(frozen=True, kw_only=True)
class Text:
    """Paragraphs."""

    paragraphs: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Points:
    """Points, each with what follows from it."""

    points: tuple[tuple[str, tuple[str, ...]], ...]
    caption: str = ""


@dataclass(frozen=True, kw_only=True)
class Figures:
    """Figures that stand together; wide ones one below the other."""

    figures: tuple[Figure, ...]
    wide: bool = False


@dataclass(frozen=True, kw_only=True)
class Verbatim:
    """A text to show as it is."""

    caption: str
    text: str


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A picture in pixels, and what a page that can move shows under it."""

    title: str
    png: bytes
    alt: str
    note: str = ""
    scene: str = ""
    """A fragment of HTML; a document on paper leaves it out."""


Block: TypeAlias = Table | Text | Points | Figures | Picture | Verbatim


@dataclass(frozen=True, kw_only=True)
class Chapter:
    """A heading and what stands under it."""

    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True, kw_only=True)
class Issue:
    """What says which report this is: the day, the file and what it held."""

    date: str = ""
    files: tuple[str, ...] = ()
    prints: tuple[str, ...] = ()
    """The first figures of each file's SHA-256."""
    texts: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Story:
    """A whole report."""

    language: str
    title: str
    subtitle: str
    grade: str
    verdict: str
    facts: tuple[tuple[str, str], ...]
    chapters: tuple[Chapter, ...]
    summary: str = ""
    """What stands beside the verdict, in a line."""
    date: str = ""
    version: str = field(default=__version__)


def assessment(
    of: Assessment,
    *,
    helps: Sequence[Sensitivity],
    fixes: Sequence[Proposal],
    say: Language,
    issue: Issue,
    vibration: Stability | None = None,
    more: Sequence[Chapter] = (),
) -> Story:
    """Return the story of one application: the verdict first, then what to change.

    Without `vibration` it says that nobody could ask about it. Chapters of other studies,
    `more`, follow the results.
    """
    several = len(of.responses) > 1
    chapters = [
        Chapter(title=say("Verdict"), blocks=tuple(_verdict(of, say))),
        Chapter(
            title=say("What to change"), blocks=tuple(_changes(helps, fixes, say, several=several))
        ),
        Chapter(title=say("Inputs"), blocks=tuple(_inputs(of, say))),
    ]
    for response in of.responses:
        chapters += _line(response, say, several=several)
    chapters += [
        Chapter(title=say("Vibration and stability"), blocks=tuple(_vibration(vibration, say))),
        *more,
        Chapter(title=say("Equations and sources"), blocks=tuple(_equations(of, vibration, say))),
        Chapter(title=say("Approval"), blocks=tuple(_approval(say, issue))),
    ]
    return Story(
        language=say.code,
        title=of.application.title,
        subtitle=say("Driveline approval report"),
        grade=of.verdict,
        verdict=say(of.verdict).upper(),
        facts=(
            (say("Checks"), counts(of.checks, say)),
            (say("Limits"), of.application.profile),
            (say("States"), say.list(*(say.given(s.name) for s in of.application.states))),
            *_signs(issue, say),
        ),
        chapters=tuple(chapters),
        summary=counts(of.checks, say),
        date=issue.date,
    )


def comparison(of: Sequence[Variant], *, say: Language, issue: Issue) -> Story:
    """Return the story of variants side by side."""
    names = tuple(f"{k}. {v.name}" for k, v in enumerate(of, 1))
    verdicts = Table(
        caption=say("Verdicts"),
        head=(say("variant"), say("verdict"), say("checks"), say("limits")),
        rows=tuple(
            (
                n,
                say(v.assessment.verdict).upper(),
                counts(v.assessment.checks, say),
                v.assessment.application.profile,
            )
            for n, v in zip(names, of, strict=True)
        ),
        words=4,
        grades=tuple(("", v.assessment.verdict, "", "") for v in of),
    )
    what = differences(of, say)
    chapters = [
        Chapter(title=say("Verdict"), blocks=(verdicts,)),
        Chapter(
            title=say("What differs in the input"),
            blocks=(
                (_compared(say("Inputs that differ"), names, what),)
                if what
                else (Text(paragraphs=(say("nothing"),)),)
            ),
        ),
        Chapter(
            title=say("What it does to each limit, where it is worst"),
            blocks=(_compared(say("Value and margin"), names, effects(of, say)),),
        ),
    ]
    for name, v in zip(names, of, strict=True):
        several = len(v.assessment.responses) > 1
        for r in v.assessment.responses:
            title = f"{name}: {r.line.name}" if several else name
            chapters.append(
                Chapter(
                    title=title,
                    blocks=(
                        *_states(r, say),
                        Figures(figures=drawings(r, say)[:2], wide=True),
                    ),
                )
            )
    chapters.append(Chapter(title=say("Approval"), blocks=tuple(_approval(say, issue))))
    grades = [v.assessment.verdict for v in of]
    return Story(
        language=say.code,
        title=say("Variants side by side"),
        subtitle=say.list(*(v.assessment.application.title for v in of)),
        grade="fail" if "fail" in grades else "warn" if "warn" in grades else "pass",
        verdict="; ".join(f"{n} {say(g).upper()}" for n, g in zip(names, grades, strict=True)),
        facts=tuple(_signs(issue, say)),
        chapters=tuple(chapters),
        date=issue.date,
    )


def _signs(issue: Issue, say: Language) -> Iterator[tuple[str, str]]:
    """Yield what tells this report from another."""
    for file, print_ in zip(issue.files, issue.prints, strict=True):
        yield say("File"), f"{file} (SHA-256 {print_})"
    if issue.date:
        yield say("Date"), issue.date
    yield say("Made with"), f"cardan {__version__}"


def _verdict(of: Assessment, say: Language) -> Iterator[Block]:
    """Yield the worst check of each limit and where the limits come from."""
    rows = worst_of_each(of.checks)
    sources = list(dict.fromkeys(str(c.limit.source) for c in rows))
    several = len(of.responses) > 1

    def row(c: Check) -> tuple[str, ...]:
        q = QUANTITIES[c.quantity]
        return (
            say(c.grade),
            q.named(say.code),
            place(c, say, several=several),
            say.number(c.value / q.factor),
            f"{sense(c, say)} {say.number(c.bound / q.factor)}",
            q.unit_name,
            say.percent(c.margin),
            f"[{sources.index(str(c.limit.source)) + 1}]",
        )

    yield Table(
        caption=say("Every limit, where it is worst"),
        head=(
            say("verdict"),
            say("limit"),
            say("where it is worst"),
            say("value"),
            say("bound"),
            say("unit"),
            say("margin"),
            say("source"),
        ),
        rows=tuple(row(c) for c in rows),
        words=3,
        grades=tuple((c.grade, *[""] * 7) for c in rows),
    )
    yield Points(
        caption=say("Where the limits come from"),
        points=tuple((f"[{k}] {source}", ()) for k, source in enumerate(sources, 1)),
    )
    if found := notes(of, say):
        yield Text(paragraphs=tuple(found))


def _changes(
    helps: Sequence[Sensitivity], fixes: Sequence[Proposal], say: Language, *, several: bool
) -> Iterator[Block]:
    """Yield corrections, and what each thing that can be moved would do."""
    if not helps:
        yield Text(paragraphs=(say("Everything passes; nothing needs to change."),))
        return
    if fixes:
        yield Points(
            caption=say("Corrections over all states at once, best first"),
            points=tuple(_proposal(k, p, say) for k, p in enumerate(fixes, 1)),
        )
    yield Points(
        caption=say("What would help, each move alone"),
        points=tuple(
            (
                problem(one, say, several=several),
                tuple(moves_that_help(one, say)) or (say("nothing that can be moved"),),
            )
            for one in helps
        ),
    )


def _proposal(k: int, p: Proposal, say: Language) -> tuple[str, tuple[str, ...]]:
    """Return one correction: its verdict, what it moves, what still does not pass."""
    won = say(
        "smallest margin {margin}, cost {cost}",
        margin=say.percent(p.margin),
        cost=say.short(round(p.cost, 2)),
    )
    bad = worst_of_each(c for c in p.checks if c.grade != "pass")
    still = tuple(
        say("still {grade}: {check}", grade=say(c.grade), check=sentence(c, say)) for c in bad[:3]
    )
    moves = tuple(move(m, say) for m in p.moves)
    return f"{k}. {say(p.verdict).upper()}, {won} ({p.line})", (*moves, *still)


def _inputs(of: Assessment, say: Language) -> Iterator[Block]:
    """Yield what was given, group by group."""
    every = inputs(of.application, say)
    for group in dict.fromkeys(i.group for i in every):
        yield Table(
            caption=group,
            head=(say("input"), say("value")),
            rows=tuple((i.name, i.value) for i in every if i.group == group),
            words=2,
        )


def _line(r: Response, say: Language, *, several: bool) -> Iterator[Chapter]:
    """Yield results, drawings and plots of one line."""
    end = f": {r.line.name}" if several else ""
    first, second, *others = drawings(r, say)
    yield Chapter(
        title=say("Results by state") + end,
        blocks=(Text(paragraphs=(line_title(r, say) + ".",)), *_states(r, say)),
    )
    yield Chapter(
        title=say("Drawings") + end,
        blocks=(
            Figures(figures=(first, second, others[0]), wide=True),
            Figures(figures=tuple(others[1:])),
        ),
    )
    yield Chapter(title=say("Plots") + end, blocks=(Figures(figures=plots(r, say)),))


def _states(r: Response, say: Language) -> Iterator[Table]:
    """Yield the numbers of a line, rows over states."""
    states = tuple(say.given(s) for s in r.demand.states)
    graded = _grades(r)
    for section in sections(r):
        yield Table(
            caption=say(section.title),
            head=(say("quantity"), say("unit"), *states),
            rows=tuple(
                (
                    row.label(say).replace("  ", "\u2003"),
                    row.unit,
                    *(say.number(v) for v in row.values),
                )
                for row in section.rows
            ),
            words=2,
            grades=tuple(("", "", *_row_grades(row, graded, r)) for row in section.rows),
        )


def _grades(r: Response) -> dict[tuple[str, str, str], Grade]:
    """Return the worst grade of each quantity, part and state that does not pass."""
    found: dict[tuple[str, str, str], Grade] = {}
    for c in sorted(checks_of(r), key=badness, reverse=True):
        if c.grade != "pass":
            # A clearance is checked shaft by shaft, and shown obstacle by obstacle.
            part = c.part.partition(" to ")[2] or c.part
            found[c.quantity, part, c.state] = c.grade
    return found


def _row_grades(
    row: Row, graded: dict[tuple[str, str, str], Grade], r: Response
) -> tuple[str, ...]:
    """Return the grade of each value of a row; approximations are not what is checked."""
    if row.method:
        return ("",) * len(row.values)
    part = f"centre {row.part}" if row.part.startswith("bearing ") else row.part or "line"
    asked = ("joint_angle", "joint_angle_min") if row.quantity == "joint_angle" else (row.quantity,)
    shown: list[str] = []
    for state in r.demand.states:
        grades: list[Grade] = [graded.get((q, part, state), "pass") for q in asked]
        shown.append("" if worst(grades) == "pass" else worst(grades))
    return tuple(shown)


def _vibration(of: Stability | None, say: Language) -> Iterator[Block]:
    """Yield how far each range of speed stays from resonances and zones, and what grows."""
    if of is None:
        asked = say.list(*(say.name(q).lower() for q in (KEPT_FROM_RESONANCE.quantity, *STEADY)))
        yield Text(paragraphs=(say("Not asked, for want of data: {names}.", names=asked),))
        return
    verdict = say("Vibration: {verdict} ({counts}).", verdict=say(of.verdict).upper(),
                  counts=counts(of.checks, say))  # fmt: skip
    hint = say("0 % runs through it; − stays below its speed, + above.")
    yield Text(paragraphs=(verdict, *basis(of, say), hint))
    for v in of.lines:
        end = f": {v.line.name}" if len(of.lines) > 1 else ""
        rows = tuple(distances(v, of.checks))
        yield Table(
            caption=say("How far each range of speed stays from resonances and zones") + end,
            head=(say("resonance or zone"), say("at [rpm]"), *(named(g, say) for g in v.gears)),
            rows=tuple(
                (
                    named(row.part, say),
                    say.number(row.speed / rpm),
                    *(say.percent(share) if share else "0 %" for share in row.shares),
                )
                for row in rows
            ),
            grades=tuple(("", "", *("" if g == "pass" else g for g in row.grades)) for row in rows),
        )
        growing = sorted(
            worst_of_parts(c for c in of.checks if c.line == v.line.name and c.quantity in STEADY),
            key=badness,
        )
        yield Table(
            caption=say("Growth of vibrations, where it is worst") + end,
            head=(say("verdict"), say("limit"), say("where it is worst"), say("value"),
                  say("bound"), say("unit")),
            rows=tuple(_growth(c, say) for c in growing),
            words=3,
            grades=tuple((c.grade, *[""] * 5) for c in growing),
        )  # fmt: skip
        yield Figures(figures=(campbell(v, say), forced(v, say)))


def _growth(c: Check, say: Language) -> tuple[str, ...]:
    """Return a check on growth as a row."""
    q = QUANTITIES[c.quantity]
    where = say.list(named(c.part, say), named(c.state, say))
    value, bound = say.number(c.value / q.factor), say.number(c.bound / q.factor)
    return say(c.grade), q.named(say.code), where, value, f"{sense(c, say)} {bound}", q.unit_name


def _equations(of: Assessment, vibration: Stability | None, say: Language) -> Iterator[Block]:
    """Yield the declaration of every quantity this report shows."""
    shown = {row.quantity for r in of.responses for s in sections(r) for row in s.rows}
    shown |= {c.quantity for c in (*of.checks, *(vibration.checks if vibration else ()))}
    used = [q for key, q in QUANTITIES.items() if key in shown]
    yield Table(
        caption=say("Quantities of this report"),
        head=(say("quantity"), say("symbol"), say("equation"), say("limits of use"), say("source")),
        rows=tuple(
            (
                q.named(say.code),
                f"{q.symbol} [{q.unit_name}]" if q.unit_name else q.symbol,
                "; ".join(
                    [say.given(q.equation), *(f"{s}: {say.given(w)}" for s, w in q.where.items())]
                ),
                say.given(q.use) if q.use else "",
                cited(q.source, say),
            )
            for q in used
        ),
        words=5,
    )


def _approval(say: Language, issue: Issue) -> Iterator[Block]:
    """Yield the revision block, for two companies to sign, and what the file said."""
    yield Table(
        caption=say("Revisions"),
        head=(say("revision"), say("date"), say("change"), say("made by"), say("checked by")),
        rows=(("0", issue.date, say("first issue"), "", ""), *[("", "", "", "", "")] * 2),
        words=5,
        blank=True,
    )
    yield Table(
        caption=say("Agreed between"),
        head=("", say("vehicle maker"), say("driveline maker")),
        rows=tuple((say(row), "", "") for row in ("company", "name", "date", "signature")),
        words=3,
        blank=True,
    )
    for file, text in zip(issue.files, issue.texts, strict=False):
        yield Verbatim(caption=say("Application file {file}", file=file), text=text)


def _compared(caption: str, names: tuple[str, ...], rows: Iterable[Compared]) -> Table:
    """Return rows of variants as a table; a star marks where verdicts differ."""
    rows = tuple(rows)
    return Table(
        caption=caption,
        head=("", *names),
        rows=tuple((f"{r.name} *" if r.changed else r.name, *r.values) for r in rows),
        words=1 if any(g for r in rows for g in r.grades) else len(names) + 1,
        grades=tuple(("", *(g or "" for g in r.grades)) for r in rows),
    )


def figures(of: Story) -> Iterator[Figure]:
    """Yield every figure of a story, in order."""
    for chapter in of.chapters:
        for block in chapter.blocks:
            if isinstance(block, Figures):
                yield from block.figures


__all__ = [
    "Block",
    "Chapter",
    "Figures",
    "Issue",
    "Picture",
    "Points",
    "Story",
    "Table",
    "Text",
    "Verbatim",
    "assessment",
    "comparison",
    "figures",
]
