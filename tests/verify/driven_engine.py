"""A drive of a line on rubber and brackets that give way, in a multibody engine (EXUDYN).

Bodies as in `rubber_engine.py`. Torque and speed change as a driver makes them; each rubber
sits in a bracket with mass, stiffness and damping of its own, which the road may shake; a lump
off the axis unbalances a shaft. A gauge on a bracket feels what its springs carry.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from rubber_engine import FLYWHEEL, Rigid, Swinging

LUMP = 0.05
"""m, from the axis to the lump that unbalances."""
SHEAR = 206e9 / 2.6
"""Pa, of steel in torsion."""


def twisting(tube: Any, length: float) -> float:
    """Return the torsion spring N m/rad that a tube is from joint to joint."""
    inside = tube.outer - 2 * tube.wall
    return SHEAR * np.pi / 32 * (tube.outer**4 - inside**4) / length


@dataclass(frozen=True, kw_only=True)
class Mount:
    """Rubber (vertical, lateral) N/m, its loss factor at `at` rad/s, of both ways or of each; the
    bracket it sits in.

    The bracket: kg, N/m (vertical, lateral), damping ratio; force (n+1, 3) N of the road.
    """

    rubber: tuple[float, float]
    loss: float
    at: float | tuple[float, float]
    mass: float
    bracket: tuple[float, float]
    damping: float = 0.02
    road: np.ndarray | None = None


@dataclass(frozen=True)
class Driven:
    """What is to be known of a drive, at every step.

    Time (n,) s, torque (n,) N m and angle (n,) rad of the gearbox flange, speed (n,) rad/s
    wanted, and what each bracket's springs carry, (bearings, n, 2) N, sideways and up.
    """

    time: np.ndarray
    torque: np.ndarray
    angle: np.ndarray
    speed: np.ndarray
    force: np.ndarray


class Driving(Swinging):
    """A line under way.

    As `Swinging`, with `mounts` at the overhangs, torque (n+1,) N m and speed (n+1,) rad/s at
    each `step` s, and `heavy`: kg m off the axis at a shaft's rear end, by shaft from 1. Between
    its yokes each shaft may be a torsion spring, N m/rad.
    """

    def __init__(
        self, points: Any, directions: Any, phases: Any, shafts: list[Rigid], overhangs: Any, *,
        mounts: list[Mount], torque: np.ndarray, speed: np.ndarray, step: float,
        heavy: dict[int, float] | None = None, torsion: Any = None,
    ) -> None:  # fmt: skip
        P, d = np.asarray(points), np.asarray(directions)
        self.speed, self.torque, self.step = speed, torque, step
        if torsion is not None:  # it starts as it would stand still under its torque
            self._turned = torque[0] / np.asarray(torsion)
            phases = phases - self._turned
        self._line(P, d, phases, shafts, speed=speed[0], torsion=torsion)
        held = -torque + FLYWHEEL * np.gradient(speed, step)
        self._pushed("Torque", self.flange, torque[:, None] * d[0])
        self._pushed("Torque", self.pinion, held[:, None] * d[-1])
        for k, unbalance in (heavy or {}).items():
            side = np.cross([0, 0, 1], d[k])
            at = P[k] + LUMP * side / np.linalg.norm(side)
            lump = self._body(
                d[k], at, self._spins[k], mass=unbalance / LUMP, transverse=1e-6, polar=1e-6
            )
            self.mbs.CreateGenericJoint(
                itemNumbers=[self.tubes[k - 1], lump], position=list(at), constrainedAxes=[1] * 6
            )
        hung = enumerate(zip(overhangs, mounts, strict=True), 1)
        self._bracket = [self._mounted(k, *of) for k, of in hung]

    def _mounted(self, k: int, over: float, of: Mount) -> list[Any]:
        at, inside, axes = self._hung(k, over)
        house = self._body(axes[0], at, [0.0] * 3, mass=of.mass, transverse=0.1, polar=0.1)
        self.mbs.CreateGenericJoint(
            itemNumbers=[self.ground, house], position=list(at), constrainedAxes=[1, 0, 0, 1, 1, 1]
        )
        for axis, rubber, at_ in zip(axes, of.rubber, np.broadcast_to(of.at, 2), strict=True):
            ends = [(house, np.zeros(3)), (self.tubes[k - 1], inside)]
            self._spring(ends, axis, rubber, of.loss * rubber / at_)
        if of.road is not None:
            self._pushed("Force", house, of.road)
        watched = []
        for axis, stiff in zip(np.eye(3)[1:], of.bracket[::-1], strict=True):
            damping = 2 * of.damping * np.sqrt(stiff * of.mass)
            spring = self._spring([(self.ground, at), (house, np.zeros(3))], axis, stiff, damping)
            watched.append(self._watched("Object", "ForceLocal", objectNumber=spring))
        return watched

    def _pushed(self, kind: str, body: Any, by: np.ndarray) -> None:
        """Load a body by (n+1, 3), step by step."""
        last, step = len(by) - 1, self.step

        def load(_mbs: Any, t: float, _load: Any) -> list[float]:
            return by[min(round(t / step), last)].tolist()

        getattr(self.mbs, f"Create{kind}")(itemNumber=body, loadVectorUserFunction=load)

    def drive(self) -> Driven:
        """Step through the drive."""
        settings, n = self.exu.SimulationSettings(), len(self.torque) - 1
        settings.timeIntegration.numberOfSteps = n
        settings.timeIntegration.endTime = n * self.step
        settings.timeIntegration.adaptiveStep = False
        settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
        settings.linearSolver.solverType = self.exu.LinearSolverType.EigenSparse
        settings.timeIntegration.newton.useModifiedNewton = True
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = self.step
        self.mbs.Assemble()
        self.mbs.SolveDynamic(settings)

        def read(sensor: Any) -> np.ndarray:
            return self.mbs.GetSensorStoredData(sensor)[1:, 1:]

        start, ahead = self._yoke
        yoke = read(self._flange).reshape(-1, 3, 3) @ start
        angle = np.unwrap(np.arctan2(yoke @ ahead, yoke @ start))
        n = angle.size
        force = np.stack(
            [np.stack([read(s)[:, 0] for s in pair], axis=-1) for pair in self._bracket]
        )
        time = self.step * np.arange(1, n + 1)
        return Driven(time, self.torque[1 : n + 1], angle, self.speed[1 : n + 1], force)
