"""Run the mutants: `python tests/mutants [WORDS...]`, from the repository's root.

Each mutant is made in a copy of `src` of its own, never where anybody works, and the tests
that ought to notice it are run on that copy, two at a time. Nothing is written but the table.
With words only the mutants are run whose file or words hold one of them.

Exit code 0 where every mutant is noticed, 1 where one survives or its text is no longer
found; the list is to be maintained like any other.
"""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from tempfile import TemporaryDirectory

from mutants import MUTANTS, ROOT, Mutant

AT_ONCE = 2
PATIENCE = 300.0
"""s: a mutant that makes its tests run longer is noticed by whoever waits for them."""

KILLED, BROKEN, SLOW, SURVIVED, LOST = "killed", "killed at import", "hangs", "SURVIVED", "LOST"
FAILED, NOT_RUN = 1, 2  # how pytest ends


def say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


class Copy:
    """A copy of the package that tests can be run on."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.package = folder, folder / "src" / "cardan"
        shutil.copytree(ROOT / "src", folder / "src", ignore=shutil.ignore_patterns("__pycache__"))

    def tested(
        self, tests: tuple[str, ...], *options: str, patience: float | None = PATIENCE
    ) -> subprocess.CompletedProcess[str]:
        """Run tests on this copy."""
        known = dict(os.environ)
        known |= {
            "PYTHONPATH": str(self.folder / "src"),
            "OPENBLAS_NUM_THREADS": "1",
            "HYPOTHESIS_STORAGE_DIRECTORY": str(self.folder / "hypothesis"),
        }
        # A bracket's tests too, where its extra is installed, and slow ones: nobody else sees some.
        also = ("-m", "not oracle and not office and not browser")
        quietly = ("-q", "--tb=no", "-p", "no:cacheprovider", "--hypothesis-seed=0", *also)
        return subprocess.run(
            [sys.executable, "-B", "-m", "pytest", *quietly, *options, *tests],
            cwd=ROOT, env=known, timeout=patience, capture_output=True, text=True, check=False,
        )  # fmt: skip

    def outcome(self, mutant: Mutant, red: tuple[str, ...]) -> tuple[str, str]:
        """Make a mutant, ask its tests, and undo it: what became of it, and who noticed."""
        file = self.package / mutant.file
        sound = file.read_text(encoding="utf-8")
        if sound.count(mutant.text) != 1:
            return LOST, ""
        file.write_text(sound.replace(mutant.text, mutant.becomes), encoding="utf-8")
        try:
            found = self.tested(mutant.noticed_by, "-x", "-rfE", *(f"--deselect={r}" for r in red))
        except subprocess.TimeoutExpired:
            return SLOW, ""
        finally:
            file.write_text(sound, encoding="utf-8")
        noticed = next(failures(found.stdout), "")
        return {FAILED: KILLED, NOT_RUN: BROKEN}.get(found.returncode, SURVIVED), noticed


def failures(printed: str) -> Iterator[str]:
    """Yield the names of the tests that pytest says failed."""
    for line in printed.splitlines():
        if line.startswith(("FAILED ", "ERROR ")):
            yield line.split(" ", 1)[1].partition(" - ")[0]


def red_anyway(copies: "SimpleQueue[Copy]", mutants: tuple[Mutant, ...]) -> tuple[str, ...]:
    """Return the tests that fail without a mutant: they notice nothing."""
    tests = tuple(dict.fromkeys(t for m in mutants for t in m.noticed_by))
    copy = copies.get()
    try:
        found = copy.tested(tests, "-n", str(AT_ONCE), "-rfE", patience=None)
    finally:
        copies.put(copy)
    return tuple(dict.fromkeys(failures(found.stdout)))


def chosen(words: list[str]) -> Iterator[Mutant]:
    for mutant in MUTANTS:
        said = f"{mutant.file} {mutant.says}"
        if not words or any(word in said for word in words):
            yield mutant


def table(mutants: tuple[Mutant, ...], found: list[str]) -> Iterator[str]:
    """Yield the number of mutants by room, and how many survived."""
    yield f"{'room':<14}{'mutants':>8}{'killed':>8}{'survived':>10}"
    rows = {m.room: 0 for m in mutants}
    for room in [*rows, "all"]:
        mine = [f for m, f in zip(mutants, found, strict=True) if room in (m.room, "all")]
        bad = sum(f in (SURVIVED, LOST) for f in mine)
        yield f"{room:<14}{len(mine):>8}{len(mine) - bad:>8}{bad:>10}"


def main(words: list[str]) -> int:
    if any(word.startswith("-") for word in words):
        say(__doc__ or "")
        return 0
    begun, mutants = time.monotonic(), tuple(chosen(words))
    with TemporaryDirectory(prefix="cardan-mutants-") as folder:
        copies: SimpleQueue[Copy] = SimpleQueue()
        for k in range(AT_ONCE):
            copies.put(Copy(Path(folder) / str(k)))
        red = red_anyway(copies, mutants)
        for test in red:
            say(f"red without a mutant, so it notices nothing: {test}")

        def one(mutant: Mutant) -> str:
            copy, start = copies.get(), time.monotonic()
            try:
                found, by = copy.outcome(mutant, red)
            finally:
                copies.put(copy)
            took = f"{time.monotonic() - start:.0f} s"
            say(
                f"{found:<15} {took:>5}  {mutant.file}: {mutant.says}" + (f"  [{by}]" if by else "")
            )
            return found

        with ThreadPoolExecutor(AT_ONCE) as threads:
            found = list(threads.map(one, mutants))
    say("")
    for line in table(mutants, found):
        say(line)
    say(f"\n{time.monotonic() - begun:.0f} s")
    return 1 if red or {SURVIVED, LOST} & set(found) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
