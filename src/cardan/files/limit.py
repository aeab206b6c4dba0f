"""Limit profiles: what each quantity may reach, from data files with a source per limit."""

from functools import cache
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from cardan.base.errors import BadFile, Problem
from cardan.base.source import Source
from cardan.base.units import UNITS, deg
from cardan.base.verdict import Limit
from cardan.border import measure
from cardan.border.document import parse, text_of
from cardan.border.table import (
    PROSE,
    Enough,
    Here,
    ListOf,
    Number,
    Reading,
    Spoilt,
    Table,
    TableRule,
    Text,
    key,
    nearest,
)  # fmt: skip
from cardan.files.how_read import HowRead, with_reading
from cardan.model.application import KIND_GROUPS, STATE_KINDS
from cardan.quantity.declared import WRITTEN
from cardan.quantity.quantities import LIMITABLE, QUANTITIES

DEFAULT = "heavy-truck"
"""The profile of an application that names none."""

_ALIKE = (
    measure.LENGTHS, measure.TORQUES, measure.MASSES, measure.FORCES, measure.ANGLES,
    measure.SPEEDS, measure.STRESSES, ("1", "percent"), ("h", "s"),
)  # fmt: skip
"""Units of one dimension: a limit may stand in any that its quantity can be shown in."""


class LimitTable(Table):
    """What a quantity may reach: past `normal` a check warns, past `maximum` it fails."""

    fixed = True

    quantity: str = key("the quantity, by the name `cardan explain` knows it under")
    unit: str | None = key("unit of the numbers; by default the one it is shown in", default=None)
    normal: float | None = key("what it may reach without a warning", default=None)
    maximum: float | None = key("what it may reach at all", default=None)
    sense: Literal["<=", ">="] | None = key(
        "whether the limit is an upper or a lower one; by default what the quantity asks for",
        default=None,
    )
    band: Annotated[tuple[float, float], ListOf(Number(), "from", "to")] | None = key(
        "range to keep out of", default=None
    )
    above_angle: float | None = key("asked only above this joint angle, deg", default=None)
    states: tuple[str, ...] | None = key(
        "kinds of state it applies to, or groups of them: riding, stops, wound up; by default all",
        default=None,
    )
    points: Literal["all", "own"] = key(
        "all: asked at every torque and speed that a state can have; own: at the state's own alone",
        default="all",
    )
    required: bool = key("whether a verdict is incomplete where nothing answers it", default=False)
    source: Annotated[str, Text(PROSE)] = key("who says so")
    how_read: HowRead | None = key(
        "how that was read: re-read, by definition, second hand, from memory or assumed; where "
        "normal, maximum or band differ, behind a semicolon",
        default=None,
    )

    def build(self) -> Limit:
        """Return the limit in SI."""
        quantity = QUANTITIES.get(self.quantity)
        if quantity is None:
            hint = nearest(self.quantity, LIMITABLE)
            self.at("quantity").refuse("unknown quantity", hint, got=self.quantity)
        if self.quantity not in LIMITABLE:
            self.at("quantity").refuse("nothing answers a limit of this", got=self.quantity)
        alike = next((a for a in _ALIKE if quantity.unit in a), (quantity.unit,))
        unit = quantity.unit if self.unit is None else _unit(self.unit)
        if unit not in alike:
            message = f"{self.quantity} is limited in {' or '.join(alike)}"
            self.at("unit").refuse(message, got=self.unit or "")
        sense = self.sense or quantity.sense
        self._order(sense)
        self._alone()
        worth, band = UNITS[unit], self.band
        return Limit(
            quantity=self.quantity,
            source=with_reading(Source(self.source), self.how_read),
            normal=None if self.normal is None else self.normal * worth,
            maximum=None if self.maximum is None else self.maximum * worth,
            sense=sense,
            band=None if band is None else (band[0] * worth, band[1] * worth),
            above_angle=None if self.above_angle is None else self.above_angle * deg,
            states=self._kinds(),
            required=self.required,
            points=self.points,
        )

    def _kinds(self) -> frozenset[str] | None:
        """Return the kinds of state it applies to; None for all."""
        if self.states is None:
            return None
        found: set[str] = set()
        for k, name in enumerate(self.states, 1):
            if name not in (*KIND_GROUPS, *STATE_KINDS):
                hint = nearest(name, (*KIND_GROUPS, *STATE_KINDS))
                self.at("states", k).refuse("no kind of state", hint, got=name)
            found |= KIND_GROUPS.get(name, {name})
        return frozenset(found)

    def _order(self, sense: str) -> None:
        """Refuse a warning that would come after the failure."""
        first, last = self.normal, self.maximum
        if first is None or last is None or first == last:
            return
        if (first < last) != (sense == "<="):
            message = f"must lie on the safe side of the maximum, {self.quantity} {sense} {last:g}"
            hint = 'sense: "<=" is an upper limit, ">=" a lower one'
            self.at("normal").refuse(message, hint, got=f"{first:g}")

    def _alone(self) -> None:
        """Refuse a band that falls, and one beside other bounds: each asks for itself."""
        if self.band is None:
            return
        first, last = self.band
        if not 0 < first < last:
            self.at("band").refuse("must rise from above 0", got=f"{first:g}, {last:g}")
        for name in ("normal", "maximum"):
            if getattr(self, name) is not None:
                message = "a band is a limit of its own: list another of this quantity beside it"
                self.at(name).refuse(message)


Limits: TypeAlias = Annotated[tuple[Limit, ...], ListOf(TableRule(LimitTable), most=500)]
Profile: TypeAlias = tuple[str, tuple[Limit, ...]]
"""Name and limits."""


def _unit(written: str) -> str:
    """Return the name in keys of a unit as people write it: rad/s2, N·m."""
    bare = written.replace("/", "_").replace("²", "2").replace("·", "").replace(" ", "_")
    return {v: k for k, v in WRITTEN.items() if v}.get(written, bare)


class ProfileTable(Table):
    """A limit profile."""

    profile: str = key("its name")
    title: Annotated[str, Text(PROSE)] | None = key("what it is for", default=None)
    limits: Limits = key("the limits")


def names() -> tuple[str, ...]:
    """Return the names of the profiles that come with this package."""
    return tuple(sorted(p.stem for p in _FOLDER.glob("*.yaml")))


_FOLDER = Path(__file__).with_name("profiles")


def limits(name: str) -> Profile:
    """Return name and limits of a shipped profile, or of a .yaml file of your own.

    Raises
    ------
    BadFile
        If there is none of that name, or with everything wrong in the file.
    """
    if name.endswith((".yaml", ".yml")):
        return _read(Path(name))
    if name not in names():
        hint = f"{nearest(name, names())} A file of your own ends in .yaml"
        message = "there is no limit profile of this name"
        raise BadFile(name, (Problem(message=message, hint=hint),))
    return _shipped(name)


@cache
def _shipped(name: str) -> Profile:
    return _read(_FOLDER / f"{name}.yaml")


def _read(path: Path) -> Profile:
    """Return name and limits of a profile's file."""
    root, problems = parse(text_of(path), str(path))
    try:
        table: ProfileTable = ProfileTable.read(Here(root, "", Reading(problems=problems)))
    except (Spoilt, Enough):
        raise BadFile(str(path), tuple(problems)) from None
    if problems:
        raise BadFile(str(path), tuple(problems))
    return table.profile, table.limits
