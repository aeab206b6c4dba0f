"""What the workbench must not lose or say wrongly, in a real browser: edits, fingers, old answers.

Needs the built page: `make browser` builds it.
"""

import shutil
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from browsing import (
    CHAIN,
    ROOT,
    SETTLED,
    arrived,
    browsing,
    clean,
    edited,
    opened,
    serious,
    text_of,
    wait,
    workbench,
)

from cardan.application import reader
from cardan.approval.approval import approve_application

pytestmark = [pytest.mark.browser, pytest.mark.filterwarnings("ignore::ResourceWarning")]

SIDES = "section[aria-label='Variants side by side'] td b"
SHOWN = "return document.querySelector(arguments[0])?.innerText ?? ''"


@pytest.fixture(scope="module")
def browser():
    with browsing() as driver:
        yield driver


def click(driver, selector):
    """Click at once: a test of what is in a hurry waits for nothing."""
    driver.execute_script("document.querySelector(arguments[0]).click()", selector)


def typed(driver, text):
    """Type at the end of the file, as a hand does."""
    from selenium.webdriver.common.keys import Keys

    area = driver.find_element("css selector", ".editor textarea")
    area.send_keys(Keys.CONTROL, Keys.END)
    area.send_keys(text)


def test_text_typed_just_before_view_change_is_kept(browser, tmp_path):
    """Less than a quarter of a second before it was gone: no undo, no draft."""
    with workbench(tmp_path, CHAIN, "chain.yaml") as (house, path):
        opened(browser, house)
        was = text_of(browser)
        typed(browser, "# real")
        click(browser, "[data-view=limits]")
        wait(browser, "return document.querySelector('.limits tbody tr')")
        click(browser, "[data-view=line]")
        wait(browser, "return document.querySelector('.editor textarea')")
        assert text_of(browser) == f"{was}# real"
        click(browser, ".save")
        wait(browser, "return document.querySelector('.save').disabled")
        assert path.read_text("utf-8") == f"{was}# real"
        clean(browser)


def test_file_conflict_question_reappears_after_page_reload(browser, tmp_path):
    """A reload made the question go away, and Save wrote over what another program had written."""
    with workbench(tmp_path, CHAIN, "chain.yaml") as (house, path):
        opened(browser, house)
        typed(browser, "# mine")
        wait(browser, "return !document.querySelector('.save').disabled")
        browser.execute_async_script("setTimeout(arguments[0], 700)")  # the draft is kept
    theirs = f"{CHAIN}# theirs\n"
    path.write_text(theirs, "utf-8")
    question = "return document.querySelector('.notice.warn')"
    with workbench(tmp_path, CHAIN, "chain.yaml") as (house, path):
        arrived(browser, house)
        wait(browser, question)
        for _ in range(2):
            browser.refresh()
            wait(browser, question)
            assert text_of(browser).endswith("# mine")
            click(browser, ".save")
            browser.execute_async_script("setTimeout(arguments[0], 500)")
            assert browser.execute_script(question)
            assert path.read_text("utf-8") == theirs


def test_drafts_of_two_crashed_tabs_are_both_restored(browser, tmp_path):
    """One draft a file: the text of the tab that was typed in first was gone."""
    with workbench(tmp_path, CHAIN, "chain.yaml") as (house, path):
        opened(browser, house)
        first = browser.current_window_handle
        browser.switch_to.new_window("tab")
        opened(browser, house)
        for tab, text in ((browser.current_window_handle, "# two"), (first, "# one")):
            browser.switch_to.window(tab)
            typed(browser, text)
            wait(browser, "return !document.querySelector('.save').disabled")
            browser.execute_async_script("setTimeout(arguments[0], 700)")
        browser.switch_to.window(next(w for w in browser.window_handles if w != first))
        browser.close()
        browser.switch_to.window(first)
    with workbench(tmp_path, CHAIN, "chain.yaml") as (house, path):
        opened(browser, house)
        shown, other = ("# one", "# two")
        if text_of(browser).endswith(other):  # it was kept once more as it was closed
            shown, other = other, shown
        assert text_of(browser).endswith(shown)
        assert "kept as variants" in browser.execute_script(SHOWN, ".notice")
        click(browser, "[data-view=variants]")
        wait(browser, "return document.querySelector('.variants [data-do=take]')")
        name = browser.find_element("css selector", ".variants th input").get_property("value")
        assert name.startswith("not saved 20")
        click(browser, "[data-do=take]")
        click(browser, "[data-view=line]")
        wait(browser, "return document.querySelector('.editor textarea')")
        assert text_of(browser).endswith(other)
        assert path.read_text("utf-8") == CHAIN


@pytest.mark.parametrize("width", [390, 1440])
def test_touch_drag_moves_bearing_without_scrolling_page(tmp_path, width):
    """The page scrolled 163 px and took the hand away: only a mouse had been asked."""
    text = (ROOT / "examples/refuse-collector-6x2.yaml").read_text("utf-8")
    with browsing() as driver, workbench(tmp_path, text) as (house, _):
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": width, "height": 844, "deviceScaleFactor": 1, "mobile": True,
        })  # fmt: skip
        driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True})
        opened(driver, house)
        was = text_of(driver)
        x, y, top = driver.execute_script(
            "const e = document.querySelector(\"[data-handle='side/main/bearing/1'] .dot\");"
            "e.scrollIntoView({block: 'center'}); const r = e.getBoundingClientRect();"
            "return [r.x + r.width / 2, r.y + r.height / 2, views.getBoundingClientRect().y]"
        )

        def touch(kind, *points):
            at = [{"x": x, "y": y - dy} for dy in points]
            driver.execute_cdp_cmd(
                "Input.dispatchTouchEvent", {"type": kind, "touchPoints": at}
            )  # fmt: skip

        touch("touchStart", 0)
        for step in range(1, 13):
            touch("touchMove", 3 * step)
        wait(driver, "return document.querySelector('.grip.held')")
        touch("touchEnd")
        now = edited(driver, was)
        # The verdict above may take two rows more or fewer; its rows change places all the same.
        assert abs(driver.execute_script("return views.getBoundingClientRect().y") - top) < 100
        old, new = (reader.loads(t).lines[0].layout.points[1, 2] for t in (was, now))
        assert new - old > 0.005


def test_compared_files_keep_their_names_when_selection_changes(browser, tmp_path):
    """What was ticked next took the names of what had been compared: a FAIL stood over a WARN."""
    desk = tmp_path / "desk"
    desk.mkdir()
    for name in ("tandem-6x4", "three-joint-chain", "van"):
        shutil.copy(ROOT / f"examples/{name}.yaml", desk)
    with workbench(tmp_path, folder=True) as (house, _):
        arrived(browser, house)
        ready = "return document.querySelectorAll('.library li input:not([disabled])').length === 3"
        wait(browser, ready)
        boxes = browser.find_elements("css selector", ".library li input")
        for box in boxes[:2]:
            box.click()
        click(browser, "[data-do=compare]")
        heads = (
            "[...document.querySelectorAll('section[aria-label^=Variants] thead th')]"
            ".map(e => e.innerText).filter(Boolean).join()"
        )
        names = ["tandem-6x4.yaml", "three-joint-chain.yaml"]
        wait(browser, f"return {heads} === arguments[0]", ",".join(names))
        verdicts = [e.get_attribute("class") for e in browser.find_elements("css selector", SIDES)]
        assert verdicts == [approve_application(reader.read(desk / name)).verdict for name in names]
        boxes[0].click()
        boxes[2].click()
        assert browser.find_elements("css selector", SIDES) == []
        click(browser, "[data-do=compare]")
        names = ["three-joint-chain.yaml", "van.yaml"]
        wait(browser, f"return {heads} === arguments[0]", ",".join(names))
        clean(browser)


def test_outdated_correction_is_not_applied_to_changed_file(browser, tmp_path):
    """A second click added to the first: what stood there belonged to neither."""
    with workbench(tmp_path, CHAIN, "chain.yaml") as (house, _):
        opened(browser, house)
        was = text_of(browser)
        click(browser, "[data-view=change]")
        wait(browser, "return document.querySelector('.fix .asking button')")
        click(browser, ".fix .asking button")
        wait(browser, "return document.querySelectorAll('.proposals li').length > 1"
             " && !document.querySelector('.fix progress')")  # fmt: skip
        click(browser, ".proposals li:nth-of-type(2) button")
        wait(browser, "return document.querySelector('.proposals li button').disabled")
        wait(browser, SETTLED)
        browser.execute_script(
            "document.querySelector('.front g')"
            ".dispatchEvent(new MouseEvent('click', {bubbles: true}))"
        )
        assert (
            browser.execute_script(
                "return document.querySelector('.front g').getAttribute('aria-disabled')"
            )
            == "true"
        )
        assert serious(browser) == []
        click(browser, "[data-view=line]")
        wait(browser, SETTLED)
        now = text_of(browser)
        assert now != was
        # Undone, it is of the file as it is, and can be made.
        click(browser, "[aria-label=undo]")
        assert edited(browser, now) == was
        click(browser, "[data-view=change]")
        wait(browser, "return !document.querySelector('.proposals li button').disabled")
        clean(browser)


def test_slider_at_braking_torque_is_labelled_braking(browser, tmp_path):
    """The low end of the slider was coasting, whatever brakes make of the axle."""
    text = (ROOT / "examples/refuse-collector-6x2.yaml").read_text("utf-8")
    with workbench(tmp_path, text) as (house, _):
        opened(browser, house)
        slide = (
            "const e = document.querySelectorAll('.poser input[type=range]')[1];"
            "e.value = -1000; e.dispatchEvent(new Event('input', {bubbles: true}))"
        )
        told = "return document.querySelectorAll('.poser output')[1].innerText"
        browser.execute_script(slide)
        wait(browser, f"return ({told[7:]}).includes('overrun')")
        coasts = browser.execute_script(told)
        click(browser, "[data-field=brakes]")
        wait(browser, f"return ({told[7:]}).includes('braking')")
        braked = browser.execute_script(told)
        angle = [float(t.split(", ")[2].rstrip("°").replace("−", "-")) for t in (coasts, braked)]
        assert angle[0] != angle[1]
        assert "overrun" in browser.execute_script(SHOWN, ".slider:nth-of-type(2)")
        click(browser, "[data-field=brakes]")
        wait(browser, f"return ({told[7:]}) === arguments[0]", coasts)
        assert serious(browser) == []
        clean(browser)
