#!/usr/bin/env bash
# EXUDYN 1.13.6: ComputeODE2Eigenvalues leaves out the stiffness that a constraint's force gives.
#
# Valid input: a pendulum, a mass of 2 kg hung 1 m below ground, at rest; once on a DistanceConstraint,
# once on a stiff spring drawn by the weight.
#
# Guess: g/l = 9.81 (rad/s)^2 of both, as integration in time has it. The function's text says that
# eigenvalues are those of the constrained system, on the kernel of the constraint's Jacobian.
#
# Seen: 9.81 and k/m on the spring; 0 on the constraint, also after an integration that leaves the
# constraint's force, 19.6 N, in the system's state. Integration gives 9.81 of both. No warning.
#
# So modes of a line whose joints or spline are constraints miss what tension or thrust adds to or takes
# off its stiffness, buckling too. Model the part that carries the force as a stiff spring for modes, or
# read frequencies off a small free swing.
#
# Run by hand: bash findings/exudyn_constraint_stiffness.sh. Needs Python 3.11 or later and a package
# index. It fails if the output is another one.
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
python3 -m venv "$here/venv"
"$here/venv/bin/pip" install --quiet exudyn==1.13.6 numpy==2.4.6 scipy==1.17.1
cd "$here"
"$here/venv/bin/python" -W ignore > seen <<'PYTHON'
import exudyn
import numpy as np
from exudyn import itemInterface as item

MASS, LENGTH, G, STIFFNESS = 2.0, 1.0, 9.81, 1e7


def pendulum(kind, aside):
    """Return a system, its container and the sensor of its mass, hung on a constraint or a spring."""
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    ground = system.AddObject(item.ObjectGround())
    top = system.AddMarker(item.MarkerBodyPosition(bodyNumber=ground, localPosition=[0, 0, 0]))
    down = np.sqrt(LENGTH**2 - aside**2)
    node = system.AddNode(item.Point2D(referenceCoordinates=[aside, -down]))
    body = system.AddObject(item.MassPoint2D(mass=MASS, nodeNumber=node))
    below = system.AddMarker(item.MarkerBodyPosition(bodyNumber=body, localPosition=[0, 0, 0]))
    if kind == "constraint":
        system.AddObject(item.DistanceConstraint(markerNumbers=[top, below], distance=LENGTH))
    else:
        slack = LENGTH - MASS * G / STIFFNESS
        system.AddObject(item.SpringDamper(
            markerNumbers=[top, below], referenceLength=slack, stiffness=STIFFNESS))
    system.AddLoad(item.Force(markerNumber=below, loadVector=[0, -MASS * G, 0]))
    sensor = system.AddSensor(item.SensorBody(
        bodyNumber=body, outputVariableType=exudyn.OutputVariableType.Position, storeInternal=True))
    system.Assemble()
    return system, container, sensor


def integrated(system):
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.endTime = 10
    settings.timeIntegration.numberOfSteps = 10000
    settings.timeIntegration.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = 1e-3
    system.SolveDynamic(settings, updateInitialValues=True)


for kind in ("constraint", "spring"):
    system, container, _ = pendulum(kind, 0.0)
    text = ", ".join(f"{value:.2f}" for value in system.ComputeODE2Eigenvalues()[0])
    integrated(system)
    after = ", ".join(f"{value:.2f}" for value in system.ComputeODE2Eigenvalues()[0])
    force = system.systemData.GetAECoordinates()
    system, container, sensor = pendulum(kind, 0.01)
    integrated(system)
    time, x = system.GetSensorStoredData(sensor)[:, :2].T
    up = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
    crossed = time[up] - x[up] * (time[up + 1] - time[up]) / (x[up + 1] - x[up])
    swing = (2 * np.pi / np.diff(crossed).mean()) ** 2
    held = f", its force {force[0]:.1f} N" if len(force) else ""
    print(f"{kind}: {text}; after integration {after}{held}; swing in time {swing:.2f}")
PYTHON
cat > expected <<'TEXT'
constraint: 0.00; after integration 0.00, its force 19.6 N; swing in time 9.81
spring: 9.81, 5000000.00; after integration 9.81, 5000000.00; swing in time 9.81
TEXT
diff expected seen
