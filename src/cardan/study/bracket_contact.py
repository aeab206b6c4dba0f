"""A bracket in its bolts: what contact and friction make of the swing that tells most.

What presses a flange lifts off and rubs, so stress is no sum of unit stresses. A load history
is followed at its two ends, the moments between which the place that fares worst swings most,
each from the tightened state; the swing of each feature, over that the two ways to be held make
of it, then scales all its cycles. So much in proportion contact is not everywhere: half the load
leaves the ratio within 5 % where stress is high, pushed straight up within a quarter.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.part import Occasion
from cardan.bracket.elastic import IntArray
from cardan.bracket.solve import Held, Solved
from cardan.bracket.unit import UNITS
from cardan.fatigue.critical import on_planes, plane_directions
from cardan.model.bracket import ZONES, Bolts, Zone
from cardan.study.bracket_life import Strength

APART: Mapping[Zone, float] = {
    "sheet": 0.15, "cut edge": 0.15, "weld toe": 0.15, "bolt border": 0.35,
}  # fmt: skip
"""Share by which stress in contact may be wrong, beyond the mesh's: CalculiX has it so far off."""
_LOW = 0.2
"""Share of the most used feature below which one is left as the two ways have it."""


@dataclass(frozen=True, kw_only=True)
class InBolts:
    """What contact makes of a bracket's swings.

    Attributes
    ----------
    when
        The case that was followed.
    times : (features,)
        Swing of each feature in contact, on its safe side, over that told by the worse of the two
        ways held.
    told : (features,)
        What that case uses of each feature's fatigue limit by the two ways.
    life_told
        Hours over the duty cycle by the two ways; nan without one.
    """

    bolts: Bolts
    when: Occasion
    times: FloatArray
    told: FloatArray
    life_told: float = np.nan


def swings(
    solved: Solved,
    features: Sequence[IntArray],
    ends: FloatArray,
    *,
    bolts: Bolts,
    strength: Mapping[Zone, Strength],
    count: int,
) -> FloatArray:
    """Return swings in contact over those told, (count,), between two loads (2, 9).

    `features` are those of the places of each way held.

    Raises
    ------
    NotConverged
        If the bolts do not bear the loads.
    """
    assert solved.bolted is not None
    joint, places = solved.bolted.joint, solved.bolted.places
    tight = joint.tightened(bolts)
    forces = np.stack([tight.under(load) for load in ends])
    real = np.einsum("pqs,tq->pts", joint.stress, forces)
    start = np.cumsum([0, *map(len, places)])
    told, found = np.zeros((2, count))
    for held, own, at, k in zip(solved.both, features, places, start, strict=False):
        alone = np.einsum("pqs,tq->pts", held.unit[at], ends)
        for into, stress in ((told, alone), (found, real[k : k + len(at)])):
            np.maximum.at(into, own[at], _used(held, at, stress, strength))
    counts = told >= _LOW * told.max()
    return np.where(counts, found / np.where(counts, told, 1.0), 1.0)


def on_its_safe_side(times: FloatArray, zones: Sequence[Zone]) -> FloatArray:
    """Return swings (features,) over those told, as much larger as contact may be wrong.

    By that alone no swing is more than the worse of the two ways has.
    """
    apart = np.array([APART[zone] for zone in zones])
    return np.maximum(times, np.minimum(times * (1 + apart), 1.0))


def ends_of(held: Held, at: int, loads: FloatArray, places: int) -> FloatArray:
    """Return the two loads (2, 9) between which the stress of a place swings most."""
    directions = plane_directions(held.zones.normals[[at]])
    best, widest = loads[:2, : len(UNITS)], -1.0
    for one in np.split(loads[:, : len(UNITS)], places):
        history = on_planes(held.unit[[at]], directions)[0] @ one.T
        plane = int(np.ptp(history, axis=1).argmax())
        if (wide := float(np.ptp(history[plane]))) > widest:
            widest = wide
            best = one[[int(history[plane].argmax()), int(history[plane].argmin())]]
    return best


def _used(
    held: Held, at: IntArray, stress: FloatArray, strength: Mapping[Zone, Strength]
) -> FloatArray:
    """Return what the swing between two stresses (places, 2, 6) uses of a zone's limit."""
    on = on_planes(stress, plane_directions(held.zones.normals[at]))
    swing = np.abs(on[..., 0] - on[..., 1]) / 2
    plane = swing.argmax(axis=1)[:, None]
    amplitude = np.take_along_axis(swing, plane, 1)[:, 0]
    mean = np.take_along_axis(on.mean(axis=-1), plane, 1)[:, 0]
    kinds = held.zones.kind[at]
    return np.array([
        float(strength[ZONES[k]].used(a, m)) for k, a, m in zip(kinds, amplitude, mean, strict=True)
    ])  # fmt: skip
