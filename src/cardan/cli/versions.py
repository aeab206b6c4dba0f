"""Versions of all parts, for a report of a fault."""

import platform
import re
import subprocess
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

from cardan.core.version import __version__

_REQUIREMENT = re.compile(r"([\w.-]+)(?:.*extra == ['\"](\w+)['\"])?")
_DEVELOPERS_EXTRAS = {"test", "browser", "mutants", "oracles", "bench", "lint", "docs"}

_WITHOUT = {"numba": ": studies of many variants take 1.5 to 1.7 times as long (cardan[fatigue])"}
"""What the absence of a library costs, where nothing else says it."""


def version_lines() -> Iterator[str]:
    """Yield cardan's version and commit, Python's and the system's, and each library's."""
    commit = _commit()
    yield f"cardan {__version__}" + (f", commit {commit}" if commit else "")
    yield f"Python {platform.python_version()}, {platform.platform()}"
    needed = [m for r in requires("cardan") or () if (m := _REQUIREMENT.match(r))]
    for name in sorted({m[1].lower() for m in needed if m[2] not in _DEVELOPERS_EXTRAS}):
        try:
            yield f"{name} {version(name)}"
        except PackageNotFoundError:
            yield f"{name} not installed" + _WITHOUT.get(name, "")


def _commit() -> str:
    """Return the commit of a copy of the repository; "" of an installed package."""
    root = Path(__file__).parents[3]
    if not (root / ".git").exists():
        return ""
    command = ["git", "-C", str(root), "rev-parse", "--short=12", "HEAD"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""
