"""Run every benchmark, one after another, each in a process of its own: `make bench`."""

import os
import platform
import subprocess
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent


def main() -> None:
    """Print the machine, then each benchmark's rows."""
    print(
        f"{platform.machine()}, {os.cpu_count()} cores, {platform.system()}; Python "
        f"{platform.python_version()}, NumPy {np.__version__}"
    )
    missed: list[str] = []
    for script in sorted(HERE.glob("bench_*.py")):
        name = script.stem.removeprefix("bench_")
        print(f"\n## {name}\n", flush=True)
        if subprocess.run([sys.executable, str(script)], check=False).returncode:
            missed.append(name)
            print(f"\n**{name}: a target was missed, or it could not run: see above.**", flush=True)
    if missed:
        sys.exit(f"\nmissed: {', '.join(missed)}")


if __name__ == "__main__":
    main()
