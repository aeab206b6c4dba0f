"""Every view of the workbench, in every language, wide and on a telephone; a recording; a bracket.

Needs the built page: `make browser` builds it.
"""

import re
import sys
import time
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from brackets import BRACKET, LINE
from browsing import (
    CHAIN,
    SETTLED,
    arrived,
    browsing,
    clean,
    opened,
    serious,
    text_of,
    wait,
    workbench,
)  # fmt: skip

from cardan.core.units import MPa
from cardan.physics.signals.synthetic import GaugeStressPerCause, synthetic_recording
from cardan.render.i18n import LANGUAGE_CODES

pytestmark = [pytest.mark.browser, pytest.mark.filterwarnings("ignore::ResourceWarning")]

VIEWS = {
    "line": ".heat .cell", "speed": ".waterfall canvas", "change": ".map canvas",
    "variants": ".variants, .card", "bracket": ".bracket .asking button",
    "recording": ".drop input", "limits": ".limits li, .limits tr, .card li",
    "library": ".library li", "new": ".guide input",
}  # fmt: skip
"""What stands in each view once it is there."""

TURNED = (
    LINE
    + BRACKET.replace("thickness_mm: 6", "thickness_mm: 8")
    + """\
  element_mm: 25
  cases: [{name: kerb, force_N: [0, 1000, 0]}]
"""
)


OVERLAPPING = """
const boxes = (s) => [...document.querySelectorAll(s)].filter(e => e.textContent)
  .map(e => [e.textContent, e.getBoundingClientRect()]);
return boxes(arguments[0]).flatMap(([a, p]) => boxes(arguments[1])
  .filter(([, q]) => p.left < q.right && q.left < p.right)
  .filter(([, q]) => p.top < q.bottom - 3 && q.top + 3 < p.bottom)
  .map(([b]) => [a, b]));
"""
"""Texts that lie over each other, by more than the room that a line leaves."""


def sized(driver, width):
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
        "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500,
    })  # fmt: skip


def show(driver, view):
    driver.execute_script(f"document.querySelector('[data-view={view}]').click()")
    wait(driver, f"return document.querySelector('{VIEWS[view]}')")


def press(driver, selector):
    wait(driver, "return document.querySelector(arguments[0])", selector)
    driver.execute_script("document.querySelector(arguments[0]).click()", selector)


@pytest.mark.parametrize(
    ("width", "theme", "code"),
    [*((390, "dark", code) for code in LANGUAGE_CODES), (1440, "light", "en")],
)
def test_views_are_accessible_and_fit_screen_in_every_language(tmp_path, code, width, theme):
    with browsing(500, 900) as driver, workbench(tmp_path) as (house, _):
        sized(driver, width)
        opened(driver, house)
        driver.execute_script(
            "localStorage.setItem('cardan-lang', arguments[0]);"
            "localStorage.setItem('cardan-theme', arguments[1])", code, theme,
        )  # fmt: skip
        driver.refresh()
        wait(driver, SETTLED)
        shown = [
            e.get_attribute("data-view")
            for e in driver.find_elements("css selector", "[data-view]")
        ]
        assert sorted(shown) == sorted(VIEWS)
        sizes = driver.execute_script(
            "return [...document.querySelectorAll('[data-part] option')].map(o => o.textContent)"
        )
        assert any("," in s for s in sizes if " × " in s) == (code != "en")
        several = {"en": "exceeded", "pt": "excedidos", "it": "superati"}[code]
        told = driver.find_element("css selector", ".counts .fail").text
        assert re.fullmatch(rf"[1-9]\d* {several}", told)
        assert driver.execute_script(OVERLAPPING, ".room text", ".joint .angle") == []
        for view in shown:
            show(driver, view)
            wide = driver.execute_script(
                "return [document.documentElement.scrollWidth, innerWidth]"
            )
            assert (view, wide[0] <= wide[1] == width) == (view, True), wide
            assert (view, serious(driver)) == (view, [])
        clean(driver)


# ------------------------------------------------------------------ a recording


@pytest.fixture
def run(tmp_path):
    """Return the path of a recording with two spikes in S1, which decide its damage."""
    made = synthetic_recording(
        seconds=60, rate=400, seed=6, gains={"S1": GaugeStressPerCause(joints=40 * MPa)}
    ).recording
    data = made.read_all()
    data[0, 8000:8003] += 400
    data[0, 20000:20002] -= 300
    head = ",".join(("time_s", *(f"{c.name} [{c.unit}]" for c in made.channels)))
    rows = np.vstack([np.arange(data.shape[1]) / made.rate, data]).T
    path = tmp_path / "run.csv"
    np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.6g")
    return path


def answered(driver, *, after=""):
    wait(
        driver,
        "const e = document.querySelector('.lived'); return e && !document.querySelector("
        "'.asks progress, .asks [role=status]') && e.innerText !== arguments[0] && e.innerText",
        after,
    )
    return driver.execute_script("return document.querySelector('.more .rows').textContent")


def test_uploaded_recording_is_reviewed_and_gets_damage_causes(tmp_path, run):
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.support.ui import Select

    with browsing() as driver, workbench(tmp_path, CHAIN, "chain.yaml") as (house, _):
        opened(driver, house)
        show(driver, "recording")
        driver.find_element("css selector", "[data-field=recording]").send_keys(str(run))
        wait(driver, "return document.querySelectorAll('.channels li').length === 6")
        assert driver.find_elements("css selector", ".trace .open")
        for field, value in (("amplitude", "80"), ("cycles", "2e6"), ("slope", "5")):
            driver.find_element("css selector", f"[data-field={field}]").send_keys(value)
        press(driver, ".asks .asking button")
        first = answered(driver)
        assert "data rejected" in first
        # Each of the two by itself: the other decides as long as nobody has said what it is.
        driver.execute_script("document.querySelector('.channels details').open = true")
        places = driver.find_elements("css selector", "[data-rule^='S1=spike@']")
        assert len(places) == 2
        told = [first]
        for k, place in enumerate(places, 1):
            Select(place).select_by_value("mask")
            assert len(driver.find_elements("css selector", ".trace .mask")) == k
            press(driver, ".asks .asking button")
            end = time.monotonic() + 60
            while (now := answered(driver)) == told[-1] and time.monotonic() < end:
                time.sleep(0.1)
            told.append(now)
        assert ["data rejected" in one for one in told] == [True, True, False]
        assert driver.find_elements("css selector", ".removed rect")
        field = driver.find_element("css selector", ".field canvas")
        told = driver.execute_script("return document.querySelector('.field p').innerText")
        field.send_keys(Keys.ARROW_UP, Keys.ARROW_RIGHT)
        wait(driver, "return document.querySelector('.field p').innerText !== arguments[0]", told)
        driver.execute_script(
            "document.querySelectorAll('details').forEach(d => { d.open = true })"
        )
        assert serious(driver) == []
        clean(driver)
        # What no reader knows is said, and the page stays.
        (tmp_path / "run.xyz").write_text("1")
        driver.find_element("css selector", "[data-field=recording]").send_keys(
            str(tmp_path / "run.xyz")
        )
        wait(driver, "return document.querySelector('.notice.fail')?.innerText.includes('.xyz')")


# ------------------------------------------------------------------ a bracket


@pytest.mark.bracket
def test_bracket_is_solved_rotated_and_fatigue_zones_are_marked(tmp_path):
    pytest.importorskip("ngsolve")
    with browsing(deep=True) as driver, workbench(tmp_path, TURNED) as (house, _):
        opened(driver, house)
        show(driver, "bracket")
        press(driver, ".bracket .asking button")
        wait(driver, "return document.querySelector('.bracket [role=status]')")
        press(driver, ".bracket .asking button")  # stopped: its process ends
        wait(driver, "return document.querySelector('.bracket .fail')")
        press(driver, ".bracket .asking button")
        end = time.monotonic() + 540
        while time.monotonic() < end and not driver.find_elements("css selector", ".zones li"):
            time.sleep(0.5)
        zones = driver.find_elements("css selector", ".zones li")
        assert "MPa" in zones[0].text
        assert driver.find_elements("css selector", ".marks canvas")
        # Far below the page, on a telephone, pictures had come when they were scrolled to.
        drawn = "[...document.querySelectorAll('.paper img')].map(i => i.naturalWidth > 0)"
        wait(driver, f"return {drawn}.length > 1 && {drawn}.every(Boolean)")
        assert [e.text for e in driver.find_elements("css selector", ".marks span")][:1] == ["H1"]
        top = driver.execute_script("return document.querySelector('[data-top]').innerText")
        chips = driver.find_elements("css selector", ".chips[aria-label=case] button")
        driver.execute_script("arguments[0].click()", chips[-1])
        wait(driver, "return document.querySelector('[data-top]').innerText !== arguments[0]", top)
        assert serious(driver) == []
        clean(driver)


@pytest.mark.usefixtures("run")
def test_campaign_is_opened_reviewed_and_evaluated(tmp_path):
    from selenium.webdriver.support.ui import Select

    text = (
        "campaign: Twice\nrecordings: [{file: run.csv, times: 2}]\ngauges: [S1]\n"
        "strength: {amplitude_MPa: 80, cycles: 2e6, slope: 5}\nspeed: shaft_speed\n"
    )
    with browsing(width=390) as driver, workbench(tmp_path, text, "twice.yaml") as (house, _):
        arrived(driver, house)
        wait(driver, "return document.querySelector('.drives')")
        press(driver, "[data-drive='0']")
        wait(driver, "return document.querySelectorAll('.channels li').length === 2")
        Select(driver.find_element("css selector", "[data-rule='S1=spike']")).select_by_value(
            "mask"
        )
        wait(driver, "return document.querySelector('textarea').value.includes('S1=spike')")
        press(driver, ".asks .asking button")
        wait(driver, "return document.querySelector('.removed rect')")
        assert driver.execute_script("return document.querySelector('.more[open] :is(svg, img)')")
        assert driver.execute_script("return document.querySelector('.more table')")
        assert serious(driver) == []
        # Taken back by the same choice: no rule is left.
        Select(driver.find_element("css selector", "[data-rule='S1=spike']")).select_by_value("")
        wait(driver, "return document.querySelector('textarea').value.includes('mask: []')")
        wait(driver, "return document.querySelector('.trace .open')")
        press(driver, "[aria-label=undo]")
        press(driver, "[aria-label=undo]")
        wait(driver, "return !document.querySelector('textarea').value.includes('mask')")
        assert text_of(driver) == text
        # Reported and frozen as an application is.
        driver.execute_script("URL.createObjectURL = (b) => { window.took = b; return 'data:,'; };")
        press(driver, "[data-view=library]")
        press(driver, ".reports .asking button")
        wait(driver, "return window.took?.size")
        assert driver.execute_script("return window.took.type") == "text/html"
        wait(driver, "return document.querySelector('[data-field=by]')").send_keys("A. Silva")
        press(driver, "[data-do=freeze]")
        wait(driver, "return document.querySelector('#revisions').parentNode.parentNode"
                     ".querySelector('li')")  # fmt: skip
        # The recording is kept beside it, and named there.
        revision = tmp_path / "revisions" / "twice.1.yaml"
        held = text.replace("run.csv", "twice.1.files/run.csv")
        assert revision.read_text("utf-8").endswith(held)
        copy = revision.with_name("twice.1.files") / "run.csv"
        assert copy.read_bytes() == (tmp_path / "run.csv").read_bytes()
        assert serious(driver) == []
        # What changed since is said by what is written, and a command asks for it again.
        assert "cardan life twice.yaml" in driver.find_element("css selector", ".script").text
        press(driver, "[data-view=line]")
        Select(wait(driver, "return document.querySelector('[data-rule=\"S1=spike\"]')")
               ).select_by_value("mask")  # fmt: skip
        wait(driver, "return document.querySelector('textarea').value.includes('S1=spike')")
        press(driver, "[data-view=library]")
        press(driver, ".revisions li button")
        row = wait(driver, "return document.querySelector('.variants .differs')")
        assert row.text == "recordings[1].mask[1] S1=spike -"
        assert serious(driver) == []
        clean(driver)
