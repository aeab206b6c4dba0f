"""Where a line runs, as a file may say it: slopes, joint angles or points.

All three are one geometry: slopes of every member with the shafts' lengths, the changes of
slope at the joints, or the joint centres between two flange directions.
"""

from collections.abc import Sequence
from typing import Annotated, TypeAlias

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, stack_on_last_axis, stack_vectors_on_last_axes
from cardan.core.errors import values_of_first_violating_case
from cardan.core.units import deg, mm
from cardan.model.layout import (
    Layout,
    direction_from_slopes,
    layout_from_points,
    layout_from_slopes,
)
from cardan.schema.field_types import IntegerField, ListField, MappingField, NumberField
from cardan.schema.fields import (
    LENGTH_KEY_UNITS,
    MAX_SHAFT_SLOPE_RAD,
    JointCoordinates,
    PlanViewSlope,
    PlanViewSlopes,
    ShaftLength,
    Slope,
    Slopes,
)  # fmt: skip
from cardan.schema.tables import Table, table_key_field

SHAFT_LENGTH_MISMATCH_TOLERANCE_M = 2 * mm
"""How far a length may be from what the points give: they are measured to the millimetre."""
MAX_JOINT_ANGLE_RAD = 75 * deg
"""Joint angles stay below this: no yoke lets its joint bend further, and at 90 deg it locks."""

MAX_SHAFTS = 12
"""Of one line: trucks have up to five, and a limit far above keeps a mistake short."""

_COSINE = np.cos(MAX_JOINT_ANGLE_RAD)


class SlopeTable(Table):
    """The slope of one member."""

    side: Slope = table_key_field("side view, down to the rear positive", default=0.0)
    top: PlanViewSlope = table_key_field(
        "plan view, to the right going rearward positive", default=0.0
    )

    def build(self) -> tuple[float, float]:
        """Return both slopes, rad."""
        return self.side, self.top


class ViewAnglesTable(Table):
    """Angles in side and plan view, gearbox first; a view left out is straight."""

    side: Slopes | None = table_key_field("side view, down to the rear positive", default=None)
    top: PlanViewSlopes | None = table_key_field(
        "plan view, to the right going rearward positive", default=None
    )

    def angles(self, *members: str) -> tuple[FloatArray, FloatArray]:
        """Return both views, (..., members) rad, one value for each member named."""
        if self.side is None and self.top is None:
            self.reader_of().reject("needs side_deg or top_deg")
        for name, view in (("side", self.side), ("top", self.top)):
            if view is not None and len(view) != len(members):
                message = f"must hold {len(members)} values, for {', '.join(members)}"
                self.reader_of(name).reject(message, got=f"{len(view)} values")
        views = [
            np.zeros(len(members)) if v is None else stack_on_last_axis(v)
            for v in (self.side, self.top)
        ]
        return views[0], views[1]


SlopeFromTable: TypeAlias = Annotated[tuple[float, float], SlopeTable]


class GeometryTable(Table):
    """Where a line runs: slopes, joint angles or points, one of them."""

    at_most_one_of = (("slopes", "joint_angles", "points"),)

    slopes: ViewAnglesTable | None = table_key_field(
        "slope of every member: gearbox, shafts, pinion", default=None
    )
    joint_angles: ViewAnglesTable | None = table_key_field(
        "change of slope at every joint, as application sheets tabulate it", default=None
    )
    points: JointCoordinates | None = table_key_field(
        "joint centres [x, y, z]: x along the line from gearbox to axle, y to its right, z up",
        default=None,
    )
    gearbox_slope: SlopeFromTable | None = table_key_field(
        "of the gearbox output, with points", default=None
    )
    pinion_slope: SlopeFromTable | None = table_key_field(
        "of the axle's pinion, with points", default=None
    )

    @property
    def gives_geometry(self) -> bool:
        """Whether this says where the line runs."""
        return any(self.has(n) for n in ("slopes", "joint_angles", "points"))

    def layout(self, lengths: Sequence[float | None], *, reference: Layout | None = None) -> Layout:
        """Return the layout; what a state leaves out is as in the reference layout.

        Only points can do without a length.

        Raises
        ------
        InvalidValueError
            With the problem noted, if the line cannot run like this.
        """
        if self.points is not None:
            layout = self._through_points(self.points, lengths, reference)
        else:
            layout = self._along_slopes(stack_on_last_axis(lengths), reference)  # type: ignore[arg-type]
        cosines = (layout.directions[..., :-1, :] * layout.directions[..., 1:, :]).sum(-1)
        for k, cosine in enumerate(np.moveaxis(cosines, -1, 0), 1):
            if wrong := values_of_first_violating_case(cosine > _COSINE, cosine):
                name = next(n for n in ("slopes", "joint_angles", "points") if self.has(n))
                message = f"joint {k} would bend by {np.arccos(wrong[0]) / deg:.0f} deg"
                self.reader_of(name).reject(
                    message, f"a joint bends by less than {MAX_JOINT_ANGLE_RAD / deg:.0f} deg"
                )
        return layout

    def _along_slopes(self, lengths: FloatArray, reference: Layout | None) -> Layout:
        for name in ("pinion_slope", *(() if self.joint_angles else ("gearbox_slope",))):
            if self.has(name):
                hint = "the slopes hold it already" if self.slopes else "the joint angles give it"
                self.reader_of(name).reject("goes with points only", hint)
        count = lengths.shape[-1]
        shafts = [f"shaft {k}" for k in range(1, count + 1)]
        if self.slopes is not None:
            side, top = self.slopes.angles("gearbox", *shafts, "pinion")
        else:
            side, top = self._summed(count + 1, reference)
        layout = layout_from_slopes(side=side, top=top, lengths=lengths)
        if reference is None:
            return layout
        start = reference.points[..., :1, :]
        return Layout(points=layout.points + start, directions=layout.directions)

    def _summed(self, joints: int, reference: Layout | None) -> tuple[FloatArray, FloatArray]:
        """Slopes of every member from the joint angles, (..., members) rad."""
        assert self.joint_angles is not None  # used only if given
        views = self.joint_angles.angles(*(f"joint {k}" for k in range(1, joints + 1)))
        start: tuple[ArrayLike, ArrayLike] = self.gearbox_slope or (0.0, 0.0)
        if self.gearbox_slope is None and reference is not None:
            start = reference.side[..., 0], reference.top[..., 0]
        side, top = (
            np.cumsum(stack_on_last_axis((first, *np.moveaxis(view, -1, 0))), axis=-1)
            for first, view in zip(start, views, strict=True)
        )
        steepest = max(np.abs(side).max(), np.abs(top).max())
        if not steepest < MAX_SHAFT_SLOPE_RAD:
            message = f"the angles add up to a member sloping {steepest / deg:.1f} deg"
            self.reader_of("joint_angles").reject(
                message, f"slopes stay below {MAX_SHAFT_SLOPE_RAD / deg:.0f} deg"
            )
        return side, top

    def _through_points(
        self,
        points: JointCoordinates,
        lengths: Sequence[float | None],
        reference: Layout | None,
    ) -> Layout:
        if len(points) != len(lengths) + 1:
            message = f"must hold {len(lengths) + 1} joint centres, one more than shafts"
            self.reader_of("points").reject(message, got=f"{len(points)} points")
        joints = stack_vectors_on_last_axes(points)
        for k, (x, y, z) in enumerate(np.moveaxis(np.diff(joints, axis=-2), (-2, -1), (0, 1)), 1):
            least = np.maximum(
                SHAFT_LENGTH_MISMATCH_TOLERANCE_M, np.hypot(y, z) / np.tan(MAX_SHAFT_SLOPE_RAD)
            )
            if wrong := values_of_first_violating_case(x > least, x):
                message = f"x must rise from joint {k} to joint {k + 1}: it runs along the line"
                self.reader_of("points", k + 1).reject(
                    message, got=f"a rise of {wrong[0] / mm:g} mm"
                )
        ends: list[FloatArray] = []
        for name, end in (("gearbox_slope", 0), ("pinion_slope", -1)):
            slope: tuple[float, float] | None = getattr(self, name)
            if slope is not None:
                ends.append(direction_from_slopes(side=slope[0], top=slope[1]))
            elif reference is not None:
                ends.append(reference.directions[..., end, :])
            else:
                hint = f"{name}: {{side_deg: 3.0, top_deg: 0.0}}"
                self.reader_of("points").reject(f"points need a {name} too", hint)
        layout = layout_from_points(joints, gearbox=ends[0], pinion=ends[1])
        self._compare(lengths, layout, reference)
        return layout

    def _compare(
        self, lengths: Sequence[float | None], layout: Layout, reference: Layout | None
    ) -> None:
        """Hold the lengths given against the points; the last shaft slides between states."""
        slides = len(lengths) if reference is not None else 0
        apart = np.moveaxis(layout.lengths, -1, 0)
        for k, (given, between) in enumerate(zip(lengths, apart, strict=True), 1):
            if given is None or k == slides:
                continue
            if wrong := values_of_first_violating_case(
                abs(given - between) <= SHAFT_LENGTH_MISMATCH_TOLERANCE_M, between, given
            ):
                message = (
                    f"put joints {k} and {k + 1} {wrong[0] / mm:.1f} mm apart, but shaft {k} is "
                    f"{wrong[1] / mm:g} mm long"
                )
                self.reader_of("points").reject(message, "correct the points or the length")


_OFFSET = ListField(
    NumberField(*LENGTH_KEY_UNITS, least=-1, most=1, usual=(0.5 * mm, 0.1)), "side", "up"
)


class StateGeometryTable(GeometryTable):
    """Where a line runs in one state; what is left out is as in the reference."""

    last_length: ShaftLength | None = table_key_field(
        "length of the last shaft in this state, with slopes or joint angles", default=None
    )

    bearing_offset: Annotated[
        dict[int, tuple[float, float]], MappingField(IntegerField(MAX_SHAFTS), _OFFSET)
    ] = table_key_field(
        "how far the frame has moved centre bearings to the right and up as it sags and twists, "
        "between gearbox and axle: {2: [0, -10]}",
        default={},
    )

    def state_layout(self, lengths: Sequence[float], reference: Layout) -> Layout:
        """Return the layout of a line in this state."""
        if self.last_length is not None:
            if self.points is not None:
                self.reader_of("last_length").reject("the points give this already")
            lengths = [*lengths[:-1], self.last_length]
        return self.layout(lengths, reference=reference)
