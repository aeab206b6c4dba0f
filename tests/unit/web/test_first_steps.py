"""Examples of empty views can be used, and what is not installed is known before a file comes."""

import pytest
from repository import ROOT

from cardan.application import reader
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.web import first_steps

EXAMPLE_FILES = ("refuse-collector-6x2", "three-joint-chain")


@pytest.mark.parametrize("code", LANGUAGE_CODES)
@pytest.mark.parametrize("name", EXAMPLE_FILES)
def test_bracket_example_is_valid_in_application_with_centre_bearing(name, code):
    text = (ROOT / f"examples/{name}.yaml").read_text("utf-8")
    assert reader.loads(text).bracket is None
    example = first_steps.bracket_example(Translator(code))
    assert ("drawing" in example) == (code == "en")
    assert reader.loads(text + example).bracket is not None


def test_missing_library_is_named_with_its_extra(monkeypatch):
    monkeypatch.setattr(first_steps, "find_spec", lambda name: None if name == "asammdf" else name)
    assert first_steps.missing_libraries() == [{"use": "MDF4", "extra": "mdf"}]


def test_optional_libraries_belong_to_extras_of_the_package():
    """An extra that was renamed would be named wrongly on the page."""
    import tomllib

    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    names = {"nptdms": "npTDMS", "imctermite": "imctermite3"}
    for library in first_steps.OPTIONAL_LIBRARIES:
        required = extras["optional-dependencies"][library.extra]
        name = names.get(library.module, library.module)
        assert any(r.startswith(f"{name}>") for r in required)
    assert any(r.startswith("pyarrow") for r in extras["optional-dependencies"]["web"])
