#!/usr/bin/env bash
# RPC III: rpc-reader 0.9 and rpc3-file 1.0.0rc6 read different values, other channels' samples, and
# another length from one valid file.
#
# Valid input: 300 samples of two channels, 16-bit, in groups of 128 points of four frames of 32,
# ten frames in all; the last group is stored whole and filled up with zeros, as MTS, RPC File
# Formats, "Time History Files", has it. INT_FULL_SCALE is the format's default, 32752; SCALE is
# 0.01 and 1.
#
# Guess: both readers give number times SCALE, 300 samples or 320 with the filling, and agree.
#
# Seen:
# - rpc-reader multiplies by INT_FULL_SCALE/32768 besides: 29.985 for 30.000. By the format SCALE is
#   the "value used to multiply the binary 16-bit converter value" (10 V/32752 = 3.053249E-04), and a
#   file of nCode states a largest value that agrees with it (SignalExample.rsp of RPC3.js).
# - rpc-reader takes the last group for as short as its frames: from sample 256 on, where a whole
#   group begins, "second" holds what is the filling and the end of "first". Sample 260 of "second"
#   is 2260, and 0 is read.
# - rpc3-file keeps one zero of the filling: 301 samples, and the last is a step down to 0 from 2299,
#   one half cycle that nobody drove.
#
# Run by hand: bash findings/rpc_readers.sh. Needs Python 3.11 or later and a package index. It fails
# if the output is another one.
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
python3 -m venv "$here/venv"
"$here/venv/bin/pip" install --quiet rpc-reader==0.9 rpc3-file==1.0.0rc6 numpy==2.4.6 tqdm==4.70.1
cd "$here"
"$here/venv/bin/python" > seen <<'PYTHON'
import contextlib
import io
import warnings

import numpy as np
import rpc3
from rpc_reader.rpc_reader import ReadRPC

N, POINTS = 300, 128
stored = np.stack([np.full(N, 3000), 2000 + np.arange(N)])
head = {
    "FORMAT": "BINARY_IEEE_LITTLE_END", "NUM_HEADER_BLOCKS": "", "NUM_PARAMS": "",
    "FILE_TYPE": "TIME_HISTORY", "TIME_TYPE": "RESPONSE", "DATA_TYPE": "SHORT_INTEGER",
    "DELTA_T": "3.906250E-03", "CHANNELS": 2, "PTS_PER_FRAME": 32, "PTS_PER_GROUP": POINTS,
    "FRAMES": 10, "INT_FULL_SCALE": 32752, "HALF_FRAMES": 0, "REPEATS": 1, "BYPASS_FILTER": 0,
    "PARTITIONS": 1, "PART.CHAN_1": 1, "PART.NCHAN_1": 2,
}
for k, (name, scale) in enumerate((("first", "1.000000E-02"), ("second", "1.000000E+00")), 1):
    head |= {f"DESC.CHAN_{k}": name, f"UNITS.CHAN_{k}": "N", f"SCALE.CHAN_{k}": scale,
             f"UPPER_LIMIT.CHAN_{k}": 1.0, f"LOWER_LIMIT.CHAN_{k}": -1.0, f"MAP.CHAN_{k}": k}
blocks = -(-len(head) // 4)
head["NUM_HEADER_BLOCKS"], head["NUM_PARAMS"] = blocks, len(head)
header = b"".join(k.encode().ljust(32, b"\0") + str(v).encode().ljust(96, b"\0")
                  for k, v in head.items()).ljust(512 * blocks, b"\0")
filled = np.pad(stored, ((0, 0), (0, -N % POINTS))).reshape(2, -1, POINTS).astype("<i2")
with open("a.rsp", "wb") as file:
    file.write(header + np.ascontiguousarray(filled.swapaxes(0, 1)).tobytes())

rpc3.rpc3.progressbar = False
warnings.simplefilter("ignore")
channels, _ = rpc3.read("a.rsp")
first, second = (channel.data for channel in channels)
print(f"rpc3-file   samples {len(first)}, first[0] {first[0]:.3f}, second[260] {second[260]:.0f}, "
      f"last two of second {second[-2]:.0f} {second[-1]:.0f}")
reader = ReadRPC("a.rsp")
with contextlib.redirect_stdout(io.StringIO()):
    reader.import_rpc_data_from_file()
first, second = reader.get_data().T
print(f"rpc-reader  samples {len(first)}, first[0] {first[0]:.3f}, second[260] {second[260]:.0f}, "
      f"ratio {first[0] / 30:.8f} = 32752/32768")
PYTHON
cat > expected <<'TEXT'
rpc3-file   samples 301, first[0] 30.000, second[260] 2260, last two of second 2299 0
rpc-reader  samples 320, first[0] 29.985, second[260] 0, ratio 0.99951172 = 32752/32768
TEXT
diff expected seen
