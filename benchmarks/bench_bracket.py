"""A bracket at about 100k and 280k unknowns: nine unit loads and six modes, beside CalculiX.

    python benchmarks/bench_bracket.py

Both solve the same mesh of quadratic tetrahedra on two threads. CalculiX (Debian:
`apt-get install calculix-ccx`) solves six static steps and six modes. Each solver runs in
a process of its own, so that its peak memory is its own.
"""

import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "verify"))

import calculix
import numpy as np

from cardan.core.units import mm
from cardan.model.bracket import LShape
from cardan.model.material import STEEL
from cardan.physics.fem.geometry import build_solid
from cardan.physics.fem.unit_loads import mesh_and_solve_unit_loads

BRACKET = LShape(
    seat_diameter=52 * mm, width=180 * mm, wall_width=144 * mm, depth=90 * mm, thickness=8 * mm,
    height=80 * mm, rim=24 * mm, fillet=5 * mm, bolt_diameter=11 * mm, bolt_edge=14 * mm,
    gusset=8 * mm, gusset_height=50 * mm,
)  # fmt: skip
THREADS = "2"
SIZES = (4.3 * mm, 3.2 * mm)


def ours(size, folder):
    """Mesh, factorise, solve, modes; prints a row and leaves a deck for CalculiX."""
    start = last = time.perf_counter()
    laps = {}

    def lap(what):
        nonlocal last
        now = time.perf_counter()
        laps[what], last = now - last, now

    units = mesh_and_solve_unit_loads(build_solid(BRACKET), STEEL, size=size, hold="clamped")
    lap("mesh, factor, 9 loads")
    units.at_nodes  # noqa: B018  computed on first use
    lap("stresses at the nodes")
    frequencies = units.modes(6)[0]
    lap("6 modes")
    total = time.perf_counter() - start
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    parts = ", ".join(f"{what} {seconds:.1f} s" for what, seconds in laps.items())
    print(f"| {units.elastic.unknowns} | cardan | {total:.1f} | {peak:.0f} | {parts} |", flush=True)
    nodes = units.elastic.nodes
    loads = calculix.seat_loads(nodes)
    text = calculix.deck(
        nodes, STEEL, held=tuple(units.solid.fixed_faces("clamped")), loads=loads, modes=6
    )
    (folder / "deck.inp").write_text(text)
    np.savez(folder / "ours.npz", u=units.at_nodes[0][:, :6], frequencies=frequencies)


def theirs(folder):
    """Run CalculiX on the deck and compare."""
    static, frequencies, seconds = calculix.run((folder / "deck.inp").read_text(), folder)
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    kept = np.load(folder / "ours.npz")
    off = max(
        np.abs(u - kept["u"][:, k]).max() / np.abs(kept["u"][:, k]).max()
        for k, (u, _) in enumerate(static)
    )
    apart = np.abs(kept["frequencies"] / frequencies[:6] - 1).max()
    print(
        f"| {kept['u'].shape[0] * 3} | CalculiX | {seconds:.1f} | {peak:.0f} | "
        f"displacements agree to {off:.0e}, frequencies to {apart:.0e} |",
        flush=True,
    )


def main():
    if len(sys.argv) > 1:
        who, size, folder = sys.argv[1], float(sys.argv[2]), Path(sys.argv[3])
        if who == "ours":
            ours(size, folder)
        else:
            theirs(folder)
        return
    print(f"{platform.machine()}, {os.cpu_count()} cores, {THREADS} threads used\n")
    print("| unknowns | solver | s | MB | |\n|---|---|---|---|---|", flush=True)
    threads = {"NGS_NUM_THREADS": THREADS, "OPENBLAS_NUM_THREADS": THREADS}
    for size in SIZES:
        with tempfile.TemporaryDirectory() as folder:
            for who in ("ours", "theirs") if calculix.installed() else ("ours",):
                subprocess.run(
                    [sys.executable, __file__, who, str(size), folder],
                    check=True,
                    env=os.environ | threads,
                )


if __name__ == "__main__":
    main()
