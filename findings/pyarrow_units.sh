#!/usr/bin/env bash
# pyarrow 26.0.1: Parquet files whose field states different units in its metadata become one column,
# with the first file's unit, whatever way they are joined.
#
# Valid input: two files of one field, S1: 100 with the unit MPa, and 1e8 with the unit Pa, the same
# stress.
#
# Guess, written before the script was run: the schemas differ, so a folder's reading and
# concat_tables refuse, or drop the unit.
#
# Seen: read_table of the folder, a dataset of it, concat_tables with and without promotion, and
# unify_schemas all keep "MPa" for both: a stress of 1e8 MPa without a word. Metadata of a field
# are no part of its type. (Schema.equals has check_metadata, false by default.)
#
# Run by hand: bash findings/pyarrow_units.sh. Needs Python 3.11 or later and a package index. It
# fails if the output is another one.
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
python3 -m venv "$here/venv"
"$here/venv/bin/pip" install --quiet pyarrow==26.0.1
cd "$here"
"$here/venv/bin/python" > seen <<'PYTHON'
from pathlib import Path

import pyarrow as pa
import pyarrow.dataset as ds
import pyarrow.parquet as pq


def table(unit, value):
    field = pa.field("S1", pa.float64(), metadata={"unit": unit})
    return pa.table({"S1": [value]}, schema=pa.schema([field]))


both = table("MPa", 100.0), table("Pa", 1e8)
Path("run").mkdir()
for k, one in enumerate(both):
    pq.write_table(one, f"run/{k}.parquet")
for name, joined in (
    ("read_table", pq.read_table("run")),
    ("dataset", ds.dataset("run").to_table()),
    ("concat_tables", pa.concat_tables(both)),
    ("concat_tables, promoted", pa.concat_tables(both, promote_options="default")),
):
    unit = joined.schema.field("S1").metadata[b"unit"].decode()
    print(f"{name}: {joined['S1'].to_pylist()} {unit}")
unified = pa.unify_schemas([one.schema for one in both])
print("unify_schemas:", unified.field("S1").metadata[b"unit"].decode())
print("schemas equal:", both[0].schema.equals(both[1].schema))
PYTHON
cat > expected <<'TEXT'
read_table: [100.0, 100000000.0] MPa
dataset: [100.0, 100000000.0] MPa
concat_tables: [100.0, 100000000.0] MPa
concat_tables, promoted: [100.0, 100000000.0] MPa
unify_schemas: MPa
schemas equal: True
TEXT
diff expected seen
