"""What a recording did, as lines of text, as the JSON contract and as a figure."""

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cardan import __version__
from cardan.base.arrays import FloatArray
from cardan.base.units import MPa, hour
from cardan.fatigue.cause import JOINTS, MEANING, Comparison
from cardan.fatigue.conditioning import Health
from cardan.fatigue.fault import FREEZE, HOLE, KINDS
from cardan.fatigue.life import Causes, GaugeLife, Plan, verdict
from cardan.fatigue.quality import FAST, Rule
from cardan.fatigue.rainflow import range_pairs
from cardan.fatigue.recording import Recording
from cardan.fatigue.response import Evidence
from cardan.report import identified
from cardan.report.contract import check, coverage, plain
from cardan.report.language import EN, Language
from cardan.report.terminal import headline, table, without_answer
from cardan.report.wording import gaps, worst_of_each
from cardan.study.approval import coverage_of
from cardan.study.campaign import ASKED
from cardan.study.finding import Finding
from cardan.study.recording import Heard, Mix, verdict_on

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
            }
            for e in of.effects
        ],
        "between_samples": not math.isnan(of.samples_only),
        "damage_of_samples": _number(of.samples_only),
        "power_above_0.4_rate": of.fast,
        "biaxiality": _number(of.biaxiality),
        "damage_by_measure": dict(of.measures),
    }


def _evidence(of: Evidence) -> dict[str, Any]:
    return {
        "removed": of.removed,
        "removed_interval": list(of.interval),
        "finding": of.finding,
        "strength": _number(of.strength),
        "modes": [{"frequency_Hz": f, "damping_ratio": d} for f, d in of.modes],
        "speed_ratio": of.ratio,
        "speed_lag_s": of.lag,
    }


MOST = 100
"""Places of one kind of fault that the contract lists, those farthest off."""


def _suspects(health: Health, rate: float) -> list[dict[str, Any]]:
    """Return the places of each kind of fault, in s and the channel's unit."""
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
                    {"from_s": first / rate, "to_s": last / rate, "size": _number(height)}
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


def document(found: Finding[Heard]) -> dict[str, Any]:
    """Return the JSON contract of `cardan life`: what is null is infinite or not known."""
    of = _heard(found)
    return {
        **contract(of.recording, plan=of.plan, lives=of.lives, causes=of.causes),
        **({"identification": identified.document(of.identification)} if of.identification else {}),
        "verdict": verdict_on(found),
        "profile": of.profile or None,
        **plain(
            {
                "checks": [check(c) for c in found.checks],
                "coverage": coverage(coverage_of(found)),
            }
        ),
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
        "verdict": verdict_on(found),
        "profile": of.profile or None,
        "gauges": gauges,
        "recordings": [
            {
                "times": times,
                **contract(h.recording, plan=h.plan, lives=h.lives, causes=h.causes),
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


def _mix(found: Finding[Mix]) -> Mix:
    assert found.answer is not None
    return found.answer


def mix_terminal(found: Finding[Mix], say: Language = EN) -> Iterator[str]:
    """Yield the verdict on a campaign, its mix, and each recording as lines of text."""
    of = _mix(found)
    yield from _verdict(found, of.title, of.profile, say)
    yield ""
    heads = {"times": 10, "live h": 10, "damage": 12, "per h": 12, "per km": 12, "of the mix": 12}
    for one in of.lives:
        whole = one.life.damage or math.nan
        yield f"{one.name:<28}" + "".join(f"{name:>{width}}" for name, width in heads.items())
        for (name, times, _), (part, _) in zip(of.parts, one.parts, strict=True):
            life = part.life
            per_km = life.damage / (life.distance / 1e3) if life.distance > 0 else math.nan
            per_hour = life.damage / life.duration * hour if life.duration > 0 else math.nan
            yield (
                f"  {name[:26]:<26}{times:>10g}{life.duration / hour:>10.3g}"
                f"{_known(life.damage, '.4g'):>12}{_known(per_hour, '.3g'):>12}"
                f"{_known(per_km, '.3g'):>12}{_known(times * life.damage / whole, '.1%'):>12}"
            )
        yield f"  {'the mix':<26}{'':>10}{one.life.duration / hour:>10.3g}{whole:>12.4g}"
        if one.vetoes:
            kinds = " and ".join(one.vetoes)
            yield f"{one.name}: VETOED: its damage hangs on {kinds} of some recording"
        else:
            hours = one.life.hours if one.heard else math.nan
            yield f"{one.name}: lives {_long(hours)} h of the mix"
        if evidence := of.evidence(one.name):
            low, high = evidence.interval
            yield (
                f"{one.name}: {evidence.removed:.0%} of the mix's damage would go with the joints "
                f"(90 % interval {low:.0%} to {high:.0%}): {evidence.finding.upper()}"
            )
        yield ""
    for _, _, heard in of.parts:
        yield from lines(heard.recording, plan=heard.plan, lives=heard.lives, causes=heard.causes)
        yield ""


def _heard(found: Finding[Heard]) -> Heard:
    assert found.answer is not None  # of a recording that could be asked
    return found.answer


def _places(causes: Causes | None) -> dict[str, int]:
    """Return where causes have each gauge: they leave out those that said nothing."""
    return {name: k for k, name in enumerate(causes.gauges if causes else ())}


def contract(
    recording: Recording, *, plan: Plan, lives: Sequence[GaugeLife], causes: Causes | None
) -> dict[str, Any]:
    """Return what a recording did. Infinite or unknown numbers are null."""
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
            entry["verdict"] = verdict(one.name, found, causes.evidence[k])
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
            "masked": [_ruled(r) for r in plan.rules if r.mask],
            "accepted": [_ruled(r) for r in plan.rules if not r.mask],
        },
        "channels": [
            {
                "name": name, "missing": h.missing, "spikes": h.spikes, "clipped": h.clipped,
                "dead": h.dead, "drift": h.drift, "findings": h.findings(rate=recording.rate),
                "suspects": _suspects(h, recording.rate),
            }
            for name, h in channels.items()
        ],
        "gauges": gauges,
        "doubts": [] if causes is None else causes.doubts,
    }  # fmt: skip


def _ruled(rule: Rule) -> dict[str, Any]:
    return {
        "channel": rule.channel or None, "kind": rule.kind or None, "from_s": rule.first,
        "to_s": _number(rule.last),
    }  # fmt: skip


def _known(value: float, as_: str) -> str:
    return "-" if math.isnan(value) else format(value, as_)


def _long(value: float) -> str:
    if math.isnan(value):
        return "not known"
    return f"{value:,.4g}" if math.isfinite(value) else "no end"


def terminal(found: Finding[Heard], say: Language = EN) -> Iterator[str]:
    """Yield the verdict, the limits that were asked, and the report as lines of text."""
    of = _heard(found)
    yield from _verdict(found, of.recording.name, of.profile, say)
    yield ""
    yield from lines(of.recording, plan=of.plan, lives=of.lives, causes=of.causes)
    if of.identification is not None:
        yield ""
        yield from identified.lines(of.identification, say)


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


def lines(
    recording: Recording, *, plan: Plan, lives: Sequence[GaugeLife], causes: Causes | None
) -> Iterator[str]:
    """Yield the report as lines of text."""
    duration = lives[0].quality.recorded
    yield f"{recording.name}: {duration / hour:.4g} h at {recording.rate:g} Hz"
    for note in recording.notes:
        yield f"  note: {note}"
    for one in lives:
        for name, health in one.health.items():
            for said in health.findings(rate=recording.rate):
                yield f"  {name}: {said}"
    yield ""
    heads = {"low": 8, "high": 8, "damage": 12, "hours": 12, "km": 12, "d ln D/d ln S": 15}
    yield f"{'gauge':<12}" + "".join(f"{name:>{width}}" for name, width in heads.items())
    yield f"{'':<12}{'MPa':>8}{'MPa':>8}"
    for one in lives:
        life, hours = one.life, one.life.hours if one.heard else math.nan
        km = "" if math.isnan(life.kilometres * hours) else _long(life.kilometres)
        told = "vetoed" if one.vetoed else _long(hours)
        km = "" if one.vetoed else km
        yield (
            f"{one.name:<12}{_known(one.low / MPa, '.1f'):>8}{_known(one.high / MPa, '.1f'):>8}"
            f"{_known(life.damage, '.4g'):>12}{told:>12}{km:>12}"
            f"{_known(one.exponent, '.2f'):>15}"
        )
    yield ""
    for one in lives:
        if not one.heard:
            yield f"{one.name}: said nothing, so its life is not known"
            continue
        yield from _trust(one, rate=recording.rate)
        if one.vetoed:
            continue
        rate = ", ".join(
            f"{f:.0%} failed {_long(n * one.life.duration / hour)} h"
            for f, n in one.repeats.items()
        )
        yield f"{one.name}: {rate}"
        if one.spectral:
            beside = ", ".join(
                f"{n.replace('_', '-').title()} {d / one.life.damage:.2f}"
                for n, d in one.spectral.items()
                if one.life.damage > 0
            )
            yield f"{one.name}: damage by spectrum over rainflow: {beside}"
    if causes is None:
        return
    places = _places(causes)
    for one in lives:
        k = places.get(one.name)
        if k is None:
            continue
        found = causes.attributions[k]
        yield ""
        yield f"{one.name + ': cause':<24}{'share':>9}{'without it':>13}{'alone':>10}"
        for cause in found.causes:
            whole = found.whole or math.nan
            yield (
                f"  {cause:<22}{found.share(cause):>9.1%}{found.without(cause) / whole:>13.3f}"
                f"{found.alone(cause) / whole:>10.3f}"
            )
        if causes.comparisons:
            c = causes.comparisons[k]
            yield (
                f"  order 2 measured over predicted {c.ratio:.2f}, correlation with torque "
                f"{c.correlation:.2f}"
            )
        yield verdict(one.name, found, causes.evidence[k])
    yield ""
    yield "Shares are Shapley values; without it and alone are damages over that of all together."
    for doubt in causes.doubts:
        yield f"doubt: {doubt}"
    yield (
        f"Residue by {plan.rule.__name__.replace('_', ' ')}; failure at damage {plan.allowed:g}."
    )


def _trust(one: GaugeLife, *, rate: float) -> Iterator[str]:
    """Yield how far a gauge's answer may be trusted, and why no farther."""
    of = one.quality
    for e in of.effects:
        if e.kind in (HOLE, FREEZE):
            continue
        state = "undecided" if e.undecided else "decided"
        yield (
            f"{one.name}: {e.kind} ({e.count}, {state}): damage {e.recorded:.4g} as recorded, "
            f"{e.without:.4g} without"
        )
    if of.share < 0.9999:
        yield f"{one.name}: alive for {of.share:.1%} of the time; its life is told of that time"
    if not math.isnan(of.samples_only):
        yield (
            f"{one.name}: its crests fall between samples and were looked for there: damage "
            f"{of.samples_only:.4g} by the samples alone"
        )
    if of.fast > FAST:
        yield (
            f"{one.name}: undersampled: {of.fast:.0%} of its power lies above {0.4 * rate:g} Hz, "
            "and what was faster still is folded in"
        )
    if of.sheared:
        each = ", ".join(f"{name} {damage:.4g}" for name, damage in of.measures.items())
        yield (
            f"{one.name}: mostly shear (biaxiality {of.biaxiality:.2f}), so its measure decides: "
            f"damage by {each}"
        )
    if of.vetoes:
        yield (
            f"{one.name}: VETOED: its damage hangs on {' and '.join(of.vetoes)}; say what it was "
            "with --mask or --accept"
        )


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
