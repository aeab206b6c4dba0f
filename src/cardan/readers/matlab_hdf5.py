"""Variables of a MATLAB file of level 7.3 (save -v7.3), which is HDF5.

An array is a dataset whose axes stand the other way round; a struct is a group, an array of
structs a group of datasets of references, a cell a dataset of references.

Source: MathWorks, save, version 7.3; it writes the attributes `MATLAB_class` and `MATLAB_empty`.
"""

from pathlib import Path
from typing import Any

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.readers.base import attribute_text, unreadable_recording_error
from cardan.readers.hdf5 import check_dataset, open_hdf5_file
from cardan.readers.matlab_variables import MAX_DEPTH, MAX_TEXT_LETTERS, MAX_VARIABLES, Variable

_NUMBER_CLASSES = (
    "double", "single", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64",
    "logical", "",
)  # fmt: skip
MAX_CELLS = 2048
"""Parts of a cell or of an array of structs that are looked at."""


def open_v73(path: Path) -> list[Variable]:
    """Return the variables of a MATLAB file of level 7.3, and of their structs and cells."""
    import h5py  # pyright: ignore[reportMissingTypeStubs]

    file = open_hdf5_file(path)
    found: list[Variable] = []
    try:
        for name in file:
            # Behind # MATLAB keeps what references lead to; other links may lead out of the file.
            if not name.startswith("#") and isinstance(file.get(name, getlink=True), h5py.HardLink):
                _add(path, file, file[name], name, found, depth=0)
    except (OSError, RuntimeError, KeyError, TypeError, ValueError) as error:
        raise unreadable_recording_error(path, f"it is damaged: {error}") from error
    return found


def _add(path: Path, file: Any, item: Any, name: str, found: list[Variable], *, depth: int) -> None:
    import h5py  # pyright: ignore[reportMissingTypeStubs]

    if len(found) > MAX_VARIABLES:
        raise unreadable_recording_error(
            path, "it holds too many variables", value=f"over {MAX_VARIABLES}"
        )
    kind = attribute_text(item.attrs.get("MATLAB_class", ""))
    if isinstance(item, h5py.Group):
        if depth < MAX_DEPTH:
            for field in item:
                if isinstance(item.get(field, getlink=True), h5py.HardLink):
                    _add(path, file, item[field], f"{name}.{field}", found, depth=depth + 1)
        return
    if not isinstance(item, h5py.Dataset):
        return
    if item.shape is None:
        return
    check_dataset(path, name, item)
    shape, size = tuple(reversed(item.shape)), int(np.prod(item.shape))
    if item.attrs.get("MATLAB_empty", 0):
        return
    if item.dtype == h5py.ref_dtype:
        if depth < MAX_DEPTH and size <= MAX_CELLS:
            _add_parts(path, file, item, name, found, kind=kind, depth=depth)
        return
    if kind == "char" and item.dtype.kind in "ui" and size <= MAX_TEXT_LETTERS:
        letters = item[()].reshape(-1, shape[0]) if item.ndim == 2 else item[()].reshape(-1, 1)
        text = "".join(chr(int(n)) for n in letters[:, 0] if n)  # the first row
        found.append(Variable(name, shape, kind, texts=(text.strip(),)))
    elif kind in _NUMBER_CLASSES and item.dtype.kind in "fiu" and item.ndim:
        found.append(Variable(name, shape, kind or "double", read=_reader(path, item)))
    else:
        found.append(Variable(name, shape, kind or str(item.dtype)))


def _add_parts(
    path: Path, file: Any, item: Any, name: str, found: list[Variable], *, kind: str, depth: int
) -> None:
    """Add what the references of a cell or of an array of structs lead to."""
    references = item[()].reshape(-1)
    parts: list[Variable] = []
    # An array of structs is stored field by field: run.x of run(1), run(2).
    struct, _, field = name.rpartition(".")
    for k, reference in enumerate(references, 1):
        place = f"({k})" if len(references) > 1 else ""
        own = f"{name}{{{k}}}" if kind == "cell" else f"{struct}{place}.{field}"
        if reference:
            _add(path, file, file[reference], own, parts, depth=depth + 1)
    if kind == "cell" and parts and all(v.kind == "char" for v in parts):
        texts = tuple(v.texts[0] for v in parts)
        parts = [Variable(name, tuple(reversed(item.shape)), kind, texts=texts)]
    found += parts


def _reader(path: Path, item: Any) -> Any:
    """Return what reads the numbers of a dataset, as MATLAB counts them: its last axis last."""
    # HDF5 keeps the last axis together, which is MATLAB's first: the order is the same.
    inner = int(np.prod(item.shape[1:]))

    def read(first: int, many: int) -> FloatArray:
        try:
            if item.ndim == 1 or inner == 1:
                return item[first : first + many].astype(float).ravel()
            row, within = divmod(first, inner)
            if item.ndim == 2 and within + many <= inner:
                return item[row, within : within + many].astype(float)
            last = -(-(first + many) // inner)
            return item[row:last].astype(float).ravel()[within : within + many]
        except (OSError, RuntimeError) as error:
            raise unreadable_recording_error(path, f"it is damaged: {error}") from error

    return read
