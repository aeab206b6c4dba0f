"""What a recording did, as a figure of matplotlib."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cardan.core.units import MPa
from cardan.physics.fatigue.rainflow import range_pairs
from cardan.physics.signals.assessment import GaugeAssessment
from cardan.physics.signals.cause_assessment import DamageCausesByGauge
from cardan.physics.signals.faults.registry import FAULT_KINDS
from cardan.physics.signals.recording import Recording
from cardan.topics.recording.presentation import cause_places

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def _suspected(sheet: Any, *, recording: Recording, lives: Sequence[GaugeAssessment]) -> None:
    """Draw where and when each channel looks wrong, a colour a kind."""
    channels = {name: h for one in lives for name, h in one.channel_reports.items()}
    colours = {kind: f"C{k}" for k, kind in enumerate(FAULT_KINDS)}
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


def draw_recording_figure(
    sheet: "Figure",
    *,
    recording: Recording,
    lives: Sequence[GaugeAssessment],
    causes: DamageCausesByGauge | None,
) -> None:
    """Draw a recording's gauges on a sheet of matplotlib.

    Range pairs, spectra, shares, the joints' order 2, what goes with them, and where and when
    channels look wrong.
    """
    (pairs, density), (shares, order), (removed, health) = sheet.subplots(
        3, 2, height_ratios=(3, 3, 2)
    )
    places = cause_places(causes)
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
        for k, one in enumerate(causes.joint_attributions):
            low, high = (100 * v for v in one.interval)
            removed.plot([low, high], [k, k], "-", lw=6, alpha=0.4, color=f"C{k % 10}")
            removed.plot(100 * one.damage_share, k, "o", color=f"C{k % 10}")
            removed.annotate(one.verdict, (50, k + 0.25), ha="center", va="bottom")
            removed.set_yticks(range(len(causes.gauges)), causes.gauges)
            removed.set_ylim(-0.7, len(causes.gauges))
        removed.axvspan(-10, 25, color="0.93", zorder=-1)
        removed.axvline(35, color="0.8", lw=0.8, zorder=-1)
    removed.set(xlabel="damage that would go with the joints, %", xlim=(-10, 105))
    pairs.legend()
    sheet.suptitle(recording.name)
