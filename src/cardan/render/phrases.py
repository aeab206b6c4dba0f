"""How checks, moves and effects are put into words, the same in every medium."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from math import isinf, pi
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from cardan.application.limit_profiles import INLINE_LIMITS_NAME
from cardan.application.quantity_lookup import declared_quantity
from cardan.approval.study import StudyResult
from cardan.core.errors import FileIssue, InvalidFileError, OptionError
from cardan.core.labels import WHOLE_LINE
from cardan.core.provenance import Source, provenance_text
from cardan.core.units import rpm
from cardan.core.verdict import (
    GRADE_TEXTS,
    VERDICTS,
    AssumedRange,
    Check,
    CheckGrade,
    Limit,
    UnevaluatedCheck,
    Verdict,
    worst_first_key,
)
from cardan.core.version import __version__
from cardan.model.adjustments import ADJUSTMENTS
from cardan.model.application import PermittedAdjustment
from cardan.render.blocks import ReportDateAndSourceStamp
from cardan.render.check_texts import lower_bound_mark
from cardan.render.i18n import Translator

if TYPE_CHECKING:  # a recording does not wait for the physics of a driveline
    from cardan.approval.applied_adjustments import AppliedAdjustment
    from cardan.approval.approval import Approval


class CurvesOverSpeed(Protocol):
    """Curves over speed, each of a direction of drive and a gear."""

    @property
    def directions(self) -> Sequence[str]:
        """Direction of each curve: drive, reverse, brake."""
        ...

    @property
    def gears(self) -> Sequence[str]:
        """Gear of each curve; empty where the vehicle has one."""
        ...


def grade_text(grade: Verdict, say: Translator) -> str:
    """Return what a grade of a criterion is called: exceeded, beyond recommended, met."""
    return say(GRADE_TEXTS[grade])


def approval_counts_text(of: "Approval", say: Translator) -> str:
    """Return how many checks have each grade, the worst first, and how many are not evaluated."""
    return check_counts_text(of.checks, say, of.coverage.unevaluated)


def check_grade_count_texts(checks: Iterable[Check], say: Translator) -> dict[CheckGrade, str]:
    """Return how many checks have each grade in words, the worst first."""
    grades = [c.grade for c in checks]
    return {
        "fail": say.count("{count} exceeded", "{count} exceeded", grades.count("fail")),
        "warn": say.count(
            "{count} beyond recommended", "{count} beyond recommended", grades.count("warn")
        ),
        "pass": say.count("{count} met", "{count} met", grades.count("pass")),
    }


def check_counts_text(
    checks: Iterable[Check], say: Translator, missed: Sequence[UnevaluatedCheck] = ()
) -> str:
    """Return how many checks have each grade, the worst first, and how many are not evaluated."""
    said = list(check_grade_count_texts(checks, say).values())
    if missed:
        said.append(say.count("{count} not evaluated", "{count} not evaluated", len(missed)))
    return ", ".join(said)


def worst_check_per_limit(checks: Iterable[Check]) -> list[Check]:
    """Return the worst check of each limit, those that do not pass first.

    And that which its error may make worse than the error of the worst does it, if one may.
    """
    every = list(checks)
    worst, doubted = (
        _first_check_per_limit(sorted(every, key=key))
        for key in (_nominal_severity, worst_first_key)
    )
    also = (c for k, c in doubted.items() if worst_first_key(c)[:2] < worst_first_key(worst[k])[:2])
    return sorted([*worst.values(), *also], key=worst_first_key)


def _first_check_per_limit(checks: Iterable[Check]) -> dict[tuple[str, str, Limit], Check]:
    """Return the first check of each limit."""
    found: dict[tuple[str, str, Limit], Check] = {}
    for c in checks:
        found.setdefault(limit_grouping_key(c), c)
    return found


def limit_grouping_key(c: Check | UnevaluatedCheck) -> tuple[str, str, Limit]:
    """Return what checks of one limit have in common."""
    return c.quantity, c.line, c.limit


def _nominal_severity(c: Check) -> tuple[int, float]:
    """Return what checks are sorted by if the effect of their error is not needed."""
    grade, _, margin = worst_first_key(c)
    return grade, margin


_ASSESSMENT_INTERVAL_TEXTS = (
    "between {low} and {high} {unit} by what elements, flange and gauges leave open",
    "between {low} and {high} by what elements, flange and gauges leave open",
)
_INTERVAL_TEXTS_BY_PART = {
    "gauge": (
        "between {low} and {high} {unit} by what was not recorded",
        "between {low} and {high} by what was not recorded",
    ),
    "mode": (
        "between {low} and {high} {unit} by the estimated error of the elements",
        "between {low} and {high} by the estimated error of the elements",
    ),
}


_ASSUMED_INTERVAL_TEXTS = (
    "between {low} and {high} {unit} with {inputs}",
    "between {low} and {high} with {inputs}",
)
_POSSIBLE_GRADE_TEXTS = {
    "pass": "by that it may be met",
    "warn": "by that it may be beyond recommended",
    "fail": "by that it may be exceeded",
}


def assumed_range_phrase(of: AssumedRange, say: Translator) -> str:
    """Return an input with its range: tyre.friction 0.667 to 0.96 (assumed)."""
    low, high = (say.compact_number(end, 3) for end in (of.low, of.high))
    ends = say("{low} to {high}", low=low, high=high)
    if of.is_given:
        return f"{say.translate_if_known(of.name)} {ends} {of.unit}".rstrip()
    return say(
        "{name} {range} (assumed)", name=say.translate_if_known(of.name),
        range=f"{ends} {of.unit}".rstrip(),
    )  # fmt: skip


def check_location(c: Check | UnevaluatedCheck, say: Translator, *, several: bool = False) -> str:
    """Return where a check is: state, torque, mode, part and, with several lines, which line."""
    told = [check_state_phrase(c, say)]
    # The engine's torque, where that applies, is not what the tyres leave of it.
    slips = declared_quantity(c.quantity).uses_engine_torque
    if isinstance(c, Check) and c.point and not (slips and c.point.direction == "drive"):
        told.append(f"{say.compact_number(c.point.torque, 4)} N·m")
    if isinstance(c, Check) and c.point and c.point.is_spline_stuck:
        told.append(say("spline stuck"))
    if isinstance(c, Check) and c.mode:
        told.append(say(
            "order {order} in resonance with the {mode} mode, {frequency} Hz", order=c.mode.order,
            mode=say(c.mode.shape), frequency=say.compact_number(c.mode.frequency / (2 * pi), 3),
        ))  # fmt: skip
    if isinstance(c, Check) and c.within:
        quantity = declared_quantity(c.quantity)
        low, high = (
            "∞" if isinf(end) else say.compact_number(end / quantity.si_factor, 4)
            for end in c.within
        )
        with_unit, alone = (
            _ASSUMED_INTERVAL_TEXTS
            if c.assumed
            else _INTERVAL_TEXTS_BY_PART.get(c.part.kind, _ASSESSMENT_INTERVAL_TEXTS)
        )
        means = with_unit if quantity.unit_symbol else alone
        inputs = say.join(*(assumed_range_phrase(a, say) for a in c.assumed))
        told.append(say(means, low=low, high=high, unit=quantity.unit_symbol, inputs=inputs))
        if c.worst_possible_grade != c.grade:
            told.append(say(_POSSIBLE_GRADE_TEXTS[c.worst_possible_grade]))
        elif c.assumed and c.best_possible_grade != c.grade:
            told.append(say(_POSSIBLE_GRADE_TEXTS[c.best_possible_grade]))
        if c.deciding_inputs:
            told.append(say("`{key}` has one answer for the two", key="; ".join(c.deciding_inputs)))
    where = say.join(*told) if c.part == WHOLE_LINE else say.join(*told, say.part(c.part))
    return f"{c.line}: {where}" if several else where


def check_state_phrase(c: Check | UnevaluatedCheck, say: Translator) -> str:
    """Return where a check was evaluated: the state, and where in it a worst point was found."""
    at = c.point if isinstance(c, Check) else None
    if at is None:
        return say.occasion(c.when)
    moving = {
        "drive": "gear {gear} at {speed} rpm" if at.gear else "drive at {speed} rpm",
        "coast": "overrun in gear {gear} at {speed} rpm" if at.gear else "overrun at {speed} rpm",
        "reverse": "reverse at {speed} rpm",
        "brake": "braking in gear {gear} at {speed} rpm" if at.gear else "braking at {speed} rpm",
    }
    still = {
        "drive": "pulling away in gear {gear}" if at.gear else "pulling away",
        "coast": "overrun to a stop in gear {gear}" if at.gear else "overrun to a stop",
        "reverse": "pulling away in reverse",
        "brake": "braking to a stop in gear {gear}" if at.gear else "braking to a stop",
    }
    means = (moving if at.speed else still)[at.direction]
    said = say(means, gear=at.gear, speed=say.compact_number(round(at.speed / rpm), 6))
    return say.join(say.occasion(c.when), said)


def torque_curve_name(of: CurvesOverSpeed, k: int, say: Translator) -> str:
    """Return the name of a curve of torque over speed: reverse, gear 3, braking, gear 3."""
    way, gear = of.directions[k], of.gears[k]
    if way == "reverse":
        return say("reverse")
    geared = say("gear {gear}", gear=gear) if gear else ""
    if way == "brake":
        return say.join(*filter(None, (say("braking"), geared)))
    return geared or say("drive")


def limit_sense_symbol(c: Check, say: Translator) -> str:
    """Return how a value stands to its limit."""
    return say("outside") if c.limit.band else {"<=": "≤", ">=": "≥"}[c.limit.sense]


def value_and_bound(c: Check, say: Translator) -> tuple[str, str]:
    """Return value and bound of a check, in as many figures as distinguish unequal values.

    The value after ≥ where it is a lower bound, ≤ of what is the safer the larger.
    """
    factor, sign = declared_quantity(c.quantity).si_factor, lower_bound_mark(c)
    for figures in range(4, 10):
        value, bound = (say.number(v / factor, figures) for v in (c.value, c.bound))
        if value != bound:
            return sign + value, bound
    return sign + say.number(c.value / factor), say.number(c.bound / factor)


def check_sentence(c: Check, say: Translator) -> str:
    """Return a check as a sentence: what, where, how much, against what."""
    q, name = declared_quantity(c.quantity), say.name(c.quantity)
    value, bound = value_and_bound(c, say)
    return say(
        "{what} in {state}: {value} against {limit} {unit}",
        what=name if c.part == WHOLE_LINE else f"{name}, {say.part(c.part)}",
        state=check_state_phrase(c, say),
        value=value,
        limit=bound,
        unit=q.unit_symbol,
    ).rstrip()


def adjustment_phrase(m: "AppliedAdjustment", say: Translator) -> str:
    """Return a move in a workshop's words."""
    movable, part, amount = ADJUSTMENTS[m.adjustable.adjustment_key], m.adjustable.part, m.amount
    shown = amount / movable.unit_value
    said = say.compact_number(shown if movable.shows_sign else abs(shown), 4)
    sign = "+" if movable.shows_sign and amount > 0 else ""
    return say(
        movable.increase_text if amount > 0 else movable.decrease_text,
        part=part,
        amount=sign + said,
    )


def adjustable_parameter_phrase(a: PermittedAdjustment, say: Translator) -> str:
    """Return what may be moved, in few words."""
    return say(ADJUSTMENTS[a.adjustment_key].label, part=a.part)


VERDICT_TEXTS: dict[Verdict, str] = {
    "pass": "approved",
    "warn": "approved with warnings",
    "incomplete": "incomplete",
    "fail": "not approved",
}
"""What a verdict means to a signer; a single check has its own words, `GRADE_TEXTS`."""

_NOT_EVALUATED_TEXTS: dict[tuple[str, ...], str] = {
    ("speed",): "speed not evaluated",
    ("strength",): "strength not evaluated",
    ("speed", "strength"): "speed and strength not evaluated",
}
_APPROVED_TEXTS = {
    ("pass", "angles"): "angles approved",
    ("warn", "angles"): "angles approved with warnings",
    ("pass", "all"): "approved",
    ("warn", "all"): "approved with warnings",
    ("pass", "own limits"): "approved by the file's own limits",
    ("warn", "own limits"): "approved by the file's own limits with warnings",
}
"""By verdict and what is evaluated."""


def verdict_word(verdict: Verdict, say: Translator) -> str:
    """Return a verdict in capitals: NOT APPROVED."""
    return say(VERDICT_TEXTS[verdict]).upper()


def verdict_text(of: "Approval", say: Translator, verdict: Verdict | None = None) -> str:
    """Return the verdict as a headline; an approval says in it what it is not of.

    "angles approved; speed and strength not evaluated" is never shortened to APPROVED. Another
    `verdict` than the approval's own is what a live workbook may come to.
    """
    verdict = verdict or of.verdict
    if not is_partial_approval(of) or verdict not in ("pass", "warn"):
        return verdict_word(verdict, say)
    angles_alone = bool({"speed", "strength"} & set(of.not_evaluated))
    scope = "angles" if angles_alone else "all"
    if of.application.profile.startswith(INLINE_LIMITS_NAME):
        scope = "own limits"
    return "; ".join(map(say, (_APPROVED_TEXTS[verdict, scope], *_not_evaluated(of))))


def is_partial_approval(of: "Approval") -> bool:
    """Return whether the headline says what is not evaluated, also of a file's own limits."""
    return bool(of.not_evaluated)


def _not_evaluated(of: "Approval") -> list[str]:
    """Return what an approval is not of, in English."""
    missing = tuple(s for s in of.not_evaluated if s in ("speed", "strength"))
    told = [_NOT_EVALUATED_TEXTS[missing]] if missing else []
    if len(missing) < len(of.not_evaluated):
        told.append("centre bearings taken as rigid, without rubber")
    return told


def verdict_texts(of: "Approval", say: Translator) -> dict[Verdict, str]:
    """Return the headline of each verdict that an approval may come to."""
    return {verdict: verdict_text(of, say, verdict) for verdict in VERDICTS}


def short_verdict_text(of: "Approval", say: Translator) -> str:
    """Return the verdict for a narrow column: marked where it is not of everything."""
    said = verdict_word(of.verdict, say)
    return f"{said} *" if is_partial_approval(of) and of.verdict in ("pass", "warn") else said


def placeholder_sentence(of: "Approval", say: Translator) -> str:
    """Return why a file with placeholders has no numbers of its lines."""
    return say(
        "Results by state: not evaluated; these keys hold placeholders: {names}",
        names=", ".join(of.application.placeholders),
    )


def not_given_sentence(of: "Approval", say: Translator) -> str:
    """Return which kinds of state the profile expects and the file lacks; "" if none."""
    if not of.state_kinds_not_given:
        return ""
    return say(
        "States not given, and not evaluated: {states}",
        states=", ".join(say.state(kind) for kind in of.state_kinds_not_given),
    )


def unevaluated_limit_lines(
    of: "Approval", say: Translator, *, required: bool = False
) -> list[str]:
    """Return limits not evaluated, with the missing input of each; the `required` first, or alone.

    Studies that were not requested are reported by `notes`.
    """
    missed = [u for f in of.study_results if f.was_run for u in f.unevaluated]
    missed = [u for u in missed if u.limit.required] if required else missed
    return grouped_unevaluated_lines(missed, say, several=len(of.line_responses) > 1)


def grouped_unevaluated_lines(
    missed: Iterable[UnevaluatedCheck], say: Translator, *, several: bool = False
) -> list[str]:
    """Return limits not evaluated, with the missing input of each; the required ones first."""
    found: dict[tuple[bool, str, tuple[str, ...]], list[UnevaluatedCheck]] = {}
    for u in sorted(missed, key=lambda u: not u.limit.required):
        found.setdefault((u.limit.required, u.quantity, u.missing_inputs), []).append(u)
    return [
        _unevaluated_line(same, say, required=required, several=several)
        for (required, _, _), same in found.items()
    ]


def _unevaluated_line(
    same: list[UnevaluatedCheck], say: Translator, *, required: bool, several: bool
) -> str:
    """Return limits of one quantity that miss the same, where they are a few with their places."""
    first = same[0]
    needs = "; ".join(say.translate_if_known(n) for n in first.missing_inputs) or say(
        "a number that could not be computed"
    )
    parts = dict.fromkeys(
        say.join(u.line if several else "", "" if u.part == WHOLE_LINE else say.part(u.part))
        for u in same
    )
    name = say.join(say.name(first.quantity), *(parts if len(parts) <= 3 else ()))
    if required:
        return say("{name}: required, input missing: {needs}", name=name, needs=needs)
    return say("{name}: input missing: {needs}", name=name, needs=needs)


def doubtful_value_count_text(of: "Approval", say: Translator) -> str:
    """Return how many values look wrong, which a verdict may hang on; "" if none."""
    if not (keys := {w.key for w in of.application.warnings if w.key}):
        return ""
    return say.count("{count} value looks wrong", "{count} values look wrong", len(keys))


def failure_sentences(found: StudyResult[Any], say: Translator) -> list[str]:
    """Return why a study has no result."""
    return [
        say("{study} could not be evaluated: {why}.", study=say(found.study), why=why.rstrip("."))
        for why in found.failure_reasons
    ]


def note_sentences(of: "Approval", say: Translator) -> list[str]:
    """Return what a reader should know: studies not run, what contradicts itself."""
    found: list[str] = []
    if lacking := not_given_sentence(of, say):
        found.append(f"{lacking}.")
    if of.studies_not_run:
        names = ", ".join(say(name) for name in of.studies_not_run)
        options = " ".join(f"--with {name}" for name in of.studies_not_run)
        found.append(say("Not part of this verdict: {names} ({options}).", names=names,
                         options=options))  # fmt: skip
    for f in of.study_results:
        if f.was_run:
            found += failure_sentences(f, say)
    found += [say("Note: {note}.", note=say.translate_message(one)) for one in of.note_messages]
    return found


def file_problem_line(
    of: FileIssue, file: str, say: Translator, *, is_warning: bool = False
) -> str:
    """Return what is wrong in a file as one line, in the language."""
    message = say.error(of.message)
    if is_warning:  # of an error numbers stand as the file has to write them
        message = say.localise_numbers(message)
    told = replace(of, message=message, hint=say.error(of.hint))
    if of.value:
        told = replace(told, message=f"{told.message} ({say.error(f'got {of.value}')})", value="")
    if of.against:
        others = ", ".join(
            say("{value} (line {line})", value=f"{at.key} {value}".rstrip(), line=str(at.line))
            for at, value in of.against
        )
        compared = say("compared with {others}", others=others)
        told = replace(told, message=f"{told.message}; {compared}", against=())
    return told.format_with_location(file)


def file_warning_lines(of: "Approval", say: Translator) -> list[str]:
    """Return what looked wrong while an application was read, each with its line and key."""
    written = of.application.written
    name = Path(written.name).name if written else of.application.title
    return [
        file_problem_line(warning, name, say, is_warning=True)
        for warning in of.application.warnings
    ]


def error_text(error: Exception, say: Translator) -> str:
    """Return why something was refused, in the language; a bad file problem by problem."""
    if isinstance(error, InvalidFileError):
        return "\n".join(file_problem_line(p, error.file, say) for p in error.problems)
    if isinstance(error, OptionError):
        return f"{error.file}: {error.worded(error_text(error.why, say))}"
    return say.error(str(error))


def citation(source: Source, say: Translator) -> str:
    """Return a source and how it was read, in the language where it is no publication."""
    said = say.source(f"{source.title}, {source.place}" if source.place else source.title)
    read = source_digitisation_phrase(source, say)
    return f"{said} ({read})" if read else said


def source_digitisation_phrase(source: Source, say: Translator) -> str:
    """Return how the values of a source were read, those that differ behind; empty if not given.

    Values are called what files call them.
    """
    if not source.how_read:
        return ""
    words = dict.fromkeys(word for _, word in source.apart)
    differ = (
        f"{', '.join(name for name, w in source.apart if w == word)}: {say(provenance_text(word))}"
        for word in words
    )
    return "; ".join((say(provenance_text(source.how_read)), *differ))


def source_date_and_version_facts(
    issue: ReportDateAndSourceStamp, say: Translator
) -> Iterator[tuple[str, str]]:
    """Yield what distinguishes this report from another."""
    for file, print_ in zip(issue.file_names, issue.fingerprints, strict=True):
        yield say("File"), f"{file} (SHA-256 {print_})"
    if issue.date:
        yield say("Date"), issue.date
    yield say("Made with"), f"cardan {__version__}"
