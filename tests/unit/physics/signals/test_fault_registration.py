"""A new kind of fault costs a module and its entry in the registry, and nothing else.

A copy of the package gets a kind that nothing in it knows. The survey then finds it, a rule masks
it, and the command names it.
"""

import filecmp
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from repository import ROOT

MODULE = '''"""Ones: a supply that fails writes 1 and nothing else."""

import numpy as np

from cardan.physics.signals.faults.fault_kind import FaultKind, FaultSource
from cardan.physics.signals.faults.intervals import fault_intervals


class OnesDetector:
    """Finds samples of value 1."""

    def __init__(self, rate):
        self.runs = []

    def update(self, block):
        """Take a piece."""
        at = np.flatnonzero(block.samples == 1.0) + block.start
        self.runs += [(int(k), int(k) + 1) for k in at]

    def result(self, of):
        """Return where they are."""
        return {"ones": fault_intervals(self.runs)}


FAULT_SOURCE = FaultSource(kinds=(FaultKind(code="ones", maskable=True),), detector=OnesDetector)
'''

SURVEY = """
import json
import numpy as np
from cardan.physics.signals.conditioning import condition_pieces, survey_channel_signals
from cardan.physics.signals.data_quality import FaultRule, fault_treatment_variants
from cardan.physics.signals.conditioning import no_baseline

x = np.load("channel.npy")
(report,) = survey_channel_signals([x[None]], rate=500.0)
rules = [FaultRule(mask=True, kind="ones")]
(way, *_) = fault_treatment_variants({"S1": report}, rules=rules, rate=500.0, baseline=no_baseline)
treated = way.treatments["S1"](x, 0)
found = report.faults["ones"].runs[:, 0]
print(json.dumps([found.tolist(), np.flatnonzero(np.isnan(treated)).tolist()]))
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory) -> Path:
    """A copy of the package with a kind of fault more, and a channel that shows it."""
    root = tmp_path_factory.mktemp("faults")
    shutil.copytree(
        ROOT / "src" / "cardan", root / "cardan", ignore=shutil.ignore_patterns("__pycache__")
    )
    faults = root / "cardan" / "physics" / "signals" / "faults"
    (faults / "ones.py").write_text(MODULE, encoding="utf-8")
    registry = faults / "registry.py"
    text = registry.read_text(encoding="utf-8")
    for entry, more in (("    mains_hum,\n", "    ones,\n"),
                        ("    mains_hum.FAULT_SOURCE,\n", "    ones.FAULT_SOURCE,\n")):  # fmt: skip
        assert text.count(entry) == 1
        text = text.replace(entry, entry + more)
    registry.write_text(text, encoding="utf-8")
    x = 10 * np.random.default_rng(0).normal(size=20_000)
    x[[4000, 9000]] = 1.0
    np.save(root / "channel.npy", x)
    rows = [f"{k / 500:.3f},{v!r}" for k, v in enumerate(x.tolist())]
    (root / "run.csv").write_text("\n".join(["time_s,S1", *rows]) + "\n", encoding="utf-8")
    return root


def python(package: Path, *args: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *args], capture_output=True, text=True, cwd=package, check=False,
        encoding="utf-8", env={**os.environ, "PYTHONPATH": str(package)},
    )  # fmt: skip


def test_new_kind_changes_only_its_module_and_the_registry(package):
    ours, theirs = ROOT / "src" / "cardan", package / "cardan"
    changed = {
        file.name
        for file in theirs.rglob("*.py")
        if not (at := ours / file.relative_to(theirs)).exists()
        or not filecmp.cmp(file, at, shallow=False)
    }
    assert changed == {"ones.py", "registry.py"}


def test_new_kind_is_found_and_masked(package):
    done = python(package, "-c", SURVEY)
    assert done.returncode == 0, done.stderr
    found, masked = json.loads(done.stdout)
    assert found == masked == [4000, 9000]


@pytest.mark.slow
def test_command_names_new_kind(package):
    asks = ["-m", "cardan", "life", "run.csv", "--gauge", "S1:MPa", "--sn", "30,2e6,5"]
    done = python(package, *asks, "--all", "--json", "out.json")
    assert done.returncode in (0, 1), done.stderr
    (gauge,) = json.loads((package / "out.json").read_text(encoding="utf-8"))["gauges"]
    assert [e["kind"] for e in gauge["quality"]["suspects"]] == ["ones"]
    assert "samples that look wrong: 2; places: 2, the first at 8 s" in done.stdout
    done = python(package, *asks, "--mask", "ones", "-q")
    assert done.returncode in (0, 1), done.stderr
