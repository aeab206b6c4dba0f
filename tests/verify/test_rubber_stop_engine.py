"""Rubber at its stop against EXUDYN: one mass stepped through time, from low speeds and from many.

METHOD, section 20: 398 N of order 2 on a mean of 2020 N, rubber of 200 N/mm with its stop at
15 mm, 10.4 Hz. It prints 6.5 and 8.9 kN at 12 Hz for a stop 5 and 20 times as stiff, 5.1 and
7.5 kN at the linear resonance. The engine has 6.85 and 7.82, 4.86 and 5.88 kN, from any start.
A stop's damper loses as much at order 2 as its stiffness times the rubber's loss factor; without
that damper it is 7.5 and 8.6 kN at 12 Hz, 5.0 and 6.1 at 10.4 Hz.
"""

from collections.abc import Sequence

import numpy as np
import pytest
from case_selection import long
from one_mass_at_stop import LOSS, MASS, STEADY, STIFFNESS, STOP, SWING, crests, elastic, one_mass

from cardan.physics.loads.rubber_stop_response import followed_motion

pytestmark = [
    pytest.mark.oracle,
    pytest.mark.filterwarnings("ignore"),  # the engine's own deprecations
]

STEPS, PERIODS = 300, 25


def settled(frequency: float, ratio: float, start: Sequence[float]) -> np.ndarray:
    """Return places and speeds (2, steps) of the engine's mass in its last two periods."""
    import exudyn as exu
    from exudyn import itemInterface

    mbs, W = exu.SystemContainer().AddSystem(), 2 * np.pi * frequency
    node = mbs.AddNode(
        itemInterface.Node1D(
            referenceCoordinates=[0.0],
            initialCoordinates=[float(start[0])],
            initialVelocities=[float(start[1])],
        )
    )
    mbs.AddObject(itemInterface.Mass1D(physicsMass=MASS, nodeNumber=node))
    ground = mbs.AddNode(itemInterface.NodePointGround())
    ends = [
        mbs.AddMarker(itemInterface.MarkerNodeCoordinate(nodeNumber=n, coordinate=0))
        for n in (ground, node)
    ]

    def rubber(_system, _time, _item, x, v, *_):
        slope = STIFFNESS * (ratio if abs(x) > STOP else 1.0)
        return float(elastic(np.array(x), ratio)) + LOSS * slope / W * v

    mbs.AddObject(
        itemInterface.CoordinateSpringDamper(markerNumbers=ends, springForceUserFunction=rubber)
    )
    mbs.AddLoad(
        itemInterface.LoadCoordinate(
            markerNumber=ends[1],
            load=1.0,
            loadUserFunction=lambda _system, t, _load: STEADY + SWING * np.cos(W * t),
        )
    )
    kinds = exu.OutputVariableType.Coordinates, exu.OutputVariableType.Coordinates_t
    watched = [
        mbs.AddSensor(
            itemInterface.SensorNode(
                nodeNumber=node, outputVariableType=kind, storeInternal=True, writeToFile=False
            )
        )
        for kind in kinds
    ]
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = STEPS * PERIODS
    settings.timeIntegration.endTime = PERIODS / frequency
    settings.timeIntegration.generalizedAlpha.spectralRadius = 1
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 1e-6 / frequency  # every step
    mbs.Assemble()
    mbs.SolveDynamic(settings)
    return np.array([mbs.GetSensorStoredData(s)[-2 * STEPS :, 1] for s in watched])


@pytest.mark.parametrize(("ratio", "tolerance"), [(5.0, 0.01), (20.0, 0.015)])
def test_force_at_stop_matches_exudyn_in_run_up(ratio, tolerance):
    """The motion kept from one frequency to the next: it goes up the branch of the larger one."""
    line = one_mass(ratio)
    at, force = crests(line, followed_motion(line))
    state = np.array([STEADY / STIFFNESS, 0.0])
    for f in (10.4, 11.0, 12.0, 12.5):
        found = settled(f, ratio, state)
        state = found[:, -1]
        near = np.abs(at - f) < 0.06
        expected = elastic(found[0], ratio).max()
        assert np.interp(f, at[near], force[near]) == pytest.approx(expected, rel=tolerance)


@pytest.mark.parametrize(
    ("ratio", "frequency"), [(20.0, 12.0), *long((5.0, 10.4), (5.0, 12.0), (20.0, 10.4))]
)
def test_no_start_reaches_a_larger_force_in_exudyn(ratio, frequency):
    """Thrown from both sides: every start ends in one motion at these frequencies."""
    line = one_mass(ratio)
    at, force = crests(line, followed_motion(line))
    near = np.abs(at - frequency) < 0.06
    found = np.interp(frequency, at[near], force[near])
    for start in ((0.03, 0.0), (-0.02, 2.0), (0.0, -3.0), (0.01, 3.0)):
        reached = elastic(settled(frequency, ratio, start)[0], ratio).max()
        assert reached == pytest.approx(found, rel=0.02)
