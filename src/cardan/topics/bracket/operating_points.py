"""The worst operating points of a load case that may occur at several."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.model.bracket import FATIGUE_ZONES, FatigueZone
from cardan.physics.fatigue.critical_plane import LoadEnvelope, load_envelope, principal_extremes
from cardan.physics.fem.stress import superpose, von_mises, von_mises_envelope
from cardan.topics.bracket.boundary_case import BoundaryCase
from cardan.topics.bracket.feature_fatigue import worst_cycle_at_places, zone_utilisation
from cardan.topics.bracket.life import ZoneFatigueStrength
from cardan.topics.bracket.load_cases import WIDEST_STRESS_SWING_CASE_NAMES, BearingLoadCase

_MIN_SWING_EXCESS_RATIO = 1.01
"""Ratio to its swing at the point of most stress, above which its own worst point is given too."""


def worst_operating_points(
    case: BearingLoadCase,
    ways: Sequence[BoundaryCase],
    strength: Mapping[FatigueZone, ZoneFatigueStrength],
) -> Iterator[BearingLoadCase]:
    """Yield of the operating points a case may meet that where it stresses most, held either way.

    Of a case that repeats also those where a zone swings most, by what it bears: where parts add
    up to most force, none need be. Sought at the places that the farthest loads, and the farthest
    swings, stress most.
    """
    if not case.alternatives:
        yield case
        return
    stress = np.zeros(len(case.alternatives))
    swing = np.zeros((len(case.alternatives), len(FATIGUE_ZONES)))
    looked = []
    for way in ways:
        each = [way.loads(one) for one in case.alternatives]
        swung = [one - one.mean(axis=0) for one in each]
        far = [
            way.places(principal_extremes(np.concatenate(of), way.rms_stress_per_load))
            for of in (each, swung)
        ]
        at = np.unique(far)
        passes = [
            np.stack(np.split(v, c.pass_count))
            for v, c in zip(each, case.alternatives, strict=True)
        ]
        reaches = [load_envelope(of, way.rms_stress_per_load) for of in passes]
        _stressed_most(way, at, each, reaches, stress)
        looked.append((way, at, passes, reaches))
    worst = int(stress.argmax())
    if case.repeats:
        for way, at, passes, reaches in looked:
            _swung_most(way, at, passes, reaches, strength, swing, told=worst)
    yield replace(case.alternatives[worst], alternatives=case.alternatives)
    told = swing[worst].copy()
    for zone in np.argsort(-swing.max(axis=0)).tolist():
        most = int(swing[:, zone].argmax())
        if swing[most, zone] > _MIN_SWING_EXCESS_RATIO * told[zone]:
            told = np.maximum(told, swing[most])
            yield replace(
                case.alternatives[most],
                component=WIDEST_STRESS_SWING_CASE_NAMES[FATIGUE_ZONES[zone]],
            )


def _stressed_most(
    way: BoundaryCase,
    at: IntArray,
    points: Sequence[FloatArray],
    reaches: Sequence[LoadEnvelope],
    found: FloatArray,
) -> None:
    """Find the highest von Mises stress (points,) Pa that loads (t, c) of each point make.

    At some places; of those points that may stress most. Of others, what was `found` stays.
    """
    unit = way.unit[at]
    # Its square is a sum of squares, so an ellipsoid's is at most that of all its axes.
    each = [[of.centre[None], *(axes.T for axes in of.axes)] for of in reaches]
    parts = [part for row in each for part in row]
    sizes = von_mises(superpose(unit, np.concatenate(parts)))
    ends = np.cumsum([len(part) for part in parts])[:-1]
    far = np.stack([np.linalg.norm(part, axis=1) for part in np.split(sizes, ends, axis=1)])
    most = np.add.reduceat(far, np.cumsum([0, *map(len, each[:-1])])).max(axis=1)
    for k in np.argsort(-most).tolist():
        if most[k] > found.max():
            found[k] = max(found[k], float(von_mises_envelope(unit, points[k]).max()))


def _swung_most(
    way: BoundaryCase,
    at: IntArray,
    points: Sequence[FloatArray],
    reaches: Sequence[LoadEnvelope],
    strength: Mapping[FatigueZone, ZoneFatigueStrength],
    found: FloatArray,
    *,
    told: int,
) -> None:
    """Find what passes (p, t, c) of each point use of each zone (points, zones) at some places.

    Of the point that is `told` anyway, lest one that swings no more be reported too; of those
    that may use most; of others, what was `found` stays.
    """
    kind, ones = way.held.zones.kind[at], np.ones(way.count)
    flat = way.flat[at]
    held = [of.mean_and_amplitude(flat) for of in reaches]
    most = np.stack([zone_utilisation(kind, *of, strength) for of in held])
    zones = [most[:, kind == zone].max(axis=1, initial=0.0) for zone in range(len(FATIGUE_ZONES))]
    first = np.stack([of / max(of.max(), 1e-300) for of in zones]).max(axis=0)
    best = found.max(axis=0)
    for k in np.argsort(-first).tolist():
        asked = most[k] > (found[k] if k == told else best)[kind]
        used = worst_cycle_at_places(way, at[asked], points[k], strength, ones)[0]
        np.maximum.at(found[k], kind[asked], used)
        best = np.maximum(best, found[k])
