"""What a study of variants came to: in words, in tables, in figures."""

from collections.abc import Iterator
from math import isfinite
from typing import Any

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.verdict import GRADES, VERDICTS, Limit, badness
from cardan.quantity.quantities import QUANTITIES
from cardan.report import contract, svg
from cardan.report.blocks import Block, Chapter, Figures, Issue, Story, Table, Text
from cardan.report.chart import Band, Chart, bounds
from cardan.report.language import EN, Language
from cardan.report.story import signs
from cardan.report.svg import FAINT, GRADED, INK, PALETTE, Figure
from cardan.report.terminal import block
from cardan.study.draw import Factor
from cardan.study.rare import FAR
from cardan.study.reduce import Indices, Map, State, cells, quantile, sobol, tighter
from cardan.study.shards import Progress, Studied
from cardan.study.sweep import NOTHING

SHOWN = 6
"""Limits that figures and tables of the most telling ones show."""

AXES = 7
"""Inputs across which lines of variants go, at most."""

NAMED, BESIDE = 4, 12
"""Inputs that stand by name at the head of a front's columns, and beside each other, at most."""

BINS = 40
"""Bars of a histogram, about."""


# --------------------------------------------------------------------------- in words


def progress(of: Progress, say: Language = EN) -> str:
    """Return how far a study has come, with rate and time left."""
    if of.rare:
        return say("rare failures: {done} of {count} limits", done=of.rare[0], count=of.rare[1])
    if of.idle:
        return say(
            "{done} of {count} variants; the cluster has no worker: waiting for one",
            done=of.done, count=of.count,
        )  # fmt: skip
    rate = say.short(float(f"{of.rate:.3g}")) if of.rate else "-"
    left = clock(of.left, say) if isfinite(of.left) else "-"
    return say(
        "{done} of {count} variants, {rate} a second, {left} left",
        done=of.done, count=of.count, rate=rate, left=left,
    )  # fmt: skip


def clock(seconds: float, say: Language = EN) -> str:
    """Return a time as people say it."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    minutes = seconds / 60
    return f"{minutes:.0f} min" if minutes < 100 else say.pointed(f"{minutes / 60:.1f} h")


def summary(of: Studied, say: Language = EN) -> str:
    """Return what the variants came to in a line."""
    said = [f"{share(s, say)} {say(v)}" for v, s in of.shares.items() if s]
    return say(
        "{title}: {count} variants, {verdicts}",
        title=of.installed.application.title,
        count=of.count,
        verdicts=", ".join(said),
    )


def told(of: Studied, say: Language = EN) -> Iterator[str]:
    """Yield what else is to be said of the whole."""
    low, high = of.interval()
    if of.variants.ask.yield_:
        yield say(
            "May be built (pass or warn): {share}; with {confidence} confidence {low} to {high} "
            "(Clopper and Pearson).",
            share=share(of.yield_, say),
            confidence=level(of.variants.ask.confidence, say),
            low=share(low, say, 2),
            high=share(high, say, 2),
        )
    if of.foretold:
        yield _foretold(of, say)
    elif of.variants.ask.foretold and of.count == of.asked:
        yield say("Too few variants were asked to foretell others from them.")
    if of.drawing.points == "even":
        yield say(
            "The points are spread evenly, so the interval is wider than need be; give "
            "tolerances for one of variants drawn by chance."
        )
    if of.beyond:
        names = dict.fromkeys(say.name(r.limit.quantity) for r in of.beyond)
        yield say(
            "No failure was found nearer than {far} σ, with what is chosen in the middle, of: "
            "{names}.",
            far=say.short(FAR), names=say.list(*names),
        )  # fmt: skip
    if any(r.lost for r in (*of.rare, *of.beyond)):
        yield say(
            "Some of those asked about rare failures cannot exist: they fail no limit, and how "
            "often they occur is not told."
        )
    if of.rare and any(not f.tolerance for f in (*of.drawing.factors, *of.drawing.grids)):
        yield say(
            "What hardly ever fails is told of what scatters about the middle of what is chosen; "
            "elsewhere there it may fail more often."
        )
    if of.variants.correlated:
        pairs = [
            say("{one} with {other} {r}", one=one, other=other, r=say.short(r))
            for one, other, r in of.variants.correlated
        ]
        yield say(
            "Tolerances that go together, by their correlation: {pairs}.", pairs=say.list(*pairs)
        )
    if of.own < of.count:
        yield say(
            "Shares are of the {own} variants drawn by themselves; the others share the variance "
            "out.",
            own=of.own,
        )
    if of.variants.ask.search and "pareto" in of.states:
        yield say(
            "{bred} of the {count} variants of the front were bred from the best (NSGA-II).",
            bred=int((of.states["pareto"]["place"] >= of.asked).sum()),
            count=len(of.states["pareto"]["place"]),
        )
    if of.count < of.asked:
        yield say(
            "Stopped: {count} of {asked} variants are told of.", count=of.count, asked=of.asked
        )
    refused = int(of.states["counts"]["refused"])
    if refused:
        yield say(
            "{count} variants cannot exist, and count as failed; the first: {why}",
            count=refused, why=str(of.states["worst"]["why"][0]),
        )  # fmt: skip
    if refused and "sobol" in of.states:
        known, groups = of.states["sobol"]["count"][:2].tolist()
        yield say(
            "Of a margin the variance is shared out among the {known} of {groups} groups in which "
            "all variants can exist.",
            known=known, groups=groups,
        )  # fmt: skip
    if of.bench.single:
        yield say(
            "Read anew for each variant, which is slower, because arrays cannot hold it: {names}.",
            names=say.list(*of.bench.single),
        )


def _foretold(of: Studied, say: Language) -> str:
    """Return the yield of many, foretold, and how often that was wrong."""
    f = of.foretold
    assert f is not None  # who asks has looked
    if f.plain:
        return say(
            "Foretelling others tells no more narrowly: of {taught} asked, {missed} were foretold "
            "to fail that fit, and {praised} to fit that fail. The interval above stands.",
            taught=f.taught, missed=f.missed, praised=f.praised,
        )  # fmt: skip
    return say(
        "Of {count} more, foretold from {taught} asked: {share}; with {confidence} confidence "
        "{low} to {high}. Foretold wrongly, of those asked: {missed} to fail that fit, "
        "{praised} to fit that fail.",
        count=f.count,
        taught=f.taught,
        share=share(f.share, say, 2),
        confidence=level(of.variants.ask.confidence, say),
        low=share(f.low, say, 2),
        high=share(f.high, say, 2),
        missed=f.missed,
        praised=f.praised,
    )


def terminal(of: Studied, say: Language = EN) -> Iterator[str]:
    """Yield all that a terminal shows of a study."""
    yield summary(of, say)
    yield from told(of, say)
    yield say("limits: {profile}", profile=of.installed.application.profile)
    for table in tables(of, say):
        yield from block(table)
    if of.variants.ask.maps:
        yield ""
        yield say("Maps and histograms are drawn by --html.")


def share(value: float, say: Language, digits: int = 1) -> str:
    """Return a share in per cent; what is not none or all of them never reads so."""
    while 0 < value < 1 and digits < 9 and float(f"{100 * value:.{digits}f}") in (0, 100):
        digits += 1
    return say.pointed(f"{100 * value:.{digits}f} %")


def level(value: float, say: Language) -> str:
    """Return a share that somebody gave, as they gave it, in per cent."""
    return say.pointed(f"{100 * value:.9g} %")


# --------------------------------------------------------------------------- tables


def tables(of: Studied, say: Language = EN) -> Iterator[Table]:
    """Yield what varies, and what each limit came to, the worst first."""
    yield _varied(of, say)
    yield _limits(of, say)
    if "tighter" in of.states:
        yield _tighter(of, say)
    if "sobol" in of.states:
        yield _sobol(of, say)
    if of.rare:
        yield _rare(of, say)
    if len(of.states["worst"]["place"]):
        yield _worst(of, say)
    if "pareto" in of.states:
        yield from _front(of, say)


def _varied(of: Studied, say: Language) -> Table:
    drawn = of.drawing
    numbered = "pareto" in of.states and _numbered(of)
    rows = [
        (
            f"{f.input + 1} {drawn.called(f)}" if numbered else drawn.called(f),
            say.short(drawn.at[f.input], 5),
            _spread(f, say),
        )
        for f in (*drawn.grids, *drawn.factors)
    ]
    return Table(
        caption=say("What varies"),
        head=(say("input"), say("as it is"), say("how it varies")),
        rows=tuple(rows),
    )


def _numbered(of: Studied) -> bool:
    """Return whether inputs stand by their numbers at the head of a front's columns."""
    return len(of.drawing.names) > NAMED


def _spread(of: Factor, say: Language) -> str:
    values = of.spread.values
    match of.spread.kind:
        case "range":
            low, high = (say.short(v) for v in values)
            return f"{low} … {high}"
        case "choice":
            return say("one of {values}", values=say.list(*map(say.short, values)))
        case "grid":
            low, high = say.short(values[0]), say.short(values[-1])
            return say("{count} places, {low} … {high}", count=len(values), low=low, high=high)
        case "normal":
            return say("normal, σ {wide}", wide=say.short(values[0], 4))
        case "uniform":
            return f"± {say.short(values[0], 4)}"


def ordered(of: Studied) -> list[int]:
    """Return the limits that have answers, those first that fail most often."""
    counts, values = of.states["counts"]["grades"] / of.own, of.states["values"]
    number = len(of.limits)
    least = values["least"][number : 2 * number]
    known = [k for k in range(number) if np.isfinite(least[k])]
    return sorted(known, key=lambda k: (-counts[k, 2], -counts[k, 1], least[k]))


def limit_name(limit: Limit, say: Language) -> str:
    """Return which limit it is, with its bound: a quantity may have several."""
    q = QUANTITIES[limit.quantity]
    bounds_ = limit.band or tuple(b for b in (limit.normal, limit.maximum) if b is not None)
    shown = " … ".join(say.number(b / q.factor) for b in bounds_)
    sense = say("outside") if limit.band else limit.sense
    return f"{say.name(q.key)} {sense} {shown} {q.unit_name}".rstrip()


def _named(of: Studied, k: int, say: Language) -> str:
    line, limit = of.limits[k]
    several = len(of.installed.application.lines) > 1
    return say.list(line if several else "", limit_name(limit, say))


def _limits(of: Studied, say: Language) -> Table:
    counts, values, asked = of.states["counts"], of.states["values"], of.variants.ask.quantiles
    number = len(of.limits)
    grades = counts["grades"] / of.own

    def row(k: int) -> tuple[str, ...]:
        factor = QUANTITIES[of.limits[k][1].quantity].factor
        return (
            _named(of, k, say),
            *(share(grades[k, g], say) for g in range(3)),
            share(counts["alone"][k] / of.own, say),
            say.percent(float(values["least"][number + k])),
            say.percent(quantile(values, number + k, 0.5)),
            *(say.number(quantile(values, k, q) / factor) for q in asked),
        )

    return Table(
        caption=say("Every limit over all variants"),
        head=(
            say("limit"), *(say(g) for g in GRADES), say("fails alone"), say("smallest margin"),
            say("median margin"), *(say("{share} quantile", share=level(q, say)) for q in asked),
        ),
        rows=tuple(row(k) for k in ordered(of)),
    )  # fmt: skip


def _tolerances(of: Studied) -> list[Factor]:
    return [f for f in of.drawing.factors if f.tolerance]


def _tighter(of: Studied, say: Language) -> Table:
    passes, error = tighter(of.states["tighter"])
    rows: list[tuple[float, tuple[str, ...]]] = []
    for t, factor in enumerate(_tolerances(of)):
        gains = passes[t, 1:] - (1 - of.states["counts"]["grades"][:, 2] / of.own)
        best = int(gains.argmax())
        helps = gains[best] > 2 * error[t, 1 + best]
        rows.append(
            (
                -(passes[t, 0] + 1e-6 * gains[best]),
                (
                    of.drawing.called(factor),
                    _spread(factor, say),
                    share(float(passes[t, 0]), say),
                    say.pointed(f"± {200 * error[t, 0]:.1f} %"),
                    say.pointed(f"{100 * (passes[t, 0] - of.yield_):+.1f} %"),
                    f"{_named(of, best, say)} {say.pointed(f'{100 * gains[best]:+.1f} %')}"
                    if helps
                    else "-",
                ),
            )
        )
    return Table(
        caption=say("Which tolerance to tighten first: the yield with each half as wide, alone"),
        head=(
            say("tolerance"), say("now"), say("yield"), say("two standard errors"), say("gain"),
            say("limit that gains most"),
        ),
        rows=tuple(row for _, row in sorted(rows)),
        words=2,
    )  # fmt: skip


def _sobol(of: Studied, say: Language) -> Table:
    found = sobol(of.states["sobol"])
    drawn = of.drawing
    columns = _outputs(of)
    order = np.argsort(-np.nan_to_num(found.total[columns[0] if columns else 0]), kind="stable")

    def row(k: int) -> tuple[str, ...]:
        name = _factor(of, drawn.factors[k], say)
        cells_: list[str] = []
        for c in columns:
            cells_ += [_index(found, c, k, say), _total(found, c, k, say)]
        return (name, *cells_)

    heads: list[str] = []
    for c in columns:
        what = _output(of, c, say)
        heads += [say("{what}: alone", what=what), say("{what}: in all", what=what)]
    return Table(
        caption=say("Where the variance comes from (Sobol indices, two standard errors)"),
        head=(say("input"), *heads),
        rows=tuple(row(int(k)) for k in order),
    )


def _factor(of: Studied, factor: Factor, say: Language) -> str:
    name = of.drawing.called(factor)
    both = sum(f.input == factor.input for f in of.drawing.factors) > 1
    return f"{name} ({say('tolerance')})" if both and factor.tolerance else name


def _outputs(of: Studied) -> list[int]:
    """Return the columns of variance that are shown: margin, yield and the limit worst off."""
    found = sobol(of.states["sobol"])
    some = [c for c in (0, 1) if np.isfinite(found.total[c]).all()]
    worst = [2 + k for k in ordered(of) if np.isfinite(found.total[2 + k]).all()]
    return some + worst[:1]


def _output(of: Studied, column: int, say: Language) -> str:
    if column < 2:
        return say("smallest margin") if column == 0 else say("may be built")
    return say.name(of.limits[column - 2][1].quantity)


def _index(found: Indices, c: int, k: int, say: Language) -> str:
    return _with_errors(found.first[c, k], found.first_error[c, k], say)


def _total(found: Indices, c: int, k: int, say: Language) -> str:
    return _with_errors(found.total[c, k], found.total_error[c, k], say)


def _with_errors(value: float, error: float, say: Language) -> str:
    return say.pointed(f"{round(value, 2) + 0.0:.2f} ± {2 * error:.2f}")  # no "-0.00"


def _rare(of: Studied, say: Language) -> Table:
    drawn = of.drawing
    own = [f for f in drawn.factors if f.tolerance]

    def once(share_: float) -> str:
        return (
            say("1 in {count}", count=say.short(float(f"{1 / share_:.2g}"))) if share_ > 0 else "-"
        )

    rows: list[tuple[str, ...]] = []
    for one in sorted(of.rare, key=lambda r: -r.failure):
        first, second, sampled = one.first_order, one.second_order, one.sampled
        assert first is not None  # others are not told
        most = own[int(first.importance.argmax())]
        rows.append(
            (
                limit_name(one.limit, say),
                str(len(one.ways)),
                say.pointed(f"{first.beta:.2f}"),
                "-" if first.met else once(first.failure),
                once(second.failure) if second else "-",
                once(sampled.failure)
                + (
                    say.pointed(f" ± {200 * sampled.error / sampled.failure:.0f} %")
                    if sampled.failure
                    else ""
                )
                if sampled
                else "-",
                f"{drawn.called(most)} {say.short(float(one.inputs[most.input]), 4)}",
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


def _decides(of: Studied, k: int, say: Language) -> str:
    return say.name(of.limits[k][1].quantity) if k != NOTHING else "-"


def _worst(of: Studied, say: Language) -> Table:
    state = of.states["worst"]
    many = range(min(len(state["place"]), 5))
    rows = [
        (say("verdict"), *(say(VERDICTS[int(state["verdict"][k])]) for k in many)),
        (say("smallest margin"), *(say.percent(float(state["margin"][k])) for k in many)),
        (say("limit"), *(_decides(of, int(state["limit"][k]), say) for k in many)),
        *(
            (name, *(say.short(float(state["inputs"][k, i]), 5) for k in many))
            for i, name in enumerate(of.drawing.names)
        ),
    ]
    return Table(
        caption=say("The worst variants"),
        head=(say("variant"), *(str(int(state["place"][k])) for k in many)),
        rows=tuple(rows),
    )


def _front(of: Studied, say: Language) -> Iterator[Table]:
    """Yield what no other variant beats; of many inputs some at a time, by numbers for names."""
    state, goals = of.states["pareto"], of.variants.ask.pareto
    titles = {"margin": say("smallest margin"), "cost": say("cost"), "mass": say("mass [kg]")}

    def shown(goal: str, value: float) -> str:
        if goal == "margin":
            return say.percent(-value)
        return say.short(round(value, 2) if goal == "cost" else value, 5)

    few = (
        np.unique(np.linspace(0, len(state["place"]) - 1, 20).astype(int))
        if len(state["place"])
        else []
    )
    names = of.drawing.names
    numbered = _numbered(of)
    caption = say(
        "What no other variant beats ({count} in all): margin, cost of moves, mass; inputs by "
        "their numbers above"
        if numbered
        else "What no other variant beats ({count} in all): margin, cost of moves, mass",
        count=len(state["place"]),
    )
    for first in range(0, len(names), BESIDE):
        some = range(first, min(first + BESIDE, len(names)))
        yield Table(
            caption=caption,
            head=(
                say("variant"), say("verdict"), *(titles[g] for g in goals),
                *(str(i + 1) if numbered else names[i] for i in some),
            ),
            rows=tuple(
                (
                    str(int(state["place"][k])),
                    say(VERDICTS[int(state["verdict"][k])]),
                    *(shown(g, float(v)) for g, v in zip(goals, state["goals"][k], strict=True)),
                    *(say.short(float(state["inputs"][k, i]), 4 if numbered else 5) for i in some),
                )
                for k in few
            ),
        )  # fmt: skip


# --------------------------------------------------------------------------- figures


def figures(of: Studied, say: Language = EN) -> Iterator[Figure]:
    """Yield histograms with their limits, bars of what decides, maps and the front."""
    for k in telling(of):
        yield histogram(of, k, say)
    if "tighter" in of.states and len(_tolerances(of)) > 1:
        yield _gains(of, say)
    if "sobol" in of.states:
        for column in _outputs(of):
            yield variance(of, column, say)
    if len(of.drawing.names) > 1:
        yield parallel(of, say)
    for chart, state in of.maps:
        yield heat(of, chart, state, say)
    if "pareto" in of.states and len(of.states["pareto"]["place"]):
        yield front(of, say)


def telling(of: Studied) -> list[int]:
    """Return the limits whose scatter tells most: those that some variants pass and some not."""
    grades = of.states["counts"]["grades"] / of.own
    split = [k for k in ordered(of) if 0 < grades[k, 2] < 1 or 0 < grades[k, 1] < 1]
    others = [k for k in ordered(of) if k not in split and grades[k, 2] > 0]
    return (split + others)[:SHOWN] or ordered(of)[:2]


def histogram(of: Studied, k: int, say: Language = EN) -> Figure:
    """Return how the values of a limit scatter, with its bounds."""
    limit = of.limits[k][1]
    q, state = QUANTITIES[limit.quantity], of.states["values"]
    places, counts = cells(state, k)
    places = places / q.factor
    ends = [
        b / q.factor for b in (limit.normal, limit.maximum, *(limit.band or ())) if b is not None
    ]
    low, high = sorted((state["least"][k] / q.factor, state["most"][k] / q.factor))
    near = [b for b in ends if low - (high - low) <= b <= high + (high - low)]
    x = bounds(np.array([low, high, *near]), room=0.04)
    edges = np.linspace(low, high, BINS + 1) if high > low else np.array([x[0], x[1]])
    heights, _ = np.histogram(np.clip(places, low, high), edges, weights=counts)
    heights = 100 * heights / counts.sum()
    chart = Chart(
        say=say, x=x, y=(0.0, 1.1 * float(heights.max())),
        x_label=f"{say.name(q.key)} [{q.unit_name or '1'}]", y_label=say("share of variants [%]"),
    )  # fmt: skip
    for band in _bands(limit, q.factor, x):
        chart.band(band)
    for left, right, height in zip(edges, edges[1:], heights, strict=False):
        if height:
            (x1, y1), (x2, y2) = chart.spot(left, 0.0), chart.spot(right, height)
            chart.put(svg.rect(x1 + 0.3, y2, max(x2 - x1 - 0.6, 0.6), y1 - y2, fill=PALETTE[0]))
    at = _installed(of, k)
    if at is not None and x[0] <= at / q.factor <= x[1]:
        (x1, y1), (_, y2) = chart.spot(at / q.factor, 0.0), chart.spot(at / q.factor, chart.y[1])
        chart.put(svg.line(x1, y1, x1, y2, stroke=INK, stroke_width=1.4, stroke_dasharray="5 3"))
        chart.put(svg.text(x1 + 4, y2 + 12, say("as it is"), font_size=11))
    grades = of.states["counts"]["grades"][k] / of.own
    note = say(
        "{fail} fail, {warn} warn; of every variant the state and part where it is worst.",
        fail=share(grades[2], say), warn=share(grades[1], say),
    )  # fmt: skip
    title = limit_name(limit, say)
    return chart.figure(title=title, alt=f"{title}. {note}", note=note)


def _installed(of: Studied, k: int) -> float | None:
    line, limit = of.limits[k]
    mine = [c for c in of.installed.checks if c.limit == limit and c.line == line]
    if not mine:
        return None
    return min(mine, key=badness).value


def _bands(limit: Limit, factor: float, x: tuple[float, float]) -> Iterator[Band]:
    """Yield where a limit warns and fails along the x axis."""
    if limit.band:
        low, high = (b / factor for b in limit.band)
        yield Band(low=low, high=high, grade="warn", along="x")
        return
    first, last = (None if b is None else b / factor for b in (limit.normal, limit.maximum))
    above = limit.sense == "<="
    if first is not None:
        end = last if last is not None else (x[1] if above else x[0])
        low, high = min(first, end), max(first, end)
        yield Band(low=low, high=high, grade="warn", along="x", from_above=not above)
    if last is not None:
        end = max(x[1], last) if above else min(x[0], last)
        low, high = min(last, end), max(last, end)
        yield Band(low=low, high=high, grade="fail", along="x", from_above=not above)


def _gains(of: Studied, say: Language) -> Figure:
    """Return what halving each tolerance wins."""
    passes, error = tighter(of.states["tighter"])
    factors = _tolerances(of)
    gain, spread = 100 * (passes[:, 0] - of.yield_), 200 * error[:, 0]
    return _sideways(
        say,
        title=say("What halving each tolerance wins"),
        names=[of.drawing.called(f) for f in factors],
        values=gain,
        errors=spread,
        x_label=say("gain in yield [%]"),
        least=1.0,
        digits=1,
    )


def variance(of: Studied, column: int, say: Language = EN) -> Figure:
    """Return the total Sobol indices of one output as bars."""
    found = sobol(of.states["sobol"])
    what = _output(of, column, say)
    return _sideways(
        say,
        title=say("Where the variance comes from: {what}", what=what),
        names=[_factor(of, f, say) for f in of.drawing.factors],
        values=found.total[column],
        errors=2 * found.total_error[column],
        inner=found.first[column],
        x_label=say("share of the variance: dark alone, light with what it does with others"),
    )


def _sideways(
    say: Language,
    *,
    title: str,
    names: list[str],
    values: FloatArray,
    errors: FloatArray,
    x_label: str,
    inner: FloatArray | None = None,
    least: float = 0.01,
    digits: int = 2,
) -> Figure:
    """Return bars that lie, longest on top, names in the chart, which reaches to `least` at least.

    Values are told to so many digits behind the point.
    """
    order = np.argsort(np.nan_to_num(values), kind="stable")[-16:]
    high = float(np.nan_to_num(values + errors).max(initial=least))
    low = min(0.0, float(np.nan_to_num(values - errors).min(initial=0.0)))
    chart = Chart(
        say=say, x=bounds(np.array([low, high]), zero=True), y=(0.0, float(len(order))),
        x_label=x_label, y_label="", values=False, height=90 + 30.0 * len(order),
    )  # fmt: skip
    for row, k in enumerate(order.tolist()):
        value, error = float(values[k]), float(errors[k])
        if not isfinite(value):
            continue
        for size, colour in (
            (value, PALETTE[0] if inner is None else FAINT),
            *(() if inner is None else ((float(max(inner[k], 0.0)), PALETTE[0]),)),
        ):
            (x1, y1), (x2, y2) = chart.spot(0.0, row + 0.12), chart.spot(size, row + 0.5)
            chart.put(svg.rect(min(x1, x2), y2, max(abs(x2 - x1), 0.8), y1 - y2, fill=colour))
        (x1, y1), (x2, _) = (chart.spot(value + s * error, row + 0.31) for s in (-1, 1))
        chart.put(svg.line(x1, y1, x2, y1, stroke=INK, stroke_width=1.2))
        (x0, y0) = chart.spot(max(low, 0.0), row + 0.58)
        said = f"{names[k]}: {say.pointed(f'{round(value, digits) + 0.0:.{digits}f}')}"
        chart.put(svg.text(x0 + 4, y0, said, font_size=11))
    most = names[int(order[-1])] if len(order) else ""
    return chart.figure(title=title, alt=f"{title}. {say('most')}: {most}")


def heat(of: Studied, chart: Map, state: State, say: Language = EN) -> Figure:
    """Return the yield over two inputs, cell by cell."""
    (a, b), (wide, high) = chart.edges, chart.shape
    drawn = Chart(
        say=say, x=(a[0], a[-1]), y=(b[0], b[-1]),
        x_label=of.drawing.names[chart.columns[0]], y_label=of.drawing.names[chart.columns[1]],
    )  # fmt: skip
    for i in range(wide):
        for j in range(high):
            count = state["count"][i, j]
            if not count:
                continue
            fit = float(state["passes"][i, j] / count)
            (x1, y1), (x2, y2) = drawn.spot(a[i], b[j]), drawn.spot(a[i + 1], b[j + 1])
            drawn.put(svg.rect(x1, y2, x2 - x1, y1 - y2, fill=_mixed(fit), stroke="none"))
            if wide <= 10 and high <= 12:
                said = say.pointed(f"{100 * fit:.0f}")
                drawn.put(
                    svg.text((x1 + x2) / 2, (y1 + y2) / 2 + 4, said, anchor="middle", font_size=11,
                             fill="#ffffff" if fit < 0.25 or fit > 0.85 else "#1a1a1a")
                )  # fmt: skip
    title = say("Yield over {one} and {other}", one=drawn.x_label, other=drawn.y_label)
    fit = state["passes"] / np.maximum(state["count"], 1)
    left = state["sum"] / np.maximum(state["known"], 1)
    best = np.unravel_index(  # of cells with the same yield the one of most margin
        np.where((state["count"] > 0) & (fit == fit.max()), left, -np.inf).argmax(), fit.shape
    )
    note = say(
        "From red, none may be built, to green, all of them; white where no variant lies. Best at "
        "{one} and {other}.",
        one=say.short(chart.middles[0][best[0]], 3),
        other=say.short(chart.middles[1][best[1]], 3),
    )
    return drawn.figure(title=title, alt=f"{title}. {note}", note=note)


def _mixed(fit: float) -> str:
    """Return a colour between that of what fails and that of what passes, lighter between."""
    ends = GRADED["fail"], "#f4ecd0", GRADED["pass"]
    one, other = (ends[0], ends[1]) if fit < 0.5 else (ends[1], ends[2])
    t = 2 * fit if fit < 0.5 else 2 * fit - 1
    parts = zip(_rgb(one), _rgb(other), strict=True)
    return "#" + "".join(f"{round(p + t * (q - p)):02x}" for p, q in parts)


def _rgb(colour: str) -> tuple[int, int, int]:
    digits = colour.removeprefix("#")
    red, green, blue = (int(digits[k : k + 2], 16) for k in (0, 2, 4))
    return red, green, blue


def parallel(of: Studied, say: Language = EN) -> Figure:
    """Return the first variants as lines across what varies and the smallest margin.

    Of many inputs those are shown that go most with the margin; what fails lies on top.
    """
    state = of.states["first"]
    known = np.isfinite(state["margin"])
    inputs, margin = state["inputs"][known], 100 * state["margin"][known]
    verdict = state["verdict"][known]
    spread = inputs.std(axis=0)
    moves = np.flatnonzero(spread > 0)
    off = (inputs[:, moves] - inputs[:, moves].mean(axis=0)) / spread[moves]
    told = np.abs(off.T @ (margin - margin.mean()))
    moves = np.sort(moves[np.argsort(-told, kind="stable")[:AXES]])
    values = np.column_stack([inputs[:, moves], margin])
    low, high = values.min(axis=0), values.max(axis=0)
    wide = np.where(high > low, high - low, 1.0)
    names = [*(of.drawing.names[k] for k in moves), say("smallest margin [%]")]
    places = np.arange(len(names), dtype=float)
    chart = Chart(
        say=say, x=(-0.3, len(names) - 0.7), y=(-0.06, 1.06), x_label="", y_label="",
        categories=tuple(map(str, range(1, len(names) + 1))), values=False,
    )  # fmt: skip
    for grade in VERDICTS:  # the worst on top
        for row in np.flatnonzero(verdict == VERDICTS.index(grade)):
            x, y = chart.at(places, (values[row] - low) / wide)
            chart.put(svg.path(x, y, stroke=GRADED.get(grade, INK), stroke_width=0.8,
                               stroke_opacity=0.45))  # fmt: skip
    for k, place in enumerate(places.tolist()):
        (x, bottom), (_, top) = chart.spot(place, 0.0), chart.spot(place, 1.0)
        chart.put(svg.line(x, bottom, x, top, stroke=INK, stroke_width=1))
        for y, value in ((bottom + 12, low[k]), (top - 5, high[k])):
            said = say.short(float(value), 4)
            chart.put(svg.text(x, y, said, anchor="middle", font_size=10.5))
    title = say("Variants across what varies")
    note = say(
        "{count} variants, each a line: {axes}.", count=len(values),
        axes=say.list(*(f"{k} {name}" for k, name in enumerate(names, 1))),
    )  # fmt: skip
    return chart.figure(title=title, alt=f"{title}. {note}", note=note)


def front(of: Studied, say: Language = EN) -> Figure:
    """Return the front over its first two goals."""
    state, goals = of.states["pareto"], of.variants.ask.pareto
    titles = {
        "margin": say("smallest margin [%]"), "cost": say("cost"), "mass": say("mass [kg]"),
    }  # fmt: skip
    sign = {"margin": -100.0, "cost": 1.0, "mass": 1.0}
    y, x = (sign[g] * state["goals"][:, k] for k, g in enumerate(goals[:2]))
    chart = Chart(
        say=say, x=bounds(x), y=bounds(y), x_label=titles[goals[1]], y_label=titles[goals[0]]
    )
    for a, b, verdict in zip(x.tolist(), y.tolist(), state["verdict"].tolist(), strict=True):
        px, py = chart.spot(a, b)
        chart.put(svg.circle(px, py, 3.6, fill=GRADED.get(VERDICTS[verdict], INK)))
    title = say("What no other variant beats")
    return chart.figure(title=title, alt=title)


# --------------------------------------------------------------------------- a report


def chapters(of: Studied, say: Language = EN) -> tuple[Chapter, ...]:
    """Return the chapters of a study: what it came to, and its figures."""
    first: list[Block] = [Text(paragraphs=(summary(of, say), *told(of, say)))]
    drawn = tuple(figures(of, say))
    return (
        Chapter(title=say("What the variants come to"), blocks=(*first, *tables(of, say))),
        *(
            (Chapter(title=say("How they scatter"), blocks=(Figures(figures=drawn),)),)
            * bool(drawn)
        ),
    )


def story(of: Studied, *, say: Language, issue: Issue) -> Story:
    """Return a report of a study."""
    say = say.typeset
    low, high = of.interval()
    fit = share(of.yield_, say)
    return Story(
        language=say.code,
        title=of.installed.application.title,
        subtitle=say("Study of {count} variants", count=of.count),
        grade=of.installed.verdict,
        verdict=say("yield {share}", share=fit),
        facts=(
            (say("As it is"), say(of.installed.verdict).upper()),
            (say("May be built"), f"{fit} ({share(low, say, 2)} … {share(high, say, 2)})"),
            (say("Limits"), of.installed.application.profile),
            *signs(issue, say),
        ),
        chapters=chapters(of, say),
        summary=summary(of, say),
        date=issue.date,
    )


# --------------------------------------------------------------------------- for programs


def document(of: Studied) -> dict[str, Any]:
    """Return a study as the document that `cardan study --json` writes."""
    ask, counts, drawn = of.variants.ask, of.states["counts"], of.drawing
    found: dict[str, Any] = {
        "cardan": contract.CONTRACT,
        "application": of.installed.application.title,
        "profile": of.installed.application.profile,
        "verdict_as_it_is": of.installed.verdict,
        "variants": of.count,
        "asked": of.asked,
        "drawn_by_themselves": of.own,
        "points": drawn.points,
        "seed": drawn.seed,
        "inputs": [
            {
                "name": drawn.called(f),
                "as_it_is": drawn.at[f.input],
                "kind": f.spread.kind,
                "values": list(f.spread.values),
                "tolerance": f.tolerance,
            }
            for f in (*drawn.grids, *drawn.factors)
        ],
        "correlated": [
            {"between": [one, other], "correlation": r} for one, other, r in of.variants.correlated
        ],
        "read_anew": list(of.bench.single),
        "shares": of.shares,
        "cannot_exist": int(counts["refused"]),
        "limits": [_limit(of, k) for k in range(len(of.limits))],
        "worst": [
            {
                "variant": int(place),
                "verdict": VERDICTS[int(v)],
                "margin": float(m),
                "limit": of.called[int(k)] if k != NOTHING else None,
                "inputs": dict(zip(drawn.names, inputs.tolist(), strict=True)),
            }
            for place, v, m, k, inputs in _rows(
                of.states["worst"], "place", "verdict", "margin", "limit", "inputs"
            )
        ],
    }
    if ask.yield_:
        found["yield"] = {
            "share": of.yield_,
            "confidence": ask.confidence,
            "clopper_pearson": list(of.interval()),
            "wilson": list(of.interval(exact=False)),
        }
    if "tighter" in of.states:
        passes, error = tighter(of.states["tighter"])
        found["halved_tolerances"] = [
            {"name": drawn.called(f), "yield": float(p), "standard_error": float(e)}
            for f, p, e in zip(_tolerances(of), passes[:, 0], error[:, 0], strict=True)
        ]
    if "sobol" in of.states:
        found["sobol"] = _indices(of)
    if of.variants.ask.rare:
        found["rare"] = [
            {
                "limit": of.called[of.limits.index((r.line, r.limit))],
                "failure": r.failure,
                "ways": len(r.ways),
                "beta": r.first_order.beta if r.first_order else None,
                "first_order": r.first_order.failure
                if r.first_order and not r.first_order.met
                else None,
                "second_order": r.second_order.failure if r.second_order else None,
                "standard_error": r.sampled.error if r.sampled else None,
                "most_likely": dict(zip(drawn.names, r.inputs.tolist(), strict=True)),
            }
            for r in of.rare
        ]
        found["rare_beyond"] = [of.called[of.limits.index((r.line, r.limit))] for r in of.beyond]
    if of.foretold:
        f = of.foretold
        found["foretold"] = {
            "count": f.count,
            "taught": f.taught,
            "yield": f.share,
            "interval": [f.low, f.high],
            "wrongly_failing": f.missed,
            "wrongly_fit": f.praised,
            "of_those_asked": f.plain,
        }
    if "pareto" in of.states:
        found["pareto"] = [
            {
                "variant": int(place),
                "verdict": VERDICTS[int(v)],
                **{
                    g: float(-x if g == "margin" else x)
                    for g, x in zip(ask.pareto, goals, strict=True)
                },
                "inputs": dict(zip(drawn.names, inputs.tolist(), strict=True)),
            }
            for place, v, goals, inputs in _rows(
                of.states["pareto"], "place", "verdict", "goals", "inputs"
            )
        ]
    if of.maps:
        found["maps"] = [
            {
                "over": [drawn.names[k] for k in chart.columns],
                "edges": [list(e) for e in chart.edges],
                "count": state["count"].astype(int).tolist(),
                "yield": (
                    state["passes"] / np.where(state["count"], state["count"], np.nan)
                ).tolist(),
            }
            for chart, state in of.maps
        ]
    return contract.plain(found)


def _rows(state: State, *names: str) -> Iterator[tuple[Any, ...]]:
    yield from zip(*(state[n] for n in names), strict=True)


def _limit(of: Studied, k: int) -> dict[str, Any]:
    (line, limit), counts = of.limits[k], of.states["counts"]
    values, number, q = of.states["values"], len(of.limits), QUANTITIES[limit.quantity]
    grades = (counts["grades"][k] / of.own).tolist()
    return {
        "name": of.called[k],
        "quantity": limit.quantity,
        "line": line,
        "unit": q.unit_name,
        "normal": None if limit.normal is None else limit.normal / q.factor,
        "maximum": None if limit.maximum is None else limit.maximum / q.factor,
        "shares": dict(zip(("pass", "warn", "fail", "no answer"), grades, strict=True)),
        "fails_alone": float(counts["alone"][k] / of.own),
        "least": float(values["least"][k] / q.factor),
        "most": float(values["most"][k] / q.factor),
        "smallest_margin": float(values["least"][number + k]),
        "quantiles": [
            {
                "share": s,
                "value": quantile(values, k, s) / q.factor,
                "margin": quantile(values, number + k, s),
            }
            for s in of.variants.ask.quantiles
        ],
    }


def _indices(of: Studied) -> list[dict[str, Any]]:
    found = sobol(of.states["sobol"])
    titles = ["margin", "may be built", *of.called]
    return [
        {
            "of": title,
            "factors": [
                {
                    "name": of.drawing.called(f),
                    "tolerance": f.tolerance,
                    "first": float(found.first[c, k]),
                    "first_error": float(found.first_error[c, k]),
                    "total": float(found.total[c, k]),
                    "total_error": float(found.total_error[c, k]),
                }
                for k, f in enumerate(of.drawing.factors)
            ],
        }
        for c, title in enumerate(titles)
        if np.isfinite(found.total[c]).any()
    ]
