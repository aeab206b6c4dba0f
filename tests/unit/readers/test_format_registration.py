"""A new recording format is one module and one line: added here to a copy of the package."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import cardan
from cardan.readers import dispatch
from cardan.readers.dispatch import FORMAT_MODULES, formats_by_extension

MODULE = '''
"""Recordings of one column of bytes, 100 of them a second."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.physics.signals.recording import Channel
from cardan.readers.base import RecordingFileColumns, RecordingFormat


def open_bytes(path: Path, _group: str = "") -> RecordingFileColumns:
    """Open a recording of bytes."""

    def rows(places: tuple[int, ...]) -> Iterator[FloatArray]:
        yield np.fromfile(path, np.uint8).astype(float)[None][list(places)]

    return RecordingFileColumns(
        columns=(Channel("level"),), read_rows=rows, rate=100.0, samples=path.stat().st_size
    )


FORMAT = RecordingFormat(name="bytes", extensions=(".u8",), open_columns=open_bytes)
'''
READ = """
import sys
from pathlib import Path
from cardan.readers.dispatch import open_recording
found = open_recording(Path(sys.argv[1]))
print(found.names, found.rate, found.read_all().tolist())
"""


def test_new_format_needs_one_module_and_one_line(tmp_path):
    package = Path(cardan.__file__).parent
    copy = tmp_path / "cardan"
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("__pycache__", "static"))
    (copy / "readers" / "bytes.py").write_text(MODULE)
    registry = copy / "readers" / "dispatch.py"
    text = registry.read_text(encoding="utf-8")
    assert text.count("FORMAT_MODULES = (") == 1
    registry.write_text(
        text.replace("FORMAT_MODULES = (", 'FORMAT_MODULES = ("bytes", '), encoding="utf-8"
    )
    (tmp_path / "a.u8").write_bytes(bytes([1, 2, 250]))
    said = subprocess.run(
        [sys.executable, "-c", READ, str(tmp_path / "a.u8")], check=True, text=True,
        stdout=subprocess.PIPE, env=os.environ | {"PYTHONPATH": str(tmp_path)},
    ).stdout  # fmt: skip
    assert said.strip() == "('level',) 100.0 [[1.0, 2.0, 250.0]]"


def test_file_extensions_belong_to_one_format():
    formats = {one.name: one for one in formats_by_extension().values()}
    assert len(formats) == len(FORMAT_MODULES)
    extensions = [e for one in formats.values() for e in one.extensions]
    assert sorted(extensions) == sorted(formats_by_extension())
    assert all(e.startswith(".") and e == e.lower() for e in extensions)


def test_opening_module_imports_no_format():
    code = "import sys, cardan.readers.dispatch; print(*sys.modules)"
    modules = subprocess.run(
        [sys.executable, "-c", code], check=True, text=True, stdout=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    ).stdout.split()  # fmt: skip
    assert not {f"{dispatch.__package__}.{name}" for name in FORMAT_MODULES} & set(modules)
