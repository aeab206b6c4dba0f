"""What the joints did to a gauge, as evidence: identified by phase and torque, with its doubt.

A bracket responds to every excitation, so a large amplitude at twice the shaft's speed proves
nothing. Two things distinguish the joints from a road that shakes the same mode: their force is
locked to the shaft's angle, and it goes with its torque. So what is `locked` is fitted and taken
off: the answer is the share of damage that goes with it, 1 - D(without)/D. What that cannot see
is examined one by one: what else turns so, what stands close `beside` the order, what only comes
with it. Each answer may widen the interval, and says so.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import BoolArray, ComplexArray, FloatArray
from cardan.core.finding import Finding
from cardan.physics.signals.attribution_result import (
    DOMINANT_MIN_SHARE,
    DOUBT_BUMP_STOP_IMPACTS,
    DOUBT_CONSTANT_FREQUENCY,
    DOUBT_ENGINE_ORDER_OVERLAP,
    DOUBT_INTERMITTENT_SIDEBANDS,
    DOUBT_NO_ENGINE_SPEED,
    DOUBT_NO_RELIABLE_SHAFT_ANGLE,
    DOUBT_NO_TORQUE,
    DOUBT_ORDER_6_SUGGESTS_RATTLE,
    DOUBT_RESPONSE_STEP,
    DOUBT_SHAFT_ANGLE_MAY_SLIP,
    DOUBT_SIDEBANDS,
    DOUBT_SPEED_OF_OTHER_SHAFT,
    DOUBT_SPEED_SCALE,
    DOUBT_TORQUE_INDEPENDENT,
    DOUBT_WEAK_SYNCHRONOUS_PART,
    NOT_DOMINANT_MAX_SHARE,
    JointAttribution,
)
from cardan.physics.signals.conditioning import interpolate_gaps
from cardan.physics.signals.confounders import (
    bump_stop_impacts,
    engine_order_overlap,
    intermittent_energy_share,
    order_share_not_from_engine,
    smooth_share_over_one_second,
)
from cardan.physics.signals.identification_problem import (
    FULLY_INTERMITTENT_MIN_ENERGY_SHARE,
    RIDE_SIDEBAND_WINDOW_S,
    TYRE_LUG_MIN_ORDER,
    IdentificationProblem,
    ShareInterval,
    StressHistoryDamageFunction,
    decimate,
)
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.response_step import (
    MIN_STEP_LN,
    damage_ratios_of_gain_step,
    response_step,
)
from cardan.physics.signals.shaft_angle import ShaftAngle
from cardan.physics.signals.synchronous_fit import (
    MIN_DETECTION_F_STATISTIC,
    OrderFit,
    fit_order,
    gain_variation_over_time,
    least_squares,
)

FULL_CONFIDENCE_F_STATISTIC = 60.0
"""F from which the interval is that of the draws alone."""
CONFIDENCE_INTERVAL_DRAWS = 24
"""Of the interval."""
MAX_ORDER2_DEVIATION_FROM_OTHER_GEARS = 0.2
"""Share by which order 2 next to an engine order may differ from what other gears predict (rms, in
size and phase), and still be the joints' alone."""
TRIAL_PHASE_ERRORS_RAD = (0.0, *(k * np.pi / 8 for k in (-3, -2, -1, 1, 2, 3)))
"""By which the phase predicted from other gears may be wrong: an engine that turns with the shaft
pulls at the ratio of the speed, and near a mode a per cent of frequency turns it by as much."""
MIN_SIDEBAND_EXCESS_DAMAGE_SHARE = 0.15
"""Share of the damage by which what is next to the order exceeds what is farther off."""


@dataclass(frozen=True)
class JointCausedStress:
    """The joints' part of a stress, and the evidence for it.

    Attributes
    ----------
    attribution
        What they are answerable for.
    stress : (n,) Pa
        Most likely due to the joints, as `evidence.removed` says: what is fitted, locked or not, or
        where nothing is locked all that follows order 2 through all frequencies.
    order2 : (n,) Pa
        0-to-peak amplitude of their order 2, as fitted, found or not.
    damage
        Of all of it.
    """

    attribution: JointAttribution
    stress: npt.NDArray[np.floating]
    order2: FloatArray
    damage: float


# --------------------------------------------------------------------------- the question


def separate_joint_caused_stress(
    stress: FloatArray,
    *,
    rate: float,
    angle: ShaftAngle,
    torque: FloatArray | None,
    damage: StressHistoryDamageFunction,
    engine: ShaftRotation | None = None,
    engine_orders: Sequence[float] = (),
    wheel: ShaftRotation | None = None,
    start: float = 0.0,
    seed: int = 0,
) -> JointCausedStress:
    """Estimate what the joints did to a stress (n,).

    Before a speed is known and after, a rotation goes on at its last speed, at which nothing
    turned: what a gauge feels there is neither of the joints nor of another cause.

    Parameters
    ----------
    stress : (n,) Pa
        Of the gauge, nan where it is not known.
    rate : Hz
        Of its samples.
    angle
        Of the shaft.
    torque : (n,) N m
        At the shaft; None if not measured.
    damage
        Of a stress (n,).
    engine, engine_orders
        What else may turn twice a shaft turn; of an unmeasured engine, whether its order 2 may.
    wheel
        Behind the axle, where its ratio is known.
    start : s
        Of the first sample, in the time of the rotations.
    seed
        Of the draws.
    """
    time = start + np.arange(stress.size) / rate
    unknown_speed_share = _damage_share_without_speed(stress, angle, time, damage)
    stress = np.where(angle.is_beyond_ends(time), np.nan, stress)
    every = max(int(rate // 400), 1)
    x = decimate(interpolate_gaps(stress), every)
    fine = rate / every
    load = None
    if torque is not None:
        load = interpolate_gaps(torque)[every // 2 :: every][: x.size]
        load = np.pad(load, (0, x.size - load.size), mode="edge")
    thin = start + np.arange(x.size) / fine
    if load is None or not np.abs(load).max() > 0:
        load = np.where(angle.rotation.speed(thin) > 0.5, 1.0, 0.0)
    known = ~angle.is_beyond_ends(thin)
    load = np.where(known, load, 0.0)  # or a fit sees torque that no stress goes with
    rms = float(np.sqrt(np.sum(load**2) / max(np.count_nonzero(known), 1)))
    case = IdentificationProblem(
        stress=stress, x=x, every=every, rate=fine, start=start,
        load=load / max(rms, 1e-300), measured=torque is not None,
        angle=angle.within(start, start + x.size / fine),
        engine=engine, engine_orders=engine_orders, wheel=wheel, damage=damage,
    )  # fmt: skip
    if not case.alignments:
        nothing = JointAttribution(damage_share=0.0, interval=(0.0, 0.0), f_statistic=0.0)
        nothing = nothing.with_unknown_speed_share(unknown_speed_share)
        return JointCausedStress(
            nothing, np.zeros(stress.size), np.zeros(stress.size), case.total_damage
        )
    answer = (
        _result_without_lock(case)
        if case.order2_fit.f_statistic < MIN_DETECTION_F_STATISTIC
        else _result_with_lock(case, seed)
    )
    return replace(
        answer,
        attribution=answer.attribution.with_unknown_speed_share(unknown_speed_share),
    )


def _damage_share_without_speed(
    stress: FloatArray, angle: ShaftAngle, time: FloatArray, damage: StressHistoryDamageFunction
) -> float:
    """Return the share of damage done while its speed is not known, or is negative."""
    said = ~(angle.is_unknown(time) | angle.is_negative(time))
    if said.all() or not (total := damage(stress)) > 0:
        return 0.0
    return 1 - damage(stress[said]) / total if said.any() else 1.0


def _result_without_lock(case: IdentificationProblem) -> JointCausedStress:
    """Return the evidence if nothing is locked to the shaft: what might still be of the joints."""
    wave = case.order2_fit.waveform.real
    theirs = case.at_full_rate(wave)
    likely, own = max(case.damage_share_of_stress(theirs), 0.0), case.decimated_damage_share(wave)
    reach = likely
    for option in case.alignments[1:]:
        columns = case.rotation_of(option).columns(2)
        # How far another lies from it shows among the thinned samples as well as among all.
        more = case.decimated_damage_share((least_squares(columns, case.y)[0] @ columns).real) - own
        reach = max(reach, likely + more)
    # The same doubt at both ends: what does so little may spare the part, by chance or a stop.
    doubt = 0.3 * reach + 0.03
    span = ShareInterval(-doubt, reach + doubt)
    if not (case.angle.trusted and case.measured):
        # Without a torque it is unknown where the joints' force turns its sign.
        all_near = max(
            case.decimated_damage_share(case.near_order2(case.x, span=held))
            for held in (0.5, RIDE_SIDEBAND_WINDOW_S)
        )
        why = DOUBT_NO_TORQUE if case.angle.trusted else DOUBT_NO_RELIABLE_SHAFT_ANGLE
        span = span.up_to(max(span.high, likely + all_near - own) + 0.05, why)
    if not case.angle.measured:
        span = span.up_to(NOT_DOMINANT_MAX_SHARE + 0.05)
    else:
        close, more = case.sideband_shares(np.zeros_like(case.x))
        if more > MIN_SIDEBAND_EXCESS_DAMAGE_SHARE:
            span = span.up_to(close + 0.05, DOUBT_SIDEBANDS)
    if case.angle_is_lost.any():
        span = span.up_to(case.damage_share_of_wave(case.with_lost_angle_part(wave)) + 0.05)
    span = case.widen_for_short_torque(case.x, case.widen_for_other_speeds(span))
    if span.high <= NOT_DOMINANT_MAX_SHARE:
        span = case.widen_for_intermittent_sidebands(case.x, span)
    span = case.widen_for_bump_stop_preload(wave, span)
    low, high = span.low, min(span.high, 1.0)
    if there := case.following_shares():
        low, likely = min(there[:2]) - 0.01, max(likely, there[1])
        theirs = case.at_full_rate(there[2])
        span = span.with_doubt(DOUBT_INTERMITTENT_SIDEBANDS)
        sure = _following_share_beside_engine(case, there[2])
        if sure < low:
            low, span = sure, span.with_doubt(DOUBT_ENGINE_ORDER_OVERLAP)
        if low >= DOMINANT_MIN_SHARE and sure < 0.5:  # the rest may be the engine's
            low, span = 0.0, span.with_doubt(DOUBT_ENGINE_ORDER_OVERLAP)
        if low >= DOMINANT_MIN_SHARE and case.other_scale_problem:
            low, span = 0.0, span.with_doubt(DOUBT_SPEED_SCALE)
        if low >= DOMINANT_MIN_SHARE and case.is_torque_independent:
            low, span = 0.0, span.with_doubt(DOUBT_TORQUE_INDEPENDENT)
        # Lugs follow the shaft too, an order of the wheels or two away.
        if low >= DOMINANT_MIN_SHARE and case.wheel_order > TYRE_LUG_MIN_ORDER:
            low, span = 0.0, span.with_doubt(DOUBT_SPEED_OF_OTHER_SHAFT)
    found = _joint_attribution(
        case, float(np.clip(likely, 0.0, high)), min(low, high), high, span.doubts
    )
    return JointCausedStress(
        found, theirs, case.amplitude_at_full_rate(case.order2_fit.waveform), case.total_damage
    )


def _result_with_lock(case: IdentificationProblem, seed: int) -> JointCausedStress:
    """Answer where something is locked: its share by draws, and what it may leave out."""
    line, x = case.order2_fit, case.x
    theirs = _fit_joint_lines(case)
    rng = np.random.default_rng(seed)
    mean = theirs.wave()
    whole = case.at_full_rate(mean)
    middle, own = case.damage_share_of_stress(whole), case.decimated_damage_share(mean)
    if middle < 0 and case.following_shares():
        # What is held of it does harm: the angle slips, and what follows the shaft shows more.
        return _result_without_lock(case)
    # How far draws lie from it shows among the thinned samples as well as among all.
    drawn = (
        middle
        - own
        + np.array(
            [
                case.decimated_damage_share(theirs.wave(rng))
                for _ in range(CONFIDENCE_INTERVAL_DRAWS)
            ]
        )
    )
    low, high = (float(v) for v in np.quantile(drawn, [0.05, 0.95]))
    # What the model leaves out of a bracket: most where half of the damage is at stake.
    margin = 0.03 + 0.1 * max(middle * (1 - middle), 0.0)
    span = ShareInterval(min(low, middle) - margin, max(high, middle) + margin)
    # What it leaves close to the order, over what it leaves elsewhere, may be of the joints as
    # well.
    close, more = case.sideband_shares(mean)
    if more > 0:
        span = span.up_to(span.high + min(more, max(close - own, 0.0)))
        if more > MIN_SIDEBAND_EXCESS_DAMAGE_SHARE:
            span = span.with_doubt(DOUBT_SIDEBANDS)
    if not case.measured:
        span = span.up_to(close, DOUBT_NO_TORQUE)
    if line.f_statistic < FULL_CONFIDENCE_F_STATISTIC:
        span = span.down_to(span.low - 0.1).up_to(span.high + 0.1, DOUBT_WEAK_SYNCHRONOUS_PART)
        if middle > 0.3:  # an angle that slips loses some of the joints' part
            span = span.up_to(case.damage_share_of_wave(case.near_order2(x)) + 0.05)
    # The shaft does all that is there, and little of it is held, or when it pulls is not measured:
    # what that knocks loose elsewhere, at a stop above all, is unknown.
    unclear = line.f_statistic < FULL_CONFIDENCE_F_STATISTIC or not case.measured
    if (
        unclear
        and intermittent_energy_share(x, case.best_rotation, case.rate)
        > FULLY_INTERMITTENT_MIN_ENERGY_SHARE
    ):
        span = span.up_to(NOT_DOMINANT_MAX_SHARE + 0.05, DOUBT_INTERMITTENT_SIDEBANDS)
    if middle < 0:  # removing the joints' part does more damage: the angle slips where it matters
        span = span.up_to(
            max(case.damage_share_of_wave(case.near_order2(x)), 0.05), DOUBT_SHAFT_ANGLE_MAY_SLIP
        )
    if case.angle_is_lost.any():
        span = span.up_to(case.damage_share_of_wave(case.with_lost_angle_part(mean)))
    if any(one.order == 6 for one in theirs.lines):
        span = span.up_to(
            1.0 if span.high > 0.3 else span.high + 0.3, DOUBT_ORDER_6_SUGGESTS_RATTLE
        )
    if not case.angle.trusted:
        # Something is of the joints, and what that knocks loose elsewhere no lost angle can follow.
        span = span.up_to(
            max(case.damage_share_of_wave(case.near_order2(x)), NOT_DOMINANT_MAX_SHARE + 0.05),
            DOUBT_NO_RELIABLE_SHAFT_ANGLE,
        )
        span = span.down_to(0.5 * middle)
    beside = _share_beside_engine(case, theirs, mean, margin)
    if beside is not None:
        if beside.least < span.low:
            span = span.down_to(
                beside.least,
                DOUBT_NO_ENGINE_SPEED if case.engine is None else DOUBT_ENGINE_ORDER_OVERLAP,
            )
        if beside.likely is not None:
            # In other gears they do other than what runs with order 2 here: an engine does some.
            mean, middle = beside.likely, beside.share
            whole = case.at_full_rate(mean)
            span = span.up_to(max(span.high, beside.most), DOUBT_ENGINE_ORDER_OVERLAP)
    mixed = beside is not None and beside.likely is not None
    if not mixed and span.low < DOMINANT_MIN_SHARE and (there := case.following_shares()):
        least = min(there[0], middle, _following_share_beside_engine(case, there[2]))
        span = span.with_doubt(DOUBT_SPEED_SCALE) if case.other_scale_problem else replace(
            span, low=max(span.low, least)
        )  # fmt: skip
    if span.low >= DOMINANT_MIN_SHARE and case.is_torque_independent:
        span = span.down_to(0.0, DOUBT_TORQUE_INDEPENDENT)
    if span.low >= DOMINANT_MIN_SHARE and case.has_foreign_speed:
        span = span.down_to(0.0, DOUBT_SPEED_OF_OTHER_SHAFT)
    if span.low >= DOMINANT_MIN_SHARE and case.is_single_tone:
        span = span.down_to(0.0, DOUBT_CONSTANT_FREQUENCY)
    span = case.widen_for_short_torque(x - mean, span)
    if span.high <= NOT_DOMINANT_MAX_SHARE:
        span = case.widen_for_other_speeds(span)
        if case.angle.trusted and span.high <= NOT_DOMINANT_MAX_SHARE:
            span = case.widen_for_intermittent_sidebands(x - mean, span)
    knocks = bump_stop_impacts(x - mean, line.waveform, case.rate)
    if knocks.any():
        span = span.up_to(
            case.damage_share_of_wave(np.where(knocks, case.y, mean)) + 0.05,
            DOUBT_BUMP_STOP_IMPACTS,
        )
    span = case.widen_for_bump_stop_preload(mean, span)
    if (doubt := _response_step_doubt(case, theirs)) is not None:
        span = span.with_doubt(doubt)
    low, high = (float(v) for v in np.clip([span.low, span.high], -1.0, 1.0))
    found = _joint_attribution(case, float(np.clip(middle, low, high)), low, high, span.doubts)
    return JointCausedStress(
        replace(found, modes=line.modes), whole, case.amplitude_at_full_rate(theirs.second()),
        case.total_damage,
    )  # fmt: skip


MIN_NOTED_DAMAGE_CHANGE = 0.2
"""Relative change of the damage by a gain that stepped, from which it is reported."""


MAX_STEP_TO_STEP_OF_GAINS = 4.0
"""Step between fits of two parts over that of the whole fit's gains, as logarithms: a fit of both
hides three quarters of it at most."""


def _response_step_doubt(case: IdentificationProblem, theirs: "_JointLines") -> Finding | None:
    """Return by how much the damage may be off where order 2 per torque steps; else None."""
    middle, gain, _ = theirs.gains[0]
    line = case.order2_fit
    sure = case.measured and line.f_statistic >= FULL_CONFIDENCE_F_STATISTIC
    step = response_step(middle, gain) if sure else None
    if step is None:
        return None
    at = round(step.time * case.rate)
    # The gains are of what was fitted to both parts; each part alone shows how far they are apart.
    before, after = (
        least_squares(line.columns[:, part], line.fitted_signal[part])[0] @ line.columns
        for part in (slice(at), slice(at, None))
    )
    power = float(np.vdot(before, before).real)
    factor = float(np.sqrt(np.vdot(after, after).real / max(power, 1e-300)))
    apart, seen = np.log(max(factor, 1e-3)), np.log(step.factor)
    if not (apart * seen > 0 and MIN_STEP_LN < abs(apart) < MAX_STEP_TO_STEP_OF_GAINS * abs(seen)):
        return None
    low, high = damage_ratios_of_gain_step(case.stress, at * case.every, factor, damage=case.damage)
    most = 1 + MIN_NOTED_DAMAGE_CHANGE
    if 1 / most < low and high < most:
        return None
    return DOUBT_RESPONSE_STEP.with_values(
        time=case.start + step.time, factor=factor, low=low, high=high
    )


def _joint_attribution(
    case: IdentificationProblem,
    removed: float,
    low: float,
    high: float,
    doubts: tuple[Finding, ...],
) -> JointAttribution:
    """Return a share and its interval as evidence, each doubt once."""
    return JointAttribution(
        damage_share=removed,
        interval=(low, high),
        f_statistic=case.order2_fit.f_statistic,
        ratio=case.best_alignment.ratio,
        lag=case.best_alignment.lag,
        lag_interval=case.best_alignment.lag_interval,
        doubts=tuple(dict.fromkeys(doubts)),
    )


@dataclass(frozen=True)
class _ShareBesideEngine:
    """What is the joints' where an engine order may run with their order 2.

    `least` is their share at least, `most` at most. Where the engine does part of what runs with
    order 2, `likely` (m,) is a stress of the joints between, and `share` what goes with that.
    """

    least: float
    most: float = 0.0
    likely: FloatArray | None = None
    share: float = 0.0


def _share_beside_engine(
    case: IdentificationProblem, theirs: "_JointLines", mean: FloatArray, margin: float
) -> _ShareBesideEngine | None:
    """Return the joints' part if an engine may turn with the shaft; None if none may.

    Of a measured engine all that runs with order 2 may be its own. Of one that was not
    measured, the joints' part is what its spells have in common: order 2 and all that nothing
    explains.
    """
    may = engine_order_overlap(case.best_rotation, case.engine, case.engine_orders, case.time)
    if may is None:
        return None
    line = case.order2_fit
    if case.engine is None:
        best = case.best_rotation
        given = case.rotation_of(replace(case.best_alignment, ratio=1.0)).turns
        own = theirs.left + line.waveform.real
        sure = order_share_not_from_engine(
            may, line.waveform, own, stretch=best.stretch, turns=best.turns, given=given
        )
        share = smooth_share_over_one_second(sure, case.rate)
        return _ShareBesideEngine(case.damage_share_of_wave(mean * share) - margin)
    share = smooth_share_over_one_second(~may, case.rate)
    sure = case.damage_share_of_wave(mean * share) - margin
    if share.mean() < 0.5:
        return _ShareBesideEngine(min(sure, 0.0))
    foretold = _order2_of_other_gears(case, may, share)
    size = float(np.mean(np.abs(foretold[may]) ** 2))
    off = np.sqrt(np.mean(np.abs(theirs.second()[may] - foretold[may]) ** 2) / max(size, 1e-300))
    if off <= MAX_ORDER2_DEVIATION_FROM_OTHER_GEARS:
        return _ShareBesideEngine(sure)
    # The engine adds to what they do, or takes from it, and has its part in the angle as well.
    turned = [
        mean * share + (foretold * np.exp(1j * phase)).real * (1 - share)
        for phase in TRIAL_PHASE_ERRORS_RAD
    ]
    shares = [case.damage_share_of_wave(wave) for wave in turned]
    return _ShareBesideEngine(
        min(sure, min(shares) - margin), max(shares) + margin, turned[0], shares[0]
    )


def _following_share_beside_engine(case: IdentificationProblem, wave: FloatArray) -> float:
    """Share of damage that goes with a wave (m,) that follows order 2, where no engine does.

    An engine order that runs with order 2 follows the shaft as well; 1 where none was measured to.
    """
    may = engine_order_overlap(case.best_rotation, case.engine, case.engine_orders, case.time)
    if may is None or case.engine is None:
        return 1.0
    share = smooth_share_over_one_second(~may, case.rate)
    return case.damage_share_of_wave(wave * share) - 0.03


def _order2_of_other_gears(
    case: IdentificationProblem, may: BoolArray, share: FloatArray
) -> ComplexArray:
    """Return order 2 (m,) of the joints as the rest of the drive has it, where none else `may`.

    Torque and speed make it, through the bracket's modes; it is fitted without the samples in
    which an engine order runs with it, and predicted for those.
    """
    scene, y = case.best_rotation, case.order2_fit.fitted_signal
    alone = fit_order(replace(scene, torque=scene.torque * share), y * share, 2, most=2)
    columns = scene.columns(2, alone.modes)
    gains, _ = least_squares(columns[:, ~may], y[~may])
    return np.asarray(gains @ columns, np.complex128)


@dataclass(frozen=True)
class _JointLines:
    """Lines of the joints, how each wanders, and what they leave of a stress (m,)."""

    lines: tuple[OrderFit, ...]
    gains: tuple[tuple[FloatArray, ComplexArray, FloatArray], ...]
    left: FloatArray
    since: FloatArray

    def wave(self, rng: np.random.Generator | None = None) -> FloatArray:
        """Return all of them (m,): as is most likely, or as drawn."""
        total = np.zeros(self.since.size)
        for one, (middle, gain, sigma) in zip(self.lines, self.gains, strict=True):
            z = one.waveform
            if rng is not None:
                k = one.noise.shape[0]
                mix = (rng.normal(size=k) + 1j * rng.normal(size=k)) / np.sqrt(2 * k)
                # Of what noise might have made of it four digits are plenty.
                z = z + (mix @ one.noise).astype(np.complex64) @ one.columns_float32
                gain = gain + sigma * (
                    rng.normal(size=gain.size) + 1j * rng.normal(size=gain.size)
                ) / np.sqrt(2)
            total += (self._slow(middle, gain) * z).real
        return total

    def second(self) -> ComplexArray:
        """Return order 2 (m,) as it wanders."""
        middle, gain, _ = self.gains[0]
        return self._slow(middle, gain) * self.lines[0].waveform

    def _slow(self, middle: FloatArray, gain: ComplexArray) -> ComplexArray:
        return np.asarray(np.interp(self.since, middle, gain), np.complex128)


def _fit_joint_lines(case: IdentificationProblem) -> _JointLines:
    """Return order 2, with orders 4 and 6 if they are locked too, as they wander."""
    lines, left = [case.order2_fit], case.y - case.order2_fit.waveform.real
    for order in (4, 6):
        more = fit_order(case.best_rotation, left, order, most=1 if order == 4 else 0)
        if more.f_statistic >= MIN_DETECTION_F_STATISTIC:
            lines.append(more)
            left = left - more.waveform.real
    # With the other orders out of the way each is fitted once more, wandering.
    gains = tuple(
        gain_variation_over_time(one, left + one.waveform.real, case.rate) for one in lines
    )
    return _JointLines(tuple(lines), gains, left, np.arange(case.x.size) / case.rate)
