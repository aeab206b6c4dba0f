"""The kinematics on another array library: the strictest there is gives NumPy's numbers."""

from dataclasses import fields, is_dataclass

import array_api_strict as strict
import numpy as np
import pytest
from repository import EXAMPLES

from cardan.application import reader
from cardan.core.arrays import array_library_and_floats, array_namespace, in_chunks
from cardan.model.layout import Layout, unit_vector
from cardan.physics.kinematics import equivalent_angle as equivalent
from cardan.physics.kinematics import hooke_joint as joint
from cardan.physics.kinematics.joint_chain import joint_angles, rotate_chain
from cardan.physics.loads.statics import joint_loads
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

RNG = np.random.default_rng(4)
BETA, THETA = RNG.uniform(0, 0.6, 6), RNG.uniform(-9, 9, 6)
SIDE, TOP = RNG.uniform(-0.1, 0.1, (2, 6, 4))
WAY = unit_vector([1.0, 0, 0] + 0.2 * RNG.uniform(-1, 1, (6, 5, 3)))
PHASES, INERTIAS = RNG.uniform(-3, 3, (6, 3)), RNG.uniform(0.01, 0.2, (6, 3))


def assert_same(found, wanted):
    if wanted is None or isinstance(wanted, int):
        assert found == wanted
    elif is_dataclass(wanted):
        for field in fields(wanted):
            assert_same(getattr(found, field.name), getattr(wanted, field.name))
    elif isinstance(wanted, tuple):
        for one, other in zip(found, wanted, strict=True):
            assert_same(one, other)
    else:
        assert array_namespace(found) is strict
        assert np.asarray(found) == pytest.approx(wanted, rel=1e-12, abs=1e-15)


def both(function, *arrays):
    return function(*map(strict.asarray, arrays)), function(*arrays)


@pytest.mark.parametrize(
    "of",
    [
        joint.speed_range,
        joint.irregularity,
        joint.angle_for_irregularity,
        joint.angle_lead_amplitude,
        joint.equal_speed_angles,
        joint.max_acceleration_angles,
        *joint.MAX_ACCELERATION_FORMULAS.values(),
    ],
)
def test_joint_functions_of_angle_match_numpy(of):
    assert_same(*both(of, BETA))


@pytest.mark.parametrize(
    ("of", "given"),
    [
        (joint.angle_lead, {}),
        (joint.output_angle, {"pin": joint.PIN_NORMAL_TO_PLANE}),
        (joint.speed_ratio, {}),
        (joint.output_acceleration, {"speed": 3.0, "input_acceleration": 5.0}),
        (joint.cross_motion, {"speed": 3.0}),
    ],
)
def test_joint_functions_over_one_turn_match_numpy(of, given):
    assert_same(*both(lambda theta, beta: of(theta, beta=beta, **given), THETA, BETA))


@pytest.mark.parametrize(
    "what", ["lead", "speed", "acceleration", "coast_acceleration", "driving_pins", "theta"]
)
def test_joint_chain_matches_numpy(what):
    assert_same(*both(lambda d, p: getattr(rotate_chain(d, phases=p), what), WAY, PHASES))


def test_joint_angles_match_numpy():
    assert_same(*both(joint_angles, WAY))


def test_exact_excitation_matches_numpy():
    def of(d, phases, inertias):
        return equivalent.excitation_of_rotating_chain(
            rotate_chain(d, phases=phases), speed=200.0, inertias=inertias
        )

    assert_same(*both(of, WAY, PHASES, INERTIAS))


@pytest.mark.parametrize("of", equivalent.EXCITATION_APPROXIMATIONS.values())
def test_approximate_excitation_matches_numpy(of):
    def at_speed(side, top, phases, inertias):
        return of(side, top, phases=phases, speed=200.0, inertias=inertias)

    assert_same(*both(at_speed, SIDE, TOP, PHASES, INERTIAS))


@pytest.mark.parametrize(
    "of", [*equivalent.TRUE_ANGLE_FORMULAS.values(), equivalent.joint_plane_angle]
)
def test_view_angles_match_numpy(of):
    assert_same(*both(of, SIDE, TOP))


def test_chunked_phasors_match_numpy():
    assert_same(*both(lambda d, p: in_chunks(turn_phasors, d, p, size=4), WAY, PHASES))


def turn_phasors(d, phases):
    return rotate_chain(d, phases=phases).phasors


@pytest.mark.parametrize("name", ["refuse-collector-6x2", "composite-van", "three-joint-chain"])
def test_bearing_forces_of_example_match_numpy(name):
    """End to end: a truck's layouts in its states and its torques, in NumPy's place."""
    truck = reader.read(EXAMPLES / f"{name}.yaml")
    asked = line_state_demand(resolve_line_references(truck, truck.lines[0]))
    line = truck.lines[0].line

    def carried(points, directions, phases, torque):
        lies = Layout(points=points, directions=directions)
        turned = rotate_chain(directions, phases=phases, crosses=line.is_cross, samples=16)
        found = joint_loads(lies, turned, line, torque=torque)
        angles = equivalent.excitation_of_rotating_chain(
            turned, speed=1.0, inertias=0 * phases + 0.1
        ).torsional
        bearings, ends = found.bearing_forces, found.joint_forces
        return (
            joint_angles(directions), angles.angle, angles.acceleration,
            bearings.static, bearings.dynamic, ends.static, ends.dynamic,
        )  # fmt: skip

    given = (
        asked.layout.points, asked.layout.directions, np.array(line.phases, dtype=float),
        np.nan_to_num(asked.torque),
    )  # fmt: skip
    assert_same(*both(carried, *map(np.ascontiguousarray, given)))


def test_scalars_use_the_namespace_of_the_arrays():
    xp, number, array = array_library_and_floats(2, strict.asarray([1.0]))
    assert xp is strict
    assert array_namespace(number) is array_namespace(array) is strict
    assert array_library_and_floats(2)[0] is array_library_and_floats([1, 2])[0] is np
