"""What the joints did to a gauge, as evidence: identified by phase and torque, with its doubt.

A bracket answers whoever shakes it, so a large amplitude at twice the shaft's speed accuses
nobody. Two things tell the joints from a road that shakes the same mode: their force is
locked to the shaft's angle, and it goes with its torque. So what is `locked` is fitted and taken
off: the answer is the share of damage that goes with it, 1 - D(without)/D. What that cannot see
is asked one by one: who else turns so, what stands close `beside` the order, what only comes
with it. Each answer may widen the interval, and says so.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from cardan.base.arrays import BoolArray, ComplexArray, FloatArray
from cardan.base.said import Said
from cardan.fatigue.angle import Angle
from cardan.fatigue.beside import (
    ITS_OWN,
    PULLED,
    above_idle,
    alike,
    coming,
    knocking,
    near,
    pulled,
    running,
    softly,
    strongly,
    surely,
)
from cardan.fatigue.conditioning import bridged
from cardan.fatigue.evidence import (
    ACQUITTED,
    ALIKE,
    BESIDE,
    BORROWED,
    BRIEF,
    CONVICTED,
    DOUBLED,
    FAINT,
    HALVED,
    KNOCKING,
    PASSING,
    PULLING,
    RATTLING,
    SCALED,
    SLIPPING,
    STEADY,
    TONE,
    UNHEARD,
    UNLOADED,
    UNTRUSTED,
    Evidence,
)
from cardan.fatigue.locked import (
    FOUND,
    SLOWEST,
    Aligned,
    Line,
    Scene,
    Search,
    aligned,
    by_bands,
    levelled,
    limited,
    order_line,
    punctual,
    solved,
    wandering,
)
from cardan.fatigue.orders import Rotation

CLEAR = 60.0
"""F from which the interval is that of the draws alone."""
DRAWS = 24
"""Of the interval."""
RIDES = 0.2
"""Seconds that hold what a vehicle's ride puts beside an order, 1 to 2.5 Hz off."""
ALOOF = (7.0, 11.0)
"""Hz beside the order where none of that is."""
STANDS_OUT = 0.15
"""Share of the damage by which what is beside the order exceeds what is farther off."""
COMES = 0.55
"""Share of the energy about order 2 from which it comes with the order: innocent lines had 0.33."""
WHOLLY = 0.85
"""Of that share, from which all of it comes with the order: innocent lines had 0.78."""
FOLLOWS = 0.95
"""Of that share, from which what is there follows the shaft, locked or not: no road reached it."""
SCALES = tuple(1.095**k for k in (-3, -2, -1, 1, 2, 3))
"""Of a speed, that are looked at where its own acquits: each holds what is within 5 % of it."""
SOME = 0.1
"""Share of the damage from which a line that may be theirs lets nobody be acquitted."""
NO_SQUARE = 1.25
"""Of what goes with the speed's square, that goes with a torque and is no unbalance."""
SUDDEN = 0.15
"""Share of the time up to which a strong torque is a matter of seconds."""
HARDLY = 0.25
"""Correlation of crests with the torque below which a torque of seconds brought no damage: of 18
guilty gauges at which it had, all but one (held by other doubts) had 0.33 to 0.92, and of 14
innocent ones whose damage came in such seconds by chance nine had less."""
UNMOVED = 1.01
"""Of what goes with a torque, above which an order that is the same under any explains more."""
ONE_TONE = 0.5
"""Share of the joints' force that is one tone, from which nothing tells it from a tone."""
RIGHT, WRONG = 1e-3, 2e-3
"""Shares of a speed within which it is taken to be right, and from which it is not: ratios come
back to 1e-4, and axle ratios are told in three or four digits."""
WHOLE = 5e-4
"""Share of a wheel's order within which it is a whole one: of a wrong speed 2 % of ratios are."""
LUGS = 13.5
"""Order of a wheel from which it may be that of a tyre's lugs, of which there are 14 and more."""
AS_MUCH = 0.9
"""Of the energy at one scale of a speed, from which another explains as much."""
DIRECTLY = 0.05
"""Share of the time under way in direct gear, from which the engine says how fast the shaft is."""
BESIDES = 5.0
"""Hz from order 2 within which another order takes part in what stands about it."""

Damage = Callable[[FloatArray], float]


@dataclass(frozen=True)
class Identified:
    """The joints' part of a stress, and the evidence for it.

    Attributes
    ----------
    evidence
        What they are answerable for.
    stress : (n,) Pa
        Theirs most likely, as `evidence.removed` says: what is fitted, locked or not, or where
        nothing is locked all that follows order 2 through all frequencies.
    order2 : (n,) Pa
        0-to-peak amplitude of their order 2, as fitted, found or not.
    damage
        Of all of it.
    """

    evidence: Evidence
    stress: npt.NDArray[np.floating]
    order2: FloatArray
    damage: float


@dataclass(frozen=True)
class _Span:
    """What may be theirs, from low to high, and what made it so wide."""

    low: float
    high: float
    doubts: tuple[Said, ...] = ()

    def up_to(self, high: float, *doubts: Said) -> "_Span":
        """Return it with at least so high an end, for some doubts."""
        return _Span(self.low, max(self.high, high), self.doubts + doubts)

    def doubting(self, doubt: Said) -> "_Span":
        """Return it with a doubt more."""
        return replace(self, doubts=(*self.doubts, doubt))

    def down_to(self, low: float, *doubts: Said) -> "_Span":
        """Return it with at most so low an end, for some doubts."""
        return _Span(min(self.low, low), self.high, self.doubts + doubts)


@dataclass(frozen=True, kw_only=True)
class _Case:
    """A stress, and all that may have turned with it, thinned to what order 2 needs.

    Attributes
    ----------
    stress : (n,) Pa
        As recorded, nan where it is not known; `x` (m,) what is left of it, every so manyth.
    rate : Hz
        Of what is left.
    load : (m,)
        The torque over its rms, or where nobody `measured` it, when the shaft turns.
    """

    stress: FloatArray
    x: FloatArray
    every: int
    rate: float
    start: float
    load: FloatArray
    measured: bool
    angle: Angle
    engine: Rotation | None
    engine_orders: Sequence[float]
    wheel: Rotation | None
    damage: Damage

    # ---------------------------------------------------------------- what there is

    @cached_property
    def time(self) -> FloatArray:
        """Return when, (m,) s in the time of the rotations."""
        return self.start + np.arange(self.x.size) / self.rate

    @cached_property
    def y(self) -> FloatArray:
        """Return the stress (m,) without its running mean."""
        return levelled(self.x, self.rate)

    @cached_property
    def whole(self) -> float:
        """Return the damage."""
        return self.damage(self.stress)

    @cached_property
    def options(self) -> list[Aligned]:
        """Return ratios and lags of the speed that the stress goes with, the best first."""
        return aligned(self.search) if self.whole > 0 else []

    @cached_property
    def quiet(self) -> FloatArray:
        """Return `y` with its blows cut down (m,)."""
        return limited(self.y, self.rate)

    @cached_property
    def search(self) -> Search:
        """Return what ratios and lags are looked for in."""
        return Search(self.quiet, self.load, self.angle, self.rate, self.start)

    def other(self, times: float) -> Aligned | None:
        """Return the best ratio and lag of what turns so often as far, if it explains more."""
        over = self.options[0].energy
        found = aligned(self.search, times=times, over=over)
        return found[0] if found and found[0].energy > over else None

    def scene(self, option: Aligned, angle: Angle | None = None) -> Scene:
        """Return what turns by an angle, else the shaft's, with a ratio and lag."""
        angle = angle or self.angle
        shifted = self.time - option.lag
        stretch = angle.stretches(shifted)
        return Scene(
            option.ratio * angle.rotation.at(shifted) + option.zeros[stretch],
            option.ratio * angle.rotation.speed(shifted), self.load, self.rate, stretch,
        )  # fmt: skip

    def late(self, option: Aligned, angle: Angle | None = None) -> Aligned:
        """Return an option with the lag that its response tells."""
        return punctual(option, self.scene(option, angle), self.quiet, most=self.angle.lag)

    @cached_property
    def held(self) -> tuple[Aligned, Line]:
        """Return the ratio and lag that explain most, and order 2 as fitted so.

        Bands know a lag roughly; whether there is any says the fit itself.
        """
        late = self.late(self.options[0])
        line = order_line(self.scene(late), self.y, 2, most=2)
        if late.lag:
            none = replace(late, lag=0.0, lags=(min(late.lags[0], 0.0), max(late.lags[1], 0.0)))
            other = order_line(self.scene(none), self.y, 2, most=2)
            if self.left(other) <= self.left(line):
                return none, other
        return late, line

    def left(self, line: Line) -> float:
        """Return the energy that a line leaves, its blows cut down."""
        return float((limited(self.y - line.wave.real, self.rate) ** 2).sum())

    @cached_property
    def first(self) -> Aligned:
        """Return the ratio and lag that explain most."""
        return self.held[0]

    @cached_property
    def best(self) -> Scene:
        """Return what turns so."""
        return self.scene(self.first)

    @cached_property
    def line(self) -> Line:
        """Return order 2 as fitted."""
        return self.held[1]

    @cached_property
    def losing(self) -> BoolArray:
        """Return where the angle is lost (m,)."""
        return self.angle.losing(self.time)

    # ---------------------------------------------------------------- what is theirs

    def removed(self, wave: FloatArray) -> float:
        """Return the share of damage that goes with a wave (m,)."""
        return self.taken(self.at_all(wave))

    def taken(self, theirs: npt.NDArray[np.floating]) -> float:
        """Return the share of damage that goes with a stress (n,)."""
        return 1 - self.damage(self.stress - theirs) / self.whole

    @cached_property
    def unheard(self) -> float:
        """Return the share of damage done while its speed is not known, or is below nought."""
        time = self.start + np.arange(self.stress.size) / (self.rate * self.every)
        said = ~(self.angle.unsaid(time) | self.angle.below(time))
        if said.all() or not self.whole > 0:
            return 0.0
        return 1 - self.damage(self.stress[said]) / self.whole if said.any() else 1.0

    def at_all(self, wave: FloatArray) -> npt.NDArray[np.floating]:
        """Return a wave (m,) at all samples (n,)."""
        return _back(wave, self.every, self.stress.size)

    def size(self, wave: ComplexArray) -> FloatArray:
        """Return the amplitude (n,) at all samples of a wave (m,)."""
        place = np.arange(self.stress.size, dtype=float)
        return np.interp(place, place[:: self.every][: self.x.size], np.abs(wave))

    @cached_property
    def _thin(self) -> float:
        return self.damage(self.x)

    def among(self, wave: FloatArray) -> float:
        """Share removed among the thinned samples: how waves differ shows there as well."""
        return 1 - self.damage(self.x - wave) / self._thin if self._thin > 0 else self.removed(wave)

    def close(self, x: FloatArray, *, span: float = 0.5, aside: float = 0.0) -> FloatArray:
        """Return all (m,) that a span of some seconds holds near order 2, or so many Hz aside."""
        return near(x, self.best, self.rate, span=span, beside=aside)

    # ---------------------------------------------------------------- what else may be theirs

    def besides(self, wave: FloatArray) -> FloatArray:
        """Return a wave, and all that is near order 2 where the angle is lost."""
        return np.where(self.losing, self.close(self.x, span=RIDES), wave)

    def beside(
        self, known: FloatArray, where: FloatArray | float = 1.0, of: FloatArray | None = None
    ) -> tuple[float, float]:
        """Return what goes with all `of` it close to order 2, and how much less farther off."""
        rest = (self.x if of is None else of) - known
        close, *off = (
            self.among(known + where * self.close(rest, span=RIDES, aside=b))
            for b in (0.0, *ALOOF, *(-k for k in ALOOF))
        )
        return close, close - max(off)

    def elsewhere(self, span: _Span) -> _Span:
        """Widen by what may be theirs if the speed is another's, at half or twice the shaft's."""
        for times, doubt in ((2.0, DOUBLED), (0.5, HALVED)):
            if found := self.other(times):
                asked = replace(self.angle, rotation=self.angle.rotation.geared(times))
                theirs = self.late(found, asked)
                scene = self.scene(theirs, asked)
                # What turns once a turn with the speed's square is unbalance, seen roughly first.
                by_torque, by_speed = by_bands(scene, self.y, 2)
                if NO_SQUARE * by_torque < by_speed:
                    continue
                other = order_line(scene, self.y, 2, most=2)
                by_torque, by_speed = (solved(other.columns[k::2], self.y)[1] for k in (0, 1))
                clearly = NO_SQUARE * by_speed if self.measured else by_speed
                if by_torque > clearly and other.strength >= FOUND:
                    share = self.removed(other.wave.real) + 0.05
                    if share > span.high:
                        span = span.up_to(share, doubt)
        return self.scaled(span) if span.high <= ACQUITTED else span

    def scaled(self, span: _Span) -> _Span:
        """Widen by what may be theirs if the speed's scale is off, as by a wrong number of teeth.

        What is no engine's that was heard, and not the same under any torque, may be order 2 of
        another shaft than turned so.
        """
        other = self.aside if self.measured else None
        if other is None or other.steady:
            return span
        may = () if self.engine is None else self.engine_orders
        if alike(other.best, self.engine, may, self.time) is None:
            share = self.removed(other.line.wave.real)
            if share > SOME:
                return span.up_to(max(share, ACQUITTED) + 0.05, SCALED)
        return span

    @cached_property
    def aside(self) -> "_Case | None":
        """Return the case by another scale of the speed, if more is locked there; None if not.

        No order of a shaft lies at 1.79 times its speed: what is locked there is another's.
        """
        if not self.angle.measured:
            return None
        found = [(best.energy, times) for times in SCALES if (best := self.other(times))]
        if not found:
            return None
        turning = self.angle.rotation.geared(max(found)[1])
        other = replace(self, angle=replace(self.angle, rotation=turning))
        return other if other.line.strength >= FOUND else None

    @cached_property
    def steady(self) -> bool:
        """Return whether order 2 is locked, and explained better without the torque than with it.

        The joints' goes with the torque, turns its sign with it, and where rubber or a stop yields
        ever less grows as its root: within each band of frequency, where the bracket is one. An
        order 2 of other descent, of a wheel's or a bent flange, knows no torque. Each is asked at
        the ratio and lag of the speed that suits it best, or a turn's slip stands for a sign.
        """
        if not self.measured:
            return False
        alone = replace(self, load=np.ones_like(self.load))
        root = replace(self, load=np.sign(self.load) * np.sqrt(np.abs(self.load)))
        return (
            all(alone.options[0].energy > UNMOVED * law.options[0].energy for law in (self, root))
            and alone.line.strength >= FOUND
        )

    @property
    def borrowed(self) -> bool:
        """Return whether what is locked goes with a speed that is not the shaft's.

        The joints' goes with another scale than 1 where the speed's is wrong. But in direct gear
        the engine's says what it is; and where a wheel's order turns as fast, of lugs above all,
        the wheel needs no such chance. Angles that ride put as much on either side of order 2.
        """
        ratio, most = self.first.ratio, self.first.energy
        off = abs(ratio - 1) >= WRONG and not any(
            min(abs(o.ratio - 1), abs(o.ratio + ratio - 2)) < WRONG and o.energy > AS_MUCH * most
            for o in self.options
        )
        shaft = self.angle.rotation.speed(self.time)
        turning = shaft > SLOWEST / 2
        if off and self.engine is not None and turning.any():
            own = self.engine.speed(self.time)[turning] / shaft[turning]
            if np.mean(np.abs(own - 1) < RIGHT) > DIRECTLY:
                return True
        order = ratio * self.rolling
        return order > (0 if off else LUGS) and abs(order - round(order)) < WHOLE * order

    @cached_property
    def rolling(self) -> float:
        """Return which order of the wheels order 2 is; 0 where no axle's ratio is known."""
        if self.wheel is None:
            return 0.0
        shaft, wheel = (float(np.ptp(r.at(self.time))) for r in (self.angle.rotation, self.wheel))
        return 2 * shaft / wheel if wheel > 0 else 0.0

    @cached_property
    def toned(self) -> bool:
        """Return whether what the joints do is one tone: its energy is in one line of a spectrum.

        Any other of about that frequency, there all the time, is then as surely locked.
        """
        from scipy.fft import fft, next_fast_len

        force = self.best.inputs(2)[0]
        # Between two lines of a spectrum twice as long a tone keeps four fifths of its energy.
        lines = fft(force.astype(np.complex64), next_fast_len(2 * force.size))
        energy = force.size * float(np.vdot(force, force).real)
        return float(np.abs(lines).max()) ** 2 > ONE_TONE * energy

    def following(self) -> tuple[float, float, FloatArray] | None:
        """Share, at least and likely, of what follows order 2 where no engine may, and that (m,).

        It needs no angle: only what turns with the shaft goes through all frequencies with it.
        So does any order of an engine that nobody heard, in some gear. None of what does not.
        """
        if self.engine is None:
            where = ~above_idle(self.best)
        else:
            # Whatever of an engine comes into the band that is looked at, a second off it too.
            may = running(self.best, self.engine, self.engine_orders, self.time, within=BESIDES)
            may |= running(self.best, self.engine, (ITS_OWN,), self.time, within=0.5)
            where = ~(softly(may, self.rate) > 0)
        # Nor of a blow, which comes when it comes.
        if not coming(self.quiet, self.best, self.rate, where=where) > FOLLOWS:
            return None
        close, more = self.beside(np.zeros_like(self.x), np.where(where, 1.0, 0.0), of=self.quiet)
        return (more, close, where * self.close(self.quiet, span=RIDES)) if more > 0 else None

    def sudden(self, rest: FloatArray, span: _Span) -> _Span:
        """Widen by what may be theirs if it comes with a torque that lasts for seconds only.

        Where crests do not go with the torque at all, what comes in its seconds came by chance.
        """
        strong = strongly(self.load, self.rate)
        if 0 < strong.mean() < SUDDEN and not self.pulled < HARDLY:
            swings = levelled(rest, self.rate) - self.swinging
            share = self.removed(np.where(strong, swings, 0.0) + (self.x - rest))
            if share > ACQUITTED:
                span = span.up_to(share + 0.05, BRIEF)
        return span

    @cached_property
    def swinging(self) -> FloatArray | float:
        """Return what swings with the torque itself (m,): load, whoever turns."""
        if not self.measured:
            return 0.0
        pull = levelled(self.load, self.rate)
        return pull * float(pull @ self.y) / max(float(pull @ pull), 1e-300)

    def passing(self, rest: FloatArray, span: _Span) -> _Span:
        """Widen by what may be theirs if it comes and goes with order 2, not locked to it."""
        if (comes := coming(rest, self.best, self.rate)) > COMES:
            span = span.up_to(self.removed(self.close(self.x, span=RIDES / 2)) + 0.05, PASSING)
            # Nobody knows what that knocks loose elsewhere, nor, without a torque, when.
            if comes > WHOLLY or not self.measured:
                span = span.up_to(ACQUITTED + 0.05)
        return span

    @cached_property
    def pull(self) -> FloatArray:
        """Return how hard they pull (m,): by the torque, or by order 2 where nobody measured it."""
        return np.abs(self.load) if self.measured else np.abs(self.line.wave) ** 2

    @cached_property
    def pulled(self) -> float:
        """Return how all crests go with that, a correlation; nan where nothing tells it."""
        return self.going(0.0)

    def going(self, wave: FloatArray | float) -> float:
        """Return how the crests of what a wave (m,) leaves go with their pull, a correlation."""
        turning = self.best.speed > SLOWEST / 2
        return pulled(self.y - self.swinging - wave, self.pull, turning, self.rate)

    def pulling(self, wave: FloatArray, span: _Span) -> _Span:
        """Open the end where crests go with their pull, as of a stop that the line stands on.

        How much of the damage would be left without it no line's wave (m,) tells. Where they are
        found, or nobody is acquitted, it takes less: without a stop nothing beside the wave goes
        with their pull.
        """
        innocent = span.high <= ACQUITTED
        goes = innocent and self.pulled > PULLED
        if not innocent or self.line.strength >= FOUND:
            goes = goes or self.going(wave) > HARDLY
        return span.up_to(1.0, PULLING if self.measured else KNOCKING) if goes else span


# --------------------------------------------------------------------------- the question


def identified(
    stress: FloatArray,
    *,
    rate: float,
    angle: Angle,
    torque: FloatArray | None,
    damage: Damage,
    engine: Rotation | None = None,
    engine_orders: Sequence[float] = (),
    wheel: Rotation | None = None,
    start: float = 0.0,
    seed: int = 0,
) -> Identified:
    """Ask what the joints did to a stress (n,).

    Parameters
    ----------
    stress : (n,) Pa
        Of the gauge, nan where it is not known.
    rate : Hz
        Of its samples.
    angle
        Of the shaft.
    torque : (n,) N m
        At the shaft; None where nobody measured it.
    damage
        Of a stress (n,).
    engine, engine_orders
        Who else may turn twice a shaft turn: of an engine nobody heard, if its order 2 may be.
    wheel
        Behind the axle, where its ratio is known.
    start : s
        Of the first sample, in the time of the rotations.
    seed
        Of the draws.
    """
    every = max(int(rate // 400), 1)
    x = _thinned(bridged(stress), every)
    fine = rate / every
    load = None
    if torque is not None:
        load = bridged(torque)[every // 2 :: every][: x.size]
        load = np.pad(load, (0, x.size - load.size), mode="edge")
    if load is None or not np.abs(load).max() > 0:
        load = np.where(angle.rotation.speed(start + np.arange(x.size) / fine) > 0.5, 1.0, 0.0)
    case = _Case(
        stress=stress, x=x, every=every, rate=fine, start=start,
        load=load / max(float(np.sqrt(np.mean(load**2))), 1e-300), measured=torque is not None,
        angle=angle.within(start, start + x.size / fine),
        engine=engine, engine_orders=engine_orders, wheel=wheel, damage=damage,
    )  # fmt: skip
    if not case.options:
        nothing = Evidence(removed=0.0, interval=(0.0, 0.0), strength=0.0)
        nothing = nothing.with_unheard(case.unheard)
        return Identified(nothing, np.zeros(stress.size), np.zeros(stress.size), case.whole)
    answer = _not_locked(case) if case.line.strength < FOUND else _locked(case, seed)
    return replace(answer, evidence=answer.evidence.with_unheard(case.unheard))


def _not_locked(case: _Case) -> Identified:
    """Answer where nothing is locked to the shaft: what might be theirs all the same."""
    wave = case.line.wave.real
    theirs = case.at_all(wave)
    likely, own = max(case.taken(theirs), 0.0), case.among(wave)
    reach = likely
    for option in case.options[1:]:
        columns = case.scene(option).columns(2)
        # How far another lies from it shows among the thinned samples as well as among all.
        more = case.among((solved(columns, case.y)[0] @ columns).real) - own
        reach = max(reach, likely + more)
    # The same doubt at both ends: what does so little may spare the part, by chance or a stop.
    doubt = 0.3 * reach + 0.03
    span = _Span(-doubt, reach + doubt)
    if not (case.angle.trusted and case.measured):
        # Who knows no torque does not know where the joints' force turns its sign.
        all_near = max(case.among(case.close(case.x, span=held)) for held in (0.5, RIDES))
        why = UNLOADED if case.angle.trusted else UNTRUSTED
        span = span.up_to(max(span.high, likely + all_near - own) + 0.05, why)
    if not case.angle.measured:
        span = span.up_to(ACQUITTED + 0.05)
    else:
        close, more = case.beside(np.zeros_like(case.x))
        if more > STANDS_OUT:
            span = span.up_to(close + 0.05, BESIDE)
    if case.losing.any():
        span = span.up_to(case.removed(case.besides(wave)) + 0.05)
    span = case.sudden(case.x, case.elsewhere(span))
    if span.high <= ACQUITTED:
        span = case.passing(case.x, span)
    span = case.pulling(wave, span)
    low, high = span.low, min(span.high, 1.0)
    if there := case.following():
        low, likely = min(there[:2]) - 0.01, max(likely, there[1])
        theirs = case.at_all(there[2])
        span = span.doubting(PASSING)
        if low >= CONVICTED and case.aside:
            low, span = 0.0, span.doubting(SCALED)
        if low >= CONVICTED and case.steady:
            low, span = 0.0, span.doubting(STEADY)
        # Lugs follow the shaft too, an order of the wheels or two beside.
        if low >= CONVICTED and case.rolling > LUGS:
            low, span = 0.0, span.doubting(BORROWED)
    found = _told(case, float(np.clip(likely, 0.0, high)), min(low, high), high, span.doubts)
    return Identified(found, theirs, case.size(case.line.wave), case.whole)


def _locked(case: _Case, seed: int) -> Identified:
    """Answer where something is locked: its share by draws, and what it may leave out."""
    line, x = case.line, case.x
    theirs = _theirs(case)
    rng = np.random.default_rng(seed)
    mean = theirs.wave()
    whole = case.at_all(mean)
    middle, own = case.taken(whole), case.among(mean)
    if middle < 0 and case.following():
        # What is held of it does harm: the angle slips, and what follows the shaft tells more.
        return _not_locked(case)
    # How far draws lie from it shows among the thinned samples as well as among all.
    drawn = middle - own + np.array([case.among(theirs.wave(rng)) for _ in range(DRAWS)])
    low, high = (float(v) for v in np.quantile(drawn, [0.05, 0.95]))
    # What the model leaves out of a bracket: most where half of the damage is at stake.
    margin = 0.03 + 0.1 * max(middle * (1 - middle), 0.0)
    span = _Span(min(low, middle) - margin, max(high, middle) + margin)
    # What it leaves close to the order, over what it leaves elsewhere, may be theirs as well.
    close, more = case.beside(mean)
    if more > 0:
        span = span.up_to(span.high + min(more, max(close - own, 0.0)))
        if more > STANDS_OUT:
            span = span.doubting(BESIDE)
    if not case.measured:
        span = span.up_to(close, UNLOADED)
    if line.strength < CLEAR:
        span = span.down_to(span.low - 0.1).up_to(span.high + 0.1, FAINT)
        if middle > 0.3:  # an angle that slips loses some of what is theirs
            span = span.up_to(case.removed(case.close(x)) + 0.05)
    # The shaft does all that is there, and little of it is held, or nobody measured when it pulls:
    # what that knocks loose elsewhere, at a stop above all, nobody knows.
    unclear = line.strength < CLEAR or not case.measured
    if unclear and coming(x, case.best, case.rate) > WHOLLY:
        span = span.up_to(ACQUITTED + 0.05, PASSING)
    if middle < 0:  # theirs taken off does more damage: the angle slips where it matters
        span = span.up_to(max(case.removed(case.close(x)), 0.05), SLIPPING)
    if case.losing.any():
        span = span.up_to(case.removed(case.besides(mean)))
    if any(one.order == 6 for one in theirs.lines):
        span = span.up_to(1.0 if span.high > 0.3 else span.high + 0.3, RATTLING)
    if not case.angle.trusted:
        # Something is theirs, and what that knocks loose elsewhere no lost angle can follow.
        span = span.up_to(max(case.removed(case.close(x)), ACQUITTED + 0.05), UNTRUSTED)
        span = span.down_to(0.5 * middle)
    sure = _sure(case, mean, theirs.left + line.wave.real, margin)
    if sure is not None and sure < span.low:
        span = span.down_to(sure, UNHEARD if case.engine is None else ALIKE)
    if span.low < CONVICTED and (there := case.following()):
        span = span.doubting(SCALED) if case.aside else replace(
            span, low=max(span.low, min(there[0], middle))
        )  # fmt: skip
    if span.low >= CONVICTED and case.steady:
        span = span.down_to(0.0, STEADY)
    if span.low >= CONVICTED and case.borrowed:
        span = span.down_to(0.0, BORROWED)
    if span.low >= CONVICTED and case.toned:
        span = span.down_to(0.0, TONE)
    span = case.sudden(x - mean, span)
    if span.high <= ACQUITTED:
        span = case.elsewhere(span)
        if case.angle.trusted and span.high <= ACQUITTED:
            span = case.passing(x - mean, span)
    knocks = knocking(x - mean, line.wave, case.rate)
    if knocks.any():
        span = span.up_to(case.removed(np.where(knocks, case.y, mean)) + 0.05, KNOCKING)
    span = case.pulling(mean, span)
    low, high = (float(v) for v in np.clip([span.low, span.high], -1.0, 1.0))
    found = _told(case, float(np.clip(middle, low, high)), low, high, span.doubts)
    return Identified(
        replace(found, modes=line.poles), whole, case.size(theirs.second()),
        case.whole,
    )  # fmt: skip


def _told(
    case: _Case, removed: float, low: float, high: float, doubts: tuple[Said, ...]
) -> Evidence:
    """Return a share and its interval as evidence, each doubt once."""
    return Evidence(
        removed=removed, interval=(low, high), strength=case.line.strength,
        ratio=case.first.ratio, lag=case.first.lag, lags=case.first.lags,
        doubts=tuple(dict.fromkeys(doubts)),
    )  # fmt: skip


def _sure(case: _Case, mean: FloatArray, own: FloatArray, margin: float) -> float | None:
    """Share that is theirs at least where an engine may turn with the shaft; None if none may.

    Of an engine that was heard all that runs with order 2 is taken for its own; of one that nobody
    heard, what its spells do not have in common in `own`: order 2 and all that nothing explains.
    """
    may = alike(case.best, case.engine, case.engine_orders, case.time)
    if may is None:
        return None
    if case.engine is None:
        best = case.best
        given = case.scene(replace(case.first, ratio=1.0)).turns
        sure = surely(may, case.line.wave, own, stretch=best.stretch, turns=best.turns, given=given)
        share = softly(sure, case.rate)
        return case.removed(mean * share) - margin
    heard = np.where(may, 0.0, 1.0)
    share = softly(heard, case.rate)
    sure = case.removed(mean * share) - margin
    return min(sure, 0.0) if share.mean() < 0.5 else sure


@dataclass(frozen=True)
class _Theirs:
    """Lines of the joints, how each wanders, and what they leave of a stress (m,)."""

    lines: tuple[Line, ...]
    gains: tuple[tuple[FloatArray, ComplexArray, FloatArray], ...]
    left: FloatArray
    since: FloatArray

    def wave(self, rng: np.random.Generator | None = None) -> FloatArray:
        """Return all of them (m,): as is most likely, or as drawn."""
        total = np.zeros(self.since.size)
        for one, (middle, gain, sigma) in zip(self.lines, self.gains, strict=True):
            z = one.wave
            if rng is not None:
                k = one.noise.shape[0]
                mix = (rng.normal(size=k) + 1j * rng.normal(size=k)) / np.sqrt(2 * k)
                # Of what noise might have made of it four digits are plenty.
                z = z + (mix @ one.noise).astype(np.complex64) @ one.coarse
                gain = gain + sigma * (
                    rng.normal(size=gain.size) + 1j * rng.normal(size=gain.size)
                ) / np.sqrt(2)
            total += (self._slow(middle, gain) * z).real
        return total

    def second(self) -> ComplexArray:
        """Return order 2 (m,) as it wanders."""
        middle, gain, _ = self.gains[0]
        return self._slow(middle, gain) * self.lines[0].wave

    def _slow(self, middle: FloatArray, gain: ComplexArray) -> ComplexArray:
        return np.asarray(np.interp(self.since, middle, gain), np.complex128)


def _theirs(case: _Case) -> _Theirs:
    """Return order 2, with orders 4 and 6 if they are locked too, as they wander."""
    lines, left = [case.line], case.y - case.line.wave.real
    for order in (4, 6):
        more = order_line(case.best, left, order, most=1 if order == 4 else 0)
        if more.strength >= FOUND:
            lines.append(more)
            left = left - more.wave.real
    # With the other orders out of the way each is fitted once more, wandering.
    gains = tuple(wandering(one, left + one.wave.real, case.rate) for one in lines)
    return _Theirs(tuple(lines), gains, left, np.arange(case.x.size) / case.rate)


def _thinned(x: FloatArray, every: int) -> FloatArray:
    """Every so manyth sample (n / every,) of what half of them can hold."""
    if every == 1:
        return x
    from scipy.signal import resample_poly

    return resample_poly(x, 1, every, padtype="line")


def _back(wave: FloatArray, every: int, n: int) -> npt.NDArray[np.floating]:
    """Return a thinned wave at all samples (n,)."""
    if every == 1:
        return wave
    from scipy.signal import resample_poly

    # Seven digits of it are taken off a stress.
    out = resample_poly(wave.astype(np.float32), every, 1)[:n]
    return np.pad(out, (0, n - out.size))
