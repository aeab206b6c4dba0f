"""Results of recordings as tables: rainflow matrices, damage over time, orders over time."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.errors import DesignError
from cardan.core.units import MPa, deg
from cardan.physics.fatigue.rainflow_matrix import RainflowKind, RainflowTable, merge_tables
from cardan.physics.signals.assessment import GaugeAssessment, gauge_stresses
from cardan.physics.signals.conditioning import UPSAMPLING_FACTOR, upsample
from cardan.physics.signals.order_cuts import order_cuts, order_windows
from cardan.physics.signals.usage_profile import interval_length, usage_histories
from cardan.topics.recording.campaign_assessment import CampaignAssessment
from cardan.topics.recording.options import parse_numbers
from cardan.topics.recording.rainflow_matrices import (
    DATA_COLUMN,
    DATA_GRADES,
    Columns,
    RainflowMatrices,
    worst_grade,
)
from cardan.topics.recording.recording_assessment import RecordingAssessment

ORDERS = (1.0, 2.0, 4.0)
"""Multiples of the shaft's turn that are tracked, besides those of --joint-orders."""


def rainflow_matrices(
    of: RecordingAssessment | CampaignAssessment, kind: RainflowKind
) -> RainflowMatrices:
    """Return the matrix of each gauge that has one.

    Of a campaign: of all its recordings, each as often as it is driven.
    """
    tables: dict[str, RainflowTable] = {}
    grades: dict[str, str] = {}
    for one in of.lives:
        parts = ((one, 1.0),) if isinstance(one, GaugeAssessment) else one.parts
        told = [(m, times) for part, times in parts for m in part.matrices if m.kind == kind]
        if told:
            tables[one.name] = merge_tables(told)
            # What said nothing in a part is missing in the whole.
            grades[one.name] = worst_grade(
                p.quality.verdict if p.has_signal else DATA_GRADES[-1] for p, _ in parts
            )
    return RainflowMatrices(kind=kind, tables=tables, grades=grades)


def damage_track(of: RecordingAssessment | CampaignAssessment) -> Columns:
    """Return the damage of each gauge second by second, a pass over each recording more.

    `damage` is of the cycles that close in a second: a cycle closes where its range is passed, on
    the way to the turning point that ends it. `open_damage` of what the residue's rule
    makes of the legs that end in it: together they are the gauge's damage.
    """
    names = ("recording", "gauge", "time_s", "damage", "open_damage", "low_MPa", "high_MPa",
             "live_s", DATA_COLUMN)  # fmt: skip
    found: dict[str, list[Any]] = {n: [] for n in names}
    for name, heard in _parts(of):
        for one in heard.lives:
            if not one.has_signal:
                continue
            sharp = not np.isnan(one.quality.damage_of_samples_only)
            rate = heard.recording.rate * (UPSAMPLING_FACTOR if sharp else 1)
            stress = _stress(heard, [one.name])
            plan = heard.plan
            (told,) = usage_histories(
                upsample(stress) if sharp else stress, rate=rate, curve=plan.curve,
                correction=plan.correction, rule=plan.residue_rule,
            )  # fmt: skip
            count = told.damage.size
            time = heard.recording.start_time + interval_length(rate) * np.arange(count)
            found["recording"] += [name] * count
            found["gauge"] += [one.name] * count
            found["time_s"] += time.tolist()
            found["damage"] += told.damage.tolist()
            found["open_damage"] += told.open_damage.tolist()
            found["low_MPa"] += _or_none(told.low / MPa)
            found["high_MPa"] += _or_none(told.high / MPa)
            found["live_s"] += told.live.tolist()
            found[DATA_COLUMN] += [one.quality.verdict] * count
    return found


def order_track(of: RecordingAssessment | CampaignAssessment) -> Columns:
    """Return orders of each gauge in windows of whole turns, a pass over each recording more.

    The stress is amplitude times cos(order times shaft angle plus phase) in each window, 0 to
    peak; `noise_MPa` is the level next to the order.

    Raises
    ------
    DesignError
        If nothing says how the shaft turns.
    """
    names = ("recording", "gauge", "time_s", "speed_rpm", "order", "amplitude_MPa", "phase_deg",
             "noise_MPa", DATA_COLUMN)  # fmt: skip
    found: dict[str, list[Any]] = {n: [] for n in names}
    for name, heard in _parts(of):
        if heard.angle is None:
            msg = "--order-track needs the shaft's angle: name --speed or --tacho"
            raise DesignError(msg)
        own = [one for one in heard.lives if one.has_signal]
        at = order_windows(heard.angle.rotation, until=heard.lives[0].quality.recorded_time)
        if not own or not at.time.size:
            continue
        orders = tuple(sorted({*ORDERS, *parse_numbers(heard.options.joint_orders)}))
        cuts = order_cuts(
            _stress(heard, [one.name for one in own]), rate=heard.recording.rate,
            rotation=heard.angle.rotation, at=at, orders=orders,
        )  # fmt: skip
        time, rpm = heard.recording.start_time + at.time, 60 * at.speed
        for one, amplitude, noise in zip(own, cuts.amplitude, cuts.noise, strict=True):
            for k, order in enumerate(orders):
                found["recording"] += [name] * at.time.size
                found["gauge"] += [one.name] * at.time.size
                found["time_s"] += time.tolist()
                found["speed_rpm"] += rpm.tolist()
                found["order"] += [order] * at.time.size
                found["amplitude_MPa"] += _or_none(np.abs(amplitude[k]) / MPa)
                found["phase_deg"] += _or_none(np.angle(amplitude[k]) / deg)
                found["noise_MPa"] += _or_none(noise[k] / MPa)
                found[DATA_COLUMN] += [one.quality.verdict] * at.time.size
    return found


def _parts(
    of: RecordingAssessment | CampaignAssessment,
) -> Iterator[tuple[str, RecordingAssessment]]:
    """Yield the recordings of an answer by their names."""
    if isinstance(of, RecordingAssessment):
        yield of.recording.name, of
    else:
        yield from ((name, heard) for name, _, heard in of.parts)


def _stress(of: RecordingAssessment, names: Sequence[str]) -> Iterable[FloatArray]:
    """Return pieces (gauges, n) Pa of the stress of some gauges, as it was counted."""
    healths = {name: h for life in of.lives for name, h in life.channel_reports.items()}
    plan = replace(of.plan, gauges=tuple(g for g in of.plan.gauges if g.name in names))
    return gauge_stresses(of.recording, plan=plan, healths=healths, name="tables")


def _or_none(values: FloatArray) -> list[float | None]:
    return [None if np.isnan(v) else v for v in values.tolist()]
