"""A driveline that runs on rubber, as bodies of a multibody engine: what its bearings carry.

The engine (EXUDYN) gets rigid shafts with their masses, crosses with two pins each, a spline,
and springs with dampers across the shafts where they hang. It steps through time from a line
that turns but does not swing yet, and the geometry moves as it will. It is told nothing of how
a universal joint turns, what it loads, or how a line on rubber moves.

A constant torque turns the gearbox flange, which has hardly any inertia. Behind the pinion a
flywheel turns at a constant speed, against the same torque.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

FLYWHEEL = 1e6
"""kg m²: what the rubber loses in a run does not slow it down."""

WHEEL = 1.0
"""kg, of the flywheel."""

SMALL = {"mass": 1e-4, "transverse": 1e-6, "polar": 1e-6}
"""kg, kg m²: crosses, the gearbox flange, the sliding end of the spline."""

DAMPER = 2e-4
"""s, of a torsion spring: what a shaft swings with at the start is gone at once."""

RUN_IN = 4
"""Half turns that are left out: the fastest of what dies away is gone then."""


@dataclass(frozen=True, kw_only=True)
class Rigid:
    """A shaft: kg; m behind its front joint; kg m² about its centre, across and along."""

    mass: float
    centre: float
    transverse: float
    polar: float


@dataclass(frozen=True)
class Steady:
    """How a line runs in the end; amplitudes c of Re c e^{2i theta}, theta of the gearbox.

    Mean force on the bearings (n-2, 3) N, its order 2, and that of the speed they give way
    at, m/s.
    """

    mean: np.ndarray
    force: np.ndarray
    velocity: np.ndarray


class Swinging:
    """A line in the engine.

    Points (n, 3) m of the joint centres, directions (n+1, 3), phases (n-1,) rad, the shafts
    (n-1,), overhangs (n-2,) m of the bearings ahead of the rear joints, stiffness (vertical,
    lateral) N/m, torque N m and speed rad/s. The dampers are loss k / 2 speed: at order 2, and
    only there, that is rubber of this loss. The first bearing may hang in a bracket: kg, the
    N/m that hold it along x, y, z, and its loss. Transmission tail and axle may be a mass that
    moves across its flange on springs: kg, N/m (up, level), loss; in `Steady` they come behind
    the bearings. Between its yokes each shaft may be a torsion spring, N m/rad.
    """

    def __init__(
        self, points: Any, directions: Any, phases: Any, shafts: list[Rigid], overhangs: Any, *,
        stiffness: Any, loss: float, torque: float, speed: float, bracket: Any = None,
        tail: Any = None, axle: Any = None, torsion: Any = None,
    ) -> None:  # fmt: skip
        self.speed = speed
        d, line = np.asarray(directions), {"tail": tail, "axle": axle, "torsion": torsion}
        self._turned = None
        if torsion is not None:  # it starts as it would stand still under its torque
            self._turned = torque / np.asarray(torsion)
            phases = phases - self._turned
        self._line(np.asarray(points), d, phases, shafts, speed=speed, **line)
        self.mbs.CreateTorque(itemNumber=self.flange, loadVector=list(torque * d[0]))
        self.mbs.CreateTorque(itemNumber=self.pinion, loadVector=list(-torque * d[-1]))
        self._springs, self._axes = [], []
        for k, over in enumerate(overhangs, 1):
            at, inside, axes = self._hung(k, over)
            self._axes.append(axes)
            frame, held_at = self.ground, at
            if bracket is not None and k == 1:
                frame, held_at = self._bracket(at, *bracket), np.zeros(3)
            self._suspend([(frame, held_at), (self.tubes[k - 1], inside)], axes, stiffness, loss)
        for body, at, along, given in self._ends:
            if given is not None:
                axes = across(along)
                self._axes.append(axes)
                self._suspend([(self.ground, at), (body, np.zeros(3))], axes, *given[1:])

    def _suspend(self, ends: Any, axes: Any, stiffness: Any, loss: float) -> None:
        """Add a watched spring with its damper along each of two axes."""
        for axis, k in zip(axes, stiffness, strict=True):
            spring = self._spring(ends, axis, k, loss * k / (2 * self.speed))
            self._springs.append(
                [self._watched("Object", v, objectNumber=spring)
                 for v in ("ForceLocal", "VelocityLocal")]
            )  # fmt: skip

    def _end(self, at: Any, along: Any, given: Any) -> Any:
        """Return what a flange's bearings sit in: the ground, or a mass that moves across."""
        if given is None:
            return self.ground
        # Too heavy to turn, and held along the flange by a spring that nothing moves.
        body = self._body(along, at, [0, 0, 0], mass=given[0], transverse=1e6, polar=1e6)
        self._spring([(self.ground, at), (body, np.zeros(3))], along, 1e9, 1e4)
        return body

    def _line(
        self, P: np.ndarray, d: np.ndarray, phases: Any, shafts: list[Rigid], *, speed: float,
        tail: Any = None, axle: Any = None, torsion: Any = None,
    ) -> None:  # fmt: skip
        """Add what turns, from the gearbox flange to the pinion, and nothing that holds it."""
        import exudyn as exu

        self.exu, self._places, self._d, self._shafts = exu, P, d, shafts
        self.mbs = exu.SystemContainer().AddSystem()
        pins, spins, crosses = turning(d, phases)
        pace = speed / spins[-1]
        spins, crosses = pace * spins[:, None] * d, pace * crosses
        self.ground = self.mbs.CreateGround()
        self.flange = flange = self._body(d[0], P[0], spins[0], **SMALL)
        middles = [P[k - 1] + b.centre * d[k] for k, b in enumerate(shafts, 1)]
        self.tubes = tubes = [
            self._body(
                d[k], middles[k - 1], spins[k],
                mass=b.mass, transverse=b.transverse, polar=b.polar,
            )
            for k, b in enumerate(shafts, 1)
        ]  # fmt: skip
        self.sliding = sliding = self._body(d[-2], P[-2], spins[-2], **SMALL)
        wheel = {"mass": WHEEL, "transverse": FLYWHEEL, "polar": FLYWHEEL}
        self.pinion = pinion = self._body(d[-1], P[-1], spins[-1], **wheel)
        ends = self._end(P[0], d[0], tail), self._end(P[-1], d[-1], axle)
        self._ends = (ends[0], P[0], d[0], tail), (ends[1], P[-1], d[-1], axle)
        self._hinge(ends[0], flange, P[0], d[0])
        self._hinge(ends[1], pinion, P[-1], d[-1])
        yokes = [*tubes[:-1], sliding]
        if torsion is not None:
            yokes = [
                self._twisting(
                    body, P[k] - place, P[k], d[k + 1], spins[k + 1],
                    stiffness=torsion[k], welded=self._turned[k],
                )
                for k, (body, place) in enumerate(zip(yokes, [*middles[:-1], P[-2]], strict=True))
            ]  # fmt: skip
        ahead, behind = [flange, *tubes], [*yokes, pinion]
        for k, (driving, driven) in enumerate(pins):
            cross = self._body(d[k], P[k], crosses[k], **SMALL)
            self._hinge(ahead[k], cross, P[k], driving)
            self._hinge(cross, behind[k], P[k], driven)
        self._join_spline(P[-1], d[-2])
        self._spins = spins
        self._yoke = pins[0][0], np.cross(d[0], pins[0][0])
        self._flange = self._watched("Body", "RotationMatrix", bodyNumber=flange)

    def _join_spline(self, at: np.ndarray, along: np.ndarray) -> None:
        """Let the front end of the last shaft slide along its tube."""
        self.mbs.CreatePrismaticJoint(
            itemNumbers=[self.sliding, self.tubes[-1]], position=list(at), axis=list(along)
        )

    def _twisting(
        self, body: Any, inside: Any, at: Any, along: Any, spin: Any, *, stiffness: float,
        welded: float,
    ) -> Any:  # fmt: skip
        """Return a yoke in front of a body, which springs would turn to where it was welded.

        Two of them, at 1 m on either side of the shaft.
        """
        yoke = self._body(along, at, spin, **SMALL)
        self._hinge(yoke, body, at, along)
        for side in (1.0, -1.0):
            arm = side * across(along)[0]
            self._spring(
                [(yoke, arm), (body, inside + arm)], np.cross(along, arm),
                stiffness / 2, DAMPER * stiffness / 2, offset=welded,
            )  # fmt: skip
        return yoke

    def _hung(self, k: int, over: float) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
        """Where bearing k from 1 sits, in space and in its shaft, and its two ways, up first."""
        d, P = self._d, self._places
        at = P[k] - over * d[k]
        return at, at - P[k - 1] - self._shafts[k - 1].centre * d[k], across(d[k])

    def _bracket(self, at: Any, mass: float, stiffness: Any, loss: float) -> Any:
        """Add a mass on three springs, too heavy to turn; its axes stay those of the vehicle."""
        body = self._body([0, 0, 1], at, [0, 0, 0], mass=mass, transverse=1e3, polar=1e3)
        for axis, k in zip(np.eye(3), stiffness, strict=True):
            self._spring(
                [(self.ground, at), (body, [0, 0, 0])], axis, k, loss * k / (2 * self.speed)
            )
        return body

    def _body(
        self, axis: Any, at: Any, spin: Any, *, mass: float, transverse: float, polar: float
    ) -> Any:
        """Add a body whose axes start along those of the vehicle."""
        from exudyn.utilities import RigidBodyInertia

        tensor = transverse * np.eye(3) + (polar - transverse) * np.outer(axis, axis)
        return self.mbs.CreateRigidBody(
            inertia=RigidBodyInertia(mass=mass, inertiaTensor=tensor),
            nodeType=self.exu.NodeType.RotationEulerParameters,
            referencePosition=list(at), initialAngularVelocity=list(spin),
        )  # fmt: skip

    def _hinge(self, first: Any, second: Any, at: Any, axis: Any) -> None:
        self.mbs.CreateRevoluteJoint(
            itemNumbers=[first, second], position=list(at), axis=list(axis)
        )

    def _spring(
        self, ends: Any, axis: Any, stiffness: float, damping: float, *, offset: float = 0.0
    ) -> Any:
        """Add a spring and a damper between points of two bodies, along an axis of the first."""
        from exudyn.utilities import LinearSpringDamper, MarkerBodyRigid

        markers = [
            self.mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=list(at)))
            for body, at in ends
        ]
        return self.mbs.AddObject(
            LinearSpringDamper(
                markerNumbers=markers,
                stiffness=stiffness,
                damping=damping,
                axisMarker0=list(axis),
                offset=offset,
            )
        )

    def _watched(self, kind: str, output: str, **of: Any) -> Any:
        """Record an output at every step."""
        from exudyn import utilities

        kind_of_output = getattr(self.exu.OutputVariableType, output)
        sensor = getattr(utilities, f"Sensor{kind}")
        return self.mbs.AddSensor(
            sensor(outputVariableType=kind_of_output, storeInternal=True, writeToFile=False, **of)
        )

    def run(self, *, turns: int = 20, steps: int = 400) -> Steady:
        """Run some turns, in so many steps each half, and find what it tends to."""
        halves = 2 * turns
        settings = self.exu.SimulationSettings()
        settings.timeIntegration.numberOfSteps = steps * halves
        settings.timeIntegration.endTime = np.pi / self.speed * halves
        settings.timeIntegration.adaptiveStep = False
        # Yokes on torsion springs would ring for ever by the trapezoidal rule.
        alpha = settings.timeIntegration.generalizedAlpha
        alpha.spectralRadius = 1 if self._turned is None else 0.8
        alpha.useNewmark = self._turned is None
        alpha.useIndex2Constraints = self._turned is None
        settings.timeIntegration.newton.absoluteTolerance = 1e-8
        settings.linearSolver.solverType = self.exu.LinearSolverType.EigenSparse
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = 1e-9 / self.speed  # every step
        self.mbs.Assemble()
        self.mbs.SolveDynamic(settings)

        def read(sensor: Any) -> np.ndarray:
            stored = self.mbs.GetSensorStoredData(sensor)[1:, 1:]
            return stored.reshape(halves, steps, -1)

        clock = np.pi * np.arange(1, steps * halves + 1).reshape(halves, steps) / steps
        # The flange does not turn quite uniformly; amplitudes are against its mean angle.
        start, ahead = self._yoke
        yoke = read(self._flange).reshape(halves, steps, 3, 3) @ start
        lead = np.arctan2(yoke @ ahead, yoke @ start) - clock
        lead = np.unwrap(lead.ravel()).reshape(clock.shape).mean(axis=-1)
        against = 2 * np.exp(-2j * (clock + lead[:, None])) / steps
        of = np.array([[read(s)[..., 0] for s in pair] for pair in self._springs])
        order2 = (of * against).sum(-1)  # (springs, force and velocity, halves)
        mean = of[:, 0].mean(-1)
        parts = np.concatenate([mean, order2[:, 0], order2[:, 1]])
        rows = np.concatenate([parts.real, parts.imag]).T[RUN_IN:]
        found = limit(rows)
        first, *_, last = np.linalg.norm(rows - found, axis=-1)
        if last > max(first, 1e-3 * np.linalg.norm(found)):
            msg = f"the line does not settle: {first:g} N off at first, {last:g} N in the end"
            raise AssertionError(msg)
        found = (found[: len(parts)] + 1j * found[len(parts) :]).reshape(3, -1, 2)
        mean, force, velocity = np.einsum("abi,bij->abj", found, np.array(self._axes))
        return Steady(mean.real, force, velocity)


def across(along: np.ndarray) -> list[np.ndarray]:
    """Return the two ways across a member, up first."""
    level = np.cross([0, 0, 1], along)
    level /= np.linalg.norm(level)
    return [np.cross(along, level), level]


def turning(d: np.ndarray, phases: Any) -> tuple[Any, np.ndarray, np.ndarray]:
    """Return both pins of each cross, and how members and crosses turn while no shaft swings.

    A cross turns as its two neighbours do, but for turning about its pins.
    """
    driving = np.cross([0, 0, 1], d[0])
    driving = driving / np.linalg.norm(driving)
    pins, speeds, crosses = [], [1.0], []
    for k, along in enumerate(d[1:]):
        driven = np.cross(along, driving)
        driven /= np.linalg.norm(driven)
        pins.append((driving, driven))
        axes = np.stack([along, driven, -driving], axis=-1)
        speed, _, swing = np.linalg.solve(axes, speeds[-1] * d[k])
        crosses.append(speeds[-1] * d[k] + swing * driving)
        speeds.append(speed)
        if k < len(phases):
            driving = np.cos(phases[k]) * driven + np.sin(phases[k]) * np.cross(along, driven)
    return pins, np.array(speeds), np.array(crosses)


def limit(rows: np.ndarray) -> np.ndarray:
    """Return what rows (m, q) tend to, each but for decaying motion.

    What is left of the start shrinks from row to row by one matrix, whose invariant polynomial
    the differences show (reduced rank extrapolation).
    """
    steps = np.diff(rows, axis=0)
    weights, *_ = np.linalg.lstsq(np.diff(steps, axis=0).T, steps[0], rcond=1e-8)
    return rows[0] - weights @ steps[:-1]
