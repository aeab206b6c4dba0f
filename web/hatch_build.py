"""Puts the built page of the workbench into what is distributed."""

import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

WITHOUT_PAGE = "CARDAN_WITHOUT_PAGE"
"""Variable of the environment that, set to 1, asks for a package without the workbench."""


class PageHook(BuildHookInterface[Any]):
    """Builds the page where its sources are newer; without it there is no package to hand on."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the page, unless the package is installed in place."""
        del build_data
        root = Path(self.root)
        page, sources = root / "src/cardan/web/static/index.html", root / "web"
        read = (*(sources / "src").glob("*"), root / "src/cardan/web/messages.schema.json")
        newest = max((p.stat().st_mtime for p in read if p.exists()), default=0.0)
        unwanted = version == "editable" or os.environ.get(WITHOUT_PAGE) == "1"
        if unwanted or (page.exists() and page.stat().st_mtime >= newest):
            return
        npm = shutil.which("npm")
        why = "Node with npm is not installed" if npm is None else self._built(npm, sources)
        if why:
            msg = (
                f"the workbench's page cannot be built: {why}; set {WITHOUT_PAGE}=1 for a package "
                "in which `cardan serve` says that it has none"
            )
            raise RuntimeError(msg)

    @staticmethod
    def _built(npm: str, sources: Path) -> str:
        """Return why the page could not be built; nothing where it was."""
        for command in (["ci", "--silent"], ["run", "--silent", "build"]):
            done = subprocess.run(
                [npm, *command], cwd=sources, capture_output=True, text=True, check=False
            )
            if done.returncode:
                said = (done.stderr or done.stdout).strip().splitlines()
                return f"npm {command[-1]}: {said[-1] if said else done.returncode}"
        return ""
