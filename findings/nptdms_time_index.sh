#!/usr/bin/env bash
# npTDMS 1.13.0: as_dataframe(time_index=True) lays channels that begin at different instants side by
# side as if they had begun together; with absolute_time=True it does not.
#
# Valid input: a gauge from 08:00:00 on, and a speed that a bus began 3 s later, as its
# wf_start_time says; both hold the time of day as their values, seconds after 08:00:00.
#
# Guess, written before the script was run: the speed begins in the row of 3 s, with empty cells
# before it.
#
# Seen: the speed's first sample stands in the row of 0 s: each channel's time counts from its own
# start. Its last 3 s are empty, as if the bus had ended early. A shaft angle by that table is 3 s
# off. With absolute_time=True the rows are instants, and the speed begins at 3 s.
#
# Run by hand: bash findings/nptdms_time_index.sh. Needs Python 3.11 or later and a package index. It
# fails if the output is another one.
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
python3 -m venv "$here/venv"
"$here/venv/bin/pip" install --quiet npTDMS==1.13.0 numpy==2.4.6 pandas==3.1.1
cd "$here"
"$here/venv/bin/python" > seen <<'PYTHON'
import numpy as np
from nptdms import ChannelObject, TdmsFile, TdmsWriter

begin = np.datetime64("2026-01-01T08:00:00", "us")


def channel(name, late, seconds):
    about = {"wf_increment": 0.5, "wf_start_offset": 0.0, "wf_samples": len(seconds),
             "wf_start_time": begin + np.timedelta64(late, "s")}
    return ChannelObject("g", name, seconds, about)


time = np.arange(0, 10, 0.5)
with TdmsWriter("a.tdms") as writer:
    writer.write_segment([channel("S1", 0, time), channel("speed", 3, time[6:])])
group = TdmsFile.read("a.tdms")["g"]
for how in ({}, {"absolute_time": True}):
    table = group.as_dataframe(time_index=True, **how)
    speed = table["speed"].dropna()
    row = table.index.get_loc(speed.index[0])
    print(f"{how}: speed of {speed.iloc[0]:g} s beside S1 of {table['S1'].iloc[row]:g} s, "
          f"empty after it: {len(table) - row - len(speed)}")
PYTHON
cat > expected <<'TEXT'
{}: speed of 3 s beside S1 of 0 s, empty after it: 6
{'absolute_time': True}: speed of 3 s beside S1 of 3 s, empty after it: 0
TEXT
diff expected seen
