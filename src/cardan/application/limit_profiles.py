"""Limit profiles: what each quantity may reach, from data files with a source per limit."""

from functools import cache
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from cardan.application.provenance_code import ProvenanceCode, with_provenance_code
from cardan.core.errors import FileIssue, InvalidFileError
from cardan.core.provenance import Source
from cardan.core.units import UNITS, deg, mm
from cardan.core.verdict import Limit
from cardan.model.application import STATE_KIND_GROUPS, STATE_KINDS, Application
from cardan.schema import fields as measure
from cardan.schema.field_types import MAX_PROSE_CHARACTERS, ListField, NumberField, TextField
from cardan.schema.node_reader import (
    InvalidValueError,
    NodeReader,
    TableReadContext,
    TooManyIssuesError,
    nearest_name_hint,
)
from cardan.schema.tables import Table, TableField, table_key_field
from cardan.schema.yaml_tree import parse_yaml, read_text

DEFAULT_PROFILE_NAME = "heavy-truck"
"""The profile of an application that names none."""

LENGTH_MARGIN_SCALE = 10 * mm
"""What the margin of a length is a share of where its bound is 0."""

INLINE_LIMITS_NAME = "limits of the application"
"""What limits are called that are listed in the file itself."""

OVERRIDDEN_PROFILE_SUFFIX = ", with overrides"
"""What stands after the name of a profile of whose limits the file replaces some."""

_ALIKE = (
    measure.LENGTH_KEY_UNITS,
    measure.TORQUE_KEY_UNITS,
    measure.MASS_KEY_UNITS,
    measure.FORCE_KEY_UNITS,
    measure.ANGLE_KEY_UNITS,
    measure.SPEED_KEY_UNITS,
    measure.STRESS_KEY_UNITS,
    ("1", "percent"),
    ("h", "s"),
)
"""Units of one dimension: a limit may stand in any that its quantity can be shown in."""


class LimitTable(Table):
    """What a quantity may reach: past `normal` a check warns, past `maximum` it fails."""

    fixed = True

    quantity: str = table_key_field("the quantity, by the name `cardan explain` knows it under")
    unit: str | None = table_key_field(
        "unit of the numbers; by default the one it is shown in", default=None
    )
    normal: float | None = table_key_field("what it may reach without a warning", default=None)
    maximum: float | None = table_key_field("what it may reach at all", default=None)
    sense: Literal["<=", ">="] | None = table_key_field(
        "whether the limit is an upper or a lower one; by default what the quantity asks for",
        default=None,
    )
    band: Annotated[tuple[float, float], ListField(NumberField(), "from", "to")] | None = (
        table_key_field("range to keep out of", default=None)
    )
    above_angle: float | None = table_key_field(
        "asked only above this angle of a cross, deg", default=None
    )
    states: tuple[str, ...] | None = table_key_field(
        "kinds of state it applies to, or groups of them: riding, stops, wound up; by default all",
        default=None,
    )
    points: Literal["all", "own"] = table_key_field(
        "all: asked at every torque and speed that a state can have; own: at the state's own alone",
        default="all",
    )
    required: bool = table_key_field(
        "whether a verdict is incomplete where nothing answers it", default=False
    )
    if_given: bool = table_key_field(
        "whether it is left out where the file lacks what it needs", default=False
    )
    source: Annotated[str, TextField(MAX_PROSE_CHARACTERS)] = table_key_field("who says so")
    how_read: ProvenanceCode | None = table_key_field(
        "how that was read: re-read, by definition, second hand, from memory or assumed; where "
        "normal, maximum or band differ, behind a semicolon",
        default=None,
    )

    def build(self) -> Limit:
        """Return the limit in SI."""
        from cardan.checks.quantities.registry import LIMITABLE_QUANTITIES, QUANTITIES

        quantity = QUANTITIES.get(self.quantity)
        if quantity is None:
            hint = nearest_name_hint(self.quantity, LIMITABLE_QUANTITIES)
            self.reader_of("quantity").reject("unknown quantity", hint, got=self.quantity)
        if self.quantity not in LIMITABLE_QUANTITIES:
            self.reader_of("quantity").reject("nothing answers a limit of this", got=self.quantity)
        alike = next((a for a in _ALIKE if quantity.unit in a), (quantity.unit,))
        unit = quantity.unit if self.unit is None else _unit(self.unit)
        if unit not in alike:
            message = f"{self.quantity} is limited in {' or '.join(alike)}"
            self.reader_of("unit").reject(message, got=self.unit or "")
        sense = self.sense or quantity.sense
        self._order(sense)
        self._alone()
        if self.required and self.if_given:
            self.reader_of("if_given").reject("a required limit is never left out", got="true")
        worth, band = UNITS[unit], self.band
        return Limit(
            quantity=self.quantity,
            source=with_provenance_code(Source(self.source), self.how_read),
            normal=None if self.normal is None else self.normal * worth,
            maximum=None if self.maximum is None else self.maximum * worth,
            sense=sense,
            band=None if band is None else (band[0] * worth, band[1] * worth),
            above_angle=None if self.above_angle is None else self.above_angle * deg,
            states=self._kinds(),
            required=self.required,
            points=self.points,
            if_given=self.if_given,
            margin_scale=LENGTH_MARGIN_SCALE if quantity.unit == "mm" else 1.0,
        )

    def _kinds(self) -> frozenset[str] | None:
        """Return the kinds of state it applies to; None for all."""
        if self.states is None:
            return None
        found: set[str] = set()
        for k, name in enumerate(self.states, 1):
            if name not in (*STATE_KIND_GROUPS, *STATE_KINDS):
                hint = nearest_name_hint(name, (*STATE_KIND_GROUPS, *STATE_KINDS))
                self.reader_of("states", k).reject("no kind of state", hint, got=name)
            found |= STATE_KIND_GROUPS.get(name, {name})
        return frozenset(found)

    def _order(self, sense: str) -> None:
        """Refuse a warning that would come after the failure."""
        first, last = self.normal, self.maximum
        if first is None or last is None or first == last:
            return
        if (first < last) != (sense == "<="):
            message = f"must lie on the safe side of the maximum, {self.quantity} {sense} {last:g}"
            hint = 'sense: "<=" is an upper limit, ">=" a lower one'
            self.reader_of("normal").reject(message, hint, got=f"{first:g}")

    def _alone(self) -> None:
        """Refuse a band that falls, and one with other bounds: each is a limit of its own."""
        if self.band is None:
            return
        first, last = self.band
        if not 0 < first < last:
            self.reader_of("band").reject("must rise from above 0", got=f"{first:g}, {last:g}")
        for name in ("normal", "maximum"):
            if getattr(self, name) is not None:
                message = "a band is a limit of its own: list another of this quantity separately"
                self.reader_of(name).reject(message)


LimitsFromTables: TypeAlias = Annotated[
    tuple[Limit, ...], ListField(TableField(LimitTable), most=500)
]
LimitProfile: TypeAlias = tuple[str, tuple[Limit, ...]]
"""Name and limits."""


def _unit(written: str) -> str:
    """Return the name in keys of a unit as people write it: rad/s2, N·m."""
    from cardan.checks.quantities.declaration import UNIT_SYMBOLS

    bare = written.replace("/", "_").replace("²", "2").replace("·", "").replace(" ", "_")
    return {v: k for k, v in UNIT_SYMBOLS.items() if v}.get(written, bare)


class ProfileTable(Table):
    """A limit profile."""

    profile: str = table_key_field("its name")
    title: Annotated[str, TextField(MAX_PROSE_CHARACTERS)] | None = table_key_field(
        "what it is for", default=None
    )
    limits: LimitsFromTables = table_key_field("the limits")


def profile_names() -> tuple[str, ...]:
    """Return the names of the profiles that come with this package."""
    return tuple(sorted(p.stem for p in _FOLDER.glob("*.yaml")))


_FOLDER = Path(__file__).with_name("profiles")


def load_profile(name: str) -> LimitProfile:
    """Return name and limits of a shipped profile, or of a .yaml file of your own.

    Raises
    ------
    InvalidFileError
        If there is none of that name, or with everything wrong in the file.
    """
    if name.endswith((".yaml", ".yml")):
        return _read(Path(name))
    if name not in profile_names():
        hint = f"{nearest_name_hint(name, profile_names())} A file of your own ends in .yaml"
        message = "there is no limit profile of this name"
        raise InvalidFileError(name, (FileIssue(message=message, hint=hint),))
    return _shipped(name)


def limits_to_evaluate(application: Application) -> tuple[Limit, ...]:
    """Return an application's limits, with those of every profile that its own says nothing of.

    Whatever a file holds is evaluated: without them a shaft beyond its critical speed would be
    approved by a profile of angles. Limits listed in the file itself, or handed over from Python,
    stand alone; what they do not limit of speed and strength is named with the verdict.
    """
    limits = application.limits
    if application.written is None or application.profile.startswith(INLINE_LIMITS_NAME):
        return limits
    stated = {limit.quantity for limit in limits}
    return (*limits, *(own for own in _of_every_profile() if own.quantity not in stated))


@cache
def _of_every_profile() -> tuple[Limit, ...]:
    return _read(Path(__file__).with_name("limits_of_every_profile.yaml"))[1]


@cache
def _shipped(name: str) -> LimitProfile:
    return _read(_FOLDER / f"{name}.yaml")


def _read(path: Path) -> LimitProfile:
    """Return name and limits of a profile's file."""
    root, problems = parse_yaml(read_text(path), str(path))
    try:
        table: ProfileTable = ProfileTable.read(
            NodeReader(root, "", TableReadContext(problems=problems))
        )
    except (InvalidValueError, TooManyIssuesError):
        raise InvalidFileError(str(path), tuple(problems)) from None
    if problems:
        raise InvalidFileError(str(path), tuple(problems))
    return table.profile, table.limits
