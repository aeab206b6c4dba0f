"""Files to start from."""

import re

import pytest

from cardan.files import loads, starter
from cardan.files.starter import kinds


@pytest.mark.parametrize("kind", kinds())
def test_every_starter_is_read_without_a_doubt(kind):
    assert loads(starter(kind)).warnings == ()


@pytest.mark.parametrize("kind", kinds())
def test_every_key_of_a_starter_is_explained(kind):
    """Each key stands on a line with a comment, or is explained where it stood first."""
    explained: set[str] = set()
    for line in starter(kind).splitlines():
        text, _, comment = line.partition(" #")
        keys = set(re.findall(r"[\w]+(?=:)", text.split("#")[0]))
        if comment:
            explained |= keys
        assert not keys or keys & explained or text.strip().endswith(":"), line


def test_starters_are_named():
    assert kinds() == ("6x4", "bus", "industrial", "small", "truck")
    with pytest.raises(ValueError, match="there is no starter lorry; there are: 6x4, bus, "):
        starter("lorry")
