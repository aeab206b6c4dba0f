"""A driveline as bodies and joints of a multibody engine, crosses included.

The engine (EXUDYN) gets members, crosses, their pins, bearings and a spline, finds the
poses by its own Newton iteration and says what its constraints carry. It is told nothing
of how a universal joint turns or what it loads, only where the pins are at the start.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

X_TURNS = [1, 1, 1, 0, 1, 1]
X_SLIDES = [0, 1, 1, 1, 1, 1]
X_PASSES = [0, 1, 1, 0, 0, 0]
"""What a joint holds: x, y, z, and the rotations about them."""


@dataclass(frozen=True)
class Found:
    """Loads at N equally spaced angles of the gearbox, for 1 N m of gearbox torque.

    Forces on the `bearings` (n-2, N, 3); forces and moments of the crosses on the members
    behind, `joints` (n, N, 3) and `moments` (n, N, 3); the torque at the `pinion` (N,).
    """

    bearings: np.ndarray
    joints: np.ndarray
    moments: np.ndarray
    pinion: np.ndarray


class Crosses:
    """A line in the engine.

    Points (n, 3) m of the joint centres, directions (n+1, 3), phases (n-1,) rad, overhangs
    (n-2,) m of the bearings ahead of the rear joints. Where the gearbox flange is not
    floating the last shaft is two bodies that slide in each other.
    """

    def __init__(
        self, points: Any, directions: Any, phases: Any, overhangs: Any, *, floating: bool = False
    ) -> None:
        import exudyn as exu
        from exudyn.utilities import RigidBodyInertia

        self.exu = exu
        self.mbs = exu.SystemContainer().AddSystem()
        self.inertia = RigidBodyInertia(mass=1.0, inertiaTensor=np.eye(3))
        P, d = np.asarray(points), np.asarray(directions)
        n = len(P)
        ground = (self.mbs.CreateGround(), np.zeros(3))
        gearbox, pinion = self._body(P[0]), self._body(P[-1])
        shafts = [self._body(p) for p in P[:-1]]
        tail = shafts[-1] if floating else self._body(P[-1])
        slides = [0 if floating else 1, *X_SLIDES[1:]]
        self.drive = self._joint(ground, gearbox, frame(d[0]), P[0], slides, driven=True)
        ahead, behind = [gearbox, *shafts[:-1], tail], [*shafts, pinion]
        self.crosses, pin = [], np.cross([0, 0, 1], d[0])
        for k in range(n):
            cross, driven = self._body(P[k]), frame(np.cross(d[k + 1], pin))
            self._joint(cross, ahead[k], frame(pin), P[k], X_TURNS)
            joint = self._joint(cross, behind[k], driven, P[k], X_TURNS)
            self.crosses.append((joint, driven, cross[0], behind[k][0]))
            if k < n - 1:
                b = driven[:, 0]
                pin = np.cos(phases[k]) * b + np.sin(phases[k]) * np.cross(d[k + 1], b)
        self.bearings = [
            (self._joint(ground, shafts[k], frame(d[k + 1]), P[k + 1] - over * d[k + 1], X_PASSES),
             frame(d[k + 1]))
            for k, over in enumerate(overhangs)
        ]  # fmt: skip
        self._joint(ground, pinion, frame(d[-1]), P[-1], X_TURNS)
        if not floating:
            self._joint(shafts[-1], tail, frame(d[-2]), P[-1], X_SLIDES)
        self.mbs.CreateTorque(itemNumber=pinion[0], loadVector=list(-d[-1]))

    def _body(self, point: Any) -> tuple[Any, np.ndarray]:
        """Add a body whose axes start along those of the vehicle."""
        number = self.mbs.CreateRigidBody(
            inertia=self.inertia, referencePosition=list(point), gravity=[0, 0, 0]
        )
        return number, np.asarray(point)

    def _joint(
        self, first: Any, second: Any, axes: Any, point: Any, holds: Any, *, driven: bool = False
    ) -> Any:
        """Add a joint between two bodies."""
        from exudyn.utilities import GenericJoint, MarkerBodyRigid

        markers = [
            self.mbs.AddMarker(
                MarkerBodyRigid(
                    bodyNumber=number,
                    localHT=self.exu.HT(rotation=axes, translation=list(point - origin)),
                )
            )
            for number, origin in (first, second)
        ]
        if not driven:
            return self.mbs.AddObject(GenericJoint(markerNumbers=markers, constrainedAxes=holds))
        return self.mbs.AddObject(
            GenericJoint(
                markerNumbers=markers,
                constrainedAxes=holds,
                offsetUserFunction=lambda _mbs, t, _i, _p: [0, 0, 0, 2 * np.pi * t, 0, 0],
            )
        )

    def _watched(self, number: Any, output: str, *, body: bool = False) -> Any:
        """Record an output of a joint, or of a body, at every step."""
        from exudyn.utilities import SensorBody, SensorObject

        kind = getattr(self.exu.OutputVariableType, output)
        settings = {"outputVariableType": kind, "storeInternal": True, "writeToFile": False}
        sensor = SensorBody(bodyNumber=number, **settings) if body else SensorObject(
            objectNumber=number, **settings
        )  # fmt: skip
        return self.mbs.AddSensor(sensor)

    def turned(self, samples: int, *, joints: bool = True) -> Found:
        """Turn the gearbox once, in as many static steps, and read the constraints."""
        mbs = self.mbs
        drive = self._watched(self.drive, "TorqueLocal")
        bearings = [self._watched(joint, "ForceLocal") for joint, _ in self.bearings]
        crosses = [
            [
                *(self._watched(joint, output) for output in ("ForceLocal", "TorqueLocal")),
                *(self._watched(body, "RotationMatrix", body=True) for body in bodies),
            ]
            for joint, _, *bodies in (self.crosses if joints else [])
        ]
        mbs.Assemble()
        settings = self.exu.SimulationSettings()
        settings.staticSolver.numberOfLoadSteps = samples
        settings.staticSolver.useLoadFactor = False
        settings.staticSolver.newton.relativeTolerance = 1e-12
        settings.staticSolver.newton.absoluteTolerance = 1e-12
        settings.staticSolver.verboseMode = 0
        settings.linearSolver.solverType = self.exu.LinearSolverType.EigenSparse
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = 0.1 / samples
        mbs.SolveStatic(settings)

        def read(sensor: Any) -> np.ndarray:
            # The last step ends where the turn began.
            return np.roll(mbs.GetSensorStoredData(sensor)[-samples:, 1:], 1, axis=0)

        # The torque that holds the gearbox sets the scale, and with it the sign in which the
        # engine gives what a joint does to its second body.
        torque = read(drive)[:, :1]
        forces, moments = [], []
        for sensors, (_, driven, *_) in zip(crosses, self.crosses, strict=False):
            force, moment, cross, behind = map(read, sensors)
            force, moment = (x / torque for x in (force, moment))
            cross, behind = (x.reshape(-1, 3, 3) @ driven for x in (cross, behind))
            forces.append((cross @ force[..., None])[..., 0])
            # Where x only may turn it gives the multipliers of x . y' = 0 and x . z' = 0,
            # with y' and z' of the second body: the moment turned a quarter about x.
            turned = (behind @ moment[..., None])[..., 0]
            moments.append(np.cross(turned, behind[..., 0]))
        return Found(
            bearings=np.array(
                [
                    -read(s) / torque @ axes.T
                    for s, (_, axes) in zip(bearings, self.bearings, strict=True)
                ]
            ),
            joints=np.array(forces),
            moments=np.array(moments),
            pinion=1 / torque[:, 0],
        )


def frame(x: Any) -> np.ndarray:
    """Return axes as columns, the first along a vector."""
    x = np.asarray(x) / np.linalg.norm(x)
    y = np.cross([0.3, -0.5, 0.8], x)
    y /= np.linalg.norm(y)
    return np.stack([x, y, np.cross(x, y)], axis=-1)
