"""Pages in a real browser: axe-core finds nothing serious, and nothing is fetched.

`AXE` names axe-core's axe.min.js; by default it is looked for under node_modules.
"""

import os
import shutil
from pathlib import Path

import pytest

from cardan.application import reader
from cardan.approval.approval import approve_application, approve_driveline
from cardan.approval.driveline_study import DrivelineStudy
from cardan.documents import approval_report as story
from cardan.documents.comparison import Variant
from cardan.render.html import html_page
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.topics.design.sensitivity import check_sensitivities
from cardan.topics.torsion.registration import VibrationStudy

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
    """Every example in English; the ones with most chapters in the other languages too."""
    for path in EXAMPLES:
        several = path.stem in ("refuse-collector-6x2", "tandem-6x4")
        for code in LANGUAGE_CODES if several else ("en",):
            yield pytest.param(path, code, id=f"{path.stem}-{code}")


@pytest.mark.parametrize(("path", "code"), list(pages()))
def test_report_page_has_no_accessibility_faults_or_network_requests(browser, tmp_path, path, code):
    found = approve_application(reader.read(path), (DrivelineStudy(), VibrationStudy()))
    issue = story.ReportDateAndSourceStamp(
        file_names=(path.name,), fingerprints=("0",), file_texts=(path.read_text("utf-8"),)
    )
    told = story.approval_report_from_results(
        found, helps=check_sensitivities(found), fixes=(), say=Translator(code), issue=issue
    )  # fmt: skip
    out = tmp_path / "report.html"
    out.write_text(html_page(told), encoding="utf-8")
    held(browser, out)


def test_comparison_page_has_no_accessibility_faults_or_requests(browser, tmp_path):
    variants = [
        Variant(name=p.stem, approval=approve_driveline(reader.read(p))) for p in EXAMPLES[:2]
    ]
    told = story.comparison_report(
        variants, say=Translator("en"), issue=story.ReportDateAndSourceStamp()
    )
    out = tmp_path / "comparison.html"
    out.write_text(html_page(told), encoding="utf-8")
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
