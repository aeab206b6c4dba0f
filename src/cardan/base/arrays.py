"""Arrays: their types, and which library the caller's arrays belong to."""

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

FloatArray: TypeAlias = npt.NDArray[np.float64]
ComplexArray: TypeAlias = npt.NDArray[np.complex128]
ArrayLike: TypeAlias = npt.ArrayLike


def namespace(*arrays: Any) -> Any:
    """Return the array library of the arguments: NumPy, unless one is of another.

    Functions that compute with what this returns, and with operators, run on any
    library that follows the Python array API (JAX, CuPy, PyTorch's compat layer).
    """
    for array in arrays:
        if not isinstance(array, np.ndarray) and hasattr(array, "__array_namespace__"):
            return array.__array_namespace__()
    return np
