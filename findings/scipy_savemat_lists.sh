#!/usr/bin/env bash
# scipy 1.17.1: savemat writes a list of dicts as a cell array, and names of unequal length padded.
#
# Valid input: parameters of two shafts as a list of two dicts, names of two gauges as a list.
#
# Guess: a struct array of size 1 x 2, shaft(1).length in MATLAB, as one dict becomes a struct; and
# two names, as they are.
#
# Seen: shaft is a cell array, so shaft(1).length is an error there and shaft{1}.length is needed. The
# names are a matrix of characters, which pads: "S1 " for "S1". scipy reads them back padded too, so a
# channel is not found by its name.
#
# loadmat(simplify_cells=True) gives the list of dicts back either way: a round trip in Python shows
# nothing of it. A structured array of NumPy is written as a struct array, and an array of objects as
# cells with the names as they are. `cardan check --parameters` writes the former.
#
# Run by hand: bash findings/scipy_savemat_lists.sh. Needs Python 3.11 or later and a package index.
# It fails if the output is another one.
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
python3 -m venv "$here/venv"
"$here/venv/bin/pip" install --quiet scipy==1.17.1 numpy==2.4.6
cd "$here"
"$here/venv/bin/python" > seen <<'PYTHON'
import numpy as np
from scipy.io import loadmat, savemat, whosmat

shafts, names = [{"length": 1.2}, {"length": 1.5}], ["S1", "S12"]
structs = np.zeros((1, 2), dtype=[("length", object)])
structs["length"] = [[shaft["length"] for shaft in shafts]]
savemat("lists.mat", {"shaft": shafts, "gauge": names})
savemat("arrays.mat", {"shaft": structs, "gauge": np.array(names, dtype=object)})
for file in ("lists.mat", "arrays.mat"):
    kinds = {name: kind for name, _, kind in whosmat(file)}
    simple = loadmat(file, simplify_cells=True)
    again = [shaft["length"] for shaft in simple["shaft"]]
    print(f"{file}: shaft {kinds['shaft']}, gauge {kinds['gauge']}; read back: {again}, "
          f"{[str(name) for name in simple['gauge']]}")
PYTHON
cat > expected <<'TEXT'
lists.mat: shaft cell, gauge char; read back: [1.2, 1.5], ['S1 ', 'S12']
arrays.mat: shaft struct, gauge cell; read back: [1.2, 1.5], ['S1', 'S12']
TEXT
diff expected seen
