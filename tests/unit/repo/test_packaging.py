"""What a package's users and their tools read of it."""

import re
import tomllib
from pathlib import Path

import yaml
from brackets import LINE
from click.testing import CliRunner

import cardan
from cardan.cli.main import cli

ROOT = Path(__file__).parents[3]
DEVELOPMENT = {"bench", "browser", "docs", "lint", "mutants", "oracles", "test"}


def test_citation_is_of_this_version():
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert yaml.safe_load(text)["version"] == cardan.__version__


def test_extra_all_has_every_extra_that_a_user_may_want():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    [every] = extras["all"]
    assert set(re.findall(r"\w+", every)) - {"cardan"} == {*extras} - {"all"} - DEVELOPMENT


def test_hook_before_a_commit_checks_application_files(tmp_path):
    """By a convention of their names; one of several that fails a limit stops the commit."""
    text = (ROOT / ".pre-commit-hooks.yaml").read_text(encoding="utf-8")
    [hook] = yaml.safe_load(text)
    program, *arguments = hook["entry"].split()
    assert program == "cardan"
    assert re.search(hook["files"], "trucks/line.cardan.yaml")
    assert not re.search(hook["files"], "campaign.yaml")
    right, wrong = tmp_path / "a.cardan.yaml", tmp_path / "b.cardan.yaml"
    right.write_text(LINE + "limits: protractor\n")
    wrong.write_text(LINE.replace("3.0, 1.0", "30.0, 1.0") + "limits: protractor\n")
    for files, code in (([right], 0), ([right, wrong], 1)):
        done = CliRunner().invoke(cli, [*arguments, *map(str, files)])
        assert done.exit_code == code, done.output


def test_conda_recipe_asks_for_what_the_package_does():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    recipe = yaml.safe_load((ROOT / "conda/recipe.yaml").read_text(encoding="utf-8"))
    asked = {text.replace(" ", "").lower() for text in recipe["requirements"]["run"]}
    package = project["project"]
    assert asked == {
        *(text.lower() for text in package["dependencies"]),
        f"python{package['requires-python']}",
    }
    assert {text.replace(" ", "") for text in recipe["requirements"]["host"]} >= {
        *project["build-system"]["requires"]
    }
    assert recipe["context"]["version"] == cardan.__version__
    assert recipe["build"]["python"]["entry_points"] == [
        f"{name} = {target}" for name, target in package["scripts"].items()
    ]
