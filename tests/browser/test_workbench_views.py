"""The workbench's other views in a real browser: over speed, what to change, variants, limits.

Needs the built page: `make browser` builds it.
"""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from browsing import TRUCK, browsing, clean, opened, serious, wait, workbench

from cardan import files
from cardan.study.approval import approve

pytestmark = [pytest.mark.browser, pytest.mark.filterwarnings("ignore::ResourceWarning")]


@pytest.fixture(scope="module")
def browser():
    with browsing() as driver:
        yield driver


def show(driver, view):
    driver.find_element("css selector", f"[data-view={view}]").click()


def said(driver, selector):
    return driver.execute_script(
        "return document.querySelector(arguments[0])?.innerText ?? ''", selector
    )


def press(driver, selector):
    wait(driver, "return document.querySelector(arguments[0])", selector)
    button = driver.find_element("css selector", selector)
    driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", button)
    button.click()


def test_forces_over_speed_campbell_and_launch(browser, tmp_path):
    """The worst of the waterfall is what the check found by a search of its own."""
    from selenium.webdriver.common.keys import Keys

    with workbench(tmp_path) as (house, _):
        opened(browser, house)
        show(browser, "speed")
        wait(browser, "return document.querySelector('.waterfall canvas')")
        found = approve(files.loads(TRUCK))
        worst = max(
            (c for c in found.checks if c.quantity == "centre_bearing_dynamic"),
            key=lambda c: c.value,
        )
        states = [s.name for s in found.application.states]
        chips = browser.find_elements("css selector", ".chips[aria-label='State'] button")
        chips[states.index(worst.when.name)].click()
        at = f"centre bearing {worst.part.number}"
        wait(browser, "return document.querySelector('.note').innerText")
        named = "//div[@aria-label='Force']/button[.=$]".replace("$", f"'{at}'")
        browser.find_element("xpath", named).click()
        value = "return document.querySelector('.field p').innerText"
        wait(browser, f"{value.replace('return', 'return /N, fail$/.test(')})")
        told = browser.execute_script(value)
        newtons = float(told.rpartition(": ")[2].split(" N")[0])
        assert newtons == pytest.approx(worst.value, rel=0.01)  # speeds that are drawn, not sought
        browser.find_element("css selector", ".field canvas").send_keys(Keys.ARROW_RIGHT)
        wait(browser, f"{value} !== arguments[0]", told)
        press(browser, ".vehicle .asking button")
        wait(browser, "return document.querySelectorAll('.launch canvas').length >= 2")
        assert len(browser.find_elements("css selector", ".campbell canvas")) == 3
        assert serious(browser) == []
        clean(browser)


def test_a_job_can_be_stopped_and_asked_again(browser, tmp_path):
    with workbench(tmp_path) as (house, _):
        opened(browser, house)
        show(browser, "speed")
        wait(browser, "return document.querySelector('.waterfall canvas')")
        press(browser, ".vehicle .asking button")
        wait(browser, "return document.querySelector('.vehicle [role=status]')")
        press(browser, ".vehicle .asking button")
        wait(browser, "return document.querySelector('.vehicle .fail')")
        assert said(browser, ".vehicle .fail") == "stopped"
        press(browser, ".vehicle .asking button")
        wait(browser, "return document.querySelector('.launch')")
