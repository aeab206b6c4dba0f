"""A campaign: how a recording is to be listened to, and what its gauges are held against.

It is written in the words of the command line, which are those of whoever measured:
`CHANNEL:UNIT`, `NAME=A,B,C`, MPa and Hz. What they come to in SI follows from it and from a
recording.
"""

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any

import numpy as np

from cardan.base.arrays import FloatArray, IntArray
from cardan.base.errors import CardanError, DesignError
from cardan.base.said import Said, said
from cardan.base.source import Source
from cardan.base.units import GPa, MPa, deg, hour
from cardan.base.verdict import Limit
from cardan.border.table import nearest
from cardan.fatigue import conditioning, correction, local, rainflow, strain
from cardan.fatigue.angle import (
    MOST,
    SHAFTS,
    VEHICLES,
    Angle,
    no_torque,
    no_value,
    shaft_angle,
)
from cardan.fatigue.correction import Correction
from cardan.fatigue.fault import DRIFT, IMPOSSIBLE, KINDS, REMOVABLE, SENTINEL
from cardan.fatigue.life import Plan
from cardan.fatigue.orders import Rotation, estimated_rotation, rotation_from_pulses
from cardan.fatigue.quality import NAMED_STRAIN, NAMED_STRESS, Rule
from cardan.fatigue.recording import Channel, Recording, holed
from cardan.fatigue.strain import Gauge
from cardan.fatigue.strength import SNCurve
from cardan.fatigue.unit import DRIVEN, SPEED, STRAIN, STRESS, TORQUE, TURN, UNITS, VOLTS
from cardan.files.limit import limits as profile
from cardan.model.application import Application
from cardan.quantity.quantities import QUANTITIES
from cardan.study.otherwise import Cracked, Strained
from cardan.study.recorded import predicted_stress

NAME = "recording"
ASKED = Source("asked of the recording")
"""Who says how long a gauge has to live, where no profile does."""

WALKER = 0.65
"""Exponent of Walker's equation where none is given: about that of steels (Dowling, Fatigue Fract.
Eng. Mater. Struct. 32 (2009)).
"""
FASTEST = 25.0
"""Turns/s that a shaft's tacho must be able to tell: 1500 rpm."""

_WRITTEN = re.compile(
    r"(?<=[\s_\[(])("
    + "|".join(
        sorted(map(re.escape, [u for u in UNITS if u != "%"] + ["mV/V", "mV"]), key=len)[::-1]
    )
    + r")[\])]?\s*$"
)
"""The unit a channel's name ends in: `S1_MPa`, `torque [Nm]`."""
_STRAINS = re.compile(
    r"(?<![a-z])(strain(?!\W*_*gau)|dehnung|deforma[çz]|epsilon|mikrodehn)", re.IGNORECASE
)
_STRESSES = re.compile(r"(?<![a-z])(stress|spannung|tens[ãi]o|sigma)", re.IGNORECASE)

ASSUMED: Mapping[str, str] = {
    u: "um/m" if u in ("MPa", "N/mm2", "N/mm²") else "MPa"
    for u in UNITS
    if u in ("MPa", "N/mm2", "N/mm²") or STRAIN.get(u) == STRAIN["um/m"]
}
"""Units whose numbers look alike, some tens to hundreds: which it may be as well."""

FASTEST_SHAFT = 200.0
"""Turns a second that no propshaft makes: 12,000 rpm."""

_KINDS = {"rectangular": strain.RECTANGULAR, "delta": strain.DELTA}
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
    "none": conditioning.no_zero,
    "start": conditioning.zero_at_start,
    "median": conditioning.zero_at_median,
    "drift": conditioning.slow_drift,
}

FEWEST = 20
"""Samples of a recording that a life is told of: some cycles of some samples each."""

CHOICES: Mapping[str, tuple[str, ...]] = {
    "rosette_kind": tuple(_KINDS),
    "rosette_measure": ("mises", "principal", "planes"),
    "miner": tuple(_CURVES),
    "mean_stress": ("none", "goodman", "gerber", "swt", "walker", "fkm"),
    "residue": tuple(_RESIDUES),
    "zero": tuple(_ZEROS),
    "between_samples": ("auto", "yes", "no"),
    "strain_mean": local.LAWS,
}
"""What an option may be, where it is one of a few."""

NEEDED: Mapping[str, str] = {
    "notch": "strain_life",
    "strain_mean": "strain_life",
    "crack_threshold": "crack",
    "crack_shape": "crack",
    "miner_scatter": "service_hours",
    "state": "application",
    "bearing": "application",
    "rosette_kind": "rosettes",
    "rosette_measure": "rosettes",
    "pulses": "tacho",
}
"""Options that say how another one is meant, and do nothing without it."""

TURNED_BY = "speed", "tacho", "estimate_speed"
"""What may tell how far the shaft has turned, one of them."""

JOINT_ORDERS = 2.0, 4.0, 6.0
"""At which a joint swings its shaft, and at which it is identified."""

_ABOVE, _FROM = "above", "at least"
RANGES: Mapping[str, tuple[str, float, float]] = {
    "modulus_GPa": (_ABOVE, 0, 2000),
    "ultimate_MPa": (_ABOVE, 0, 10_000),
    "scatter": (_FROM, 0, 1),
    "gauge_error": (_FROM, 0, 1),
    "mean_sensitivity": (_FROM, 0, 1),
    "allowed": (_ABOVE, 0, 100),
    "low_pass_Hz": (_ABOVE, 0, 1e9),
    "pulses": (_FROM, 1, 10_000),
    "axle_ratio": (_ABOVE, 0, 100),
    "tyre_radius_m": (_ABOVE, 0, 5),
    "bearing": (_FROM, 1, 100),
    "rate": (_ABOVE, 0, 1e9),
    "target_hours": (_ABOVE, 0, 1e12),
    "notch": (_FROM, 1, 20),
    "crack_threshold": (_FROM, 0, 100),
    "crack_shape": (_ABOVE, 0, 10),
    "service_hours": (_ABOVE, 0, 1e12),
    "miner_scatter": (_FROM, 0, 2),
}
"""Where an option's number lies: above or at least the first, at most the second."""


@dataclass(frozen=True, kw_only=True)
class Campaign:
    """How a recording is listened to. Every field is an option of `cardan life`.

    Attributes
    ----------
    gauges, rosettes
        `CHANNEL[:UNIT]` of stress or strain; `NAME=A,B,C[:UNIT]`.
    rosette_kind, rosette_measure, miner, mean_stress, residue, zero
        One of `CHOICES`.
    sn
        `MPa,CYCLES,SLOPE` at the knee, half failed.
    scatter
        Standard deviation of log10 strength.
    gauge_error
        Relative standard deviation of the stress scale.
    mean_sensitivity
        M of fkm, or the exponent of walker.
    allowed
        Damage at failure.
    scale
        `CHANNEL=FACTOR[,OFFSET]:UNIT` of what was written in volts or mV/V: the value by the
        factor and the offset on top, in the unit.
    speed, engine, torque, tacho
        `CHANNEL[:UNIT]`; with a speed or a tacho causes are told. A speed of the vehicle (km/h)
        turns the shaft by `axle_ratio` and `tyre_radius_m`.
    estimate_speed
        The gauge in which it is looked for where nobody measured it.
    axle_ratio
        Shaft turns per wheel turn.
    predicted
        `GAUGE=MPa_per_kNm` of order 2, to hold against the measured.
    application, unit_stress, state, bearing
        What predicts it instead, with `GAUGE=X,Y,Z` in MPa per kN.
    strain_life, notch, strain_mean
        `MPa,B,STRAIN,C[,MPa,N]`: σf', b, εf' and c, perhaps K' and n': life until a crack by the
        local strain; K_t from the gauge to the notch, and one of `CHOICES`.
    crack, crack_threshold, crack_shape
        `MM,MM,C,M`: from one crack length to another, growth C ΔK^m (m a cycle, MPa√m), above a
        threshold in MPa√m; Y of K = Y S √(πa).
    service_hours, miner_scatter
        Hours in which the odds of failure are asked; coefficient of variation of the damage at
        failure.
    usage
        Whether it is told when and where the damage came.
    identify
        Whether the application's numbers are looked for in the recording.
    changed
        Another application, driven as the recording was: what it promises.
    rate, time, group
        How the file is read.
    mask, accept
        What of that which looks wrong is made a hole of, and what is what the part felt:
        `[CHANNEL=]KIND[@FROM..TO]`, or a time alone, `[CHANNEL=]FROM..TO`, in seconds. What is
        accepted was not masked.
    between_samples
        Whether crests are looked for between samples: `auto` where they lose 1 % or more.
    limits
        A profile by name or file; its rows of a recording count.
    target_hours
        What every gauge has to live.
    """

    sn: str
    scale: tuple[str, ...] = ()
    gauges: tuple[str, ...] = ()
    rosettes: tuple[str, ...] = ()
    rosette_kind: str = "rectangular"
    rosette_measure: str = "mises"
    modulus_GPa: float = 206.0  # noqa: N815
    scatter: float = 0.0
    gauge_error: float = 0.0
    miner: str = "modified"
    mean_stress: str = "none"
    ultimate_MPa: float | None = None  # noqa: N815
    mean_sensitivity: float | None = None
    residue: str = "half"
    allowed: float = 1.0
    zero: str = "none"
    low_pass_Hz: float | None = None  # noqa: N815
    speed: str | None = None
    tacho: str | None = None
    pulses: int = 1
    estimate_speed: str | None = None
    joint_orders: str = "2,4"
    engine: str | None = None
    engine_orders: str = ""
    axle_ratio: float | None = None
    tyre_radius_m: float | None = None
    torque: str | None = None
    predicted: tuple[str, ...] = ()
    application: Application | None = None
    unit_stress: tuple[str, ...] = ()
    state: str = "gvw"
    bearing: int = 1
    strain_life: str | None = None
    notch: float | None = None
    strain_mean: str = "swt"
    crack: str | None = None
    crack_threshold: float = 0.0
    crack_shape: float = 1.12
    service_hours: float | None = None
    miner_scatter: float = 0.3
    usage: bool = False
    identify: bool = False
    changed: Application | None = None
    rate: float | None = None
    time: str | None = None
    group: str = ""
    mask: tuple[str, ...] = ()
    accept: tuple[str, ...] = ()
    between_samples: str = "auto"
    limits: str | None = None
    target_hours: float | None = None

    @classmethod
    def of(cls, **options: Any) -> "Campaign":
        """Return a campaign from a script's values: what has commas in words may be a list.

        Raises
        ------
        CardanError
            If there is no such option, or no S-N curve.
        """
        several = {f.name: f.type == tuple[str, ...] for f in fields(cls)}
        for name in options:
            if name not in several:
                msg = f"a recording is not asked with {name}; {nearest(name, several)}"
                raise CardanError(msg)
        if "sn" not in options:
            msg = "a recording is asked with an S-N curve: sn=(MPa, cycles, slope)"
            raise CardanError(msg)
        return cls(**{name: _worded(v, several=several[name]) for name, v in options.items()})

    def __post_init__(self) -> None:
        for name, choices in CHOICES.items():
            if getattr(self, name) not in choices:
                msg = f"{name} must be one of {', '.join(choices)}, got {getattr(self, name)!r}"
                raise DesignError(msg)
        for name, (sort, low, high) in RANGES.items():
            value = getattr(self, name)
            if value is None:
                continue
            if not (low < value if sort == _ABOVE else low <= value) or not value <= high:
                msg = (
                    f"{_option(name)} must be {sort} {low:g} and at most {high:g}, "
                    f"got {value:g}" + ("" if math.isfinite(value) else "; it must be finite")
                )
                raise DesignError(msg)
        for name in ("joint_orders", "engine_orders"):
            given = getattr(self, name)
            if name == "engine_orders" and not given:
                continue
            said = numbers(given, of=f"--{name.replace('_', '-')}")
            wrong = [n for n in said if not 0 < n <= 100]
            if wrong:
                msg = f"{_option(name)} must be above 0 and at most 100, got {wrong[0]:g}"
                raise DesignError(msg)
            if name == "joint_orders" and (none := sorted({*said} - {*JOINT_ORDERS})):
                msg = f"{_option(name)} are of 2, 4 and 6, got {none[0]:g}"
                raise DesignError(msg)
        self._hold_together()
        _ = self.rules, self.scales, self.strained, self.cracked  # refuse what is none
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
            msg = "--changed is held against the line that --identify finds: ask for that too"
            raise DesignError(msg)
        if self.identify and (self.torque is None or not (self.speed or self.tacho)):
            msg = "--identify needs the shaft's --torque and a --tacho or --speed"
            raise DesignError(msg)

    def _hold_together(self) -> None:
        """Refuse options that do nothing beside the others, or say two things of one."""
        plain = {f.name: f.default for f in fields(self)}
        for name, other in NEEDED.items():
            if getattr(self, name) != plain[name] and not getattr(self, other):
                msg = f"{_option(name)} does nothing by itself: it needs {_option(other)}"
                raise DesignError(msg)
        if self.mean_sensitivity is not None and self.mean_stress not in ("fkm", "walker"):
            msg = "--mean-sensitivity does nothing by itself: it needs --mean-stress fkm or walker"
            raise DesignError(msg)
        turned = [_option(name) for name in TURNED_BY if getattr(self, name)]
        if len(turned) > 1:
            msg = f"the shaft is turned by {turned[0]} or by {turned[1]}: say one of them"
            raise DesignError(msg)

    @property
    def line(self) -> str:
        """The line of the application whose bearing loads it predicts; "" without one."""
        return self.application.lines[0].line.name if self.application else ""

    def asked(self) -> tuple[str, tuple[Limit, ...]]:
        """Return the name of the profile, "" without one, and the limits of gauges in SI.

        Raises
        ------
        BadFile
            If there is no such profile, or something is wrong in it.
        """
        name, rows = profile(self.limits) if self.limits else ("", ())
        found = [m for m in rows if QUANTITIES[m.quantity].study == NAME]
        if self.target_hours is not None:
            found.append(
                Limit(
                    quantity="fatigue_life", sense=">=", maximum=self.target_hours * hour,
                    required=True, source=ASKED,
                )
            )  # fmt: skip
        return name, tuple(found)

    def predictions(self) -> dict[str, float]:
        """Return order-2 stress per shaft torque by gauge, Pa per N m: given, or predicted."""
        found: dict[str, float] = {}
        for name, unit in self.unit_stresses().items():
            assert self.application is not None  # __post_init__ refuses
            found[name] = predicted_stress(
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
            found[name] = np.array(numbers(axes, of="--unit-stress")) * MPa / 1e3
            if found[name].shape != (3,):
                msg = f"a unit stress is GAUGE=X,Y,Z in MPa per kN, got {text!r}"
                raise DesignError(msg)
        return found

    @property
    def rules(self) -> tuple[Rule, ...]:
        """What is masked and accepted of what looks wrong: what says more counts last.

        A time says more than a channel, and a channel more than none.

        Raises
        ------
        DesignError
            If the same is masked and accepted.
        """
        masked = [(text, _rule(text, mask=True)) for text in self.mask]
        accepted = [(text, _rule(text, mask=False)) for text in self.accept]
        for text, one in masked:
            for other_text, other in accepted:
                if one.contradicts(other):
                    msg = (
                        f"--mask {text} and --accept {other_text} say two things of the same: "
                        "say one of them"
                    )
                    raise DesignError(msg)
        said = [rule for _, rule in (*masked, *accepted)]
        return tuple(sorted(said, key=lambda r: (not r.always, r.channel != "")))

    def within(self, first: float, last: float) -> "Campaign":
        """Return what is asked of a stretch of the recording: its rules, by the stretch's clock.

        A rule of other times is none of it.
        """

        def moved(given: tuple[str, ...], *, mask: bool) -> tuple[str, ...]:
            told: list[str] = []
            for text in given:
                rule = _rule(text, mask=mask)
                if rule.always:
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

    def beyond(self, seconds: float) -> tuple[str, ...]:
        """Return what is said of times behind the end of a recording: it does nothing."""
        said = [("mask", text) for text in self.mask] + [("accept", text) for text in self.accept]
        return tuple(
            f"--{option} {text} is of a time behind its end, {seconds:g} s: it does nothing"
            for option, text in said
            if seconds < _rule(text, mask=option == "mask").first
        )

    @property
    def strained(self) -> Strained | None:
        """How places are judged by their strain; None where it was not asked."""
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
        curve = local.common(
            modulus=modulus, strength=strength * MPa, exponent=b, ductility=ductility,
            ductility_exponent=c,
        )  # fmt: skip
        if len(given) == 6:
            curve = replace(curve, hardening=given[4] * MPa, hardening_exponent=given[5])
        return Strained(material=curve, law=self.strain_mean, notch=self.notch)

    @property
    def cracked(self) -> Cracked | None:
        """How a crack is judged; None where it was not asked."""
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
        return Cracked(
            start=start / 1e3, end=end / 1e3, C=C, m=m, threshold=self.crack_threshold,
            shape=self.crack_shape,
        )  # fmt: skip

    @property
    def scales(self) -> dict[str, tuple[float, float, str]]:
        """Factor, offset and unit of the channels that are scaled."""
        found: dict[str, tuple[float, float, str]] = {}
        for text in self.scale:
            channel, _, rest = text.rpartition("=")
            value, _, unit = rest.rpartition(":")
            try:
                given = [float(v) for v in value.split(",")]
            except ValueError:
                given = []
            known = (*STRESS, *STRAIN, *SPEED, *DRIVEN, *TORQUE)
            whole = channel and len(given) in (1, 2) and all(map(math.isfinite, given))
            if not whole or given[0] == 0 or unit not in known:
                msg = (
                    f"a scale is CHANNEL=FACTOR[,OFFSET]:UNIT with a unit of {', '.join(known)}, "
                    f"got {text!r}"
                )
                raise DesignError(msg)
            found[channel] = (given[0], given[1] if len(given) > 1 else 0.0, unit)
        return found

    def scaled(self, recording: Recording) -> Recording:
        """Return the recording with its scaled channels in the units they are scaled to."""
        scales = {recording.place(name): of for name, of in self.scales.items()}
        if not scales:
            return recording
        channels = tuple(
            replace(c, unit=scales[k][2], settled=True) if k in scales else c
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

    def strains(self, recording: Recording) -> bool:
        """Return whether a gauge is of strain, which Young's modulus makes a stress."""
        units = (given or _unit_of(recording.channel(c)) for c, given in map(_named, self.gauges))
        return bool(self.rosettes) or any(unit in STRAIN for unit in units)

    def _held(self, option: str, given: Iterable[str], known: Iterable[str], kind: str) -> None:
        """Refuse what is said of a gauge or channel that there is not."""
        names = list(known)
        for name in given:
            if name not in names:
                msg = f"--{option}: no {kind} {name!r}; {nearest(name, names)}"
                raise DesignError(msg)

    def roles(self, recording: Recording) -> dict[str, str]:
        """Return what each channel of a recording is that something is asked of."""
        found = {c: "gauge" for g in self.plan(recording).gauges for c in g.channels}
        for role in ("speed", "tacho", "torque", "engine"):
            if (of := getattr(self, role)) is not None:
                found.setdefault(recording.channel(_named(of)[0]).name, role)
        return found

    def plan(self, recording: Recording) -> Plan:
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
        channels |= {_named(text)[0] for text in turning if text is not None}
        ruled = [r.channel for r in self.rules if r.channel]
        self._held("mask and --accept", ruled, channels, "gauge's channel")
        if self.low_pass_Hz is not None:
            conditioning.hold_cutoff(self.low_pass_Hz, rate=recording.rate)
        return Plan(
            gauges=gauges, curve=self._curve(), correction=self._correction(),
            rule=_RESIDUES[self.residue], baseline=_ZEROS[self.zero], low_pass=self.low_pass_Hz,
            allowed=self.allowed, gauge_error=self.gauge_error, rules=self.rules,
            between={"auto": None, "yes": True, "no": False}[self.between_samples],
            ultimate=math.inf if self.ultimate_MPa is None else self.ultimate_MPa * MPa,
        )  # fmt: skip

    def hold(self, recording: Recording, *, samples: int) -> None:
        """Refuse a recording of so many samples that holds nothing to tell a life of."""
        if samples < FEWEST:
            msg = f"{recording.name} holds {samples} samples; a life takes {FEWEST} or more"
            raise DesignError(msg)
        seconds, cutoff = samples / recording.rate, self.low_pass_Hz
        if cutoff is not None and cutoff * seconds < 1:
            msg = (
                f"low_pass_Hz keeps not one period of {recording.name}, {seconds:.4g} s long: it "
                f"must be {1 / seconds:.2g} Hz or more, got {cutoff:g}"
            )
            raise DesignError(msg)

    def held_apart(self, recording: Recording) -> float:
        """Return up to how many turns a second the tacho's pulses are held apart."""
        return recording.rate / 2.5 / self.pulses

    def shaft(self, recording: Recording) -> Angle | None:
        """Return how far the shaft has turned: measured, counted, or found in a gauge.

        Raises
        ------
        DesignError
            If the tacho's pulses come faster than the recording can hold them apart.
        """
        if self.tacho is not None:
            fastest = self.held_apart(recording)
            if fastest < FASTEST:
                msg = (
                    f"{self.tacho}: {self.pulses} pulses a turn at {recording.rate:g} Hz are held "
                    f"apart up to {fastest * 60:.0f} rpm, and no faster turn would show: a shaft's "
                    f"tacho needs {FASTEST * 2.5 * self.pulses:g} Hz or a divided pulse"
                )
                raise DesignError(msg)
            counted = rotation_from_pulses(
                recording.pieces([self.tacho]), rate=recording.rate, per_turn=self.pulses
            )
            if (most := _fastest(counted, pulses=self.pulses)) > fastest:
                msg = (
                    f"{self.tacho} is read up to {most * 60:.0f} rpm, and {self.pulses} pulses a "
                    f"turn at {recording.rate:g} Hz are held apart up to {fastest * 60:.0f} rpm: "
                    "what turns faster looks slower; it needs more samples or a divided pulse"
                )
                raise DesignError(msg)
            return Angle(counted, lag=0.02)
        if self.speed is not None:
            engine = None if self.engine is None else self._read(recording, self.engine)
            speed, rate = self._read(recording, self.speed)
            return shaft_angle(speed, rate=rate, engine=engine[0] if engine else None)
        if self.estimate_speed is not None:
            signal = recording.pieces([self.estimate_speed])
            return Angle(
                estimated_rotation(signal, rate=recording.rate), trusted=False, measured=False
            )
        return None

    def _read(self, recording: Recording, text: str) -> tuple[FloatArray, float]:
        """Return a channel of speed, turns/s, as it is taken: nan where it has no value."""
        speed, rate, runs = _speeds(recording, text, wheel=self._wheel())
        if not self._taken(text, runs, rate).size:
            return speed, rate
        for first, last in self._taken(text, runs, rate):
            speed[first:last] = np.nan
        return speed, rate

    def _taken(self, text: str, runs: IntArray, rate: float) -> IntArray:
        """Return those runs of no value that are taken for holes: what no rule accepts."""
        open_ = np.ones(len(runs), bool)
        for rule in self.rules:
            if rule.concerns(_named(text)[0], SENTINEL) and rule.kind:
                inside = (runs[:, 0] / rate >= rule.first) & (runs[:, 0] / rate <= rule.last)
                open_[inside] = rule.mask
        return runs[open_]

    def misread(self, recording: Recording) -> "tuple[Misread, ...]":
        """Return the channels in which a bus wrote that it had no value, and where."""
        found: list[Misread] = []
        for text in (self.speed, self.engine):
            if text is None or (self.tacho is not None and text == self.speed):
                continue
            speed, rate, runs = _speeds(recording, text, wheel=self._wheel())
            if len(runs):
                taken = self._taken(text, runs, rate)
                top = float(np.nanmax(speed[runs[0, 0] : runs[0, 1]]))
                found.append(
                    Misread(
                        channel=_named(text)[0], runs=runs / rate, speed=top,
                        accepted=len(runs) - len(taken),
                    )
                )  # fmt: skip
        if (named := self.torque_of(recording)) is not None:
            values, rate = _every(recording, named[0])
            runs = no_torque(values, rate=rate)
            if len(runs):
                found.append(
                    Misread(
                        channel=named[0], runs=runs / rate,
                        torque=float(np.nanmax(values)) * named[1],
                        accepted=len(runs) - len(self._taken(self.torque or "", runs, rate)),
                    )
                )  # fmt: skip
        return tuple(found)

    def without_torque(self, recording: Recording) -> Recording:
        """Return a recording whose torque is missing where a bus wrote that it had none."""
        if (named := self.torque_of(recording)) is None:
            return recording
        values, rate = _every(recording, named[0])
        taken = self._taken(self.torque or "", no_torque(values, rate=rate), rate)
        return holed(recording, named[0], taken / rate) if len(taken) else recording

    def other_way(self, of: "Misread") -> "Campaign":
        """Return the campaign with what a bus wrote taken the other way: as speeds, or as none."""
        rule = (f"{of.channel}={SENTINEL}",)
        if of.accepted:
            return replace(self, accept=tuple(r for r in self.accept if not _sentinel(r)))
        masked = tuple(r for r in self.mask if not r.startswith(rule))
        return replace(self, mask=masked, accept=(*self.accept, *rule))

    def _wheel(self) -> float | None:
        """Shaft turns a metre of the vehicle's way, where the axle and its tyres are given."""
        if self.axle_ratio is None or self.tyre_radius_m is None:
            return None
        return self.axle_ratio / (TURN * self.tyre_radius_m)

    def engine_of(self, recording: Recording) -> Rotation | None:
        """Return the engine's rotation, where it was measured."""
        if self.engine is None:
            return None
        speed, rate = self._read(recording, self.engine)
        return shaft_angle(speed, rate=rate).rotation

    def torque_of(self, recording: Recording) -> tuple[str, float] | None:
        """Return the channel of the shaft torque, and N m in its unit."""
        if self.torque is None:
            return None
        channel, given = _named(self.torque)
        return channel, _unit(recording, channel, given, TORQUE)

    def read_torque(self, recording: Recording) -> tuple[FloatArray, float]:
        """Return the shaft torque (m,) N m, nan where it has none, and how often it was looked at.

        Raises
        ------
        DesignError
            If no channel of it is named.
        """
        named = self.torque_of(recording)
        if named is None:
            msg = "no channel of the shaft's torque is named: --torque"
            raise DesignError(msg)
        values, rate = _every(self.without_torque(recording), named[0])
        return values * named[1], rate

    def _singles(self, recording: Recording) -> list[Gauge]:
        modulus = self.modulus_GPa * GPa
        units = STRESS | {u: modulus * v for u, v in STRAIN.items()}
        named = [_named(text) for text in self.gauges]
        found: list[Gauge] = []
        for channel, given in named:
            factor = _unit(recording, channel, given, units)
            gauge = strain.direct(channel, channel, factor=factor)
            of = recording.channel(channel)
            taken = given or _unit_of(of)
            gauge = replace(gauge, doubts=_doubted(of, taken))
            if taken in ASSUMED and not (of.settled or _unit_of(of)):
                # What whoever names a unit by hand confuses: numbers of either look alike.
                other = ASSUMED[taken]
                gauge = replace(gauge, assumed=taken, otherwise=(other, units[other] / factor))
            found.append(gauge)
        return found

    def _rosettes(self, recording: Recording) -> list[Gauge]:
        found: list[Gauge] = []
        for text in self.rosettes:
            name, _, rest = text.partition("=")
            grids, given = _named(rest)
            channels = tuple(grids.split(","))
            if len(channels) != 3:
                msg = f"a rosette is NAME=A,B,C with three channels, got {text!r}"
                raise DesignError(msg)
            for twice in (c for k, c in enumerate(channels) if c in channels[:k]):
                msg = (
                    f"rosette {name}: {twice} stands in it twice; three channels are one grid each"
                )
                raise DesignError(msg)
            units = np.array([_unit(recording, c, given, STRAIN) for c in channels])[:, None]
            angles, modulus = _KINDS[self.rosette_kind], self.modulus_GPa * GPa
            read, _ = _looked_at(recording, channels)
            read = read[:, np.isfinite(read).all(0)]
            if self.zero != "none" and read.size:
                read = read - np.median(read, axis=1, keepdims=True)
            along = strain.swinging(strain.rosette(read * units, angles=angles, modulus=modulus))
            found += [
                strain.rosette_gauge(
                    name + end, channels, unit=units, angles=angles, modulus=modulus, measure=of,
                    along=along,
                )
                for end, of in self._measures().items()
            ]  # fmt: skip
        return found

    def _measures(self) -> dict[str, strain.Measure | None]:
        """Return what is counted of a rosette, by the ending of the gauge's name."""
        if self.rosette_measure == "planes":
            angles = sorted({*range(0, 180, 10), 45, 135})  # a shaft's, by a leg on its axis
            return {f"@{a}": partial(strain.PlaneStress.normal, angle=a * deg) for a in angles}
        return {"": None if self.rosette_measure == "mises" else strain.largest}

    def _curve(self) -> SNCurve:
        try:
            amplitude, cycles, slope = (float(v) for v in self.sn.split(","))
        except ValueError:
            msg = f"an S-N curve is AMPLITUDE_MPa,CYCLES,SLOPE at its knee, got {self.sn!r}"
            raise DesignError(msg) from None
        if not (math.isfinite(amplitude) and math.isfinite(cycles) and math.isfinite(slope)):
            msg = f"an S-N curve is of finite numbers, got {self.sn!r}"
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
    def sensitivity(self) -> float | None:
        """M of fkm or the exponent of walker, as they are in force; None of others."""
        if self.mean_sensitivity is not None or self.mean_stress not in ("fkm", "walker"):
            return self.mean_sensitivity
        if self.mean_stress == "walker":
            return WALKER
        if self.ultimate_MPa is None:
            msg = "fkm needs the tensile strength (--ultimate-MPa) or --mean-sensitivity"
            raise DesignError(msg)
        return correction.mean_sensitivity(self.ultimate_MPa * MPa)

    def _correction(self) -> Correction:
        name = self.mean_stress
        ultimate = None if self.ultimate_MPa is None else self.ultimate_MPa * MPa
        if name in ("goodman", "gerber"):
            if ultimate is None:
                msg = f"{name} needs the tensile strength: --ultimate-MPa"
                raise DesignError(msg)
            return partial(getattr(correction, name), ultimate=ultimate)
        if name == "fkm":
            return partial(correction.fkm, sensitivity=self.sensitivity or 0.0)
        if name == "walker":
            return partial(correction.walker, exponent=self.sensitivity or 0.0)
        return correction.swt if name == "swt" else correction.uncorrected


@dataclass(frozen=True, kw_only=True)
class Misread:
    """A channel of speed or torque in which a bus wrote that it had no value.

    Attributes
    ----------
    channel
        Its name.
    runs : (k, 2) s
        From when to when, flanks that a faster clock laid between readings among them.
    speed : turns/s
        What it would be as a speed; nan of a torque.
    accepted
        How many of them are taken for values all the same, as a rule has it.
    torque : N m
        What it would be as a torque; nan of a speed.
    """

    channel: str
    runs: FloatArray
    speed: float = math.nan
    accepted: int = 0
    torque: float = math.nan


_TIMES = re.compile(r"([0-9.eE+-]*?)\.\.([0-9.eE+-]*)")


def _rule(text: str, *, mask: bool) -> Rule:
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
    if kind and kind not in KINDS:
        msg = f"{text!r}: no kind of fault {kind!r}; there are: {', '.join(KINDS)}"
        raise DesignError(msg)
    if mask and kind and kind not in REMOVABLE:
        instead = "--zero drift takes it off" if kind == DRIFT else "what it hides nobody knows"
        if kind in IMPOSSIBLE:
            instead = "it is of the gauge as a whole"
        msg = f"a {kind} cannot be masked: {instead}; can be: {', '.join(REMOVABLE)}"
        raise DesignError(msg)
    if not (kind or times):
        msg = f"a rule is [CHANNEL=]KIND[@FROM..TO] or [CHANNEL=]FROM..TO, got {text!r}"
        raise DesignError(msg)
    return Rule(mask=mask, kind=kind, channel=channel, first=first, last=last)


_KEYS = {"gauge": "gauges", "rosette": "rosettes", "sn": "strength", "rate": "rate_Hz",
         "unit-stress": "unit_stress_MPa_kN"}  # fmt: skip
"""Options that a campaign's file calls otherwise than in their own words."""


def keyed(said: str) -> str:
    """Return what is said of options in the words of a campaign's file, whatever the language.

    >>> keyed("goodman needs the tensile strength: --ultimate-MPa")
    'goodman needs the tensile strength: ultimate_MPa'
    """
    said = re.sub(
        r"--scale (.+?)=(\S+?)(?:\[?,(\S+?)\]?)?:(\S+)",
        lambda m: (
            f"channels: {{{m[1]}: {{factor: {m[2]}, {'offset: 0, ' * bool(m[3])}unit: {m[4]}}}}}"
        ),
        said,
    )
    options = {f.name for f in fields(Campaign)}

    def key(at: re.Match[str]) -> str:
        name = at[1].replace("-", "_")
        return _KEYS.get(at[1], name if name in options else at[0])

    return re.sub(r"--([A-Za-z][A-Za-z-]*[A-Za-z])", key, said)


def _option(name: str) -> str:
    """Return an option as it is written on the command line."""
    return "--" + {"rosettes": "rosette"}.get(name, name).replace("_", "-")


def numbers(text: str, *, of: str = "") -> tuple[float, ...]:
    """Return numbers that were written with commas between, `of` an option that is then named."""
    try:
        return tuple(float(v) for v in text.split(","))
    except ValueError:
        msg = f"expected numbers with commas between, got {text!r}"
        raise DesignError(f"{of}: {msg}" if of else msg) from None


def _several(text: str, *, of: str) -> tuple[float, ...]:
    """Return numbers that were written with commas between; none where they are not finite."""
    given = numbers(text, of=of)
    return given if all(map(math.isfinite, given)) else ()


def _named(text: str) -> tuple[str, str | None]:
    """Split CHANNEL:UNIT; channel names may hold colons, units do not."""
    name, _, unit = text.rpartition(":")
    known = (*STRESS, *STRAIN, *SPEED, *DRIVEN, *TORQUE)
    return (name, unit) if name and unit in known else (text, None)


def _unit(
    recording: Recording, channel: str, given: str | None, table: Mapping[str, float]
) -> float:
    """Return the SI value of a channel's unit, given by hand or by the file."""
    of = recording.channel(channel)
    name = given or _unit_of(of)
    _agreed(of, name)
    if name not in table:
        none = repr(name) if name else "no unit"
        msg = f"{channel}: {none}; write {channel}:UNIT with one of {', '.join(table)}"
        if name in VOLTS:
            msg += f", or scale it: --scale {channel}=FACTOR[,OFFSET]:UNIT"
        raise DesignError(msg)
    return table[name]


def _fastest(counted: Rotation, *, pulses: int) -> float:
    """Return how fast a tacho turns at most, turns/s, over a turn or some pulses of it."""
    over = min(max(pulses, 9), counted.time.size - 1)
    return float((over / pulses / (counted.time[over:] - counted.time[:-over])).max())


def _unit_of(channel: Channel) -> str:
    """Return the unit of a channel by its file, or else by its name; "" if neither says one."""
    return channel.unit or _named_unit(channel)


def _named_unit(channel: Channel) -> str:
    """Return the unit that a channel's name ends in; "" if none."""
    named = _WRITTEN.search(channel.name)
    return named[1] if named else ""


def _agreed(channel: Channel, taken: str) -> None:
    """Refuse a channel that is taken for another unit than its file or its name says.

    A factor of a million is easily read over, and nothing later shows one of five.
    """
    if taken not in UNITS:
        return
    if channel.settled:
        if UNITS.get(channel.unit) != UNITS[taken]:
            msg = (
                f"{channel.name}: --scale turns it into {channel.unit}, and it is taken for "
                f"{taken}; write {channel.name} without a unit, or --scale into {taken}"
            )
            raise DesignError(msg)
        return
    for who, unit in (("the file", channel.unit), ("its name", _named_unit(channel))):
        other = unit in UNITS or (unit in VOLTS and unit != "")
        if other and UNITS.get(unit) != UNITS[taken]:
            msg = (
                f"{channel.name}: {who} says {unit}, and it is taken for {taken}; if it is in "
                f"{taken} in truth, say so: --scale {channel.name}=1:{taken}"
            )
            raise DesignError(msg)


def _doubted(channel: Channel, taken: str) -> tuple[Said, ...]:
    """Return a doubt where a gauge's name speaks of a strain and it is taken for a stress."""
    if channel.settled:
        return ()
    if taken in STRESS and _STRAINS.search(channel.name):
        return (said(NAMED_STRAIN, unit=taken),)
    if taken in STRAIN and _STRESSES.search(channel.name):
        return (said(NAMED_STRESS, unit=taken),)
    return ()


READ = 200.0
"""Readings a second of a channel of speed that are looked at."""


def _sentinel(rule: str) -> bool:
    """Whether a rule, as it was written, is of sentinels."""
    return _rule(rule, mask=False).kind == SENTINEL


def _speeds(
    recording: Recording, text: str, *, wheel: float | None = None
) -> tuple[FloatArray, float, IntArray]:
    """Return a channel of speed in turns/s, as written, and at which rate it was looked at.

    `wheel` is how many turns go to a metre, for a speed of the vehicle. With it the runs (k, 2)
    of samples in which a bus wrote that it had no value.
    """
    channel, given = _named(text)
    taken = given or _unit_of(recording.channel(channel))
    _agreed(recording.channel(channel), taken)
    if taken in DRIVEN:
        if wheel is None:
            msg = (
                f"{channel}: {taken} is the vehicle's speed; the shaft turns with it by "
                "--axle-ratio and --tyre-radius-m"
            )
            raise DesignError(msg)
        unit = DRIVEN[taken] * wheel
    else:
        unit = _unit(recording, channel, given, SPEED)
    values, rate = _every(recording, channel)
    if taken in DRIVEN:
        runs = no_value(values * DRIVEN[taken] * 3.6, rate=rate, of=VEHICLES)
        values *= unit
    else:
        values *= unit
        runs = no_value(values * 60, rate=rate, of=SHAFTS)
    _turning(channel, values, taken or "")
    return values, rate, runs


def _turning(channel: str, speed: FloatArray, unit: str) -> None:
    """Refuse a speed (n,) turns/s, half of which no shaft of a vehicle makes."""
    moving = speed[speed > 0]
    typical = float(np.median(moving, overwrite_input=True)) if moving.size else 0.0
    if typical > FASTEST_SHAFT:
        msg = (
            f"{channel}: in {unit} it turns at {typical * 60:.4g} rpm, faster than any shaft or "
            f"engine of a vehicle ({FASTEST_SHAFT * 60:g} rpm); its unit is another"
        )
        raise DesignError(msg)


def _every(recording: Recording, channel: str) -> tuple[FloatArray, float]:
    """Return a slow channel as it is looked at, and how often: of a day's drive less often."""
    values, rate = _looked_at(recording, [channel])
    return values[0], rate


def _looked_at(recording: Recording, channels: Sequence[str]) -> tuple[FloatArray, float]:
    """Return channels (k, n) as they are looked at, and how often."""
    every, start, count = max(int(recording.rate / READ), 1), 0, 0
    read: list[FloatArray] = []
    for piece in recording.pieces(channels):
        read.append(np.array(piece[:, -start % every :: every], float))
        start, count = start + piece.shape[1], count + read[-1].shape[1]
        while count > MOST:
            before = np.cumsum([0, *(part.shape[1] for part in read)])
            read = [part[:, at % 2 :: 2].copy() for part, at in zip(read, before, strict=False)]
            every, count = 2 * every, sum(part.shape[1] for part in read)
    whole = np.concatenate(read, axis=1) if read else np.empty((len(channels), 0))
    return whole, recording.rate / every


def _worded(value: Any, *, several: bool) -> Any:
    """Return a script's value as the command line has it: one of several, or with commas."""
    if isinstance(value, str) or not isinstance(value, Iterable):
        return (value,) if several else value
    return tuple(value) if several else ",".join(map(str, value))
