"""The list of mutants fits the program as it is; `make mutants` runs them."""

from functools import cache

import pytest
from mutants import MUTANTS, PACKAGE, ROOT


@cache
def read(file):
    """Text of a file as it is, and what Python makes of it."""
    text = (PACKAGE / file).read_text(encoding="utf-8")
    return text, compile(text, file, "exec") if file.endswith(".py") else None


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda m: f"{m.file}: {m.says}")
def test_a_mutant_is_still_one_change_of_its_file(mutant):
    sound, code = read(mutant.file)
    assert sound.count(mutant.text) == 1
    changed = sound.replace(mutant.text, mutant.becomes)
    assert changed != sound
    if mutant.file.endswith(".py"):
        assert compile(changed, mutant.file, "exec") != code


def test_tests_that_ought_to_notice_are_there():
    for test in {t for m in MUTANTS for t in m.noticed_by}:
        file, _, name = test.partition("::")
        function = name.partition("[")[0]
        named = f"def {function}(" if name else ""
        assert named in (ROOT / file).read_text(encoding="utf-8"), test


def test_no_two_mutants_are_one():
    assert len({(m.file, m.says) for m in MUTANTS}) == len(MUTANTS)
    assert len({(m.file, m.text, m.becomes) for m in MUTANTS}) == len(MUTANTS)


def test_every_room_has_some():
    rooms = {p.parent.name for p in PACKAGE.glob("*/__init__.py")}
    assert {m.room for m in MUTANTS} == rooms
