"""Thrust of the spline as a stiffness, against EXUDYN: two trucks that stand under a thrust.

The engine has rigid shafts, crosses, a sliding joint and springs (`rubber_engine.py`); a force
along the last shaft pushes its sliding end and its tube apart, and turns with them. What bends
the line is that the thrust acts where the line then is. One truck has a last shaft of 12 deg.
"""

from functools import cache

import numpy as np
import pytest
from case_selection import long
from rubber_engine import Swinging
from scipy.linalg import eigh
from test_rubber import laid
from test_rubber_engine import THREE, line, rigid

from cardan.physics.loads.mounted_line_model import mounted_line
from cardan.physics.loads.spline_thrust import compressed_line

pytestmark = [
    pytest.mark.oracle,
    pytest.mark.filterwarnings("ignore"),  # the engine's own deprecations
]

STANDING = 1e-3
"""rad/s: the engine's crosses want a speed; nothing turns in the time of a run."""

TRUCKS = {
    "collector": (line(*THREE), {"side": [4, 4.5, 2.2, 6.4, 3], "top": [0, 0.4, -0.3, 0.5, 0]}),
    "steep": (
        line((0.9, 0.0, 0.13), (1.1, 0.0, None)),
        {"side": [4, 3, 12, 6], "top": [0, 0, 1.5, 0]},
    ),
}
STIFFNESS = 200e3, 120e3


class Compressed(Swinging):
    """A line in the engine that stands, its spline under a compression N."""

    def __init__(self, name: str, compression: float, *, damping: float) -> None:
        of_line, slopes = TRUCKS[name]
        where = laid(of_line, **slopes)
        super().__init__(
            where.points, where.directions, of_line.phases, [rigid(s) for s in of_line.shafts],
            [s.centre_bearing.from_rear_joint for s in of_line.shafts if s.centre_bearing],
            stiffness=STIFFNESS, loss=2 * STANDING * damping, torque=0.0, speed=STANDING,
        )  # fmt: skip
        along = where.directions[-2]
        for body, sign in ((self.sliding, -1.0), (self.tubes[-1], 1.0)):
            self.mbs.CreateForce(
                bodyNumber=body, loadVector=list(sign * compression * along), bodyFixed=True
            )
        self.ends = [
            self._watched("Body", "Position", bodyNumber=body)
            for body in (self.sliding, self.tubes[-1])
        ]

    def stand(self, time: float, steps: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the bearings' forces (steps, n-2, 2) N, and how far the spline goes out, m."""
        settings = self.exu.SimulationSettings()
        settings.timeIntegration.numberOfSteps = steps
        settings.timeIntegration.endTime = time
        settings.timeIntegration.newton.absoluteTolerance = 1e-8
        settings.linearSolver.solverType = self.exu.LinearSolverType.EigenSparse
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = time / steps / 2
        self.mbs.Assemble()
        self.mbs.SolveDynamic(settings)

        def read(sensor):
            return self.mbs.GetSensorStoredData(sensor)[:, 1:]

        force = np.stack([read(pair[0])[:, 0] for pair in self._springs], axis=-1)
        ahead, behind = map(read, self.ends)
        apart = np.linalg.norm(behind - ahead, axis=-1)
        return force.reshape(len(force), -1, 2), apart - apart[0]


@cache
def ours(name: str):
    of_line, slopes = TRUCKS[name]
    where = laid(of_line, **slopes)
    held = mounted_line(where, of_line, stiffness=(*STIFFNESS, 0.0), loss=0.0, sines=0)
    spline = held.spline_gradient(where.directions[-2])
    none = np.zeros(spline.shape)
    return held, compressed_line(held, forces=none, spline=spline, torque=np.array(0.0))


@pytest.mark.parametrize(
    ("name", "share"),
    [("steep", 0.4), *long(("steep", -0.4), ("steep", 0.7), ("collector", 0.4))],
)
def test_shape_under_thrust_matches_exudyn(name, share):
    """Forces on the bearings and how far the spline goes out, which is the thrust over a stroke."""
    held, of = ours(name)
    P = share * float(of.critical)
    force, out = Compressed(name, P, damping=0.02).stand(1.0, 500)
    found = held.motion(of.coordinates(P)).bearing_forces.real
    expected = np.linalg.norm(force[-1], axis=-1)
    assert np.linalg.norm(found, axis=-1) == pytest.approx(expected, rel=0.02)
    assert float(of.lengthening(P)) == pytest.approx(out[-1], rel=0.03)


def frequencies(values: np.ndarray, step: float, count: int) -> np.ndarray:
    """Return the frequencies of a sum of decaying waves (steps, q), in Hz: Hankel and SVD."""
    length = len(values) // 3
    rows = [v[k : k + length] for v in (values - values.mean(0)).T for k in range(0, 2 * length, 4)]
    _, _, base = np.linalg.svd(np.array(rows), full_matrices=False)
    base = base[: 2 * count].T
    poles = np.linalg.eigvals(np.linalg.lstsq(base[:-1], base[1:], rcond=None)[0])
    found = np.abs(np.angle(poles)) / (2 * np.pi * step)
    return np.unique(found.round(4))


@pytest.mark.parametrize(("name", "share"), [("steep", 0.4), *long(("collector", 0.3))])
def test_modes_under_thrust_match_exudyn(name, share):
    """Of free vibration: the thrust comes at once, and the line swings about where it stands."""
    held, of = ours(name)
    P = share * float(of.critical)
    force, _ = Compressed(name, P, damping=1e-4).stand(4.0, 2000)
    K = held.stiffness_under_torque(0.0) - P * held.geometric
    expected = np.sqrt(eigh(K, held.mass, eigvals_only=True)) / (2 * np.pi)
    values = force.reshape(len(force), -1)[::4]
    found = frequencies(values, 8e-3, len(expected))
    assert found == pytest.approx(expected, rel=0.01)
