"""What relations between values of an application are evaluated on, and what they return."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from itertools import chain
from math import inf, nan
from typing import NamedTuple, TypeAlias

from cardan.application.source_location import locate_yaml_address
from cardan.application.typical_values import vehicle_class_of
from cardan.core.errors import DesignError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import g, t
from cardan.model.application import Application, InstalledLine, VehicleState
from cardan.model.parts import Shaft
from cardan.model.vehicle import LoadState, Suspension, SuspensionState
from cardan.physics.vehicle.state_demand import (
    LineStateDemand,
    line_state_demand,
    resolve_line_references,
)

CandidateYamlAddresses: TypeAlias = tuple[str, ...]
"""Addresses that a value may have in the file: the first that is given counts."""


class ComparedValue(NamedTuple):
    """One value of a relation.

    `addresses` are of the value that is odd if the number is; `against` are those of the
    values that it is compared with. A nan is not known, hence never odd. `detail` is what a
    rule's own message names. `default` is what stands in where the file gives none of the first
    address: a warning then names that missing key.
    """

    addresses: CandidateYamlAddresses
    value: float
    against: tuple[str, ...] = ()
    detail: str = ""
    default: str = ""


ComparedValues: TypeAlias = Iterator[ComparedValue]
Range: TypeAlias = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class LineContext:
    """One line with what surrounds it, resolved once.

    Attributes
    ----------
    at
        Address of the line.
    """

    application: Application
    installed: InstalledLine

    @property
    def at(self) -> str:
        """Address of the line."""
        return f"drivelines.{self.installed.line.name}"

    @property
    def axle(self) -> str:
        """Address of the axle the line drives: its own, or the vehicle's."""
        own = f"{self.at}.axle"
        found = locate_yaml_address(self.application, own)
        return own if found and found.key.endswith(".axle") else "axle"

    @property
    def leaves_gearbox(self) -> bool:
        """Whether joint 1 is held by the frame, not by an axle."""
        return self.installed.output_joint is None

    @cached_property
    def suspension(self) -> tuple[str, Suspension] | None:
        """Address and springs of what moves the line's axle."""
        if self.installed.suspension:
            return f"{self.at}.suspension", self.installed.suspension
        if self.application.suspension and self.installed.drives == "rear":
            return "suspension", self.application.suspension
        return None

    @cached_property
    def reference(self) -> LineStateDemand | None:
        """Demand in the state the geometry is given in; None if it cannot be computed."""
        return self.standing(self.reference_kind)

    @property
    def reference_kind(self) -> SuspensionState:
        """Kind of state the geometry is given in."""
        return self.suspension[1].reference if self.suspension else "gvw"

    @cached_property
    def laden(self) -> LineStateDemand | None:
        """Demand at gvw; None if it cannot be computed."""
        return self.reference if self.reference_kind == "gvw" else self.standing("gvw")

    @cached_property
    def in_states(self) -> LineStateDemand | None:
        """Demand in the application's states; None if it cannot be computed."""
        with suppress(DesignError):
            return line_state_demand(resolve_line_references(self.application, self.installed))
        return None

    def standing(self, kind: SuspensionState) -> LineStateDemand | None:
        """Return the demand in one kind of state; None if it cannot be computed."""
        alone = replace(self.application, states=(VehicleState(name=kind, kind=kind),))
        with suppress(DesignError):
            return line_state_demand(resolve_line_references(alone, self.installed))
        return None

    @property
    def shafts(self) -> Iterator[tuple[str, Shaft, float]]:
        """Address, shaft and length of every shaft."""
        lengths = self.installed.layout.lengths.tolist()
        for k, (shaft, length) in enumerate(
            zip(self.installed.line.shafts, lengths, strict=True), 1
        ):
            yield f"{self.at}.shafts[{k}]", shaft, length


@dataclass(frozen=True, kw_only=True)
class RelationContext:
    """An application with what several relations share, computed once."""

    application: Application

    @cached_property
    def lines(self) -> tuple[LineContext, ...]:
        """Every line of the application."""
        return tuple(
            LineContext(application=self.application, installed=i) for i in self.application.lines
        )

    @property
    def shafts(self) -> Iterator[tuple[str, Shaft, float]]:
        """Address, shaft and length of every shaft of every line."""
        return chain.from_iterable(line.shafts for line in self.lines)

    @cached_property
    def top_speed(self) -> float:
        """Top speed of the gearbox output that the engine allows, rad/s."""
        engine, gearbox = self.application.engine, self.application.gearbox
        if engine is None:
            return nan
        return max(engine.full_load[0]) / min(gearbox.ratios if gearbox else (1.0,))

    @cached_property
    def largest_torque(self) -> float:
        """Largest torque at the gearbox output, without losses, N m."""
        engine, gearbox = self.application.engine, self.application.gearbox
        if engine is None:
            return nan
        torque = float(engine.peak_torque)
        if gearbox is None:
            return torque
        transfer = max(gearbox.transfer_ratio, 1)
        return torque * max(gearbox.ratios) * gearbox.converter_ratio * transfer

    @cached_property
    def power(self) -> float:
        """Largest power of the engine, W."""
        engine = self.application.engine
        return max(map(float.__mul__, engine.speed, engine.torque)) if engine else nan

    @cached_property
    def masses(self) -> dict[str, float]:
        """Mass in each load state, kg, by its name."""
        vehicle = self.application.vehicle
        return {load.name: self._mass(load) for load in vehicle.loads} if vehicle else {}

    @property
    def heaviest(self) -> float:
        """Largest mass of the vehicle, t."""
        return max(self.masses.values(), default=nan) / t

    @property
    def heaviest_address(self) -> str:
        """Address of the load state with it."""
        return f"vehicle.loads.{max(self.masses, key=self.masses.__getitem__, default='gvw')}"

    @property
    def vehicle_class(self) -> str | None:
        """Class of the vehicle by its largest mass; None if that is not known."""
        return vehicle_class_of(self.heaviest * t) if self.masses else None

    @property
    def has_converter(self) -> bool:
        """Whether a converter stands ahead of the gearbox."""
        gearbox = self.application.gearbox
        return gearbox is not None and gearbox.converter_ratio > 1

    def _mass(self, load: LoadState) -> float:
        if load.mass is not None:
            return load.mass
        vehicle = self.application.vehicle
        beside = sum(a.load for a in vehicle.auxiliary) if vehicle else 0.0
        on_axles = (load.front_load or 0.0) + (load.rear_load or 0.0)
        return (on_axles + (0.0 if load.auxiliary_lifted else beside)) / g


@dataclass(frozen=True)
class PlausibilityRule:
    """A relation between values of a file, or of a file and a catalogue.

    Attributes
    ----------
    name
        Identifies it in JSON and in tests.
    description
        The number that is compared, as a message begins.
    values
        Pure function: the number, in `unit`, for everything in an application that has it.
    usual_range
        Lowest and highest number without a warning; by class of vehicle where it depends on it.
    source
        Where the range is from; "assumed" is our own judgement.
    unit, hint
        How the number is printed; what to look at.
    message
        Stands in place of number and range where those say less; holds `{detail}`.
    """

    name: str
    description: str
    values: Callable[[RelationContext], ComparedValues]
    usual_range: Range | dict[str, Range]
    source: str = "assumed"
    unit: str = ""
    hint: str = ""
    message: str = ""

    def range_for(self, of: RelationContext) -> Range:
        """Return the range that holds for an application; unbounded if its class is not known."""
        if isinstance(self.usual_range, tuple):
            return self.usual_range
        return self.usual_range.get(of.vehicle_class or "", (-inf, inf))


def ratio(a: float | None, b: float | None) -> float:
    """Return a/b, nan where one is not known."""
    return a / b if a is not None and b else nan
