"""Dataclasses that make their methods late are the standard library's in all that shows."""

import copy
import dataclasses
import pickle
from dataclasses import field, replace
from functools import cached_property
from typing import Any

import pytest

from cardan.core.lazy_dataclass import dataclass


def family(make: Any, **how: Any) -> type:
    @make(frozen=True, **how)
    class Part:
        length: float
        name: str = "tube"
        holes: list[int] = field(default_factory=list)
        unseen: int = field(default=0, compare=False, repr=False)
        kind: str = field(init=False, default="part")

        def __post_init__(self) -> None:
            if self.length < 0:
                msg = "below 0"
                raise ValueError(msg)

    return Part


@pytest.mark.parametrize("how", [{}, {"kw_only": True}, {"slots": True}, {"eq": False}])
def test_it_says_and_refuses_what_the_library_does(how):
    ours, theirs = family(dataclass, **how), family(dataclasses.dataclass, **how)
    one, other = ours(length=2.0), theirs(length=2.0)
    assert repr(one) == repr(other)
    assert [f.name for f in dataclasses.fields(one)] == [f.name for f in dataclasses.fields(other)]
    for of, it in ((ours, one), (theirs, other)):
        assert (it == of(length=2.0, unseen=3)) is how.get("eq", True)
        assert it != of(length=3.0)
        assert it.holes is not of(length=2.0).holes
        assert replace(it, name="axle").name == "axle"
        assert copy.deepcopy(it).length == 2.0
        with pytest.raises(ValueError, match="below 0"):
            of(length=-1.0)
        with pytest.raises(TypeError):
            of()
        with pytest.raises(TypeError):
            of(length=1.0, width=2.0)
        for change in (lambda it=it: setattr(it, "length", 1.0), lambda it=it: delattr(it, "name")):
            with pytest.raises(dataclasses.FrozenInstanceError, match=r"(assign|delete)"):
                change()
        if how.get("kw_only"):
            with pytest.raises(TypeError):
                of(2.0)
        else:
            assert of(2.0, "axle").name == "axle"


@dataclass(frozen=True, slots=True)
class Narrow:
    """Of slots, and hashed."""

    length: float
    name: str


@dataclass(frozen=True)
class Wide(Narrow):
    """Inherits, and holds what is computed once."""

    depth: float = 1.0

    @cached_property
    def twice(self) -> float:
        """Return the depth twice."""
        return 2 * self.depth


def test_it_travels_hashes_and_inherits():
    one = Narrow(1.0, "tube")
    assert pickle.loads(pickle.dumps(one)) == one
    assert not hasattr(one, "__dict__")
    assert {one: 1}[Narrow(1.0, "tube")] == 1
    assert hash(one) == hash((1.0, "tube"))
    wide = Wide(1.0, "tube", depth=3.0)
    assert (wide.twice, wide.length) == (6.0, 1.0)
    assert wide != one
    assert pickle.loads(pickle.dumps(wide)) == wide


def test_either_kind_inherits_from_the_other():
    @dataclasses.dataclass(frozen=True)
    class Theirs(Wide):
        colour: str = "red"

    @dataclass(frozen=True)
    class Ours(Theirs):
        weight: float = 2.0

    for one in (Theirs(1.0, "tube", 3.0, "blue"), Ours(1.0, "tube", 3.0, "blue")):
        assert (one.length, one.twice, one.colour) == (1.0, 6.0, "blue")
        with pytest.raises(dataclasses.FrozenInstanceError):
            one.length = 2.0
        assert replace(one, name="axle") != one


def test_what_a_class_writes_itself_stays():
    @dataclass(frozen=True)
    class Said:
        length: float

        def __repr__(self) -> str:
            return "a tube"

        def __eq__(self, other: object) -> bool:
            return True

        def __hash__(self) -> int:
            return 7

    assert (repr(Said(1.0)), Said(1.0) == 3, hash(Said(2.0))) == ("a tube", True, 7)


def test_what_is_not_frozen_is_the_library_s():
    @dataclass
    class Open:
        length: float

    one = Open(1.0)
    one.length = 2.0
    assert repr(one).endswith("Open(length=2.0)")
