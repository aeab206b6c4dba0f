"""Each kind of report of a three-shaft truck, whole process, and how large it is.

    python benchmarks/bench_report.py

A process reads the file, checks it, searches for corrections and writes one report; its
median over some runs counts.
"""

import subprocess
import sys
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

TRUCK = Path(__file__).parents[1] / "examples" / "refuse-collector-6x2.yaml"
RUNS = 5
TARGETS = {"html": (2.0, 2.0), "pdf": (3.0, None), "xlsx": (None, None)}
"""Seconds and megabytes that a report may take."""


def seconds(out: Path, kind: str) -> float:
    """Return how long a process takes to write a report."""
    command = ("-c", "from cardan.cli import cli; cli()", "check", str(TRUCK), "--quiet")
    start = perf_counter()
    done = subprocess.run(
        [sys.executable, *command, f"--{kind}", str(out)], capture_output=True, check=False
    )
    taken = perf_counter() - start
    assert done.returncode in (0, 1), done.stderr.decode()
    return taken


def main() -> None:
    """Print a row for each kind."""
    print("| report | target s | measured s | target MB | measured MB |")
    print("| --- | --- | --- | --- | --- |")
    with TemporaryDirectory() as folder:
        for kind, (most_seconds, most_megabytes) in TARGETS.items():
            out = Path(folder) / f"report.{kind}"
            seconds(out, kind)
            taken = median(seconds(out, kind) for _ in range(RUNS))
            print(
                f"| `--{kind}` | {most_seconds or '-'} | {taken:.2f} | {most_megabytes or '-'} "
                f"| {out.stat().st_size / 1e6:.2f} |"
            )


if __name__ == "__main__":
    main()
