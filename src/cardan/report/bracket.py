"""What a bracket study shows: a terminal's table, the JSON contract, VTK files, a picture."""

import base64
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from textwrap import wrap
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from cardan.base.arrays import FloatArray
from cardan.base.errors import NotInstalled
from cardan.base.part import Occasion, Part
from cardan.base.units import MPa, N, hour, kN, mm, rpm
from cardan.base.verdict import Check
from cardan.bracket.gauges import Recovered
from cardan.bracket.refine import UNSETTLED
from cardan.bracket.stress import superpose, von_mises
from cardan.bracket.unit import UNITS
from cardan.files.metals import key_of
from cardan.loads.cycle import major_axis
from cardan.model.bracket import Bolts, BracketRecording, StepShape, usual_preload
from cardan.report.contract import CONTRACT, check, coverage, operating_point, plain
from cardan.report.language import EN, Language
from cardan.report.screen import WIDTH, folded, table
from cardan.report.terminal import BOLD, PLAIN, checks, summary, without_answer
from cardan.report.wording import cited, curve, unanswered
from cardan.study.approval import Approval
from cardan.study.bracket import CONTACT, BracketAnswer
from cardan.study.bracket_contact import APART, EASED, InBolts
from cardan.study.bracket_forced import FIRM, Forced
from cardan.study.bracket_judge import Case, Found, Judged, Outcome
from cardan.study.bracket_life import Endured, strengths
from cardan.study.finding import BRACKET

MICRO = 1e-6
_SMALL = 0.1
"""Share of a bracket's size its seat may move by before small strains mean nothing."""
_HOLE = 11 * mm
"""Of an M10, where a file draws the holes itself."""
SHOWN = 8
"""Cases that tables show; the contract has all."""
DECADES = 1e-6
"""Share of the largest damage that the map's colours reach down to."""
MARKED = 4
"""Features a picture marks."""
LONG = 1e6
"""Hours beyond which a life is not told in figures."""
SETTLED = 0.05
"""Share of a stress its error may be, before a report says that it is not known."""


# --------------------------------------------------------------------------- terminal


def terminal(approval: Approval, say: Language = EN, *, width: int = WIDTH) -> Iterator[str]:
    """Yield the verdict and a bracket's numbers, for a screen of a width."""
    of: BracketAnswer = approval.of(BRACKET)
    bracket = of.bracket
    yield from folded(verdict(approval, say, width=width), width)
    yield ""
    yield from _bold(heading(of, say), width)
    material, source = bracket.material.name, cited(bracket.material.source, say)
    yield from folded(
        [say("material {material}, {source}", material=material, source=source)], width
    )
    yield ""
    yield from _numbers(
        ("", *(say(v.name) for v in of.variants)),
        [(label, *map(say.number, values)) for label, values in _rows(of, say)],
        width,
    )
    yield from folded((pasted(v, say) for v in of.variants), width)
    for v in of.variants:
        yield from folded([*crossed(v, say), *response(v, say), *remarks(of, v, say)], width)
    for v in of.variants:
        yield from _features(of, v, say, width)
        yield from _stresses(v, say, width)
        yield from _readings(v, [gauge.name for gauge in of.bracket.gauges], say, width)
        yield from _lives(of, v, say, width)
    if len(of.variants) > 1:
        yield from _compared(of, say, width)


def _bold(line: str, width: int) -> Iterator[str]:
    return (f"{BOLD}{part}{PLAIN}" for part in folded([line], width))


def _numbers(
    head: tuple[str, ...], rows: Sequence[tuple[str, ...]], width: int, *, words: int = 1
) -> Iterator[str]:
    """Yield a table whose columns beyond the first `words` are numbers."""
    return table(head, rows, width, right=range(words, len(head)))


def verdict(approval: Approval, say: Language = EN, *, width: int = WIDTH) -> Iterator[str]:
    """Yield the verdict, each limit where it is worst, and what has no answer."""
    yield from summary(approval, say)
    yield say("limits: {profile}", profile=approval.application.profile)
    yield from checks(approval, say, width=width)
    yield from folded(parted(approval.of(BRACKET), approval.checks, say), width)
    yield from without_answer(unanswered(approval, say), approval.coverage, say)


def heading(of: BracketAnswer, say: Language = EN) -> str:
    """Return which bracket it is about."""
    return say(
        "{title}: bracket of line {line}, bearing {bearing}",
        title=of.title, line=of.bracket.line, bearing=of.bracket.bearing,
    )  # fmt: skip


def pasted(v: Judged, say: Language = EN) -> str:
    """Return how a centre bearing of an application file says a bracket, as a line feels it."""
    stiff = ", ".join(f"{1 / v.compliance[k, k] / (N / mm):.4g}" for k in range(3))
    told = say(
        "{name}: for cardan check the centre bearing may say  {key}",
        name=say(v.name), key=f"bracket: {{stiffness_N_mm: [{stiff}]}}",
    )  # fmt: skip
    share = say.short(100 * float(v.solved.sliding.too_stiff.max()), 2)
    return f"{told}  ({say('its elements are too stiff, by {share} % at most', share=share)})"


def _rows(of: BracketAnswer, say: Language) -> Iterator[tuple[str, list[float]]]:
    """Yield what is known of the variants themselves, under no load case."""
    yield say("mass, kg"), [v.mass for v in of.variants]
    yield say("unknowns"), [float(v.solved.unknowns) for v in of.variants]
    for k, axis in enumerate("xyz"):
        stiff = [float(1 / v.compliance[k, k]) / (N / mm) for v in of.variants]
        yield say("stiffness at the bearing along {axis}, N/mm", axis=axis), stiff
        firm = [float(1 / v.solved.clamped.compliance[k, k]) / (N / mm) for v in of.variants]
        yield say("   with the flange clamped, N/mm"), firm
    for k in range(len(of.variants[0].carried)):
        loaded = [float(v.carried[k]) for v in of.variants]
        yield say("frequency {mode}, loaded, Hz", mode=k + 1), loaded
    alone = [float(v.frequencies[0]) for v in of.variants]
    yield say("first frequency by itself, Hz"), alone


def crossed(v: Judged, say: Language) -> Iterator[str]:
    """Yield for each order where it meets natural frequencies."""
    met = [c for c in v.crossings if c.in_range]
    if not met:
        yield say(
            "{name}: loaded, without the line, no order 1, 2 or 4 meets a natural frequency within "
            "the speed range.",
            name=say(v.name),
        )
    for order in dict.fromkeys(c.order for c in met):
        mine = [c for c in met if c.order == order]
        yield say(
            "{name}: loaded, without the line, order {order} meets {frequencies} Hz at {speeds} "
            "rpm.",
            name=say(v.name), order=order,
            frequencies=say.list(*(say.number(c.frequency) for c in mine)),
            speeds=say.list(*(say.number(c.speed / rpm) for c in mine)),
        )  # fmt: skip


def response(v: Judged, say: Language = EN) -> Iterator[str]:
    """Yield how the line swings on rubber and bracket, and where that stresses most."""
    if v.forced is None:
        yield say(
            "{name}: loads are quasi-static. The response over speed needs the rubber of the "
            "bearing (rubber_N_mm of the bracket, or the bearing's stiffness) and a tube of each "
            "shaft.", name=say(v.name),
        )  # fmt: skip
        return
    of = v.forced.swept
    low = [
        f"{say(name)} {say.number(float(f))} Hz"
        for name, f in zip(of.names, of.frequencies, strict=True)
    ]
    told = low[: 1 + next((k for k, n in enumerate(of.names) if n == "bracket"), len(low))]
    yield say(
        "{name}: on rubber and bracket the line swings at {list}.",
        name=say(v.name), list=say.list(*told),
    )  # fmt: skip
    c, q, k = v.forced.worst
    yield say(
        "{name}: order 2 and up stress {part} by ± {stress} MPa at {speed} rpm, {state}, {gear}; "
        "in a rigid bracket by at most {rigid}.",
        name=say(v.name), part=say.part(v.features[k].part),
        stress=say.number(float(v.forced.stress[c, q, k]) / MPa),
        speed=say.short(round(float(of.speed[q]) / rpm)), state=say.state(of.state),
        gear=curve(of, c, say), rigid=say.number(float(np.nanmax(v.forced.rigid[..., k])) / MPa),
    )  # fmt: skip


def remarks(of: BracketAnswer, v: Judged, say: Language = EN) -> Iterator[str]:
    """Yield what a reader must know of how a variant was solved, and what was read from it."""
    if v.solved.fillet:
        drawn, taken = (say.number(r / mm) for r in v.solved.fillet)
        yield say(
            "{name}: solved with a fillet of {taken} mm; the CAD kernel breaks on the {drawn} mm "
            "drawn.", name=say(v.name), taken=taken, drawn=drawn,
        )  # fmt: skip
    for p in v.solved.found:
        area = say.number(p.area / mm**2)
        faces = say.count("{count} face", "{count} faces", p.faces)
        if p.radius:
            yield say(
                "{name}: {pick} is a bore of {radius} mm radius, {faces}, {area} mm².",
                name=say(v.name), pick=p.name, radius=say.number(p.radius / mm), faces=faces,
                area=area,
            )  # fmt: skip
        else:
            yield say(
                "{name}: {pick} is {faces}, {area} mm².",
                name=say(v.name), pick=p.name, faces=faces, area=area,
            )  # fmt: skip
    for axis, k, given in zip("zy", (2, 1), of.series or (), strict=False):
        own = 1 / v.compliance[k, k]
        if given > own * FIRM / (1 + FIRM):
            yield say(
                "{name}: the bearing's stiffness_N_mm, of rubber and bracket in series, is {given} "
                "N/mm along {axis}, and the bracket alone gives {own}: its rubber is taken as "
                "rigid that way.",
                name=say(v.name), axis=axis, given=say.number(given / (N / mm)),
                own=say.number(own / (N / mm)),
            )  # fmt: skip
    for one, found in _read_back(of, v):
        x, y, z = (say.number(n) for n in found.noise)
        means = (
            "{name}: the forces of {recording} were read from gauges; a microstrain of noise is "
            "{x} N along x, {y} along y and {z} along z, and how much of what they read no force "
            "explains is not known here (condition {condition})."
            if one.strain is None
            else "{name}: the forces of {recording} are read from gauges; a microstrain of noise "
            "is {x} N along x, {y} along y and {z} along z, and {left} microstrain of what they "
            "read no force explains (condition {condition})."
        )
        yield say(
            means, name=say(v.name), recording=one.name, x=x, y=y, z=z,
            condition=say.number(found.condition), left=say.number(1e6 * _size(found.residual)),
        )  # fmt: skip
        x, y, z = (say.number(n) for n in found.off)
        yield say(
            "{name}: where they are largest, those forces may be off by {x} N along x, {y} along y "
            "and {z} along z: by the mesh, by where and how gauges are glued and 1 % of what they "
            "read, or by what no force explains where that is more.",
            name=say(v.name), x=x, y=y, z=z,
        )  # fmt: skip


def _read_back(of: BracketAnswer, v: Judged) -> Iterator[tuple[BracketRecording, Recovered]]:
    """Yield the recordings whose forces are read from gauges."""
    known = {o.case.name: o.case.read for o in v.outcomes}
    for one in of.bracket.recordings:
        if (read := known.get(one.name)) is not None:
            yield one, read


def _size(residual: FloatArray) -> float:
    """Return the root mean square of what is left at each moment (t,)."""
    return float(np.sqrt((residual**2).mean()))


def used(v: Judged) -> FloatArray:
    """Return the largest use of its zone's fatigue limit by each feature; nan without any."""
    every = np.array([o.used for o in v.outcomes])
    return np.where(np.isnan(every).all(axis=0), np.nan, np.fmax.reduce(every, axis=0))


def highest(v: Judged) -> tuple[FloatArray, list[Outcome]]:
    """Return the highest stress (features,) Pa of each feature, and the case it is of."""
    every = np.array([o.hot for o in v.outcomes])
    return every.max(axis=0), [v.outcomes[k] for k in every.argmax(axis=0).tolist()]


def hours_of(v: Judged) -> FloatArray:
    """Return the hours (features,) to failure: the worst state of the duty cycle, or recording."""
    if not v.lasting:
        return np.full(len(v.features), np.nan)
    rate = np.max([e.spots / e.duration for e in v.lasting], axis=0)
    with np.errstate(divide="ignore"):
        return 1 / (rate * hour)


def lies(say: Language) -> str:
    """Return by what a life lies between the hours in brackets, and by what it may not."""
    return say(
        "Hours in brackets: by the error of stresses, by the flange held the kinder way, and by "
        "what gauges read wrong where forces are read from them. Curve, rubber and other loads are "
        "taken to be right."
    )


def hours_within(v: Judged) -> FloatArray:
    """Return between what hours (features, 2) each feature's life lies by its stress's error."""
    each = [[e.at([k]).hours_within for k in range(len(v.features))] for e in v.lasting]
    return np.min(each, axis=0) if each else np.full((len(v.features), 2), np.nan)


def hours(value: float, say: Language, within: Iterable[float] = (np.nan, np.nan)) -> str:
    """Return hours to failure; beyond a million nobody knows, and nobody drives.

    In brackets between what they lie, where that is known.
    """
    if np.isnan(value):
        return "-"
    told = f"> {say.number(LONG)}" if value > LONG else _three(value, say)
    low, high = within
    if np.isnan(low) or low > LONG:
        return told
    ends = _three(low, say), "∞" if high > LONG else _three(high, say)
    return f"{told}\N{NO-BREAK SPACE}({ends[0]}…{ends[1]})"


def _three(value: float, say: Language) -> str:
    """Return hours to three digits, thousands of them written out."""
    told = f"{value:.3g}"
    return f"{float(told):.0f}" if "e+" in told else say.pointed(told)


def _features(of: BracketAnswer, v: Judged, say: Language, width: int) -> Iterator[str]:
    """Yield where a crack may start: each feature's stress, use of its limit, life."""
    yield ""
    yield from _bold(say("{name}, where a crack may start", name=say(v.name)), width)
    head = ("", say("at x, y, z [mm]"), "MPa ", say("fatigue use"), say("hours"))
    stress, _ = highest(v)
    share, lasts, within = used(v), hours_of(v), hours_within(v)
    rows: list[tuple[str, ...]] = []
    for k, f in enumerate(v.shown):
        at = "  ".join(f"{round(p / mm)}" for p in f.point)
        error = f"{f.error * stress[k] / MPa:.1f}"
        told = f"{stress[k] / MPa:.1f} ±{error:>5}{' ' if f.error <= SETTLED else '!'}"
        use = "-" if np.isnan(share[k]) else f"{100 * share[k]:.0f} %"
        life = hours(float(lasts[k]), say, within[k])
        rows.append((say.part(f.part), at, say.pointed(told), use, life))
    yield from _numbers(head, rows, width)
    left = len(v.features) - v.listed
    if left:
        more = say("and {count} more, each less worn and less stressed: --json", count=left)
        yield from folded([f"  {more}"], width)
    means = say(
        "± is the estimated error (! above 5 %). Toes and borders: structural stress, carried on "
        "from 0.4 and 1.0 thicknesses away; the worse of a sliding and a clamped flange."
    )
    if v.lasting and not v.duty:
        means += " " + say("Hours: of the recording that wears it most, driven on and on.")
    yield from folded([f"  {means}"], width)
    for what in (*in_contact(v, say), *vague(v, say), *untold(of, v, say)):
        yield from folded([f"  {what}"], width)


def vague(v: Judged, say: Language) -> Iterator[str]:
    """Yield which places shown are known to more than a quarter only, and what tells more."""
    if parts := [say.part(f.part) for f in v.shown if f.error > UNSETTLED]:
        yield say(
            "{parts}: known to more than a quarter only; two thirds of the present `element_mm` "
            "(left out, one and a half thicknesses) tell it better.", parts=", ".join(parts),
        )  # fmt: skip


def parted(of: BracketAnswer, found: Iterable[Check], say: Language) -> Iterator[str]:
    """Yield how contact is asked for, where the two ways of holding part a verdict or a life."""
    if not any(CONTACT in c.settled_by for c in found):
        return
    shape = of.bracket.shape
    hole = _HOLE if isinstance(shape, StepShape) else shape.bolt_diameter
    usual = Bolts(preload=usual_preload(hole))
    yield say(
        "Held the kinder of the two ways, sliding or clamped, the flange has another verdict, or a "
        "life several times as long. In contact with the frame it has one answer, whose stress may "
        "be {share} % lower at most: write `{key}` in `bracket`, with what your bolts have.",
        share=f"{100 * (1 - EASED):.0f}",
        key=f"bolts: {{preload_kN: {usual.preload / kN:.2g}, friction: {usual.friction}}}",
    )  # fmt: skip


def in_contact(v: Judged, say: Language) -> Iterator[str]:
    """Yield what contact made of fatigue and life, where that was asked."""
    if v.in_bolts is not None and v.in_bolts.when is not None:
        yield _in_bolts(v, v.in_bolts, v.in_bolts.when, say)
    yield from slipped(v, say)


def slipped(v: Judged, say: Language) -> Iterator[str]:
    """Yield under which cases, and over which duty cycle, the bolts slip or open."""
    if slip := [say.occasion(s.when) for s in v.slips if s.share > 1]:
        yield say(
            "{cases}: the bolts slip or open. What is told of it is that of a flange that holds.",
            cases=say.list(*slip),
        )  # fmt: skip


def _in_bolts(v: Judged, of: InBolts, when: Occasion, say: Language) -> str:
    """Return what contact made of fatigue and life, beside the two ways the flange is held."""
    use = next(o.used for o in v.outcomes if o.case.when == when)
    k, f = int(np.nanargmax(of.told)), int(np.nanargmax(use))
    told = say(
        "In bolts of {preload} kN, with contact and a friction of {friction}, {case} uses "
        "{share} % of the fatigue limit, at {part}; by the worse of a sliding and a clamped flange "
        "{more} %, at {other}. Fatigue and life are those in contact, with the worse of a hard "
        "frame and one that gives as thick steel does, and {added} % more, as far as it may be "
        "wrong; "
        "stresses are not.",
        preload=say.number(of.bolts.preload / kN), friction=say.number(of.bolts.friction),
        added=f"{100 * APART:.0f}",
        case=say.occasion(when), share=f"{100 * use[f]:.0f}",
        part=say.part(v.features[f].part), more=f"{100 * of.told[k]:.0f}",
        other=say.part(v.features[k].part),
    )  # fmt: skip
    if np.isnan(of.life_told):
        return told
    return told + " " + say("Life by those: {hours} h.", hours=hours(of.life_told, say))


def telling_cases(v: Judged) -> list[Outcome]:
    """Return the cases a table shows: those of the highest stress."""
    return sorted(v.outcomes, key=lambda o: -o.von_mises.value)[:SHOWN]


def _stresses(v: Judged, say: Language, width: int) -> Iterator[str]:
    """Yield the highest stresses of one variant, case by case."""

    def one(value: float) -> str:
        return say.pointed(f"{value / MPa:.1f}")

    yield ""
    yield from _bold(say("{name}, {unit}", name=say(v.name), unit="MPa"), width)
    head = ("", say("worst at"), "von Mises", say("tension"), say("compression"))
    rows = [
        (
            say.occasion(o.case.when), say.part(v.features[int(o.hot.argmax())].part),
            *(one(f.value) for f in (o.von_mises, o.highest, o.lowest)),
        )
        for o in telling_cases(v)
    ]  # fmt: skip
    yield from _numbers(head, rows, width, words=2)
    left = len(v.outcomes) - SHOWN
    if left > 0:
        milder = say.count("and {count} milder case", "and {count} milder cases", left)
        yield f"  {milder}: --json"
    for told in (*pulled_off(v, say), *bent_far(v, say)):
        yield from folded([f"  {told}"], width)


def pulled_off(v: Judged, say: Language) -> Iterator[str]:
    """Yield of which cases shown the two ways to be held have the truth not between them."""
    cases = [say.occasion(o.case.when) for o in telling_cases(v) if o.pulls_off]
    if cases:
        yield say(
            "Pulled straight off the frame: {cases}. Bolts that give make a flange softer than the "
            "softer way it is held: by 11 % on a U of 6 mm beside contact, with a seventh more "
            "stress in a cut edge beside its washers.",
            cases=say.list(*cases),
        )
        if v.in_bolts is None:
            yield say("With `bolts` what swings is judged in contact.")


def bent_far(v: Judged, say: Language) -> Iterator[str]:
    """Yield which cases move the seat by more than small strains can mean."""
    size = float(np.ptp(v.solved.nodes.points, axis=0).max())
    if far := [o for o in v.outcomes if o.motion > _SMALL * size]:
        worst = max(far, key=lambda o: o.motion)
        yield say(
            "{case} moves the bearing's seat by {motion} mm, of a bracket {size} mm large: linear "
            "elasticity means nothing there. Look at its loads.",
            case=say.occasion(worst.case.when), motion=say.number(worst.motion / mm),
            size=f"{size / mm:.0f}",
        )  # fmt: skip


def _readings(v: Judged, names: list[str], say: Language, width: int) -> Iterator[str]:
    """Yield what the gauges read."""
    if not names:
        return
    yield ""
    yield from _bold(say("{name}, {unit}", name=say(v.name), unit=say("microstrain")), width)
    rows = [
        (say("per kN of {load}", load=unit), *(say.number(b * kN / MICRO) for b in column))
        for unit, column in zip(UNITS[:3], v.influence.T, strict=False)
    ]
    for o in telling_cases(v):
        spans = (say.pointed(span(low / MICRO, high / MICRO)) for low, high in o.strain.tolist())
        rows.append((say.occasion(o.case.when), *spans))
    yield from _numbers(("", *names), rows, width)
    change = v.solved.influence_change
    floor = change * float(np.abs(v.influence[:, :3]).max()) * kN / MICRO
    said = say(
        "Refining changes the gauges' influence by {change} % of the largest at most, {floor} "
        "microstrain per kN: what reads less than that may be nothing.",
        change=say.pointed(f"{100 * change:.1f}"), floor=say.pointed(f"{floor:.2g}"),
    )  # fmt: skip
    yield from folded([f"  {said}"], width)


def lives(v: Judged) -> list[Endured]:
    """Return what fatigue does to a variant: cases that repeat, then the duty cycle."""
    return [o.life for o in v.outcomes if o.life is not None] + list(v.duty)


def worn(v: Judged) -> list[Endured]:
    """Return the duty cycle, and the cases that wear most: what a table shows.

    Cases of a state of which the table says the same are one, told as the last of them that the
    state has: order 2 is combined with a mean that may add nothing.
    """
    alike: dict[tuple[Any, ...], Endured] = {}
    for e in (o.life for o in v.outcomes if o.life is not None):
        told = (e.per_turn, e.per_hour, e.hours, *e.hours_within)
        worst = int(np.nanargmax(e.spots)) if e.worst > 0 else None
        alike[e.when.name, worst, *(f"{x:.3g}" for x in told)] = e
    return [*v.duty, *sorted(alike.values(), key=lambda e: e.hours)[:SHOWN]]


def _lives(of: BracketAnswer, v: Judged, say: Language, width: int) -> Iterator[str]:
    """Yield damage and life of one variant; nothing without an S-N curve."""
    if not lives(v):
        return
    yield ""
    yield from _bold(say("{name}, {unit}", name=say(v.name), unit=say("damage")), width)
    rows: list[tuple[str, ...]] = []
    for e in worn(v):
        where = say.part(v.features[int(np.nanargmax(e.spots))].part) if e.worst > 0 else ""
        told = (
            _small(e.per_turn, say),
            _small(e.per_hour, say),
            hours(e.hours, say, e.hours_within),
        )
        rows.append((say.occasion(e.when), where, *told))
    yield from _numbers(
        (
            "", say("worst at"), say("damage per turn"), say("damage per hour"),
            say("hours to the first failure"),
        ), rows, width, words=2,
    )  # fmt: skip
    yield from folded([f"  {counted(of, say)} {lies(say)}"], width)


def counted(of: BracketAnswer, say: Language) -> str:
    """Return how damage is counted."""
    material = of.bracket.material
    if not material.ultimate_strength:
        return say("Damage: rainflow and Miner, 2k - 1 beyond the knee, mean stress not counted.")
    if material.metal == "steel":
        return say("Damage: rainflow and Miner, 2k - 1 beyond the knee, mean stress by Goodman.")
    return say(
        "Damage: rainflow and Miner, 2k - 1 beyond the knee, mean stress by Goodman, or by the "
        "FKM guideline where that makes more of it."
    )


def untold(of: BracketAnswer, v: Judged, say: Language) -> Iterator[str]:
    """Yield of which zones nobody knows what they bear, and which a weld's heat makes softer."""
    material, found = of.bracket.material, strengths(of.bracket)
    for zone in dict.fromkeys(f.zone for f in v.features if found and f.zone not in found):
        yield say(
            "{zone}: no code says what it bears of {metal}, so whether it lasts cannot be told: "
            "give {key}.",
            zone=say(zone), metal=say(material.metal), key=f"bracket.fatigue.{key_of(zone)}",
        )  # fmt: skip
    if any(f.beside_weld for f in v.features):
        beside = material.yield_beside_weld
        yield (
            say("Beside a weld {material} yields at {stress} MPa: its heat reaches 20 to 40 mm.",
                material=material.name, stress=say.number(beside / MPa))
            if beside
            else say("The heat of a weld makes {material} softer, 20 to 40 mm around it, and "
                     "nobody says by how much: give its welded_yield_MPa.", material=material.name)
        )  # fmt: skip


def _small(value: float, say: Language) -> str:
    """Return a damage or a life: both range over many powers of ten."""
    if np.isnan(value) or value > 1e9:
        return say.number(value)
    return say.pointed(f"{value:.3g}")


def span(low: float, high: float) -> str:
    """Return a smallest and a largest number as a span, or one number where they are one."""
    same = abs(high - low) <= 1e-6 * max(abs(low), abs(high))
    return f"{high:.1f}" if same else f"{low:.1f} … {high:.1f}"


def worst_use(of: BracketAnswer, say: Language) -> str:
    """Return what the largest use of the fatigue limit is called: of all zones, or those known."""
    if any(np.isnan(used(v)).any() for v in of.variants):
        return say("use of the fatigue limit, worst zone known, %")
    return say("use of the fatigue limit, worst zone, %")


def _compared(of: BracketAnswer, say: Language, width: int) -> Iterator[str]:
    """Yield what the reinforcement changes."""
    before, after = of.variants[0], of.variants[1]
    yield ""
    yield from _bold(say("What the reinforcement changes"), width)
    old, new = float(before.worst.hot.max()), float(after.worst.hot.max())
    changed = [
        (say("highest stress, MPa"), old / MPa, new / MPa),
        (say("mass, kg"), before.mass, after.mass),
        (say("frequency {mode}, loaded, Hz", mode=1), before.carried[0], after.carried[0]),
    ]
    uses = [float(np.nanmax(used(v), initial=0.0)) for v in (before, after)]
    if min(uses) > 0:
        changed.insert(1, (worst_use(of, say), 100 * uses[0], 100 * uses[1]))
    rows = [
        (label, say.number(float(was)), say.number(float(now)), say.percent(float(now / was) - 1))
        for label, was, now in changed
    ]
    if all(known(hours_of(v)) for v in (before, after)):
        was, now = (first_hours(v, say) for v in (before, after))
        rows.insert(1, (say("hours to the first failure"), was, now, ""))
    yield from _numbers(("", say(before.name), say(after.name), ""), rows, width)
    yield from folded([better(before, after, say)], width)


def better(before: Judged, after: Judged, say: Language = EN) -> str:
    """Return whether a variant is better, which it is only where its worst zone is.

    By life over the duty cycle or under what was recorded, else by the use of the fatigue limit,
    else by stress. Nobody knows where a zone that no curve is known of is stressed no less.
    """
    lasts, uses = ([f(v) for v in (before, after)] for f in (hours_of, used))
    if all(known(x) for x in lasts):
        was, now = (float(np.nanmin(x)) for x in lasts)
        gain, worst = now > was, int(np.nanargmin(lasts[1]))
        ends = {"was": first_hours(before, say), "now": first_hours(after, say)}
        what = say("{was} h before, {now} h after", **ends)
    elif all(known(x) for x in uses):
        was, now = (float(np.nanmax(x)) for x in uses)
        gain, worst = now < was, int(np.nanargmax(uses[1]))
        what = say(
            "{was} % of the fatigue limit before, {now} % after",
            was=say.number(100 * was), now=say.number(100 * now),
        )  # fmt: skip
    else:
        stress = highest(after)[0]
        was, now = (float(v.worst.hot.max()) / MPa for v in (before, after))
        gain, worst = now < was, int(stress.argmax())
        what = say("{was} MPa before, {now} MPa after", was=say.number(was), now=say.number(now))
    told = {"what": what, "part": say.part(after.features[worst].part)}
    if not gain:
        found = say("At its worst zone the variant is not better: {what} ({part}).", **told)
    elif (part := _unknown(before, after)) is not None:
        found = say(
            "Whether the variant is better cannot be told: nobody knows what its {other} bears, "
            "stressed no less than before. At the worst zone that is known: {what} ({part}).",
            other=say.part(part), **told,
        )  # fmt: skip
    else:
        found = say("At its worst zone the variant is better: {what} ({part}).", **told)
    return found + " " + say("Limits are asked of the original: the variant has no verdict.")


def known(values: FloatArray) -> bool:
    """Return whether any of some features' values is known."""
    return not np.isnan(values).all()


def first_hours(v: Judged, say: Language) -> str:
    """Return the hours to the first failure of what is known, and between what they lie."""
    within = np.min([e.hours_within for e in v.lasting], axis=0)
    return hours(float(np.nanmin(hours_of(v))), say, within)


def _unknown(before: Judged, after: Judged) -> Part | None:
    """Return what is stressed no less than its zone was, and bears what nobody knows; else None."""
    use = used(after)
    if not known(use):
        return None
    stress, old = highest(after)[0], highest(before)[0]
    for k in np.argsort(-stress).tolist():
        zone = after.features[k].zone
        was = max(
            (s for s, f in zip(old, before.features, strict=True) if f.zone == zone), default=0
        )
        if np.isnan(use[k]) and stress[k] > 0 and stress[k] >= was:
            return after.features[k].part
    return None


# --------------------------------------------------------------------------- contract


def contract(approval: Approval) -> dict[str, Any]:
    """Return a bracket study as the JSON contract's document."""
    of: BracketAnswer = approval.of(BRACKET)
    bracket = of.bracket
    return plain(
        {
            "cardan": CONTRACT,
            "application": of.title,
            "verdict": approval.verdict,
            "profile": approval.application.profile,
            "checks": [check(c) for c in approval.checks],
            "coverage": coverage(approval.coverage),
            "line": bracket.line,
            "bearing": bracket.bearing,
            "material": bracket.material.name,
            "metal": bracket.material.metal,
            "bears": {
                zone: {
                    "detail": one.name or None,
                    "amplitude_MPa": one.curve.amplitude / MPa,
                    "cycles": one.curve.cycles,
                    "slope": one.curve.slope,
                }
                for zone, one in strengths(bracket).items()
            },
            "carried_mass_kg": bracket.carried_mass,
            "top_speed_rpm": of.top_speed / rpm if np.isfinite(of.top_speed) else None,
            "variants": [_variant(of, v) for v in of.variants],
        }
    )


def _variant(of: BracketAnswer, v: Judged) -> dict[str, Any]:
    stress, _ = highest(v)
    share, lasts, within = used(v), hours_of(v), hours_within(v)
    asks = {s.when: s.share for s in v.riding}
    return {
        "name": v.name,
        "mass_kg": v.mass,
        "elements": len(v.solved.nodes.elements),
        "unknowns": v.solved.unknowns,
        "meshes": v.solved.meshes,
        "fillet_mm": (
            {"drawn": v.solved.fillet[0] / mm, "solved": v.solved.fillet[1] / mm}
            if v.solved.fillet
            else None
        ),
        "stiffness_N_mm": [float(1 / v.compliance[k, k] / (N / mm)) for k in range(3)],
        "stiffness_clamped_N_mm": [
            float(1 / v.solved.clamped.compliance[k, k] / (N / mm)) for k in range(3)
        ],
        "read_back": [
            {
                "recording": one.name,
                "noise_N": found.noise.tolist(),
                "error_N": found.off.tolist(),
                "condition": found.condition,
                "flange": None if one.strain is None else found.flange,
                "unexplained_microstrain": (
                    None if one.strain is None else 1e6 * _size(found.residual)
                ),
            }
            for one, found in _read_back(of, v)
        ],
        "stiffness_too_high": v.solved.sliding.too_stiff.tolist(),
        "frequencies_Hz": v.frequencies.tolist(),
        "frequencies_too_high": v.solved.sliding.too_high.tolist(),
        "frequencies_loaded_Hz": v.carried.tolist(),
        "frequencies_loaded_clamped_Hz": v.solved.clamped.carried.tolist(),
        "crossings": [
            {
                "mode": c.mode,
                "frequency_Hz": c.frequency,
                "order": c.order,
                "speed_rpm": c.speed / rpm,
                "in_range": c.in_range,
            }
            for c in v.crossings
        ],
        "hot_spots": [
            {
                "name": f"H{k + 1}",
                "zone": f.zone,
                "number": f.number,
                "point_mm": [x / mm for x in f.point],
                "von_mises_MPa": stress[k] / MPa,
                "error_MPa": f.error * stress[k] / MPa,
                "fatigue_utilisation": None if np.isnan(share[k]) else share[k],
                "life_hours": lasts[k] if np.isfinite(lasts[k]) else None,
                "life_hours_within": [x if np.isfinite(x) else None for x in within[k].tolist()],
                "beside_weld": f.beside_weld,
            }
            for k, f in enumerate(v.features)
        ],
        "contact": None
        if v.in_bolts is None
        else {
            "preload_N": v.in_bolts.bolts.preload,
            "friction": v.in_bolts.bolts.friction,
            "case": None if v.in_bolts.when is None else EN.occasion(v.in_bolts.when),
            "swing_over_held": [None if np.isnan(x) else x for x in v.in_bolts.times.tolist()],
            "fatigue_utilisation_held": [
                None if np.isnan(x) else x for x in v.in_bolts.told.tolist()
            ],
            "life_hours_held": (
                v.in_bolts.life_told if np.isfinite(v.in_bolts.life_told) else None
            ),
        },
        "unit_loads": list(UNITS),
        "gauges": [
            {
                "name": gauge.name,
                "point_mm": [x / mm for x in gauge.point],
                "direction": list(gauge.direction),
                "length_mm": gauge.length / mm,
                "microstrain_per_unit": (row / MICRO).tolist(),
            }
            for gauge, row in zip(of.bracket.gauges, v.influence, strict=True)
        ],
        "response": None if v.forced is None else _response(v.forced),
        "cases": [_case(of, o) for o in v.outcomes],
        "duty": [
            _life(of, e) | ({"slip_utilisation": asks[e.when]} if e.when in asks else {})
            for e in v.duty
        ],
    }


def _response(of: Forced) -> dict[str, Any]:
    def known(values: FloatArray) -> list[float | None]:
        return [None if np.isnan(x) else x for x in values.tolist()]

    swept = of.swept
    return {
        "state": swept.state,
        "modes": [
            {"name": name, "frequency_Hz": f, "damping_ratio": d}
            for name, f, d in zip(swept.names, swept.frequencies, swept.damping, strict=True)
        ],
        "speed_rpm": (swept.speed / rpm).tolist(),
        "curves": [
            {
                "gear": swept.gears[c],
                "direction": swept.directions[c],
                "torque_Nm": known(swept.torque[c]),
                "force_N": known(major_axis(swept.waves[c]).sum(-1)),
                "force_rigid_N": known(major_axis(swept.rigid[c]).sum(-1)),
                "stress_MPa": [known(x / MPa) for x in of.stress[c].T],
                "stress_rigid_MPa": [known(x / MPa) for x in of.rigid[c].T],
            }
            for c in range(len(swept.gears))
        ],
    }


def _life(of: BracketAnswer, e: Endured) -> dict[str, Any]:
    def known(value: float) -> float | None:
        return value if np.isfinite(value) else None

    return {
        "name": str(e.when),
        "turns": known(e.turns),
        "duration_s": known(e.duration),
        "hot_spots": list(map(known, e.spots.tolist())),
        "gauges": dict(zip((g.name for g in of.bracket.gauges), e.gauges.tolist(), strict=True)),
        "per_turn": known(e.per_turn),
        "per_hour": known(e.per_hour),
        "life_hours": known(e.hours),
        "life_hours_within": [known(x) for x in e.hours_within],
        "life_hours_kinder": known(e.hours_kinder),
    }


def _case(of: BracketAnswer, o: Outcome) -> dict[str, Any]:
    def found(f: Found) -> dict[str, Any]:
        return {"value_MPa": f.value / MPa, "point_mm": [x / mm for x in f.point]}

    return {
        "name": str(o.case.when),
        **({"point": operating_point(o.case.point)} if o.case.point else {}),
        "von_mises": found(o.von_mises),
        "max_principal": found(o.highest),
        "min_principal": found(o.lowest),
        "pulls_off": o.pulls_off,
        **({} if np.isnan(o.slips) else {"slip_utilisation": o.slips}),
        **({} if o.times is None else {"swing_over_held": o.times.tolist()}),
        "von_mises_on_edge": found(o.on_edge),
        "hot_spots": [
            {
                "von_mises_MPa": h / MPa,
                "error_MPa": e / MPa,
                "settled": bool(e <= SETTLED * h),
                "mean_MPa": m / MPa,
                "amplitude_MPa": a / MPa,
            }
            for h, e, m, a in zip(
                o.hot.tolist(), o.error.tolist(), o.mean.tolist(), o.amplitude.tolist(), strict=True
            )
        ],
        "gauges": {
            gauge.name: {"min_microstrain": low / MICRO, "max_microstrain": high / MICRO}
            for gauge, (low, high) in zip(of.bracket.gauges, o.strain.tolist(), strict=True)
        },
        "bolts_N": o.bolts.tolist(),
        "motion_mm": o.motion / mm,
        "damage": _life(of, o.life) if o.life is not None else None,
    }


# --------------------------------------------------------------------------- fields


def peak_fields(v: Judged, o: Outcome) -> tuple[FloatArray, FloatArray]:
    """Return displacement (n, 3) m and von Mises stress (n,) Pa at the nodes, when a case peaks."""
    u, stress = v.solved.displacement, v.solved.stress
    loads = o.case.loads[_peak(v, o)][None]
    return superpose_vectors(u, loads[0]), von_mises(superpose(stress, loads))[:, 0]


def _peak(v: Judged, o: Outcome) -> int:
    """Return the moment at which a case stresses most the place where it stresses most."""
    nodes = v.solved.nodes.surface
    gap = v.solved.nodes.points[nodes] - np.asarray(o.von_mises.point)
    near = nodes[np.linalg.norm(gap, axis=-1).argmin()]
    return int(von_mises(superpose(v.solved.stress[near], o.case.loads)).argmax())


def superpose_vectors(unit: FloatArray, loads: FloatArray) -> FloatArray:
    """Return vectors (n, 3) of loads (9,) from unit vectors (n, 9, 3)."""
    return np.einsum("nux,u->nx", unit, loads)


def vtu(v: Judged, *, said: str = "") -> str:
    """Return a VTK unstructured grid: the mesh with what each case does when it peaks.

    Quadratic tetrahedra; coordinates and displacements in metres, stresses in Pa. `said` is the
    verdict, a field of the whole: the file may be all that is passed on.
    """
    nodes = v.solved.nodes
    count, cells = len(nodes.points), len(nodes.elements)
    fields: list[str] = []
    for o in v.outcomes:
        u, mises = peak_fields(v, o)
        fields.append(_array(f"{o.case.when}: displacement", u.astype("<f4"), components=3))
        fields.append(_array(f"{o.case.when}: von Mises", mises.astype("<f4")))
    unit = superpose(v.solved.stress, v.worst.case.loads[_peak(v, v.worst)][None])[:, 0]
    fields.append(_array(f"{v.worst.case.when}: stress", unit.astype("<f4"), components=6))
    if len(v.damage):
        worn_ = np.zeros(count)
        worn_[nodes.surface] = v.damage
        fields.append(_array("damage of an hour of duty", worn_.astype("<f4")))
    offsets = np.arange(1, cells + 1, dtype="<i8") * 10
    return "\n".join([
        '<?xml version="1.0"?>',
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
        'header_type="UInt64">',
        "<UnstructuredGrid>", *([_told(said)] if said else []),
        f'<Piece NumberOfPoints="{count}" NumberOfCells="{cells}">',
        "<PointData>", *fields, "</PointData>",
        "<Points>", _array("Points", nodes.points.astype("<f8"), components=3), "</Points>",
        "<Cells>",
        _array("connectivity", nodes.elements.astype("<i8")),
        _array("offsets", offsets),
        _array("types", np.full(cells, 24, dtype="u1")),  # VTK_QUADRATIC_TETRA
        "</Cells>",
        "</Piece></UnstructuredGrid></VTKFile>", "",
    ])  # fmt: skip


def _told(said: str) -> str:
    """Return a text as a VTK file has it: the bytes of its letters, and a nought."""
    letters = " ".join(str(b) for b in (*said.encode(), 0))
    return (
        '<FieldData><DataArray type="String" Name="verdict" NumberOfTuples="1" format="ascii">'
        f"{letters}</DataArray></FieldData>"
    )


_VTK_TYPES = {"f4": "Float32", "f8": "Float64", "i8": "Int64", "u1": "UInt8"}


def _array(name: str, values: npt.NDArray[Any], *, components: int = 1) -> str:
    """Return one array of a VTK file: its size, then its bytes, in base 64."""
    from xml.sax.saxutils import quoteattr

    raw = np.ascontiguousarray(values).tobytes()
    data = base64.b64encode(np.uint64(len(raw)).astype("<u8").tobytes() + raw).decode()
    kind = _VTK_TYPES[values.dtype.str[1:]]
    return (
        f'<DataArray type="{kind}" Name={quoteattr(name)} NumberOfComponents="{components}" '
        f'format="binary">{data}</DataArray>'
    )


# --------------------------------------------------------------------------- picture


def picture(
    of: BracketAnswer, path: Path | BinaryIO, *, say: Language = EN, over: str = "",
    under: Case | None = None,
) -> None:  # fmt: skip
    """Draw each variant `under` a case, else the original's worst, by its stress, into a PNG.

    Where a duty cycle is known, the damage it does at every place of the surface: below, or beside
    it where one variant is all there is, which leaves no page of a document half empty.

    `over` stands above them: the verdict, where no page around the picture tells it.

    Raises
    ------
    NotInstalled
        Without matplotlib.
    """
    try:
        from matplotlib import colormaps
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.cm import ScalarMappable
        from matplotlib.collections import PolyCollection
        from matplotlib.colors import LogNorm, Normalize
        from matplotlib.figure import Figure
    except ImportError as error:
        msg = 'a picture needs matplotlib: pip install "cardan[bracket]"'
        raise NotInstalled(msg) from error

    case = of.variants[0].worst.case.when if under is None else under.when
    shown = [next(o for o in v.outcomes if o.case.when == case) for v in of.variants]
    worn_out = all(len(v.damage) and v.damage.max() > 0 for v in of.variants)
    rows, columns = (2 if worn_out else 1), len(of.variants)
    beside = rows > columns
    wide, high = (rows, columns) if beside else (columns, rows)
    # Letters keep their size on a page, and can be read on a telephone.
    inches = np.array([4.6, 4.3]) if beside else np.array([6.5, 6.0])
    figure: Any = Figure(figsize=tuple(inches * [wide, high]), layout="constrained")
    FigureCanvasAgg(figure)
    grid: Any = figure.subplots(high, wide, squeeze=False)
    grid = grid.T if beside else grid
    colours: Any = colormaps["turbo"]
    scale = Normalize(0, max(o.von_mises.value for o in shown) / MPa)
    most = max(float(v.damage.max()) for v in of.variants) if worn_out else 1.0
    wear = LogNorm(DECADES * most, most, clip=True)

    def paint(axis: Any, v: Judged, moved: FloatArray, tone: FloatArray) -> None:
        flat, depth, shade, facing = _projected(moved, v.solved.nodes.faces)
        tone[:, :3] *= shade[:, None]
        order = facing[np.argsort(depth[facing])]
        axis.add_collection(
            PolyCollection(
                list(flat[order] / mm), facecolors=tone[order], edgecolors=tone[order], lw=0.3
            )
        )
        for k, feature in enumerate(v.shown[:MARKED], 1):
            _mark(axis, f"H{k}", np.asarray(feature.point), "w")
        axis.set_aspect("equal")
        axis.autoscale_view()
        axis.set_axis_off()

    for column, (v, o) in enumerate(zip(of.variants, shown, strict=True)):
        u, mises = peak_fields(v, o)
        nodes = v.solved.nodes
        size = float(np.ptp(nodes.points, axis=0).max())
        exaggeration = 0.04 * size / max(float(np.abs(u).max()), 1e-12)
        axis = grid[0][column]
        paint(
            axis, v, nodes.points + exaggeration * u,
            colours(scale(mises[nodes.faces[:, :3]].mean(axis=1) / MPa)),
        )  # fmt: skip
        for gauge in of.bracket.gauges:
            _mark(axis, gauge.name, np.asarray(gauge.point), "k")
        deformed = say("deformed {times} times", times=f"{exaggeration:.0f}")
        axis.set_title(f"{say(v.name)}: {say.occasion(case)}\n{deformed}")
        if worn_out:
            worn_ = np.zeros(len(nodes.points))
            worn_[nodes.surface] = v.damage
            paint(
                grid[1][column], v, nodes.points,
                colours(wear(np.maximum(worn_[nodes.faces].max(axis=1), DECADES * most))),
            )  # fmt: skip
            grid[1][column].set_title(say("{name}: damage of an hour of duty", name=say(v.name)))
    if over:
        figure.suptitle("\n".join(wrap(over, 58 * wide)), parse_math=False)
    stress = ScalarMappable(norm=scale, cmap=colours)
    figure.colorbar(stress, ax=list(grid[0]), label=say("von Mises stress, MPa"), shrink=0.8)
    if worn_out:
        bar = ScalarMappable(norm=wear, cmap=colours)
        figure.colorbar(bar, ax=list(grid[1]), label=say("damage per hour"), shrink=0.8)
    figure.savefig(path, dpi=180 if beside else 130, format="png")


def _seen() -> tuple[FloatArray, FloatArray, FloatArray]:
    eye = np.array([0.75, -0.45, 0.35])
    eye = eye / np.linalg.norm(eye)
    right = np.cross([0.0, 0.0, 1.0], eye)
    right /= np.linalg.norm(right)
    return eye, right, np.cross(eye, right)


def _projected(
    points: FloatArray, faces: npt.NDArray[np.int64]
) -> tuple[FloatArray, FloatArray, FloatArray, npt.NDArray[np.int64]]:
    """Return triangles as seen, how near and how bright each is, and which face the eye."""
    eye, right, up = _seen()
    corner = points[faces[:, :3]]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    flat = np.stack([corner @ right, corner @ up], axis=-1)
    facing = normal @ eye
    return (
        flat,
        (corner @ eye).mean(axis=1),
        0.65 + 0.35 * np.abs(facing),
        np.flatnonzero(facing > 0),
    )


def _mark(axis: Any, name: str, point: FloatArray, colour: str) -> None:
    _, right, up = _seen()
    x, y = point @ right / mm, point @ up / mm
    axis.plot(x, y, "o", ms=4, mfc=colour, mec="k")
    # Dark where it is blue, and light beside the part.
    from matplotlib.patheffects import withStroke

    axis.annotate(
        name, (x, y), xytext=(4, 4), textcoords="offset points", fontsize=8,
        path_effects=[withStroke(linewidth=2, foreground="w")],
    )  # fmt: skip
