"""How often a finding is wrong of drives whose truth is known: the counts of `evidence.TRIED`.

    python tests/verify/tried.py [SEED+DRIVES ...] [--stop] [--bent]

Prints of each range of seeds what a row of docs/verification.md says, and their sum. A gauge that
is vetoed is judged by nobody, and is not counted.
"""

import sys
from collections import Counter

from proving_ground import drive
from test_proving_ground import heard, truths

from cardan.fatigue.evidence import CANNOT_TELL, GUILTY, INNOCENT

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
                of["told"] += found.finding == (GUILTY if truth >= 0.6 else INNOCENT)
            if truth >= 0.5:
                of[GUILTY] += 1
                of["acquitted"] += found.finding == INNOCENT
            elif truth < 0.25:
                of[INNOCENT] += 1
                of["convicted"] += found.finding == GUILTY
            of[CANNOT_TELL] += found.finding == CANNOT_TELL
    return of


def row(name, of):
    """Say it as docs/verification.md does."""
    share = {k: 100 * of[k] / max(of[n], 1) for k, n in (("inside", "gauges"), ("told", "clear"))}
    return (
        f"| {name} | {share['inside']:.0f} % of {of['gauges']} | {share['told']:.0f} % of "
        f"{of['clear']} | {of['acquitted']} of {of[GUILTY]} | {of['convicted']} of {of[INNOCENT]} "
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
