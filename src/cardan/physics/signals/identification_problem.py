"""What the joints' part of a stress is identified from, and what widens the doubt about it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import BoolArray, ComplexArray, FloatArray
from cardan.core.finding import Finding
from cardan.physics.signals.attribution_result import (
    DOUBT_BUMP_STOP_IMPACTS,
    DOUBT_DOUBLE_SPEED,
    DOUBT_HALF_SPEED,
    DOUBT_INTERMITTENT_SIDEBANDS,
    DOUBT_LINE_RESTS_ON_BUMP_STOP,
    DOUBT_SHORT_TORQUE_PULSE,
    DOUBT_SPEED_SCALE,
    NOT_DOMINANT_MAX_SHARE,
)
from cardan.physics.signals.confounders import (
    MIN_TORQUE_CORRELATION,
    ROTATION_ORDER,
    above_idle,
    engine_order_overlap,
    high_torque_mask,
    intermittent_energy_share,
    near_order,
    order_overlap,
    smooth_share_over_one_second,
    torque_correlation,
)
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.shaft_angle import ShaftAngle
from cardan.physics.signals.speed_alignment import (
    MIN_ORDER_FREQUENCY_HZ,
    SampledShaftMotion,
    SpeedAlignment,
    SpeedAlignmentSearch,
    align_speed,
    estimate_lag,
    remove_running_mean,
)
from cardan.physics.signals.synchronous_fit import (
    MIN_DETECTION_F_STATISTIC,
    OrderFit,
    band_energies,
    clip_impacts,
    fit_order,
    least_squares,
)

RIDE_SIDEBAND_WINDOW_S = 0.2
"""Seconds that hold what a vehicle's ride puts near an order, 1 to 2.5 Hz off."""


SIDEBAND_REFERENCE_OFFSETS_HZ = (7.0, 11.0)
"""Hz next to the order where none of that is."""


MIN_INTERMITTENT_ENERGY_SHARE = 0.55
"""Share of the energy about order 2 from which it comes with the order: else it is up to 0.33."""


FULLY_INTERMITTENT_MIN_ENERGY_SHARE = 0.85
"""Of that share, from which all of it comes with the order: lines without joint damage had 0.78."""


MIN_ORDER2_ENERGY_SHARE_FOLLOWING_SHAFT = 0.95
"""Of that share, from which what is there follows the shaft, locked or not: no road reached it."""


SPEED_CHANNEL_SCALE_CANDIDATES = tuple(1.095**k for k in (-3, -2, -1, 1, 2, 3))
"""Other scales of a speed, tried if its own finds no joints: each covers 5 % around it."""


MIN_RESCALED_SPEED_DAMAGE_SHARE = 0.1
"""Share of the damage from which a line that may be the joints' prevents a low estimate."""


MIN_TORQUE_TO_SPEED_SQUARED_ENERGY_RATIO = 1.25
"""Of what goes with the speed's square, that goes with a torque and is no unbalance."""


MAX_TORQUE_BURST_TIME_SHARE = 0.15
"""Share of the time up to which a strong torque is a matter of seconds."""


MIN_SHORT_TORQUE_CORRELATION = 0.25
"""Correlation of crests with the torque below which a torque of seconds brought no damage: of 18
gauges with joint damage at which it had, all but one (held by other doubts) had 0.33 to 0.92, and
of 14 without it whose damage came in such seconds by chance nine had less."""


MIN_CONSTANT_TO_TORQUE_LAW_ENERGY_RATIO = 1.01
"""Of what goes with a torque, above which an order that is the same under any explains more."""


MIN_SINGLE_TONE_ENERGY_SHARE = 0.5
"""Share of the joints' force that is one tone, from which it passes for a tone alone."""


MAX_RELATIVE_SPEED_ERROR_IF_CORRECT, MIN_RELATIVE_SPEED_ERROR_IF_WRONG = 1e-3, 2e-3
"""Shares of a speed within which it is taken to be right, and from which it is not: ratios come
back to 1e-4, and axle ratios are given in three or four digits."""


MAX_RELATIVE_DISTANCE_TO_WHOLE_ORDER = 5e-4
"""Share of a wheel's order within which it is a whole one: of a wrong speed 2 % of ratios are."""


TYRE_LUG_MIN_ORDER = 13.5
"""Order of a wheel from which it may be that of a tyre's lugs, of which there are 14 and more."""


MIN_EQUIVALENT_SPEED_SCALE_ENERGY_RATIO = 0.9
"""Of the energy at one scale of a speed, from which another explains as much."""


MIN_DIRECT_GEAR_SHARE_OF_DRIVING_TIME = 0.05
"""Share of the time under way in direct gear, from which the engine says how fast the shaft is."""


MAX_ENGINE_ORDER_DISTANCE_HZ = 5.0
"""Hz from order 2 within which another order takes part in what stands about it."""


StressHistoryDamageFunction = Callable[[FloatArray], float]


@dataclass(frozen=True)
class ShareInterval:
    """What may be due to the joints, from low to high, and what made it so wide."""

    low: float
    high: float
    doubts: tuple[Finding, ...] = ()

    def up_to(self, high: float, *doubts: Finding) -> "ShareInterval":
        """Return it with at least so high an end, for some doubts."""
        return ShareInterval(self.low, max(self.high, high), self.doubts + doubts)

    def with_doubt(self, doubt: Finding) -> "ShareInterval":
        """Return it with a doubt more."""
        return replace(self, doubts=(*self.doubts, doubt))

    def down_to(self, low: float, *doubts: Finding) -> "ShareInterval":
        """Return it with at most so low an end, for some doubts."""
        return ShareInterval(min(self.low, low), self.high, self.doubts + doubts)


@dataclass(frozen=True, kw_only=True)
class IdentificationProblem:
    """A stress, and all that may have turned with it, thinned to what order 2 needs.

    Attributes
    ----------
    stress : (n,) Pa
        As recorded, nan where it is not known; `x` (m,) what is left of it, every so manyth.
    rate : Hz
        Of what is left.
    load : (m,)
        The torque over its rms, or if not `measured`, when the shaft turns; 0 before a
        speed is known and after.
    """

    stress: FloatArray
    x: FloatArray
    every: int
    rate: float
    start: float
    load: FloatArray
    measured: bool
    angle: ShaftAngle
    engine: ShaftRotation | None
    engine_orders: Sequence[float]
    wheel: ShaftRotation | None
    damage: StressHistoryDamageFunction

    # ---------------------------------------------------------------- what there is

    @cached_property
    def time(self) -> FloatArray:
        """Return when, (m,) s in the time of the rotations."""
        return self.start + np.arange(self.x.size) / self.rate

    @cached_property
    def y(self) -> FloatArray:
        """Return the stress (m,) without its running mean."""
        return remove_running_mean(self.x, self.rate)

    @cached_property
    def total_damage(self) -> float:
        """Return the damage."""
        return self.damage(self.stress)

    @cached_property
    def alignments(self) -> list[SpeedAlignment]:
        """Return ratios and lags of the speed that the stress goes with, the best first."""
        return align_speed(self.alignment_problem) if self.total_damage > 0 else []

    @cached_property
    def impact_clipped_stress(self) -> FloatArray:
        """Return `y` with its blows cut down (m,)."""
        return clip_impacts(self.y, self.rate)

    @cached_property
    def alignment_problem(self) -> SpeedAlignmentSearch:
        """Return what ratios and lags are looked for in."""
        return SpeedAlignmentSearch(
            self.impact_clipped_stress, self.load, self.angle, self.rate, self.start
        )

    def alignment_at_speed_factor(self, times: float) -> SpeedAlignment | None:
        """Return the best ratio and lag of what turns so often as far, if it explains more."""
        over = self.alignments[0].energy
        found = align_speed(self.alignment_problem, times=times, over=over)
        return found[0] if found and found[0].energy > over else None

    def rotation_of(
        self, option: SpeedAlignment, angle: ShaftAngle | None = None
    ) -> SampledShaftMotion:
        """Return what turns by an angle, else the shaft's, with a ratio and lag."""
        angle = angle or self.angle
        shifted = self.time - option.lag
        stretch = angle.stretch_index(shifted)
        return SampledShaftMotion(
            option.ratio * angle.rotation.at(shifted) + option.stretch_offsets[stretch],
            option.ratio * angle.rotation.speed(shifted), self.load, self.rate, stretch,
        )  # fmt: skip

    def with_estimated_lag(
        self, option: SpeedAlignment, angle: ShaftAngle | None = None
    ) -> SpeedAlignment:
        """Return an option with the lag estimated from its response."""
        return estimate_lag(
            option, self.rotation_of(option, angle), self.impact_clipped_stress, most=self.angle.lag
        )

    @cached_property
    def best_alignment_and_fit(self) -> tuple[SpeedAlignment, OrderFit]:
        """Return the ratio and lag that explain most, and order 2 as fitted so.

        Bands know a lag roughly; whether there is any says the fit itself.
        """
        late = self.with_estimated_lag(self.alignments[0])
        line = fit_order(self.rotation_of(late), self.y, 2, most=2)
        if late.lag:
            none = replace(
                late,
                lag=0.0,
                lag_interval=(min(late.lag_interval[0], 0.0), max(late.lag_interval[1], 0.0)),
            )
            other = fit_order(self.rotation_of(none), self.y, 2, most=2)
            if self.residual_energy(other) <= self.residual_energy(line):
                return none, other
        return late, line

    def residual_energy(self, line: OrderFit) -> float:
        """Return the energy that a line leaves, its blows cut down."""
        return float((clip_impacts(self.y - line.waveform.real, self.rate) ** 2).sum())

    @cached_property
    def best_alignment(self) -> SpeedAlignment:
        """Return the ratio and lag that explain most."""
        return self.best_alignment_and_fit[0]

    @cached_property
    def best_rotation(self) -> SampledShaftMotion:
        """Return what turns so."""
        return self.rotation_of(self.best_alignment)

    @cached_property
    def order2_fit(self) -> OrderFit:
        """Return order 2 as fitted."""
        return self.best_alignment_and_fit[1]

    @cached_property
    def angle_is_lost(self) -> BoolArray:
        """Return where the angle is lost (m,)."""
        return self.angle.is_lost(self.time)

    # ---------------------------------------------------------------- what is due to the joints

    def damage_share_of_wave(self, wave: FloatArray) -> float:
        """Return the share of damage that goes with a wave (m,)."""
        return self.damage_share_of_stress(self.at_full_rate(wave))

    def damage_share_of_stress(self, theirs: npt.NDArray[np.floating]) -> float:
        """Return the share of damage that goes with a stress (n,)."""
        return 1 - self.damage(self.stress - theirs) / self.total_damage

    def at_full_rate(self, wave: FloatArray) -> npt.NDArray[np.floating]:
        """Return a wave (m,) at all samples (n,)."""
        return restore_rate(wave, self.every, self.stress.size)

    def amplitude_at_full_rate(self, wave: ComplexArray) -> FloatArray:
        """Return the amplitude (n,) at all samples of a wave (m,)."""
        place = np.arange(self.stress.size, dtype=float)
        return np.interp(place, place[:: self.every][: self.x.size], np.abs(wave))

    @cached_property
    def _thin(self) -> float:
        return self.damage(self.x)

    def decimated_damage_share(self, wave: FloatArray) -> float:
        """Share removed among the thinned samples: how waves differ shows there as well."""
        return (
            1 - self.damage(self.x - wave) / self._thin
            if self._thin > 0
            else self.damage_share_of_wave(wave)
        )

    def near_order2(self, x: FloatArray, *, span: float = 0.5, aside: float = 0.0) -> FloatArray:
        """Return all (m,) that a span of some seconds holds near order 2, or so many Hz aside."""
        return near_order(x, self.best_rotation, self.rate, span=span, beside=aside)

    # ---------------------------------------------------------------- what else may be due to the
    # joints

    def with_lost_angle_part(self, wave: FloatArray) -> FloatArray:
        """Return a wave, and all that is near order 2 where the angle is lost."""
        return np.where(
            self.angle_is_lost, self.near_order2(self.x, span=RIDE_SIDEBAND_WINDOW_S), wave
        )

    def sideband_shares(
        self, known: FloatArray, where: FloatArray | float = 1.0, of: FloatArray | None = None
    ) -> tuple[float, float]:
        """Return what goes with all `of` it close to order 2, and how much less farther off."""
        rest = (self.x if of is None else of) - known
        close, *off = (
            self.decimated_damage_share(
                known + where * self.near_order2(rest, span=RIDE_SIDEBAND_WINDOW_S, aside=b)
            )
            for b in (
                0.0,
                *SIDEBAND_REFERENCE_OFFSETS_HZ,
                *(-k for k in SIDEBAND_REFERENCE_OFFSETS_HZ),
            )
        )
        return close, close - max(off)

    def widen_for_other_speeds(self, span: ShareInterval) -> ShareInterval:
        """Widen by what the joints may do if the speed is half or twice the shaft's."""
        for times, doubt in ((2.0, DOUBT_DOUBLE_SPEED), (0.5, DOUBT_HALF_SPEED)):
            if found := self.alignment_at_speed_factor(times):
                asked = replace(self.angle, rotation=self.angle.rotation.geared(times))
                theirs = self.with_estimated_lag(found, asked)
                scene = self.rotation_of(theirs, asked)
                # What turns once a turn with the speed's square is unbalance, seen roughly first.
                by_torque, by_speed = band_energies(scene, self.y, 2)
                if MIN_TORQUE_TO_SPEED_SQUARED_ENERGY_RATIO * by_torque < by_speed:
                    continue
                other = fit_order(scene, self.y, 2, most=2)
                by_torque, by_speed = (
                    least_squares(other.columns[k::2], self.y)[1] for k in (0, 1)
                )
                clearly = (
                    MIN_TORQUE_TO_SPEED_SQUARED_ENERGY_RATIO * by_speed
                    if self.measured
                    else by_speed
                )
                if by_torque > clearly and other.f_statistic >= MIN_DETECTION_F_STATISTIC:
                    share = self.damage_share_of_wave(other.waveform.real) + 0.05
                    if share > span.high:
                        span = span.up_to(share, doubt)
        return self.widen_for_speed_scale(span) if span.high <= NOT_DOMINANT_MAX_SHARE else span

    def widen_for_speed_scale(self, span: ShareInterval) -> ShareInterval:
        """Widen by what may be due to the joints if the speed's scale is wrong, as by teeth.

        What is not of a measured engine, and not the same under any torque, may be order 2 of
        another shaft than turned so.
        """
        other = self.other_scale_problem if self.measured else None
        if other is None or other.is_torque_independent:
            return span
        may = () if self.engine is None else self.engine_orders
        if engine_order_overlap(other.best_rotation, self.engine, may, self.time) is None:
            share = self.damage_share_of_wave(other.order2_fit.waveform.real)
            if share > MIN_RESCALED_SPEED_DAMAGE_SHARE:
                return span.up_to(max(share, NOT_DOMINANT_MAX_SHARE) + 0.05, DOUBT_SPEED_SCALE)
        return span

    @cached_property
    def other_scale_problem(self) -> "IdentificationProblem | None":
        """Return the case by another scale of the speed, if more is locked there; None if not.

        No order of a shaft lies at 1.79 times its speed: what is locked there is another's.
        """
        if not self.angle.measured:
            return None
        found = [
            (best.energy, times)
            for times in SPEED_CHANNEL_SCALE_CANDIDATES
            if (best := self.alignment_at_speed_factor(times))
        ]
        if not found:
            return None
        turning = self.angle.rotation.geared(max(found)[1])
        other = replace(self, angle=replace(self.angle, rotation=turning))
        return other if other.order2_fit.f_statistic >= MIN_DETECTION_F_STATISTIC else None

    @cached_property
    def is_torque_independent(self) -> bool:
        """Return whether order 2 is locked, and explained better without the torque than with it.

        The joints' goes with the torque, turns its sign with it, and where rubber or a stop yields
        ever less grows as its root: within each band of frequency, where the bracket is one. An
        order 2 of other descent, of a wheel's or a bent flange, knows no torque. Each is evaluated
        at the ratio and lag of the speed that suits it best, or a turn's slip stands for a sign.
        """
        if not self.measured:
            return False
        alone = replace(self, load=np.ones_like(self.load))
        root = replace(self, load=np.sign(self.load) * np.sqrt(np.abs(self.load)))
        return (
            all(
                alone.alignments[0].energy
                > MIN_CONSTANT_TO_TORQUE_LAW_ENERGY_RATIO * law.alignments[0].energy
                for law in (self, root)
            )
            and alone.order2_fit.f_statistic >= MIN_DETECTION_F_STATISTIC
        )

    @property
    def has_foreign_speed(self) -> bool:
        """Return whether what is locked goes with a speed that is not the shaft's.

        The joints' goes with another scale than 1 where the speed's is wrong. But in direct gear
        the engine's says what it is; and where a wheel's order turns as fast, of lugs above all,
        the wheel needs no such chance. Angles that ride put as much on either side of order 2.
        """
        ratio, most = self.best_alignment.ratio, self.best_alignment.energy
        off = abs(ratio - 1) >= MIN_RELATIVE_SPEED_ERROR_IF_WRONG and not any(
            min(abs(o.ratio - 1), abs(o.ratio + ratio - 2)) < MIN_RELATIVE_SPEED_ERROR_IF_WRONG
            and o.energy > MIN_EQUIVALENT_SPEED_SCALE_ENERGY_RATIO * most
            for o in self.alignments
        )
        shaft = self.angle.rotation.speed(self.time)
        turning = shaft > MIN_ORDER_FREQUENCY_HZ / 2
        if off and self.engine is not None and turning.any():
            own = self.engine.speed(self.time)[turning] / shaft[turning]
            if (
                np.mean(np.abs(own - 1) < MAX_RELATIVE_SPEED_ERROR_IF_CORRECT)
                > MIN_DIRECT_GEAR_SHARE_OF_DRIVING_TIME
            ):
                return True
        order = ratio * self.wheel_order
        return (
            order > (0 if off else TYRE_LUG_MIN_ORDER)
            and abs(order - round(order)) < MAX_RELATIVE_DISTANCE_TO_WHOLE_ORDER * order
        )

    @cached_property
    def wheel_order(self) -> float:
        """Return which order of the wheels order 2 is; 0 where no axle's ratio is known."""
        if self.wheel is None:
            return 0.0
        shaft, wheel = (float(np.ptp(r.at(self.time))) for r in (self.angle.rotation, self.wheel))
        return 2 * shaft / wheel if wheel > 0 else 0.0

    @cached_property
    def is_single_tone(self) -> bool:
        """Return whether what the joints do is one tone: its energy is in one line of a spectrum.

        Any other of about that frequency, there all the time, is then as surely locked.
        """
        from scipy.fft import fft, next_fast_len

        force = self.best_rotation.forces(2)[0]
        # Between two lines of a spectrum twice as long a tone keeps four fifths of its energy.
        lines = fft(force.astype(np.complex64), next_fast_len(2 * force.size))
        energy = force.size * float(np.vdot(force, force).real)
        return float(np.abs(lines).max()) ** 2 > MIN_SINGLE_TONE_ENERGY_SHARE * energy

    def following_shares(self) -> tuple[float, float, FloatArray] | None:
        """Share, at least and likely, of what follows order 2 where no engine may, and that (m,).

        It needs no angle: only what turns with the shaft goes through all frequencies with it.
        So does any order of an engine that was not measured, in some gear. None of what does not.
        """
        if self.engine is None:
            where = ~above_idle(self.best_rotation)
        else:
            # Whatever of an engine comes into the band that is looked at, a second off it too.
            may = order_overlap(
                self.best_rotation,
                self.engine,
                self.engine_orders,
                self.time,
                within=MAX_ENGINE_ORDER_DISTANCE_HZ,
            )
            may |= order_overlap(
                self.best_rotation, self.engine, (ROTATION_ORDER,), self.time, within=0.5
            )
            where = ~(smooth_share_over_one_second(may, self.rate) > 0)
        # Nor of a blow, which comes when it comes.
        if (
            not intermittent_energy_share(
                self.impact_clipped_stress, self.best_rotation, self.rate, where=where
            )
            > MIN_ORDER2_ENERGY_SHARE_FOLLOWING_SHAFT
        ):
            return None
        close, more = self.sideband_shares(
            np.zeros_like(self.x), np.where(where, 1.0, 0.0), of=self.impact_clipped_stress
        )
        return (
            (
                more,
                close,
                where * self.near_order2(self.impact_clipped_stress, span=RIDE_SIDEBAND_WINDOW_S),
            )
            if more > 0
            else None
        )

    def widen_for_short_torque(self, rest: FloatArray, span: ShareInterval) -> ShareInterval:
        """Widen by what the joints may do if it comes with a torque that lasts for seconds only.

        Where crests do not go with the torque at all, what comes in its seconds came by chance.
        """
        strong = high_torque_mask(self.load, self.rate)
        if (
            0 < strong.mean() < MAX_TORQUE_BURST_TIME_SHARE
            and not self.crest_torque_correlation < MIN_SHORT_TORQUE_CORRELATION
        ):
            swings = remove_running_mean(rest, self.rate) - self.torque_proportional_part
            share = self.damage_share_of_wave(np.where(strong, swings, 0.0) + (self.x - rest))
            if share > NOT_DOMINANT_MAX_SHARE:
                span = span.up_to(share + 0.05, DOUBT_SHORT_TORQUE_PULSE)
        return span

    @cached_property
    def torque_proportional_part(self) -> FloatArray | float:
        """Return what swings with the torque itself (m,): load, whatever turns."""
        if not self.measured:
            return 0.0
        pull = remove_running_mean(self.load, self.rate)
        return pull * float(pull @ self.y) / max(float(pull @ pull), 1e-300)

    def widen_for_intermittent_sidebands(
        self, rest: FloatArray, span: ShareInterval
    ) -> ShareInterval:
        """Widen by what the joints may do if it comes and goes with order 2, not locked to it."""
        if (
            comes := intermittent_energy_share(rest, self.best_rotation, self.rate)
        ) > MIN_INTERMITTENT_ENERGY_SHARE:
            span = span.up_to(
                self.damage_share_of_wave(self.near_order2(self.x, span=RIDE_SIDEBAND_WINDOW_S / 2))
                + 0.05,
                DOUBT_INTERMITTENT_SIDEBANDS,
            )
            # What that knocks loose elsewhere is unknown, and without a torque also when.
            if comes > FULLY_INTERMITTENT_MIN_ENERGY_SHARE or not self.measured:
                span = span.up_to(NOT_DOMINANT_MAX_SHARE + 0.05)
        return span

    @cached_property
    def torque_magnitude(self) -> FloatArray:
        """Return how hard they pull (m,): by the torque, or by order 2 if not measured."""
        return np.abs(self.load) if self.measured else np.abs(self.order2_fit.waveform) ** 2

    @cached_property
    def crest_torque_correlation(self) -> float:
        """Return how all crests go with that, a correlation; nan if undetermined."""
        return self.crest_correlation_without(0.0)

    def crest_correlation_without(self, wave: FloatArray | float) -> float:
        """Return how the crests of what a wave (m,) leaves go with their pull, a correlation."""
        turning = self.best_rotation.speed > MIN_ORDER_FREQUENCY_HZ / 2
        return torque_correlation(
            self.y - self.torque_proportional_part - wave, self.torque_magnitude, turning, self.rate
        )

    def widen_for_bump_stop_preload(self, wave: FloatArray, span: ShareInterval) -> ShareInterval:
        """Open the end where crests go with their pull, as of a stop that the line stands on.

        How much of the damage would be left without it no line's wave (m,) shows. Where they are
        found, or the joints are not excluded, it takes less: without a stop only the wave goes
        with their pull.
        """
        innocent = span.high <= NOT_DOMINANT_MAX_SHARE
        goes = innocent and self.crest_torque_correlation > MIN_TORQUE_CORRELATION
        if not innocent or self.order2_fit.f_statistic >= MIN_DETECTION_F_STATISTIC:
            goes = goes or self.crest_correlation_without(wave) > MIN_SHORT_TORQUE_CORRELATION
        return (
            span.up_to(
                1.0, DOUBT_LINE_RESTS_ON_BUMP_STOP if self.measured else DOUBT_BUMP_STOP_IMPACTS
            )
            if goes
            else span
        )


def decimate(x: FloatArray, every: int) -> FloatArray:
    """Every so manyth sample (n / every,) of what half of them can hold."""
    if every == 1:
        return x
    from scipy.signal import resample_poly

    return resample_poly(x, 1, every, padtype="line")


def restore_rate(wave: FloatArray, every: int, n: int) -> npt.NDArray[np.floating]:
    """Return a thinned wave at all samples (n,)."""
    if every == 1:
        return wave
    from scipy.signal import resample_poly

    # Seven digits of it are taken off a stress.
    out = resample_poly(wave.astype(np.float32), every, 1)[:n]
    return np.pad(out, (0, n - out.size))
