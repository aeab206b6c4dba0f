#!/usr/bin/env bash
# npTDMS 1.13.0: a channel whose second segment states another wf_increment has one time track, by
# the last increment, for all of its samples, without a word.
#
# Valid input: a TDMS file of two segments, each with its own properties; the second, written
# after the logger was set from 1 kHz to 500 Hz, states 0.002 s. NI's format keeps the properties of
# each segment; a reader sees the newest by default.
#
# Guess, written before the script was run: 1000 samples of 0.001 s and 1000 of 0.002 s last
# 0.999 + 2.0 s; time_track() either ends near 3 s, or refuses to give one track for two steps.
#
# Seen: the track ends at 3.998 s, twice the true time for the first half. A cycle rate by that
# track is half of the true one there.
#
# Run by hand: bash findings/nptdms_increment.sh. Needs Python 3.11 or later and a package index. It
# fails if the output is another one.
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
python3 -m venv "$here/venv"
"$here/venv/bin/pip" install --quiet npTDMS==1.13.0 numpy==2.4.6
cd "$here"
"$here/venv/bin/python" > seen <<'PYTHON'
import numpy as np
from nptdms import ChannelObject, TdmsFile, TdmsWriter

with TdmsWriter("a.tdms") as writer:
    for step in (0.001, 0.002):
        about = {"wf_increment": step, "wf_start_offset": 0.0, "wf_samples": 1000}
        writer.write_segment([ChannelObject("g", "S1", np.arange(1000.0), about)])
channel = TdmsFile.read("a.tdms")["g"]["S1"]
time = channel.time_track()
print("samples", len(channel), "increment", channel.properties["wf_increment"])
print(f"first step {time[1] - time[0]:.3f} s, end {time[-1]:.3f} s")
PYTHON
cat > expected <<'TEXT'
samples 2000 increment 0.002
first step 0.002 s, end 3.998 s
TEXT
diff expected seen
