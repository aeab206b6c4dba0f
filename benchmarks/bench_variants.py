"""A study of a whole truck: its variants in batches beside the same one by one.

    python benchmarks/bench_variants.py

Each variant is read, placed, turned and asked every quantity that limits ask about, in every
state. A wall, a point of the spring's table and a mass differ: all that follows is computed
anew, the whirl of the line as beams included.
"""

import sys
from pathlib import Path
from time import perf_counter

import numpy as np

from cardan.application import overrides, reader
from cardan.checks.line_response import compute_line_response
from cardan.checks.quantities.registry import LINE_QUANTITIES
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

TRUCK = Path(__file__).parents[1] / "examples" / "refuse-collector-6x2.yaml"
BETWEEN = {
    "driveline.shafts[2].tube.wall_mm": (3.0, 5.0),
    "suspension.spring.load_N[3]": (12600.0, 13000.0),
    "vehicle.loads.gvw.rear_axle_kg": (16000.0, 18000.0),
}
VARIANTS, BATCH, ALONE = 256, 64, 20


def main() -> None:
    """Print the rows."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else VARIANTS
    truck, rng = reader.read(TRUCK), np.random.default_rng(1)
    drawn = {at: rng.uniform(low, high, count) for at, (low, high) in BETWEEN.items()}

    def ask(where: slice | int, skip: tuple[str, ...] = ()) -> None:
        changed = overrides.change(truck, {at: values[where] for at, values in drawn.items()})
        response = compute_line_response(
            changed, line_state_demand(resolve_line_references(changed, changed.lines[0]))
        )
        for key, q in LINE_QUANTITIES.items():
            if key not in skip:
                q.values(response)

    def seconds(places: list[slice] | list[int], *skip: str) -> float:
        start = perf_counter()
        for where in places:
            ask(where, skip)
        return perf_counter() - start

    batches = [slice(i, i + BATCH) for i in range(0, count, BATCH)]
    print("| what | target | measured |\n| --- | --- | --- |")
    for what, skip in (
        ("every quantity", ()),
        ("the same without the line as beams", ("critical_speed_ratio", "half_critical_band")),
    ):
        seconds([0], *skip)
        alone = seconds(list(range(ALONE)), *skip) / ALONE
        batch = seconds(batches, *skip)
        print(
            f"| {count} variants of wall, spring and mass one by one over a batch, {what} | 10 "
            f"| {alone * count / batch:.0f} ({1e3 * alone:.1f} ms; {1e6 * batch / count:.0f} µs a "
            "variant) |"
        )


if __name__ == "__main__":
    main()
