"""A campaign: how a recording is to be listened to, and what its gauges are held against.

It is written in the words of the command line, which are those of the measuring engineer:
`CHANNEL:UNIT`, `NAME=A,B,C`, MPa and Hz. What they come to in SI follows from it and from a
recording.
"""

import math
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from cardan.application.limit_profiles import load_profile as profile
from cardan.application.quantity_lookup import declared_quantity
from cardan.core.arrays import FloatArray
from cardan.core.errors import CardanError, DesignError
from cardan.core.provenance import Source
from cardan.core.units import GPa, MPa, deg, hour
from cardan.core.verdict import Limit
from cardan.physics.fatigue import mean_stress as correction
from cardan.physics.fatigue import rainflow
from cardan.physics.fatigue import strain_gauges as strain
from cardan.physics.fatigue import strain_life as local
from cardan.physics.fatigue.mean_stress import MeanStressCorrection
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.fatigue.strain_gauges import StrainGauge
from cardan.physics.signals import conditioning
from cardan.physics.signals.assessment import AssessmentSettings
from cardan.physics.signals.channel_units import (
    ROTATION_SPEED_UNITS,
    STRAIN_UNITS,
    STRESS_UNITS,
    TORQUE_UNITS,
    VEHICLE_SPEED_UNITS,
)
from cardan.physics.signals.data_quality import FaultRule
from cardan.physics.signals.faults.registry import (
    FAULT_KINDS,
    IMPOSSIBLE_STRESS_FAULTS,
    MASKABLE_OR_CORRECTABLE_FAULTS,
)
from cardan.physics.signals.faults.whole_channel import FAULT_DRIFT
from cardan.physics.signals.recording import Recording
from cardan.schema.node_reader import nearest_name_hint
from cardan.topics.recording.alternative_life_models import CrackGrowthSettings, StrainLifeSettings
from cardan.topics.recording.channel_reading import (
    UNIT_CONFUSED_WITH_BY_UNIT,
    channel_unit,
    check_sampled_evenly,
    sampled_channels,
    split_unit,
    unit_doubts,
    unit_factor,
)
from cardan.topics.recording.option_table import OPTIONS, SN_CURVE_MAXIMA, OptionTable

STUDY_NAME = "recording"
LIFE_OPTION_SOURCE = Source("given with the recording")
"""Source of the required life, where no profile does."""

DEFAULT_WALKER_EXPONENT = 0.65
"""Exponent of Walker's equation where none is given: about that of steels (Dowling, Fatigue Fract.
Eng. Mater. Struct. 32 (2009)).
"""
_KINDS = {"rectangular": strain.RECTANGULAR_ROSETTE_ANGLES, "delta": strain.DELTA_ROSETTE_ANGLES}
_CURVES: dict[str, Callable[[SNCurve], SNCurve]] = {
    "original": SNCurve.original,
    "elementary": SNCurve.elementary,
    "modified": SNCurve.modified,
}
_RESIDUES = {
    "half": rainflow.half_cycles,
    "repeat": rainflow.repeating,
    "discard": rainflow.discarded,
}
_ZEROS = {
    "none": conditioning.no_baseline,
    "start": conditioning.baseline_at_start,
    "median": conditioning.baseline_at_median,
    "drift": conditioning.running_median_baseline,
}

MIN_SAMPLES = 4
"""Samples of a recording needed for a life: fewer close no cycle (four-point rainflow)."""
MIN_SAMPLES_FOR_CRESTS = 20
"""Samples of a recording from which crests are looked for between them: a shorter one is a list of
its reversals, as the examples of ASTM E1049 are."""

SHAFT_SPEED_OPTION_NAMES = "speed", "tacho", "estimate_speed"
"""What may give the shaft's angle, one of them."""

JOINT_EXCITATION_ORDERS = 2.0, 4.0, 6.0
"""At which a joint swings its shaft, and at which it is identified."""


@dataclass(frozen=True, kw_only=True)
class AnalysisOptions(OptionTable):
    """How a recording is analysed: the options of `cardan life`, checked, and what they come to."""

    @classmethod
    def from_values(cls, **options: Any) -> "AnalysisOptions":
        """Return a campaign from a script's values: what has commas in words may be a list.

        Raises
        ------
        CardanError
            If there is no such option, or no S-N curve.
        """
        for name in options:
            if name not in OPTIONS:
                msg = f"a recording has no option {name}; {nearest_name_hint(name, OPTIONS)}"
                raise CardanError(msg)
        if "sn" not in options:
            msg = "a recording needs an S-N curve: sn=(MPa, cycles, slope)"
            raise CardanError(msg)
        return cls(**{n: _worded(v, several=OPTIONS[n].is_repeatable) for n, v in options.items()})

    def __post_init__(self) -> None:
        for name, one in OPTIONS.items():
            value = getattr(self, name)
            if one.choices and value not in one.choices:
                msg = f"{name} must be one of {', '.join(one.choices)}, got {value!r}"
                raise DesignError(msg)
        for name, one in OPTIONS.items():
            value = getattr(self, name)
            if one.bounds is not None and value is not None and not one.bounds.holds(value):
                word, low = one.bounds.lower_bound
                msg = (
                    f"{one.flag} must be {word} {low:g} and at most {one.bounds.most:g}, "
                    f"got {value:g}" + ("" if math.isfinite(value) else "; it must be finite")
                )
                raise DesignError(msg)
        for name in ("joint_orders", "engine_orders"):
            given = getattr(self, name)
            if name == "engine_orders" and not given:
                continue
            said = parse_numbers(given, of=OPTIONS[name].flag)
            wrong = [n for n in said if not 0 < n <= 100]
            if wrong:
                msg = f"{OPTIONS[name].flag} must be above 0 and at most 100, got {wrong[0]:g}"
                raise DesignError(msg)
            if name == "joint_orders" and (none := sorted({*said} - {*JOINT_EXCITATION_ORDERS})):
                msg = f"{OPTIONS[name].flag} are of 2, 4 and 6, got {none[0]:g}"
                raise DesignError(msg)
        self._hold_together()
        _ = (
            self.rules,
            self.channel_scales,
            self.strain_life_settings,
            self.crack_growth_settings,
        )  # refuse what is none
        if self.service_hours and not (self.scatter or self.gauge_error or self.miner_scatter):
            msg = "odds need something that scatters: --scatter, --gauge-error or --miner-scatter"
            raise DesignError(msg)
        if self.unit_stress and self.application is None:
            msg = "--unit-stress needs the --application whose bearing loads it is for"
            raise DesignError(msg)
        if self.identify and not self.unit_stress:
            msg = (
                "--identify needs the --application, and with --unit-stress what its bearing does "
                "at a gauge"
            )
            raise DesignError(msg)
        if self.changed is not None and not self.identify:
            msg = "--changed is compared with the line that --identify finds: add --identify"
            raise DesignError(msg)
        if self.identify and (self.torque is None or not (self.speed or self.tacho)):
            msg = "--identify needs the shaft's --torque and a --tacho or --speed"
            raise DesignError(msg)

    def _hold_together(self) -> None:
        """Refuse options that do nothing with the others, or say two things of one."""
        for name, one in OPTIONS.items():
            if one.needs and getattr(self, name) != one.default and not getattr(self, one.needs):
                msg = f"{one.flag} does nothing by itself: it needs {OPTIONS[one.needs].flag}"
                raise DesignError(msg)
        if self.mean_sensitivity is not None and self.mean_stress not in ("fkm", "walker"):
            msg = "--mean-sensitivity does nothing by itself: it needs --mean-stress fkm or walker"
            raise DesignError(msg)
        turned = [OPTIONS[name].flag for name in SHAFT_SPEED_OPTION_NAMES if getattr(self, name)]
        if len(turned) > 1:
            msg = f"the shaft is turned by {turned[0]} or by {turned[1]}: say one of them"
            raise DesignError(msg)

    @property
    def can_databases(self) -> tuple[Path, ...]:
        """Where the CAN databases of a log of frames are."""
        return tuple(Path(name) for name in self.dbc if name)

    @property
    def line(self) -> str:
        """The line of the application whose bearing loads it predicts; "" without one."""
        return self.application.lines[0].line.name if self.application else ""

    def profile_and_limits(self) -> tuple[str, tuple[Limit, ...]]:
        """Return the name of the profile, "" without one, and the limits of gauges in SI.

        Raises
        ------
        InvalidFileError
            If there is no such profile, or something is wrong in it.
        """
        name, rows = profile(self.limits) if self.limits else ("", ())
        found = [m for m in rows if declared_quantity(m.quantity).study == STUDY_NAME]
        if self.target_hours is not None:
            found.append(
                Limit(
                    quantity="fatigue_life", sense=">=", maximum=self.target_hours * hour,
                    required=True, source=LIFE_OPTION_SOURCE,
                )
            )  # fmt: skip
        return name, tuple(found)

    def order2_predictions(self) -> dict[str, float]:
        """Return order-2 stress per shaft torque by gauge, Pa per N m: given, or predicted."""
        found: dict[str, float] = {}
        for name, unit in self.unit_stresses().items():
            from cardan.topics.recording.order2_prediction import order2_stress_per_torque

            assert self.application is not None  # __post_init__ refuses
            found[name] = order2_stress_per_torque(
                self.application, unit_stress=unit, state=self.state, bearing=self.bearing
            )
        for text in self.predicted:
            name, _, value = text.rpartition("=")
            try:
                found[name] = float(value) * MPa / 1e3
            except ValueError:
                found[name] = math.nan
            if not 0 <= found[name] < math.inf:
                msg = f"a prediction is GAUGE=MPa_per_kNm, got {text!r}"
                raise DesignError(msg)
        return found

    def unit_stresses(self) -> dict[str, FloatArray]:
        """Return what a unit force of the bearing does at gauges, (3,) Pa/N each."""
        found: dict[str, FloatArray] = {}
        for text in self.unit_stress:
            name, _, axes = text.rpartition("=")
            found[name] = np.array(parse_numbers(axes, of="--unit-stress")) * MPa / 1e3
            if found[name].shape != (3,):
                msg = f"a unit stress is GAUGE=X,Y,Z in MPa per kN, got {text!r}"
                raise DesignError(msg)
        return found

    @property
    def rules(self) -> tuple[FaultRule, ...]:
        """What is masked and accepted of what looks wrong: what says more counts last.

        A time says more than a channel, and a channel more than none.

        Raises
        ------
        DesignError
            If the same is masked and accepted.
        """
        masked = [(text, parse_rule(text, mask=True)) for text in self.mask]
        accepted = [(text, parse_rule(text, mask=False)) for text in self.accept]
        for text, one in masked:
            for other_text, other in accepted:
                if one.contradicts(other):
                    msg = (
                        f"--mask {text} and --accept {other_text} say two things of the same: "
                        "say one of them"
                    )
                    raise DesignError(msg)
        said = [rule for _, rule in (*masked, *accepted)]
        return tuple(sorted(said, key=lambda r: (not r.covers_all_time, r.channel != "")))

    def for_segment(self, first: float, last: float) -> "AnalysisOptions":
        """Return the settings of a stretch of the recording: its rules, by the stretch's clock.

        A rule of other times is none of it.
        """

        def moved(given: tuple[str, ...], *, mask: bool) -> tuple[str, ...]:
            told: list[str] = []
            for text in given:
                rule = parse_rule(text, mask=mask)
                if rule.covers_all_time:
                    told.append(text)
                elif rule.first < last and rule.last > first:
                    what = f"{rule.channel}=" if rule.channel else ""
                    what += f"{rule.kind}@" if rule.kind else ""
                    end = "" if math.isinf(rule.last) else rule.last - first
                    told.append(f"{what}{max(rule.first - first, 0.0)}..{end}")
            return tuple(told)

        return replace(
            self, mask=moved(self.mask, mask=True), accept=moved(self.accept, mask=False)
        )

    def rules_after_end(self, seconds: float) -> tuple[str, ...]:
        """Return what is said of times behind the end of a recording: it does nothing."""
        said = [("mask", text) for text in self.mask] + [("accept", text) for text in self.accept]
        return tuple(
            f"--{option} {text} is of a time behind its end, {seconds:g} s: it does nothing"
            for option, text in said
            if seconds < parse_rule(text, mask=option == "mask").first
        )

    @property
    def strain_life_settings(self) -> StrainLifeSettings | None:
        """How places are judged by their strain; None if not requested."""
        if self.strain_life is None:
            return None
        given = _several(self.strain_life, of="--strain-life")
        if len(given) not in (4, 6):
            msg = (
                "a strain-life curve is SIGMA_F_MPa,B,EPSILON_F,C, perhaps with K_MPa,N of the "
                f"cyclic curve, got {self.strain_life!r}"
            )
            raise DesignError(msg)
        modulus = self.modulus_GPa * GPa
        strength, b, ductility, c = given[:4]
        if not 0 < ductility <= 10:
            msg = (
                "EPSILON_F of a strain-life curve is a strain, above 0 and at most 10 (0.6, not "
                f"60), got {ductility:g}"
            )
            raise DesignError(msg)
        curve = local.material_from_strain_life_curve(
            modulus=modulus, strength=strength * MPa, exponent=b, ductility=ductility,
            ductility_exponent=c,
        )  # fmt: skip
        if len(given) == 6:
            curve = replace(curve, hardening=given[4] * MPa, hardening_exponent=given[5])
        return StrainLifeSettings(
            material=curve, mean_stress_law=self.strain_mean, notch_factor=self.notch
        )

    @property
    def crack_growth_settings(self) -> CrackGrowthSettings | None:
        """How a crack is judged; None if not requested."""
        if self.crack is None:
            return None
        given = _several(self.crack, of="--crack")
        if len(given) != 4 or not 0 < given[0] < given[1] <= 1e4:
            msg = (
                "a crack is FROM_mm,TO_mm,C,M, growing to 10,000 mm at most, with C in m a cycle "
                f"and MPa√m, got {self.crack!r}"
            )
            raise DesignError(msg)
        start, end, C, m = given
        if not (0 < C < 1e-3 and 1 <= m <= 10):
            msg = (
                f"C of a crack's growth lies within (0, 1e-3) m a cycle and m within 1 to 10, got "
                f"C {C:g} and m {m:g}"
            )
            raise DesignError(msg)
        return CrackGrowthSettings(
            initial_size=start / 1e3,
            final_size=end / 1e3,
            C=C,
            m=m,
            threshold=self.crack_threshold,
            geometry_factor=self.crack_shape,
        )

    @property
    def channel_scales(self) -> dict[str, tuple[float, float, str]]:
        """Factor, offset and unit of the channels that are scaled."""
        found: dict[str, tuple[float, float, str]] = {}
        for text in self.scale:
            channel, _, rest = text.rpartition("=")
            value, _, unit = rest.rpartition(":")
            try:
                given = [float(v) for v in value.split(",")]
            except ValueError:
                given = []
            known = (
                *STRESS_UNITS,
                *STRAIN_UNITS,
                *ROTATION_SPEED_UNITS,
                *VEHICLE_SPEED_UNITS,
                *TORQUE_UNITS,
            )
            whole = channel and len(given) in (1, 2) and all(map(math.isfinite, given))
            if not whole or given[0] == 0 or unit not in known:
                msg = (
                    f"a scale is CHANNEL=FACTOR[,OFFSET]:UNIT with a unit of {', '.join(known)}, "
                    f"got {text!r}"
                )
                raise DesignError(msg)
            found[channel] = (given[0], given[1] if len(given) > 1 else 0.0, unit)
        return found

    def scale_channels(self, recording: Recording) -> Recording:
        """Return the recording with its scaled channels in the units they are scaled to."""
        scales = {recording.index_of(name): of for name, of in self.channel_scales.items()}
        if not scales:
            return recording
        channels = tuple(
            replace(c, unit=scales[k][2], unit_declared=True) if k in scales else c
            for k, c in enumerate(recording.channels)
        )

        def read(wanted: tuple[int, ...]) -> Iterator[FloatArray]:
            own = [scales.get(k, (1.0, 0.0, "")) for k in wanted]
            factor, offset = (np.array([o[k] for o in own])[:, None] for k in (0, 1))
            for piece in recording.read(wanted):
                yield piece * factor + offset

        notes = (
            f"{recording.channels[k].name} is its value times {factor:g} plus {offset:g}, in {unit}"
            for k, (factor, offset, unit) in scales.items()
        )
        return replace(
            recording, channels=channels, read=read, notes=(*recording.notes, *notes)
        )  # fmt: skip

    def has_strain_gauges(self, recording: Recording) -> bool:
        """Return whether a gauge is of strain, which Young's modulus makes a stress."""
        units = (
            given or channel_unit(recording.channel(c)) for c, given in map(split_unit, self.gauges)
        )
        return bool(self.rosettes) or any(unit in STRAIN_UNITS for unit in units)

    def _held(self, option: str, given: Iterable[str], known: Iterable[str], kind: str) -> None:
        """Refuse what is said of a gauge or channel that there is not."""
        names = list(known)
        for name in given:
            if name not in names:
                msg = f"--{option}: no {kind} {name!r}; {nearest_name_hint(name, names)}"
                raise DesignError(msg)

    def channel_roles(self, recording: Recording) -> dict[str, str]:
        """Return what each channel in use of a recording is."""
        found = {c: "gauge" for g in self.assessment_settings(recording).gauges for c in g.channels}
        for role in ("speed", "tacho", "torque", "engine"):
            if (of := getattr(self, role)) is not None:
                found.setdefault(recording.channel(split_unit(of)[0]).name, role)
        return found

    def assessment_settings(self, recording: Recording) -> AssessmentSettings:
        """Return what is counted of a recording, and held against which strength.

        Raises
        ------
        DesignError
            If it lacks a channel, a unit is not known, or an option is not as it should be.
        """
        gauges = (*self._singles(recording), *self._rosettes(recording))
        if not gauges:
            known = ", ".join(recording.names)
            msg = f"name the gauges with --gauge; {recording.name} has {known}"
            raise DesignError(msg)
        names = [g.name for g in gauges]
        for name in names:
            if names.count(name) > 1:
                msg = f"two gauges are called {name}"
                raise DesignError(msg)
        foretold = [text.rpartition("=")[0] for text in self.predicted]
        self._held("predicted", foretold, names, "gauge")
        felt = [text.rpartition("=")[0] for text in self.unit_stress]
        self._held("unit-stress", felt, names, "gauge")
        if (foretold or felt) and self.torque is None:
            msg = (
                "a predicted order 2 is held against the measured by torque: name it with --torque"
            )
            raise DesignError(msg)
        channels = {c for g in gauges for c in g.channels}
        turning = (self.speed, self.engine, self.torque)
        channels |= {split_unit(text)[0] for text in turning if text is not None}
        ruled = [r.channel for r in self.rules if r.channel]
        self._held("mask and --accept", ruled, channels, "gauge's channel")
        if self.low_pass_Hz is not None:
            conditioning.check_cutoff(self.low_pass_Hz, rate=recording.rate)
        return AssessmentSettings(
            gauges=gauges,
            curve=self._curve(),
            correction=self._correction(),
            residue_rule=_RESIDUES[self.residue],
            baseline=_ZEROS[self.zero],
            low_pass=self.low_pass_Hz,
            allowed=self.allowed,
            gauge_error=self.gauge_error,
            fault_rules=self.rules,
            interpolate_crests={"auto": None, "yes": True, "no": False}[self.between_samples],
            ultimate=math.inf if self.ultimate_MPa is None else self.ultimate_MPa * MPa,
        )

    def check_recording(self, recording: Recording, *, samples: int) -> None:
        """Refuse a recording of so many samples that is too short for a life."""
        if samples < MIN_SAMPLES:
            msg = f"{recording.name} holds {samples} samples; a life takes {MIN_SAMPLES} or more"
            raise DesignError(msg)
        seconds, cutoff = samples / recording.rate, self.low_pass_Hz
        if cutoff is not None and cutoff * seconds < 1:
            msg = (
                f"low_pass_Hz keeps not one period of {recording.name}, {seconds:.4g} s long: it "
                f"must be {1 / seconds:.2g} Hz or more, got {cutoff:g}"
            )
            raise DesignError(msg)

    def _singles(self, recording: Recording) -> list[StrainGauge]:
        modulus = self.modulus_GPa * GPa
        units = STRESS_UNITS | {u: modulus * v for u, v in STRAIN_UNITS.items()}
        named = [split_unit(text) for text in self.gauges]
        found: list[StrainGauge] = []
        for channel, given in named:
            factor = unit_factor(recording, channel, given, units)
            check_sampled_evenly(recording, channel)
            gauge = strain.single_gauge(channel, channel, factor=factor)
            of = recording.channel(channel)
            taken = given or channel_unit(of)
            gauge = replace(gauge, doubts=unit_doubts(of, taken))
            if taken in UNIT_CONFUSED_WITH_BY_UNIT and not (of.unit_declared or channel_unit(of)):
                # Units confused when named by hand: numbers of either look alike.
                other = UNIT_CONFUSED_WITH_BY_UNIT[taken]
                gauge = replace(
                    gauge, assumed_unit=taken, alternative_unit=(other, units[other] / factor)
                )
            found.append(gauge)
        return found

    def _rosettes(self, recording: Recording) -> list[StrainGauge]:
        found: list[StrainGauge] = []
        for text in self.rosettes:
            name, _, rest = text.partition("=")
            grids, given = split_unit(rest)
            channels = tuple(grids.split(","))
            if len(channels) != 3:
                msg = f"a rosette is NAME=A,B,C with three channels, got {text!r}"
                raise DesignError(msg)
            for twice in (c for k, c in enumerate(channels) if c in channels[:k]):
                msg = (
                    f"rosette {name}: {twice} stands in it twice; three channels are one grid each"
                )
                raise DesignError(msg)
            units = np.array([unit_factor(recording, c, given, STRAIN_UNITS) for c in channels])[
                :, None
            ]
            for channel in channels:
                check_sampled_evenly(recording, channel)
            angles, modulus = _KINDS[self.rosette_kind], self.modulus_GPa * GPa
            read, _ = sampled_channels(recording, channels)
            read = read[:, np.isfinite(read).all(0)]
            if self.zero != "none" and read.size:
                read = read - np.median(read, axis=1, keepdims=True)
            along = strain.dominant_stress_direction(
                strain.plane_stress_of_rosette(read * units, angles=angles, modulus=modulus)
            )
            found += [
                strain.rosette_gauge(
                    name + end, channels, unit=units, angles=angles, modulus=modulus, measure=of,
                    along=along,
                )
                for end, of in self._measures().items()
            ]  # fmt: skip
        return found

    def _measures(self) -> dict[str, strain.StressMeasureFunction | None]:
        """Return what is counted of a rosette, by the ending of the gauge's name."""
        if self.rosette_measure == "planes":
            angles = sorted({*range(0, 180, 10), 45, 135})  # a shaft's, by a leg on its axis
            return {f"@{a}": partial(strain.PlaneStress.normal, angle=a * deg) for a in angles}
        return {"": None if self.rosette_measure == "mises" else strain.abs_max_principal}

    def _curve(self) -> SNCurve:
        try:
            amplitude, cycles, slope = (float(v) for v in self.sn.split(","))
        except ValueError:
            msg = f"an S-N curve is AMPLITUDE_MPa,CYCLES,SLOPE at its knee, got {self.sn!r}"
            raise DesignError(msg) from None
        if not (math.isfinite(amplitude) and math.isfinite(cycles) and math.isfinite(slope)):
            msg = f"an S-N curve is of finite numbers, got {self.sn!r}"
            raise DesignError(msg)
        for name, value, most in zip(
            ("AMPLITUDE_MPa", "CYCLES", "SLOPE"), (amplitude, cycles, slope), SN_CURVE_MAXIMA,
            strict=True,
        ):  # fmt: skip
            if not 0 < value <= most:
                msg = (
                    f"{name} of the S-N curve {self.sn} must be above 0 and at most {most:g}, "
                    f"got {value:g}: write AMPLITUDE_MPa,CYCLES,SLOPE"
                )
                raise DesignError(msg)
        if self.ultimate_MPa is not None and amplitude >= self.ultimate_MPa:
            msg = (
                f"the S-N curve's knee, {amplitude:g} MPa, must lie below the tensile strength, "
                f"--ultimate-MPa {self.ultimate_MPa:g}"
            )
            raise DesignError(msg)
        curve = SNCurve(amplitude=amplitude * MPa, cycles=cycles, slope=slope, scatter=self.scatter)
        return _CURVES[self.miner](curve)

    @property
    def effective_mean_sensitivity(self) -> float | None:
        """M of fkm or the exponent of walker, as they are in force; None of others."""
        if self.mean_sensitivity is not None or self.mean_stress not in ("fkm", "walker"):
            return self.mean_sensitivity
        if self.mean_stress == "walker":
            return DEFAULT_WALKER_EXPONENT
        if self.ultimate_MPa is None:
            msg = "fkm needs the tensile strength (--ultimate-MPa) or --mean-sensitivity"
            raise DesignError(msg)
        return correction.steel_mean_stress_sensitivity(self.ultimate_MPa * MPa)

    def _correction(self) -> MeanStressCorrection:
        name = self.mean_stress
        ultimate = None if self.ultimate_MPa is None else self.ultimate_MPa * MPa
        if name in ("goodman", "gerber"):
            if ultimate is None:
                msg = f"{name} needs the tensile strength: --ultimate-MPa"
                raise DesignError(msg)
            return partial(getattr(correction, name), ultimate=ultimate)
        if name == "fkm":
            return partial(correction.fkm, sensitivity=self.effective_mean_sensitivity or 0.0)
        if name == "walker":
            return partial(correction.walker, exponent=self.effective_mean_sensitivity or 0.0)
        return correction.swt if name == "swt" else correction.uncorrected


_TIMES = re.compile(r"([0-9.eE+-]*?)\.\.([0-9.eE+-]*)")


def parse_rule(text: str, *, mask: bool) -> FaultRule:
    """Return the rule of `[CHANNEL=]KIND[@FROM..TO]` or `[CHANNEL=]FROM..TO`."""
    channel, _, rest = text.rpartition("=")
    kind, at, times = rest.partition("@")
    if not at and _TIMES.fullmatch(rest):
        kind, times = "", rest
    match = _TIMES.fullmatch(times) if times else None
    try:
        first = float(match[1] or 0) if match else 0.0
        last = float(match[2] or math.inf) if match else math.inf
    except ValueError:
        match = None
        first, last = 0.0, math.inf
    if (times and match is None) or not 0 <= first < last:
        msg = f"a time is FROM..TO in seconds, the first before the last, got {text!r}"
        raise DesignError(msg)
    if kind and kind not in FAULT_KINDS:
        msg = f"{text!r}: no kind of fault {kind!r}; there are: {', '.join(FAULT_KINDS)}"
        raise DesignError(msg)
    if mask and kind and kind not in MASKABLE_OR_CORRECTABLE_FAULTS:
        instead = "--zero drift takes it off" if kind == FAULT_DRIFT else "what it hides is unknown"
        if kind in IMPOSSIBLE_STRESS_FAULTS:
            instead = "it is of the gauge as a whole"
        choices = ", ".join(MASKABLE_OR_CORRECTABLE_FAULTS)
        msg = f"a {kind} cannot be masked: {instead}; can be: {choices}"
        raise DesignError(msg)
    if not (kind or times):
        msg = f"a rule is [CHANNEL=]KIND[@FROM..TO] or [CHANNEL=]FROM..TO, got {text!r}"
        raise DesignError(msg)
    return FaultRule(mask=mask, kind=kind, channel=channel, first=first, last=last)


def options_as_campaign_file_keys(said: str) -> str:
    """Return what is said of options in the words of a campaign's file, whatever the language.

    >>> options_as_campaign_file_keys("goodman needs the tensile strength: --ultimate-MPa")
    'goodman needs the tensile strength: ultimate_MPa'
    """
    said = re.sub(
        r"--scale (.+?)=(\S+?)(?:\[?,(\S+?)\]?)?:(\S+)",
        lambda m: (
            f"channels: {{{m[1]}: {{factor: {m[2]}, {'offset: 0, ' * bool(m[3])}unit: {m[4]}}}}}"
        ),
        said,
    )
    keys = {o.flag: next((k.name for k in o.keys if k.name), o.name) for o in OPTIONS.values()}

    def key(at: re.Match[str]) -> str:
        return keys.get(at[0], at[0])

    return re.sub(r"--([A-Za-z][A-Za-z-]*[A-Za-z])", key, said)


def parse_numbers(text: str, *, of: str = "") -> tuple[float, ...]:
    """Return numbers that were written with commas between, `of` an option that is then named."""
    try:
        return tuple(float(v) for v in text.split(","))
    except ValueError:
        msg = f"expected numbers with commas between, got {text!r}"
        raise DesignError(f"{of}: {msg}" if of else msg) from None


def _several(text: str, *, of: str) -> tuple[float, ...]:
    """Return numbers that were written with commas between; none where they are not finite."""
    given = parse_numbers(text, of=of)
    return given if all(map(math.isfinite, given)) else ()


def _worded(value: Any, *, several: bool) -> Any:
    """Return a script's value as the command line has it: one of several, or with commas."""
    if isinstance(value, str) or not isinstance(value, Iterable):
        return (value,) if several else value
    return tuple(value) if several else ",".join(map(str, value))
