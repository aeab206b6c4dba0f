"""Fatigue at the places of each feature: use of the fatigue limit, and damage."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from cardan.core.arrays import BoolArray, FloatArray, IntArray
from cardan.model.bracket import FATIGUE_ZONES, FatigueZone
from cardan.physics.fatigue.critical_plane import (
    CycleDamageFunction,
    LoadHistory,
    mean_and_amplitude,
    plane_damage,
)
from cardan.topics.bracket.boundary_case import BoundaryCase, BoundingCycles
from cardan.topics.bracket.life import ZoneFatigueStrength

_COARSE_TURN_SHARE = 0.2
"""Share of a history's range that its turns must have while places of a feature are compared."""
_PLACES_PER_BLOCK = 2000
"""Places whose planes are held at once: under 100 MB."""


def swing_utilisation(
    way: BoundaryCase,
    passes: FloatArray,
    held: BoundingCycles,
    strength: Mapping[FatigueZone, ZoneFatigueStrength],
    times: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return what the normal stress uses of a fatigue limit at every place, its mean and amplitude.

    In the pass (p, t, c) and on the plane that use most; with so many `times` (features,) the
    stress computed. Where no zone's limit is stated, the amplitude itself; where it cannot be the
    worst of a feature, 0. Where von Mises stress is highest may be far from there: what is steady
    swings nothing.
    """
    every = np.zeros((3, len(way.feature)))
    more = times[way.feature]
    kind = way.held.zones.kind
    most = zone_utilisation(kind, more * held.mean, more * held.amplitude, strength)
    for at in _in_turn(way, most, every[0]):
        every[:, at] = worst_cycle_at_places(way, at, passes, strength, times)
    return every[0], every[1], every[2]


def _in_turn(way: BoundaryCase, most: FloatArray, found: FloatArray) -> Iterator[IntArray]:
    """Yield the places that may be the worst of their feature: at `most` so bad, so bad as `found`.

    Those where it may be worst; then all where it may be worse than was found there meanwhile.
    """
    first = np.unique(way.highest(most)[:, 0])
    yield first
    best = np.zeros(way.count)
    np.maximum.at(best, way.feature[first], found[first])
    rest = most > best[way.feature]
    rest[first] = False
    if rest.any():
        yield np.flatnonzero(rest)


def worst_cycle_at_places(
    way: BoundaryCase,
    places: IntArray,
    passes: FloatArray,
    strength: Mapping[FatigueZone, ZoneFatigueStrength],
    times: FloatArray,
) -> FloatArray:
    """Return use, mean, amplitude (3, m) at some places, in the pass (p, t, c) that uses most."""
    best = np.zeros((3, len(places)))
    for block in _blocks(len(places)):
        at = places[block]
        stress = way.planes(at)
        more, kind = times[way.feature[at]][:, None], way.held.zones.kind[at]
        for one in passes:
            mean, amplitude = mean_and_amplitude(stress, one)
            share = zone_utilisation(kind, more * mean, more * amplitude, strength)
            plane = share.argmax(axis=-1)[:, None]
            found = [np.take_along_axis(v, plane, 1)[:, 0] for v in (share, mean, amplitude)]
            best[:, block] = np.where(found[0] > best[0, block], found, best[:, block])
    return best


def _blocks(count: int) -> list[slice]:
    """Return slices of so many places, as few as can be held at once."""
    return [slice(k, k + _PLACES_PER_BLOCK) for k in range(0, count, _PLACES_PER_BLOCK)]


def zone_utilisation(
    kind: IntArray,
    mean: FloatArray,
    amplitude: FloatArray,
    strength: Mapping[FatigueZone, ZoneFatigueStrength],
) -> FloatArray:
    """Return the share (m, ...) of the fatigue limit of zones (m,) of a kind that swings use.

    Where none is stated, the amplitude itself.
    """
    return _by_zone(
        kind, lambda one, own: one.utilisation(amplitude[own], mean[own]), strength, amplitude
    )


def _harm(
    kind: IntArray, strength: Mapping[FatigueZone, ZoneFatigueStrength]
) -> CycleDamageFunction:
    """Return the damage of cycles at places, each by the curve of its zone (m,) of a kind."""

    def harm(amplitude: FloatArray, mean: FloatArray, at: IntArray) -> FloatArray:
        return _by_zone(
            kind[at],
            lambda one, own: one.cycle_damage(amplitude[own], mean[own]),
            strength,
            amplitude,
        )

    return harm


def _by_zone(
    kind: IntArray,
    asked: Callable[[ZoneFatigueStrength, BoolArray], FloatArray],
    strength: Mapping[FatigueZone, ZoneFatigueStrength],
    unknown: FloatArray,
) -> FloatArray:
    """Return a property of the strength of zones (m,) of a kind, (m, ...).

    It is 0 for a zone of unknown strength: `known_zone_factors` says for which it means nothing.
    """
    if not strength:
        return unknown
    found = np.zeros_like(unknown)
    for zone in np.unique(kind).tolist():
        if one := strength.get(FATIGUE_ZONES[zone]):
            own = kind == zone
            found[own] = asked(one, own)
    return found


def known_zone_factors(
    kinds: IntArray, strength: Mapping[FatigueZone, ZoneFatigueStrength]
) -> FloatArray:
    """Return 1 for zones (m,) of known strength, nan for others."""
    return np.array([1.0 if FATIGUE_ZONES[k] in strength else np.nan for k in kinds.tolist()])


def damage_at_places(
    way: BoundaryCase,
    at: IntArray,
    passes: Sequence[LoadHistory],
    strength: Mapping[FatigueZone, ZoneFatigueStrength],
    times: FloatArray | float = 1.0,
    *,
    closely: float = 0.0,
    least: FloatArray | float = 0.0,
) -> FloatArray:
    """Return the damage (m,) of passes at places, each by the curve of its zone.

    With so many `times` (m,) the stress computed; passes have a scale of each feature. Where
    it is less than a share `closely` of the worst, or no more than `least` (m,), the largest cycle
    alone counts.
    """
    unit = way.unit[at] * np.broadcast_to(times, len(at))[:, None, None]
    there = [replace(p, scale=_scale(way, p)[at]) for p in passes]
    harm = _harm(way.held.zones.kind[at], strength)
    return plane_damage(
        unit, way.held.zones.normals[at], there, harm=harm, closely=closely, least=least
    )[0]


def _scale(way: BoundaryCase, one: LoadHistory) -> FloatArray:
    """Return by how much what a pass stresses is more at each place, (places,)."""
    return np.broadcast_to(one.scale, way.count)[way.feature]


def worst_place_damage(
    way: BoundaryCase,
    passes: Sequence[LoadHistory],
    held: Sequence[BoundingCycles],
    strength: Mapping[FatigueZone, ZoneFatigueStrength],
) -> tuple[IntArray, FloatArray]:
    """Return the place (features,) where passes do each feature most damage, and how much.

    Counted wherever they may do most: as if all cycles pulled there. Of a long history the place is
    that which its wide cycles wear most, and all of them count there.
    """
    wide = [
        replace(p, loads=way.telling(p.loads[0], _COARSE_TURN_SHARE)[None])
        if len(p.loads) == 1
        else p
        for p in passes
    ]
    harm, every = _harm(way.held.zones.kind, strength), np.arange(len(way.feature))
    most = np.zeros(len(every))
    for one, of in zip(passes, held, strict=True):
        more = _scale(way, one)
        for share, count in of.levels:
            most += one.repeats * count * harm(more * share * of.amplitude, more * of.mean, every)
    done, best = np.full(len(most), -1.0), np.zeros(way.count)
    for at in _in_turn(way, most, done):
        done[at] = damage_at_places(way, at, wide, strength, least=best[way.feature[at]])
        np.maximum.at(best, way.feature[at], done[at])
    top = way.highest(done)[:, 0]
    if any(p.loads.shape != w.loads.shape for p, w in zip(passes, wide, strict=True)):
        done[top] = damage_at_places(way, top, passes, strength)
    return top, np.where(way.has, done[top], 0.0)


def error_stress_factors(error: FloatArray, ease: float) -> FloatArray:
    """Return shares (3, features) of stress: by its error less, and `ease` of that; less; more."""
    off = np.minimum(error, 1.0)
    return np.stack([(1 - off) * ease, 1 - off, 1 + off])


def damage_bounds_of(
    way: BoundaryCase,
    at: IntArray,
    passes: Sequence[LoadHistory],
    strength: Mapping[FatigueZone, ZoneFatigueStrength],
    error: FloatArray,
    ease: float,
) -> FloatArray:
    """Return the damage (3, features) at places `at`, at `error_stress_factors` times stress."""
    ends = error_stress_factors(error, ease)
    some = ends[1:] if ease == 1 else ends
    found = damage_at_places(way, np.tile(at, len(some)), passes, strength, some.ravel())
    found = np.where(way.has, found.reshape(len(some), -1), 0.0)  # what breaks at once is endless
    return found if len(found) == len(ends) else found[[0, 0, 1]]


def favourable_values(
    ways: Sequence[BoundaryCase], each: Sequence[FloatArray], *, tight: bool
) -> FloatArray:
    """Return values (features,) by the more favourable of both ways to hold the flange.

    In contact, which is neither way, the less favourable: contact is reported relative to it.
    """
    had = np.where([way.has for way in ways], each, np.nan)
    return np.asarray((np.fmax if tight else np.fmin).reduce(had)) if each else np.zeros(0)
