"""First page of an approval report: the sheet that two companies sign.

Criteria as required against as achieved, the side view, open points and signatures. Everything
that they rest on is the annex, from the next page on.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from cardan.approval.approval import Approval
from cardan.core.verdict import CHECK_GRADES, Check
from cardan.documents.comparison import Variant, input_differences
from cardan.documents.criteria import (
    Criterion,
    CriterionKey,
    condition_texts,
    criteria_of,
    full_name,
    limit_qualifiers,
    short_name,
)
from cardan.documents.first_screen import (
    criteria_count_text,
    points_before_signing,
    single_correction_texts,
)
from cardan.documents.line_drawing import (
    has_known_geometry,
    side_view_in_state,
    state_to_draw,
)
from cardan.model.application import Application
from cardan.render.blocks import (
    Block,
    BulletList,
    Chapter,
    Figures,
    ReportDateAndSourceStamp,
    Table,
    Text,
)
from cardan.render.check_texts import (
    limit_text,
    lower_bound_explanation,
    unit_text,
    value_text,
)
from cardan.render.i18n import Translator
from cardan.render.phrases import (
    adjustment_phrase,
    grade_text,
    unevaluated_limit_lines,
    worst_check_per_limit,
)
from cardan.topics.design.corrections import Correction
from cardan.topics.design.phrases import correction_standing_sentence
from cardan.topics.design.sensitivity import CheckSensitivity

MAX_ROWS = 10
"""Criteria on the sheet; the rest is counted."""

MIN_ROWS = 4
"""Criteria on the sheet where fewer than these are not met: the nearest to their limits follow."""

MAX_OPEN_POINTS = 6

MAX_OPEN_POINT_CHARACTERS = 240
"""Of one open point: two lines; the annex has the whole."""

SIDE_VIEW_HEIGHT_MM = 38.0


def identification_facts(of: Application, say: Translator) -> tuple[tuple[str, str], ...]:
    """Return customer, vehicle, drawing and revision; a line to write on where not given."""
    given = of.report
    return (
        (say("Customer"), given.customer or BLANK),
        (say("Vehicle"), given.vehicle or BLANK),
        (say("Drawing"), given.drawing or BLANK),
        (say("Revision"), given.revision or BLANK),
    )


BLANK = "\N{HORIZONTAL ELLIPSIS}" * 8
"""Dots to write on, in place of what the file does not give."""


def approval_sheet(
    of: Approval,
    *,
    helps: Sequence[CheckSensitivity],
    fixes: Sequence[Correction] | None,
    say: Translator,
    state: str | None,
) -> Chapter:
    """Return the sheet of one application; the line is drawn in a `state`, or where it decides."""
    blocks = [
        *_criteria_blocks(of, say),
        *_side_view(of, say, state=state),
        *_open_point_blocks(_open_points(of, helps, fixes, say), say),
        signature_table(of.application, say),
    ]
    return Chapter(title=say("Approval sheet"), blocks=tuple(blocks))


def comparison_sheet(of: Sequence[Variant], names: Sequence[str], say: Translator) -> Chapter:
    """Return the sheet of variants side by side, such as before and after; the last is signed."""
    last = of[-1].approval
    blocks = [
        _comparison_table([v.approval for v in of], names, say),
        Text(
            paragraphs=tuple(
                f"{name}: {criteria_count_text(v.approval, say)}"
                for name, v in zip(names, of, strict=True)
            )
        ),
        *_difference_blocks(of, names, say),
        *_side_view(last, say, state=None, variant=names[-1]),
        *_open_point_blocks(_open_points(last, (), None, say), say, variant=names[-1]),
        signature_table(last.application, say),
    ]
    return Chapter(title=say("Approval sheet"), blocks=tuple(blocks))


# --------------------------------------------------------------------------- criteria


def _chosen(criteria: Sequence[Criterion]) -> list[Criterion]:
    """Return the criteria that have rows: those not met first, the worst of them first."""
    unmet = [c for c in criteria if c.grade != "pass"]
    met = [c for c in criteria if c.grade == "pass"]
    return [*unmet, *met[: max(0, MIN_ROWS - len(unmet))]][:MAX_ROWS]


def _qualifiers(of: Approval) -> dict[CriterionKey, str]:
    every = [*of.checks, *of.coverage.unevaluated]
    return dict(limit_qualifiers(every, of.application))


def _criteria_blocks(of: Approval, say: Translator) -> Iterator[Block]:
    """Yield the criteria that decide, required against achieved, and the count of all."""
    criteria, qualifiers = criteria_of(of.checks), _qualifiers(of)
    several = len(of.line_responses) > 1
    rows = _chosen(criteria)

    def name(c: Check) -> str:
        said = full_name(c, say, qualifiers)
        return f"{c.line}: {said}" if several else f"{said[:1].upper()}{said[1:]}"

    if rows:
        yield Table(
            caption=say("Criteria: required and achieved"),
            head=(say("verdict"), say("criterion"), say("where it is worst"), say("required"),
                  say("achieved"), say("margin")),
            rows=tuple(
                (
                    grade_text(c.grade, say), name(c.worst), condition_texts(c.worst, say)[0],
                    limit_text(c.worst, say), _achieved_text(c.worst, say),
                    say.margin_text(c.worst.margin),
                )
                for c in rows
            ),
            words=3,
            grades=tuple((c.grade, "", "", "", "", "") for c in rows),
        )  # fmt: skip
    for sentence in lower_bound_explanation((_achieved_text(c.worst, say) for c in rows), say):
        yield Text(paragraphs=(f"{sentence}.",))
    if rest := len(criteria) - len(rows):
        more = say.count("{count} more in the annex", "{count} more in the annex", rest)
        yield Text(paragraphs=(f"{more}.",))


def _achieved_text(c: Check, say: Translator) -> str:
    return f"{value_text(c, say)} {unit_text(c)}".rstrip()


def _graded_text(c: Criterion, say: Translator) -> str:
    return f"{_achieved_text(c.worst, say)} ({grade_text(c.grade, say)})"


def _comparison_table(of: Sequence[Approval], names: Sequence[str], say: Translator) -> Table:
    """Return criteria against each variant's value, the worst of any variant first."""
    found = [{c.key: c for c in criteria_of(a.checks)} for a in of]
    keys = dict.fromkeys(key for one in found for key in one)

    def severity(key: CriterionKey) -> tuple[int, float]:
        return min(
            (-CHECK_GRADES.index(one[key].grade), one[key].worst.margin)
            for one in found
            if key in one
        )

    ranked = sorted(keys, key=severity)
    unmet = [k for k in ranked if any(k in one and one[k].grade != "pass" for one in found)]
    chosen = [*unmet, *(k for k in ranked if k not in unmet)][: max(MIN_ROWS, len(unmet))]
    rows: list[tuple[str, ...]] = []
    grades: list[tuple[str, ...]] = []
    several = any(len(a.line_responses) > 1 for a in of)
    for key in chosen[:MAX_ROWS]:
        here = [one.get(key) for one in found]
        at, check = next((k, c.worst) for k, c in reversed([*enumerate(here)]) if c is not None)
        name = short_name(check, say, _qualifiers(of[at]))
        rows.append((
            f"{check.line}: {name}" if several else name, limit_text(check, say),
            *(_graded_text(c, say) if c else "-" for c in here),
        ))  # fmt: skip
        grades.append(("", "", *(c.grade if c else "" for c in here)))
    return Table(
        caption=say("Criteria: required and achieved"),
        head=(say("criterion"), say("required"), *names),
        rows=tuple(rows),
        words=1,
        grades=tuple(grades),
    )


def _difference_blocks(
    of: Sequence[Variant], names: Sequence[str], say: Translator
) -> Iterator[Block]:
    """Yield the first inputs that differ, from variant to variant."""
    rows = input_differences(of, say)
    if not rows:
        return
    points = [(f"{row.name}: {' → '.join(row.values)}", ()) for row in rows[:MAX_OPEN_POINTS]]
    if rest := len(rows) - len(points):
        more = say.count("{count} more in the annex", "{count} more in the annex", rest)
        points.append((more, ()))
    caption = say("What differs in the input")
    yield BulletList(caption=f"{caption} ({' → '.join(names)})", points=tuple(points))


# --------------------------------------------------------------------------- drawing, open points


def _side_view(
    of: Approval, say: Translator, *, state: str | None, variant: str = ""
) -> Iterator[Block]:
    """Yield the line that decides, drawn in its worst state or in a requested state.

    Of variants side by side `variant` says which one.
    """
    rows = worst_check_per_limit(of.checks)
    names = [r.line.name for r in of.line_responses]
    line = next((c.line for c in rows if c.line in names), names[0] if names else None)
    for r in () if of.application.placeholders else of.line_responses:
        if r.line.name == line and has_known_geometry(r):
            s, at = state_to_draw(r, rows if state is None else (), state)
            figure = side_view_in_state(r, say, s, at)
            figure = replace(figure, title=_of_variant(figure.title, variant))
            yield Figures(figures=(figure,), wide=True, max_height_mm=SIDE_VIEW_HEIGHT_MM)


def _open_points(
    of: Approval,
    helps: Sequence[CheckSensitivity],
    fixes: Sequence[Correction] | None,
    say: Translator,
) -> Iterator[str]:
    """Yield what a signer has to know: what is missing, what would correct it, what is assumed."""
    required = unevaluated_limit_lines(of, say, required=True)
    yield from required
    if not of.checks:
        yield say("Nothing was held against a limit, so nothing is approved.")
    if helps:
        moves = "; ".join(single_correction_texts(of, helps, say))
        yield f"{say('Single corrections:')} {moves}"
    if fixes:
        best = fixes[0]
        standing = correction_standing_sentence(best, best.approval, say)
        moves = "; ".join(adjustment_phrase(m, say) for m in best.adjustments)
        yield say("Best combination: {moves}: {result}", moves=moves, result=standing)
    yield from points_before_signing(of, say)
    if others := len(unevaluated_limit_lines(of, say)) - len(required):
        yield say.count(
            "{count} more limit is not evaluated: see the annex",
            "{count} more limits are not evaluated: see the annex",
            others,
        )


def _of_variant(title: str, variant: str) -> str:
    return f"{variant}: {title[:1].lower()}{title[1:]}" if variant else title


def _open_point_blocks(
    points: Iterable[str], say: Translator, *, variant: str = ""
) -> Iterator[Block]:
    """Yield open points, as many as the sheet has room for; the rest counted."""
    every = list(points)
    shown = [(_cut(one), ()) for one in every[:MAX_OPEN_POINTS]]
    if rest := len(every) - len(shown):
        more = say.count("{count} more in the annex", "{count} more in the annex", rest)
        shown.append((more, ()))
    caption = _of_variant(say("Open points"), variant)
    yield BulletList(caption=caption, points=tuple(shown) or ((say("none"), ()),))


def _cut(text: str) -> str:
    if len(text) <= MAX_OPEN_POINT_CHARACTERS:
        return text
    return f"{text[:MAX_OPEN_POINT_CHARACTERS].rsplit(' ', 1)[0]} …"


# --------------------------------------------------------------------------- signatures


def signature_table(of: Application, say: Translator) -> Table:
    """Return the table to sign: who makes, checks and approves it, and the customer."""
    given = of.report
    return Table(
        caption=say("Signatures"),
        head=("", say("made by"), say("checked by"), say("approved by"), say("customer")),
        rows=(
            (say("company"), given.company, "", "", given.customer),
            (say("name"), given.author, given.checker, given.approver, ""),
            (say("date"), "", "", "", ""),
            (say("signature"), "", "", "", ""),
        ),
        words=5,
        blank=True,
    )


def revision_table(of: Application, say: Translator, issue: ReportDateAndSourceStamp) -> Table:
    """Return the revisions, the first with what the file says of it."""
    given = of.report
    change = "" if given.revision else say("first issue")
    return Table(
        caption=say("Revisions"),
        head=(say("revision"), say("date"), say("change"), say("made by"), say("checked by")),
        rows=(
            (given.revision or "0", issue.date, change, given.author, given.checker),
            *[("", "", "", "", "")] * 2,
        ),
        words=5,
        blank=True,
    )
