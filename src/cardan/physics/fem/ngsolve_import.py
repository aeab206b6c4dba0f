"""The finite element engine, fetched when first used, and what to install where it is not."""

from importlib import import_module
from typing import Any, NamedTuple

from cardan.core.errors import MissingDependencyError


class NgSolveModules(NamedTuple):
    """NGSolve, Netgen's interface to the OpenCASCADE kernel, and its mesher."""

    ngs: Any
    occ: Any
    mesher: Any


def import_ngsolve() -> NgSolveModules:
    """Return the engine.

    Raises
    ------
    MissingDependencyError
        With what to install. On a bare Linux NGSolve names a missing libopenblas, but that
        one came with it: it does not load for want of the system's libquadmath.
    """
    try:
        found = NgSolveModules(*map(import_module, ("ngsolve", "netgen.occ", "netgen.meshing")))
    except ModuleNotFoundError as error:
        if (error.name or "").split(".")[0] not in {"ngsolve", "netgen"}:
            raise
        msg = 'the bracket needs NGSolve: pip install "cardan[bracket]"'
        raise MissingDependencyError(msg) from error
    except ImportError as error:
        msg = (
            f"NGSolve is installed but does not load ({error}). On Linux this is nearly always "
            "the small system library libquadmath, whatever the message names: "
            "apt-get install libquadmath0 (Debian, Ubuntu) or dnf install libquadmath (Fedora)"
        )
        raise MissingDependencyError(msg) from error
    found.ngs.ngsglobals.msg_level = 0
    return found
