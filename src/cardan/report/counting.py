"""What a recording was counted by, so that two reports of one recording can be told apart."""

import math
from collections.abc import Iterator
from dataclasses import fields
from typing import Any

from cardan.base.units import MPa
from cardan.fatigue.quality import Rule
from cardan.report.blocks import Block, Table
from cardan.report.language import EN, Language
from cardan.study.campaign import Campaign
from cardan.study.recording import Heard

MEANS = {
    "none": "not counted",
    "goodman": "by Goodman",
    "gerber": "by Gerber",
    "swt": "by Smith, Watson and Topper",
    "walker": "by Walker",
    "fkm": "by the FKM guideline",
    "morrow": "by Morrow",
}
"""What corrects the mean stress, of a cycle or a loop, by its name in a campaign."""

ZEROS = {
    "none": "nothing, as recorded",
    "start": "the level at the start",
    "median": "the median",
    "drift": "the running median",
}
"""What is taken off as zero."""

BETWEEN = {
    "auto": "where 1 % and more is lost there",
    "yes": "looked for",
    "no": "not looked for",
}
"""Whether crests are looked for between samples."""


def document(of: Campaign) -> dict[str, Any]:
    """Return the options in force, in their own words; null is not given."""
    options = {
        f.name: list(value) if isinstance(value, tuple) else value
        for f in fields(of)
        if f.name not in ("application", "changed", "limits")
        for value in (getattr(of, f.name),)
    }
    return options | {"mean_sensitivity": of.sensitivity}


def rows(of: Heard, say: Language) -> Iterator[tuple[str, str]]:
    """Yield each rule and what it says."""
    asked, curve = of.campaign, of.plan.curve
    yield say("S-N curve"), say(
        "{amplitude} MPa at {cycles} cycles, slope {slope}",
        amplitude=say.short(curve.amplitude / MPa), cycles=say.short(curve.cycles),
        slope=say.short(curve.slope),
    )  # fmt: skip
    yield say("below its knee"), (
        say("no damage ({rule} Miner)", rule=say(asked.miner))
        if math.isinf(curve.beyond)
        else say("slope {slope} ({rule} Miner)", slope=say.short(curve.beyond),
                 rule=say(asked.miner))
    )  # fmt: skip
    yield say("mean stress"), say(MEANS[asked.mean_stress])
    yield say("residue"), say(of.plan.rule.__name__.replace("_", " "))
    yield say("failure at damage"), say.short(asked.allowed)
    yield say("taken off as zero"), say(ZEROS[asked.zero])
    yield say("crests between samples"), say(BETWEEN[asked.between_samples])
    if asked.low_pass_Hz is not None:
        yield say("nothing faster than"), f"{say.short(asked.low_pass_Hz)} Hz"
    yield from _numbers(of, say)
    for channel, (factor, offset, unit) in asked.scales.items():
        plus = f" + {say.short(offset)}" if offset else ""
        yield channel, say(
            "{factor} times what is written{plus}, in {unit}",
            factor=say.short(factor), plus=plus, unit=unit,
        )  # fmt: skip
    for name, mask in ((say("masked"), True), (say("accepted"), False)):
        told = [_ruled(r, of.recording.begins, say) for r in of.plan.rules if r.mask == mask]
        if told:
            yield name, say.list(*told)
    turning = [
        f"{say(role)} {channel}"
        for role in ("speed", "tacho", "torque", "engine")
        if (channel := getattr(asked, role))
    ]
    if of.causes is not None and turning:
        yield say("causes by"), say.list(*turning)


def _numbers(of: Heard, say: Language) -> Iterator[tuple[str, str]]:
    """Yield what was given of material and scatter, as it was."""
    asked = of.campaign
    strained = asked.modulus_GPa if asked.strains(of.recording) else None
    judged = asked.strain_life is not None
    given = (
        (say("tensile strength"), asked.ultimate_MPa, " MPa"),
        (say("mean-stress sensitivity"), asked.sensitivity, ""),
        (say("Young's modulus"), strained, " GPa"),
        (say("scatter of log10 strength"), asked.scatter or None, ""),
        (say("error of the gauge"), asked.gauge_error or None, ""),
        (say("strain-life curve"), asked.strain_life, ""),
        (say("K_t of the notch"), asked.notch, ""),
        (say("mean stress of a loop"), say(MEANS[asked.strain_mean]) if judged else None, ""),
        (say("crack from, to in mm, C, m"), asked.crack, ""),
        (say("its threshold"), (asked.crack and asked.crack_threshold) or None, " MPa√m"),
        (say("its Y"), asked.crack and asked.crack_shape, ""),
    )
    for name, value, unit in given:
        if value is not None:
            yield name, (value if isinstance(value, str) else say.short(value)) + unit


def _ruled(rule: Rule, begins: float, say: Language) -> str:
    """Return what a rule is of: a kind, a channel, a time of the file."""
    what = say(rule.kind) if rule.kind else say("all that was recorded")
    of = f"{rule.channel}: " if rule.channel else ""
    if rule.always:
        return f"{of}{what}"
    first = say.short(begins + rule.first)
    if math.isinf(rule.last):
        return of + say("{what} from {first} s on", what=what, first=first)
    last = say.short(begins + rule.last)
    return of + say("{what} from {first} to {last} s", what=what, first=first, last=last)


def lines(of: Heard, say: Language = EN) -> Iterator[str]:
    """Yield it as lines of text."""
    told = "; ".join(f"{name}: {said}" for name, said in rows(of, say))
    yield say("Counted by: {rules}.", rules=told)


def blocks(of: Heard, say: Language) -> Iterator[Block]:
    """Yield it as a report has it."""
    yield Table(
        caption=say("Counted by"), head=(say("rule"), ""), rows=tuple(rows(of, say)), words=2
    )
