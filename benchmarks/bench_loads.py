"""Centre-bearing forces of a chain round a turn: this program beside two multibody engines.

    python benchmarks/bench_loads.py

All compute the same, the force on the bearing of a three-joint line at 64 and at 360 angles,
from its joint centres, directions and yoke phases. The engines are told bodies and joints:
EXUDYN turns them in one static solution with a step for each angle and its fastest linear
solver here, Drake is placed angle by angle and its Jacobians give what the frame holds.
"""

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np

from cardan.model.layout import Layout, layout_from_slopes
from cardan.model.parts import CentreBearing, Line, Shaft
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.loads.statics import JointLoads, joint_loads

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "verify"))

CASES = 1000
LINE = Line(
    shafts=(
        Shaft(length=1.2, centre_bearing=CentreBearing(from_rear_joint=0.14)),
        Shaft(length=1.5, phase=0.1),
    )
)
SIDE, TOP = np.radians([3, 1, 4.5, 2]), np.radians([0, 1.5, -0.8, 0.6])


def best(work: Callable[[], object], *, repeats: int) -> float:
    """Return the shortest of some runs, in seconds."""
    times = []
    for _ in range(repeats):
        start = perf_counter()
        work()
        times.append(perf_counter() - start)
    return min(times)


def ours(layout: Layout) -> JointLoads:
    return joint_loads(
        layout, rotate_chain(layout.directions, phases=LINE.phases), LINE, torque=1.0
    )


def exudyn(layout: Layout, samples: int) -> np.ndarray:
    from crosses import Crosses

    line = Crosses(layout.points, layout.directions, LINE.phases, [0.14])
    return line.turned(samples, joints=False).bearings


def drake(layout: Layout, samples: int) -> np.ndarray:
    from engine import Mechanism
    from frame import held

    mechanism = Mechanism(layout.points, layout.directions, LINE.phases)
    forces = []
    for theta in 2 * np.pi * np.arange(samples) / samples:
        mechanism.place(theta)
        forces.append(held(mechanism, [0.14])[0])
    return np.swapaxes(forces, 0, 1)


def apart(found: np.ndarray, reference: np.ndarray) -> float:
    """Return the largest difference over the largest value."""
    return float(np.abs(found - reference).max() / np.abs(reference).max())


def main() -> None:
    """Print the rows, each as a ratio to the faster of the engines."""
    layout = layout_from_slopes(side=SIDE, top=TOP, lengths=LINE.lengths)
    spread = np.random.default_rng(1).normal(scale=0.02, size=(2, CASES, 4))
    many = layout_from_slopes(side=SIDE + spread[0], top=TOP + spread[1], lengths=LINE.lengths)
    print("| what | target | measured |\n| --- | --- | --- |")
    for samples in (64, 360):
        race(layout, many, samples)


def race(layout: Layout, many: Layout, samples: int) -> None:
    """Print the rows of one number of angles."""
    engines = {"EXUDYN": exudyn, "Drake": drake}
    runs = {name: partial(run, layout, samples) for name, run in engines.items()}
    times = {name: best(run, repeats=3) for name, run in runs.items()}
    reference = ours(layout).bearing_forces.values(samples)
    differences = [f"{apart(run(), reference):.0e}" for run in runs.values()]
    fastest = min(times.values())
    told = ", ".join(f"{name} {1e3 * seconds:.0f} ms" for name, seconds in times.items())

    def alone() -> np.ndarray:
        return ours(layout).bearing_forces.values(samples)

    def sweep() -> np.ndarray:
        return ours(many).bearing_forces.values(samples)

    def orders() -> tuple[np.ndarray, np.ndarray]:
        force = ours(many).bearing_forces
        return force.static, force.dynamic

    def row(what: str, target: str, measured: str) -> None:
        print(f"| {what} | {target} | {measured} |")

    row(
        f"centre-bearing forces of a three-joint line against {' and '.join(engines)}, "
        f"{samples} angles, relative",
        "1e-9",
        " and ".join(differences),
    )
    for what, work, count, repeats in (
        (f"faster engine over turn and loads of one line, {samples} angles", alone, 1, 300),
        (f"the same, a line among {CASES} in one call", sweep, CASES, 10),
        ("the same, static and dynamic, which say it all", orders, CASES, 10),
    ):
        each = best(work, repeats=repeats) / count
        row(what, "1000", f"{fastest / each:.0f} ({1e6 * each:.1f} µs; {told})")


if __name__ == "__main__":
    main()
