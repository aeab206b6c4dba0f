"""What only reports need: libraries of the extra `report`, imported where they are used."""

from importlib import import_module
from typing import Any

from cardan.core.errors import MissingDependencyError


def import_optional(module: str) -> Any:
    """Return a library of the extra `report`.

    Raises
    ------
    MissingDependencyError
        If it is not installed; the message says how to install it.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name != module.partition(".")[0]:
            raise
        msg = f"this report needs {module}: install it with  pip install 'cardan[report]'"
        raise MissingDependencyError(msg) from None
