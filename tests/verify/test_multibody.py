"""Growth rates from EXUDYN, a 3-D multibody engine that knows no Floquet theory.

Each model is built of rigid bodies, a cross with its two pins, springs and torques. Two runs
from slightly different starts are compared once every half turn; the matrix that best maps
each difference to the next is the monodromy matrix, its eigenvalues the multipliers.
"""

import numpy as np
import pytest

from cardan.core.units import deg
from cardan.physics.dynamics.floquet import differentiation_matrix, floquet_multipliers, growth_rate
from cardan.physics.dynamics.lateral import misaligned_shaft_system, rigid_shaft_system
from cardan.physics.dynamics.torsional_line import (
    TorsionalLine,
    linearised_about_periodic_motion,
    periodic_motion,
)

pytestmark = [
    pytest.mark.oracle,
    pytest.mark.filterwarnings("ignore"),  # the engine's own deprecations
]

STEPS = 240
FLYWHEEL = 1e6


def frame(axis, pin):
    """Rotation matrix whose z is `axis` and whose x is `pin`."""
    return np.stack([pin, np.cross(axis, pin), axis], axis=-1)


class Machine:
    """A system of bodies that all turn about points on the line through the origin."""

    def __init__(self):
        import exudyn as exu

        self.exu = exu
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.ground = self.mbs.CreateGround()
        self.sensors = []

    def body(self, axis, pin, inertia, spin, mass=1e-3):
        """Add a body (transverse, polar inertia) with its axes and angular velocity."""
        from exudyn.utilities import RigidBodyInertia

        transverse, polar = inertia
        tensor = RigidBodyInertia(mass=mass, inertiaTensor=np.diag([transverse, transverse, polar]))
        return self.mbs.CreateRigidBody(
            inertia=tensor, nodeType=self.exu.NodeType.RotationEulerParameters,
            referencePosition=[0.0, 0.0, 0.0], referenceRotationMatrix=frame(axis, pin),
            initialAngularVelocity=list(spin),
        )  # fmt: skip

    def hinge(self, a, b, axis):
        self.mbs.CreateRevoluteJoint(
            itemNumbers=[a, b], position=[0.0, 0.0, 0.0], axis=list(axis), useGlobalFrame=True
        )

    def hold(self, a, b, axes, rotation=None):
        rotation = np.eye(3) if rotation is None else rotation
        self.mbs.CreateGenericJoint(
            itemNumbers=[a, b], position=[0.0, 0.0, 0.0], rotationMatrixAxes=rotation,
            constrainedAxes=axes, useGlobalFrame=True,
        )  # fmt: skip

    def spring(self, a, b, stiffness, damping):
        """Torsional spring about the bodies' common z, unstressed as placed."""
        from exudyn.utilities import MarkerBodyRigid, ObjectConnectorTorsionalSpringDamper

        markers = [self.mbs.AddMarker(MarkerBodyRigid(bodyNumber=k)) for k in (a, b)]
        self.mbs.AddObject(
            ObjectConnectorTorsionalSpringDamper(
                markerNumbers=markers, stiffness=stiffness, damping=damping
            )
        )

    def watch(self, body):
        """Record rotation matrix and angular velocity."""
        from exudyn.utilities import SensorBody

        for kind in ("RotationMatrix", "AngularVelocity"):
            self.sensors.append(
                self.mbs.AddSensor(
                    SensorBody(
                        bodyNumber=body, storeInternal=True,
                        outputVariableType=getattr(self.exu.OutputVariableType, kind),
                    )
                )
            )  # fmt: skip

    def run(self, period, count):
        """Integrate and return (count+1, columns) of each sensor, once a period."""
        self.mbs.Assemble()
        settings = self.exu.SimulationSettings()
        settings.timeIntegration.numberOfSteps = STEPS * count
        settings.timeIntegration.endTime = period * count
        settings.timeIntegration.generalizedAlpha.spectralRadius = 1
        settings.timeIntegration.generalizedAlpha.useNewmark = True
        settings.timeIntegration.generalizedAlpha.useIndex2Constraints = True
        settings.timeIntegration.newton.useModifiedNewton = False
        settings.timeIntegration.newton.relativeTolerance = 1e-6
        settings.timeIntegration.newton.absoluteTolerance = 1e-8
        settings.timeIntegration.verboseMode = 0
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = 1e-9 * period  # every step
        self.mbs.SolveDynamic(settings)
        stored = [self.mbs.GetSensorStoredData(s) for s in self.sensors]
        assert all(len(s) == STEPS * count + 1 for s in stored)
        return [s[::STEPS, 1:] for s in stored]


def mapped(states):
    """Eigenvalues of the matrix that best maps each row of (n, d) to the next."""
    # Growing rows count alike: each pair is scaled by its own size.
    before, after = states[:-1], states[1:]
    size = np.linalg.norm(before, axis=1, keepdims=True)
    P, *_ = np.linalg.lstsq(before / size, after / size, rcond=None)
    return np.linalg.eigvals(P)


# ----- torsion


def turned(matrix, axis, pin):
    """Rotation about `axis` since placed, from recorded rotation matrices (n, 9)."""
    now = matrix.reshape(-1, 3, 3)[:, :, 0]
    return np.unwrap(np.arctan2(now @ np.cross(axis, pin), now @ pin), period=np.pi)


def swung(axis, pin, angle):
    """Return the pin turned about an axis it is square to."""
    return np.cos(angle) * pin + np.sin(angle) * np.cross(axis, pin)


def torsion_run(line, speed, count, push):
    """Flywheel, spring, driving side, cross, driven side, and a spring and inertia behind it.

    Starts on the forced orbit, its rates pushed off it a little.
    """
    start = periodic_motion(line, np.array(speed))
    q, v = start.rotation[0], start.rate[0] + np.array(push[: line.size])
    beta = float(line.beta[0])
    d0, d1 = np.array([0.0, 0, 1]), np.array([0, np.sin(beta), np.cos(beta)])
    level = np.array([0.0, 1, 0])  # in the plane of the shafts: theta = 0
    a = swung(d0, level, q[0])
    b = np.cross(d1, a) / np.linalg.norm(np.cross(d1, a))
    rest = np.array([-1.0, 0, 0])  # where b is at theta = 0
    # Cross: w1 d0 + s a = w2 d1 + r b.
    w2, _, s = np.linalg.solve(np.stack([d1, b, -a], axis=-1), v[0] * d0)
    small = 1e-5
    inertia = lambda J: (max(float(J), small),) * 2  # noqa: E731
    machine = Machine()
    wheel = machine.body(d0, level, (FLYWHEEL, FLYWHEEL), speed * d0)
    first = machine.body(d0, a, inertia(line.driving[0]), v[0] * d0)
    cross = machine.body(np.cross(a, b), a, (small, small), v[0] * d0 + s * a)
    second = machine.body(d1, b, inertia(line.driven[0]), w2 * d1)
    machine.hinge(machine.ground, wheel, d0)
    machine.hinge(machine.ground, first, d0)
    machine.hinge(first, cross, a)
    machine.hinge(cross, second, b)
    machine.hold(machine.ground, second, [0, 0, 0, 1, 1, 0], frame(d1, b))
    machine.spring(wheel, first, float(line.stiffness[0]), float(line.damping[0]))
    machine.watch(first)
    if line.size == 2:
        pin = swung(d1, rest, q[1])
        last = machine.body(d1, pin, inertia(line.driving[1]), v[1] * d1)
        machine.hinge(machine.ground, last, d1)
        machine.spring(second, last, float(line.stiffness[1]), float(line.damping[1]))
        machine.watch(last)
    found = machine.run(np.pi / speed, count)
    columns = [turned(found[0], d0, level), found[1] @ d0]
    if line.size == 2:
        columns += [turned(found[2], d1, rest), found[3] @ d1]
    return np.stack(columns, axis=-1)


ONE = {"stiffness": np.ones(1), "driving": np.array([1e-3]), "driven": np.ones(1)}
TWO = {"stiffness": np.ones(2), "driving": np.ones(2), "driven": np.zeros(2)}


@pytest.mark.parametrize(
    ("line", "speed"),
    [
        (TorsionalLine(beta=np.array([20 * deg]), damping=np.array([0.03]), **ONE), 1.0),
        (TorsionalLine(beta=np.array([20 * deg, 0]), damping=np.full(2, 0.01), **TWO), 0.618),
        (TorsionalLine(beta=np.array([20 * deg, 0]), damping=np.full(2, 0.005), **TWO), 1.118),
        (TorsionalLine(beta=np.array([20 * deg, 0]), damping=np.full(2, 0.01), **TWO), 1.618),
        (TorsionalLine(beta=np.array([30 * deg, 0]), damping=np.full(2, 0.02), **TWO), 1.3),
    ],
    ids=["one", "first", "sum", "second", "stable"],
)
def test_torsional_growth_rate_matches_exudyn(line, speed):
    """The exact linearisation, about the forced orbit, is what the engine shows."""
    count, push = 20, 1e-4
    base = torsion_run(line, speed, count, (0.0, 0.0))
    other = torsion_run(line, speed, count, (push, 0.4 * push))
    rate = np.log(np.abs(mapped(other - base)).max()) * speed / np.pi
    exact = growth_rate(linearised_about_periodic_motion(line, speed))
    # The trapezoidal rule errs by (w h)² / 12 of a frequency: 2e-4 here.
    assert rate == pytest.approx(float(exact), abs=1e-4)


# ----- lateral


def lateral_run(
    *, speed, torque, follower, bearing, damping, inertia, count, beta=0.0,
    at=(0.0, 0.0), moving=(1e-5, -2e-5),
):  # fmt: skip
    """Flywheel, cross and a driven shaft on a bearing 1 m on; inclination and its rate."""
    z = np.sqrt(1 - np.dot(at, at))
    axis = np.array([*at, z])
    d0 = np.array([-np.sin(beta), 0, np.cos(beta)])
    a = np.array([np.cos(beta), 0, np.sin(beta)])  # in the plane of the nominal shafts
    b = np.cross(axis, a) / np.linalg.norm(np.cross(axis, a))
    tipping = np.cross(axis, [*moving, -np.dot(at, moving) / z])
    # Cross: w d0 + s a = w2 axis + tipping + r b.
    w2, _, s = np.linalg.solve(np.stack([axis, b, -a], axis=-1), speed * d0 - tipping)
    machine = Machine()
    wheel = machine.body(d0, a, (FLYWHEEL, FLYWHEEL), speed * d0)
    cross = machine.body(np.cross(a, b), a, (1e-5, 1e-5), speed * d0 + s * a)
    shaft = machine.body(axis, b, inertia, w2 * axis + tipping)
    machine.hinge(machine.ground, wheel, d0)
    machine.hinge(wheel, cross, a)
    machine.hinge(cross, shaft, b)
    machine.mbs.CreateCartesianSpringDamper(
        bodyNumbers=[machine.ground, shaft], localPosition0=[0.0, 0, 1], localPosition1=[0.0, 0, 1],
        stiffness=[*bearing, 0.0], damping=[damping, damping, 0.0],
    )  # fmt: skip
    machine.mbs.CreateTorque(bodyNumber=wheel, loadVector=list(torque * d0))
    machine.mbs.CreateTorque(bodyNumber=shaft, loadVector=[0.0, 0.0, -torque], bodyFixed=follower)
    machine.watch(shaft)
    matrix, rate = machine.run(np.pi / speed, count)
    axis = matrix.reshape(-1, 3, 3)[:, :, 2]
    return np.concatenate([axis[:, :2], np.cross(rate, axis)[:, :2]], axis=-1)


@pytest.mark.parametrize(
    ("speed", "torque", "follower", "difference", "count"),
    [(0.5, 0.2, 1, 0.0, 16), (2.0, 0.2, 0, 0.0, 40), (3.0, 0.3, 1, 0.0, 40),
     (1.3, 0.3, 1, 0.15, 30), (1.0, 0.05, 1, 0.05, 24)],
)  # fmt: skip
def test_lateral_growth_rate_matches_exudyn(speed, torque, follower, difference, count):
    """Mazzei's flutter, his zone with a fixed load, and unequal bearings."""
    shaft = rigid_shaft_system(
        speed=speed, torque=torque, transverse_inertia=1.0, polar_inertia=0.1, stiffness=1.0,
        damping=0.05, stiffness_difference=difference, follower=follower,
    )  # fmt: skip
    states = lateral_run(
        speed=speed, torque=torque, follower=bool(follower), damping=0.05, inertia=(1.0, 0.1),
        bearing=(1.0 + difference, 1.0 - difference), count=count,
    )  # fmt: skip
    found = mapped(states)
    exact = floquet_multipliers(shaft.periodic_system)
    rate = np.log(np.abs(found).max()) * speed / np.pi
    assert rate == pytest.approx(float(growth_rate(shaft.periodic_system)), abs=1e-4)
    assert np.abs(found[:, None] - exact).min(-1).max() < 0.02


@pytest.mark.parametrize(
    ("speed", "torque", "beta"), [(0.7, 0.05, 25), (1.5, 0.03, 30), (0.7, 0.02, 30)]
)
def test_misaligned_shaft_matches_exudyn(speed, torque, beta):
    """A shaft held at an angle, shaken twice a turn: two runs from beside its forced motion."""
    given = {"torque": torque, "damping": 0.05, "speed": speed}
    shaft, swing = misaligned_shaft_system(
        beta=beta * deg, transverse_inertia=1.0, polar_inertia=0.001, stiffness=(1.0, 1.1), **given
    )
    moving = (differentiation_matrix(33) @ swing)[0] * speed / np.pi
    runs = [
        lateral_run(
            follower=True, inertia=(1.0, 0.001), bearing=(1.0, 1.1), count=10, beta=beta * deg,
            at=swing[0], moving=moving + push, **given,
        ) for push in (np.zeros(2), np.array([1e-4, 2e-4]))
    ]  # fmt: skip
    # The engine goes on in the forced motion computed here: static and twice a turn.
    assert np.ptp(swing, axis=0).max() > 0.1 * np.abs(swing).max()
    assert np.abs(runs[0][:, :2] - swing[0]).max() < 3e-3 * np.abs(swing).max()
    rate = np.log(np.abs(mapped(runs[1] - runs[0])).max()) * speed / np.pi
    # How spin answers to tilt is left out: of order I_a tan²β ~ 2e-4 of a frequency.
    assert rate == pytest.approx(float(growth_rate(shaft)), abs=2e-4)
