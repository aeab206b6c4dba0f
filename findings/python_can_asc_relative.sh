#!/usr/bin/env bash
# python-can 4.6.1: a Vector ASC log whose header says "timestamps relative" is read as if it said
# "absolute": all frames come at one instant, and the first is lost if no line stands before it.
#
# Valid input: ten frames of one message, 0.1 s apart. Under "base hex  timestamps relative" CANoe
# writes of each event the seconds since the event before; the same log under "timestamps absolute"
# has them since the beginning. A third log has no line "internal events logged" between the header
# and the first frame.
#
# Guess, written before the script was run: the reader knows the word (it keeps it as
# timestamps_format), so that both logs give frames at 0.1 to 1.0 s; each of the three has ten.
#
# Seen: the relative log's ten frames all come at 0.1 s. A speed by them has no time axis, and a
# signal that is written as it changes has another one than the truth. The first frame of the third
# log is missing: the line that ends the header is read and dropped, whatever it is.
#
# Run by hand: bash findings/python_can_asc_relative.sh. Needs Python 3.11 or later and a package
# index. It fails if the output is another one.
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
python3 -m venv "$here/venv"
"$here/venv/bin/pip" install --quiet python-can==4.6.1 wrapt==1.17.3 packaging==26.3 \
  typing_extensions==4.16.0
cd "$here"
"$here/venv/bin/python" > seen <<'PYTHON'
import can

steps = [0.1] * 10
absolute = [sum(steps[: k + 1]) for k in range(10)]


def log(name, word, times, events="no internal events logged\n"):
    with open(name, "w") as file:
        file.write(f"date Mon Nov 30 10:00:00.000 2026\nbase hex  timestamps {word}\n{events}")
        for k, t in enumerate(times):
            file.write(f"   {t:.6f} 1  123             Rx   d 1 {k:02X}\n")
    frames = list(can.ASCReader(name))
    print(f"{name}: {len(frames)} frames, data {frames[0].data.hex()} to {frames[-1].data.hex()}, "
          f"at {frames[0].timestamp:.1f} to {frames[-1].timestamp:.1f} s")


log("absolute.asc", "absolute", absolute)
log("relative.asc", "relative", steps)
log("short.asc", "absolute", absolute, events="")
PYTHON
cat > expected <<'TEXT'
absolute.asc: 10 frames, data 00 to 09, at 0.1 to 1.0 s
relative.asc: 10 frames, data 00 to 09, at 0.1 to 0.1 s
short.asc: 9 frames, data 01 to 09, at 0.2 to 1.0 s
TEXT
diff expected seen
