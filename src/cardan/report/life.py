"""What a recording did, as lines of text, as the JSON contract and as a figure."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from cardan import __version__
from cardan.base.arrays import FloatArray
from cardan.base.units import MPa, hour
from cardan.fatigue.cause import MEANING, Comparison
from cardan.fatigue.life import Causes, GaugeLife, Plan, verdict
from cardan.fatigue.rainflow import range_pairs
from cardan.fatigue.recording import Recording

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def _number(value: float) -> float | None:
    """JSON knows no infinity: a life without end, or an unknown, is null."""
    return float(value) if math.isfinite(value) else None


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


def contract(
    recording: Recording, *, plan: Plan, lives: list[GaugeLife], causes: Causes | None
) -> dict[str, Any]:
    """Return the JSON contract of `cardan life`. Infinite or unknown numbers are null."""
    gauges: list[dict[str, Any]] = []
    for k, one in enumerate(lives):
        entry: dict[str, Any] = {
            "name": one.name,
            "low_MPa": one.low / MPa,
            "high_MPa": one.high / MPa,
            "damage": one.life.damage,
            "repeats": _number(one.life.repeats),
            "hours": _number(one.life.hours),
            "km": _number(one.life.kilometres),
            "damage_exponent": _number(one.exponent),
            "repeats_at_failure": {f"{f:g}": _number(n) for f, n in one.repeats.items()},
            "spectral_damage": one.spectral,
        }
        if causes is not None:
            found = causes.attributions[k]
            entry["causes"] = [
                {
                    "cause": cause,
                    "meaning": MEANING[cause],
                    "share": found.share(cause),
                    "damage_alone": found.alone(cause),
                    "damage_without": found.without(cause),
                }
                for cause in found.causes
            ]
            entry["verdict"] = verdict(one.name, found)
            entry["order2_by_speed"] = _cut(causes.speed, causes.order2[k])
            if causes.comparisons:
                entry["order2"] = _compared(causes.comparisons[k])
        gauges.append(entry)
    channels = {name: h for one in lives for name, h in one.health.items()}
    return {
        "cardan": __version__,
        "recording": recording.name,
        "rate_Hz": recording.rate,
        "duration_s": lives[0].life.duration if lives else 0.0,
        "distance_km": _number(lives[0].life.distance / 1e3) if lives else None,
        "notes": list(recording.notes),
        "rules": {
            "residue": plan.rule.__name__,
            "mean_stress": getattr(plan.correction, "func", plan.correction).__name__,
            "allowed_damage": plan.allowed,
            "shares": "Shapley",
        },
        "channels": [
            {
                "name": name, "missing": h.missing, "spikes": h.spikes, "clipped": h.clipped,
                "dead": h.dead, "drift": h.drift, "findings": h.findings(rate=recording.rate),
            }
            for name, h in channels.items()
        ],
        "gauges": gauges,
        "doubts": [] if causes is None else causes.doubts,
    }  # fmt: skip


def _long(value: float) -> str:
    return f"{value:,.4g}" if math.isfinite(value) else "no end"


def lines(
    recording: Recording, *, plan: Plan, lives: list[GaugeLife], causes: Causes | None
) -> Iterator[str]:
    """Yield the report as lines of text."""
    duration = lives[0].life.duration
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
        life = one.life
        km = "" if math.isnan(life.kilometres) else _long(life.kilometres)
        yield (
            f"{one.name:<12}{one.low / MPa:>8.1f}{one.high / MPa:>8.1f}{life.damage:>12.4g}"
            f"{_long(life.hours):>12}{km:>12}{one.exponent:>15.2f}"
        )
    yield ""
    for one in lives:
        rate = ", ".join(
            f"{f:.0%} failed {_long(n * duration / hour)} h" for f, n in one.repeats.items()
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
    for k, one in enumerate(lives):
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
        yield verdict(one.name, found)
    yield ""
    yield "Shares are Shapley values; without it and alone are damages over that of all together."
    for doubt in causes.doubts:
        yield f"doubt: {doubt}"
    yield (
        f"Residue by {plan.rule.__name__.replace('_', ' ')}; failure at damage {plan.allowed:g}."
    )


def figure(
    sheet: "Figure", *, recording: Recording, lives: list[GaugeLife], causes: Causes | None
) -> None:
    """Draw range pairs, spectra, shares and the joints' order 2 on a sheet of matplotlib."""
    (pairs, density), (shares, order) = sheet.subplots(2, 2)
    for k, one in enumerate(lives):
        top = one.cycles.range.max(initial=1.0)
        ranges = np.linspace(0, top, 400)[1:]
        pairs.semilogx(range_pairs(one.cycles, ranges=ranges), ranges / MPa, label=one.name)
        if one.spectrum is not None:
            density.loglog(
                one.spectrum.frequency[1:], one.spectrum.density[1:] / MPa**2, label=one.name
            )
        if causes is not None:
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
    pairs.legend()
    sheet.suptitle(recording.name)
