"""Judge one shape of a bracket: what each load case and the duty cycle do, zone by zone.

Everything follows from the unit stresses of the last mesh by adding them up. The flange is
held in two ways that have the truth between them, sliding and clamped, and what is told of
a feature is the worse of the two.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import NamedTuple, TypeAlias

import numpy as np

from cardan.base.arrays import BoolArray, FloatArray
from cardan.base.errors import DesignError, NotConverged
from cardan.base.part import Occasion, Part, Point
from cardan.base.units import Metre, RadianPerSecond, hour, mm
from cardan.bracket.elastic import IntArray, Nodes, Progress
from cardan.bracket.elastic import silent as hushed
from cardan.bracket.gauges import Recovered
from cardan.bracket.refine import LEVELS
from cardan.bracket.shape import WALL
from cardan.bracket.solve import Held, Solved, Task, solved_apart
from cardan.bracket.stress import (
    Extreme,
    Extremes,
    envelope,
    extremes,
    superpose,
    von_mises,
)
from cardan.bracket.unit import UNITS
from cardan.bracket.zones import TOE
from cardan.fatigue.critical import (
    CLOSELY,
    Harm,
    Pass,
    Reach,
    along,
    farthest,
    in_surface,
    on_planes,
    outermost,
    plane_damage,
    plane_directions,
    reach,
    swings,
)
from cardan.fatigue.rainflow import turns
from cardan.model.bracket import ZONES, Bolts, Bracket, Shape, Zone
from cardan.study.bracket_contact import EASED, Contact, InBolts
from cardan.study.bracket_forced import Forced, Swept, amplitude
from cardan.study.bracket_life import Endured, Strength, gauge_damage, loads_of, mixed, strengths

ORDERS = (1, 2, 4)
"""Unbalance; joints; joints at large angles."""
_LONG, _TURN, _WIDE = 2000, 0.01, 0.2
"""Moments beyond which a history is thinned, the share of its range that turns must have, and that
by which its places are compared before one of each feature is counted by all of them."""
_STRAIGHT = np.cos(np.radians(30))
"""Of the angle between a force and the way out of the frame, below which it pulls straight off."""
_PLACES = 6
"""Such places of each feature, which every moment is asked of."""
_MORE = 1.01
"""Times its swing at the point of most stress, above which the point of most swing is told too."""
SWINGS: dict[Zone, str] = {zone: f"widest swing, {zone}" for zone in ZONES}
"""What a case of a state takes where a zone swings most, if that is not where it stresses most."""
_SIZE = np.diag([1.0, 1, 1, 2, 2, 2])
"""Of a stress (6,) the square of its size as a tensor, which no principal stress is above."""
_MISES = _SIZE * 1.5 - np.pad(np.full((3, 3), 0.5), (0, 3))
"""And of von Mises."""
_MOSTLY = 0.5
"""Of a mode's energy, what bends a bracket that swings itself."""
_HEAT, _HOTTEST = ((6 * mm, 20 * mm), (12 * mm, 30 * mm), (25 * mm, 35 * mm)), 40 * mm
"""How far a weld's heat reaches in so thick a wall, and in any."""
_AT_ONCE = 2000
"""Places whose planes are held at once: under 100 MB."""


@dataclass(frozen=True)
class Case:
    """A load history on the bearing, (t, 9) as in `cardan.bracket.unit.UNITS`.

    Where `turns` of the shaft or `duration` (s) are known it is one pass of a history that
    repeats, and does damage; else a load by itself. `places` counts passes one after the
    other of which only the worst happens. A case of a state is called after it and `what`
    it takes of its loads.
    """

    name: str
    loads: FloatArray
    turns: float = np.nan
    duration: float = np.nan
    places: int = 1
    what: str = ""
    point: Point | None = None
    """The operating point whose loads these are, where it is not the state's own."""
    shakes: bool = False
    """Whether the bracket answers as it swings: else it is loaded as if each moment lasted."""
    times: FloatArray | None = None
    """Swing of each feature in contact, (features,), over that told by the two ways held."""
    once: bool = False
    """Whether nobody knows how often it happens: it does no damage."""
    read: Recovered | None = None
    """How its forces were read from gauges; None where they were not."""
    among: tuple["Case", ...] = ()
    """The same at each operating point: of these the worst is told."""

    @property
    def when(self) -> Occasion:
        """The case as an occasion of checks."""
        return Occasion("case", self.name, self.what)

    @property
    def far(self) -> FloatArray:
        """The loads (k, 9) that a mesh is made for: of many points those that go farthest."""
        return farthest(np.concatenate([c.loads for c in self.among])) if self.among else self.loads

    @property
    def repeats(self) -> bool:
        """Whether it is a pass of something, and no load by itself."""
        return not (self.once or (np.isnan(self.turns) and np.isnan(self.duration)))


Duty: TypeAlias = Mapping[Occasion, Sequence[tuple[float, Case]]]
"""The histories of a duty cycle with their shares, in each state that lasts."""


@dataclass(frozen=True, kw_only=True)
class Mounted:
    """What a line loads a bracket with that gives under it: cases, duty cycle, over speed."""

    cases: tuple[Case, ...]
    duty: Duty
    swept: Swept | None


@dataclass(frozen=True, slots=True)
class Found:
    """A stress and where it is."""

    value: float
    point: tuple[Metre, Metre, Metre]


@dataclass(frozen=True, kw_only=True)
class Feature:
    """A bend, a face, an edge, a hole, a weld's toe, a bolt's border: what cracks by itself.

    Attributes
    ----------
    zone, number
        What it is, counted within the zone over all the drawing has.
    point : m
        Where it is worst: by damage over the duty cycle, else by stress over the cases.
    error
        Share of its highest stress that its error may be.
    beside_weld
        Whether the heat of a weld reaches it, where that makes its material softer.
    """

    zone: Zone
    number: int
    point: tuple[Metre, Metre, Metre]
    error: float
    beside_weld: bool = False

    @property
    def part(self) -> Part:
        """The feature as a part of checks."""
        return Part(self.zone, self.number)


@dataclass(frozen=True)
class Outcome:
    """What one case does to one bracket.

    Attributes
    ----------
    von_mises, highest, lowest : Found
        Extremes over all places where fatigue is asked: equivalent, largest tension, largest
        compression.
    on_edge : Found
        Largest von Mises stress at any node. Where it exceeds `von_mises` it sits in a notch
        or at a clamp and depends on the mesh alone.
    hot, error : (features,) Pa
        Largest von Mises stress of each feature, and its estimated error.
    least : (features,) Pa
        The same stress where the flange is held the way that makes it less.
    mean, amplitude : (features,) Pa
        Of the normal stress at the place of each feature, and on the plane, that use most of its
        fatigue limit (where none is stated, that swing most), wherever `hot` is.
    used : (features,)
        That swing at zero mean over the amplitude its zone bears at the knee; nan where none
        is known, or of a load by itself.
    used_kinder : (features,)
        The same where the flange is held the way that makes it less; in contact the same.
    used_within : (features, 2)
        The same where its stress is lower, and higher, by its error, and the flange is held the way
        that makes it less, and more.
    strain : (gauges, 2)
        Smallest and largest reading.
    bolts : (b,) N
        Largest force on each bolt.
    motion : Metre
        Largest movement of the seat under the bearing.
    life : Endured
        Damage and life; None without an S-N curve, or of a load by itself.
    slips : float
        Its loads over those along them under which the bolts slip or open; nan where their force
        is not known.
    slips_at : Point
        Where that is most, of the operating points asked; None at the state's own.
    times : (features,)
        Swing of each feature in contact over that told by the two ways held; None where that was
        not asked.
    pulls_off : bool
        Whether its largest force pulls the flange straight off the frame: softer, where bolts
        give, than either way it is held (`tests/verify/test_bracket_contact.py`).
    """

    case: Case
    von_mises: Found
    highest: Found
    lowest: Found
    on_edge: Found
    hot: FloatArray
    error: FloatArray
    least: FloatArray
    mean: FloatArray
    amplitude: FloatArray
    used: FloatArray
    used_kinder: FloatArray
    used_within: FloatArray
    strain: FloatArray
    bolts: FloatArray
    motion: Metre
    life: Endured | None = None
    slips: float = np.nan
    slips_at: Point | None = None
    times: FloatArray | None = None
    pulls_off: bool = False


class Slip(NamedTuple):
    """What share of what its bolts hold loads ask: above 1 they slip or open."""

    when: Occasion
    share: float
    point: Point | None = None


@dataclass(frozen=True, slots=True)
class Crossing:
    """A natural frequency that an order of the shaft's speed meets."""

    mode: int
    frequency: float
    order: int
    speed: RadianPerSecond
    in_range: bool
    """Whether that speed is one the shaft reaches."""


@dataclass(frozen=True, kw_only=True)
class Judged:
    """One shape of a bracket, judged.

    Attributes
    ----------
    solved : Solved
        The last solution, whose mesh is drawn.
    features : (Feature, ...)
        Worst first.
    listed : int
        How many of them tables show: the worst, and the worst of each zone.
    damage : (surface nodes,)
        Of an hour of the duty cycle, in the state where it is largest; empty without one.
    duty : Endured
        A mean second of the application's duty cycle, in each state that lasts.
    forced : Forced
        The listed features over speed; None where nobody knows what hangs in it.
    in_bolts : InBolts
        What contact made of the fatigue and life told here; None where that was not asked.
    riding : (Slip, ...)
        What the duty cycle asks of the bolts in each state that lasts; nothing where their force
        is not known.
    """

    name: str
    solved: Solved
    features: tuple[Feature, ...]
    listed: int
    crossings: tuple[Crossing, ...]
    outcomes: tuple[Outcome, ...]
    duty: tuple[Endured, ...] = ()
    damage: FloatArray
    forced: Forced | None = None
    in_bolts: InBolts | None = None
    riding: tuple[Slip, ...] = ()

    @property
    def slips(self) -> tuple[Slip, ...]:
        """What each case asks of the bolts, then what the duty cycle does."""
        cases = (Slip(o.case.when, o.slips, o.slips_at) for o in self.outcomes)
        return (*(s for s in cases if not np.isnan(s.share)), *self.riding)

    @property
    def mass(self) -> float:
        """Mass, kg."""
        return self.solved.mass

    @property
    def compliance(self) -> FloatArray:
        """Mean motion of the seat under forces and moments, (6, 6), the flange sliding."""
        return self.solved.sliding.compliance

    @property
    def influence(self) -> FloatArray:
        """Strain (gauges, 9) of each gauge under each unit load, the flange sliding."""
        return self.solved.sliding.influence

    @property
    def frequencies(self) -> FloatArray:
        """Natural frequencies (6,) Hz of the bracket by itself, the flange sliding."""
        return self.solved.sliding.frequencies

    @property
    def carried(self) -> FloatArray:
        """Natural frequencies (6,) Hz with the mass it carries, the flange sliding."""
        return self.solved.sliding.carried

    @property
    def first(self) -> tuple[float, float]:
        """The lowest frequency, Hz, at which it swings itself; the share it may be too high by.

        By itself, and with what hangs in it the lowest of the modes in which it gives more than the
        rubber does: of the line where that is known, else of the mass that it carries. What it
        carries weighs what it weighs: no more than half of the stiffness's own share.
        """
        of = self.solved.sliding
        bends = self.carried[of.bends >= _MOSTLY]
        if self.forced is not None:
            line = self.forced.swept
            bends = line.frequencies[np.array(line.names) == "bracket"]
        loaded = float(of.too_stiff.max()) / 2
        alone = float(of.too_high[0]) if len(of.too_high) else 0.0
        return min([(float(self.frequencies[0]), alone), *((f, loaded) for f in bends.tolist())])

    @property
    def shown(self) -> tuple[Feature, ...]:
        """The features that tables show."""
        return self.features[: self.listed]

    @cached_property
    def worst(self) -> Outcome:
        """The case with the highest converged stress."""
        return max(self.outcomes, key=lambda o: float(o.hot.max()))

    @property
    def lasting(self) -> tuple[Endured, ...]:
        """What hours are told of: the duty cycle in each state that lasts, else each recording."""
        return self.duty or recorded(self.outcomes)

    @property
    def life(self) -> float:
        """Hours to failure at the worst feature over the duty cycle; nan without one."""
        return min((e.hours for e in self.duty), default=np.nan)

    @property
    def life_within(self) -> tuple[float, float]:
        """Between what hours that life lies, by errors and by the flange; nan without one."""
        low, high = np.min([e.hours_within for e in self.duty] or [(np.nan, np.nan)], axis=0)
        return float(low), float(high)

    @property
    def life_meshed(self) -> float:
        """Hours that finer elements may make of that life at most, the flange held alike."""
        return min((e.hours_meshed for e in self.duty), default=np.nan)


def recorded(outcomes: Iterable[Outcome]) -> tuple[Endured, ...]:
    """Return what is endured of what was driven as it was recorded: no turn of a state's shaft."""
    every = (o.life for o in outcomes if np.isnan(o.case.turns))
    return tuple(e for e in every if e is not None and e.duration > 0)


# --------------------------------------------------------------------------- one way of holding


@dataclass(frozen=True)
class _Way:
    """One way of holding a bracket, its features numbered as those of both.

    Loads have the columns of `UNITS`, and beyond them those of the modes it swings in.
    """

    held: Held
    points: FloatArray
    feature: IntArray
    kinds: IntArray
    """Of its features the place of their zone in `ZONES`, (features,)."""

    @property
    def count(self) -> int:
        """How many features both ways have."""
        return len(self.kinds)

    @cached_property
    def unit(self) -> FloatArray:
        """Stress (places, c, 6) Pa of each column of its loads."""
        return np.concatenate([self.held.unit, self.held.swing.unit], axis=1)

    @cached_property
    def flat(self) -> FloatArray:
        """Stress in the surface (places, 3, c) Pa of each column of its loads."""
        return in_surface(self.unit, self.held.zones.normals)

    def planes(self, at: IntArray) -> FloatArray:
        """Return the normal stress (m, planes, c) Pa of each column of its loads at places (m,)."""
        return on_planes(self.unit[at], plane_directions(self.held.zones.normals[at]))

    def held_by(self, passes: FloatArray) -> "_Held":
        """Return what no place's stress leaves under passes (p, t, c)."""
        found = reach(passes, self.worth)
        return _Held(found.levels, *found.swings(self.flat))

    @cached_property
    def worth(self) -> FloatArray:
        """How much each column of its loads stresses, (c,) Pa."""
        return np.sqrt(np.mean(self.unit**2, axis=(0, 2)))

    @cached_property
    def influence(self) -> FloatArray:
        """Strain (gauges, c) of each column of its loads."""
        return np.concatenate([self.held.influence, self.held.swing.influence], axis=1)

    @cached_property
    def reactions(self) -> FloatArray:
        """Force on each bolt (b, c, 3) N of each column of its loads."""
        return np.concatenate([self.held.reactions, self.held.swing.reactions], axis=1)

    @cached_property
    def moves(self) -> FloatArray:
        """Motion of the seat (c, 3) m of each column of its loads; forces and modes alone."""
        own = self.held.swing.seat.motion[: self.held.swing.unit.shape[1]]
        rest = np.zeros((len(UNITS) - 6, 3))
        return np.concatenate([self.held.compliance[:, :3], rest, own])

    def loads(self, case: Case) -> FloatArray:
        """Return the loads of a case (t, c), with what the bracket swings on top of them."""
        swings = self.held.swing.unit.shape[1]
        found = np.pad(case.loads, ((0, 0), (0, swings)))
        if not (case.shakes and np.isfinite(case.duration)):
            return found if case.places > 1 else self.telling(found)
        columns = [*range(3), *range(len(UNITS), len(UNITS) + swings)]
        each = found.reshape(case.places, -1, found.shape[1])  # a view: what is added stays
        each[..., columns] += self.held.swing.seat.shaken(each[..., :3], case.duration)
        return found if case.places > 1 else self.telling(found)

    def telling(self, loads: FloatArray, share: float = _TURN) -> FloatArray:
        """Return the moments of a long history that any stress turns at, the others left out.

        Kept is where any of the ways in which they go `along` turns by more than a share of the
        range of the way that stresses most: a hundredth, which no cycle that does harm is below.
        """
        if len(loads) <= _LONG:
            return loads
        ways = along(loads, self.worth, alike=False)
        most = share * float(np.ptp(ways, axis=0).max())
        if not most:  # a sensor that stands still, or reads nothing
            return loads[:1]
        kept = [turns(gone, gate=most / np.ptp(gone)) for gone in ways.T if np.ptp(gone) > 0]
        return loads[np.unique(np.concatenate(kept))]

    def places(self, loads: FloatArray) -> IntArray:
        """Return the places (features, k) where loads may be worst, a feature's own repeated."""
        return self.highest(envelope(self.unit, farthest(loads, self.worth)))

    def highest(self, values: FloatArray) -> IntArray:
        """Return the places (features, k) where values (places,) are highest, highest first."""
        order = np.lexsort((-values, self.feature))
        starts = np.searchsorted(self.feature[order], np.arange(self.count))
        ends = np.searchsorted(self.feature[order], np.arange(self.count), side="right")
        # A feature that this way of holding does not have shows the first place, and no stress.
        at = np.minimum(starts[:, None] + np.arange(_PLACES), np.maximum(ends[:, None] - 1, 0))
        return order[np.minimum(at, len(order) - 1)]

    @cached_property
    def has(self) -> IntArray:
        """Return whether it has each feature, 1 or 0."""
        return np.bincount(self.feature, minlength=self.count).clip(max=1)


class _Held(NamedTuple):
    """Mean and amplitude (places,) Pa that harm as any cycle of a pass; shares it has of them."""

    levels: tuple[tuple[float, float], ...]
    mean: FloatArray
    amplitude: FloatArray


@dataclass(frozen=True)
class _Peak:
    """The place (features,) of each feature that is worst, held one way, and how bad it is there.

    Below nothing where the feature is not there, held that way.
    """

    way: _Way
    places: IntArray
    values: FloatArray

    @classmethod
    def of(cls, way: _Way, places: IntArray, values: FloatArray) -> "_Peak":
        """Return the peaks of a way of holding."""
        return cls(way, places, np.where(way.has, values, -1.0))


def _ways(solved: Solved) -> tuple[tuple[_Way, ...], tuple[tuple[int, int], ...]]:
    """Return both ways of holding, and the features (kind, number) of both together."""
    every = sorted({f for held in solved.both for f in held.zones.features})
    place = {key: k for k, key in enumerate(every)}
    ways = tuple(
        _Way(
            held,
            held.zones.points(solved.nodes),
            np.array([place[f] for f in held.zones.features])[held.zones.feature],
            np.array([kind for kind, _ in every]),
        )
        for held in solved.both
    )
    return ways, tuple(every)


def _swing(
    way: _Way,
    passes: FloatArray,
    held: _Held,
    strength: Mapping[Zone, Strength],
    times: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return what the normal stress uses of a fatigue limit at every place, its mean and amplitude.

    In the pass (p, t, c) and on the plane that use most; of so many `times` (features,) the stress
    that is told. Where no zone's limit is stated, the amplitude itself; where it cannot be the
    worst of a feature, 0. Where von Mises stress is highest may be far from there: what is steady
    swings nothing.
    """
    every = np.zeros((3, len(way.feature)))
    more = times[way.feature]
    kind = way.held.zones.kind
    most = _used(kind, more * held.mean, more * held.amplitude, strength)
    for at in _in_turn(way, most, every[0]):
        every[:, at] = _swing_at(way, at, passes, strength, times)
    return every[0], every[1], every[2]


def _in_turn(way: _Way, most: FloatArray, found: FloatArray) -> Iterator[IntArray]:
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


def _swing_at(
    way: _Way,
    places: IntArray,
    passes: FloatArray,
    strength: Mapping[Zone, Strength],
    times: FloatArray,
) -> FloatArray:
    """Return use, mean, amplitude (3, m) at some places, in the pass (p, t, c) that uses most."""
    best = np.zeros((3, len(places)))
    for block in _blocks(len(places)):
        at = places[block]
        stress = way.planes(at)
        more, kind = times[way.feature[at]][:, None], way.held.zones.kind[at]
        for one in passes:
            mean, amplitude = swings(stress, one)
            share = _used(kind, more * mean, more * amplitude, strength)
            plane = share.argmax(axis=-1)[:, None]
            found = [np.take_along_axis(v, plane, 1)[:, 0] for v in (share, mean, amplitude)]
            best[:, block] = np.where(found[0] > best[0, block], found, best[:, block])
    return best


def _blocks(count: int) -> list[slice]:
    """Return slices of so many places, as few as can be held at once."""
    return [slice(k, k + _AT_ONCE) for k in range(0, count, _AT_ONCE)]


def _used(
    kind: IntArray, mean: FloatArray, amplitude: FloatArray, strength: Mapping[Zone, Strength]
) -> FloatArray:
    """Return the share (m, ...) of the fatigue limit of zones (m,) of a kind that swings use.

    Where none is stated, the amplitude itself.
    """
    return _by_zone(kind, lambda one, own: one.used(amplitude[own], mean[own]), strength, amplitude)


def _harm(kind: IntArray, strength: Mapping[Zone, Strength]) -> Harm:
    """Return the damage of cycles at places, each by the curve of its zone (m,) of a kind."""

    def harm(amplitude: FloatArray, mean: FloatArray, at: IntArray) -> FloatArray:
        return _by_zone(
            kind[at], lambda one, own: one.harm(amplitude[own], mean[own]), strength, amplitude
        )

    return harm


def _by_zone(
    kind: IntArray,
    asked: Callable[[Strength, BoolArray], FloatArray],
    strength: Mapping[Zone, Strength],
    unknown: FloatArray,
) -> FloatArray:
    """Return what is asked of the strength of zones (m,) of a kind, and which are its, (m, ...).

    Of a zone that nobody knows the strength of, 0: `_known` says where that means nothing.
    """
    if not strength:
        return unknown
    found = np.zeros_like(unknown)
    for zone in np.unique(kind).tolist():
        if one := strength.get(ZONES[zone]):
            own = kind == zone
            found[own] = asked(one, own)
    return found


def _known(kinds: IntArray, strength: Mapping[Zone, Strength]) -> FloatArray:
    """Return 1 for zones (m,) whose strength somebody knows, nan for others."""
    return np.array([1.0 if ZONES[k] in strength else np.nan for k in kinds.tolist()])


def _damage(
    way: _Way,
    at: IntArray,
    passes: Sequence[Pass],
    strength: Mapping[Zone, Strength],
    times: FloatArray | float = 1.0,
    *,
    closely: float = 0.0,
    least: FloatArray | float = 0.0,
) -> FloatArray:
    """Return the damage (m,) of passes at places, each by the curve of its zone.

    Of so many `times` (m,) the stress that is told; passes have a scale of each feature. Where
    it is less than a share `closely` of the worst, or no more than `least` (m,), the largest cycle
    alone counts.
    """
    unit = way.unit[at] * np.broadcast_to(times, len(at))[:, None, None]
    there = [replace(p, scale=_scale(way, p)[at]) for p in passes]
    harm = _harm(way.held.zones.kind[at], strength)
    return plane_damage(
        unit, way.held.zones.normals[at], there, harm=harm, closely=closely, least=least
    )[0]


def _scale(way: _Way, one: Pass) -> FloatArray:
    """Return by how much what a pass stresses is more at each place, (places,)."""
    return np.broadcast_to(one.scale, way.count)[way.feature]


def _worn(
    way: _Way,
    passes: Sequence[Pass],
    held: Sequence[_Held],
    strength: Mapping[Zone, Strength],
) -> tuple[IntArray, FloatArray]:
    """Return the place (features,) where passes do each feature most damage, and how much.

    Counted wherever they may do most: as if all cycles pulled there. Of a long history the place is
    that which its wide cycles wear most, and all of them count there.
    """
    wide = [
        replace(p, loads=way.telling(p.loads[0], _WIDE)[None]) if len(p.loads) == 1 else p
        for p in passes
    ]
    harm, every = _harm(way.held.zones.kind, strength), np.arange(len(way.feature))
    most = np.zeros(len(every))
    for one, of in zip(passes, held, strict=True):
        more = _scale(way, one)
        for share, count in of.levels:
            most += one.times * count * harm(more * share * of.amplitude, more * of.mean, every)
    done, best = np.full(len(most), -1.0), np.zeros(way.count)
    for at in _in_turn(way, most, done):
        done[at] = _damage(way, at, wide, strength, least=best[way.feature[at]])
        np.maximum.at(best, way.feature[at], done[at])
    top = way.highest(done)[:, 0]
    if any(p.loads.shape != w.loads.shape for p, w in zip(passes, wide, strict=True)):
        done[top] = _damage(way, top, passes, strength)
    return top, np.where(way.has, done[top], 0.0)


def _ends(error: FloatArray, ease: float) -> FloatArray:
    """Return shares (3, features) of stress: by its error less, and `ease` of that; less; more."""
    off = np.minimum(error, 1.0)
    return np.stack([(1 - off) * ease, 1 - off, 1 + off])


def _span(
    way: _Way,
    at: IntArray,
    passes: Sequence[Pass],
    strength: Mapping[Zone, Strength],
    error: FloatArray,
    ease: float,
) -> FloatArray:
    """Return the damage (3, features) of the place of each feature at the `_ends` of its stress."""
    ends = _ends(error, ease)
    some = ends[1:] if ease == 1 else ends
    found = _damage(way, np.tile(at, len(some)), passes, strength, some.ravel())
    found = np.where(way.has, found.reshape(len(some), -1), 0.0)  # what breaks at once is endless
    return found if len(found) == len(ends) else found[[0, 0, 1]]


def _kinder(ways: Sequence[_Way], each: Sequence[FloatArray], *, tight: bool) -> FloatArray:
    """Return what is told (features,) of the flange held the kinder way, of what either way has.

    In contact, which is neither, what the harsher has: contact has been told beside that one.
    """
    had = np.where([way.has for way in ways], each, np.nan)
    return np.asarray((np.fmax if tight else np.fmin).reduce(had)) if each else np.zeros(0)


# --------------------------------------------------------------------------- judge


def judge(
    bracket: Bracket,
    shape: Shape,
    cases: Sequence[Case],
    *,
    duty: Duty | None = None,
    mounted: Callable[[Solved], Mounted] | None = None,
    name: str = "original",
    top_speed: RadianPerSecond = np.nan,
    levels: int = LEVELS,
    tell: Progress = hushed,
) -> Judged:
    """Judge one shape of a bracket under load cases, and over a duty cycle's.

    Damage is counted where the bracket states what it bears in fatigue. `mounted` says what
    the cases and the cycle become on a bracket that gives; those given are what the mesh is
    made for, in as many `levels` at most.

    Raises
    ------
    DesignError
        If there is no case, or the shape cannot be built, meshed or afforded.
    """
    if not cases:
        msg = "the bracket has no load case: give the application a torque, or the bracket cases"
        raise DesignError(msg)

    def told(what: str) -> None:
        tell(f"{name}: {what}")

    strength = strengths(bracket)
    riding = [case for parts in (duty or {}).values() for _, case in parts]
    task = Task(
        shape=shape, material=bracket.material, element=bracket.element, order=bracket.order,
        cases=tuple(c.far for c in (*cases, *riding)), weights=_weights(strength),
        gauges=bracket.gauges, carried_mass=bracket.carried_mass, rubber=bracket.rubber,
        loss=bracket.loss, levels=levels, bolted=bracket.bolts is not None,
        reads=any(one.read for one in bracket.recordings),
    )  # fmt: skip
    try:
        solved = solved_apart(task, tell=told)
    except DesignError as error:
        msg = f"{name} bracket: {error}"
        raise DesignError(msg, about=error.about) from None
    swept: Swept | None = None
    if mounted is not None:
        told("the line on this bracket")
        on = mounted(solved)
        cases, duty, swept = on.cases, on.duty, on.swept
    told(f"stresses of {len(cases)} load cases")
    ways, known = _ways(solved)
    cases = [worst for case in cases for worst in _worst_of(case, ways, strength)]
    error = np.array([solved.error.get(key, 0.0) for key in known])
    modulus = bracket.material.youngs_modulus
    outcomes, peaks = _outcomes(cases, solved, ways, error, strength, modulus)
    in_bolts, riding = None, list[Slip]()
    if bracket.bolts is not None:
        told("contact between flange and frame")
        contact = _tightened(bracket.bolts, solved, ways, strength)
        alone, *_ = _duty(solved, ways, duty or {}, strength, modulus, error)
        two_ways = [o.used for o in outcomes]
        cases = [_in_contact(case, contact, ways[0]) for case in cases]
        duty = {
            when: [(share, _in_contact(case, contact, ways[0])) for share, case in parts]
            for when, parts in (duty or {}).items()
        }
        outcomes, peaks = _outcomes(cases, solved, ways, error, strength, modulus)
        outcomes = [_held(o, contact, ways[0]) for o in outcomes]
        riding = [
            Slip(when, contact.share(np.concatenate([_bare(case, ways[0]) for _, case in parts])))
            for when, parts in duty.items() if parts
        ]  # fmt: skip
        life = min((e.hours for e in alone), default=np.nan)
        in_bolts = _in_bolts(bracket.bolts, outcomes, two_ways, life)
    if duty and strength:
        told("damage over the duty cycle, at every place of the surface")
    spent, damage, worn = _duty(solved, ways, duty or {}, strength, modulus, error)
    order = _worst_first(known, outcomes, spent or recorded(outcomes), _weights(strength))
    spots = _spots(worn or [*chain.from_iterable(peaks)], order)
    # What its highest stress may be off by, read from gauges or not.
    high = np.array([o.hot for o in outcomes])
    off = np.take_along_axis(np.array([o.error for o in outcomes]), high.argmax(axis=0)[None], 0)[0]
    share = np.where(high.any(axis=0), off / np.maximum(high.max(axis=0), 1e-300), error)
    soft = bracket.material.softens
    heated = _beside_welds(ways, shape.thickness) if soft else np.zeros(len(known), dtype=bool)
    features = tuple(
        Feature(
            zone=ZONES[known[f][0]], number=known[f][1], point=_point(way.points[at]),
            error=float(share[f]), beside_weld=bool(heated[f]),
        )
        for f, (way, at) in zip(order.tolist(), spots, strict=True)
    )  # fmt: skip
    return Judged(
        name=name,
        solved=solved,
        features=features,
        listed=_listed(features),
        forced=None if swept is None else _forced(swept, spots[: _listed(features)]),
        crossings=tuple(crossings(solved.sliding.carried, top_speed)),
        outcomes=tuple(_sorted(o, order) for o in outcomes),
        duty=tuple(e.at(order) for e in spent),
        damage=damage,
        in_bolts=None if in_bolts is None else replace(
            in_bolts, times=in_bolts.times[order], told=in_bolts.told[order]
        ),
        riding=tuple(riding),
    )  # fmt: skip


def _beside_welds(ways: Sequence[_Way], thickness: Metre) -> BoolArray:
    """Return which features (features,) have a place that a weld's heat reaches.

    As far as 20 mm from the weld's toe in 6 mm, 30 in 12, 35 in 25, else 40. Source: EN 1999-1-1,
    6.1.6.3, of MIG welds; quoted from memory, not re-read.
    """
    from scipy.spatial import cKDTree

    reach = next((far for thick, far in _HEAT if thickness <= thick), _HOTTEST)
    found = np.zeros(ways[0].count, dtype=bool)
    for way in ways:
        toes = way.points[way.held.zones.kind == TOE]
        if len(toes):
            away, _ = cKDTree(toes).query(way.points)
            found[way.feature[away <= reach]] = True
    return found


def _tightened(
    bolts: Bolts,
    solved: Solved,
    ways: tuple[_Way, ...],
    strength: Mapping[Zone, Strength],
) -> Contact:
    try:
        return Contact.of(
            solved, [way.feature for way in ways], bolts=bolts,
            count=ways[0].count, strength=strength,
        )  # fmt: skip
    except NotConverged as error:
        raise DesignError(str(error), about="bracket.bolts") from error


def _bare(case: Case, way: _Way) -> FloatArray:
    """Return the loads (t, 9) of a case, with what it swings but for its own modes."""
    return way.loads(case)[:, : len(UNITS)]


def _worst_of(
    case: Case, ways: Sequence[_Way], strength: Mapping[Zone, Strength]
) -> Iterator[Case]:
    """Yield of the operating points a case may meet that where it stresses most, held either way.

    Of a case that repeats also those where a zone swings most, by what it bears: where parts add
    up to most force, none need be. Sought at the places that the farthest loads, and the farthest
    swings, stress most.
    """
    if not case.among:
        yield case
        return
    stress = np.zeros(len(case.among))
    swing = np.zeros((len(case.among), len(ZONES)))
    looked = []
    for way in ways:
        each = [way.loads(one) for one in case.among]
        swung = [one - one.mean(axis=0) for one in each]
        far = [way.places(farthest(np.concatenate(of), way.worth)) for of in (each, swung)]
        at = np.unique(far)
        passes = [np.stack(np.split(v, c.places)) for v, c in zip(each, case.among, strict=True)]
        reaches = [reach(of, way.worth) for of in passes]
        _stressed_most(way, at, each, reaches, stress)
        looked.append((way, at, passes, reaches))
    worst = int(stress.argmax())
    if case.repeats:
        for way, at, passes, reaches in looked:
            _swung_most(way, at, passes, reaches, strength, swing, told=worst)
    yield replace(case.among[worst], among=case.among)
    told = swing[worst].copy()
    for zone in np.argsort(-swing.max(axis=0)).tolist():
        most = int(swing[:, zone].argmax())
        if swing[most, zone] > _MORE * told[zone]:
            told = np.maximum(told, swing[most])
            yield replace(case.among[most], what=SWINGS[ZONES[zone]])


def _stressed_most(
    way: _Way,
    at: IntArray,
    points: Sequence[FloatArray],
    reaches: Sequence[Reach],
    found: FloatArray,
) -> None:
    """Find the highest von Mises stress (points,) Pa that loads (t, c) of each point make.

    At some places; of those points that may stress most. Of others, what was `found` stays.
    """
    unit = way.unit[at]
    # Its square is a sum of squares, so an ellipsoid's is at most that of all its axes.
    each = [[of.middle[None], *(axes.T for axes in of.axes)] for of in reaches]
    parts = [part for row in each for part in row]
    sizes = von_mises(superpose(unit, np.concatenate(parts)))
    ends = np.cumsum([len(part) for part in parts])[:-1]
    far = np.stack([np.linalg.norm(part, axis=1) for part in np.split(sizes, ends, axis=1)])
    most = np.add.reduceat(far, np.cumsum([0, *map(len, each[:-1])])).max(axis=1)
    for k in np.argsort(-most).tolist():
        if most[k] > found.max():
            found[k] = max(found[k], float(envelope(unit, points[k]).max()))


def _swung_most(
    way: _Way,
    at: IntArray,
    points: Sequence[FloatArray],
    reaches: Sequence[Reach],
    strength: Mapping[Zone, Strength],
    found: FloatArray,
    *,
    told: int,
) -> None:
    """Find what passes (p, t, c) of each point use of each zone (points, zones) at some places.

    Of the point that is `told` anyway, lest one that swings no more be told beside it; of those
    that may use most; of others, what was `found` stays.
    """
    kind, ones = way.held.zones.kind[at], np.ones(way.count)
    flat = way.flat[at]
    held = [of.swings(flat) for of in reaches]
    most = np.stack([_used(kind, *of, strength) for of in held])
    zones = [most[:, kind == zone].max(axis=1, initial=0.0) for zone in range(len(ZONES))]
    first = np.stack([of / max(of.max(), 1e-300) for of in zones]).max(axis=0)
    best = found.max(axis=0)
    for k in np.argsort(-first).tolist():
        asked = most[k] > (found[k] if k == told else best)[kind]
        used = _swing_at(way, at[asked], points[k], strength, ones)[0]
        np.maximum.at(found[k], kind[asked], used)
        best = np.maximum(best, found[k])


def _held(o: Outcome, contact: Contact, way: _Way) -> Outcome:
    """Return an outcome with what it asks of the bolts, at the operating point that asks most."""
    among = o.case.among or (o.case,)
    each = [_bare(case, way) for case in among]
    moment, share = contact.worst(np.concatenate(each))
    which = int(np.searchsorted(np.cumsum([len(e) for e in each]), moment, side="right"))
    return replace(o, times=o.case.times, slips=share, slips_at=among[which].point)


def _in_contact(case: Case, contact: Contact, way: _Way) -> Case:
    """Return a case with what contact makes of its swings, where it repeats."""
    if not (contact.strength and case.repeats):
        return case
    return replace(case, times=contact.times(np.split(_bare(case, way), case.places)))


def _in_bolts(
    bolts: Bolts, outcomes: Sequence[Outcome], two_ways: Sequence[FloatArray], life: float
) -> InBolts:
    """Return what contact makes of swings, in the case that uses most of a fatigue limit.

    Of those that its bolts hold.
    """
    lasting = [k for k, o in enumerate(outcomes) if o.times is not None and o.slips <= 1]
    if not lasting:
        nothing = np.full(len(two_ways[0]), np.nan)
        return InBolts(bolts=bolts, when=None, times=nothing, told=nothing)
    k = max(lasting, key=lambda k: float(np.nanmax(outcomes[k].used)))
    times = outcomes[k].times
    assert times is not None
    return InBolts(
        bolts=bolts, when=outcomes[k].case.when, times=times, told=two_ways[k], life_told=life
    )


def _weights(strength: Mapping[Zone, Strength]) -> tuple[float, ...]:
    """Return how much a stress weighs in each zone: a toe bears less than a sheet."""
    if not strength:
        return (1.0,) * len(ZONES)
    sheet = strength["sheet"]
    return tuple(
        sheet.curve.amplitude / strength.get(zone, sheet).curve.amplitude for zone in ZONES
    )


def _outcomes(
    cases: Sequence[Case],
    solved: Solved,
    ways: tuple[_Way, ...],
    error: FloatArray,
    strength: Mapping[Zone, Strength],
    modulus: float,
) -> tuple[list[Outcome], list[list[_Peak]]]:
    """Return what each case does, and the peaks of each way held."""
    both = [_outcome(case, solved, ways, error, strength, modulus) for case in cases]
    return [outcome for outcome, _ in both], [peaks for _, peaks in both]


def _outcome(
    case: Case,
    solved: Solved,
    ways: tuple[_Way, ...],
    error: FloatArray,
    strength: Mapping[Zone, Strength],
    modulus: float,
) -> tuple[Outcome, list[_Peak]]:
    """Return what one case does, the worse of both ways of holding, and the peaks of each.

    In fatigue of so many `times` of its own the stress that is told.
    """
    count = ways[0].count
    times = np.ones(count) if case.times is None else case.times
    if not np.isfinite(case.loads).all():
        loads_of(case.loads)  # which says what is wrong
    hot, mean, amplitude, swung, off = np.zeros((5, count))
    least, spent = np.full((2, count), np.nan)
    span = np.full((count, 2), np.nan)
    swung_ends, eased = list[FloatArray](), list[FloatArray]()
    each_used, each_spent = list[FloatArray](), list[FloatArray]()
    ease = 1.0 if case.times is None else EASED
    best: list[tuple[Found, Found, Found]] = []
    peaks: list[_Peak] = []
    for way in ways:
        loads = way.loads(case)
        places = way.places(loads)
        flat = places.ravel()
        unit = way.unit[flat]
        level, found = _stressed(unit, loads, way.worth)
        best.append(tuple(
            Found(e.value, _point(way.points[flat[e.point]]))
            for e in (found.von_mises, found.highest, found.lowest)
        ))  # type: ignore[arg-type]  # fmt: skip
        level = level.reshape(places.shape)
        level *= way.has[:, None]
        top = places[np.arange(count), level.argmax(axis=1)]
        peaks.append(_Peak.of(way, top, level.max(axis=1)))
        peak, swing = np.abs(loads[:, :3]).max(axis=0), np.ptp(loads[:, :3], axis=0) / 2
        off = np.where(level.max(axis=1) > hot, _misread(way, top, case.read, peak), off)
        hot = np.maximum(hot, level.max(axis=1))
        least = np.fmin(least, np.where(way.has, level.max(axis=1), np.nan))
        passes = np.stack(np.split(loads, case.places))
        held = way.held_by(passes)
        share, m, a = _swing(way, passes, held, strength, times)
        most = way.highest(share)[:, 0]
        each_used.append(share[most])
        worse = share[most] * way.has > swung
        swung = np.where(worse, share[most], swung)
        mean, amplitude = np.where(worse, m[most], mean), np.where(worse, a[most], amplitude)
        doubt = _misread(way, most, case.read, swing) / np.maximum(a[most], 1e-9)
        if strength and case.repeats:
            ends = times * _ends(error + doubt, ease)
            swung_ends.append(np.stack([
                _used(way.kinds, more * m[most], more * a[most], strength) for more in ends
            ]))  # fmt: skip
            does = [Pass(passes, scale=times)]
            worn, done = _worn(way, does, [held], strength)
            kind, low, high = _span(way, worn, does, strength, error + doubt, ease)
            eased.append(kind)
            span = np.fmax(span, np.stack([low, high], axis=-1))
            spent = np.fmax(spent, done)
            each_spent.append(done)
    tight = case.times is not None
    used_within, known = np.full((count, 2), np.nan), _known(ways[0].kinds, strength)
    if swung_ends:
        least_used = [kind for kind, *_ in swung_ends]
        most_used = [np.where(w.has, e[-1], 0.0) for w, e in zip(ways, swung_ends, strict=True)]
        used_within[:, 0] = _kinder(ways, least_used, tight=tight)
        used_within[:, 1] = np.max(most_used, axis=0)
        used_within *= known[:, None]
    sliding = ways[0]
    loads = sliding.loads(case)
    strain = superpose(sliding.influence[..., None], loads)[..., 0]
    bolts = superpose(sliding.reactions, loads)
    motion = loads @ sliding.moves
    life = None
    if strength and case.repeats:
        gauges = _gauge_damage(case, sliding, modulus, strength["sheet"])
        life = Endured(
            when=case.when, spots=known * spent, gauges=gauges,
            turns=case.turns, duration=case.duration, span=known[:, None] * span,
            eased=known * _kinder(ways, eased, tight=tight),
            kinder=known * _kinder(ways, each_spent, tight=tight),
        )  # fmt: skip
    found = Outcome(
        case=case,
        von_mises=max((b[0] for b in best), key=lambda f: f.value),
        highest=max((b[1] for b in best), key=lambda f: f.value),
        lowest=min((b[2] for b in best), key=lambda f: f.value),
        on_edge=_on_edge(solved, case.loads),
        hot=hot,
        error=error * hot + off,
        least=np.nan_to_num(least),
        mean=mean,
        amplitude=amplitude,
        used=known * swung if case.repeats else np.full(count, np.nan),
        used_kinder=(
            known * _kinder(ways, each_used, tight=tight)
            if case.repeats
            else np.full(count, np.nan)
        ),
        used_within=used_within,
        strain=np.stack([strain.min(axis=-1), strain.max(axis=-1)], axis=-1),
        bolts=np.linalg.norm(bolts, axis=-1).max(axis=-1),
        motion=float(np.linalg.norm(motion, axis=-1).max()),
        life=life,
        pulls_off=_pulls_off(solved.nodes, case.loads[:, :3]),
    )
    return found, peaks


def _stressed(
    unit: FloatArray, loads: FloatArray, worth: FloatArray
) -> tuple[FloatArray, Extremes]:
    """Return the highest von Mises stress (m,) Pa of unit stresses (m, c, 6) under loads (t, c).

    And the extremes of all. Of a long history at the moments that lie farthest from no load, and at
    all of them where one of the others may make more: of compression they may.
    """
    outer, ways = outermost(loads, worth)
    level, found = envelope(unit, outer), extremes(unit, outer)
    beyond = superpose(unit, ways.T)
    mises, tension = (
        np.sqrt(np.linalg.eigvalsh(beyond @ of @ beyond.mT).max(axis=1, initial=0.0))
        for of in (_MISES, _SIZE)
    )
    left = np.flatnonzero((mises > level) | (tension > found.highest.value))
    if len(left):
        level[left], also = envelope(unit[left], loads), extremes(unit[left], loads)
        found = Extremes(
            max(found.von_mises, also.at(left).von_mises, key=_value),
            max(found.highest, also.at(left).highest, key=_value),
            min(found.lowest, also.at(left).lowest, key=_value),
        )
    return level, found


def _value(of: Extreme) -> float:
    return of.value


def _misread(way: _Way, at: IntArray, read: Recovered | None, size: FloatArray) -> FloatArray:
    """Return the stress (m,) Pa at places that what gauges read wrong makes of forces (3,) N.

    Nothing where no forces are read from gauges.
    """
    if read is None:
        return np.zeros(len(at))
    each = von_mises(superpose(way.unit[at, :3], read.ways_off(size).T))
    return np.linalg.norm(each, axis=1)


def _pulls_off(nodes: Nodes, forces: FloatArray) -> bool:
    """Return whether the largest of forces (t, 3) N pulls all washers' rings off their frame."""
    rings = np.char.startswith(nodes.face_names, "bolt ") & ~np.char.endswith(
        nodes.face_names, WALL
    )
    a, b, c = (nodes.points[nodes.faces[rings, k]] for k in range(3))
    out = np.cross(b - a, c - a).sum(axis=0)
    largest = forces[np.linalg.norm(forces, axis=1).argmax()]
    size = np.linalg.norm(out) * np.linalg.norm(largest)
    return bool(size > 0 and -out @ largest > _STRAIGHT * size)


def _gauge_damage(case: Case, way: _Way, modulus: float, strength: Strength) -> FloatArray:
    """Return the damage (g,) a pass does at the gauges, by the sheet's curve."""
    passes = np.split(way.loads(case), case.places)
    return np.max([
        gauge_damage(way.influence, one, modulus=modulus, strength=strength) for one in passes
    ], axis=0)  # fmt: skip


def _duty(
    solved: Solved,
    ways: tuple[_Way, ...],
    duty: Mapping[Occasion, Sequence[tuple[float, Case]]],
    strength: Mapping[Zone, Strength],
    modulus: float,
    error: FloatArray,
) -> tuple[list[Endured], FloatArray, list[_Peak]]:
    """Return the mean second of the duty cycle in each state, and the worst one's map.

    The map is damage of an hour (surface nodes,), in the state where it is largest; with it,
    its peaks for each way of holding. Of each feature the worst of all places is told; those that
    are a thousandth as bad as the worst stand in the map by their largest cycle alone.
    """
    spent: list[Endured] = []
    if not strength:
        return spent, np.zeros(0), []
    for when, parts in duty.items():
        if not _passes(ways[0], parts):
            continue
        worst, span = np.zeros(ways[0].count), np.zeros((ways[0].count, 2))
        tight = any(case.times is not None for _, case in parts)
        eased, each = list[FloatArray](), list[FloatArray]()
        for way in ways:
            passes = _passes(way, parts)
            held = [way.held_by(p.loads) for p in passes]
            top, done = _worn(way, passes, held, strength)
            worst = np.maximum(worst, done)
            each.append(done)
            kind, low, high = _span(way, top, passes, strength, error, EASED if tight else 1.0)
            eased.append(kind)
            span = np.maximum(span, np.stack([low, high], axis=-1))
        gauges = [
            (share, Endured(
                when=when, spots=np.zeros(0), turns=case.turns, duration=case.duration,
                gauges=_gauge_damage(case, ways[0], modulus, strength["sheet"]),
            ))
            for share, case in parts
        ]  # fmt: skip
        known = _known(ways[0].kinds, strength)
        spent.append(replace(
            mixed(when, gauges), spots=known * worst, span=known[:, None] * span,
            eased=known * _kinder(ways, eased, tight=tight),
            kinder=known * _kinder(ways, each, tight=tight),
        ))  # fmt: skip
    if not spent:
        return spent, np.zeros(0), []
    state = max(range(len(spent)), key=lambda k: spent[k].worst)
    damage, peaks = np.zeros(len(solved.nodes.surface)), list[_Peak]()
    for way in ways:
        passes = _passes(way, duty[spent[state].when])
        every = _damage(way, np.arange(len(way.feature)), passes, strength, closely=CLOSELY)
        top = way.highest(every)[:, 0]
        peaks.append(_Peak.of(way, top, every[top]))
        damage = np.maximum(damage, every[way.held.zones.told_by])
    return spent, damage * hour, peaks


def _passes(way: _Way, parts: Sequence[tuple[float, Case]]) -> list[Pass]:
    """Return the passes of a mean second of a duty cycle."""
    known = [(share, case) for share, case in parts if case.repeats and case.duration > 0]
    whole = sum(share for share, _ in known)
    return [
        Pass(
            np.stack(np.split(way.loads(case), case.places)), share / whole / case.duration,
            scale=1.0 if case.times is None else case.times,
        )
        for share, case in known
    ]  # fmt: skip


def _worst_first(
    known: tuple[tuple[int, int], ...],
    outcomes: Sequence[Outcome],
    lasting: Sequence[Endured],
    weights: tuple[float, ...],
) -> IntArray:
    """Return the features, the worst first: by damage of a second, else by stress."""
    weight = np.array([weights[kind] for kind, _ in known])
    stress = np.max([o.hot for o in outcomes], axis=0) * weight
    rates = [e.spots / e.duration for e in lasting] or [np.zeros(len(known))]
    damage = np.nan_to_num(np.max(rates, axis=0))
    return np.lexsort((-stress, -damage))


def _spots(peaks: Sequence[_Peak], order: IntArray) -> list[tuple[_Way, int]]:
    """Return how it is held, and the place, where each feature is worst."""
    highest = np.argmax([peak.values for peak in peaks], axis=0)
    return [(peaks[highest[f]].way, int(peaks[highest[f]].places[f])) for f in order.tolist()]


def _forced(swept: Swept, spots: Sequence[tuple[_Way, int]]) -> Forced:
    """Return the response over speed at places."""
    found, rigid = [], []
    for way, at in spots:
        unit, normals = way.unit[[at]], way.held.zones.normals[[at]]
        found.append(
            amplitude(unit, normals, swept.waves, speed=swept.speed, seat=way.held.swing.seat)
        )
        rigid.append(amplitude(unit, normals, swept.rigid, speed=swept.speed))
    return Forced(
        swept=swept, stress=np.concatenate(found, axis=-1), rigid=np.concatenate(rigid, axis=-1)
    )


def _listed(features: Sequence[Feature]) -> int:
    """Return how many features tables show: eight, and on until each zone has been shown."""
    zones = {f.zone for f in features}
    first = [next(k for k, f in enumerate(features) if f.zone == zone) for zone in zones]
    return min(len(features), max(8, *(k + 1 for k in first if k < 16)))


def _sorted(o: Outcome, order: IntArray) -> Outcome:
    """Return an outcome with its features in order."""
    return replace(
        o, hot=o.hot[order], error=o.error[order], mean=o.mean[order],
        amplitude=o.amplitude[order], used=o.used[order], used_kinder=o.used_kinder[order],
        used_within=o.used_within[order],
        least=o.least[order],
        times=None if o.times is None else o.times[order],
        life=o.life.at(order) if o.life else None,
    )  # fmt: skip


def _on_edge(solved: Solved, loads: FloatArray) -> Found:
    """Return the largest von Mises stress at any node of the surface."""
    surface, (stress, worth) = solved.nodes.surface, solved.on_surface
    level = envelope(stress, farthest(loads, worth))
    top = np.argsort(-level)[:_PLACES]
    level = envelope(stress[top], loads)
    worst = int(level.argmax())
    return Found(float(level[worst]), _point(solved.nodes.points[surface[top[worst]]]))


def _point(at: FloatArray) -> tuple[Metre, Metre, Metre]:
    x, y, z = at.tolist()
    return x, y, z


def crossings(
    frequencies: FloatArray, top_speed: RadianPerSecond, *, orders: Sequence[int] = ORDERS
) -> Iterator[Crossing]:
    """Yield the speeds at which orders meet natural frequencies (m,) Hz, up to twice the top."""
    for k, frequency in enumerate(frequencies.tolist(), 1):
        for order in orders:
            speed = 2 * np.pi * frequency / order
            if not speed > 2 * top_speed:
                yield Crossing(k, frequency, order, speed, in_range=bool(speed <= top_speed))
