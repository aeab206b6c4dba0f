"""Dataclasses, frozen or not, whose methods are made when they are first used.

The standard library compiles six methods for each class while a program starts, most of which
no run ever calls: a quarter of the time of a whole check. Here a class costs the list of its
fields; its `__init__` is compiled when its first object is made, and what compares, hashes and
prints is written once for all. In everything else such a class is one of the standard library's:
`fields`, `replace` and type checkers see no difference.
"""

import dataclasses
from collections.abc import Callable
from dataclasses import FrozenInstanceError
from functools import cache
from operator import attrgetter
from reprlib import recursive_repr
from typing import Any, TypeVar, dataclass_transform, overload

T = TypeVar("T")


@overload
def dataclass(cls: type[T], /) -> type[T]: ...
@overload
def dataclass(
    *, frozen: bool = ..., slots: bool = ..., kw_only: bool = ..., eq: bool = ..., repr: bool = ...
) -> Callable[[type[T]], type[T]]: ...
@dataclass_transform(field_specifiers=(dataclasses.field,))
def dataclass(
    cls: Any = None,
    /,
    *,
    frozen: bool = False,
    slots: bool = False,
    kw_only: bool = False,
    eq: bool = True,
    repr: bool = True,  # noqa: A002  the library's own word
) -> Any:
    """Make a class a dataclass as `dataclasses.dataclass` does, with the same arguments.

    Either kind inherits from the other.
    """

    def made(cls: Any) -> Any:
        own = vars(cls).copy()
        of = [getattr(base, "__dataclass_params__", None) for base in cls.__mro__[1:]]
        # The library lets frozen classes inherit only from frozen ones.
        bare: Any = dataclasses.dataclass(
            init=False,
            repr=False,
            eq=False,
            slots=slots,
            kw_only=kw_only,
            frozen=any(p.frozen for p in of if p),
        )(cls)
        bare.__dataclass_params__.frozen = frozen
        methods: dict[str, Any] = {"__init__": _first(bare)}
        if frozen:
            methods |= {"__setattr__": _unset, "__delattr__": _kept}
        if repr:
            methods["__repr__"] = _repr
        if eq:
            methods |= {"__eq__": _equal, "__hash__": _hash if frozen else None}
        if slots and frozen:
            methods |= {"__getstate__": _state, "__setstate__": _restored}
        for name, method in methods.items():
            if own.get(name) is None:
                setattr(bare, name, method)
        return bare

    return made if cls is None else made(cls)


def _first(cls: Any) -> Callable[..., None]:
    """Return what makes the first object of a class, and the `__init__` that makes the others."""

    def __init__(self: Any, *args: Any, **given: Any) -> None:  # noqa: N807  it is one
        cls.__init__ = _init(cls)
        cls.__init__(self, *args, **given)

    return __init__


def _init(cls: Any) -> Callable[..., None]:
    """Compile the `__init__` of a class from its fields."""
    known: dict[str, Any] = {"_set": object.__setattr__, "_none": object()}
    kept = "_set(self, {!r}, {})" if cls.__dataclass_params__.frozen else "self.{} = {}"
    plain, named, body = [], [], []
    for f in dataclasses.fields(cls):
        value = f.name
        entry = f.name
        if f.default is not dataclasses.MISSING:
            known[f"_of_{f.name}"] = f.default
            entry = f"{f.name}=_of_{f.name}"
        elif f.default_factory is not dataclasses.MISSING:
            known[f"_of_{f.name}"] = f.default_factory
            entry = f"{f.name}=_none"
            value = f"_of_{f.name}() if {f.name} is _none else {f.name}"
        if f.init:
            (named if f.kw_only else plain).append(entry)
        elif f.default_factory is not dataclasses.MISSING:
            value = f"_of_{f.name}()"
        elif f.default is not dataclasses.MISSING:
            value = f"_of_{f.name}"
        else:
            continue
        body.append(kept.format(f.name, value))
    if hasattr(cls, "__post_init__"):
        body.append("self.__post_init__()")
    arguments = ", ".join(["self", *plain, *(["*", *named] if named else [])])
    text = f"def __init__({arguments}):\n " + "\n ".join(body or ["pass"])
    exec(text, known)  # of names of fields alone
    return known["__init__"]


@cache
def _compared(cls: Any) -> Callable[[Any], Any]:
    """Return what gives the fields of an object by which it is compared."""
    names = [f.name for f in dataclasses.fields(cls) if f.compare]
    return attrgetter(*names) if names else lambda _: ()


def _equal(self: Any, other: Any) -> Any:
    if other.__class__ is not self.__class__:
        return NotImplemented
    values = _compared(self.__class__)
    return values(self) == values(other)


def _hash(self: Any) -> int:
    return hash(_compared(self.__class__)(self))


@recursive_repr()
def _repr(self: Any) -> str:
    shown = (f"{f.name}={getattr(self, f.name)!r}" for f in dataclasses.fields(self) if f.repr)
    return f"{self.__class__.__qualname__}({', '.join(shown)})"


def _unset(self: Any, name: str, value: Any) -> None:
    del self, value
    msg = f"cannot assign to field {name!r}"
    raise FrozenInstanceError(msg)


def _kept(self: Any, name: str) -> None:
    del self
    msg = f"cannot delete field {name!r}"
    raise FrozenInstanceError(msg)


def _state(self: Any) -> list[Any]:
    return [getattr(self, f.name) for f in dataclasses.fields(self)]


def _restored(self: Any, state: list[Any]) -> None:
    for f, value in zip(dataclasses.fields(self), state, strict=True):
        object.__setattr__(self, f.name, value)
