"""What a study of variants came to: in words, in tables, in figures."""

from collections.abc import Iterator
from math import isfinite

import numpy as np

from cardan.application.variant_sampling import SampledVariable
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.verdict import CHECK_GRADES, VERDICTS, Limit
from cardan.render.blocks import Table
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import VERDICT_TEXTS, grade_text
from cardan.render.screen_layout import percent_text
from cardan.render.terminal import report_table_lines
from cardan.topics.variants.evaluation import UNEVALUATED_GRADE_CODE
from cardan.topics.variants.rare_failure import MAX_FAILURE_DISTANCE_SD
from cardan.topics.variants.statistics import (
    SobolIndices,
    halved_tolerance_yields,
    quantile,
    sobol_indices,
)
from cardan.topics.variants.study_result import StudyProgress, VariantStudyResult

MAX_SHOWN_LIMITS = 6
"""Limits that figures and tables of the most relevant ones show."""

MAX_INPUT_COLUMNS_HEADED_BY_NAME, MAX_INPUT_COLUMNS = 4, 12
"""Inputs that stand by name at the head of a front's columns, and next to each other, at most."""


# --------------------------------------------------------------------------- in words


def progress_text(of: StudyProgress, say: Translator = ENGLISH) -> str:
    """Return how far a study has come, with rate and time left."""
    if of.rare:
        return say("rare failures: {done} of {count} limits", done=of.rare[0], count=of.rare[1])
    if of.idle:
        return say(
            "{done} of {count} variants; the cluster has no worker: waiting for one",
            done=of.done, count=of.count,
        )  # fmt: skip
    rate = say.compact_number(float(f"{of.rate:.3g}")) if of.rate else "-"
    left = duration_text(of.seconds_left, say) if isfinite(of.seconds_left) else "-"
    return say(
        "{done} of {count} variants, {rate} a second, {left} left",
        done=of.done, count=of.count, rate=rate, left=left,
    )  # fmt: skip


def damaged_shards_text(count: int, folder: object, say: Translator = ENGLISH) -> str:
    """Return that shards of a folder cannot be trusted and are computed again."""
    said = say.count(
        "{count} shard of {folder} is damaged, or of an older version: it is computed again",
        "{count} shards of {folder} are damaged, or of an older version: they are computed again",
        count, folder=folder,
    )  # fmt: skip
    return f"{say('note')}: {said}"


def duration_text(seconds: float, say: Translator = ENGLISH) -> str:
    """Return a time as people say it."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    minutes = seconds / 60
    return f"{minutes:.0f} min" if minutes < 100 else say.with_decimal_sign(f"{minutes / 60:.1f} h")


def summary_line(of: VariantStudyResult, say: Translator = ENGLISH) -> str:
    """Return what the variants came to in a line."""
    said = [f"{percent_text(s, say)} {say(VERDICT_TEXTS[v])}" for v, s in of.shares.items() if s]
    return say(
        "{title}: {count} variants, {verdicts}",
        title=of.installed.application.title,
        count=of.count,
        verdicts=", ".join(said),
    )


def remark_lines(of: VariantStudyResult, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield what else is to be said of the whole."""
    yield from _changed_file_sentences(of, say)
    yield from yield_sentences(of, say)
    yield from doubt_sentences(of, say)
    yield from _stopped_sentence(of, say)


def stopped_sentences(of: VariantStudyResult, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield that the study stopped early, or that its files changed while it ran."""
    yield from _stopped_sentence(of, say)
    yield from _changed_file_sentences(of, say)


def _stopped_sentence(of: VariantStudyResult, say: Translator) -> Iterator[str]:
    if of.count < of.requested_count:
        yield say(
            "Stopped: results of {count} of {asked} variants.",
            count=of.count,
            asked=of.requested_count,
        )


def _changed_file_sentences(of: VariantStudyResult, say: Translator) -> Iterator[str]:
    for file in of.changed_files:
        yield say(
            "Warning: {file} changed while the study ran (SHA-256 {before}, then {after}). The "
            "results are of the text read at the start.",
            file=file.name, before=file.digest_before[:16],
            after=(file.digest_after or "-")[:16],
        )  # fmt: skip


def yield_sentences(of: VariantStudyResult, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield the share that may be built with its interval, and the surrogate prediction."""
    low, high = of.interval()
    if of.variants.ask.yield_:
        yield say(
            "May be built (approved, also with warnings): {share}; with {confidence} confidence "
            "{low} to {high} (Clopper and Pearson).",
            share=percent_text(of.yield_, say),
            confidence=percent_text_as_stated(of.variants.ask.confidence, say),
            low=percent_text(low, say, 2),
            high=percent_text(high, say, 2),
        )
    if of.variants.ask.yield_only:
        yield say(
            "Only the yield was evaluated: {count} variants failed without rubber and were not "
            "evaluated on rubber. Limits and variants have no table.",
            count=of.stopped_count,
        )
    if of.lower_bound_share:
        yield say(
            "Not shown to pass: {share} do not fail, and have a value that is a lower bound (≥), "
            "because rubber is at its stop. They count as incomplete.",
            share=percent_text(of.lower_bound_share, say),
        )
    if of.surrogate_yield:
        yield _foretold(of, say)
    elif of.variants.ask.foretold and of.count == of.requested_count:
        yield say("Too few variants were evaluated for a surrogate prediction.")


def doubt_sentences(of: VariantStudyResult, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield what limits the trust in the results, and how they were obtained."""
    if not of.variants.ask.yield_only and (most := of.lower_bound_shares.max(initial=0.0)):
        yield say(
            "≤ upper bound of a margin: in {share} of the variants rubber goes beyond its stop, "
            "and forces are lower bounds; `cardan check` of one design solves them.",
            share=percent_text(float(most), say),
        )
    if of.sampling_plan.method == "even":
        yield say(
            "The points are spread evenly, so the interval is wider than need be; give "
            "tolerances for one of variants drawn by chance."
        )
    if of.negligible_failures:
        names = dict.fromkeys(say.name(r.limit.quantity) for r in of.negligible_failures)
        yield say(
            "No failure was found nearer than {far} σ, with what is chosen in the middle, of: "
            "{names}.",
            far=say.compact_number(MAX_FAILURE_DISTANCE_SD), names=say.join(*names),
        )  # fmt: skip
    if any(r.infeasible_count for r in (*of.rare_failures, *of.negligible_failures)):
        yield say(
            "Some variants of the search for rare failures cannot exist: they fail no limit, and "
            "their frequency is not reported."
        )
    if of.rare_failures and any(
        not f.tolerance for f in (*of.sampling_plan.factors, *of.sampling_plan.grids)
    ):
        yield say(
            "Rare failures are evaluated for what scatters about the middle of what is chosen; "
            "elsewhere there they may be more frequent."
        )
    if of.variants.correlated:
        pairs = [
            say("{one} with {other} {r}", one=one, other=other, r=say.compact_number(r))
            for one, other, r in of.variants.correlated
        ]
        yield say(
            "Tolerances that go together, by their correlation: {pairs}.", pairs=say.join(*pairs)
        )
    if of.independent_count < of.count:
        yield say(
            "Shares are of the {own} variants drawn by themselves; the others share the variance "
            "out.",
            own=of.independent_count,
        )
    if of.variants.ask.search and "pareto" in of.statistics:
        yield say(
            "{bred} of the {count} variants of the front were bred from the best (NSGA-II).",
            bred=int((of.statistics["pareto"]["place"] >= of.requested_count).sum()),
            count=len(of.statistics["pareto"]["place"]),
        )
    refused = int(of.statistics["counts"]["refused"])
    if refused:
        yield say(
            "{count} variants cannot exist, and count as failed; the first: {why}",
            count=refused, why=str(of.statistics["worst"]["why"][0]),
        )  # fmt: skip
    if refused and "sobol" in of.statistics:
        known, groups = of.statistics["sobol"]["count"][:2].tolist()
        yield say(
            "Of a margin the variance is shared out among the {known} of {groups} groups in which "
            "all variants can exist.",
            known=known, groups=groups,
        )  # fmt: skip
    if of.evaluator.unvectorised_inputs:
        yield say(
            "Read anew for each variant, which is slower, because arrays cannot hold it: {names}.",
            names=say.join(*of.evaluator.unvectorised_inputs),
        )


def _foretold(of: VariantStudyResult, say: Translator) -> str:
    """Return the predicted yield of many, and how often the prediction was wrong."""
    f = of.surrogate_yield
    assert f is not None  # checked by the caller
    if f.without_surrogate:
        return say(
            "The surrogate gives no narrower interval: of {taught} evaluated, {missed} were "
            "predicted to fail that pass, and {praised} to pass that fail. The interval above "
            "holds.",
            taught=f.training_count, missed=f.false_failures, praised=f.false_passes,
        )  # fmt: skip
    return say(
        "Surrogate prediction for {count} more, from {taught} evaluated: {share}; {confidence} "
        "confidence interval {low} to {high}. Errors on the evaluated: {missed} predicted to "
        "fail that pass, {praised} predicted to pass that fail.",
        count=f.count,
        taught=f.training_count,
        share=percent_text(f.share, say, 2),
        confidence=percent_text_as_stated(of.variants.ask.confidence, say),
        low=percent_text(f.low, say, 2),
        high=percent_text(f.high, say, 2),
        missed=f.false_failures,
        praised=f.false_passes,
    )


def terminal_lines(of: VariantStudyResult, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield all that a terminal shows of a study."""
    yield summary_line(of, say)
    yield from remark_lines(of, say)
    yield say("limits: {profile}", profile=of.installed.application.profile)
    for table in result_tables(of, say):
        yield from report_table_lines(table)
    if of.variants.ask.maps:
        yield ""
        yield say("Maps and histograms are drawn by --html.")


def percent_text_as_stated(value: float, say: Translator) -> str:
    """Return a share as it was given, in per cent."""
    return say.with_decimal_sign(f"{100 * value:.9g} %")


# --------------------------------------------------------------------------- tables


def result_tables(of: VariantStudyResult, say: Translator = ENGLISH) -> Iterator[Table]:
    """Yield what varies, and what each limit came to, the worst first."""
    yield _varied(of, say)
    if not of.variants.ask.yield_only:
        yield _limits(of, say)
    if "tighter" in of.statistics:
        yield _tighter(of, say)
    if "sobol" in of.statistics:
        yield _sobol(of, say)
    if of.rare_failures:
        yield _rare(of, say)
    if len(of.statistics["worst"]["place"]):
        yield _worst(of, say)
    if "pareto" in of.statistics:
        yield from _front(of, say)


def _varied(of: VariantStudyResult, say: Translator) -> Table:
    drawn = of.sampling_plan
    numbered = "pareto" in of.statistics and _numbered(of)
    rows = [
        (
            f"{f.input + 1} {drawn.name_of(f)}" if numbered else drawn.name_of(f),
            say.compact_number(drawn.nominal[f.input], 5),
            spread_text(f, say),
        )
        for f in (*drawn.grids, *drawn.factors)
    ]
    return Table(
        caption=say("What varies"),
        head=(say("input"), say("as it is"), say("how it varies")),
        rows=tuple(rows),
    )


def _numbered(of: VariantStudyResult) -> bool:
    """Return whether inputs stand by their numbers at the head of a front's columns."""
    return len(of.sampling_plan.names) > MAX_INPUT_COLUMNS_HEADED_BY_NAME


def spread_text(of: SampledVariable, say: Translator) -> str:
    """Return how an input varies."""
    values = of.spread.values
    match of.spread.kind:
        case "range":
            low, high = (say.compact_number(v) for v in values)
            return f"{low} … {high}"
        case "choice":
            return say("one of {values}", values=say.join(*map(say.compact_number, values)))
        case "grid":
            low, high = say.compact_number(values[0]), say.compact_number(values[-1])
            return say("{count} places, {low} … {high}", count=len(values), low=low, high=high)
        case "normal":
            return say("normal, σ {wide}", wide=say.compact_number(values[0], 4))
        case "uniform":
            return f"± {say.compact_number(values[0], 4)}"


def limits_by_failures(of: VariantStudyResult) -> list[int]:
    """Return the limits that have answers, those first that fail most often.

    None where only the yield was evaluated: not every variant answered each.
    """
    if of.variants.ask.yield_only:
        return []
    counts, values = (
        of.statistics["counts"]["grades"] / of.independent_count,
        of.statistics["values"],
    )
    number = len(of.limits)
    least = values["least"][number : 2 * number]
    known = [k for k in range(number) if np.isfinite(least[k])]
    return sorted(known, key=lambda k: (-counts[k, 2], -counts[k, 1], least[k]))


def limit_name(limit: Limit, say: Translator) -> str:
    """Return which limit it is, with its bound: a quantity may have several."""
    q = QUANTITIES[limit.quantity]
    bounds_ = limit.band or tuple(b for b in (limit.normal, limit.maximum) if b is not None)
    shown = " … ".join(say.number(b / q.si_factor) for b in bounds_)
    sense = say("outside") if limit.band else limit.sense
    return f"{say.name(q.key)} {sense} {shown} {q.unit_symbol}".rstrip()


def limit_label(of: VariantStudyResult, k: int, say: Translator) -> str:
    """Return the name of a limit with its bound, and its line if there are several."""
    line, limit = of.limits[k]
    several = len(of.installed.application.lines) > 1
    return say.join(line if several else "", limit_name(limit, say))


def limit_margins(of: VariantStudyResult, k: int) -> tuple[float, float]:
    """Return the smallest and the median margin to a limit."""
    values, column = of.statistics["values"], len(of.limits) + k
    return float(values["least"][column]), quantile(values, column, 0.5)


def bound_mark(of: VariantStudyResult, k: int) -> str:
    """Return the mark of margins that are upper bounds, because values are lower bounds."""
    return "≤ " if of.lower_bound_shares[k] else ""


def _limits(of: VariantStudyResult, say: Translator) -> Table:
    counts, values, asked = (
        of.statistics["counts"],
        of.statistics["values"],
        of.variants.ask.quantiles,
    )
    grades = counts["grades"] / of.independent_count

    def row(k: int) -> tuple[str, ...]:
        factor = QUANTITIES[of.limits[k][1].quantity].si_factor
        return (
            limit_label(of, k, say),
            *(percent_text(grades[k, g], say) for g in range(3)),
            percent_text(counts["alone"][k] / of.independent_count, say),
            *(bound_mark(of, k) + say.margin_percent(m) for m in limit_margins(of, k)),
            *(say.number(quantile(values, k, q) / factor) for q in asked),
        )

    return Table(
        caption=say("Every limit over all variants"),
        head=(
            say("limit"),
            *(grade_text(g, say) for g in CHECK_GRADES),
            say("exceeded alone"),
            say("smallest margin"),
            say("median margin"),
            *(say("{share} quantile", share=percent_text_as_stated(q, say)) for q in asked),
        ),
        rows=tuple(row(k) for k in limits_by_failures(of)),
    )


def _tighter(of: VariantStudyResult, say: Translator) -> Table:
    passes, error = halved_tolerance_yields(of.statistics["tighter"])
    rows: list[tuple[float, tuple[str, ...]]] = []
    for t, factor in enumerate(of.tolerance_factors):
        fails = of.statistics["counts"]["grades"][: passes.shape[1] - 1, 2] / of.independent_count
        gains = passes[t, 1:] - (1 - fails)
        best = int(gains.argmax()) if gains.size else None
        helps = best is not None and gains[best] > 2 * error[t, 1 + best]
        rows.append(
            (
                -(passes[t, 0] + 1e-6 * gains.max(initial=0.0)),
                (
                    of.sampling_plan.name_of(factor),
                    spread_text(factor, say),
                    percent_text(float(passes[t, 0]), say),
                    say.with_decimal_sign(f"± {200 * error[t, 0]:.1f} %"),
                    say.with_decimal_sign(f"{100 * (passes[t, 0] - of.yield_):+.1f} %"),
                    f"{limit_label(of, best, say)} "
                    f"{say.with_decimal_sign(f'{100 * gains[best]:+.1f} %')}"
                    if helps and best is not None
                    else "-",
                ),
            )
        )
    return Table(
        caption=say("Which tolerance to tighten first: the yield with each half as wide, alone"),
        head=(
            say("tolerance"),
            say("now"),
            say("yield"),
            say("two standard errors"),
            say("gain"),
            say("limit that gains most"),
        ),
        rows=tuple(row for _, row in sorted(rows)),
        words=2,
    )


def _sobol(of: VariantStudyResult, say: Translator) -> Table:
    found = sobol_indices(of.statistics["sobol"])
    drawn = of.sampling_plan
    columns = sobol_columns(of)
    order = np.argsort(-np.nan_to_num(found.total[columns[0] if columns else 0]), kind="stable")

    def row(k: int) -> tuple[str, ...]:
        name = factor_label(of, drawn.factors[k], say)
        cells_: list[str] = []
        for c in columns:
            cells_ += [_index(found, c, k, say), _total(found, c, k, say)]
        return (name, *cells_)

    heads: list[str] = []
    for c in columns:
        what = sobol_column_label(of, c, say)
        heads += [say("{what}: alone", what=what), say("{what}: in all", what=what)]
    return Table(
        caption=say("Where the variance comes from (Sobol indices, two standard errors)"),
        head=(say("input"), *heads),
        rows=tuple(row(int(k)) for k in order),
    )


def factor_label(of: VariantStudyResult, factor: SampledVariable, say: Translator) -> str:
    """Return the name of a factor; of a tolerance of a variable, with that word."""
    name = of.sampling_plan.name_of(factor)
    both = sum(f.input == factor.input for f in of.sampling_plan.factors) > 1
    return f"{name} ({say('tolerance')})" if both and factor.tolerance else name


def sobol_columns(of: VariantStudyResult) -> list[int]:
    """Return the columns of variance that are shown: margin, yield and the limit worst off."""
    found = sobol_indices(of.statistics["sobol"])
    some = [c for c in (0, 1) if np.isfinite(found.total[c]).all()]
    worst = [2 + k for k in limits_by_failures(of) if np.isfinite(found.total[2 + k]).all()]
    return some + worst[:1]


def sobol_column_label(of: VariantStudyResult, column: int, say: Translator) -> str:
    """Return the name of the output whose variance a column holds."""
    if column < 2:
        return say("smallest margin") if column == 0 else say("may be built")
    return say.name(of.limits[column - 2][1].quantity)


def _index(found: SobolIndices, c: int, k: int, say: Translator) -> str:
    return _with_errors(found.first[c, k], found.first_error[c, k], say)


def _total(found: SobolIndices, c: int, k: int, say: Translator) -> str:
    return _with_errors(found.total[c, k], found.total_error[c, k], say)


def _with_errors(value: float, error: float, say: Translator) -> str:
    return say.with_decimal_sign(f"{round(value, 2) + 0.0:.2f} ± {2 * error:.2f}")  # no "-0.00"


def once_in_text(share: float, say: Translator) -> str:
    """Return a small share as one in so many; "-" if it is zero."""
    if share <= 0:
        return "-"
    return say("1 in {count}", count=say.compact_number(float(f"{1 / share:.2g}")))


def _rare(of: VariantStudyResult, say: Translator) -> Table:
    drawn = of.sampling_plan
    own = [f for f in drawn.factors if f.tolerance]

    rows: list[tuple[str, ...]] = []
    for one in sorted(of.rare_failures, key=lambda r: -r.failure_probability):
        first, second, sampled = one.first_order, one.second_order, one.sampled
        assert first is not None  # others are not reported
        most = own[int(first.importance.argmax())]
        rows.append(
            (
                limit_name(one.limit, say),
                str(len(one.failure_modes)),
                say.with_decimal_sign(f"{first.beta:.2f}"),
                "-" if first.sampled else once_in_text(first.failure_probability, say),
                once_in_text(second.failure_probability, say) if second else "-",
                once_in_text(sampled.failure_probability, say)
                + (
                    say.with_decimal_sign(
                        f" ± {200 * sampled.standard_error / sampled.failure_probability:.0f} %"
                    )
                    if sampled.failure_probability
                    else ""
                )
                if sampled
                else "-",
                f"{drawn.name_of(most)} {say.compact_number(float(one.inputs[most.input]), 4)}",
            )
        )
    return Table(
        caption=say(
            "Limits that fail hardly ever: how often, sampled with two standard errors, and where "
            "most likely"
        ),
        head=(
            say("limit"), say("ways to fail"), say("nearest [σ]"), say("first order"),
            say("second order"), say("sampled"), say("most of it by"),
        ),
        rows=tuple(rows),
    )  # fmt: skip


def deciding_limit_name(of: VariantStudyResult, k: int, say: Translator) -> str:
    """Return the name of the limit that decides a variant; "-" if none was evaluated."""
    return say.name(of.limits[k][1].quantity) if k != UNEVALUATED_GRADE_CODE else "-"


def _worst(of: VariantStudyResult, say: Translator) -> Table:
    state = of.statistics["worst"]
    many = range(min(len(state["place"]), 5))
    rows = [
        (say("verdict"), *(say(VERDICT_TEXTS[VERDICTS[int(state["verdict"][k])]]) for k in many)),
        (say("smallest margin"), *(say.margin_percent(float(state["margin"][k])) for k in many)),
        (say("limit"), *(deciding_limit_name(of, int(state["limit"][k]), say) for k in many)),
        *(
            (name, *(say.compact_number(float(state["inputs"][k, i]), 5) for k in many))
            for i, name in enumerate(of.sampling_plan.names)
        ),
    ]
    return Table(
        caption=say("The worst variants"),
        head=(say("variant"), *(str(int(state["place"][k])) for k in many)),
        rows=tuple(rows),
    )


def _front(of: VariantStudyResult, say: Translator) -> Iterator[Table]:
    """Yield what no other variant beats; of many inputs some at a time, by numbers for names."""
    state, goals = of.statistics["pareto"], of.variants.ask.pareto
    titles = {"margin": say("smallest margin"), "cost": say("cost"), "mass": say("mass [kg]")}

    def shown(goal: str, value: float) -> str:
        if goal == "margin":
            return say.margin_percent(-value)
        return say.compact_number(round(value, 2) if goal == "cost" else value, 5)

    few = (
        np.unique(np.linspace(0, len(state["place"]) - 1, 20).astype(int))
        if len(state["place"])
        else []
    )
    names = of.sampling_plan.names
    numbered = _numbered(of)
    caption = say(
        "What no other variant beats ({count} in all): margin, cost of moves, mass; inputs by "
        "their numbers above"
        if numbered
        else "What no other variant beats ({count} in all): margin, cost of moves, mass",
        count=len(state["place"]),
    )
    for first in range(0, len(names), MAX_INPUT_COLUMNS):
        some = range(first, min(first + MAX_INPUT_COLUMNS, len(names)))
        yield Table(
            caption=caption,
            head=(
                say("variant"),
                say("verdict"),
                *(titles[g] for g in goals),
                *(str(i + 1) if numbered else names[i] for i in some),
            ),
            rows=tuple(
                (
                    str(int(state["place"][k])),
                    say(VERDICT_TEXTS[VERDICTS[int(state["verdict"][k])]]),
                    *(shown(g, float(v)) for g, v in zip(goals, state["goals"][k], strict=True)),
                    *(
                        say.compact_number(float(state["inputs"][k, i]), 4 if numbered else 5)
                        for i in some
                    ),
                )
                for k in few
            ),
        )
