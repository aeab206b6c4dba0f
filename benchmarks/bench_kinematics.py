"""How fast lines turn: ratios measured side by side in one run, as rows of a table.

    python benchmarks/bench_kinematics.py

The engine is Drake, as tests/verify/engine.py drives it; `pip install .[oracles]`.
"""

import os
import sys
import time
import tracemalloc
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "verify"))

from engine import Mechanism

from cardan.core.arrays import in_chunks
from cardan.core.units import deg
from cardan.model.layout import Layout, direction_from_slopes, layout_from_slopes
from cardan.physics.kinematics.equivalent_angle import (
    KinematicExcitation,
    ae7_excitation,
    excitation_of_rotating_chain,
)
from cardan.physics.kinematics.joint_chain import rotate_chain

VARIANTS, SPEED, INERTIAS = 1_000_000, 260.0, (0.08, 0.07, 0.10)
RNG = np.random.default_rng(1)
SIDE, TOP = RNG.normal(0.0, 3 * deg, (2, VARIANTS, 4))
PHASES = RNG.choice([0.0, 90 * deg], (VARIANTS, 3)) + RNG.normal(0.0, 1 * deg, (VARIANTS, 3))

LINE = layout_from_slopes(
    side=np.array([4, 3, 2, 7, 3]) * deg,
    top=np.array([0, 1, -1, 0.5, 0]) * deg,
    lengths=[1.2, 1.1, 1.4],
)
YOKES = np.array([0.0, 90.0, 0.0]) * deg


def phasors(side: Any, top: Any, phases: Any) -> KinematicExcitation:
    """AE-7's excitation of variants, with inertia torques."""
    return ae7_excitation(side, top, phases=phases, speed=SPEED, inertias=INERTIAS)


def exact(side: Any, top: Any, phases: Any) -> KinematicExcitation:
    """The same from view angles, exactly: directions, phasors, peaks."""
    slopes = (np.cumsum(view, axis=-1) for view in (side, top))
    side, top = (np.concatenate([0 * s[:, :1], s], axis=-1) for s in slopes)
    line = rotate_chain(direction_from_slopes(side=side, top=top), phases=phases)
    return excitation_of_rotating_chain(line, speed=SPEED, inertias=INERTIAS)


def best(*works: Callable[[], object], rounds: int = 5) -> list[float]:
    """Shortest time of each, taking turns, so that all meet the same machine."""
    times = [[0.0] * rounds for _ in works]
    for k in range(rounds):
        for taken, work in zip(times, works, strict=True):
            start = time.perf_counter()
            work()
            taken[k] = time.perf_counter() - start
    return [min(taken) for taken in times]


def row(what: str, target: str, measured: str) -> None:
    """Print a row of the table."""
    print(f"| {what} | {target} | {measured} |")


def swept(
    work: Callable[..., KinematicExcitation], threads: int, variants: int
) -> Callable[[], KinematicExcitation]:
    """Return a sweep of the first so many variants, in chunks that suit the work."""
    size = 16384 if work is phasors else 4096

    def sweep() -> KinematicExcitation:
        with ThreadPoolExecutor(threads) as pool:
            cases = (SIDE[:variants], TOP[:variants], PHASES[:variants])
            return in_chunks(work, *cases, size=size, executor=pool)

    return sweep


def sweeps() -> None:
    """Rows of the sweeps: both kinds on one thread, two and all of them."""
    few = VARIANTS // 20
    cores = min(os.cpu_count() or 1, 4)
    times = best(
        *(swept(phasors, n, VARIANTS) for n in (1, 2, cores)),
        *(swept(exact, n, few) for n in (1, 2, cores)),
    )
    near, far = np.array(times[:3]) / VARIANTS, np.array(times[3:]) / few
    row("AE-7 sweep, 10⁶ four-joint variants, 2 threads", "well under 1 s", f"{times[1]:.2f} s")
    row(
        "exact sweep over AE-7 sweep, per variant, 1 and 2 threads",
        "within 200",
        f"{far[0] / near[0]:.0f} and {far[1] / near[1]:.0f} ({1e6 * far[0]:.1f} µs on 1 thread)",
    )
    for name, each in (("AE-7", near), ("exact", far)):
        row(
            f"{name} sweep on 2 and {cores} threads over 1",
            "grows with cores",
            f"{each[0] / each[1]:.2f} and {each[0] / each[2]:.2f} times as fast",
        )
    tracemalloc.start()
    kept = swept(phasors, 2, VARIANTS)()
    held, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert kept.torsional.angle.shape == (VARIANTS,)
    row(
        "AE-7 sweep, memory at its peak over that of its results",
        "bounded by chunks",
        f"{most / held:.2f} ({held / 2**20:.0f} MiB of results)",
    )


def turns() -> None:
    """Rows of one line round a turn against the engine, each asked the same of every angle."""

    def engine(angles: int) -> Callable[[], object]:
        mechanism = Mechanism(LINE.points, LINE.directions, YOKES)
        theta = 2 * np.pi * np.arange(angles) / angles
        return lambda: [mechanism.motion(t) for t in theta]

    def ours(layout: Layout, angles: int, repeats: int) -> Callable[[], object]:
        def work() -> object:
            for _ in range(repeats):
                line = rotate_chain(layout.directions, phases=YOKES, samples=angles)
                kept = line.lead, line.speed, line.acceleration
            return kept

        return work

    many = Layout(points=LINE.points, directions=np.repeat(LINE.directions[None], 100, axis=0))
    for angles in (64, 360):
        slow, single, batch = best(
            engine(angles), ours(LINE, angles, 100), ours(many, angles, 1), rounds=7
        )
        row(
            f"engine over exact turn of one four-joint line, {angles} angles",
            "1000",
            f"{slow / single * 100:.0f} ({1e4 * single:.0f} µs; engine {1e3 * slow:.0f} ms)",
        )
        row(
            f"the same, a line among 100 in one call, {angles} angles",
            "1000",
            f"{slow / batch * 100:.0f}",
        )


if __name__ == "__main__":
    print("| what | target | measured |\n| --- | --- | --- |")
    sweeps()
    turns()
