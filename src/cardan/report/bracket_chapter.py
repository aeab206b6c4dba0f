"""The bracket's chapter of a report: cases, hot spots, gauges, frequencies, life, a picture."""

from collections.abc import Iterator
from io import BytesIO

from cardan.base.units import MPa, N, mm, rpm
from cardan.report.blocks import Block, Picture, Table, Text
from cardan.report.bracket import MICRO, lives, picture, span
from cardan.report.bracket_scene import scene
from cardan.report.language import Language
from cardan.study.bracket import BracketAnswer, Judged
from cardan.study.finding import Finding


def chapter(found: Finding[BracketAnswer], say: Language) -> Iterator[Block]:
    """Yield what a study of a bracket found, original beside reinforced.

    Raises
    ------
    NotInstalled
        Without matplotlib.
    """
    of = found.answer
    assert of is not None  # of a study that answered
    yield Text(paragraphs=(say("The bracket of bearing {bearing}", bearing=of.bracket.bearing),))
    yield _compared(of, say)
    yield Text(paragraphs=tuple(_crossings(of, say)))
    for v in of.variants:
        yield _stresses(v, say)
        yield _places(v, say)
        if of.bracket.gauges:
            yield _readings(of, v, say)
        if lives(v):
            yield _damage(v, say)
    yield Text(paragraphs=tuple(_notes(of, say)))
    yield _picture(of, say)


def _compared(of: BracketAnswer, say: Language) -> Table:
    """Return the variants side by side."""
    rows = [(say("mass, kg"), [v.mass for v in of.variants])]
    rows += [
        (
            say("stiffness at the bearing along {axis}, N/mm", axis=axis),
            [1 / float(v.units.compliance[k, k]) / (N / mm) for v in of.variants],
        )
        for k, axis in enumerate("xyz")
    ]
    rows += [
        (
            say("frequency {mode}, loaded, Hz", mode=k + 1),
            [float(v.carried[k]) for v in of.variants],
        )
        for k in range(len(of.variants[0].carried))
    ]
    rows += [
        (say("first frequency by itself, Hz"), [float(v.frequencies[0]) for v in of.variants]),
        (
            say("highest stress at a hot spot, MPa"),
            [float(v.worst.hot.max()) / MPa for v in of.variants],
        ),
    ]
    if all(lives(v) for v in of.variants):
        worst = [max(float(e.spots.max()) / e.turns for e in lives(v)) for v in of.variants]
        rows.append((say("largest damage of a turn of the shaft"), worst))
    return Table(
        caption=say("Original and reinforced") if len(of.variants) > 1 else say("The bracket"),
        head=("", *(say(v.name) for v in of.variants)),
        rows=tuple((name, *(say.number(x) if x > 1e-4 or x == 0 else say.pointed(f"{x:.2e}")
                            for x in values)) for name, values in rows),
    )  # fmt: skip


def _crossings(of: BracketAnswer, say: Language) -> Iterator[str]:
    """Yield where orders meet natural frequencies."""
    for v in of.variants:
        met = [c for c in v.crossings if c.in_range]
        if not met:
            yield say(
                "{name}: no order 1, 2 or 4 meets a natural frequency within the speed range.",
                name=say(v.name),
            )
        for c in met:
            yield say(
                "{name}: order {order} meets frequency {mode}, {frequency} Hz, at {speed} rpm.",
                name=say(v.name), order=c.order, mode=c.mode,
                frequency=say.number(c.frequency), speed=say.number(c.speed / rpm),
            )  # fmt: skip


def _stresses(v: Judged, say: Language) -> Table:
    """Return the case table of a variant."""

    def one(value: float) -> str:
        return say.pointed(f"{value / MPa:.1f}")

    return Table(
        caption=say("Stresses in MPa: {name}", name=say(v.name)),
        head=(
            say("case"),
            "von Mises",
            say("tension"),
            say("compression"),
            *(f"H{k}" for k in range(1, len(v.hot_spots.points) + 1)),
        ),
        rows=tuple(
            (
                say.occasion(o.case.when),
                one(o.von_mises.value),
                one(o.highest.value),
                one(o.lowest.value),
                *(f"{one(h)} ± {one(e)}" for h, e in zip(o.hot, o.error, strict=True)),
            )
            for o in v.outcomes
        ),
    )


def _places(v: Judged, say: Language) -> Table:
    """Return where the hot spots are."""
    return Table(
        caption=say("Hot spots, mm from the bearing's centre: {name}", name=say(v.name)),
        head=(say("hot spot"), "x", "y", "z"),
        rows=tuple(
            (f"H{k}", *(say.pointed(f"{x / mm:.1f}") for x in point))
            for k, point in enumerate(v.hot_spots.points.tolist(), 1)
        ),
    )


def _readings(of: BracketAnswer, v: Judged, say: Language) -> Table:
    """Return what the gauges read, lowest and highest."""
    return Table(
        caption=say("Gauges, microstrain: {name}", name=say(v.name)),
        head=(say("case"), *(gauge.name for gauge in of.bracket.gauges)),
        rows=tuple(
            (
                say.occasion(o.case.when),
                *(say.pointed(span(low / MICRO, high / MICRO)) for low, high in o.strain.tolist()),
            )
            for o in v.outcomes
        ),
    )


def _damage(v: Judged, say: Language) -> Table:
    """Return damage and life."""

    def small(value: float) -> str:
        return "-" if value != value else say.pointed(f"{value:.3g}").replace("inf", "∞")

    return Table(
        caption=say("Damage and life at the worst hot spot: {name}", name=say(v.name)),
        head=(
            say("case"),
            say("damage per turn"),
            say("damage per hour"),
            say("hours to failure"),
        ),
        rows=tuple(
            (say.occasion(e.when), small(e.per_turn), small(e.per_hour), small(e.hours))
            for e in lives(v)
        ),
    )


def _notes(of: BracketAnswer, say: Language) -> Iterator[str]:
    """Yield what a reader of the numbers should know."""
    yield say(
        "Stresses leave out what lies within 1.5 thicknesses of a sharp edge or a clamp, where "
        "they depend on the mesh; H are solved again, finer, with their estimated error."
    )
    yield say("Loads are quasi-static: right below the natural frequencies.")
    if any(lives(v) for v in of.variants):
        yield (
            say("Damage: rainflow and Miner, 2k - 1 beyond the knee, mean stress by Goodman.")
            if of.bracket.material.ultimate_strength
            else say("Damage: rainflow and Miner, 2k - 1 beyond the knee, mean stress not counted.")
        )


def _picture(of: BracketAnswer, say: Language) -> Picture:
    """Return the variants under the original's worst case, still and to be turned about."""
    drawn = BytesIO()
    picture(of, drawn, say=say)
    first = of.variants[0]
    case = say.occasion(first.worst.case.when)
    found = next(o for o in first.outcomes if o is first.worst).von_mises
    alt = say(
        "The bracket deformed under {case}, coloured by von Mises stress; the highest, "
        "{stress} MPa, is at x {x}, y {y}, z {z} mm from the bearing's centre.",
        case=case, stress=say.pointed(f"{found.value / MPa:.1f}"),
        **{a: say.pointed(f"{p / mm:.0f}") for a, p in zip("xyz", found.point, strict=True)},
    )  # fmt: skip
    return Picture(
        title=say("Stress where it is worst: {case}", case=case),
        png=drawn.getvalue(), alt=alt, scene=scene(of, say=say),
    )  # fmt: skip
