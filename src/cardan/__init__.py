"""Cardan: universal-joint drivelines, from hardpoints to verdict.

    import cardan

    app = cardan.read("truck.yaml")
    cardan.check(app)

What `__all__` names stands in `cardan.face` and is imported where it is asked for, so that
this line costs nothing. Three of the names are rooms of the house too, with modules in them:
`cardan.study`, `cardan.bracket` and `cardan.loads` are packages that can be called.
"""

import sys
from types import ModuleType

__version__ = "0.1.0"

__all__ = [
    "Application", "Approval", "CompositeTube", "Driven", "Life", "LooseJoint", "Proposals",
    "Sizing", "Steering", "Sweep", "Values", "__version__", "addresses", "bracket",
    "buckling_torques", "change", "check", "fates", "fix", "hysteretic_threshold", "life",
    "lightest", "loads", "passage", "rattle", "read", "shimmy", "size", "stability", "study",
    "viscous_threshold",
]  # fmt: skip

TYPE_CHECKING = False  # as type checkers know it; `typing` itself takes longer than all the rest
if TYPE_CHECKING:
    from cardan.face import (
        Application,
        Approval,
        CompositeTube,
        Driven,
        Life,
        LooseJoint,
        Proposals,
        Sizing,
        Steering,
        Sweep,
        Values,
        addresses,
        bracket,
        buckling_torques,
        change,
        check,
        fates,
        fix,
        hysteretic_threshold,
        life,
        lightest,
        loads,
        passage,
        rattle,
        read,
        shimmy,
        size,
        stability,
        study,
        viscous_threshold,
    )

_ROOMS = ("bracket", "loads", "study")
"""Packages that are asked by their names too."""


def __getattr__(name: str) -> object:
    """Return what the public face calls so."""
    if name not in __all__:
        msg = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(msg)
    from importlib import import_module

    if name in _ROOMS:
        return import_module(f"{__name__}.{name}")
    return getattr(import_module(f"{__name__}.face"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


class _Room(ModuleType):
    """A package that is asked by its name: `cardan.study(app, ...)`."""

    def __call__(self, *args: object, **how: object) -> object:
        """Ask the public face."""
        from importlib import import_module

        return getattr(import_module("cardan.face"), self.__name__.rpartition(".")[2])(*args, **how)


class _House(ModuleType):
    """The package: whoever imports one of its rooms first, the room can be asked."""

    def __setattr__(self, name: str, value: object) -> None:
        if name in _ROOMS and isinstance(value, ModuleType):
            value.__class__ = _Room
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _House
