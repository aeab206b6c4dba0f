"""What a terminal shows: the first screen, each check, single corrections, numbers by state.

Text is marked with colours; the printer takes them out where there is no terminal.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import zip_longest
from typing import TYPE_CHECKING

from cardan.approval.approval import Approval
from cardan.approval.registry import study_registrations
from cardan.approval.study import load_function
from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.declaration import Quantity
from cardan.core.verdict import VERDICTS, Check, UnevaluatedCheck, Verdict
from cardan.documents.criteria import criteria_of, full_name, limit_qualifiers
from cardan.documents.first_screen import screen_lines
from cardan.render.check_texts import limit_text, lower_bound_explanation, value_text
from cardan.render.i18n import ENGLISH, LANGUAGE_CODES, Translator
from cardan.render.phrases import (
    VERDICT_TEXTS,
    citation,
    doubtful_value_count_text,
    is_partial_approval,
    note_sentences,
    placeholder_sentence,
    short_verdict_text,
    unevaluated_limit_lines,
    verdict_text,
)
from cardan.render.state_table import driveline_title, state_table_sections
from cardan.render.terminal import (
    bold,
    check_lines,
    coloured_by_grade,
    provenance_lines,
    report_table_lines,
    unevaluated_lines,
    verdict_lines,
)
from cardan.render.text_layout import (
    DEFAULT_WIDTH_COLUMNS,
    column_heading_lines,
    display_width,
    fold_lines,
    wrap_text,
)
from cardan.topics.design import phasing_table as phased
from cardan.topics.design.presentation import adjustment_effect_lines
from cardan.topics.design.sensitivity import CheckSensitivity

if TYPE_CHECKING:  # one check of one design is not to wait for these
    from cardan.documents.comparison import Variant
    from cardan.topics.design.presentation import RemedyByCheck

MAX_LETTERS_OF_WORD_WIDENING_COLUMN = 14
"""Letters of a word over a column, at most, for whose sake it is wider than its numbers."""


def approval_lines(
    of: Approval,
    *,
    helps: Iterable[CheckSensitivity],
    sizes: "RemedyByCheck | None" = None,
    every: bool = False,
    states: bool = False,
    phasings: bool = False,
    moves: bool = False,
    sources: bool = False,
    say: Translator = ENGLISH,
    width: int = DEFAULT_WIDTH_COLUMNS,
) -> Iterator[str]:
    """Yield the first screen of an approval, and below it the blocks that options request.

    `states` adds the numbers of every state, `moves` all single corrections, `sources` limits
    and data with their sources and all notes, `phasings` the yokes in every way. With `every`
    each check has its row in place of the screen, and all blocks follow. `sizes` are other
    parts, for what no correction improves.
    """
    helps, several = tuple(helps), len(of.line_responses) > 1
    if every:
        yield from verdict_lines(of, say, every=True, width=width)
    else:
        yield from screen_lines(of, helps=helps, say=say, width=width)
    if every or moves:
        yield from fold_lines(
            adjustment_effect_lines(helps, sizes or {}, say, several=several), width
        )
    for found in of.study_results:
        lines = study_registrations()[found.study].text_lines
        if lines and found.answer is not None:
            yield from load_function(lines)(found, say)
    if sources and not every:
        yield from _source_lines(of, say, width)
    if of.application.placeholders:
        if phasings or states or every:
            yield ""
            yield from fold_lines([placeholder_sentence(of, say)], width)
        return
    if every or phasings:
        for response in of.line_responses:
            yield from _yoke_phasing_lines(response, say, width, several=several)
    if every or states:
        for response in of.line_responses:
            yield from _line_state_lines(response, say, width)


def _source_lines(of: Approval, say: Translator, width: int) -> Iterator[str]:
    """Yield what a verdict stands on: each limit with its source, data, notes."""
    yield from check_lines(of, say, width=width)
    yield from fold_lines(
        unevaluated_lines(unevaluated_limit_lines(of, say), of.coverage, say), width
    )
    yield from provenance_lines(of, say, width)
    if notes := note_sentences(of, say):
        yield ""
        yield from fold_lines(notes, width)


def file_lines(of: "Sequence[Variant]", say: Translator = ENGLISH) -> Iterator[str]:
    """Yield verdict and worst criterion of each file, the count of verdicts, next commands."""
    wide = max(display_width(v.name) for v in of)
    for v in of:
        approval = v.approval
        partial = is_partial_approval(approval) and approval.verdict == "pass"
        verdict = coloured_by_grade(
            "warn" if partial else approval.verdict, verdict_text(approval, say)
        )
        told = filter(
            None, (_worst_criterion_text(approval, say), doubtful_value_count_text(approval, say))
        )
        room = " " * (wide - display_width(v.name))
        yield f"{v.name}{room}  {verdict}: {'; '.join(told)}"
    counts = Counter(v.approval.verdict for v in of)
    found = ", ".join(f"{counts[v]} {say(VERDICT_TEXTS[v])}" for v in VERDICTS if counts[v])
    yield say.count(
        "{count} file: {verdicts}", "{count} files: {verdicts}", len(of), verdicts=found
    )
    yield f"{say('Next:')} cardan check FILE | cardan check FILE FILE --all | --pdf OUT"


def _worst_criterion_text(of: Approval, say: Translator) -> str:
    """Return what decides a verdict: the worst criterion, or a required one not evaluated."""
    unevaluated = of.coverage.unevaluated
    qualifiers = limit_qualifiers([*of.checks, *unevaluated], of.application)
    several = len(of.line_responses) > 1

    def name(c: Check | UnevaluatedCheck) -> str:
        named = full_name(c, say, qualifiers)
        return f"{c.line}: {named}" if several else named

    missing = next((u for u in unevaluated if u.limit.required), None)
    if of.verdict == "incomplete" and missing is not None:
        return say("{name} not evaluated", name=name(missing))
    criteria = criteria_of(of.checks)
    if not criteria:
        return say("nothing was evaluated")
    worst = criteria[0].worst
    return f"{name(worst)} {value_text(worst, say)} ({limit_text(worst, say)})"


def comparison_lines(
    of: "Sequence[Variant]", say: Translator = ENGLISH, *, width: int = DEFAULT_WIDTH_COLUMNS
) -> Iterator[str]:
    """Yield variants side by side: verdicts, what differs in the input, each limit."""
    from cardan.documents.comparison import input_differences, limit_differences

    wide = 20
    most = max(1, (width - 2 - 24) // wide)
    room = max(width - 2 - wide * min(len(of), most), 24)
    changes, results = input_differences(of, say), limit_differences(of, say)

    def row(
        name: str, values: Sequence[str], grades: Sequence[Verdict | None], mark: str = " "
    ) -> Iterator[str]:
        cells = [wrap_text(v, wide - 1) for v in values]
        for k, (title, *line) in enumerate(zip_longest(wrap_text(name, room - 1), *cells)):
            shown = (
                coloured_by_grade(g, text) if g else text
                for g, text in zip(grades, (f"{t or '':>{wide}}" for t in line), strict=True)
            )
            yield f"{mark if k == 0 else ' '} {title or '':<{room}}{''.join(shown)}".rstrip()

    for start in range(0, len(of), most):
        some = slice(start, start + most)
        none = (None,) * len(of[some])
        yield bold(say("Variants side by side"))
        names = [f"{k}. {v.name}" for k, v in enumerate(of, 1)][some]
        yield from (f"  {'':{room}}{line}" for line in column_heading_lines(names, wide))
        found: list[Verdict] = [v.approval.verdict for v in of[some]]
        yield from row(
            say("verdict"), [short_verdict_text(v.approval, say) for v in of[some]], found
        )
        yield ""
        yield bold(say("What differs in the input"))
        for one in changes:
            yield from row(one.name, one.values[some], none)
        if not changes:
            yield "  " + say("nothing")
        yield ""
        yield bold(say("What it does to each limit, where it is worst"))
        for one in results:
            mark = "*" if one.grades_differ else " "
            yield from row(one.name, one.values[some], one.grades[some], mark)
        yield say("* the verdict differs")
        yield from fold_lines(
            lower_bound_explanation((v for one in results for v in one.values[some]), say), width
        )
        for k, v in enumerate(of[some], start + 1):
            if is_partial_approval(v.approval):
                yield f"* {k}. {verdict_text(v.approval, say)}"
            if doubt := doubtful_value_count_text(v.approval, say):
                yield f"* {k}. {doubt}"
        if start + most < len(of):
            yield ""


def quantity_explanation_lines(q: Quantity, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield what a quantity is: equation, symbols, source, limits of use."""
    yield f"{bold(say.name(q.key))}  {q.symbol}" + (f" [{q.unit_symbol}]" if q.unit_symbol else "")
    yield f"    {say.translate_if_known(q.equation_text)}"
    yield from (
        f"      {symbol}: {say.translate_if_known(meaning)}"
        for symbol, meaning in q.symbol_meanings.items()
    )
    if q.validity:
        yield f"  {say('Limits of use')}: {say.translate_if_known(q.validity)}"
    yield f"  {say('Source')}: {citation(q.source, say)}"
    yield from _limits_on(q, say)
    others = "; ".join(f"{c}: {Translator(c).name(q.key)}" for c in LANGUAGE_CODES if c != "en")
    yield f"  {say('Key')}: {q.key}; {others}"


def _limits_on(q: Quantity, say: Translator) -> Iterator[str]:
    """Yield what the default profile requires of a quantity, its source and how that was read."""
    from cardan.application.limit_profiles import DEFAULT_PROFILE_NAME, load_profile

    for limit in load_profile(DEFAULT_PROFILE_NAME)[1]:
        if limit.quantity != q.key:
            continue
        low, high = limit.band or (None, None)
        bounds = (("normal", limit.normal), ("maximum", limit.maximum))
        said = [
            f"{say(name)} {limit.sense} {say.number(bound / q.si_factor)}"
            for name, bound in bounds
            if bound is not None
        ]
        if low is not None and high is not None:
            edges = (say.number(edge / q.si_factor) for edge in (low, high))
            said.append(f"{say('outside')} {' … '.join(edges)}")
        asks = " ".join((", ".join(said), q.unit_symbol)).rstrip()
        yield f"  {say('Limits')} ({DEFAULT_PROFILE_NAME}): {asks}"
        yield f"      {citation(limit.source, say)}"


def _yoke_phasing_lines(
    r: LineResponse, say: Translator, width: int, *, several: bool
) -> Iterator[str]:
    """Yield a line with its yokes in every way."""
    for one in phased.yoke_phasing_table(r, say):
        caption = f"{r.line.name}: {one.caption}" if several else one.caption
        yield from report_table_lines(replace(one, caption=caption), width)


def _line_state_lines(r: LineResponse, say: Translator, width: int) -> Iterator[str]:
    """Yield the numbers of one line, rows over states, as many states next to each other as fit."""
    yield ""
    yield bold(driveline_title(r, say))
    for section in state_table_sections(r):
        labels = [row.label(say) for row in section.rows]
        unit = 2 + max(len(row.unit) for row in section.rows)
        room = min(max(map(len, labels)) + 3, max(32, width * 3 // 8))
        cells = [row.value_texts(say) for row in section.rows]
        states = [say.state(s) for s in r.demand.states]
        words = [
            1 + min(len(word), MAX_LETTERS_OF_WORD_WIDENING_COLUMN)
            for name in states
            for word in name.split()
        ]
        column = max(9, *words, *(2 + len(cell) for row in cells for cell in row))
        most = max(1, (width - room - unit) // column)
        for start in range(0, len(states), most):
            some = slice(start, start + most)
            yield ""
            head = column_heading_lines(states[some], column)
            title = wrap_text(say(section.title), room + unit - 1)
            names = [""] * (len(head) - len(title)) + title
            heads = [""] * (len(title) - len(head)) + head
            for name, over in zip(names, heads, strict=True):
                yield bold(f"{name:<{room + unit}}{over}".rstrip())
            for row, label, values in zip(section.rows, labels, cells, strict=True):
                numbers = f"{row.unit:<{unit}}" + "".join(f"{v:>{column}}" for v in values[some])
                yield from _hanging_row(label, numbers, room)


def _hanging_row(label: str, numbers: str, room: int) -> Iterator[str]:
    """Yield a row of numbers; of a long name the last line stands next to them."""
    indent = len(label) - len(label.lstrip())
    first, *others = wrap_text(label.strip(), room - 3 - indent)
    *above, last = [" " * indent + first, *(" " * (indent + 2) + line for line in others)]
    yield from above
    yield f"{last:<{room}}{numbers}".rstrip()
