"""A campaign's file: recordings of any rate and format, what is in them, and what is computed.

It says once, for all its recordings, what the options of `cardan life` say for one: which
channels are gauges, how they are calibrated, what turns, what is masked and accepted, how
strong the part is. How often each recording or segment of one is driven makes the mix.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, TypeVar

from cardan.application.yaml_edit import YamlEditor
from cardan.core.errors import InvalidFileError
from cardan.model.application import Application
from cardan.physics.signals.channel_units import KIND_AND_SI_FACTOR_BY_UNIT
from cardan.schema.field_types import (
    MAX_PROSE_CHARACTERS,
    BooleanField,
    EnumField,
    Field,
    IntegerField,
    ListField,
    MappingField,
    NumberField,
    TextField,
    UnionField,
)
from cardan.schema.node_reader import (
    InvalidValueError,
    NodeReader,
    ReferencedFile,
    TableReadContext,
    TooManyIssuesError,
)
from cardan.schema.tables import Table, TableField, table_key_field
from cardan.schema.yaml_tree import parse_yaml, read_text
from cardan.topics.recording.option_table import (
    OPTIONS,
    SN_CURVE_MAXIMA,
    FileKey,
    LifeOption,
    file_keys,
    in_order,
)

T = TypeVar("T", bound=Table)

_TIME = NumberField(least=0, most=1e9)
_SN_AMPLITUDE, _SN_CYCLES, _SN_SLOPE = (NumberField(above=0, most=m) for m in SN_CURVE_MAXIMA)
_ONE_OR_SEVERAL = UnionField(TextField(), ListField(TextField()))


def _field(of: LifeOption, key: FileKey) -> Field:
    """Return how a key of a campaign's file is read."""
    bounds = key.bounds or of.bounds
    if bounds is None:
        number = NumberField()
    else:
        number = NumberField(above=bounds.above, least=bounds.least, most=bounds.most)
    if key.form == "numbers":
        return ListField(number)
    if key.form == "axes":
        return MappingField(TextField(), ListField(number, least=3, most=3))
    if key.form == "one or several":
        return _ONE_OR_SEVERAL
    if of.is_repeatable:
        return ListField(TextField())
    if of.choices:
        return EnumField(*of.choices)
    if of.value_type is bool:
        return BooleanField()
    if of.number_type is int and bounds is not None:
        return IntegerField(int(bounds.most))
    return TextField() if of.number_type is None else number


def _with_option_keys(table: str, *, before: str = "") -> Callable[[type[T]], type[T]]:
    """Return what gives a table its keys of the options, before one of its own or behind all."""

    def extended(cls: type[T]) -> type[T]:
        own, after = dict(cls.__annotations__), dict[str, str]()
        made: dict[str, Any] = {}
        for name, of, key in file_keys(table):
            default = {"numbers": (), "axes": None}.get(key.form, of.default)
            made[name], after[name] = _field(of, key), key.after
            setattr(cls, name, table_key_field(key.description, default=default))
        place = [*own].index(before) if before else len(own)
        names = [*[*own][:place], *made, *[*own][place:]]
        names = in_order(names, name=str, after=lambda name: after.get(name, ""))
        cls.__annotations__ = {name: (own | made)[name] for name in names}
        return cls

    return extended


def _option_values(of: Table, table: str) -> dict[str, Any]:
    """Return the options that a table's keys give, as the command line has them."""
    found: dict[str, Any] = {}
    for name, option, key in file_keys(table):
        value = getattr(of, name)
        if key.form == "numbers":
            value = ",".join(map(key.number_format.format, value)) or option.default
        elif key.form == "axes":
            value = tuple(f"{gauge}={','.join(map(repr, v))}" for gauge, v in (value or {}).items())
        found[option.name] = value
    return found


@dataclass(frozen=True, kw_only=True)
class RecordingSegment:
    """A stretch of a recording, s or m of the way, and how often it is driven in the mix."""

    name: str
    first: float
    last: float
    times: float
    by_distance: bool = False


@dataclass(frozen=True, kw_only=True)
class RecordingSpec:
    """One recording of a campaign.

    Attributes
    ----------
    file
        Where it is.
    name
        What it is called; that of the file unless said.
    times
        How often it is driven in the mix.
    second_files
        Other files of the same drive, how much later each began, s, and its CAN databases.
    segments
        Stretches that count in place of the whole.
    options
        What is said of it alone: rate, time, group, CAN databases, mask, accept, and its
        calibrations (scale).
    """

    file: Path
    name: str
    times: float
    second_files: tuple[tuple[Path, float, tuple[str, ...]], ...]
    segments: tuple[RecordingSegment, ...]
    options: Mapping[str, Any]


@dataclass(frozen=True, kw_only=True)
class CampaignSpec:
    """A campaign's file as read: title, drives, options for all of them, share of customers."""

    title: str
    drives: tuple[RecordingSpec, ...]
    options: Mapping[str, Any]
    customer_share: float = 0.0
    name: str = ""
    """Of its file."""
    referenced_files: tuple[Path, ...] = ()
    """Files that are read with it: recordings, applications, limits, and what those name."""


def _databases(of: Table) -> tuple[str, ...]:
    """Return where the CAN databases are that a table names."""
    given: str | tuple[str, ...] = getattr(of, "dbc")  # noqa: B009  a key that the options give
    names = (given,) if isinstance(given, str) else given
    return tuple(str(of.reader_of("dbc").referenced_path(name)) for name in names)


class SegmentTable(Table):
    """A stretch of a recording by time, or by place on the way."""

    name: str = table_key_field("what it is called: a route, a gear, a place")
    from_s: Annotated[float, _TIME] | None = table_key_field("where it begins, s", default=None)
    to_s: Annotated[float, _TIME] | None = table_key_field("where it ends, s", default=None)
    from_km: Annotated[float, _TIME] | None = table_key_field(
        "where it begins on the way, km", default=None
    )
    to_km: Annotated[float, _TIME] | None = table_key_field(
        "where it ends on the way, km", default=None
    )
    times: Annotated[float, NumberField(above=0, most=1e9)] = table_key_field(
        "how often it is driven in the mix", default=1.0
    )

    def build(self) -> RecordingSegment:
        """Return the stretch."""
        times, ways = (self.from_s, self.to_s), (self.from_km, self.to_km)
        if any(v is not None for v in times) and any(v is not None for v in ways):
            self.reader_of("from_km" if self.from_km is not None else "to_km").reject(
                "belongs to a time: a segment is by time or by place"
            )
        by_way = self.to_km is not None
        first, last = ways if by_way else times
        if last is None:
            self.reader_of("name").reject(
                "belongs to a segment without an end", "give to_s or to_km"
            )
        first, last = first or 0.0, last or 0.0
        if first >= last:
            unit = "km" if by_way else "s"
            self.reader_of(f"to_{unit}").reject(f"must be later than from_{unit}", got=f"{last:g}")
        scale = 1e3 if by_way else 1.0
        return RecordingSegment(
            name=self.name,
            first=scale * first,
            last=scale * last,
            times=self.times,
            by_distance=by_way,
        )


class AdditionalRecordingFileTable(Table):
    """Another file of the same drive, of any rate."""

    file: str = table_key_field("a recording, next to this file")
    late_s: Annotated[float, NumberField(least=-1e6, most=1e6)] = table_key_field(
        "how much later than the first it began", default=0.0
    )

    dbc: Annotated[str | tuple[str, ...], _ONE_OR_SEVERAL] = table_key_field(
        "CAN database (DBC) of a log of frames, or a list of them, next to this file", default=()
    )

    def build(self) -> tuple[Path, float, tuple[str, ...]]:
        """Return where it is, how late, and where its CAN databases are."""
        return self.reader_of("file").referenced_path(self.file), self.late_s, _databases(self)


class ChannelTable(Table):
    """What a channel means: its value times `factor` plus `offset` is in `unit`."""

    unit: str = table_key_field("unit it is turned into: MPa, um/m, rpm, kNm")
    factor: Annotated[float, NumberField(least=-1e12, most=1e12)] = table_key_field(
        "times its value", default=1.0
    )
    offset: Annotated[float, NumberField(least=-1e12, most=1e12)] = table_key_field(
        "on top", default=0.0
    )

    def build(self) -> str:
        """Return it as `--scale` says it, without the channel."""
        if self.unit not in KIND_AND_SI_FACTOR_BY_UNIT:
            known = ", ".join(KIND_AND_SI_FACTOR_BY_UNIT)
            self.reader_of("unit").reject(
                "is no unit of stress, strain, speed or torque", f"there are {known}", got=self.unit
            )
        if self.factor == 0:
            self.reader_of("factor").reject("must not be 0: nothing of the channel would be left")
        return f"{self.factor!r},{self.offset!r}:{self.unit}"


_Channels = Annotated[dict[str, str], MappingField(TextField(), TableField(ChannelTable))]


def _scales(channels: Mapping[str, str] | None) -> tuple[str, ...]:
    """Return calibrations as `--scale` says them."""
    return tuple(f"{name}={of}" for name, of in (channels or {}).items())


@_with_option_keys("recording")
class CampaignRecordingTable(Table):
    """A recording."""

    file: str = table_key_field("a recording, next to this file")
    name: str | None = table_key_field(
        "what it is called; the file's name by default", default=None
    )
    times: Annotated[float, NumberField(above=0, most=1e9)] = table_key_field(
        "how often it is driven in the mix", default=1.0
    )
    beside: tuple[
        Annotated[tuple[Path, float, tuple[str, ...]], AdditionalRecordingFileTable], ...
    ] = table_key_field("other files of the same drive", default=())
    segments: tuple[Annotated[RecordingSegment, SegmentTable], ...] = table_key_field(
        "stretches that count in place of the whole", default=()
    )
    channels: _Channels | None = table_key_field(
        "calibrations of this recording, in place of those of the campaign", default=None
    )

    def build(self) -> RecordingSpec:
        """Return the recording."""
        self.require_different_names("segments", (segment.name for segment in self.segments))
        options = _option_values(self, "recording") | {"dbc": _databases(self)}
        return RecordingSpec(
            file=self.reader_of("file").referenced_path(self.file),
            name=self.name or Path(self.file).name,
            times=self.times,
            second_files=self.beside,
            segments=self.segments,
            options=options | {"scale": _scales(self.channels)},
        )


@_with_option_keys("strength")
class GaugeFatigueStrengthTable(Table):
    """The S-N curve at the gauges, half failed."""

    amplitude_MPa: Annotated[float, _SN_AMPLITUDE] = table_key_field("at the knee")  # noqa: N815
    cycles: Annotated[float, _SN_CYCLES] = table_key_field("at the knee")
    slope: Annotated[float, _SN_SLOPE] = table_key_field("above the knee")

    def build(self) -> dict[str, Any]:
        """Return it as the options say it."""
        curve = f"{self.amplitude_MPa!r},{self.cycles!r},{self.slope!r}"
        return {"sn": curve} | _option_values(self, "strength")


@_with_option_keys("campaign", before="customer")
class CampaignTable(Table):
    """A campaign of recordings: what was measured, and what is computed from it."""

    campaign: Annotated[str, TextField(MAX_PROSE_CHARACTERS)] = table_key_field("its title")
    recordings: tuple[Annotated[RecordingSpec, CampaignRecordingTable], ...] = table_key_field(
        "what was recorded"
    )
    strength: Annotated[dict[str, Any], GaugeFatigueStrengthTable] = table_key_field(
        "the S-N curve at the gauges"
    )
    channels: _Channels | None = table_key_field(
        "calibrations, by channel, of every recording that says no other", default=None
    )
    customer: Annotated[float, NumberField(least=0.5, below=1)] | None = table_key_field(
        "share of customers to tell the damage of, each recording taken for one", default=None
    )

    def build(self) -> CampaignSpec:
        """Return the campaign."""
        if not self.recordings:
            self.reader_of("recordings").reject("is empty", "give one file at least")
        self.require_different_names("recordings", (drive.name for drive in self.recordings))
        options = _option_values(self, "campaign") | self.strength
        options["scale"] = _scales(self.channels)
        for name in (o.name for o in OPTIONS.values() if o.is_application):
            if options[name] is not None:
                options[name] = self._application(name)
        profile = options["limits"]
        if profile and profile.endswith((".yaml", ".yml")):
            options["limits"] = str(self.reader_of("limits").referenced_path(profile))
        return CampaignSpec(
            title=self.campaign,
            drives=self.recordings,
            options=options,
            customer_share=self.customer or 0.0,
        )

    def _application(self, name: str) -> Application:
        """Return the application of a file named by a key."""
        from cardan.application.reader import read as application

        here = self.reader_of(name)
        path = here.referenced_path(getattr(self, name))
        found: list[ReferencedFile] = []
        try:
            return application(path, allow_outside=here.context.allow_outside, beside=found)
        finally:
            here.context.referenced_files += (
                replace(b, address=here.address, name=None) for b in found
            )


def read_campaign_file(path: Path, *, allow_outside: bool = False) -> CampaignSpec:
    """Read a campaign's file.

    Raises
    ------
    InvalidFileError
        With everything wrong in it, by line and column; also where it names a recording
        outside its own folder and that is not allowed.
    """
    return read_campaign_text(
        read_text(path), name=str(path), folder=path.parent, allow_outside=allow_outside
    )


def read_campaign_text(
    text: str,
    *,
    name: str = "campaign",
    folder: Path | None = None,
    allow_outside: bool = False,
    beside: list[ReferencedFile] | None = None,
) -> CampaignSpec:
    """Return the campaign a text describes; `read` is the same for a file.

    `name` is what errors call the text, and its recordings are files in `folder`.
    `beside` is given each file that is looked up, whatever comes of it.
    """
    root, problems = parse_yaml(text, name)
    reading = TableReadContext(
        folder=folder, allow_outside=allow_outside, problems=problems,
        referenced_files=[] if beside is None else beside,
    )  # fmt: skip
    try:
        found: CampaignSpec = TableField(CampaignTable).read(NodeReader(root, "", reading))
    except (InvalidValueError, TooManyIssuesError):
        raise InvalidFileError(name, tuple(problems)) from None
    if problems:
        raise InvalidFileError(name, tuple(problems))
    named = tuple(dict.fromkeys(one.path for one in reading.referenced_files))
    return replace(found, name=Path(name).name, referenced_files=named)


def campaign_title(text: YamlEditor) -> str | None:
    """Return what a text is called as a campaign; None where it is of something else."""
    return text.scalar_text("campaign")


def campaign_json_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) that editors complete and check campaigns by."""
    defs: dict[str, Any] = {}
    root = CampaignTable.schema(defs)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "cardan campaign",
        **root,
        "$defs": dict(sorted(defs.items())),
    }
