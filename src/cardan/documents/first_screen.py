"""First screen of `cardan check`: what decides, in at most `MAX_LINES` lines of 80 columns."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest

import numpy as np

from cardan.approval.applied_adjustments import AppliedAdjustment
from cardan.approval.approval import Approval
from cardan.approval.deciding_inputs import DecidingInput
from cardan.approval.study import DRIVELINE_STUDY_NAME
from cardan.checks.line_response import LineResponse
from cardan.core.arrays import FloatArray
from cardan.core.labels import WHOLE_LINE
from cardan.core.units import deg, rpm
from cardan.core.verdict import CHECK_GRADES, Check, CheckGrade, UnevaluatedCheck
from cardan.documents.criteria import (
    Criterion,
    CriterionKey,
    by_line,
    condition_texts,
    criteria_of,
    full_name,
    limit_qualifiers,
    names_its_part,
    short_name,
)
from cardan.render.check_texts import (
    limit_text,
    lower_bound_explanation,
    unit_text,
    value_text,
)
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import (
    adjustment_phrase,
    assumed_range_phrase,
    failure_sentences,
    limit_grouping_key,
)
from cardan.render.screen_layout import (
    capped_item_lines,
    capped_list_lines,
    more_text,
    title_lines,
)
from cardan.render.terminal import GRADE_MARKS, bold, coloured_by_grade
from cardan.render.text_layout import (
    DEFAULT_WIDTH_COLUMNS,
    NO_BREAK_SPACE,
    fold_lines,
    wrap_text,
)
from cardan.topics.design.sensitivity import CheckSensitivity

MAX_LINES = 40
"""Lines of the screen at 80 columns; the blocks below keep to it together."""

MAX_TABLE_LINES = 13
MAX_DETAIL_LINES = 4
"""Lines that gear, speed or a stuck spline of worst cases may add to the table; other points
before signing give way to them."""

MAX_ROWS_BESIDE_EXCEEDED = 6
"""Rows at most, where criteria that are not exceeded fill the table."""
MIN_ROWS = 3
MAX_LIST_LINES = 3
MAX_SIGNATURE_LINES = 9
MAX_NOT_EVALUATED_LINES = 6
MAX_CORRECTIONS = 3
MIN_NAME_COLUMNS = 24
MIN_CONDITION_COLUMNS = 16
"""Columns at least for the name of a criterion, and for where it is worst."""

_PROVENANCE_TEXTS = {
    "from memory": "unverified: {names}",
    "second hand": "quoted: {names}",
    "assumed": "assumed: {names}",
}
"""How data was read, where a reader should know before signing; all of it is in `--sources`."""


@dataclass(frozen=True, kw_only=True)
class _Screen:
    """An approval and how it is said."""

    approval: Approval
    criteria: tuple[Criterion, ...]
    unevaluated: tuple[UnevaluatedCheck, ...]
    qualifiers: Mapping[CriterionKey, str]
    say: Translator
    width: int

    @property
    def is_of_several_lines(self) -> bool:
        """Whether the application has more than one driveline."""
        return len(self.approval.line_responses) > 1

    def graded(self, grade: CheckGrade) -> list[Criterion]:
        """Return the criteria of a grade, the worst first."""
        return [c for c in self.criteria if c.grade == grade]

    def name(self, c: Check | UnevaluatedCheck) -> str:
        """Return the name of a criterion with its part."""
        return full_name(c, self.say, self.qualifiers)

    def group_name(self, c: Check | UnevaluatedCheck) -> str:
        """Return the name of a criterion without its part, for those of several parts."""
        return short_name(replace(c, part=WHOLE_LINE), self.say, self.qualifiers)

    def name_with_line(self, c: Check | UnevaluatedCheck) -> str:
        """Return the same, of which line where there are several."""
        return f"{c.line}: {self.name(c)}" if self.is_of_several_lines else self.name(c)

    def fold(self, *lines: str) -> list[str]:
        """Return lines of text, the long ones broken."""
        return list(fold_lines(lines, self.width))

    def capped(self, lead: str, items: Sequence[str], lines: int, option: str) -> list[str]:
        """Return a list after its lead in so many lines at most, the rest counted."""
        return capped_list_lines(lead, items, lines, option, self.say, self.width)


def screen_lines(
    of: Approval,
    *,
    helps: Sequence[CheckSensitivity] = (),
    say: Translator = ENGLISH,
    width: int = DEFAULT_WIDTH_COLUMNS,
) -> Iterator[str]:
    """Yield verdict, what was read, criteria, corrections, open points and next commands.

    At 80 columns at most `MAX_LINES` lines. `helps` is what single corrections do to each
    check that does not pass.
    """
    screen = _screen(of, say, width)
    required, optional = _not_evaluated_lines(screen)
    rows, rest, detailed = _chosen_criteria(screen)
    shown = (value_text(c.worst, say) for c in (*rows, *rest))
    explanation = screen.fold(*lower_bound_explanation(shown, say))
    above = [
        *title_lines(of, say, width),
        *_read_lines(screen),
        *screen.fold(_count_text(screen)),
        *required,
        *_table_lines(screen, rows, detailed),
        *_rest_lines(screen, rest),
        *explanation,
        *_correction_lines(screen, helps),
    ]
    below = [*optional, *_next_lines(screen)]
    most = MAX_SIGNATURE_LINES - len(explanation)
    room = min(MAX_LINES - len(above) - len(below) - 1, most)
    yield from above
    yield from _signature_lines(screen, rows, max(room, 1))
    yield from below


def _screen(of: Approval, say: Translator, width: int) -> _Screen:
    unevaluated = of.coverage.unevaluated
    return _Screen(
        approval=of,
        criteria=criteria_of(of.checks),
        unevaluated=unevaluated,
        qualifiers=limit_qualifiers([*of.checks, *unevaluated], of.application),
        say=say,
        width=width,
    )


def criteria_count_text(of: Approval, say: Translator) -> str:
    """Return how many criteria have each grade, and how many are not evaluated."""
    return _count_text(_screen(of, say, DEFAULT_WIDTH_COLUMNS))


def points_before_signing(of: Approval, say: Translator) -> tuple[str, ...]:
    """Return sentences for a signer, the gravest first, as the screen has them."""
    screen = _screen(of, say, DEFAULT_WIDTH_COLUMNS)
    graver, data, notes = _signature_parts(screen, screen.criteria)
    return tuple(filter(None, (*graver, data, *notes)))


def single_correction_texts(
    of: Approval, helps: Sequence[CheckSensitivity], say: Translator
) -> tuple[str, ...]:
    """Return the single corrections that improve most criteria, as the screen has them."""
    return tuple(_correction_items(_screen(of, say, DEFAULT_WIDTH_COLUMNS), helps))


def _read_lines(screen: _Screen) -> Iterator[str]:
    """Yield what was read: joints, shafts, states, gears, largest torque and speed, profile."""
    say, responses = screen.say, screen.approval.line_responses
    parts: list[str] = []
    if responses:
        joints = sum(r.line.joint_count for r in responses)
        shafts = sum(len(r.line.shafts) for r in responses)
        lines = say.count("{count} line", "{count} lines", len(responses))
        states = len(screen.approval.application.states)
        parts += [
            say.join(
                lines if screen.is_of_several_lines else "",
                say.count("{count} joint", "{count} joints", joints),
                say.count("{count} shaft", "{count} shafts", shafts),
            ),
            say.count("{count} state", "{count} states", states),
            _ways_of_driving(responses, say),
        ]
    demand = _largest_demand(responses, say).replace(" ", NO_BREAK_SPACE)
    profile = say("criteria: {profile}", profile=screen.approval.application.profile)
    read = "; ".join(filter(None, (*parts, demand, profile)))
    yield from screen.fold(say("Read: {what}", what=read))


def _ways_of_driving(responses: Sequence[LineResponse], say: Translator) -> str:
    """Return gears and directions that lines are evaluated in; "" where none is known."""
    curves = [r.operating_envelope.points.curves for r in responses if r.operating_envelope]
    ways = {way for c in curves for way in c.directions}
    gears = {
        gear
        for c in curves
        for way, gear in zip(c.directions, c.gears, strict=True)
        if way == "drive" and gear
    }
    return say.join(
        say.count("{count} gear", "{count} gears", len(gears)) if gears else "",
        say("reverse") if "reverse" in ways else "",
        say("overrun") if "coast" in ways else "",
        say("braking") if "brake" in ways else "",
    )


def _largest_demand(responses: Sequence[LineResponse], say: Translator) -> str:
    """Return the largest torque and speed that lines are evaluated at; "" where unknown."""
    if not responses:
        return ""
    demands = [r.demand for r in responses]
    demands += [r.operating_envelope.response.demand for r in responses if r.operating_envelope]

    def largest(values: Iterable[FloatArray]) -> float:
        return max(float(np.nanmax(np.abs(v), initial=0.0)) for v in values)

    torque, speed = largest(d.torque for d in demands), largest(d.speed for d in demands)
    said = say.join(
        f"{say.compact_number(float(f'{torque:.3g}'))} N·m" if torque else "",
        f"{say.compact_number(round(speed / rpm))} rpm" if speed else "",
    )
    return say("up to {demand}", demand=said) if said else ""


def criteria_grade_texts(of: Approval, say: Translator) -> dict[CheckGrade, str]:
    """Return how many criteria have each grade, the worst first."""
    return _grade_texts(_screen(of, say, DEFAULT_WIDTH_COLUMNS))


def count_criteria_not_evaluated(of: Approval) -> int:
    """Return how many criteria have no value for any part."""
    known = {c.key for c in criteria_of(of.checks)}
    return len({limit_grouping_key(u) for u in of.coverage.unevaluated} - known)


def _grade_texts(screen: _Screen) -> dict[CheckGrade, str]:
    say = screen.say
    number = {g: len(screen.graded(g)) for g in CHECK_GRADES}
    return {
        "fail": say.count("{count} exceeded", "{count} exceeded", number["fail"]),
        "warn": say.count(
            "{count} beyond recommended", "{count} beyond recommended", number["warn"]
        ),
        "pass": say.count("{count} met", "{count} met", number["pass"]),
    }


def _count_text(screen: _Screen) -> str:
    say = screen.say
    grades = say.join(*_grade_texts(screen).values())
    total = say.count("{count} criterion", "{count} criteria", len(screen.criteria))
    known = {c.key for c in screen.criteria}
    missed = {limit_grouping_key(u) for u in screen.unevaluated}
    alone, part = len(missed - known), len(missed & known)
    said = f"{total}: {grades}"
    if alone:
        text = say.count("{count} not evaluated", "{count} not evaluated", alone)
        said = f"{said}; {text}"
    if part:
        text = say.count("{count} only in part", "{count} only in part", part)
        said = f"{said}; {text}"
    return said


# --------------------------------------------------------------------------- criteria


def _chosen_criteria(
    screen: _Screen,
) -> tuple[list[Criterion], list[Criterion], frozenset[CriterionKey]]:
    """Return the criteria that have rows, and the others that are exceeded or beyond recommended.

    All exceeded ones have rows while there is room. Where they are few others follow, the
    nearest to their limits. The third result is which rows have room for gear and speed of their
    worst case, on a second line where they must: those with a stuck spline before others.
    """
    ranked = [c for grade in ("fail", "warn", "pass") for c in screen.graded(grade)]
    exceeded = len(screen.graded("fail"))
    beyond = exceeded + len(screen.graded("warn"))
    count = max(exceeded, min(beyond, MAX_ROWS_BESIDE_EXCEEDED), MIN_ROWS)

    none: frozenset[CriterionKey] = frozenset()

    def line_count(detailed: frozenset[CriterionKey]) -> int:
        return len(list(_table_lines(screen, ranked[:count], detailed)))

    while count > 1 and line_count(none) > MAX_TABLE_LINES:
        count -= 1
    points = {c.key: c.worst.point for c in ranked[:count]}
    stuck = {key for key, at in points.items() if at and at.is_spline_stuck}
    order = sorted(ranked[:count], key=lambda c: c.key not in stuck)
    sets = (frozenset(c.key for c in order[:n]) for n in range(count, 0, -1))
    most = line_count(none) + MAX_DETAIL_LINES
    detailed = next((keys for keys in sets if line_count(keys) <= most), none)
    return ranked[:count], [c for c in ranked[count:] if c.grade != "pass"], detailed


def _table_lines(
    screen: _Screen, rows: Sequence[Criterion], detailed: frozenset[CriterionKey]
) -> Iterator[str]:
    """Yield a row for each criterion: name, value, limit, where it is worst.

    Of several lines the worst line's rows stand first, each line below its name. Of rows that
    are `detailed` the worst case keeps its gear and speed, on a second line where it must.
    """
    if not rows:
        return
    say, several = screen.say, screen.is_of_several_lines
    rows = by_line(rows) if several else rows
    values = [value_text(c.worst, say) for c in rows]
    limits = [limit_text(c.worst, say) for c in rows]
    wide_value = max(map(len, [*values, say("value")]))
    wide_limit = max(map(len, [*limits, say("limit")]))
    free = screen.width - 2 - 1 - wide_value - 2 - wide_limit - 2
    rooms = range(MIN_NAME_COLUMNS, max(free - MIN_CONDITION_COLUMNS, MIN_NAME_COLUMNS) + 1)
    layouts = (
        [_row_layout(screen, c.worst, room, free - room, whole=c.key in detailed) for c in rows]
        for room in rooms
    )
    room, cells = min(zip(rooms, layouts, strict=True), key=lambda one: _cost(one[1]))
    head = f"  {say('criterion'):<{room}} {say('value'):>{wide_value}}  "
    yield bold(f"{head}{say('limit'):<{wide_limit}}  {say('worst case')}")
    line = ""
    for c, row, value, limit in zip(rows, cells, values, limits, strict=True):
        if several and c.worst.line != line:
            line = c.worst.line
            yield bold(f"  {say('line {line}', line=line)}")
        numbers = f"{value:>{wide_value}}  {limit:<{wide_limit}}"
        for k, (name, where) in enumerate(zip_longest(row.name, row.condition, fillvalue="")):
            mark = " " if k else coloured_by_grade(c.grade, GRADE_MARKS[c.grade])
            name, between = (f"  {name}" if k else name), numbers if k == 0 else " " * len(numbers)
            yield f"{mark} {name:<{room}} {between}  {where}".rstrip()


@dataclass(frozen=True, kw_only=True)
class _RowLayout:
    """Lines of the name and of the worst case of a row.

    `omitted` counts the details of the worst case that have no room.
    """

    name: list[str]
    condition: list[str]
    omitted: int


def _row_layout(screen: _Screen, c: Check, room: int, left: int, *, whole: bool) -> _RowLayout:
    """Return a row with its name in so many columns, and where it is worst in the rest.

    If it is to be `whole`, only the name of the mode is omitted for want of room.
    """
    name, conditions = screen.name(c), condition_texts(c, screen.say)
    if len(name) > room and c.part != WHOLE_LINE and not names_its_part(c.quantity):
        name = short_name(c, screen.say, screen.qualifiers)
        part = screen.say.part(c.part)
        conditions = tuple(screen.say.join(part, condition) for condition in conditions)
    fitting = [k for k, text in enumerate(conditions) if len(text) <= left]
    chosen = min(fitting, default=len(conditions) - 1)
    if whole:
        chosen = min(chosen, 1 if c.mode and c.point and not c.point.is_spline_stuck else 0)
    first, *others = wrap_text(name, room)
    return _RowLayout(
        name=[first, *wrap_text(" ".join(others), room - 2)] if others else [first],
        condition=wrap_text(conditions[chosen], left),
        omitted=chosen,
    )


def _cost(rows: Sequence[_RowLayout]) -> float:
    """Return what a layout costs: two details that are omitted weigh as much as a line."""
    return sum(max(len(r.name), len(r.condition)) + r.omitted / 2 for r in rows)


def _rest_lines(screen: _Screen, rest: Sequence[Criterion]) -> Iterator[str]:
    """Yield the criteria without a row that are exceeded or beyond recommended, by name."""
    say = screen.say
    for grade, lead in (("fail", say("Exceeded too:")), ("warn", say("Beyond recommended:"))):
        some = [c for c in rest if c.grade == grade]
        items = [
            f"{screen.name_with_line(c.worst)}: {value_text(c.worst, say)} "
            f"({limit_text(c.worst, say)})"
            for c in some
        ]
        if items:
            yield from screen.capped(lead, items, MAX_LIST_LINES, "--all")


# --------------------------------------------------------------------------- corrections


def _correction_lines(screen: _Screen, helps: Sequence[CheckSensitivity]) -> Iterator[str]:
    """Yield the single corrections that improve most criteria and spoil none."""
    if helps:
        lead, items = screen.say("Single corrections:"), _correction_items(screen, helps)
        yield from screen.capped(lead, items, MAX_LIST_LINES, "--moves")


def _correction_items(screen: _Screen, helps: Sequence[CheckSensitivity]) -> list[str]:
    say = screen.say
    worst = {(c.key, c.worst.part) for c in screen.criteria}
    failed = [one for one in helps if (limit_grouping_key(one.check), one.check.part) in worst]
    exceeded = [one for one in failed if one.check.grade == "fail"]
    about = exceeded or failed
    effects = [(one, effect) for one in about for effect in one.helpful_effects]
    improved = Counter(
        one.best_adjustment(effect)[0] for one, effect in effects if effect.side_effect is None
    )
    text = "{correction} (improves {count} of {total} exceeded)"
    text = text if exceeded else "{correction} (improves {count} of {total})"
    best = [
        (_correction_text(move, screen), n) for move, n in improved.most_common(MAX_CORRECTIONS)
    ]
    short = "{correction} ({count} of {total})"  # what is counted stands with the first
    items = [
        say(short if k else text, correction=correction, count=n, total=len(about))
        if len(about) > 1
        else correction
        for k, (correction, n) in enumerate(best)
    ]
    if not items:
        items = [
            say("none without a side effect (--moves)")
            if effects
            else say("no geometric correction; `cardan size` proposes other parts")
        ]
    return items


def _correction_text(move: AppliedAdjustment, screen: _Screen) -> str:
    """Return a correction in few words, of which line where there are several."""
    said = correction_text(move, screen.say)
    return f"{move.adjustable.line}: {said}" if screen.is_of_several_lines else said


def correction_text(move: AppliedAdjustment, say: Translator) -> str:
    """Return a correction in few words: bearing 2 up 5 mm, pinion angle +1° (shim)."""
    if move.adjustable.adjustment_key != "shim":
        return adjustment_phrase(move, say)
    amount = move.amount / deg
    sign = "+" if amount > 0 else ""
    return say("pinion angle {amount}° (shim)", amount=sign + say.compact_number(amount, 4))


# --------------------------------------------------------------------------- before signing


def _signature_lines(screen: _Screen, rows: Sequence[Criterion], room: int) -> Iterator[str]:
    """Yield what a signer should know, in at most `room` lines below a head; the rest counted.

    Verdicts that hang on an assumed input come first, then unverified data and notes. Data is
    always shown: if `MAX_SIGNATURE_LINES` end above it, there are as many more, or it moves up.
    """
    say = screen.say
    graver, data, notes = _signature_parts(screen, rows)
    if not (graver or data or notes):
        return
    yield bold(say("Before you sign"))
    own = list(fold_lines([f"  {data}"], screen.width)) if data else []

    def lines(place: int, count: int) -> list[str]:
        items = [text for text in (*graver[:place], data, *graver[place:], *notes) if text]
        return capped_item_lines(items, min(count, room), "--sources", say, screen.width)

    found, place = lines(len(graver), MAX_SIGNATURE_LINES), len(graver)
    while own and own[-1] not in found and place >= 0:
        found = lines(place, MAX_SIGNATURE_LINES + len(own))
        place -= 1
    yield from found


def _signature_parts(
    screen: _Screen, rows: Sequence[Criterion]
) -> tuple[list[str], str, list[str]]:
    """Return sentences for a signer, the gravest first: before that on data, on data, after it."""
    return list(_graver_items(screen)), _data_item(screen), list(_note_items(screen, rows))


def _graver_items(screen: _Screen) -> Iterator[str]:
    """Yield sentences for a signer that go before those on data, the gravest first."""
    say, of = screen.say, screen.approval
    warnings = of.application.warnings
    if keys := dict.fromkeys(w.key for w in warnings if w.key):
        yield say("values, given or assumed, that look wrong: {keys}", keys=", ".join(keys))
    yield from dict.fromkeys(say.error(w.message) for w in warnings if not w.key)
    for f in of.study_results:
        if f.was_run and (f.run_failed or (f.failure_reasons and not f.unevaluated)):
            yield from failure_sentences(f, say)
    yield from _assumed_input_items(screen, worse=True)
    if of.state_kinds_not_given:
        names = map(say.state, of.state_kinds_not_given)
        yield say("states not given, and not evaluated: {states}", states=", ".join(names))
    yield from _deciding_input_items(screen)
    yield from _assumed_input_items(screen, worse=False)


def _note_items(screen: _Screen, rows: Sequence[Criterion]) -> Iterator[str]:
    """Yield sentences for a signer that go after those on data, the gravest first."""
    say, of = screen.say, screen.approval
    if any(limit_text(c.worst, say).endswith("*") for c in rows):
        yield say("* limit of engineering judgement, no published limit")
    # Those that may turn a verdict first: others describe the input, or what was left out.
    graver = (
        "nothing in the file",
        "rubber is taken",
        "assumed",
        "accelerations are of",
        "clearance is",
    )
    for note in sorted(of.note_messages, key=lambda one: [g not in one.text for g in graver]):
        yield say.translate_message(note)


def _assumed_input_items(screen: _Screen, *, worse: bool) -> Iterator[str]:
    """Yield the criteria whose verdict an assumed input may turn to the worse, or to the better."""
    say = screen.say
    found: dict[str, list[str]] = {}
    for c in screen.criteria:
        check = c.deciding_check
        if check is None or check.within is None:
            continue
        place = CHECK_GRADES.index
        if worse != (place(check.worst_possible_grade) > place(c.grade)):
            continue
        low, high = (value_text(check, say, end) for end in check.within)
        interval = say("{low} to {high}", low=low, high=high)
        inputs = say.join(*(assumed_range_phrase(a, say) for a in check.assumed))
        item = f"{screen.name_with_line(check)} {interval} {unit_text(check)}".rstrip()
        found.setdefault(inputs or say("the error of the computation"), []).append(item)
    for inputs, names in found.items():
        text = (
            "{criteria}: a worse verdict is possible with {inputs}"
            if worse
            else "{criteria}: a better verdict is possible with {inputs}"
        )
        yield say(text, criteria="; ".join(names), inputs=inputs)


def _deciding_input_items(screen: _Screen) -> Iterator[str]:
    """Yield the given values by which the criterion nearest to its maximum is exceeded first."""
    say = screen.say
    if found := screen.approval.deciding_inputs:
        values = (_deciding_input_text(one, say) for one in found.inputs)
        yield say(
            "check these values: {criterion} is exceeded from about {values}",
            criterion=screen.name_with_line(found.check),
            values=", ".join(values),
        )


def _deciding_input_text(one: DecidingInput, say: Translator) -> str:
    """Return a given value and where it decides."""
    return say(
        "{key} {value} ({given} given)",
        key=one.key.removeprefix("driveline."),  # a file of one line has no other
        value=say.compact_number(one.rounded_outward),
        given=say.compact_number(one.given),
    )


def _data_item(screen: _Screen) -> str:
    """Return the catalogue data that is unverified, quoted or assumed; "" if there is none.

    Of a row whose values were read in several ways, those read worse than the row are named.
    """
    say = screen.say
    found: dict[str, dict[str, None]] = {code: {} for code in _PROVENANCE_TEXTS}
    for datum in screen.approval.catalogue_data:
        name, how_read = f"{say(datum.kind)} {datum.name}", datum.source.how_read
        if how_read in found:
            found[how_read][name] = None
        for code in ("from memory", "assumed"):
            apart = [key for key, read in datum.source.apart if read == code]
            if apart:
                found[code][f"{name} ({', '.join(apart)})"] = None
    said = [
        say(text, names=", ".join(found[code]))
        for code, text in _PROVENANCE_TEXTS.items()
        if found[code]
    ]
    return say("data {provenance}", provenance="; ".join(said)) if said else ""


# --------------------------------------------------------------------------- not evaluated


@dataclass(frozen=True, kw_only=True)
class _Missing:
    """An input that is missing, and the names of the criteria that need it."""

    input: str
    criteria: tuple[str, ...]


def _not_evaluated_lines(screen: _Screen) -> tuple[list[str], list[str]]:
    """Return what was not evaluated and the input it needs: the required criteria, and others."""
    say = screen.say
    refused = {id(u) for f in screen.approval.study_results if f.run_failed for u in f.unevaluated}
    skipped = {f.study: f.unevaluated for f in screen.approval.study_results if not f.was_run}
    of_skipped = {id(u) for some in skipped.values() for u in some}
    requested = {
        id(u)
        for f in screen.approval.study_results
        if f.was_run and f.study != DRIVELINE_STUDY_NAME
        for u in f.unevaluated
    }
    groups: dict[tuple[bool, tuple[str, ...]], dict[str, dict[str, None]]] = {}
    for u in sorted(screen.unevaluated, key=lambda u: id(u) not in requested):
        if id(u) not in refused | of_skipped:
            lines = groups.setdefault((u.limit.required, u.missing_inputs), {})
            lines.setdefault(screen.group_name(u), {})[u.line] = None
    required, optional = (
        [
            _not_evaluated(screen, needs, names)
            for (must, needs), names in groups.items()
            if must == wanted
        ]
        for wanted in (True, False)
    )
    optional += [_study_not_run(screen, study, some) for study, some in skipped.items()]
    return (
        _as_many_as_fit(screen, required, say("Required, not evaluated")),
        _as_many_as_fit(screen, optional, say("Not evaluated")),
    )


def _not_evaluated(
    screen: _Screen, needs: Sequence[str], criteria: Mapping[str, Iterable[str]]
) -> _Missing:
    """Return which input is missing, and the criteria that need it, with their lines."""
    say, every = screen.say, {r.line.name for r in screen.approval.line_responses}
    missing = "; ".join(say.translate_if_known(n) for n in needs)
    return _Missing(
        input=say("(input missing: {inputs})", inputs=missing)
        if missing
        else say("(no value can be computed)"),
        criteria=tuple(
            name if set(lines) == every else f"{name} ({', '.join(lines)})"
            for name, lines in criteria.items()
        ),
    )


def _study_not_run(
    screen: _Screen, study: str, unevaluated: Sequence[UnevaluatedCheck]
) -> _Missing:
    """Return a study that was not run, and the option that runs it."""
    say = screen.say
    count = len({limit_grouping_key(u) for u in unevaluated})
    criteria = say.count("{count} criterion", "{count} criteria", count)
    said = say.join(say(study), criteria if count else "")
    return _Missing(input=f"(--with {study})", criteria=(said,))


def _as_many_as_fit(screen: _Screen, items: Sequence[_Missing], lead: str) -> list[str]:
    """Return lines of what was not evaluated, the rest counted."""
    found: list[str] = []
    for k, one in enumerate(items):
        lines = screen.capped(f"{lead} {one.input}:", one.criteria, MAX_LIST_LINES, "--all")
        last = k == len(items) - 1
        if found and len(found) + len(lines) > MAX_NOT_EVALUATED_LINES - (not last):
            return [*found, f"{lead}: {more_text(len(items) - k, '--all', screen.say)}"]
        found += lines
    return found


# --------------------------------------------------------------------------- next


def _next_lines(screen: _Screen) -> Iterator[str]:
    """Yield the commands that follow."""
    say, fix = screen.say, "" if screen.approval.verdict == "pass" else "cardan fix FILE | "
    why = f'--why "{screen.name(screen.criteria[0].worst)}" | ' if screen.criteria else ""
    options = "--moves | --states | --sources | --all | --pdf OUT"
    yield from screen.fold(f"{say('Next:')} {fix}cardan check FILE {why}{options}")
