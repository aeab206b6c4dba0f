"""Pages in a real browser: axe-core finds nothing serious, and nothing is fetched.

`AXE` names axe-core's axe.min.js; by default it is looked for under node_modules.
"""

import os
import shutil
from pathlib import Path

import pytest

from cardan import files
from cardan.report import story
from cardan.report.compare import Variant
from cardan.report.html import page
from cardan.report.language import Language
from cardan.study.approval import approve, assess
from cardan.study.driveline import DrivelineStudy
from cardan.study.sensitivity import sensitivities
from cardan.study.studies import VibrationStudy

pytestmark = [pytest.mark.browser, pytest.mark.filterwarnings("ignore::ResourceWarning")]

ROOT = Path(__file__).parents[2]
AXE = Path(os.environ.get("AXE", ROOT / "node_modules/axe-core/axe.min.js"))
EXAMPLES = sorted((ROOT / "examples").glob("*.yaml"))


@pytest.fixture(scope="module")
def browser():
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    for flag in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1200,900",
                 "--host-resolver-rules=MAP * ~NOTFOUND"):  # fmt: skip
        options.add_argument(flag)
    options.binary_location = shutil.which("chromium") or shutil.which("google-chrome") or ""
    driver = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
    yield driver
    driver.quit()


def pages():
    for path in EXAMPLES:
        for code in ("en", "pt", "it"):
            yield pytest.param(path, code, id=f"{path.stem}-{code}")


@pytest.mark.parametrize(("path", "code"), list(pages()))
def test_nothing_serious_and_nothing_fetched(browser, tmp_path, path, code):
    found = approve(files.read(path), (DrivelineStudy(), VibrationStudy()))
    issue = story.Issue(files=(path.name,), prints=("0",), texts=(path.read_text("utf-8"),))
    told = story.approval(
        found, helps=sensitivities(found), fixes=(), say=Language(code), issue=issue
    )  # fmt: skip
    out = tmp_path / "report.html"
    out.write_text(page(told), encoding="utf-8")
    held(browser, out)


def test_a_comparison_is_as_good(browser, tmp_path):
    variants = [Variant(name=p.stem, approval=assess(files.read(p))) for p in EXAMPLES[:2]]
    told = story.comparison(variants, say=Language("en"), issue=story.Issue())
    out = tmp_path / "comparison.html"
    out.write_text(page(told), encoding="utf-8")
    held(browser, out)


def held(browser, out):
    """Hold a page against axe-core's rules, and against the network being off."""
    browser.get(out.as_uri())
    browser.execute_script(AXE.read_text(encoding="utf-8"))
    report = browser.execute_async_script(
        "const done = arguments[arguments.length - 1]; axe.run().then(done, e => done(String(e)));"
    )
    wrong = [(v["id"], v["impact"], v["nodes"][0]["html"][:200]) for v in report["violations"]
             if v["impact"] in ("serious", "critical")]  # fmt: skip
    assert wrong == []
    assert report["passes"]
    fetched = browser.execute_script("return performance.getEntriesByType('resource').length")
    assert fetched == 0
    assert [e for e in browser.get_log("browser") if e["level"] == "SEVERE"] == []
