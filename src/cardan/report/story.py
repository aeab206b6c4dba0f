"""The story a report tells, before any medium shapes it: chapters of tables and figures.

The page, the printed document and whatever comes after them tell the same story, in the
same order and the same words, because this is all they have to tell it from.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from cardan import __version__
from cardan.base.part import Part
from cardan.base.verdict import Check, Grade, Verdict, badness, worst
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import Response
from cardan.report import bracket_chapter, phased, vibration_chapter
from cardan.report.blocks import (
    Block,
    Chapter,
    Figures,
    Issue,
    Points,
    Story,
    Table,
    Text,
    Verbatim,
    figures,
)
from cardan.report.compare import Compared, Variant, differences, effects
from cardan.report.data import blocks as data_used
from cardan.report.drawing import drawable, drawings, in_state, state_to_show
from cardan.report.inputs import inputs
from cardan.report.language import Language
from cardan.report.plots import plots
from cardan.report.sheet import Row, line_title, sections, shown_as
from cardan.report.terminal import instead
from cardan.report.wording import (
    STUDY_TITLES,
    cited,
    counts,
    gaps,
    held,
    left,
    move,
    moves_that_help,
    notes,
    nothing_better,
    out_of_reach,
    place,
    problem,
    scattered,
    sense,
    sentence,
    standing,
    survives,
    unanswered,
    won,
    worst_of_each,
)
from cardan.study.approval import Approval
from cardan.study.finding import BRACKET, DRIVELINE, RECORDING, VIBRATION, Finding
from cardan.study.fix import Proposal, fix
from cardan.study.sensitivity import Sensitivity, sensitivities
from cardan.study.sizing import next_sizes

__all__ = ["Issue", "Story", "approval", "comparison", "figures", "verdict", "whole"]


def whole(
    of: Approval,
    *,
    say: Language,
    issue: Issue,
    state: str | None = None,
    corrections: bool = True,
    short: bool = False,
    tell: Callable[[int, int], None] | None = None,
) -> Story:
    """Return the story of one application, with what would help and the best corrections.

    The line is drawn in a `state`; by default in the one that decides. Corrections of a line
    of three shafts take half a minute to find, of four minutes: without them the story says that
    nobody looked. `short` leaves out what nobody decides by: numbers of every state, inputs,
    equations.
    """
    helps = sensitivities(of)
    fixes = None if helps and not corrections else ()
    if helps and corrections:
        fixes = fix(of.application, count=3, tell=tell)
    return approval(of, helps=helps, fixes=fixes, say=say, issue=issue, state=state, short=short)


def approval(
    of: Approval,
    *,
    helps: Sequence[Sensitivity],
    fixes: Sequence[Proposal] | None,
    say: Language,
    issue: Issue,
    more: Sequence[Chapter] = (),
    state: str | None = None,
    short: bool = False,
) -> Story:
    """Return the story of one application: on its first page what decides and what to change.

    The line is drawn in a `state`, by default the one that decides. A chapter for each study
    that was asked; `more` follow them, and what was given stands at the end.
    """
    say, several = say.typeset, len(of.responses) > 1
    first = tuple(_first_page(of, helps, fixes, say, state=state))
    chapters = [
        Chapter(title=say("Verdict"), blocks=first),
        Chapter(title=say("Limits"), blocks=tuple(verdict(of, say, short=short))),
        Chapter(title=say("What to change"), blocks=tuple(_changes(of, helps, fixes, say))),
    ]
    for response in () if short else of.responses:
        chapters += _line(response, of.checks, say, several=several)
    chapters += [
        *_studies(of, say, short=short),
        *more,
        Chapter(title=say("Approval"), blocks=tuple(_approval(say, issue))),
    ]
    if not short:
        chapters += [
            Chapter(title=say("Inputs"), blocks=(*_inputs(of, say), *_given(say, issue))),
            Chapter(title=say("Equations and sources"), blocks=tuple(_equations(of, say))),
        ]
    return Story(
        language=say.code,
        title=of.application.title,
        subtitle=say("Driveline approval report"),
        grade=of.verdict,
        verdict=say(of.verdict).upper(),
        facts=(
            (say("Coverage"), _covered(of, say)),
            (say("Limits"), of.application.profile),
            (say("States"), say.list(*(say.state(s.name) for s in of.application.states))),
            *signs(issue, say),
        ),
        chapters=tuple(chapters),
        summary=counts(of, say),
        date=issue.date,
    )


def comparison(of: Sequence[Variant], *, say: Language, issue: Issue) -> Story:
    """Return the story of variants side by side."""
    say = say.typeset
    names = tuple(f"{k}. {v.name}" for k, v in enumerate(of, 1))
    verdicts = Table(
        caption=say("Verdicts"),
        head=(say("variant"), say("verdict"), say("checks"), say("limits")),
        rows=tuple(
            (
                n,
                say(v.approval.verdict).upper(),
                counts(v.approval, say),
                v.approval.application.profile,
            )
            for n, v in zip(names, of, strict=True)
        ),
        words=4,
        grades=tuple(("", v.approval.verdict, "", "") for v in of),
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
        several = len(v.approval.responses) > 1
        for r in v.approval.responses:
            title = f"{name}: {r.line.name}" if several else name
            chapters.append(
                Chapter(
                    title=title,
                    blocks=(
                        *_states(r, v.approval.checks, say),
                        Figures(figures=drawings(r, say)[: 2 if drawable(r) else 1], wide=True),
                    ),
                )
            )
    signed = (*_approval(say, issue), *_given(say, issue))
    chapters.append(Chapter(title=say("Approval"), blocks=signed))
    grades: list[Verdict] = [v.approval.verdict for v in of]
    return Story(
        language=say.code,
        title=say("Variants side by side"),
        subtitle=say.list(*(v.approval.application.title for v in of)),
        grade=worst(grades),
        verdict="; ".join(f"{n} {say(g).upper()}" for n, g in zip(names, grades, strict=True)),
        facts=tuple(signs(issue, say)),
        chapters=tuple(chapters),
        date=issue.date,
    )


def signs(issue: Issue, say: Language) -> Iterator[tuple[str, str]]:
    """Yield what tells this report from another."""
    for file, print_ in zip(issue.files, issue.prints, strict=True):
        yield say("File"), f"{file} (SHA-256 {print_})"
    if issue.date:
        yield say("Date"), issue.date
    yield say("Made with"), f"cardan {__version__}"


DECIDING = 3
"""Rows of the first page: the limits that decide, and the first things to change."""


def _covered(of: Approval, say: Language) -> str:
    """Return how much of what was asked is answered, and how near the nearest limit is."""
    said = say(
        "{answered} of {asked} questions answered", answered=of.coverage.answered,
        asked=of.coverage.asked,
    )  # fmt: skip
    if of.smallest_margin is None:
        return said
    margin = say("smallest margin {margin}", margin=say.percent(of.smallest_margin))
    return f"{said}; {margin}"


def _first_page(
    of: Approval,
    helps: Sequence[Sensitivity],
    fixes: Sequence[Proposal] | None,
    say: Language,
    *,
    state: str | None,
) -> Iterator[Block]:
    """Yield what decides: three rows, the line in the state that does, what to change."""
    rows = worst_of_each(of.checks)[:DECIDING]
    several = len(of.responses) > 1
    if rows:
        yield _rows(rows, say, caption=say("What decides"), several=several)
    if of.verdict == "incomplete" and (open_ := unanswered(of, say, required=True)):
        yield Points(caption=say("Required, and without an answer"),
                     points=tuple((one, ()) for one in open_))  # fmt: skip
    names = [r.line.name for r in of.responses]
    line = next((c.line for c in rows if c.line in names), names[0] if names else None)
    for r in of.responses:
        if r.line.name == line and drawable(r):
            s, at = state_to_show(r, rows if state is None else (), state)
            yield Figures(figures=(in_state(r, say, s, at),), wide=True)
    said: list[tuple[str, tuple[str, ...]]] = []
    if fixes:
        title, moves = _proposal(1, fixes[0], say)
        said.append((title, moves[: len(fixes[0].moves)]))
    for one in helps[:DECIDING]:
        moves = tuple(moves_that_help(one, say)[:1]) or (say("nothing that can be moved"),)
        said.append((problem(one, say, several=several), moves))
    if said:
        yield Points(caption=say("What to change first"), points=tuple(said))
    yield from _untried(rows, say, several=several)


def verdict(of: Approval, say: Language, *, short: bool = False) -> Iterator[Block]:
    """Yield the worst check of each limit and where the limits come from.

    `short` leaves out the limits that pass, but the nearest few.
    """
    every = worst_of_each(of.checks)
    bad = sum(c.grade != "pass" for c in every)
    rows = every[: bad + DECIDING] if short else every
    several = len(of.responses) > 1
    sources = list(dict.fromkeys(cited(c.limit.source, say) for c in rows))
    yield _rows(rows, say, caption=say("Every limit, where it is worst"), several=several,
                sources=sources)  # fmt: skip
    if len(rows) < len(every):
        yield Text(paragraphs=(say("{count} more limits pass.", count=len(every) - len(rows)),))
    yield Points(
        caption=say("Where the limits come from"),
        points=tuple((f"[{k}] {source}", ()) for k, source in enumerate(sources, 1)),
    )
    if found := unanswered(of, say):
        yield Points(
            caption=say(
                "Without an answer ({answered} of {asked} answered)",
                answered=of.coverage.answered,
                asked=of.coverage.asked,
            ),
            points=tuple((line, ()) for line in found),
        )
    if found := notes(of, say):
        yield Text(paragraphs=tuple(found))


def _rows(
    rows: Sequence[Check],
    say: Language,
    *,
    caption: str,
    several: bool,
    sources: Sequence[str] = (),
) -> Table:
    """Return checks as a table; with `sources` their numbers stand at the end."""

    def row(c: Check) -> tuple[str, ...]:
        q, (value, bound) = QUANTITIES[c.quantity], held(c, say)
        return (
            say(c.grade),
            say.name(q.key),
            place(c, say, several=several),
            value,
            f"{sense(c, say)} {bound}",
            q.unit_name,
            say.percent(c.margin),
            *((f"[{sources.index(cited(c.limit.source, say)) + 1}]",) if sources else ()),
        )

    head = (
        say("verdict"),
        say("limit"),
        say("where it is worst"),
        say("value"),
        say("bound"),
        say("unit"),
        say("margin"),
        *((say("source"),) if sources else ()),
    )
    return Table(
        caption=caption,
        head=head,
        rows=tuple(row(c) for c in rows),
        words=3,
        grades=tuple((c.grade, *[""] * (len(head) - 1)) for c in rows),
    )


def _changes(
    of: Approval,
    helps: Sequence[Sensitivity],
    fixes: Sequence[Proposal] | None,
    say: Language,
) -> Iterator[Block]:
    """Yield corrections, what each move would do, and what no move of a line answers."""
    several = len(of.responses) > 1
    sizes = next_sizes(of.application, out_of_reach(helps))
    if of.verdict == "pass":
        yield Text(
            paragraphs=(
                say("What has an answer passes; nothing needs to change.")
                if of.coverage.unanswered
                else say("Everything passes; nothing needs to change."),
            )
        )
    elif not of.checks:
        yield Text(paragraphs=(say("Nothing was held against a limit, so nothing is approved."),))
    if fixes is None:
        nobody = say("Corrections over all states were not looked for: cardan fix does.")
        yield Text(paragraphs=(nobody,))
    elif fixes:
        yield Points(
            caption=say("Corrections over all states at once, best first"),
            points=tuple(_proposal(k, p, say) for k, p in enumerate(fixes, 1)),
        )
        if scatter := scattered(fixes[0].trucks, say):
            yield Text(paragraphs=(scatter,))
    elif helps:
        yield Text(paragraphs=(nothing_better(say),))
    if helps:
        yield Points(
            caption=say("What would help, each move alone"),
            points=tuple(
                (
                    problem(one, say, several=several),
                    tuple(moves_that_help(one, say))
                    or (instead(one.check, sizes.get((one.check.line, one.check.quantity)), say),),
                )
                for one in helps
            ),
        )
    yield from _untried(of.checks, say, several=several)
    if of.coverage.missed:
        yield Points(
            caption=say("What no move answers"),
            points=tuple((gap, ()) for gap in gaps(of.coverage.missed, say, several=several)),
        )


def _untried(checks: Sequence[Check], say: Language, *, several: bool) -> Iterator[Block]:
    """Yield what other studies found: moves are tried on what the driveline answers."""
    beyond = [
        c for c in checks
        if c.grade != "pass" and QUANTITIES[c.quantity].study not in ("", DRIVELINE)
    ]  # fmt: skip
    if beyond:
        yield Points(
            caption=say("What other studies found: no move was tried against it"),
            points=tuple((_beyond(c, say, several=several), ()) for c in worst_of_each(beyond)),
        )


def _beyond(c: Check, say: Language, *, several: bool) -> str:
    """Return a check that does not pass: how bad it is, of which study and line, and how much."""
    study = say(QUANTITIES[c.quantity].study)
    of = say.list(study, c.line) if several else study
    return say("{grade} ({study}): {check}", grade=say(c.grade), study=of, check=sentence(c, say))


def _proposal(k: int, p: Proposal, say: Language) -> tuple[str, tuple[str, ...]]:
    """Return one correction: its verdict, what it moves, what still does not pass."""
    cost = say.short(round(p.cost, 2))
    to = say("{standing}, cost {cost}", standing=standing(p.approval, say), cost=cost)
    moves = tuple(move(m, say) for m in p.moves)
    return f"{k}. {to} ({p.line})", (
        *moves,
        won(p, say),
        *survives(p.survival, p.trucks, say),
        *left(p, say),
    )


def _inputs(of: Approval, say: Language) -> Iterator[Block]:
    """Yield what was given, group by group."""
    every = inputs(of.application, say)
    for group in dict.fromkeys(i.group for i in every):
        yield Table(
            caption=group,
            head=(say("input"), say("value")),
            rows=tuple((i.name, i.value) for i in every if i.group == group),
            words=2,
        )
    yield from data_used(of, say)


def _line(
    r: Response, checks: tuple[Check, ...], say: Language, *, several: bool
) -> Iterator[Chapter]:
    """Yield results, drawings and plots of one line."""
    end = f": {r.line.name}" if several else ""
    *views, phases, planes, sums = drawings(r, say)
    yield Chapter(
        title=say("Results by state") + end,
        blocks=(
            Text(paragraphs=(line_title(r, say) + ".",)),
            *_states(r, checks, say),
        ),
    )
    yield Chapter(
        title=say("Drawings") + end,
        blocks=(
            Figures(figures=(*views, phases), wide=True),
            *phased.table(r, say),
            Figures(figures=(planes, sums)),
        ),
    )
    yield Chapter(title=say("Plots") + end, blocks=(Figures(figures=plots(r, say)),))


def _states(r: Response, checks: tuple[Check, ...], say: Language) -> Iterator[Table]:
    """Yield the numbers of a line, rows over states."""
    states = tuple(say.state(s) for s in r.demand.states)
    graded = _grades(c for c in checks if c.line == r.line.name)
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


def _grades(checks: Iterable[Check]) -> dict[tuple[str, Part, str], Grade]:
    """Return the worst grade of each quantity, part and state that does not pass."""
    found: dict[tuple[str, Part, str], Grade] = {}
    for c in sorted(checks, key=badness, reverse=True):
        if c.grade != "pass":
            found[c.quantity, shown_as(c.part), str(c.when)] = c.grade
    return found


def _row_grades(
    row: Row, graded: dict[tuple[str, Part, str], Grade], r: Response
) -> tuple[str, ...]:
    """Return the grade of each value of a row; approximations are not what is checked."""
    if row.method:
        return ("",) * len(row.values)
    shown: list[str] = []
    for state in r.demand.states:
        grade = worst([graded.get((q, row.part, state), "pass") for q in row.asked])
        shown.append("" if grade == "pass" else grade)
    return tuple(shown)


def _studies(of: Approval, say: Language, *, short: bool) -> Iterator[Chapter]:
    """Yield a chapter for each study that was asked beside the driveline."""
    told: dict[str, Callable[[Finding[Any], Language], Iterator[Block]]] = {
        VIBRATION: vibration_chapter.chapter,
        BRACKET: bracket_chapter.chapter,
    }
    for f in of.findings:
        if f.study == RECORDING and f.answer is not None:
            from cardan.report import recording_chapter  # few reports tell of one

            yield from recording_chapter.chapters(f.answer, say, short=short)
        elif f.study in told and f.asked:
            blocks = told[f.study](f, say) if f.answer else _not_asked(f, say)
            yield Chapter(title=say(STUDY_TITLES[f.study]), blocks=tuple(blocks))


def _not_asked(of: Finding[Any], say: Language) -> Iterator[Block]:
    """Yield why a study has no answer."""
    yield Text(
        paragraphs=tuple(
            say("{study} could not be asked: {why}.", study=say(of.study), why=why.rstrip("."))
            for why in of.doubts
        )
    )


def _equations(of: Approval, say: Language) -> Iterator[Block]:
    """Yield the declaration of every quantity that a limit of this report asks about."""
    shown = {c.quantity for c in of.checks} | {u.quantity for u in of.coverage.unanswered}
    used = [q for key, q in QUANTITIES.items() if key in shown]
    yield Table(
        caption=say("Quantities that limits ask about; `cardan explain` tells every other"),
        head=(say("quantity"), say("symbol"), say("equation"), say("limits of use"), say("source")),
        rows=tuple(
            (
                say.name(q.key),
                f"{q.symbol} [{q.unit_name}]" if q.unit_name else q.symbol,
                "; ".join(
                    [say.given(q.stated), *(f"{s}: {say.given(w)}" for s, w in q.where.items())]
                ),
                say.given(q.use) if q.use else "",
                cited(q.source, say),
            )
            for q in used
        ),
        words=5,
    )


def _approval(say: Language, issue: Issue) -> Iterator[Block]:
    """Yield the revision block, for two companies to sign."""
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


def _given(say: Language, issue: Issue) -> Iterator[Block]:
    """Yield what the files said."""
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
