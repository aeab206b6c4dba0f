"""Compiled loops run whether or not numba finds a folder for its cache."""

import importlib.util

import numpy as np
import pytest

from cardan.core.compiled import compiled

pytest.importorskip("numba")


@pytest.mark.slow
def test_loop_is_compiled_where_no_cache_folder_can_be_written(tmp_path, monkeypatch):
    """Neither beside the module nor in the user's folder: life and verify ended there."""
    (tmp_path / "loops.py").write_text("def total(x):\n    return x.sum()\n")
    (tmp_path / "__pycache__").touch()
    for folder in ("HOME", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.setenv(folder, str(tmp_path / "loops.py" / "folder"))
    spec = importlib.util.spec_from_file_location("loops", tmp_path / "loops.py")
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setattr("sys.dont_write_bytecode", True)
    spec.loader.exec_module(module)
    total = compiled(module.total)
    assert total(np.arange(4.0)) == 6.0
    assert total.signatures
