"""`cardan check` on a three-shaft truck, whole process, beside Python importing NumPy.

    python benchmarks/bench_check.py

The two run in turn, so that a machine whose speed drifts slows both; the ratio is taken
pair by pair, and its median counts.
"""

import subprocess
import sys
from pathlib import Path
from statistics import median
from time import perf_counter

TRUCK = Path(__file__).parents[1] / "examples" / "refuse-collector-6x2.yaml"
PAIRS = 15


def seconds(*command: str) -> float:
    """Return how long a process takes, start to end; its output is thrown away."""
    start = perf_counter()
    done = subprocess.run([sys.executable, *command], stdout=subprocess.DEVNULL, check=False)
    taken = perf_counter() - start
    assert done.returncode in (0, 1), "not a verdict: the file could not be read"
    return taken


def main() -> None:
    """Print the row."""
    check = ("-c", "from cardan.cli import cli; cli()", "check", str(TRUCK))
    numpy = ("-c", "import numpy")
    seconds(*check), seconds(*numpy)
    pairs = [(seconds(*check), seconds(*numpy)) for _ in range(PAIRS)]
    ratio = median(a / b for a, b in pairs)
    ours, theirs = (1e3 * median(side) for side in zip(*pairs, strict=True))
    print("| what | target | measured |\n| --- | --- | --- |")
    print(
        "| `cardan check` on a three-shaft truck over Python starting and importing NumPy | 3 "
        f"| {ratio:.2f} ({ours:.0f} ms over {theirs:.0f} ms) |"
    )


if __name__ == "__main__":
    main()
