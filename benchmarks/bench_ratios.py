"""This build beside an earlier one: processor time of whole commands, in turn, as ratios.

    python benchmarks/bench_ratios.py [OTHER] [--turns 3] [--only check fix]

OTHER is a folder with another build's `src`; without it the repository's commit `BASELINE` is
taken. Each turn runs `import numpy`, the other build and this one, one after the other, in the
environment as it is; the least of the turns counts, so that other work on the machine does not.
"""

import argparse
import os
import subprocess
import sys
from compileall import compile_dir
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[1]
BASELINE = "038023c7"
EXAMPLES = ("refuse-collector-6x2", "medium-truck-4x2", "van")
STUDY = """\
tolerances:
  bearing_height_mm[*]: {normal: 1.0}
  shim_deg: {normal: 0.167}
  phase_deg[*]: {normal: 0.667}
"""
VARIANTS = 1000
CAN_BE_STUDIED = EXAMPLES[:2]
"""Those that have a centre bearing, whose height scatters."""


def commands(folder: Path) -> dict[str, list[list[str]]]:
    """Return the command lines of each row, by what the row is called."""
    study = folder / "study.yaml"
    study.write_text(STUDY)
    files = {name: f"{folder}/examples/{name}.yaml" for name in EXAMPLES}
    many = ["--study", str(study), "--n", str(VARIANTS), "--workers", "1", "-q"]
    return {
        "start": [["check", "--help"]],
        "check": [["check", f] for f in files.values()],
        "fix": [["fix", f] for f in files.values()],
        "study": [["study", files[name], *many] for name in CAN_BE_STUDIED],
    }


def processor_seconds(source: Path | None, arguments: list[str]) -> float:
    """Return the processor time of a Python process, s, its system's share included."""
    environment = dict(os.environ)
    if source:
        environment["PYTHONPATH"] = str(source / "src")
    process = subprocess.Popen(
        [sys.executable, *arguments],
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode in (0, 1), f"no result of {' '.join(arguments)}"
    return used.ru_utime + used.ru_stime


def main() -> None:
    """Print the rows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("other", nargs="?", type=Path)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--only", nargs="+")
    given = parser.parse_args()
    with TemporaryDirectory() as name:
        folder = Path(name)
        # Both read the other build's files: what is new in this one's is unknown there.
        other = given.other or _exported(folder / "other")
        (folder / "examples").symlink_to(other.resolve() / "examples")
        for source in (other, ROOT):  # what is installed has its bytecode
            compile_dir(source / "src", quiet=1)
        print("| what | other, s | this, s | this over other | this over `import numpy` |")
        print("| --- | --- | --- | --- | --- |")
        for what, lines in commands(folder).items():
            for line in lines if not given.only or what in given.only else ():
                _print_row(what, line, other, given.turns)


def _print_row(what: str, line: list[str], other: Path, turns: int) -> None:
    sides = [
        (None, ["-c", "import numpy"]),
        (other, ["-m", "cardan", *line]),
        (ROOT, ["-m", "cardan", *line]),
    ]
    each = [[processor_seconds(*side) for side in sides] for _ in range(turns)]
    numpy, was, now = map(min, zip(*each, strict=True))
    name = Path(line[1]).stem if what != "start" else "`check --help`"
    print(
        f"| {what}, {name} | {was:.2f} | {now:.2f} | {now / was:.2f} | {now / numpy:.1f} |",
        flush=True,
    )


def _exported(folder: Path) -> Path:
    """Return a folder with the files of `BASELINE`."""
    folder.mkdir()
    archive = subprocess.run(
        ["git", "-C", str(ROOT), "archive", BASELINE], stdout=subprocess.PIPE, check=True
    )
    subprocess.run(["tar", "x", "-C", str(folder)], input=archive.stdout, check=True)
    return folder


if __name__ == "__main__":
    main()
