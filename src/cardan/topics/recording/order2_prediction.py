"""What an application predicts of a recording: the joints' order 2 at a gauge."""

import numpy as np

from cardan.checks.line_response import compute_line_response
from cardan.core.arrays import ComplexArray, FloatArray
from cardan.core.errors import DesignError
from cardan.model.application import Application
from cardan.physics.signals.damage_attribution import stress_per_torque
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references


def order2_bearing_force_per_torque(
    application: Application, *, state: str, bearing: int = 1, line: str | None = None
) -> ComplexArray:
    """Order-2 force on a centre bearing per torque of the gearbox output, (3,) N per N m.

    Vehicle axes, complex amplitude. The loads are linear in torque, so the state only sets
    the geometry.

    Raises
    ------
    DesignError
        If there is no such line, state or bearing, or the state carries no torque.
    """
    names = [installed.line.name for installed in application.lines]
    if line is not None and line not in names:
        msg = f"no line {line!r}; there are: {', '.join(names)}"
        raise DesignError(msg)
    installed = application.lines[0 if line is None else names.index(line)]
    asked = line_state_demand(resolve_line_references(application, installed))
    if state not in asked.states:
        msg = f"no state {state!r}; there are: {', '.join(asked.states)}"
        raise DesignError(msg)
    row = asked.states.index(state)
    response = compute_line_response(application, asked)
    forces = response.rigid_loads.joint_loads.bearing_forces.order(2)[row]
    if not 1 <= bearing <= len(forces):
        msg = f"line {installed.line.name} has {len(forces)} centre bearings, not a {bearing}."
        raise DesignError(msg)
    torque = float(np.broadcast_to(asked.torque, len(asked.states))[row])
    if not abs(torque) > 0:
        msg = f"state {state!r} carries no torque"
        raise DesignError(msg)
    return forces[bearing - 1] / torque


def order2_stress_per_torque(
    application: Application, *, unit_stress: FloatArray, state: str, bearing: int = 1,
    line: str | None = None,
) -> float:  # fmt: skip
    """Order-2 stress amplitude at a gauge per torque of the gearbox output, Pa per N m.

    `unit_stress` (3,) Pa/N is the stress at the gauge under a unit force of the bearing on
    the bracket along each vehicle axis, from a finite-element model or a calibration.
    """
    force = order2_bearing_force_per_torque(application, state=state, bearing=bearing, line=line)
    return float(stress_per_torque(force, unit_stress))
