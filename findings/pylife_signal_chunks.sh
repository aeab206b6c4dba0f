#!/usr/bin/env bash
# pyLife 2.3.1: a signal of TimeSignalGenerator that is asked for in pieces jumps between them.
#
# Valid input: one sine of amplitude 1 and "frequency" 5, 100 samples a second, 2000 samples at once and
# as two times 1000, with the same seed.
#
# Guess: the same samples ("the newly delivered samples will smoothly attach to the previously queried
# ones"), 5 turns a second.
#
# Seen: the first piece is the same; at its end the signal jumps by 0.24, five times its largest step,
# and the second piece lies off by up to 0.26. Time is taken back by whole multiples of omega seconds in
# place of 2 pi/omega. The frequency is omega, rad/s: 0.8 turns a second. Each joint of pieces adds a
# reversal that the load does not have.
#
# Ask for all samples at once, and give 2 pi f.
#
# Run by hand: bash findings/pylife_signal_chunks.sh. Needs Python 3.11 or later and a package index. It
# fails if the output is another one.
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
python3 -m venv "$here/venv"
"$here/venv/bin/pip" install --quiet pylife==2.3.1 numpy==2.4.6 scipy==1.17.1
cd "$here"
"$here/venv/bin/python" -W ignore > seen <<'PYTHON'
import numpy as np
from pylife.stress.timesignal import TimeSignalGenerator

SINE = {"number": 1}
for name, value in (("amplitude", 1.0), ("frequency", 5.0), ("offset", 0.0)):
    SINE |= {f"{name}_median": value, f"{name}_std_dev": 0.0}


def generator():
    np.random.seed(1)
    return TimeSignalGenerator(100, SINE, None, None)


whole = generator().query(2000)
pieces = generator()
pieces = np.concatenate([pieces.query(1000), pieces.query(1000)])
up = np.flatnonzero((whole[:-1] < 0) & (whole[1:] >= 0))
print(f"turns a second: {100 / np.diff(up).mean():.2f}")
print(f"largest step: at once {np.abs(np.diff(whole)).max():.3f}, in pieces "
      f"{np.abs(np.diff(pieces)).max():.3f} before sample {np.abs(np.diff(pieces)).argmax() + 1}")
print(f"apart: first piece {np.abs(whole - pieces)[:1000].max():.3f}, "
      f"second {np.abs(whole - pieces)[1000:].max():.3f}")
PYTHON
cat > expected <<'TEXT'
turns a second: 0.80
largest step: at once 0.050, in pieces 0.244 before sample 1000
apart: first piece 0.000, second 0.265
TEXT
diff expected seen
