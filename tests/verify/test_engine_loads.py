"""Loads round a turn against two multibody engines, EXUDYN and Drake, 3-D and with odd phases.

Both know rigid bodies, pins, bearings and a spline and nothing of this program's equations.
EXUDYN has every cross as a body and reports its constraints (`crosses.py`). Drake places
the line (`engine.py`), and its Jacobians say what the frame must hold (`frame.py`).
"""

import numpy as np
import pytest

from cardan.model.layout import Layout, layout_from_slopes
from cardan.model.parts import CentreBearing, Line, Shaft
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.loads.statics import JointLoads, joint_loads

SAMPLES = 16

# Side and top slopes in deg, shaft lengths in m, yoke phases in deg, bearings ahead of the
# rear joint in m, floating gearbox flange.
CHAINS = {
    "two shafts, aligned": ([3, 1, 4.5, 2], [0, 1.5, -0.8, 0.6], [1.2, 1.5], [0, 0], [0], False),
    "two shafts, floating flange": (
        [3, 1, 4.5, 2], [0, 1.5, -0.8, 0.6], [1.2, 1.5], [0, 0], [0], True,
    ),
    "two shafts, odd phases, bearing ahead": (
        [5, -2, 6, 1], [2, -4, 3, -1], [1.4, 1.1], [17, -38], [0.21], False,
    ),
    "the same, floating": ([5, -2, 6, 1], [2, -4, 3, -1], [1.4, 1.1], [17, -38], [0.21], True),
    "one shaft": ([2, 7, 3], [1, -3, 2], [1.7], [5], [], False),
    "one shaft, floating, crossed": ([2, 7, 3], [1, -3, 2], [1.7], [90], [], True),
    "three shafts": (
        [4, 0, 3, 8, 5], [-1, 2, 0, -3, 1], [1.1, 0.9, 1.6], [90, 3, -61], [0.14, 0.3], False,
    ),
    "three shafts, steep, floating": (
        [12, -8, 15, -4, 9], [-10, 6, 14, -13, 2], [1, 1.3, 1.2], [33, 71, -12], [0, 0.25], True,
    ),
}  # fmt: skip


def placed(
    side: list[float],
    top: list[float],
    lengths: list[float],
    phases: list[float],
    overhangs: list[float],
    floating: bool,
) -> tuple[Layout, Line]:
    layout = layout_from_slopes(side=np.radians(side), top=np.radians(top), lengths=lengths)
    bearings = [*(CentreBearing(from_rear_joint=x) for x in overhangs), None]
    shafts = tuple(
        Shaft(length=length, phase=np.radians(phase), centre_bearing=bearing)
        for length, phase, bearing in zip(lengths, phases, bearings, strict=True)
    )
    return layout, Line(shafts=shafts, axial_freedom="gearbox_flange" if floating else "last_shaft")


@pytest.fixture(params=CHAINS.values(), ids=CHAINS.keys())
def chain(request: pytest.FixtureRequest) -> tuple[Layout, Line]:
    return placed(*request.param)


def ours(layout: Layout, line: Line) -> JointLoads:
    return joint_loads(
        layout, rotate_chain(layout.directions, phases=line.phases), line, torque=1.0
    )


def overhangs(line: Line) -> list[float]:
    return [s.centre_bearing.from_rear_joint for s in line.shafts if s.centre_bearing]


def assert_same(found: np.ndarray, engine: np.ndarray) -> None:
    """Hold to 1e-9 of the largest; what is left is the engine's Newton, about 1e-12."""
    if engine.size:
        assert found == pytest.approx(engine, rel=0, abs=1e-9 * np.abs(engine).max())
    else:
        assert found.size == 0


@pytest.mark.oracle
def test_loads_match_exudyn(chain: tuple[Layout, Line]) -> None:
    from crosses import Crosses

    layout, line = chain
    engine = Crosses(
        layout.points,
        layout.directions,
        line.phases,
        overhangs(line),
        floating=line.axial_freedom == "gearbox_flange",
    ).turned(SAMPLES)
    found = ours(layout, line)
    assert_same(found.bearing_forces.values(SAMPLES), engine.bearings)
    assert_same(found.joint_forces.values(SAMPLES), engine.joints)
    assert_same(found.joint_moments.values(SAMPLES), engine.moments)
    assert_same(found.torques.values(SAMPLES)[-1, :, 0], engine.pinion)


@pytest.mark.oracle
def test_loads_match_virtual_power_in_drake(chain: tuple[Layout, Line]) -> None:
    from engine import Mechanism
    from frame import held

    layout, line = chain
    mechanism = Mechanism(layout.points, layout.directions, line.phases)
    floating = line.axial_freedom == "gearbox_flange"
    reactions = []
    for theta in 2 * np.pi * np.arange(SAMPLES) / SAMPLES:
        mechanism.place(theta)
        reactions.append(held(mechanism, overhangs(line), floating=floating))
    bearings, force, moment = (np.array(x) for x in zip(*reactions, strict=True))
    found = ours(layout, line)
    assert_same(np.swapaxes(found.bearing_forces.values(SAMPLES), 0, 1), bearings)
    assert_same(found.pinion_force.values(SAMPLES), force)
    assert_same(found.pinion_moment.values(SAMPLES), moment)


@pytest.mark.oracle
@pytest.mark.parametrize("name", ["two shafts, odd phases, bearing ahead", "three shafts"])
def test_inertia_loads_match_exudyn_and_drake(name: str) -> None:
    """No torque at all, so that the masses the engine gives its bodies are all there is."""
    from engine import Mechanism
    from frame import held, masses_take

    layout, line = placed(*CHAINS[name])
    mechanism = Mechanism(layout.points, layout.directions, line.phases)
    spin = rotate_chain(layout.directions, phases=line.phases)

    def polar(name: str) -> float:
        body = mechanism.plant.GetBodyByName(name)
        inertia = body.CalcSpatialInertiaInBodyFrame(mechanism.context)
        return inertia.CalcRotationalInertia().get_moments()[2]

    inertias = np.array([polar(f"member {k}") for k in range(1, len(layout.points))])
    inertias[-1] += polar("spline")
    found = joint_loads(
        layout, spin, line, torque=0.0, inertias=inertias, accelerations=spin.acceleration
    )
    bearings, forces = [], []
    for theta in spin.theta:
        spent = masses_take(mechanism, theta)
        bearing, force, _ = held(mechanism, overhangs(line), torque=0.0, spent=spent)
        bearings.append(bearing)
        forces.append(force)
    samples = len(spin.theta)
    assert_same(np.swapaxes(found.bearing_forces.values(samples), 0, 1), np.array(bearings))
    assert_same(found.pinion_force.values(samples), np.array(forces))
