"""Print constraints that hold each library to the lowest version `pyproject.toml` allows."""

import re
import sys
import tomllib
from pathlib import Path

PROJECT = Path(__file__).parents[1] / "pyproject.toml"


def lowest_versions(project: dict) -> list[str]:
    """Return `name==version; marker` of each requirement with a lower bound, extras included."""
    extras = project.get("optional-dependencies", {})
    tools = ("lint", "docs", "bench", "mutants", "oracles", "browser", "bracket")
    wanted = [*project["dependencies"], *(r for e in extras if e not in tools for r in extras[e])]
    found = {}
    for requirement in wanted:
        match = re.match(r"([A-Za-z0-9_.-]+)(?:\[[^]]*\])?>=([^;,\s]+)\s*(;.*)?$", requirement)
        if match:
            name, version, marker = match.groups()
            found[name.lower()] = f"{name}=={version}{marker or ''}"
    return sorted(found.values())


if __name__ == "__main__":
    lines = lowest_versions(tomllib.loads(PROJECT.read_text())["project"])
    sys.stdout.write("\n".join(lines) + "\n")
