#!/usr/bin/env bash
# pyLife 2.3.1: use_class_right() and use_class_left() change nothing of a from-to rainflow matrix.
#
# Valid input: a swing of 100 with a slower one of 40, counted by FourPointDetector; its collective as a
# from-to matrix (`LoopValueRecorder.histogram`) and as ranges (`range_histogram`), classes of 20; an S-N
# curve of slope 5 with 1e6 cycles at an amplitude of 50.
#
# Guess: the upper limits of classes ("use the upper limit of the class bins") make the damage of both
# larger and the lower ones smaller, by a fifth here.
#
# Seen: so for ranges. Of the matrix amplitudes and damage are those of the middles with either: both
# ends of a cycle move by half a class, and their difference stays. Mean stresses move instead. No
# warning. Whoever asks for upper limits to be safe is not.
#
# Take `range_histogram` where limits of classes count, or add a class to the ranges of a matrix.
#
# Run by hand: bash findings/pylife_class_limits.sh. Needs Python 3.11 or later and a package index. It
# fails if the output is another one.
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
python3 -m venv "$here/venv"
"$here/venv/bin/pip" install --quiet pylife==2.3.1 numpy==2.4.6 scipy==1.17.1
cd "$here"
"$here/venv/bin/python" -W ignore > seen <<'PYTHON'
import numpy as np
import pandas as pd
import pylife.strength.fatigue  # noqa: F401, registers `fatigue`
import pylife.stress.collective  # noqa: F401, registers `load_collective`
import pylife.stress.rainflow as rainflow

turn = np.arange(0, 200 * np.pi, 0.05)
load = np.round(100 * np.sin(turn) + 40 * np.sin(0.37 * turn)) + 0.5
recorder = rainflow.LoopValueRecorder()
rainflow.FourPointDetector(recorder=recorder).process(load)
curve = pd.Series({"k_1": 5.0, "ND": 1e6, "SD": 50.0})
whole = curve.fatigue.damage(recorder.collective.load_collective).sum()
matrix = recorder.histogram(bins=np.arange(-150, 151, 20.0))
ranges = recorder.collective.load_collective.range_histogram(np.arange(0, 301, 20.0)).to_pandas()
print(f"cycles as counted: damage {whole:.2e}")
for name, histogram in (("from-to matrix", matrix), ("ranges", ranges)):
    found = {
        "left": histogram.load_collective.use_class_left(),
        "middle": histogram.load_collective,
        "right": histogram.load_collective.use_class_right(),
    }
    damage = {side: curve.fatigue.damage(of).sum() / whole for side, of in found.items()}
    mean = {side: np.average(of.meanstress, weights=histogram) for side, of in found.items()}
    print(f"{name}: damage over that", ", ".join(f"{s} {d:.2f}" for s, d in damage.items()) + "; mean", ", ".join(f"{s} {m:.1f}" for s, m in mean.items()))
PYTHON
cat > expected <<'TEXT'
cycles as counted: damage 5.07e-03
from-to matrix: damage over that left 1.03, middle 1.03, right 1.03; mean left -9.6, middle 0.4, right 10.4
ranges: damage over that left 0.84, middle 1.03, right 1.26; mean left 0.0, middle 0.0, right 0.0
TEXT
diff expected seen
