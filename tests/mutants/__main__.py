"""Mutation testing of modules of the package, by cosmic-ray, in a copy of the source.

    python tests/mutants physics/loads/statics.py physics/strength --sample 40

Each sampled mutant is made in a copy of `src` and judged by the tests that mirror its module
(`tests/unit/physics/loads/test_statics.py`, or the folder), and by those of `--tests`. The seed
makes the sample repeatable. Exit code 1 if a mutant survives or the tests fail without one.
"""

import argparse
import os
import random
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from cosmic_ray.commands import init
from cosmic_ray.mutating import mutate_and_test
from cosmic_ray.work_db import WorkDB, use_db
from cosmic_ray.work_item import MutationSpec, TestOutcome

ROOT = Path(__file__).parents[2]
PACKAGE = Path("src") / "cardan"
TIMEOUT_S = 300.0
"""A mutant that makes its tests run longer counts as killed."""
EQUIVALENT = (
    "core/RemoveDecorator", "core/ReplaceBinaryOperator_BitOr", "core/NumberReplacer_Docstring",
)  # fmt: skip
"""Operators skipped: unions of types are written with |, and decorators declare."""


def tests_of(module: Path) -> list[str]:
    """Return the unit tests that mirror a module: its file, else the nearest folder."""
    folder = ROOT / "tests" / "unit" / module.parent
    own = folder / f"test_{module.stem}.py"
    if own.exists():
        return [str(own)]
    while not folder.exists():
        folder = folder.parent
    return [str(folder)]


def mutations_of(module: Path, database: Path) -> Iterator[MutationSpec]:
    """Yield every mutation that cosmic-ray knows for a module."""
    with use_db(str(database), WorkDB.Mode.create) as db:
        init([PACKAGE / module], db, {})
        for item in db.work_items:
            yield from (m for m in item.mutations if not m.operator_name.startswith(EQUIVALENT))


def judge(module: Path, extra: list[str], sample: int, seed: int) -> tuple[int, int]:
    """Test a sample of a module's mutants; return how many there were and how many survived."""
    tests = " ".join(map(shlex.quote, [*tests_of(module), *extra]))
    marks = "not oracle and not office and not browser and not long"
    command = (
        f"{shlex.quote(sys.executable)} -m pytest -q -x --tb=no -p no:cacheprovider "
        f"--hypothesis-seed=0 -m {shlex.quote(marks)} --rootdir {shlex.quote(str(ROOT))} "
        f"-c {shlex.quote(str(ROOT / 'pyproject.toml'))} {tests}"
    )
    if subprocess.run(shlex.split(command), capture_output=True, check=False).returncode:
        sys.stdout.write(f"{module}: its tests fail without a mutant\n")
        return 0, 1
    with tempfile.TemporaryDirectory() as folder:
        every = list(mutations_of(module, Path(folder) / "session.sqlite"))
    chosen = random.Random(seed).sample(every, min(sample, len(every)))
    survived = 0
    for mutation in chosen:
        result = mutate_and_test([mutation], command, TIMEOUT_S)
        if result.test_outcome is TestOutcome.SURVIVED:
            survived += 1
            sys.stdout.write(f"survived: {mutation.operator_name}\n{result.diff}\n")
            sys.stdout.flush()
    sys.stdout.write(f"{module}: {len(chosen)} of {len(every)} mutants, {survived} survived\n")
    return len(chosen), survived


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("modules", nargs="+", help="files or folders below src/cardan")
    parser.add_argument("--sample", type=int, default=20, help="mutants a module (default 20)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tests", nargs="*", default=[], help="further tests to run")
    given = parser.parse_args()
    extra = [
        str((ROOT / t.partition("::")[0]).resolve()) + "".join(t.partition("::")[1:])
        for t in given.tests
    ]
    with tempfile.TemporaryDirectory(prefix="cardan-mutants-") as copy:
        shutil.copytree(
            ROOT / "src", Path(copy) / "src", ignore=shutil.ignore_patterns("__pycache__")
        )
        os.chdir(copy)
        os.environ |= {"PYTHONPATH": str(Path(copy) / "src"), "OPENBLAS_NUM_THREADS": "1"}
        files = [
            file
            for name in given.modules
            for file in (
                sorted((PACKAGE / name).rglob("*.py"))
                if (PACKAGE / name).is_dir()
                else [PACKAGE / name]
            )
            if file.name != "__init__.py"
        ]
        found = [judge(f.relative_to(PACKAGE), extra, given.sample, given.seed) for f in files]
    return int(any(survived for _, survived in found))


if __name__ == "__main__":
    sys.exit(main())
