"""A study of the refuse collector's settings: variants a second of a core, and its memory.

    python benchmarks/bench_studies.py

Every limit in seven states at all operating points, bearings on rubber; and the limits of its
geometry alone. Seconds are the processor's, so that other work does not count.
"""

import resource
import sys
from pathlib import Path
from time import process_time

from cardan import files
from cardan.model.variants import Ask
from cardan.study.sweep import Bench, variants_of

TRUCK = Path(__file__).parents[1] / "examples" / "refuse-collector-6x2.yaml"
TOLERANCES = {
    "bearing_height_mm[*]": {"normal": 1.0},
    "shim_deg": {"normal": 0.167},
    "phase_deg[*]": {"normal": 0.667},
}
GEOMETRY = (
    "torsional_acceleration", "inertia_coast_acceleration", "inertia_drive_acceleration",
    "joint_angle", "joint_angle_min", "angle_for_speed", "clearance",
)  # fmt: skip
COUNT = 512


def main() -> None:
    """Print the rows."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    truck = files.read(TRUCK)
    print("| what | target | measured |\n| --- | --- | --- |")
    for what, limits in (("every limit", ()), ("limits of its geometry alone", GEOMETRY)):
        bench = Bench.of(truck, variants_of({}, TOLERANCES, ask=Ask(limits=limits)))
        bench.rows(0, 64)  # warm
        begun = process_time()
        bench.rows(0, count)
        rate = count / (process_time() - begun)
        print(f"| variants a second a core, {what} | 10000 | {rate:.0f} |")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"| memory at its peak, {count} variants | bounded | {peak:.0f} MiB |")


if __name__ == "__main__":
    main()
