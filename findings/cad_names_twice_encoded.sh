#!/usr/bin/env bash
# STEP: CadQuery 2.8.0 and build123d 0.13.0 write a part's name that has a letter beyond ASCII as UTF-8
# of UTF-8, and read it back as two letters.
#
# Valid input: an assembly of one box, named "Träger" (CadQuery's `name`, build123d's `label`).
#
# Guess: the file has the name in UTF-8 (ISO 10303-21, third edition: bytes c3 a4) or escaped
# (\X2\00E4\X0\), and either program reads "Träger" from its own file.
#
# Seen:
# - both files have the bytes c3 83 c2 a4: the letter's two bytes of UTF-8 were taken for two letters,
#   and each was encoded again. The kernel's strings are made of bytes, one letter each.
# - CadQuery reads "TrÃ¤ger" from its own file, build123d too.
# - the same kernel used by FreeCAD 0.20 writes c3 a4 (tests/unit/physics/fem/step_files).
#
# cardan decodes names until they are no UTF-8 any more, twice at most.
#
# Run by hand: bash findings/cad_names_twice_encoded.sh. Needs Python 3.11 or later and a package index
# (some 400 MB). It fails if the output is another one.
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
cd "$here"
cat > look.py <<'PYTHON'
import re
import sys
from pathlib import Path


def told(program, file, name):
    written = re.findall(rb"PRODUCT\('(Tr[^']*)'", Path(file).read_bytes())
    print(f"{program}: written {written[0].hex(' ')}, read back {name!r}")


if sys.argv[1] == "cadquery":
    import cadquery

    whole = cadquery.Assembly(name="line")
    whole.add(cadquery.Workplane("XY").box(1, 2, 3), name="Träger")
    whole.export("cadquery.step")
    again = cadquery.Assembly.importStep("cadquery.step")
    (name,) = (name for name in again.objects if name.startswith("Tr"))
    told("CadQuery 2.8.0", "cadquery.step", name)
else:
    import build123d

    box = build123d.Box(1, 2, 3)
    box.label = "Träger"
    build123d.export_step(build123d.Compound(label="line", children=[box]), "build123d.step")
    (again,) = build123d.import_step("build123d.step").children
    told("build123d 0.13.0", "build123d.step", again.label)
PYTHON
for package in cadquery==2.8.0 build123d==0.13.0; do
  name=${package%%=*}
  python3 -m venv "$here/$name"
  "$here/$name/bin/pip" install --quiet "$package"
  "$here/$name/bin/python" -W ignore look.py "$name"
done > seen
diff - seen <<'SEEN'
CadQuery 2.8.0: written 54 72 c3 83 c2 a4 67 65 72, read back 'TrÃ¤ger'
build123d 0.13.0: written 54 72 c3 83 c2 a4 67 65 72, read back 'TrÃ¤ger'
SEEN
cat seen
