"""Libraries of the extras, imported where they are used."""

from importlib import import_module
from typing import Any

from cardan.core.errors import MissingDependencyError


def import_optional(module: str, *, extra: str = "report", purpose: str = "this report") -> Any:
    """Return a library of an extra of the package, needed for a purpose.

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
        msg = f"{purpose} needs {module}: install it with  pip install 'cardan[{extra}]'"
        raise MissingDependencyError(msg) from None
