"""From a recording to life and cause: looks, counts and takes apart, in that order.

Two passes over the recording, one to see what is wrong with it and one to count; a third
if causes are requested. Memory holds a few pieces, whatever the length.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from itertools import islice, tee

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.core.errors import DesignError
from cardan.core.units import MPa
from cardan.physics.fatigue.damage import (
    LifeEstimate,
    damage_to_stress_exponent,
    miner_damage,
    repeats_at_failure_probabilities,
)
from cardan.physics.fatigue.mean_stress import MeanStressCorrection, uncorrected
from cardan.physics.fatigue.rainflow import (
    EMPTY_REVERSALS,
    Cycles,
    FromToMatrix,
    ResidueRule,
    concatenate_cycles,
    four_point,
    half_cycles,
)
from cardan.physics.fatigue.rainflow_matrix import RainflowTable, RangeMeanMatrix, from_to_table
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.fatigue.spectral import (
    Spectrum,
    WelchEstimator,
    dirlik,
    periodograms,
    rayleigh,
    tovo_benasciutti,
)
from cardan.physics.fatigue.strain_gauges import (
    PlaneStress,
    StrainGauge,
    abs_max_principal,
    signed_mises,
)
from cardan.physics.signals.conditioning import (
    UPSAMPLING_FACTOR,
    ChannelReport,
    condition_pieces,
    low_pass,
    no_baseline,
    survey_channel_signals,
    upsample,
)
from cardan.physics.signals.data_quality import (
    ALL_UNDECIDED_FAULT_KINDS,
    DOUBT_DAMAGE_ABOVE_FAILURE,
    MIN_CREST_HEIGHT_SHARE_LOST_BY_SAMPLING,
    AssumedUnit,
    DataQuality,
    DeclaredRecordingProperties,
    FaultEffect,
    FaultRule,
    FaultTreatmentVariant,
    apply_rules,
    fault_treatment_variants,
)
from cardan.physics.signals.faults.intervals import merge_runs
from cardan.physics.signals.faults.lost_response import FAULT_RESPONSE
from cardan.physics.signals.faults.stuck_bit import FAULT_BIT
from cardan.physics.signals.faults.waveform import (
    FAULT_DROPOUT,
    FAULT_FREEZE,
    FAULT_MISSING_SAMPLES,
    FAULT_SENTINEL,
    FAULT_SPIKE,
)
from cardan.physics.signals.hidden_damage import IntervalDamage, hidden_interval_count
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, Recording, rechunk_to_block_size

HIDING_FAULTS = (FAULT_MISSING_SAMPLES, FAULT_FREEZE, FAULT_RESPONSE)
"""Kinds of fault while which the stress is unknown."""

ProgressCallback = Callable[[str, float], None]
"""Receives the name of the pass and the seconds of recording done."""


@dataclass(frozen=True, kw_only=True)
class AssessmentSettings:
    """How damage is to be judged.

    Attributes
    ----------
    gauges
        Places on the part.
    curve
        S-N curve at the gauges; its slope beyond the knee is the Miner variant.
    correction
        For mean stress.
    residue_rule
        For the residue of the count.
    baseline
        What is taken off as zero.
    low_pass : Hz
        Nothing faster counts; no filter unless given.
    allowed
        Damage at failure.
    gauge_error
        Relative standard deviation of the stress scale.
    failure_shares
        Shares of parts for which the life is computed.
    segment_samples : samples
        Of the spectra.
    fault_rules
        What is masked or accepted of what looks wrong; the last one that concerns it counts.
    interpolate_crests
        Whether crests are looked for between samples; None where they lose more than
        `MIN_CREST_HEIGHT_SHARE_LOST_BY_SAMPLING`.
    ultimate : Pa
        Tensile strength, which no crest may exceed; infinite if not given.
    max_known_frequency : Hz
        What is known to move in the recording.
    """

    gauges: tuple[StrainGauge, ...]
    curve: SNCurve
    correction: MeanStressCorrection = uncorrected
    residue_rule: ResidueRule = half_cycles
    baseline: Callable[[ChannelReport], FloatArray] = no_baseline
    low_pass: float | None = None
    allowed: float = 1.0
    gauge_error: float = 0.0
    failure_shares: tuple[float, ...] = (0.1, 0.5, 0.9)
    segment_samples: int = 4096
    fault_rules: tuple[FaultRule, ...] = ()
    interpolate_crests: bool | None = None
    ultimate: float = float("inf")
    max_known_frequency: float = 0.0

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels the gauges need, each once."""
        return tuple(dict.fromkeys(c for g in self.gauges for c in g.channels))


@dataclass(frozen=True, kw_only=True)
class GaugeAssessment:
    """What the recording did to one place.

    Attributes
    ----------
    name
        Of the gauge.
    channel_reports
        Of its channels, by their names.
    min_stress, max_stress : Pa
        Smallest and largest stress.
    life
        Damage and what follows from it.
    closed_cycles : FromToMatrix
        Closed cycles; the matrix rounds stresses to half a bin, 1e-3 in damage at most.
    residue : Pa
        Reversals left open.
    cycles
        Closed cycles, binned, and the residue by its rule.
    damage_exponent
        Per cent of damage for a per cent of stress.
    repeats : share of failed parts to passages of the recording
        With the scatter of strength and gauge.
    spectrum : Pa²/Hz
        Of the stress; None if no stretch was long enough.
    spectral_damage : name to damage
        Of the recording, by Rayleigh, Dirlik and Tovo-Benasciutti.
    quality
        How far to trust it.
    matrices
        All cycles from where to where and by range and mean, Pa, the residue by its rule; none of
        a gauge without a sample.
    """

    name: str
    channel_reports: dict[str, ChannelReport]
    min_stress: float
    max_stress: float
    life: LifeEstimate
    closed_cycles: FromToMatrix
    residue: FloatArray
    cycles: Cycles
    damage_exponent: float
    repeats: dict[float, float]
    spectrum: Spectrum | None
    spectral_damage: dict[str, float]
    quality: DataQuality
    matrices: tuple[RainflowTable, ...] = ()

    @property
    def has_signal(self) -> bool:
        """Whether it said anything: a stress that moved, of channels that all did."""
        return self.min_stress < self.max_stress and not any(
            h.dead for h in self.channel_reports.values()
        )

    @property
    def vetoes(self) -> tuple[str, ...]:
        """Kinds of fault that spoil what it said."""
        return self.quality.vetoes if self.has_signal else ()

    @property
    def vetoed(self) -> bool:
        """Whether what it said is spoiled, so that its life cannot be known."""
        return bool(self.vetoes)


class _DamageCounter:
    """Damage of one stress, as pieces pass."""

    def __init__(self, plan: AssessmentSettings) -> None:
        self.plan, self.damage, self.residue = plan, 0.0, EMPTY_REVERSALS

    def update(self, stress: FloatArray) -> Cycles:
        cycles, self.residue = four_point(stress, residue=self.residue)
        self.damage += miner_damage(cycles, curve=self.plan.curve, correction=self.plan.correction)
        return cycles

    def total_damage(self) -> float:
        left = self.plan.residue_rule(self.residue)
        return self.damage + miner_damage(
            left, curve=self.plan.curve, correction=self.plan.correction
        )


class _HighFrequencyPower:
    """How much of a stress is too fast for its frequency content to be known, block by block.

    A contact that chatters for some tenths of a second is white, and nothing of all the power; but
    it is all of the damage. So stretches count as damage does, by a power of how far they reach.
    """

    BLOCK_SAMPLES = 64

    def __init__(self, plan: AssessmentSettings, rate: float) -> None:
        self.slope, self.rate = plan.curve.slope, rate
        self.most = self.weight = self.share = 0.0
        self.tail = EMPTY_REVERSALS

    def update(self, stress: FloatArray) -> None:
        """Take a piece of it (n,)."""
        x = np.concatenate([self.tail, stress])
        full = x.size // self.BLOCK_SAMPLES * self.BLOCK_SAMPLES
        rows, self.tail = x[:full].reshape(-1, self.BLOCK_SAMPLES), x[full:].copy()
        if not full:
            return
        reach = np.ptp(rows, axis=-1)
        # Half as far does a thirtieth of the damage; nan reaches nowhere.
        so_far = np.fmax(np.fmax.accumulate(reach), self.most)
        self.most = float(so_far[-1])
        loud = reach > so_far / 2
        if not loud.any():
            return
        frequency, power = periodograms(
            rows[loud].ravel(), rate=self.rate, segment=self.BLOCK_SAMPLES
        )
        power = power[::2][: np.count_nonzero(loud)]  # those between two stretches are of neither
        weight = (reach[loud] / MPa) ** self.slope
        fast = power[:, frequency > 0.4 * self.rate].sum(-1)
        whole = np.maximum(power.sum(-1), 1e-300)
        self.weight += float(weight.sum())
        self.share += float(weight @ (fast / whole))

    def high_frequency_share(self) -> float:
        """Return the share of power above 0.4 of the sample rate there."""
        return self.share / self.weight if self.weight > 0 else 0.0


class CycleCounter(_DamageCounter):
    """One gauge's count, as pieces pass."""

    def __init__(self, plan: AssessmentSettings, rate: float) -> None:
        super().__init__(plan)
        self.rate, self.matrix, self.live = rate, FromToMatrix.empty(), 0
        self.loud, self.welch = (
            _HighFrequencyPower(plan, rate),
            WelchEstimator(rate, plan.segment_samples),
        )

    def update(self, stress: FloatArray) -> Cycles:
        """Count a piece of stress (n,); returns the cycles that it closed."""
        cycles = super().update(stress)
        self.matrix = self.matrix.with_cycles(cycles)
        return cycles

    def update_statistics(self, stress: FloatArray) -> None:
        """Take a piece of stress (n,) for its spectrum and the time it lived."""
        self.live += int(np.count_nonzero(~np.isnan(stress)))
        self.loud.update(stress)
        self.welch.update(stress)

    def cycles(self) -> Cycles:
        """Return all cycles so far, closed ones binned, and the residue by its rule."""
        return concatenate_cycles([self.matrix.cycles(), self.plan.residue_rule(self.residue)])

    def result(
        self, gauge: StrainGauge, healths: dict[str, ChannelReport], quality: DataQuality
    ) -> GaugeAssessment:
        """Return what the recording did to a gauge."""
        plan, curve, correction = self.plan, self.plan.curve, self.plan.correction
        if not self.residue.size:
            return self._empty_result(gauge, healths, quality)
        damage = self.total_damage()
        cycles = self.cycles()
        binned = miner_damage(cycles, curve=curve, correction=correction)
        lives = repeats_at_failure_probabilities(
            cycles, curve=curve, failures=plan.failure_shares,
            gauge_error=plan.gauge_error, correction=correction,
        )  # fmt: skip
        # The bins' rounding cancels: their ratio to the exact damage is the same in all.
        exact = plan.allowed * (binned / damage if damage > 0 else 1.0)
        spectrum, spectral = self.welch.spectrum(), dict[str, float]()
        if spectrum is not None and spectrum.moment(0) > 0:
            for method in (rayleigh, dirlik, tovo_benasciutti):
                spectral[method.__name__] = method(spectrum).damage_rate(curve) * quality.live_time
        return GaugeAssessment(
            name=gauge.name, channel_reports=healths,
            min_stress=float(self.residue.min()), max_stress=float(self.residue.max()),
            life=LifeEstimate(damage=damage, duration=quality.live_time, allowed=plan.allowed),
            closed_cycles=self.matrix, residue=self.residue, cycles=cycles,
            damage_exponent=damage_to_stress_exponent(cycles, curve=curve, correction=correction),
            repeats={f: exact * n for f, n in lives.items()},
            spectrum=spectrum, spectral_damage=spectral, quality=quality,
        )  # fmt: skip

    def _empty_result(
        self, gauge: StrainGauge, healths: dict[str, ChannelReport], quality: DataQuality
    ) -> GaugeAssessment:
        nan = float("nan")
        return GaugeAssessment(
            name=gauge.name,
            channel_reports=healths,
            min_stress=nan,
            max_stress=nan,
            life=LifeEstimate(damage=nan, duration=quality.live_time, allowed=self.plan.allowed),
            closed_cycles=self.matrix,
            residue=EMPTY_REVERSALS,
            cycles=self.matrix.cycles(),
            damage_exponent=nan,
            repeats=dict.fromkeys(self.plan.failure_shares, nan),
            spectrum=None,
            spectral_damage={},
            quality=quality,
        )


_PLANE_ANGLES_DEG = range(0, 180, 15)
_ROSETTE_MEASURES: dict[str, Callable[[PlaneStress], FloatArray]] = {
    "principal": abs_max_principal,
    **{f"@{a}": partial(PlaneStress.normal, angle=np.radians(a)) for a in _PLANE_ANGLES_DEG},
}
"""Gauges of a rosette that are compared with each other where it is sheared."""


class _ShearStatistic:
    """How a rosette is sheared where it is stressed, and what each measure makes of it."""

    def __init__(self, plan: AssessmentSettings, along: FloatArray | None) -> None:
        self.weight = self.total = 0.0
        self.ways = {"mises": partial(signed_mises, along=along), **_ROSETTE_MEASURES}
        self.tallies = {name: _DamageCounter(plan) for name in self.ways}

    def update(self, plane: PlaneStress) -> None:
        # The fifth power, as damage goes: what is small has no say.
        size = np.nan_to_num(plane.mises) ** 5
        self.weight += float(size.sum())
        self.total += float((size * np.nan_to_num(plane.biaxiality)).sum())
        for name, measure in self.ways.items():
            self.tallies[name].update(measure(plane))

    def biaxiality(self) -> float:
        return self.total / self.weight if self.weight > 0 else float("nan")

    def measures(self) -> dict[str, float]:
        found = {name: tally.total_damage() for name, tally in self.tallies.items()}
        return {
            "mises": found["mises"], "principal": found["principal"],
            "planes": max(found[f"@{a}"] for a in _PLANE_ANGLES_DEG),
        }  # fmt: skip


def _with_progress(
    pieces: Iterable[FloatArray], *, name: str, rate: float, progress: ProgressCallback | None
) -> Iterator[FloatArray]:
    done = 0
    for piece in pieces:
        yield piece
        done += piece.shape[-1]
        if progress is not None:
            progress(name, done / rate)


def survey_channel_quality(
    recording: Recording, *, channels: Iterable[str], progress: ProgressCallback | None = None
) -> dict[str, ChannelReport]:
    """Survey some channels of a recording: the first pass.

    Raises
    ------
    DesignError
        If it holds no samples at all.
    """
    names = tuple(channels)
    pieces = _with_progress(
        recording.pieces(names), name="look", rate=recording.rate, progress=progress
    )
    found = survey_channel_signals(pieces, rate=recording.rate, names=names)
    if not found:
        msg = f"{recording.name} holds no samples"
        raise DesignError(msg)
    return dict(zip(names, found, strict=True))


def gauge_stresses(
    recording: Recording, *, plan: AssessmentSettings, healths: dict[str, ChannelReport], name: str,
    progress: ProgressCallback | None = None,
) -> Iterator[FloatArray]:  # fmt: skip
    """Yield the stress of every gauge, treated by the plan's rules, (gauges, n) Pa."""
    how = fault_treatment_variants(
        {c: healths[c] for c in plan.channels}, rules=plan.fault_rules, rate=recording.rate,
        baseline=plan.baseline,
    )[:1]  # fmt: skip
    for felt in _stresses_by_variant(recording, plan=plan, how=how, name=name, progress=progress):
        yield felt[0]


def _piece_samples(rows: int) -> int:
    """Return the samples of a piece of which so many rows are held: gauges, in each way."""
    return SAMPLES_PER_BLOCK >> min((rows // 4).bit_length(), 2)


def _stresses_by_variant(
    recording: Recording,
    *,
    plan: AssessmentSettings,
    how: Sequence[FaultTreatmentVariant],
    name: str,
    progress: ProgressCallback | None = None,
    seen: Callable[[int, FloatArray], None] | None = None,
) -> Iterator[FloatArray]:
    """Yield the stress of every gauge in each way of treatment, (ways, gauges, n) Pa.

    `seen` is shown each gauge's place, and its channels as treated in the first way.
    """
    names = plan.channels
    place = {n: k for k, n in enumerate(names)}
    pieces = recording.pieces(names, size=_piece_samples(len(how) * len(plan.gauges)))
    raw = _with_progress(pieces, name=name, rate=recording.rate, progress=progress)

    def rows(clean: Iterable[FloatArray]) -> Iterator[FloatArray]:
        for way, x in enumerate(clean):
            for k, gauge in enumerate(plan.gauges):
                channels = x[[place[c] for c in gauge.channels]]
                if seen is not None and not way:
                    seen(k, channels)
                yield gauge.stress(channels)

    each = condition_pieces(raw, how=[[w.treatments[n] for n in names] for w in how])
    made = (np.stack([*rows(clean)]) for clean in each)
    if plan.low_pass is not None:
        made = low_pass(plan.low_pass, rate=recording.rate)(made)
    for felt in made:
        yield felt.reshape(len(how), len(plan.gauges), -1)


def assess_gauges(
    recording: Recording,
    *,
    plan: AssessmentSettings,
    healths: dict[str, ChannelReport] | None = None,
    distance: float = float("nan"),
    progress: ProgressCallback | None = None,
) -> list[GaugeAssessment]:
    """Damage and life at every gauge of a recording.

    Parameters
    ----------
    recording
        What was measured.
    plan
        How it is judged.
    healths
        Of the plan's channels, if already looked at.
    distance : m
        Driven in the recording, if known.
    progress
        Receives the progress.

    Raises
    ------
    DesignError
        If a gauge has no samples.
    """
    found = assess_damage_at_gauges(
        recording, plan=plan, healths=healths, distance=distance, progress=progress
    )  # fmt: skip
    for one in found:
        if not one.residue.size:
            msg = f"gauge {one.name} has no samples to count"
            raise DesignError(msg)
    return found


def assess_damage_at_gauges(
    recording: Recording,
    *,
    plan: AssessmentSettings,
    healths: dict[str, ChannelReport] | None = None,
    distance: float = float("nan"),
    progress: ProgressCallback | None = None,
) -> list[GaugeAssessment]:
    """Damage and life at every gauge, as by `life`; nan at those without a sample."""
    if healths is None:
        healths = survey_channel_quality(recording, channels=plan.channels, progress=progress)
    own = {c: healths[c] for c in plan.channels}
    how = fault_treatment_variants(
        own, rules=plan.fault_rules, rate=recording.rate, baseline=plan.baseline
    )
    gauges = [
        _GaugeCounter(g, plan, recording.rate, {c: healths[c] for c in g.channels}, how)
        for g in plan.gauges
    ]
    samples = 0
    felt = _stresses_by_variant(
        recording, plan=plan, how=how, name="count", progress=progress,
        seen=lambda k, channels: gauges[k].update_plane_stress(channels),
    )  # fmt: skip
    sharp = [k for k, g in enumerate(gauges) if g.sharp]
    coarse, fine = tee(felt) if sharp else (felt, iter(()))
    # Of each sample there are so many more, of every gauge in every way.
    few = _piece_samples(len(how) * len(gauges)) // UPSAMPLING_FACTOR
    between = upsample(x[:, sharp] for x in rechunk_to_block_size(fine, size=few))
    # Threads import parts of it when they first need them: two that meet at its own break it.
    import_module("scipy")
    with ThreadPoolExecutor(4) as pool:

        def sharpened(pieces: Iterable[FloatArray]) -> None:
            for more in pieces:
                jobs = [
                    pool.submit(gauges[k].update_counts, more[:, m]) for m, k in enumerate(sharp)
                ]
                for job in jobs:
                    job.result()

        for piece in coarse:
            samples += piece.shape[-1]
            jobs = [pool.submit(g.update, piece[:, k]) for k, g in enumerate(gauges)]
            sharpened(islice(between, -(-piece.shape[-1] // few)))
            for job in jobs:
                job.result()
        sharpened(between)
    return [g.result(samples, distance) for g in gauges]


class _GaugeCounter:
    """One gauge in every way of treatment, as pieces pass."""

    def __init__(
        self,
        gauge: StrainGauge,
        plan: AssessmentSettings,
        rate: float,
        healths: dict[str, ChannelReport],
        how: Sequence[FaultTreatmentVariant],
    ) -> None:
        self.gauge, self.plan, self.rate, self.healths = gauge, plan, rate, healths
        self.decided = {
            c: apply_rules(h, channel=c, rules=plan.fault_rules, rate=rate)
            for c, h in healths.items()
        }
        kinds = {kind for said in self.decided.values() for kind in said}
        short = max((h.crest_loss for h in healths.values() if not h.dead), default=0.0)
        self.sharp = (
            short > MIN_CREST_HEIGHT_SHARE_LOST_BY_SAMPLING
            if plan.interpolate_crests is None
            else plan.interpolate_crests
        )
        self.count, self.range_mean = CycleCounter(plan, rate), RangeMeanMatrix.empty()
        self.others = {
            k: _DamageCounter(plan)
            for k, w in enumerate(how)
            if w.kind in kinds or w.kind == ALL_UNDECIDED_FAULT_KINDS
        }
        self.how = how
        self.hidden = {k: self._hidden_runs(k) for k in HIDING_FAULTS}
        self.hidden_counts = {
            k: hidden_interval_count(runs, rate=rate) for k, runs in self.hidden.items()
        }
        self.intervals = IntervalDamage(
            rate=rate * (UPSAMPLING_FACTOR if self.sharp else 1), curve=plan.curve,
            correction=plan.correction, rule=plan.residue_rule,
        ) if any(self.hidden_counts.values()) else None  # fmt: skip
        self.samples_only = _DamageCounter(plan)
        self.shear = (
            _ShearStatistic(plan, gauge.dominant_direction)
            if gauge.plane_stress is not None
            else None
        )

    def _hidden_runs(self, kind: str) -> IntArray:
        """Return the runs (k, 2) of a kind in which the stress is unknown.

        A freeze that a rule accepts hides nothing, nor does a standstill.
        """
        found = [own[kind] for own in self.decided.values() if kind in own]
        if kind == FAULT_MISSING_SAMPLES:
            return merge_runs(of.intervals.runs for of in found)
        runs = [np.concatenate([of.masked, of.undecided]) for of in found]
        moving = [of.intervals.runs[of.intervals.sizes > 0, 0] for of in found]
        return merge_runs(r[np.isin(r[:, 0], m)] for r, m in zip(runs, moving, strict=True))

    def update_plane_stress(self, channels: FloatArray) -> None:
        """Take a piece of the channels (k, n)."""
        if self.shear is not None and self.gauge.plane_stress is not None:
            self.shear.update(self.gauge.plane_stress(channels))

    def update(self, stress: FloatArray) -> None:
        """Take a piece of the stress in each way (ways, n)."""
        self.count.update_statistics(stress[0])
        if self.sharp:
            self.samples_only.update(stress[0])
        else:
            self.update_counts(stress)

    def update_counts(self, stress: FloatArray) -> None:
        """Take what is counted of a piece."""
        self.range_mean = self.range_mean.with_cycles(self.count.update(stress[0]))
        if self.intervals is not None:
            self.intervals.update(stress[0])
        for k, tally in self.others.items():
            tally.update(stress[k])

    def result(self, samples: int, distance: float) -> GaugeAssessment:
        """Return what it came to in a recording of so many samples."""
        frozen = merge_runs(
            d[kind].undecided
            for d in self.decided.values()
            for kind in (FAULT_FREEZE, FAULT_RESPONSE)
            if kind in d
        )
        live = self.count.live - int((frozen[:, 1] - frozen[:, 0]).sum())
        spectrum = self.count.welch.spectrum()
        fast = 0.0
        if spectrum is not None and (whole := spectrum.moment(0)) > 0:
            above = spectrum.frequency > 0.4 * self.rate
            fast = Spectrum(spectrum.frequency[above], spectrum.density[above]).moment(0) / whole
            fast = max(fast, self.count.loud.high_frequency_share())
        quality = DataQuality(
            live_time=max(live, 0) / self.rate,
            recorded_time=samples / self.rate,
            effects=tuple(self._effects()),
            high_frequency_share=fast,
            damage_of_samples_only=self.samples_only.total_damage() if self.sharp else float("nan"),
            biaxiality=self.shear.biaxiality() if self.shear else float("nan"),
            damage_by_measure=self.shear.measures() if self.shear else {},
            doubts=self.gauge.doubts,
            damage=self.count.total_damage(),
            damage_without_undecided=next(
                (
                    t.total_damage()
                    for k, t in self.others.items()
                    if self.how[k].kind == ALL_UNDECIDED_FAULT_KINDS
                ),
                float("nan"),
            ),
        )
        one = self.count.result(self.gauge, self.healths, quality)
        one = replace(one, quality=self._with_contradictions(one))
        quality = one.quality
        return replace(
            one, life=replace(one.life, distance=distance * quality.live_share),
            matrices=self._matrices(),
        )  # fmt: skip

    def _matrices(self) -> tuple[RainflowTable, ...]:
        """Return all cycles by bins, from where to where and by range and mean."""
        if not self.count.residue.size:
            return ()
        left = self.plan.residue_rule(self.count.residue)
        return (
            from_to_table(self.count.matrix.with_cycles(left)),
            self.range_mean.with_cycles(left).nonempty_bins(),
        )

    def _with_contradictions(self, one: GaugeAssessment) -> DataQuality:
        """Return a gauge's quality with what its numbers contradict of what was said."""
        of, damage, allowed = one.quality, one.life.damage, self.plan.allowed
        if not one.has_signal:
            return of
        told = list(self.healths.values())
        level = np.array(
            [[float(np.nanmedian(h.levels)) if h.levels.size else h.mean] for h in told]
        )
        swing = np.array([[h.typical_swing] for h in told])
        typical = max(float(np.abs(self.gauge.stress(x))[0]) for x in (level, swing))
        # An accepted spike may still be no stress of the part.
        jumps = any(
            kind in (FAULT_SENTINEL, FAULT_SPIKE, FAULT_DROPOUT)
            and d.intervals.count > len(d.masked)
            for own in self.decided.values()
            for kind, d in own.items()
        )
        stated = DeclaredRecordingProperties(
            rate=self.rate,
            bend_share=min(h.bend_share for h in told),
            max_known_frequency=self.plan.max_known_frequency,
            ultimate=self.plan.ultimate,
            stuck_bit_value=max(h.whole_channel_size(FAULT_BIT) for h in told),
        )
        against = stated.contradictions(
            low=one.min_stress,
            high=one.max_stress,
            typical=typical,
            sound=not jumps,
            plane=self.gauge.plane_stress is not None,
        )
        accepted = {
            r.kind
            for r in self.plan.fault_rules
            for c in self.healths
            if not r.mask and r.applies_to(c, r.kind)
        }
        samples = max(h.samples for h in self.healths.values())
        effects = tuple(
            FaultEffect(
                kind=kind, count=1, samples=samples, share=1.0, undecided=int(kind not in accepted),
                damage_recorded=damage, damage_without=float("nan"), reason=why,
            )
            for kind, why in against.items()
        )  # fmt: skip
        doubts = of.doubts
        if not of.vetoes and damage >= allowed:
            doubts = (*doubts, DOUBT_DAMAGE_ABOVE_FAILURE.with_values(times=damage / allowed))
        assumed = None
        if self.gauge.alternative_unit is not None:
            other, factor = self.gauge.alternative_unit
            of_other = miner_damage(
                one.cycles.scaled(factor), curve=self.plan.curve, correction=self.plan.correction
            )  # fmt: skip
            assumed = AssumedUnit(
                unit=self.gauge.assumed_unit, other_unit=other, factor=factor, damage=of_other
            )  # fmt: skip
        return replace(of, effects=(*of.effects, *effects), doubts=doubts, assumed_unit=assumed)

    def _effects(self) -> Iterator[FaultEffect]:
        ruled = self.count.total_damage()
        for kind in dict.fromkeys(k for told in self.decided.values() for k in told):
            of = [told[kind] for told in self.decided.values() if kind in told]
            damage = {
                self.how[k].without: tally.total_damage()
                for k, tally in self.others.items()
                if self.how[k].kind == kind
            }
            samples = sum(d.intervals.sample_count for d in of)
            hidden, most = self.hidden.get(kind, merge_runs([])), float("nan")
            if self.intervals is not None and (count := self.hidden_counts.get(kind, 0)):
                most = ruled + self.intervals.worst(count)
            yield FaultEffect(
                kind=kind,
                count=sum(d.intervals.count for d in of),
                samples=samples,
                share=samples / max(sum(h.samples for h in self.healths.values()), 1),
                undecided=0 if kind == FAULT_MISSING_SAMPLES else sum(len(d.undecided) for d in of),
                damage_recorded=damage.get(False, ruled),
                damage_without=damage.get(True, ruled),
                damage_if_worst=most,
                hidden_time=float(np.diff(hidden).sum()) / self.rate,
            )
