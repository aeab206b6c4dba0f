#!/usr/bin/env bash
# openTorsion 0.3.2: dsim of a line that branches adds the torques of shafts, and calls a speed a torque.
#
# Valid input: an engine of 1 kg m2 on a shaft of 1000 N m/rad to a differential of 0.5 kg m2, and from
# there two like shafts of 400 N m/rad to a wheel of 2 kg m2 each. 100 N m on the engine from t = 0.
#
# Guess: three shaft torques and four speeds. Modes of the same assembly are right.
#
# Seen: three rows of torque and three of speed. The second is the sum of both wheel shafts, twice the
# torque of one; the third is the engine's speed in rad/s; the engine is missing among the speeds. Rows
# are made by the node at which a shaft begins. No warning. With the wheel shafts written from wheel to
# differential an IndexError is raised.
#
# Take torques from the states of `state_space()`, as the last lines do, or write the wheels as one.
#
# Run by hand: bash findings/opentorsion_branches.sh. Needs Python 3.11 or later and a package index. It
# fails if the output is another one.
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
python3 -m venv "$here/venv"
"$here/venv/bin/pip" install --quiet opentorsion==0.3.2 numpy==2.4.6 scipy==1.17.1
cd "$here"
"$here/venv/bin/python" -W ignore > seen <<'PYTHON'
import numpy as np
import opentorsion as ot
from scipy.linalg import expm

SHAFTS = ((0, 1, 1000.0, 2.0), (1, 2, 400.0, 1.0), (1, 3, 400.0, 1.0))
INERTIAS = (1.0, 0.5, 2.0, 2.0)
disks = [ot.Disk(node, I=inertia) for node, inertia in enumerate(INERTIAS)]
line = ot.Assembly([ot.Shaft(a, b, k=k, c=c) for a, b, k, c in SHAFTS], disk_elements=disks)
modes = np.sort(np.sqrt(np.abs(line.undamped_modal_analysis()[0].real)))
print("modes, rad/s:", *(f"{mode:.2f}" for mode in modes[1:]))

time = np.linspace(0, 1, 1001)
push = ot.TransientExcitation(4, time)
push.add_transient(0, np.full(len(time), 100.0))
torque, speed, _ = line.dsim(push)
print("dsim at 1 s: torques", *(f"{row[-1]:.2f}" for row in torque),
      "speeds", *(f"{row[-1]:.2f}" for row in speed))

A, B, _, _ = line.state_space()
step = expm(np.block([[A, 100 * B[:, :1]], [np.zeros((1, 9))]]) * 1e-3)
state = np.append(np.zeros(8), 1.0)
for _ in time[1:]:
    state = step @ state
turn, rate = state[:4], state[4:8]
print("its state space: torques",
      *(f"{k * (turn[a] - turn[b]) + c * (rate[a] - rate[b]):.2f}" for a, b, k, c in SHAFTS),
      "speeds", *(f"{value:.2f}" for value in rate))
try:
    ot.Assembly([ot.Shaft(0, 1, k=1000.0), *(ot.Shaft(n, 1, k=400.0) for n in (2, 3))],
                disk_elements=disks)
except IndexError:
    print("wheel shafts the other way round: IndexError")
PYTHON
cat > expected <<'TEXT'
modes, rad/s: 14.14 22.65 65.47
dsim at 1 s: torques 110.28 107.93 17.20 speeds 17.70 18.49 18.49
its state space: torques 110.28 53.97 53.97 speeds 17.20 17.70 18.49 18.49
wheel shafts the other way round: IndexError
TEXT
diff expected seen
