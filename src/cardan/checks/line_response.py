"""What a line does: every quantity of the method, for cases on leading axes.

One code path serves one design and a million: the states of an application stand on the
last leading axis, variants of a study on axes before it.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from cardan.checks.line_clearances import LineClearances
from cardan.checks.line_inputs import LineInputs, layout_of_demand
from cardan.checks.line_kinematics import LineKinematics
from cardan.checks.line_on_mounts import LineOnMounts
from cardan.checks.line_strength import LineStrength
from cardan.checks.mount_loads import MountLoads
from cardan.checks.operating_envelope import envelope_points
from cardan.checks.rigid_line_loads import RigidLineLoads
from cardan.core.arrays import ArrayLike, FloatArray, stack_on_last_axis
from cardan.core.lazy_dataclass import dataclass
from cardan.model.application import Application
from cardan.model.layout import Layout
from cardan.model.parts import JointSize, Line
from cardan.physics.loads.centre_bearing import layout_settled_under_torque
from cardan.physics.vehicle.operating_points import LineOperatingPoints
from cardan.physics.vehicle.state_demand import LineStateDemand
from cardan.physics.vehicle.state_torques import individual_axle_loads_by_state


@dataclass(frozen=True, kw_only=True)
class LineResponse:
    """Everything computed for one line, by subject; leading axes are (variants ..., states).

    What the application gives no grounds for is nan, and no limit applies to it.
    """

    inputs: LineInputs

    @property
    def application(self) -> Application:
        """The application that the line is of."""
        return self.inputs.application

    @property
    def demand(self) -> LineStateDemand:
        """What the vehicle requires of the line in each state."""
        return self.inputs.demand

    @property
    def layout(self) -> Layout:
        """Where the line runs."""
        return self.inputs.layout

    @property
    def phases(self) -> FloatArray:
        """Yoke phases of the shafts, (..., n-1) rad."""
        return self.inputs.phases

    @property
    def line(self) -> Line:
        """The line this is about."""
        return self.inputs.line

    @property
    def joint_sizes(self) -> tuple[JointSize | None, ...]:
        """The catalogue's size of each joint, None where it is not given."""
        return self.inputs.joint_sizes

    @property
    def state_kinds(self) -> tuple[str, ...]:
        """The kind of each state, as limits know it."""
        return self.inputs.state_kinds

    @property
    def joint_angles(self) -> FloatArray:
        """True joint angles, (..., n) rad."""
        return self.inputs.joint_angles

    def layout_for(self, demand: LineStateDemand) -> Layout:
        """Return where the line runs at other torques: bearings and axle moved like here."""
        return self.inputs.layout_for(demand)

    def with_inputs(self, **changes: Any) -> "LineResponse":
        """Return the response of a line with some of its `LineInputs` replaced."""
        return LineResponse(inputs=replace(self.inputs, **changes))

    @cached_property
    def kinematics(self) -> LineKinematics:
        """Angles of the joints, and the excitation by them."""
        return LineKinematics(inputs=self.inputs)

    @cached_property
    def rigid_loads(self) -> RigidLineLoads:
        """Forces and moments with rigid centre bearings."""
        return RigidLineLoads(inputs=self.inputs)

    @cached_property
    def mounts(self) -> LineOnMounts:
        """How the line moves on the rubber of its centre bearings."""
        return LineOnMounts(inputs=self.inputs)

    @cached_property
    def mount_loads(self) -> MountLoads:
        """What its centre bearings carry where that is worst."""
        return MountLoads(mounts=self.mounts, rigid_loads=self.rigid_loads)

    @cached_property
    def strength(self) -> LineStrength:
        """Critical speeds, utilisations and life of tubes and joints."""
        return LineStrength(inputs=self.inputs, rigid_loads=self.rigid_loads)

    @cached_property
    def clearances(self) -> LineClearances:
        """Free distance of obstacles, and travel of the sliding fit."""
        return LineClearances(inputs=self.inputs)

    @cached_property
    def operating_envelope(self) -> "OperatingEnvelope | None":
        """The line at the corners of its torque over speed; None where they are unknown."""
        found = envelope_points(self.demand, self.mounts.demand_torque_curves)
        if found is None:
            return None
        points, demand = found
        there = self.with_inputs(demand=demand, layout=self.layout_for(demand))
        return OperatingEnvelope(points=points, response=there)

    @cached_property
    def axle_loads(self) -> tuple[FloatArray, FloatArray]:
        """Load of every axle of the vehicle at rest and at the slip limit, (..., axles) N each."""
        return individual_axle_loads_by_state(self.demand.static_state.line)

    @cached_property
    def axle_to_frame(self) -> FloatArray:
        """From the axle's centre up to the frame, (...) m; nan where it is not given."""
        suspension = self.demand.static_state.line.suspension
        given = suspension.axle_to_frame if suspension else None
        return (np.nan if given is None else given) - self.demand.travel


@dataclass(frozen=True, kw_only=True, eq=False)
class OperatingEnvelope:
    """A line at the points where what follows torque, speed and angles is worst.

    Attributes
    ----------
    points : (P, ..., S)
    response
        The line there: points on its first axis, then variants (one where there are none),
        the states last.
    """

    points: LineOperatingPoints
    response: LineResponse


def deflected_line(response: LineResponse) -> LineResponse:
    """Return a line as its torque leaves it: shafts twisted, bearings moved on their rubber.

    The bearings at each operating point; of a line that has none they hang where they did. Its
    angles are to be used: forces on rubber are those of a line before its rubber gives.
    """
    held, inputs = response.mounts.mounted_line, response.inputs

    def lay(of: LineStateDemand) -> Layout:
        laid = inputs.layout_for(of)
        if held is None:
            return laid
        torque = np.nan_to_num(of.torque)
        return layout_settled_under_torque(
            laid, inputs.line, inputs.phases, torque=torque, held=held
        )

    return response.with_inputs(layout_for=lay, twisted_by_torque=True)


def compute_line_response(
    application: Application,
    demand: LineStateDemand,
    *,
    lay: Callable[[LineStateDemand], Layout] = layout_of_demand,
    phases: ArrayLike | None = None,
) -> LineResponse:
    """Return the response of a line, as installed or moved, and with other yoke phases.

    `lay` says where the line runs, (..., S), at the torques of a demand: as its own layout, or
    with bearings and axle moved (`LineStateDemand.corrected_layout`). That and `phases` (..., n-1)
    may bring variants on axes before the states; give the phases of V variants as (V, 1, n-1).
    """
    line = demand.installed.line
    return LineResponse(
        inputs=LineInputs(
            application=application,
            demand=demand,
            layout=lay(demand),
            layout_for=lay,
            phases=stack_on_last_axis(line.phases)
            if phases is None
            else np.asarray(phases, dtype=float),
        )
    )
