"""Arrays: their types, whose library they belong to, and many cases at a time."""

import os
import sys
from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from functools import cache, lru_cache
from threading import Lock
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from concurrent.futures import Executor

FloatArray: TypeAlias = npt.NDArray[np.float64]
ComplexArray: TypeAlias = npt.NDArray[np.complex128]
BoolArray: TypeAlias = npt.NDArray[np.bool_]
IntArray: TypeAlias = npt.NDArray[np.intp]
ArrayLike: TypeAlias = npt.ArrayLike


def array_namespace(*arrays: Any) -> Any:
    """Return the array library of the arguments: NumPy, unless one is of another.

    Functions that compute with what this returns, and with operators, run on any
    library that follows the Python array API (JAX, CuPy, PyTorch's compat layer).
    """
    for array in arrays:
        if not isinstance(array, np.ndarray) and hasattr(array, "__array_namespace__"):
            return array.__array_namespace__()
    return np


def array_library_and_floats(*values: Any, like: Any = None) -> tuple[Any, *tuple[FloatArray, ...]]:
    """Return the array library of the values, then each value as a real array of it.

    Numbers and lists become arrays of that library; NumPy's are in double precision. An
    array `like` counts for the library without being returned.
    """
    xp = array_namespace(like, *values)
    return xp, *(
        v if xp is not np and hasattr(v, "__array_namespace__") else xp.asarray(v, dtype=xp.float64)
        for v in values
    )


def stack_on_last_axis(values: Iterable[ArrayLike]) -> FloatArray:
    """Return numbers, or arrays (...) of them, side by side on a new last axis, (..., n).

    In memory that axis comes first (`apart`).
    """
    columns = [np.asarray(v, dtype=float) for v in values]
    shapes = {c.shape for c in columns}  # of one there is nothing to find out: most are
    shape = shapes.pop() if len(shapes) == 1 else np.broadcast_shapes(*shapes)
    found = np.empty((len(columns), *shape))
    for k, column in enumerate(columns):
        found[k] = column
    return first_axis_last(found)


def first_axis_last(values: Any) -> Any:
    """Return arrays (n, ...) as (..., n): the first axis last, where it lies in memory."""
    return array_namespace(values).permute_dims(values, (*range(1, values.ndim), 0))


def stack_keeping_parts_contiguous(values: Iterable[Any], *, axis: int) -> Any:
    """Return arrays side by side on a new axis, each of them by itself in memory (`apart`)."""
    parts = list(values)
    found = array_namespace(*parts).stack(parts)
    order = list(range(1, found.ndim))
    order.insert(axis % found.ndim, 0)
    return array_namespace(found).permute_dims(found, tuple(order))


def make_components_contiguous(values: FloatArray, *, of: int = 1) -> FloatArray:
    """Return arrays (..., components) with each component of all cases by itself in memory.

    `of` is how many axes of components there are, the last ones. NumPy keeps the order that its
    arguments have, so what follows runs over long rows of cases, several times as fast as over
    three components of each.
    """
    first = (*range(values.ndim - of, values.ndim), *range(values.ndim - of))
    back = (*range(of, values.ndim), *range(of))
    return np.ascontiguousarray(values.transpose(first)).transpose(back)


@lru_cache(1024)
def broadcastable_axis_indices(shape: tuple[int, ...]) -> tuple[IntArray, ...]:
    """Return for each axis of a shape the index that steps along it, next to the others.

    `values[(which, *steps(which.shape))]` are, of `values` (P, ...), those at `which` (...).
    """
    return tuple(np.arange(n).reshape(n, *(1,) * (len(shape) - k)) for k, n in enumerate(shape, 1))


def unique_along_first_axis(values: FloatArray) -> tuple[tuple[IntArray, ...], IntArray]:
    """Return where numbers (P, ...) stand that no earlier one on the first axis is equal to.

    And which of those each number is: `values[where][which]` are the numbers.
    """
    first = (values[:, None] == values).argmax(axis=0)
    along, *others = broadcastable_axis_indices(values.shape)
    new = first == along
    count = new.cumsum().reshape(new.shape) - 1
    return np.nonzero(new), count[first, *others]


def collapse_broadcast_axes(values: FloatArray) -> FloatArray:
    """Return arrays without what they only repeat: 1 on each axis along which they broadcast."""
    if 0 not in values.strides:
        return values
    return values[tuple(slice(None) if step else slice(1) for step in values.strides)]


def stack_vectors_on_last_axes(
    points: Iterable[Iterable[ArrayLike]], *, size: int = 3
) -> FloatArray:
    """Return points of numbers or arrays (...) as vectors (..., n, size)."""
    columns = [stack_on_last_axis(c) for c in zip(*points, strict=True)]
    return (
        make_components_contiguous(stack_on_last_axis(columns), of=2)
        if columns
        else np.zeros((0, size))
    )


@contextmanager
def single_threaded_blas() -> Generator[None, None, None]:
    """Keep BLAS to one thread: on many small matrices its own cost far more than they bring.

    Of threads that are inside together the first sets that and the last takes it back: it holds
    for the whole process. The libraries are looked for by one thread while no other is inside
    (`_blas`), but where SciPy's came meanwhile.
    """
    scipys = "scipy.linalg" in sys.modules
    with _THREAD_COUNT_LOCK:
        if scipys not in _ORIGINAL_BLAS_LIMITS and True not in _ORIGINAL_BLAS_LIMITS:
            _ORIGINAL_BLAS_LIMITS[scipys] = _blas(scipys).limit(limits=1, user_api="blas")
        _SINGLE_THREADED_CALLS.append(None)
    try:
        yield
    finally:
        with _THREAD_COUNT_LOCK:
            _SINGLE_THREADED_CALLS.pop()
            while _ORIGINAL_BLAS_LIMITS and not _SINGLE_THREADED_CALLS:
                _ORIGINAL_BLAS_LIMITS.popitem()[1].restore_original_limits()


_THREAD_COUNT_LOCK = Lock()
_SINGLE_THREADED_CALLS: list[None] = []
"""One for each thread, and each call of it, that keeps BLAS to one thread."""

_ORIGINAL_BLAS_LIMITS: dict[bool, Any] = {}
"""What takes that back: of NumPy's, and of SciPy's where its linear algebra was there."""


MALLOC_TRIM_VARIABLE = "MALLOC_TRIM_THRESHOLD_"
"""The variable that sets when the GNU C library gives memory back."""


@contextmanager
def retain_freed_memory() -> Generator[None, None, None]:
    """Keep what arrays give back, in a process that was set to hand it to the system at once.

    Dask sets its workers so: then arrays, which come and go, cost twice their time. Given where to
    trim, the C library no longer learns either from which size on memory is worth a mapping of its
    own: every array of 128 KiB is one, whose pages are all faulted in anew. The last of several
    threads that are inside together goes back to what was set.
    """
    told = os.environ.get(MALLOC_TRIM_VARIABLE)
    if told is None or not sys.platform.startswith("linux"):
        yield
        return
    import ctypes

    adjust: Any = getattr(ctypes.CDLL(None), "mallopt", None)  # other C libraries have none
    trim, mapped = -1, -3  # M_TRIM_THRESHOLD, M_MMAP_THRESHOLD
    if adjust is None:
        yield
        return
    with _THREAD_COUNT_LOCK:
        _RETAINING_CALLS.append(None)
        adjust(trim, 2**28)
        adjust(mapped, 2**25)  # as far as it would learn by itself
    try:
        yield
    finally:
        with _THREAD_COUNT_LOCK:
            _RETAINING_CALLS.pop()
            if not _RETAINING_CALLS:
                adjust(trim, int(told))
                adjust(mapped, 2**17)  # where it begins


_RETAINING_CALLS: list[None] = []
"""One for each thread that keeps memory."""


@cache
def _blas(scipys: bool) -> Any:  # noqa: FBT001  a key of the cache
    """Return what controls the threads of BLAS; to look for it takes milliseconds.

    While one thread looks, no other may load a library: the look holds the loader's lock and waits
    for the interpreter, the loading thread holds the interpreter and waits for the loader's. A
    worker of a cluster, with threads of which one began its first shard while another imported what
    its own needed, stood still for ever.
    SciPy brings one of its own, which is there once its linear algebra is: `scipys`.
    """
    del scipys
    from importlib import import_module  # untyped, and a check of one design needs none

    return import_module("threadpoolctl").ThreadpoolController()


def in_chunks(
    function: Callable[..., Any],
    *arrays: Any,
    size: int = 4096,
    executor: "Executor | None" = None,
) -> Any:
    """Return function(*arrays), computed for `size` cases at a time on every core.

    Parameters
    ----------
    function
        Takes arrays with cases on axis 0 and returns an array, or a dataclass, tuple or
        dict of them, with cases on axis 0 as well. What all cases share it brings along
        (`functools.partial`).
    arrays : (cases, ...)
        The cases, the same number in each.
    size
        Cases in a chunk: few enough that a chunk's arrays stay in the processor's cache,
        which is also all the memory the work needs besides arguments and results.
    executor
        Where the chunks are computed; by default threads, one for each core. NumPy lets
        go of the interpreter while it computes, so threads serve it as processes would.

    Raises
    ------
    ValueError
        If the arrays disagree on the number of cases.
    """
    from concurrent.futures import ThreadPoolExecutor  # a check of one design needs none

    counts = {a.shape[0] for a in arrays}
    if len(counts) != 1:
        msg = f"all arrays must hold the same number of cases, got {sorted(counts)}"
        raise ValueError(msg)
    cases = counts.pop()
    pieces = [slice(i, min(i + size, cases)) for i in range(0, max(cases, 1), size)]
    if len(pieces) == 1:
        return function(*arrays)

    def work(piece: slice) -> Any:
        return function(*(a[piece, ...] for a in arrays))

    if executor is not None:
        return _joined(executor.map(work, pieces))
    with single_threaded_blas(), ThreadPoolExecutor(os.cpu_count()) as threads:
        return _joined(threads.map(work, pieces))


def _joined(parts: Iterable[Any]) -> Any:
    """Return results of neighbouring chunks as one, field by field."""
    first, *_ = parts = list(parts)
    if is_dataclass(first) and not isinstance(first, type):
        names = [f.name for f in fields(first) if f.init]
        return type(first)(**{k: _joined(getattr(p, k) for p in parts) for k in names})
    if isinstance(first, dict):
        return {key: _joined(p[key] for p in parts) for key in first}
    if isinstance(first, tuple):
        return tuple(_joined(column) for column in zip(*parts, strict=True))
    if not hasattr(first, "shape"):
        return first  # no array: the same for every case
    return array_namespace(first).concat(parts)
