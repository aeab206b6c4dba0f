"""The wheel, not the checkout: built, installed where nothing else is, serving its page.

Installs the package's needs from the registry that pip knows, so it takes minutes.
"""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from browsing import SETTLED, TRUCK, browsing, clean, wait
from workbench import command

ROOT = Path(__file__).parents[2]
pytestmark = [pytest.mark.browser, pytest.mark.filterwarnings("ignore::ResourceWarning")]


def run(*arguments, cwd):
    alone = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
    done = subprocess.run(
        [str(a) for a in arguments], cwd=cwd, env=alone, capture_output=True, text=True,
        timeout=900, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_installed_wheel_serves_workbench_page(tmp_path):
    run(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", tmp_path, ROOT,
        cwd=tmp_path)  # fmt: skip
    (wheel,) = tmp_path.glob("cardan-*.whl")
    held = zipfile.ZipFile(wheel).namelist()
    assert "cardan/web/static/index.html" in held
    assert not [name for name in held if "node_modules" in name or name.startswith("web/")]
    run(sys.executable, "-m", "venv", tmp_path / "venv", cwd=tmp_path)
    python = tmp_path / "venv" / ("Scripts" if os.name == "nt" else "bin") / "python"
    run(python, "-m", "pip", "install", "--quiet", "--constraint", ROOT / "constraints.txt",
        f"cardan[web] @ {wheel.as_uri()}", cwd=tmp_path)  # fmt: skip
    where = run(python, "-P", "-c", "import cardan; print(cardan.__file__)", cwd=tmp_path).strip()
    assert Path(where).is_relative_to(tmp_path)
    run(python, "-P", "-m", "cardan", "new", "case", "--example", "refuse-collector", cwd=tmp_path)
    assert (tmp_path / "case/joints.parquet").stat().st_size > 500_000
    desk = tmp_path / "desk"
    desk.mkdir()
    (desk / "truck.yaml").write_text(TRUCK, "utf-8")
    serving = command(desk / "truck.yaml", state=tmp_path / "state", cwd=tmp_path, python=python)
    with serving as (_, address), browsing() as driver:
        driver.get(address)
        wait(driver, SETTLED)
        assert driver.find_elements("css selector", ".strip.fail")
        driver.execute_script("document.querySelector('[data-view=change]').click()")
        wait(driver, "return document.querySelector('.map canvas')")
        clean(driver)
