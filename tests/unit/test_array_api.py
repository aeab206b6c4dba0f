"""The kinematics on another array library: the strictest there is gives NumPy's numbers."""

from dataclasses import fields, is_dataclass
from pathlib import Path

import array_api_strict as strict
import numpy as np
import pytest

from cardan import files
from cardan.base.arrays import chunked, floats, namespace
from cardan.demand.states import demand, resolve
from cardan.kinematics import equivalent, joint
from cardan.kinematics.chain import joint_angles, turn
from cardan.loads.statics import loads
from cardan.model.layout import Layout, unit

EXAMPLES = Path(__file__).parents[2] / "examples"

RNG = np.random.default_rng(4)
BETA, THETA = RNG.uniform(0, 0.6, 6), RNG.uniform(-9, 9, 6)
SIDE, TOP = RNG.uniform(-0.1, 0.1, (2, 6, 4))
WAY = unit([1.0, 0, 0] + 0.2 * RNG.uniform(-1, 1, (6, 5, 3)))
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
        assert namespace(found) is strict
        assert np.asarray(found) == pytest.approx(wanted, rel=1e-12, abs=1e-15)


def both(function, *arrays):
    return function(*map(strict.asarray, arrays)), function(*arrays)


@pytest.mark.parametrize(
    "of",
    [
        joint.speed_range,
        joint.irregularity,
        joint.angle_for_irregularity,
        joint.lead_orders,
        joint.lead_amplitude,
        joint.equal_speed_angles,
        joint.max_acceleration_angles,
        *joint.MAX_ACCELERATION.values(),
    ],
)
def test_joints_by_angle(of):
    assert_same(*both(of, BETA))


@pytest.mark.parametrize(
    ("of", "given"),
    [
        (joint.lead, {}),
        (joint.output_angle, {"pin": joint.NORMAL}),
        (joint.speed_ratio, {}),
        (joint.acceleration, {"speed": 3.0, "input_acceleration": 5.0}),
        (joint.output_torque, {"torque": 100.0}),
        (joint.cross_motion, {"speed": 3.0}),
    ],
)
def test_joints_round_the_turn(of, given):
    assert_same(*both(lambda theta, beta: of(theta, beta=beta, **given), THETA, BETA))


@pytest.mark.parametrize(
    "what", ["lead", "speed", "acceleration", "coast_acceleration", "driving_pins", "theta"]
)
def test_chains(what):
    assert_same(*both(lambda d, p: getattr(turn(d, phases=p), what), WAY, PHASES))


def test_joint_angles():
    assert_same(*both(joint_angles, WAY))


def test_exact_excitation():
    def of(d, phases, inertias):
        return equivalent.excitation(turn(d, phases=phases), speed=200.0, inertias=inertias)

    assert_same(*both(of, WAY, PHASES, INERTIAS))


@pytest.mark.parametrize("of", equivalent.APPROXIMATIONS.values())
def test_approximate_excitation(of):
    def at_speed(side, top, phases, inertias):
        return of(side, top, phases=phases, speed=200.0, inertias=inertias)

    assert_same(*both(at_speed, SIDE, TOP, PHASES, INERTIAS))


@pytest.mark.parametrize("of", [*equivalent.TRUE_ANGLE.values(), equivalent.position])
def test_view_angles(of):
    assert_same(*both(of, SIDE, TOP))


def test_chunks():
    assert_same(*both(lambda d, p: chunked(turn_phasors, d, p, size=4), WAY, PHASES))


def turn_phasors(d, phases):
    return turn(d, phases=phases).phasors


@pytest.mark.parametrize("name", ["refuse-collector-6x2", "composite-van", "three-joint-chain"])
def test_from_where_a_line_runs_to_what_its_bearings_carry(name):
    """End to end: a truck's layouts in its states and its torques, in NumPy's place."""
    truck = files.read(EXAMPLES / f"{name}.yaml")
    asked = demand(resolve(truck, truck.lines[0]))
    line = truck.lines[0].line

    def carried(points, directions, phases, torque):
        lies = Layout(points=points, directions=directions)
        turned = turn(directions, phases=phases, crosses=line.crosses, samples=16)
        found = loads(lies, turned, line, torque=torque)
        angles = equivalent.excitation(turned, speed=1.0, inertias=0 * phases + 0.1).torsional
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


def test_numbers_join_the_library_of_the_arrays():
    xp, number, array = floats(2, strict.asarray([1.0]))
    assert xp is strict
    assert namespace(number) is namespace(array) is strict
    assert floats(2)[0] is floats([1, 2])[0] is np
