"""A campaign's file: recordings of any rate and format, what is in them, and what is asked.

It says once, for all its recordings, what the options of `cardan life` say for one: which
channels are gauges, how they are calibrated, what turns, what is masked and accepted, how
strong the part is. How often each recording or segment of one is driven makes the mix.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

from cardan.base.errors import BadFile
from cardan.border.document import parse, text_of
from cardan.border.table import (
    PROSE,
    Beside,
    Enough,
    Here,
    ListOf,
    MapOf,
    Number,
    Reading,
    Spoilt,
    Table,
    TableRule,
    Text,
    Whole,
    key,
)  # fmt: skip
from cardan.fatigue.unit import UNITS
from cardan.files.application import read as application
from cardan.files.manuscript import Manuscript
from cardan.model.application import Application

_TIME = Number(least=0, most=1e9)
_WORDS = ListOf(Text())


@dataclass(frozen=True, kw_only=True)
class Segment:
    """A stretch of a recording, s or m of the way, and how often it is driven in the mix."""

    name: str
    first: float
    last: float
    times: float
    by_way: bool = False


@dataclass(frozen=True, kw_only=True)
class Drive:
    """One recording of a campaign.

    Attributes
    ----------
    file
        Where it is.
    name
        What it is called; that of the file unless said.
    times
        How often it is driven in the mix.
    beside
        Other files of the same drive, and how much later each began, s.
    segments
        Stretches that count in place of the whole.
    options
        What is said of it alone: rate, time, group, mask, accept, and its calibrations (scale).
    """

    file: Path
    name: str
    times: float
    beside: tuple[tuple[Path, float], ...]
    segments: tuple[Segment, ...]
    options: Mapping[str, Any]


@dataclass(frozen=True, kw_only=True)
class Campaigned:
    """A campaign's file as read: title, drives, options for all of them, share of customers."""

    title: str
    drives: tuple[Drive, ...]
    options: Mapping[str, Any]
    customer: float = 0.0
    name: str = ""
    """Of its file."""
    named: tuple[Path, ...] = ()
    """Files that are read with it: recordings, applications, limits, and what those name."""


class SegmentTable(Table):
    """A stretch of a recording by time, or by place on the way."""

    name: str = key("what it is called: a route, a gear, a place")
    from_s: Annotated[float, _TIME] | None = key("where it begins, s", default=None)
    to_s: Annotated[float, _TIME] | None = key("where it ends, s", default=None)
    from_km: Annotated[float, _TIME] | None = key("where it begins on the way, km", default=None)
    to_km: Annotated[float, _TIME] | None = key("where it ends on the way, km", default=None)
    times: Annotated[float, Number(above=0, most=1e9)] = key(
        "how often it is driven in the mix", default=1.0
    )

    def build(self) -> Segment:
        """Return the stretch."""
        times, ways = (self.from_s, self.to_s), (self.from_km, self.to_km)
        if any(v is not None for v in times) and any(v is not None for v in ways):
            self.at("from_km" if self.from_km is not None else "to_km").refuse(
                "stands beside a time: a segment is by time or by place"
            )
        by_way = self.to_km is not None
        first, last = ways if by_way else times
        if last is None:
            self.at("name").refuse("belongs to a segment without an end", "give to_s or to_km")
        first, last = first or 0.0, last or 0.0
        if first >= last:
            unit = "km" if by_way else "s"
            self.at(f"to_{unit}").refuse(f"must be later than from_{unit}", got=f"{last:g}")
        scale = 1e3 if by_way else 1.0
        return Segment(
            name=self.name, first=scale * first, last=scale * last, times=self.times, by_way=by_way
        )


class BesideTable(Table):
    """Another file of the same drive, of any rate."""

    file: str = key("a recording, beside this file")
    late_s: Annotated[float, Number(least=-1e6, most=1e6)] = key(
        "how much later than the first it began", default=0.0
    )

    def build(self) -> tuple[Path, float]:
        """Return where it is, and how late."""
        return self.at("file").beside(self.file), self.late_s


class ChannelTable(Table):
    """What a channel means: its value times `factor` plus `offset` is in `unit`."""

    unit: str = key("unit it is turned into: MPa, um/m, rpm, kNm")
    factor: Annotated[float, Number(least=-1e12, most=1e12)] = key("times its value", default=1.0)
    offset: Annotated[float, Number(least=-1e12, most=1e12)] = key("on top", default=0.0)

    def build(self) -> str:
        """Return it as `--scale` says it, without the channel."""
        if self.unit not in UNITS:
            known = ", ".join(UNITS)
            self.at("unit").refuse(
                "is no unit of stress, strain, speed or torque", f"there are {known}", got=self.unit
            )
        if self.factor == 0:
            self.at("factor").refuse("must not be 0: nothing of the channel would be left")
        return f"{self.factor!r},{self.offset!r}:{self.unit}"


_Channels = Annotated[dict[str, str], MapOf(Text(), TableRule(ChannelTable))]


def _scales(channels: Mapping[str, str] | None) -> tuple[str, ...]:
    """Return calibrations as `--scale` says them."""
    return tuple(f"{name}={of}" for name, of in (channels or {}).items())


class DriveTable(Table):
    """A recording."""

    file: str = key("a recording, beside this file")
    name: str | None = key("what it is called; the file's name by default", default=None)
    times: Annotated[float, Number(above=0, most=1e9)] = key(
        "how often it is driven in the mix", default=1.0
    )
    beside: tuple[Annotated[tuple[Path, float], BesideTable], ...] = key(
        "other files of the same drive", default=()
    )
    segments: tuple[Annotated[Segment, SegmentTable], ...] = key(
        "stretches that count in place of the whole", default=()
    )
    rate_Hz: Annotated[float, Number(above=0, most=1e9)] | None = key(  # noqa: N815
        "samples a second, above what the file says", default=None
    )
    time: str | None = key("name of the time column", default=None)
    group: str = key("HDF5, TDMS or MDF4 group", default="")
    channels: _Channels | None = key(
        "calibrations of this recording, in place of those of the campaign", default=None
    )
    mask: Annotated[tuple[str, ...], _WORDS] = key(
        "what of it is a hole: [CHANNEL=]KIND[@FROM..TO] or FROM..TO", default=()
    )
    accept: Annotated[tuple[str, ...], _WORDS] = key("what of it the part felt", default=())

    def build(self) -> Drive:
        """Return the recording."""
        self.differ("segments", (segment.name for segment in self.segments))
        return Drive(
            file=self.at("file").beside(self.file), name=self.name or Path(self.file).name,
            times=self.times, beside=self.beside, segments=self.segments,
            options={
                "rate": self.rate_Hz, "time": self.time, "group": self.group,
                "mask": self.mask, "accept": self.accept, "scale": _scales(self.channels),
            },
        )  # fmt: skip


class StrengthTable(Table):
    """The S-N curve at the gauges, half failed."""

    amplitude_MPa: Annotated[float, Number(above=0, most=10_000)] = key("at the knee")  # noqa: N815
    cycles: Annotated[float, Number(above=0, most=1e12)] = key("at the knee")
    slope: Annotated[float, Number(above=0, most=100)] = key("above the knee")
    scatter: Annotated[float, Number(least=0, most=1)] = key(
        "standard deviation of log10 strength", default=0.0
    )
    miner: Literal["original", "elementary", "modified"] = key(
        "what is below the knee", default="modified"
    )

    def build(self) -> dict[str, Any]:
        """Return it as the options say it."""
        curve = f"{self.amplitude_MPa!r},{self.cycles!r},{self.slope!r}"
        return {"sn": curve, "scatter": self.scatter, "miner": self.miner}


_STRESS = Number(least=-1e6, most=1e6)
_Units = Annotated[dict[str, tuple[float, ...]], MapOf(Text(), ListOf(_STRESS, least=3, most=3))]
_Positive = Annotated[float, Number(above=0, most=1e12)]
_Share = Annotated[float, Number(least=0, most=1)]


class CampaignTable(Table):
    """A campaign of recordings: what was measured, and what is asked of it."""

    campaign: Annotated[str, Text(PROSE)] = key("its title")
    recordings: tuple[Annotated[Drive, DriveTable], ...] = key("what was recorded")
    strength: Annotated[dict[str, Any], StrengthTable] = key("the S-N curve at the gauges")
    channels: _Channels | None = key(
        "calibrations, by channel, of every recording that says no other", default=None
    )
    gauges: Annotated[tuple[str, ...], _WORDS] = key("CHANNEL[:UNIT] of each", default=())
    rosettes: Annotated[tuple[str, ...], _WORDS] = key("NAME=A,B,C[:UNIT] of each", default=())
    rosette_kind: Literal["rectangular", "delta"] = key("its grids", default="rectangular")
    rosette_measure: Literal["mises", "principal", "planes"] = key(
        "the stress of a rosette that is counted", default="mises"
    )
    modulus_GPa: _Positive = key("Young's modulus", default=206.0)  # noqa: N815
    gauge_error: _Share = key("relative standard deviation of the stress scale", default=0.0)
    mean_stress: Literal["none", "goodman", "gerber", "swt", "walker", "fkm"] = key(
        "correction for mean stress", default="none"
    )
    ultimate_MPa: _Positive | None = key("tensile strength", default=None)  # noqa: N815
    mean_sensitivity: _Share | None = key("M of fkm, exponent of walker", default=None)
    residue: Literal["half", "repeat", "discard"] = key(
        "what the open residue counts for", default="half"
    )
    allowed: _Positive = key("damage at failure", default=1.0)
    zero: Literal["none", "start", "median", "drift"] = key(
        "what is taken off each channel as zero", default="none"
    )
    low_pass_Hz: _Positive | None = key("count nothing faster", default=None)  # noqa: N815
    between_samples: Literal["auto", "yes", "no"] = key(
        "whether crests are looked for between samples", default="auto"
    )
    speed: str | None = key("CHANNEL[:UNIT] of the shaft's speed", default=None)
    tacho: str | None = key("CHANNEL of the shaft's tacho", default=None)
    pulses: Annotated[int, Whole(10_000)] = key("of it, a turn", default=1)
    engine: str | None = key("CHANNEL[:UNIT] of the engine's speed", default=None)
    engine_orders: Annotated[tuple[float, ...], ListOf(Number(above=0, most=100))] = key(
        "orders it excites: half its cylinders, and twice that; 3 and 6 assumed", default=()
    )
    torque: str | None = key("CHANNEL[:UNIT] of the shaft's torque", default=None)
    axle_ratio: Annotated[float, Number(above=0, most=100)] | None = key(
        "shaft turns a wheel turn", default=None
    )
    tyre_radius_m: Annotated[float, Number(above=0, most=5)] | None = key(
        "static radius of the tyre", default=None
    )
    application: str | None = key(
        "an application file beside this one, whose line is under way", default=None
    )
    state: str = key("of it, whose geometry counts", default="gvw")
    bearing: Annotated[int, Whole(100)] = key("its centre bearing that the gauges feel", default=1)
    unit_stress_MPa_kN: _Units | None = key(  # noqa: N815
        "[x, y, z] at each gauge for 1 kN of the bearing along each axis", default=None
    )
    identify: bool = key("whether the application's numbers are looked for", default=False)
    changed: str | None = key(
        "another application file beside this one, driven as the recordings were", default=None
    )
    strain_life: Annotated[tuple[float, ...], ListOf(Number(least=-1e6, most=1e6))] = key(
        "σf' MPa, b, εf', c, perhaps K' MPa and n': life by the local strain", default=()
    )
    notch: Annotated[float, Number(least=1, most=20)] | None = key(
        "K_t from the gauges to the notch", default=None
    )
    strain_mean: Literal["swt", "morrow", "none"] = key(
        "what the mean stress of a loop does", default="swt"
    )
    crack: Annotated[tuple[float, ...], ListOf(Number(least=0, most=1e4))] = key(
        "from mm, to mm, C in m a cycle and MPa√m, m: growth of a crack", default=()
    )
    crack_threshold: Annotated[float, Number(least=0, most=100)] = key(
        "ΔK that grows it, MPa√m", default=0.0
    )
    crack_shape: Annotated[float, Number(above=0, most=10)] = key(
        "Y of K = Y S √(πa)", default=1.12
    )
    service_hours: _Positive | None = key("hours the odds of failure are of", default=None)
    miner_scatter: Annotated[float, Number(least=0, most=2)] = key(
        "coefficient of variation of the damage at failure", default=0.3
    )
    usage: bool = key("whether it is told when and where the damage came", default=False)
    mask: Annotated[tuple[str, ...], _WORDS] = key(
        "what is a hole in every recording: [CHANNEL=]KIND[@FROM..TO]", default=()
    )
    accept: Annotated[tuple[str, ...], _WORDS] = key("what the part felt", default=())
    limits: str | None = key("a profile, by name or as a file", default=None)
    target_hours: _Positive | None = key("what every gauge has to live of the mix", default=None)
    customer: Annotated[float, Number(least=0.5, below=1)] | None = key(
        "share of customers to tell the damage of, each recording taken for one", default=None
    )

    def build(self) -> Campaigned:
        """Return the campaign."""
        if not self.recordings:
            self.at("recordings").refuse("is empty", "give one file at least")
        self.differ("recordings", (drive.name for drive in self.recordings))
        plain = {"campaign", "recordings", "strength", "channels", "engine_orders", "customer",
                 "unit_stress_MPa_kN"}  # fmt: skip
        options: dict[str, Any] = {n: getattr(self, n) for n in self.entries() if n not in plain}
        options |= self.strength
        options["scale"] = _scales(self.channels)
        units = self.unit_stress_MPa_kN or {}
        options["unit_stress"] = tuple(
            f"{name}={','.join(map(repr, axes))}" for name, axes in units.items()
        )
        for name in ("application", "changed"):
            if options[name] is not None:
                options[name] = self._application(name)
        if self.limits and self.limits.endswith((".yaml", ".yml")):
            options["limits"] = str(self.at("limits").beside(self.limits))
        for name in ("strain_life", "crack"):
            options[name] = ",".join(f"{k!r}" for k in options[name]) or None
        options["engine_orders"] = ",".join(f"{k:g}" for k in self.engine_orders)
        return Campaigned(
            title=self.campaign,
            drives=self.recordings,
            options=options,
            customer=self.customer or 0.0,
        )

    def _application(self, name: str) -> Application:
        """Return the application of a file named by a key."""
        here = self.at(name)
        path = here.beside(getattr(self, name))
        found: list[Beside] = []
        try:
            return application(path, allow_outside=here.reading.allow_outside, beside=found)
        finally:
            here.reading.beside += (replace(b, at=here.at, name=None) for b in found)


def read(path: Path, *, allow_outside: bool = False) -> Campaigned:
    """Read a campaign's file.

    Raises
    ------
    BadFile
        With everything wrong in it, by line and column; also where it names a recording
        outside its own folder and that is not allowed.
    """
    return loads(text_of(path), name=str(path), folder=path.parent, allow_outside=allow_outside)


def loads(
    text: str,
    *,
    name: str = "campaign",
    folder: Path | None = None,
    allow_outside: bool = False,
    beside: list[Beside] | None = None,
) -> Campaigned:
    """Return the campaign a text describes; `read` is the same for a file.

    `name` is what errors call the text, and its recordings are files in `folder`.
    `beside` is given each file that is looked up, whatever comes of it.
    """
    root, problems = parse(text, name)
    reading = Reading(
        folder=folder, allow_outside=allow_outside, problems=problems,
        beside=[] if beside is None else beside,
    )  # fmt: skip
    try:
        found: Campaigned = TableRule(CampaignTable).read(Here(root, "", reading))
    except (Spoilt, Enough):
        raise BadFile(name, tuple(problems)) from None
    if problems:
        raise BadFile(name, tuple(problems))
    named = tuple(dict.fromkeys(one.path for one in reading.beside))
    return replace(found, name=Path(name).name, named=named)


def title(text: Manuscript) -> str | None:
    """Return what a text is called as a campaign; None where it is of something else."""
    return text.written("campaign")


def schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) that editors complete and check campaigns by."""
    defs: dict[str, Any] = {}
    root = CampaignTable.schema(defs)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "cardan campaign",
        **root,
        "$defs": dict(sorted(defs.items())),
    }
