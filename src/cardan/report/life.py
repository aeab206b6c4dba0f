"""What a recording did, as lines of text, as the JSON contract and as a figure."""

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cardan import __version__
from cardan.base.arrays import FloatArray
from cardan.base.said import Said
from cardan.base.units import MPa, hour
from cardan.fatigue.cause import JOINTS, MEANING, Attribution, Comparison
from cardan.fatigue.conditioning import Health
from cardan.fatigue.evidence import CANNOT_TELL, GUILTY, INNOCENT, TRIED, Evidence
from cardan.fatigue.fault import FREEZE, HOLE, KINDS, SENTINEL
from cardan.fatigue.life import Causes, GaugeLife
from cardan.fatigue.locked import FOUND
from cardan.fatigue.quality import FAST, Assumed, Rule
from cardan.fatigue.rainflow import range_pairs
from cardan.fatigue.recording import Recording
from cardan.report import counting, identified, otherwise, used
from cardan.report.contract import check, coverage, plain
from cardan.report.language import EN, Language
from cardan.report.terminal import columns, headline, table, without_answer
from cardan.report.wording import gaps, worst_of_each
from cardan.study.approval import coverage_of
from cardan.study.campaign import ASKED
from cardan.study.finding import Finding
from cardan.study.recording import FEWEST_CUSTOMERS, Heard, Mix, Mixed, OtherWay, verdict_on

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def _number(value: float) -> float | None:
    """JSON knows no infinity: a life without end, or an unknown, is null."""
    return float(value) if math.isfinite(value) else None


def _life(one: GaugeLife, value: float) -> float | None:
    """Return a number of a life; unknown where it is vetoed."""
    return None if one.vetoed else _number(value)


def _quality(one: GaugeLife) -> dict[str, Any]:
    of = one.quality
    return {
        "verdict": of.verdict if one.heard else "silent",
        "vetoes": list(of.vetoes) if one.heard else [],
        "live_s": of.live,
        "live_share": of.share,
        "suspects": [
            {
                "kind": e.kind,
                "count": e.count,
                "samples": e.samples,
                "undecided": e.undecided,
                "damage_recorded": _number(e.recorded),
                "damage_without": _number(e.without),
                **({"why": str(e.why)} if e.why is not None else {}),
            }
            for e in of.effects
        ],
        "between_samples": not math.isnan(of.samples_only),
        "damage_of_samples": _number(of.samples_only),
        "power_above_0.4_rate": of.fast,
        "biaxiality": _number(of.biaxiality),
        "damage_by_measure": dict(of.measures),
        "doubts": [str(d) for d in of.doubts],
        **({"assumed": _assumed(of.assumed)} if of.assumed is not None else {}),
    }


def _assumed(of: Assumed) -> dict[str, Any]:
    """Return a unit that only the command line says, and the damage in the other."""
    return {
        "unit": of.unit,
        "otherwise": of.other,
        "factor": of.factor,
        "damage_otherwise": _number(of.damage),
    }


def _evidence(of: Evidence) -> dict[str, Any]:
    return {
        "removed": of.removed,
        "removed_interval": list(of.interval),
        "finding": of.finding,
        "finding_wrong": _tried(of.finding),
        "strength": _number(of.strength),
        "modes": [{"frequency_Hz": f, "damping_ratio": d} for f, d in of.modes],
        "speed_ratio": of.ratio,
        "speed_lag_s": of.lag,
        "speed_lag_interval_s": [_number(late) for late in of.lags],
    }


def _tried(finding: str) -> dict[str, Any] | None:
    """Return how often such a finding was wrong where the truth is known."""
    if finding not in TRIED:
        return None
    plain, stopped = (
        {"wrong": t.wrong, "cases": t.cases, "at_most": t.at_most} for t in TRIED[finding]
    )
    return {**plain, "on_a_stop": stopped}


MOST = 100
"""Places of one kind of fault that the contract lists, those farthest off."""


def _suspects(health: Health, rate: float, begins: float) -> list[dict[str, Any]]:
    """Return the places of each kind of fault, in s of its file and the channel's unit."""
    found: list[dict[str, Any]] = []
    for kind, where in health.faults.items():
        size = np.abs(where.sizes)
        weight = np.where(np.isnan(size), where.runs[:, 1] - where.runs[:, 0], size)
        far = np.sort(np.argsort(-weight, kind="stable")[:MOST])
        found.append(
            {
                "kind": kind,
                "count": where.count,
                "samples": where.samples,
                "places": [
                    {
                        "from_s": begins + first / rate,
                        "to_s": begins + last / rate,
                        "size": _number(height),
                    }
                    for (first, last), height in zip(
                        where.runs[far].tolist(), where.sizes[far], strict=True
                    )
                ],
            }
        )
    return found


def _compared(answer: Comparison) -> dict[str, Any]:
    return {
        "ratio": _number(answer.ratio),
        "correlation": _number(answer.correlation),
        "measured_MPa": _number(answer.measured / MPa),
        "predicted_MPa": _number(answer.predicted / MPa),
    }


def _cut(speed: FloatArray, amplitude: FloatArray, *, step: float = 100.0) -> list[dict[str, Any]]:
    """Rms amplitude, MPa, in bands of 100 rpm of shaft speed: an order cut."""
    turning = amplitude > 0
    band = np.floor(speed[turning] * 60 / step)
    return [
        {
            "rpm": float((b + 0.5) * step),
            "MPa": float(np.sqrt((amplitude[turning][band == b] ** 2).mean()) / MPa),
        }
        for b in np.unique(band)
    ]


_DOING = {"look": "reading", "count": "counting cycles", "usage": "counting cycles",
          "strain": "counting cycles", "draw": "drawing"}  # fmt: skip
"""What is done in a pass over a recording, by its name in a study; all others seek causes."""


def under_way(doing: str, say: Language) -> str:
    """Return what a study does, and how far its pass is; behind a whole one it is thought over."""
    name, far = doing.split(maxsplit=1)
    said = say(_DOING.get(name, "looking for causes"))
    return said if far == "100%" else f"{said}: {far}"


def document(found: Finding[Heard]) -> dict[str, Any]:
    """Return the JSON contract of `cardan life`: what is null is infinite or not known."""
    of = _heard(found)
    return {
        **contract(of),
        **_more(of),
        "verdict": verdict_on(found),
        "profile": of.profile or None,
        **plain(
            {
                "checks": [check(c) for c in found.checks],
                "coverage": coverage(coverage_of(found)),
            }
        ),
    }


def _more(of: Heard) -> dict[str, Any]:
    """Return what a recording was asked beyond damage and cause."""
    return {
        **({"misread": [_misread(m) for m in of.misread]} if of.misread else {}),
        **({"usage": {u.gauge: used.document(u) for u in of.used}} if of.used else {}),
        **(
            {"otherwise": {o.gauge: otherwise.document(o) for o in of.otherwise}}
            if of.otherwise
            else {}
        ),
        **({"identification": identified.document(of.identification)} if of.identification else {}),
        **({"changed": identified.promises(of.promised)} if of.promised else {}),
        **({"departures": identified.departing(of.departures)} if of.promised else {}),
    }


def _misread(of: OtherWay) -> dict[str, Any]:
    """Return where a bus wrote no value, and the answer with that taken otherwise."""
    own = of.misread
    torque = {} if math.isnan(own.torque) else {"torque_Nm": own.torque}
    return {
        "channel": own.channel,
        "kind": SENTINEL,
        "rpm": None if torque else own.speed * 60,
        **torque,
        "count": len(own.runs),
        "seconds": float((own.runs[:, 1] - own.runs[:, 0]).sum()),
        "places": [{"from_s": a, "to_s": b} for a, b in own.runs[:MOST].tolist()],
        "accepted": own.accepted,
        "turns_otherwise": _number(of.turns),
        "gauges_otherwise": {name: _evidence(e) for name, e in of.evidence.items()},
    }


def mix_document(found: Finding[Mix]) -> dict[str, Any]:
    """Return the JSON contract of `cardan life` of a campaign: as of one recording, for the mix."""
    of = _mix(found)
    gauges: list[dict[str, Any]] = []
    for one in of.lives:
        life, told = one.life, of.evidence(one.name)
        known = not one.vetoes and one.heard
        gauges.append(
            {
                "name": one.name,
                "damage": _number(life.damage),
                "hours": _number(life.hours) if known else None,
                "km": _number(life.kilometres) if known else None,
                "vetoes": list(one.vetoes),
                **_in_turn(one),
                "recordings": [
                    {
                        "recording": name,
                        "times": times,
                        "damage": _number(part.life.damage),
                        "share": _number(times * part.life.damage / life.damage)
                        if life.damage
                        else None,
                        "live_s": part.quality.live,
                        "damage_per_km": _number(part.life.damage / (part.life.distance / 1e3))
                        if part.life.distance > 0
                        else None,
                        "damage_per_hour": _number(part.life.damage / part.life.duration * hour)
                        if part.life.duration > 0
                        else None,
                    }
                    for (name, times, _), (part, _) in zip(of.parts, one.parts, strict=True)
                ],
                **(_evidence(told) if told else {}),
            }
        )
    return {
        "cardan": __version__,
        "campaign": of.title,
        **(
            {
                "customer": {
                    "share": of.customer,
                    "gauges": [
                        {
                            "name": gauge,
                            "damage_per_hour": rate * hour,
                            "bound_per_hour": bound * hour,
                        }
                        for gauge, (rate, bound) in of.customers.items()
                    ],
                }
            }
            if of.customers
            else {}
        ),
        "verdict": verdict_on(found),
        "profile": of.profile or None,
        "gauges": gauges,
        **(
            {"otherwise": {o.gauge: otherwise.document(o) for o in of.otherwise}}
            if of.otherwise
            else {}
        ),
        "recordings": [
            {
                "times": times,
                **contract(h),
                **_more(h),
            }
            for _, times, h in of.parts
        ],
        **plain(
            {
                "checks": [check(c) for c in found.checks],
                "coverage": coverage(coverage_of(found)),
            }
        ),
    }


def _in_turn(of: Mixed) -> dict[str, Any]:
    """Return what a gauge takes where a mix's parts are driven in turn, if that is more."""
    if of.in_turn is None:
        return {}
    known = not of.vetoes and of.heard
    return {
        "damage_in_turn": _number(of.in_turn.damage),
        "hours_in_turn": _number(of.in_turn.hours) if known else None,
    }


def _mix(found: Finding[Mix]) -> Mix:
    assert found.answer is not None
    return found.answer


def mix_terminal(found: Finding[Mix], say: Language = EN) -> Iterator[str]:
    """Yield the verdict on a campaign, its mix, and each recording as lines of text."""
    of = _mix(found)
    yield from _verdict(found, of.title, of.profile, say)
    yield from mix_lines(of, say)


def mix_lines(of: Mix, say: Language = EN) -> Iterator[str]:
    """Yield what recordings come to together and each of them as lines of text, ungraded."""
    for one in of.lives:
        yield ""
        yield from columns(mix_rows(of, one, say))
        yield from mix_says(of, one, say)
    for one in of.otherwise:
        yield from otherwise.lines(one, say)
    yield from customers(of, say)
    for _, _, heard in of.parts:
        yield ""
        yield from lines(heard, say)
        yield from _said_more(heard, say)


def customers(of: Mix, say: Language) -> Iterator[str]:
    """Yield what a share of customers does to each gauge, where the campaign asks for one."""
    for gauge, (rate, bound) in of.customers.items():
        yield say(
            "{gauge}: {share} of customers do at most {rate} damage per hour (90 % bound {bound}), "
            "each recording taken for one of them: {hours} h, at the bound {least} h",
            gauge=gauge, share=say.share(of.customer),
            rate=say.small(rate * hour, 3), bound=say.small(bound * hour, 3),
            hours=_long(of.allowed / (rate * hour), say),
            least=_long(of.allowed / (bound * hour), say),
        )  # fmt: skip
    for one in of.lives if of.customer else ():
        if one.name not in of.customers:
            yield say(
                "{gauge}: nothing is told of customers: that takes {count} recordings or more, "
                "each of which did damage there, and no veto",
                gauge=one.name, count=FEWEST_CUSTOMERS,
            )  # fmt: skip


def mix_rows(of: Mix, one: Mixed, say: Language) -> list[tuple[str, ...]]:
    """Return what each recording does to a gauge of a mix as rows, their heads first."""
    whole = one.life.damage or math.nan
    rows = [
        (one.name, say("times"), say("live h"), say("damage"), say("per h"), say("per km"),
         say("of the mix")),
    ]  # fmt: skip
    for (name, times, _), (part, _) in zip(of.parts, one.parts, strict=True):
        life = part.life
        per_km = life.damage / (life.distance / 1e3) if life.distance > 0 else math.nan
        per_hour = life.damage / life.duration * hour if life.duration > 0 else math.nan
        rows.append(
            (f"  {name}", say.short(times), say.short(life.duration / hour, 3),
             _known(life.damage, ".4g", say), _known(per_hour, ".3g", say),
             _known(per_km, ".3g", say), _known(times * life.damage / whole, ".1%", say))
        )  # fmt: skip
    rows.append(
        (f"  {say('the mix')}", "", say.short(one.life.duration / hour, 3),
         _known(whole, ".4g", say), "", "", "")
    )  # fmt: skip
    return rows


def mix_says(of: Mix, one: Mixed, say: Language) -> Iterator[str]:
    """Yield how long a gauge lives of a mix, and what of its damage is the joints'."""
    if one.vetoes:
        yield say(
            "{gauge}: VETOED: its damage hangs on {kinds} of some recording",
            gauge=one.name, kinds=say.list(*map(say, one.vetoes)),
        )  # fmt: skip
    else:
        hours = mix_life(one, say)
        yield say("{gauge}: lives {hours} h of the mix", gauge=one.name, hours=hours)
    if one.hidden:
        yield say(
            "{gauge}: segments of one recording stand at levels so far apart that whole it would "
            "have no answer, for {kinds}: --accept says that the part felt them",
            gauge=one.name, kinds=say.list(*map(say, one.hidden)),
        )  # fmt: skip
    elif (turn := one.in_turn) and not one.vetoes:
        yield say(
            "{gauge}: that is of parts each by itself; driven in turn, cycles from one to the "
            "other bring it to {damage} damage: {hours} h",
            gauge=one.name, damage=_known(turn.damage, ".4g", say), hours=_long(turn.hours, say),
        )  # fmt: skip
    if evidence := of.evidence(one.name):
        yield say(
            "{gauge}: {share} of the mix's damage would go with the joints "
            "(90 % interval {low} to {high}): {finding}",
            gauge=one.name, finding=say(evidence.finding).upper(),
            **_shares(evidence, say),
        )  # fmt: skip
        yield from tried(evidence.finding, say)


def mix_life(of: Mixed, say: Language) -> str:
    """Return how many hours of a mix a gauge lives, or why nobody knows."""
    return say("vetoed") if of.vetoes else _long(of.life.hours if of.heard else math.nan, say)


def _shares(of: Evidence, say: Language) -> dict[str, str]:
    low, high = of.interval
    each = {"share": of.removed, "low": low, "high": high}
    return {name: say.share(value) for name, value in each.items()}


def _heard(found: Finding[Heard]) -> Heard:
    assert found.answer is not None  # of a recording that could be asked
    return found.answer


def _places(causes: Causes | None) -> dict[str, int]:
    """Return where causes have each gauge: they leave out those that said nothing."""
    return {name: k for k, name in enumerate(causes.gauges if causes else ())}


def contract(of: Heard) -> dict[str, Any]:
    """Return what a recording did. Infinite or unknown numbers are null."""
    recording, plan, lives, causes = of.recording, of.plan, of.lives, of.causes
    gauges: list[dict[str, Any]] = []
    places = _places(causes)
    for one in lives:
        k = places.get(one.name)
        entry: dict[str, Any] = {
            "name": one.name,
            "low_MPa": _number(one.low / MPa),
            "high_MPa": _number(one.high / MPa),
            "damage": _number(one.life.damage),
            "repeats": _life(one, one.life.repeats),
            "hours": _life(one, one.life.hours),
            "km": _life(one, one.life.kilometres),
            "damage_exponent": _number(one.exponent),
            "repeats_at_failure": {f"{f:g}": _life(one, n) for f, n in one.repeats.items()},
            "spectral_damage": one.spectral,
            "quality": _quality(one),
        }
        if causes is not None and k is not None:
            found, evidence = causes.attributions[k], _evidence(causes.evidence[k])
            entry |= evidence
            entry["causes"] = [
                {
                    "cause": cause,
                    "meaning": MEANING[cause],
                    "share": found.share(cause),
                    "damage_alone": found.alone(cause),
                    "damage_without": found.without(cause),
                    **(evidence if cause == JOINTS else {}),
                }
                for cause in found.causes
            ]
            entry["verdict"] = blame(one.name, found, causes.evidence[k])
            entry["order2_by_speed"] = _cut(causes.speed, causes.order2[k])
            if causes.comparisons:
                entry["order2"] = _compared(causes.comparisons[k])
        gauges.append(entry)
    driven = next((o.life.distance / o.quality.share for o in lives if o.quality.live), math.nan)
    channels = {name: h for one in lives for name, h in one.health.items()}
    return {
        "cardan": __version__,
        "recording": recording.name,
        "rate_Hz": recording.rate,
        "duration_s": lives[0].quality.recorded if lives else 0.0,
        "distance_km": _number(driven / 1e3) if lives else None,
        "notes": list(recording.notes),
        "rules": {
            "residue": plan.rule.__name__,
            "mean_stress": getattr(plan.correction, "func", plan.correction).__name__,
            "allowed_damage": plan.allowed,
            "shares": "Shapley",
            "masked": [_ruled(r, recording.begins) for r in plan.rules if r.mask],
            "accepted": [_ruled(r, recording.begins) for r in plan.rules if not r.mask],
            "options": counting.document(of.campaign),
        },
        "channels": [
            {
                "name": name, "missing": h.missing, "spikes": h.spikes, "clipped": h.clipped,
                "dead": h.dead, "drift": h.drift,
                "findings": [str(f) for f in _found(recording, name, h)],
                "suspects": _suspects(h, recording.rate, recording.begins),
            }
            for name, h in channels.items()
        ],
        "gauges": gauges,
        "doubts": [] if causes is None else [str(d) for d in causes.doubts],
    }  # fmt: skip


def _ruled(rule: Rule, begins: float) -> dict[str, Any]:
    begins = 0.0 if rule.always else begins
    return {
        "channel": rule.channel or None, "kind": rule.kind or None, "from_s": begins + rule.first,
        "to_s": _number(begins + rule.last),
    }  # fmt: skip


def _known(value: float, as_: str, say: Language) -> str:
    return "-" if math.isnan(value) else say.pointed(format(value, as_))


def _long(value: float, say: Language) -> str:
    """Return hours or kilometres, which may have no end."""
    if math.isnan(value):
        return say("not known")
    return say.short(value, 4) if math.isfinite(value) else say("no end")


def terminal(found: Finding[Heard], say: Language = EN) -> Iterator[str]:
    """Yield the verdict, the limits that were asked, and the report as lines of text."""
    of = _heard(found)
    yield from _verdict(found, of.recording.name, of.profile, say)
    yield ""
    yield from lines(of, say)
    yield from _said_more(of, say)


def _said_more(of: Heard, say: Language) -> Iterator[str]:
    """Yield what a recording was asked beyond damage and cause as lines of text."""
    for one in of.misread:
        yield from misread(one, say)
    for one in of.used:
        yield from used.lines(one, say)
    for one in of.otherwise:
        yield from otherwise.lines(one, say)
    if of.identification is not None:
        yield ""
        yield from identified.lines(of.identification, say)
    if of.promised:
        yield ""
        yield from identified.kept(of, say)
    elif of.unkept:
        yield f"  {identified.unkept(say)}"


def misread(of: OtherWay, say: Language) -> Iterator[str]:
    """Yield where a bus' number for no value stands, and what the other reading would do."""
    own = of.misread
    places = {
        "channel": own.channel, "seconds": say.short(float(np.diff(own.runs).sum()), 3),
        "count": len(own.runs), "first": say.short(float(own.runs[0, 0]), 6),
        "speed": f"{say.short(own.speed * 60, 7)} rpm", "turns": say.short(abs(of.turns), 3),
    }  # fmt: skip
    if not math.isnan(own.torque):
        torque = {"torque": f"{say.short(own.torque, 7)} N m"}
        if own.accepted:
            yield say(
                "{channel}: accepted as a torque for {seconds} s in {count} places, the first at "
                "{first} s: {torque}, which a bus (SAE J1939) writes for an error or no value",
                **places | torque,
            )  # fmt: skip
        else:
            yield say(
                "{channel}: no torque for {seconds} s in {count} places, the first at {first} s: "
                "{torque}, which a bus (SAE J1939) writes for an error or no value, taken for "
                "holes (--accept {channel}=sentinel)",
                **places | torque,
            )  # fmt: skip
    elif own.accepted:
        yield say(
            "{channel}: accepted as a speed for {seconds} s in {count} places, the first at "
            "{first} s: {speed}, which a bus (SAE J1939) writes for an error or no value; as "
            "holes the shaft would make {turns} turns less",
            **places,
        )  # fmt: skip
    else:
        yield say(
            "{channel}: no speed for {seconds} s in {count} places, the first at {first} s: "
            "{speed}, which a bus (SAE J1939) writes for an error or no value, taken for holes; as "
            "speeds the shaft would make {turns} turns more (--accept {channel}=sentinel)",
            **places,
        )  # fmt: skip
    for gauge, evidence in of.evidence.items():
        yield say(
            "{gauge}: with that taken otherwise {share} of the damage would go with the joints "
            "(90 % interval {low} to {high}): {finding}",
            gauge=gauge, finding=say(evidence.finding).upper(), **_shares(evidence, say),
        )  # fmt: skip


def _verdict(
    found: Finding[Heard] | Finding[Mix], title: str, profile: str, say: Language
) -> Iterator[str]:
    """Yield the verdict and each limit where it is worst, or that there is none."""
    verdict = verdict_on(found)
    if verdict is None:
        yield say(
            "Nothing was asked: --target-hours or --limits hold the gauges' lives against a limit."
        )
    else:
        yield headline(title, verdict, found.checks, found.unanswered, say)
    if any(x.limit.source != ASKED for x in (*found.checks, *found.unanswered)):
        yield say("limits: {profile}", profile=profile)
    elif profile:
        yield say("{profile} limits no fatigue_life and no fatigue_damage.", profile=profile)
    yield from table(worst_of_each(found.checks), say)
    yield from without_answer(gaps(found.unanswered, say), coverage_of(found), say)


def lines(of: Heard, say: Language = EN) -> Iterator[str]:
    """Yield the report as lines of text."""
    recording, lives, causes = of.recording, of.lives, of.causes
    duration = lives[0].quality.recorded
    yield say(
        "{recording}: {hours} h at {rate} Hz", recording=recording.name,
        hours=say.short(duration / hour, 4), rate=say.short(recording.rate),
    )  # fmt: skip
    for note in recording.notes:
        yield say("  note: {note}", note=say.error(say.given(note)))
    for line in channels(recording, lives, say):
        yield f"  {line}"
    yield ""
    yield from columns(gauges(lives, say))
    yield ""
    yield from counting.lines(of, say)
    for one in lives:
        yield from trust(one, rate=recording.rate, say=say)
    if causes is not None:
        yield from who(lives, causes, say)


def who(lives: Sequence[GaugeLife], causes: Causes, say: Language = EN) -> Iterator[str]:
    """Yield the causes at each gauge as lines of text."""
    places = _places(causes)
    for one in lives:
        k = places.get(one.name)
        if k is None:
            continue
        yield ""
        yield from columns(shared(one.name, causes, k, say))
        yield from told(one.name, causes, k, say)
    yield ""
    yield say(
        "Shares are Shapley values; without it and alone are damages over that of all together."
    )
    for doubt in causes.doubts:
        yield say("doubt: {doubt}", doubt=say.said(doubt))


def channels(recording: Recording, lives: Sequence[GaugeLife], say: Language) -> Iterator[str]:
    """Yield what looks wrong in the channels of gauges, a line each."""
    healths = {name: health for one in lives for name, health in one.health.items()}
    for name, health in healths.items():
        for finding in _found(recording, name, health):
            yield f"{name}: {say.said(finding)}"


def _found(recording: Recording, channel: str, health: Health) -> list[Said]:
    return health.findings(rate=recording.rate, unit=recording.channel(channel).unit)


def gauges(lives: Sequence[GaugeLife], say: Language) -> list[tuple[str, ...]]:
    """Return the gauges as rows, their heads first."""
    rows = [
        (say("gauge"), say("low, MPa"), say("high, MPa"), say("damage"), say("hours"), "km",
         "d ln D/d ln S"),
    ]  # fmt: skip
    for one in lives:
        life, hours = one.life, one.life.hours if one.heard else math.nan
        km = "" if math.isnan(life.kilometres * hours) else _long(life.kilometres, say)
        rows.append(
            (one.name, _known(one.low / MPa, ".1f", say), _known(one.high / MPa, ".1f", say),
             _known(life.damage, ".4g", say), say("vetoed") if one.vetoed else _long(hours, say),
             "" if one.vetoed else km, _known(one.exponent, ".2f", say))
        )  # fmt: skip
    return rows


def shared(name: str, causes: Causes, k: int, say: Language) -> list[tuple[str, ...]]:
    """Return who did the damage at a gauge as rows, their heads first."""
    found = causes.attributions[k]
    whole = found.whole or math.nan
    head = (say("{gauge}: cause", gauge=name), say("share"), say("without it"), say("alone"))
    return [
        head,
        *(
            (f"  {say(cause)}", say.share(found.share(cause), 1),
             say.pointed(f"{found.without(cause) / whole:.3f}"),
             say.pointed(f"{found.alone(cause) / whole:.3f}"))
            for cause in found.causes
        ),
    ]  # fmt: skip


def told(name: str, causes: Causes, k: int, say: Language) -> Iterator[str]:
    """Yield what the joints had to do with a gauge's damage, in words."""
    if causes.comparisons:
        c = causes.comparisons[k]
        yield say(
            "  order 2 measured over predicted {ratio}, correlation with torque {correlation}",
            ratio=_known(c.ratio, ".2f", say), correlation=_known(c.correlation, ".2f", say),
        )  # fmt: skip
    yield blame(name, causes.attributions[k], causes.evidence[k], say)


def blame(
    gauge: str, attribution: Attribution, evidence: Evidence | None = None, say: Language = EN
) -> str:
    """Say in a sentence or three how much the joints had to do with it, whichever way it falls."""
    whole, without = attribution.whole, attribution.without(JOINTS)
    if not whole > 0:
        return say("{gauge}: no damage, so nobody did it.", gauge=gauge)
    longer = whole / without if without > 0 else math.inf
    share, times = say.share(attribution.share(JOINTS), 1), say.short(longer, 3)
    own = (
        say(
            "the joints' orders answer for {share} of the damage; without them it would live as "
            "long.", share=share,
        )
        if times == "1"
        else say(
            "the joints' orders answer for {share} of the damage; without them it would live "
            "{longer} times as long.", share=share, longer=times,
        )
    )  # fmt: skip
    parts = [f"{gauge}: {own}"]
    if evidence is not None:
        shares = _shares(evidence, say)
        if evidence.strength < FOUND and evidence.finding == CANNOT_TELL:
            # A share of nought beside "cannot tell" would be read as an acquittal.
            return say(
                "{gauge}: CANNOT TELL: nothing that could be followed is locked to the shaft; by "
                "phase and torque {share} of the damage would go with the joints (90 % interval "
                "{low} to {high}). With that taken for theirs, {own}",
                gauge=gauge, own=own, **shares,
            )  # fmt: skip
        parts.append(
            say(
                "By phase and torque {share} of the damage would go with them (90 % interval {low} "
                "to {high}): {finding}.",
                finding=say(evidence.finding).upper(), **shares,
            )
        )  # fmt: skip
        parts += tried(evidence.finding, say)
    chief, most = max(attribution.shares.items(), key=lambda kv: kv[1])
    if chief != JOINTS:
        parts.append(
            say("The largest share, {share}, is of {cause}.",
                share=say.share(most, 1), cause=say(chief))
        )  # fmt: skip
    return " ".join(parts)


WRONGLY = {
    INNOCENT: "Such a finding may be wrong: of {cases} gauges whose joints were guilty {wrong} "
    "were called innocent ({most} at most), of {stops} of lines that stand on a stop {stopped} "
    "({mostly} at most).",
    GUILTY: "Such a finding may be wrong: of {cases} gauges whose joints were innocent {wrong} "
    "were called guilty ({most} at most), of {stops} of lines that stand on a stop {stopped} "
    "({mostly} at most).",
}
"""How often each finding was wrong."""


def tried(finding: str, say: Language) -> Iterator[str]:
    """Yield how often such a finding was wrong where the truth is known."""
    if finding in TRIED:
        plain, stopped = TRIED[finding]
        yield say(
            WRONGLY[finding], cases=plain.cases, wrong=plain.wrong, stops=stopped.cases,
            stopped=stopped.wrong, most=say.share(plain.at_most, 1),
            mostly=say.share(stopped.at_most, 1),
        )  # fmt: skip


def trust(one: GaugeLife, *, rate: float, say: Language) -> Iterator[str]:
    """Yield how far a gauge's answer may be trusted, why no farther, and when how many fail."""
    of, name = one.quality, one.name
    if not one.heard:
        yield say("{gauge}: said nothing, so its life is not known", gauge=name)
        return
    for e in of.effects:
        if e.why is not None:
            yield say(
                "{gauge}: {kind} ({state}): {why}", gauge=name, kind=say(e.kind),
                state=say("undecided") if e.undecided else say("decided"), why=say.said(e.why),
            )  # fmt: skip
        elif e.kind not in (HOLE, FREEZE):
            yield say(
                "{gauge}: {kind} ({count}, {state}): damage {recorded} as recorded, {without} "
                "without",
                gauge=name, kind=say(e.kind), count=e.count,
                state=say("undecided") if e.undecided else say("decided"),
                recorded=_known(e.recorded, ".4g", say), without=_known(e.without, ".4g", say),
            )  # fmt: skip
    if of.assumed is not None:
        yield say(
            "{gauge}: assumed to be in {unit}, as the recording does not say; were it in {other}, "
            "its stress would be {factor} times and its damage {damage}",
            gauge=name, unit=of.assumed.unit, other=of.assumed.other,
            factor=say.short(of.assumed.factor, 3), damage=_known(of.assumed.damage, ".3g", say),
        )  # fmt: skip
    for doubt in of.doubts:
        yield say("{gauge}: doubt: {doubt}", gauge=name, doubt=say.said(doubt))
    if of.share < 0.9999:
        yield say(
            "{gauge}: alive for {share} of the time; its life is told of that time",
            gauge=name, share=say.share(of.share, 1),
        )  # fmt: skip
    if not math.isnan(of.samples_only):
        yield say(
            "{gauge}: its crests fall between samples and were looked for there: damage {damage} "
            "by the samples alone",
            gauge=name, damage=_known(of.samples_only, ".4g", say),
        )  # fmt: skip
    if of.fast > FAST:
        yield say(
            "{gauge}: undersampled, or a contact chatters: {share} of its power, of all or where "
            "it is loudest, lies above {frequency} Hz, and what was faster still is folded in",
            gauge=name, share=say.share(of.fast), frequency=say.short(0.4 * rate),
        )  # fmt: skip
    if of.sheared:
        each = (f"{say.given(n)} {say.small(damage, 4)}" for n, damage in of.measures.items())
        yield say(
            "{gauge}: mostly shear (biaxiality {biaxiality}), so its measure decides: damage by "
            "{measures}",
            gauge=name, biaxiality=_known(of.biaxiality, ".2f", say), measures=say.list(*each),
        )  # fmt: skip
    if of.vetoes:
        yield say(
            "{gauge}: VETOED: its damage hangs on {kinds}; say what it was with --mask or --accept",
            gauge=name, kinds=say.list(*map(say, of.vetoes)),
        )  # fmt: skip
        return
    lasts = [
        say("{share} failed {hours} h", share=say.share(f),
            hours=_long(n * one.life.duration / hour, say))
        for f, n in one.repeats.items()
    ]  # fmt: skip
    if len(set(one.repeats.values())) > 1:  # one drive by one vehicle does not scatter
        yield f"{name}: {say.list(*lasts)}"
    if one.spectral and one.life.damage > 0:
        beside = (
            f"{n.replace('_', '-').title()} {say.pointed(f'{d / one.life.damage:.2f}')}"
            for n, d in one.spectral.items()
        )
        yield say(
            "{gauge}: damage by spectrum over rainflow: {methods}",
            gauge=name, methods=say.list(*beside),
        )  # fmt: skip


def _suspected(sheet: Any, *, recording: Recording, lives: Sequence[GaugeLife]) -> None:
    """Draw where and when each channel looks wrong, a colour a kind."""
    channels = {name: h for one in lives for name, h in one.health.items()}
    colours = {kind: f"C{k}" for k, kind in enumerate(KINDS)}
    end, drawn = 0.0, set[str]()
    for row, health in enumerate(channels.values()):
        end = max(end, health.samples / recording.rate)
        for kind, where in health.faults.items():
            spans = [(a / recording.rate, (b - a) / recording.rate) for a, b in where.runs[:2000]]
            label = kind if kind not in drawn else None
            sheet.broken_barh(spans, (row - 0.4, 0.8), facecolor=colours[kind], label=label,
                              edgecolor=colours[kind], linewidth=1)  # fmt: skip
            drawn.add(kind)
    sheet.set_yticks(range(len(channels)), list(channels))
    sheet.set(xlabel="what looks wrong, s", xlim=(0, end or 1), ylim=(-0.6, len(channels) - 0.4))
    if drawn:
        sheet.legend(loc="upper right")


def figure(
    sheet: "Figure", *, recording: Recording, lives: Sequence[GaugeLife], causes: Causes | None
) -> None:
    """Draw a recording's gauges on a sheet of matplotlib.

    Range pairs, spectra, shares, the joints' order 2, what goes with them, and where and when
    channels look wrong.
    """
    (pairs, density), (shares, order), (removed, health) = sheet.subplots(
        3, 2, height_ratios=(3, 3, 2)
    )
    places = _places(causes)
    for one in lives:
        k = places.get(one.name)
        top = one.cycles.range.max(initial=1.0)
        ranges = np.linspace(0, top, 400)[1:]
        pairs.semilogx(range_pairs(one.cycles, ranges=ranges), ranges / MPa, label=one.name)
        if one.spectrum is not None:
            density.loglog(
                one.spectrum.frequency[1:], one.spectrum.density[1:] / MPa**2, label=one.name
            )
        if causes is not None and k is not None:
            found = causes.attributions[k]
            place = np.arange(len(found.causes)) + 0.8 * (k + 0.5) / len(lives) - 0.4
            shares.barh(place, [100 * found.share(c) for c in found.causes], 0.8 / len(lives))
            shares.set_yticks(range(len(found.causes)), found.causes)
            turning = causes.order2[k] > 0
            order.plot(
                causes.speed[turning] * 60, causes.order2[k][turning] / MPa, ".", ms=2,
                label=one.name,
            )  # fmt: skip
    pairs.set(xlabel="cycles of at least this range", ylabel="range, MPa")
    density.set(xlabel="frequency, Hz", ylabel="stress density, MPa²/Hz")
    shares.set(xlabel="share of damage (Shapley), %")
    order.set(xlabel="shaft speed, rpm", ylabel="order 2 amplitude, MPa")
    _suspected(health, recording=recording, lives=lives)
    if causes is not None:
        for k, one in enumerate(causes.evidence):
            low, high = (100 * v for v in one.interval)
            removed.plot([low, high], [k, k], "-", lw=6, alpha=0.4, color=f"C{k % 10}")
            removed.plot(100 * one.removed, k, "o", color=f"C{k % 10}")
            removed.annotate(one.finding, (50, k + 0.25), ha="center", va="bottom")
            removed.set_yticks(range(len(causes.gauges)), causes.gauges)
            removed.set_ylim(-0.7, len(causes.gauges))
        removed.axvspan(-10, 25, color="0.93", zorder=-1)
        removed.axvline(35, color="0.8", lw=0.8, zorder=-1)
    removed.set(xlabel="damage that would go with the joints, %", xlim=(-10, 105))
    pairs.legend()
    sheet.suptitle(recording.name)
