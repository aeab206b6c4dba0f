#!/usr/bin/env bash
# asammdf 8.8.28: samples that an MDF4 file marks invalid become valid ones where a channel is laid
# on another raster, written as a table or as MDF 3; mdfreader 4.3 gives their placeholder as
# values.
#
# Valid input: a channel of 10 s at 10 Hz, sin t in MPa, of which the samples from 3 s to 5.9 s have
# their invalidation bit set and hold the logger's placeholder, -999; a channel beside it is whole.
#
# Guess, written before the script was run: get() leaves the 30 samples out; a raster is filled from
# valid samples alone; a table (to_dataframe, export to CSV) is empty there; mdfreader gives a
# masked array.
#
# Seen: get() leaves them out. resample(0.05) reports a valid sample of -499.4 MPa: the mean of the
# placeholder and of the valid sample beside it. The table and the CSV file are complete: a straight
# line lies over the 3 s, up to 0.95 MPa off. convert("3.30"), a format without such bits, gives
# -999 MPa without a word. mdfreader gives -999 unless apply_all_invalid_bit is called.
#
# Run by hand: bash findings/asammdf_invalid_samples.sh. Needs Python 3.11 or later and a package
# index. It fails if the output is another one.
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
python3 -m venv "$here/venv"
"$here/venv/bin/pip" install --quiet asammdf==8.8.28 mdfreader==4.3 numpy==2.4.6 pandas==3.1.1
cd "$here"
"$here/venv/bin/python" -W ignore > seen <<'PYTHON'
import csv
import logging

import mdfreader
import numpy as np
from asammdf import MDF, Signal

logging.disable()
t = np.arange(100) / 10
invalid = (t >= 3) & (t < 6)
with MDF(version="4.10") as file:
    stress = Signal(np.where(invalid, -999.0, np.sin(t)), t, name="S1", unit="MPa",
                    invalidation_bits=invalid)
    file.append([stress, Signal(np.cos(t), t, name="S2")], common_timebase=True)
    file.save("a.mf4")


def show(name, values, times=None):
    off = "" if times is None else f", off by up to {np.nanmax(np.abs(values - np.sin(times))):.3f}"
    print(f"{name}: {len(values)} samples, {int(np.isnan(values).sum())} empty, smallest "
          f"{np.nanmin(values):.1f}{off}")


with MDF("a.mf4") as file:
    show("get", file.get("S1").samples)
    raster = file.resample(0.05).get("S1")
    show("resample", raster.samples)
    frame = file.to_dataframe()
    show("to_dataframe", frame.S1.to_numpy(), frame.index.to_numpy())
    file.export("csv", "a")
    with open("a.ChannelGroup_0_Python.csv", newline="") as table:
        rows = list(csv.DictReader(table))
    show("CSV", np.array([float(row["S1"] or "nan") for row in rows]), t)
    show("MDF 3.30", file.convert("3.30").get("S1").samples)
values = mdfreader.Mdf("a.mf4").get_channel_data("S1")
show(f"mdfreader, {type(values).__name__}", values)
PYTHON
cat > expected <<'TEXT'
get: 70 samples, 0 empty, smallest -0.5
resample: 139 samples, 0 empty, smallest -499.4
to_dataframe: 100 samples, 0 empty, smallest -0.5, off by up to 0.949
CSV: 100 samples, 0 empty, smallest -0.5, off by up to 0.949
MDF 3.30: 100 samples, 0 empty, smallest -999.0
mdfreader, ndarray: 100 samples, 0 empty, smallest -999.0
TEXT
diff expected seen
