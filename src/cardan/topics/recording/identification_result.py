"""What a recording says of its application: the numbers found, and the file that says them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cardan.application.yaml_edit import YamlEditor
from cardan.core.arrays import ComplexArray, FloatArray
from cardan.core.labels import Part
from cardan.core.message import TranslatableMessage
from cardan.core.units import deg, mm
from cardan.model.application import Application
from cardan.physics.signals.operational_modes import OperationalMode
from cardan.physics.signals.order_cuts import OrderCuts

MIN_SAME_MODE_SHAPE_COSINE, MAX_DIFFERENT_MODE_SHAPE_COSINE = 0.97, 0.9
"""Cosine of a mode's shape with what a force does at the gauges from which they are alike, and
below which they are distinguished."""

MAX_MODE_FREQUENCY_RATIO = 1.1
"""Ratio of frequencies up to which a mode may be one of the line on its rubber."""

PARAMETER_UNITS = {
    "vertical": ("N/mm", 1 / mm), "lateral": ("N/mm", 1 / mm), "loss": ("", 1.0),
    "phase": ("deg", deg), "gain": ("", 1.0), "mode": ("Hz", 1.0), "mode damping": ("", 1.0),
    "unbalance": ("g mm", 1e-6),
}  # fmt: skip
"""Units in which numbers are reported, and their factors to SI."""


@dataclass(frozen=True, kw_only=True)
class IdentifiedParameter:
    """One number that a recording says something of, SI.

    Attributes
    ----------
    name
        vertical, lateral, loss, phase, gain, mode, mode damping or unbalance.
    part
        What it belongs to.
    file_value
        In the application's file; nan where it says nothing.
    value, low, high
        As found, and the 90 % interval.
    identifiable
        Whether the recording says it.
    assumed
        Whether it does not because more of the interval is what was assumed than what it says.
    address
        Of its number in the application's file; "" where there is none.
    """

    name: str
    part: Part
    file_value: float
    value: float
    low: float
    high: float
    identifiable: bool = True
    assumed: bool = False
    address: str = ""

    @property
    def unit(self) -> str:
        """Unit that it is reported in, that of its key in the file."""
        return PARAMETER_UNITS[self.name][0]

    def in_display_unit(self, value: float) -> float:
        """Return a value of it in that unit."""
        return value / PARAMETER_UNITS[self.name][1]

    @property
    def differs(self) -> bool:
        """Whether what the file says lies outside the interval."""
        return not np.isnan(self.file_value) and not self.low <= self.file_value <= self.high

    @property
    def contradicts_file(self) -> bool:
        """Whether the recording contradicts the file."""
        return self.identifiable and self.differs

    @property
    def needs_rewrite(self) -> bool:
        """Whether the file has to say it anew: it says otherwise, or nothing."""
        return bool(self.address) and (
            self.contradicts_file or (self.identifiable and bool(np.isnan(self.file_value)))
        )


@dataclass(frozen=True, kw_only=True)
class IdentificationResult:
    """What a recording says of its application.

    Attributes
    ----------
    application, identified
        As written, and with the numbers identified from the recording.
    state, bearing
        Which geometry, and whose force the gauges feel.
    parameters
        What was found.
    gauges
        Their names.
    cuts
        Measured at each gauge, Pa.
    torque : (W,) N m
        Mean in each window.
    computed_before, computed_after : (gauges, K, W) Pa, complex
        Computed by the file, and by what was found, with the tacho's mark where it is.
    unit_stress : (gauges, 3) Pa/N
        What a unit force of the bearing does at each, as found.
    mean_stress : (gauges, W) Pa
        Stress of the mean force, as found.
    tacho_mark_angle : (W,) rad
        How far the gearbox's yoke is ahead of the tacho's mark, to half a turn.
    misfit : before and after
        Share of the measured order 2's energy that is not explained.
    line_frequencies : Hz
        Frequencies of the line on its rubber, as found.
    operational_modes
        Modes that the gauges feel in addition to the orders: what road and engine shake.
    doubts
        Why no number is reported, if so.
    """

    application: Application
    identified: Application
    state: str
    bearing: int
    parameters: tuple[IdentifiedParameter, ...]
    gauges: tuple[str, ...]
    cuts: OrderCuts
    torque: FloatArray
    computed_before: ComplexArray
    computed_after: ComplexArray
    unit_stress: FloatArray
    mean_stress: FloatArray
    tacho_mark_angle: FloatArray
    misfit: tuple[float, float]
    line_frequencies: tuple[float, ...] = ()
    operational_modes: tuple[OperationalMode, ...] = ()
    doubts: tuple[TranslatableMessage, ...] = ()

    def force_direction(self, mode: OperationalMode) -> int | None:
        """Return which way a force on the bearing does the same to the gauges as a mode.

        Along the shaft 0, sideways 1 or up 2; None where it is none of them, or more than one:
        two gauges at least have to distinguish them.
        """
        shape = np.array(mode.shape)
        size = np.linalg.norm(self.unit_stress, axis=0) * np.linalg.norm(shape)
        alike = np.abs(shape @ self.unit_stress) / np.where(size > 0, size, np.inf)
        best, second = np.argsort(-alike)[:2]
        return (
            int(best)
            if alike[best] > MIN_SAME_MODE_SHAPE_COSINE
            and alike[second] < MAX_DIFFERENT_MODE_SHAPE_COSINE
            else None
        )

    def line_frequency(self, mode: OperationalMode) -> float | None:
        """Return the frequency Hz of the line on its rubber that a mode may be; None if none is."""
        low, found, high = mode.frequency
        near = [
            f
            for f in self.line_frequencies
            if low / MAX_MODE_FREQUENCY_RATIO <= f <= high * MAX_MODE_FREQUENCY_RATIO
        ]
        return min(near, key=lambda f: abs(f - found)) if near else None

    def file_changes(self) -> dict[str, float | str | list[float]]:
        """Return what the file would say instead, by address, in its keys' units."""
        return {
            p.address: float(f"{p.in_display_unit(p.value):.4g}")
            for p in self.parameters
            if p.needs_rewrite
        }

    def file_text(self) -> str:
        """Return the application's file with the numbers found; comments stay.

        Raises
        ------
        InvalidFileError
            If a number cannot be written where it would stand.
        """
        written = self.application.written
        assert written is not None  # `identify` refuses one without
        return YamlEditor(written.text, written.name).with_changes(self.file_changes())


@dataclass(frozen=True)
class ParameterChange:
    """A number found otherwise than written, and what a changed application has in its place, SI.

    nan where it says nothing.
    """

    identified: IdentifiedParameter
    value: float


def parameter_changes(
    of: IdentificationResult, changed: Application
) -> tuple[ParameterChange, ...]:
    """Return where a changed application departs from what was found otherwise than written.

    It is the change in question, or what the file said wrong of the line that was driven.
    """
    from cardan.topics.recording.bearing_model import identifiable_numbers

    said = {
        (name, part): value for name, part, _, value in identifiable_numbers(changed.lines[0].line)
    }
    found = (
        ParameterChange(p, said.get((p.name, p.part), np.nan))
        for p in of.parameters
        if p.needs_rewrite
    )
    return tuple(d for d in found if not d.identified.low <= d.value <= d.identified.high)


def application_with_changes(application: Application, changes: Mapping[str, float]) -> Application:
    """Return the application with other numbers; those that its file leaves out put into it."""
    from cardan.application.reader import read_source_text

    written = application.written
    assert written is not None  # `identify` refuses one without
    absent = {at: value for at, value in changes.items() if at not in written.numbers}
    made: Mapping[str, Any] = dict(written.changes) | {
        at: value for at, value in changes.items() if at not in absent
    }
    text = YamlEditor(written.text, written.name).with_changes(absent)
    return read_source_text(replace(written, text=text, changes=made))
