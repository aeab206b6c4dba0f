"""Files to start from."""

import re

import pytest

from cardan.application.reader import loads
from cardan.application.templates import template_names, template_text


@pytest.mark.parametrize("kind", template_names())
def test_every_starter_is_read_without_a_doubt(kind):
    assert loads(template_text(kind)).warnings == ()


@pytest.mark.parametrize("kind", template_names())
def test_every_key_of_a_starter_is_explained(kind):
    """Each key stands on a line with a comment, or is explained where it stood first."""
    explained: set[str] = set()
    for line in template_text(kind).splitlines():
        text, _, comment = line.partition(" #")
        keys = set(re.findall(r"[\w]+(?=:)", text.split("#")[0]))
        if comment:
            explained |= keys
        assert not keys or keys & explained or text.strip().endswith(":"), line


def test_starters_are_named():
    assert template_names() == ("6x4", "bus", "industrial", "small", "truck")
    with pytest.raises(ValueError, match="there is no starter lorry; there are: 6x4, bus, "):
        template_text("lorry")
