"""Files to start from, and writing whole or not at all."""

import re

import pytest

from cardan.base.errors import BadFile
from cardan.files import loads, starter, write
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
    assert kinds() == ("small", "truck")
    with pytest.raises(ValueError, match="there is no starter lorry; there are: small, truck"):
        starter("lorry")


def test_a_file_is_written_and_not_overwritten(tmp_path):
    file = tmp_path / "a.yaml"
    assert write(file, "a: 1\n") == file
    with pytest.raises(BadFile) as error:
        write(file, "a: 2\n")
    assert str(error.value) == f"{file}: is there already; choose another name, or say --force"
    assert file.read_text(encoding="utf-8") == "a: 1\n"
    write(file, "é: 2\n", replace=True)
    assert file.read_bytes() == "é: 2\n".encode()
    assert list(tmp_path.iterdir()) == [file]


def test_a_file_that_cannot_be_written_leaves_nothing_behind(tmp_path):
    with pytest.raises(BadFile, match="cannot be written: No such file or directory"):
        write(tmp_path / "nowhere" / "a.yaml", "a: 1\n")
    (tmp_path / "folder").mkdir()
    with pytest.raises(BadFile, match="cannot be written"):
        write(tmp_path / "folder", "a: 1\n", replace=True)
    with pytest.raises(UnicodeEncodeError):
        write(tmp_path / "b.yaml", "\ud800")
    assert [p.name for p in tmp_path.iterdir()] == ["folder"]
