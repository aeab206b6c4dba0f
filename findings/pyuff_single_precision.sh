#!/usr/bin/env bash
# pyuff 2.5.0: a binary dataset 58 that it writes in single precision holds doubles; read back by
# pyuff it has twice as many values, most of them no sample's.
#
# Valid input: 1000 samples of a sine, evenly spaced, ord_data_type 2 (real, single precision),
# binary 1, force_double False, by the arguments that pyuff documents.
#
# Guess: 1000 values, each within 1e-7 of its sample.
#
# Seen: the head says single precision, 1000 values and 4000 bytes; 8000 bytes follow, doubles.
# Reading gives 2000 values, one in two of them the upper half of a double. By the format's
# description (UC-SDRL, Binary 58 Universal File Format) the type decides, and the file is wrong. In
# text single precision is written and read back as it should be.
#
# Run by hand: bash findings/pyuff_single_precision.sh. Needs Python 3.11 or later and a package
# index. It fails if the output is another one.
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
python3 -m venv "$here/venv"
"$here/venv/bin/pip" install --quiet pyuff==2.5.0 numpy==2.4.6 tqdm==4.70.1
cd "$here"
"$here/venv/bin/python" -W ignore > seen <<'PYTHON'
import numpy as np
import pyuff

t = np.arange(1000) / 1024
x = np.sin(20 * t)
for binary in (0, 1):
    dataset = pyuff.prepare_58(
        binary=binary, func_type=1, rsp_node=1, rsp_dir=3, ref_node=1, ref_dir=3, data=x, x=t,
        id1="S1", abscissa_spacing=1, abscissa_spec_data_type=17, ordinate_spec_data_type=2,
        orddenom_spec_data_type=0, z_axis_spec_data_type=0, ord_data_type=2,
    )
    name = f"{'binary' if binary else 'text'}.uff"
    pyuff.UFF(name).write_sets([dataset], mode="add", force_double=False)
    read = pyuff.UFF(name).read_sets()
    read = read[0] if isinstance(read, list) else read
    y = read["data"]
    near = len(y) == len(x) and bool(np.abs(y - x).max() < 1e-5)
    print(f"{name}: type {read['ord_data_type']}, states {int(read['num_pts'])} values, "
          f"{len(y)} are read, equal to the samples: {near}")
data = open("binary.uff", "rb").read()
lines = data.split(b"\n", 13)
stated = int(lines[1][31:43])
print(f"bytes stated {stated}, bytes there {len(lines[13]) - len(b'    -1') - 1}")
PYTHON
cat > expected <<'TEXT'
text.uff: type 2, states 1000 values, 1000 are read, equal to the samples: True
binary.uff: type 2, states 1000 values, 2000 are read, equal to the samples: False
bytes stated 4000, bytes there 8000
TEXT
diff expected seen
