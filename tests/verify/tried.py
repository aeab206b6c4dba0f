"""How often a finding is wrong of drives whose truth is known: counts of `VALIDATED_ERROR_RATES`.

    python tests/verify/tried.py [SEED+DRIVES ...] [--stop] [--bent]

Prints of each range of seeds what a row of docs/verification.md says, and their sum. A gauge that
is vetoed is judged by nobody, and is not counted.
"""

import sys
from collections import Counter

from proving_ground import drive
from test_proving_ground import heard, truths

from cardan.physics.signals.attribution_result import (
    JOINTS_DOMINANT,
    JOINTS_NOT_DOMINANT,
    UNDETERMINED,
)

AS_THEY_COME = "650000+100", "670000+200", "710000+200", "741000+150"


def counted(seeds, **asked):
    """Count the gauges of some drives, and what was found of them."""
    of = Counter()
    for seed in seeds:
        made = drive(seed, **asked)
        for truth, (life, found) in zip(truths(made), heard(made), strict=True):
            if life.vetoed:
                of["vetoed"] += 1
                continue
            low, high = found.interval
            of["gauges"] += 1
            of["inside"] += low <= truth <= high
            if truth >= 0.6 or truth <= 0.1:
                of["clear"] += 1
                of["told"] += found.verdict == (
                    JOINTS_DOMINANT if truth >= 0.6 else JOINTS_NOT_DOMINANT
                )
            if truth >= 0.5:
                of[JOINTS_DOMINANT] += 1
                of["acquitted"] += found.verdict == JOINTS_NOT_DOMINANT
            elif truth < 0.25:
                of[JOINTS_NOT_DOMINANT] += 1
                of["convicted"] += found.verdict == JOINTS_DOMINANT
            of[UNDETERMINED] += found.verdict == UNDETERMINED
    return of


def row(name, of):
    """Say it as docs/verification.md does."""
    share = {k: 100 * of[k] / max(of[n], 1) for k, n in (("inside", "gauges"), ("told", "clear"))}
    return (
        f"| {name} | {share['inside']:.0f} % of {of['gauges']} | {share['told']:.0f} % of "
        f"{of['clear']} | {of['acquitted']} of {of[JOINTS_DOMINANT]} | {of['convicted']} of "
        f"{of[JOINTS_NOT_DOMINANT]} "
        f"| {of['vetoed']} vetoed"
    )


def main(arguments):
    asked = {k[2:]: v for k, v in (("--stop", True), ("--bent", 1.2)) if k in arguments}
    ranges = [a for a in arguments if not a.startswith("--")] or AS_THEY_COME
    whole = Counter()
    for one in ranges:
        first, count = map(int, one.split("+"))
        of = counted(range(first, first + count), **asked)
        whole += of
        sys.stdout.write(row(one, of) + "\n")
        sys.stdout.flush()
    sys.stdout.write(row("together", whole) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
