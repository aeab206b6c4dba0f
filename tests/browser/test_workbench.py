"""The workbench in a real browser: what a hand does, what the file says after, who is let in.

Needs the built page: `make browser` builds it.
"""

import csv
import re
import sys
import time
from contextlib import contextmanager
from importlib import resources
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from browsing import (
    CHAIN,
    ROOT,
    SETTLED,
    TRUCK,
    browsing,
    clean,
    drag,
    edited,
    on,
    opened,
    serious,
    text_of,
    wait,
    workbench,
)
from workbench import PATIENCE

from cardan.application import reader
from cardan.approval.approval import approve_application
from cardan.core.units import deg
from cardan.core.verdict import CHECK_GRADES, GRADE_TEXTS
from cardan.render.i18n import Translator
from cardan.render.phrases import VERDICT_TEXTS

pytestmark = [pytest.mark.browser, pytest.mark.filterwarnings("ignore::ResourceWarning")]


@pytest.fixture(scope="module")
def browser():
    with browsing() as driver:
        yield driver


def test_verdict_without_bearing_forces_is_incomplete_until_evaluated_again(browser, tmp_path):
    """The page stayed at "bearing forces follow", in the colour of what was known before."""
    with workbench(tmp_path, CHAIN, "chain.yaml") as (house, _):
        house.workers.slow.timeout = 1e-3
        browser.get(house.address)
        said = "return document.querySelector('.strip .pending')?.innerText.includes(arguments[0])"
        wait(browser, said, "bearing forces not evaluated: it took too long")
        strip = browser.find_element("css selector", ".strip")
        assert "incomplete" in strip.get_attribute("class").split()
        assert "INCOMPLETE" in strip.text.upper()
        house.workers.slow.timeout = PATIENCE
        strip.find_element("css selector", "button:not(.worst button)").click()
        wait(browser, SETTLED)
        assert "not evaluated:" not in strip.find_element("css selector", ".pending").text
        assert "incomplete" not in strip.get_attribute("class").split()


def test_dragging_bearing_updates_drawing_verdict_and_file(browser, tmp_path):
    with workbench(tmp_path) as (house, path):
        opened(browser, house)
        was = text_of(browser)
        before = browser.find_element("css selector", ".worst").text
        hand = drag(browser, "side/main/bearing/2", 0, -3)
        hand.perform()
        wait(browser, "return document.querySelector('.grip.held')")
        # While it is held the drawing and the cells have followed; the file has not.
        wait(browser, "return document.querySelector('.worst').innerText !== arguments[0]", before)
        assert text_of(browser) == was
        hand.reset_actions()
        hand.release().perform()
        now = edited(browser, was)
        lines = [(a, b) for a, b in zip(was.splitlines(), now.splitlines(), strict=True) if a != b]
        assert [a.split(":")[0].strip() for a, _ in lines] == ["points_mm"]
        old, new = (reader.loads(t).lines[0].layout.points[2, 2] for t in (was, now))
        assert new - old > 0.005
        verdict = browser.find_element("css selector", ".verdict").text.lower()
        said = VERDICT_TEXTS[approve_application(reader.loads(now)).verdict]
        assert said in verdict
        assert path.read_text("utf-8") == was
        browser.find_element("css selector", ".save").click()
        wait(browser, "return document.querySelector('.save').disabled")
        assert path.read_text("utf-8") == now
        clean(browser)


@pytest.mark.parametrize(
    ("handle", "key"),
    [
        ("side/main/joint/2", "points_mm"), ("top/main/bearing/1", "points_mm"),
        ("side/main/pinion/1", "pinion_slope"), ("side/main/gearbox/1", "gearbox_slope"),
        ("side/main/obstacle/1", "start_mm"),
    ],
)  # fmt: skip
def test_drawing_handles_move_by_keyboard(browser, tmp_path, handle, key):
    from selenium.webdriver.common.keys import Keys

    with workbench(tmp_path) as (house, _):
        opened(browser, house)
        was = text_of(browser)
        grip = on(browser, handle)
        grip.send_keys(Keys.ARROW_UP, Keys.ARROW_UP, Keys.ARROW_UP, Keys.ENTER)
        now = edited(browser, was)
        changed = [b for a, b in zip(was.splitlines(), now.splitlines(), strict=True) if a != b]
        assert changed[0].strip().startswith(key)
        browser.find_element("css selector", "[aria-label='undo']").click()
        assert edited(browser, now) == was
        browser.find_element("css selector", "[aria-label='redo']").click()
        assert edited(browser, was) == now


def test_escape_key_restores_moved_part(browser, tmp_path):
    from selenium.webdriver.common.keys import Keys

    with workbench(tmp_path) as (house, _):
        opened(browser, house)
        was = text_of(browser)
        shown = "return document.querySelector('.{}').textContent"
        worst, line = (browser.execute_script(shown.format(at)) for at in ("worst", "drawing"))
        on(browser, "side/main/bearing/1").send_keys(Keys.PAGE_UP)
        wait(browser, shown.format("drawing") + " !== arguments[0]", line)
        on(browser, "side/main/bearing/1").send_keys(Keys.ESCAPE)
        wait(browser, shown.format("drawing") + " === arguments[0]", line)
        wait(browser, SETTLED)
        assert browser.execute_script(shown.format("worst")) == worst
        assert text_of(browser) == was
        assert browser.find_element("css selector", ".save").get_property("disabled")


@pytest.mark.parametrize("name", ["refuse-collector-6x2", "tandem-6x4"])
def test_load_state_of_worst_check_is_shown_first(browser, tmp_path, name):
    text = (ROOT / f"examples/{name}.yaml").read_text("utf-8")
    with workbench(tmp_path, text) as (house, _):
        opened(browser, house)
        shown = "[...document.querySelectorAll('.poser [aria-pressed=true]')].at(-1).innerText"
        first = "document.querySelector('.worst li span').innerText.split(',')[0]"
        wait(browser, f"return {shown} === {first}")


def test_heat_map_cell_opens_its_part_equation_and_source(browser, tmp_path):
    with workbench(tmp_path) as (house, _):
        opened(browser, house)
        cell = browser.find_element("css selector", ".heat tbody tr:first-child .cell.fail")
        name = browser.find_element("css selector", ".heat tbody tr:first-child th").text
        cell.click()
        wait(browser, "return document.querySelector('.detail .equation')")
        detail = browser.find_element("css selector", ".detail").text
        assert name.splitlines()[0] in detail
        assert "Source of the limit" in detail
        assert browser.find_elements("css selector", ".drawing .chosen")
        state = browser.find_element("css selector", ".poser .chips [aria-pressed='true']").text
        assert state in detail


@contextmanager
def sized(driver, width):
    """A screen of that width, 844 high."""
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
        "width": width, "height": 844, "deviceScaleFactor": 1, "mobile": width < 500,
    })  # fmt: skip
    try:
        yield
    finally:
        driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


IN_SIGHT = """
const box = document.querySelector('#detail')?.getBoundingClientRect();
return box && box.top >= 0 && box.bottom <= innerHeight;
"""


@pytest.mark.parametrize("width", [1440, 390])
def test_detail_of_criterion_opens_in_sight_where_it_is_chosen(browser, tmp_path, width):
    """It opened below the map: a click on a worst criterion seemed to do nothing."""
    from selenium.webdriver.common.keys import Keys

    with workbench(tmp_path) as (house, _), sized(browser, width):
        opened(browser, house)
        tile = browser.find_element("css selector", ".worst li:nth-child(2) button")
        tile.click()
        wait(browser, IN_SIGHT)
        assert tile.get_attribute("aria-expanded") == "true"
        assert browser.find_elements("css selector", ".strip + .detailed #detail")
        browser.execute_script("document.querySelector('[data-view=speed]').click()")
        wait(browser, "return !document.querySelector('#detail')")  # what is asked for comes first
        tile = wait(browser, "return document.querySelectorAll('.worst button')[1]")
        tile.click()
        wait(browser, IN_SIGHT)
        browser.execute_script("document.querySelector('[data-view=line]').click()")
        cell = wait(browser, "return document.querySelectorAll('.heat .cell.fail')[3]")
        browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", cell)
        cell.send_keys(Keys.ENTER)
        wait(browser, "return document.querySelector('.heat .opened #detail')")
        wait(browser, IN_SIGHT)
        (name,) = browser.find_elements("css selector", "#detail")
        row = "return arguments[0].closest('tr').nextElementSibling.className"
        assert browser.execute_script(row, cell) == "opened"
        assert cell.get_attribute("aria-expanded") == "true"
        assert name.text in cell.get_attribute("aria-label")
        close = browser.find_element("css selector", ".detail header button")
        close.send_keys(Keys.ESCAPE)
        wait(browser, "return !document.querySelector('#detail')")
        assert browser.switch_to.active_element == cell
        clean(browser)


def test_content_begins_in_upper_third_of_telephone(browser, tmp_path):
    """Five tiles of the worst criteria filled the screen: the drawing began 700 px down."""
    from selenium.webdriver.support.ui import Select

    with workbench(tmp_path) as (house, _), sized(browser, 390):
        opened(browser, house)
        rect = "return document.querySelector(arguments[0]).getBoundingClientRect()"
        for lang in ("pt", "it", "en"):
            chosen = browser.find_element("css selector", ".tools select")
            Select(chosen).select_by_visible_text(lang)
            wait(browser, "return document.documentElement.lang.startsWith(arguments[0])", lang)
            wait(browser, SETTLED)
            assert browser.execute_script(rect, ".columns")["top"] <= 844 / 3
            assert browser.execute_script(rect, ".verdict")["height"] < 40
            assert browser.execute_script(rect, ".worst")["height"] < 60
            tiles = browser.execute_script("return document.querySelector('.worst').textContent")
            percents = [int(p) for p in re.findall(r"\d+(?= %)", tiles)]
            assert percents
            assert max(percents) <= 100
        clean(browser)


CELLS = """
return [...document.querySelectorAll('.heat tbody tr')].flatMap(row =>
  [...row.querySelectorAll('td')].map((cell, k) => [row.querySelector('th').title, k,
    (row.querySelector('th i')?.innerText ?? '').replace(/:.*/, ''),
    cell.querySelector('button')?.ariaLabel ?? ''])).filter(c => c[3]);
"""


@pytest.mark.parametrize("name", ["refuse-collector-6x2", "pick-up-4x4"])
def test_heat_map_cells_match_check_margin_grade_and_part(browser, tmp_path, name):
    """Margin, grade and part of `cardan.check`; what is worst of a quantity in a state is there."""
    text, say = (
        (ROOT / f"examples/{name}.yaml").read_text("utf-8"),
        Translator("en").with_minus_sign,
    )
    found = approve_application(reader.loads(text))
    states, several = [s.name for s in found.application.states], len(found.line_responses) > 1
    said, least = set(), {}
    for c in (c for f in found.study_results if f.study == "driveline" for c in f.checks):
        line, part = c.line if several else "", "" if c.part.kind == "line" else say.part(c.part)
        row, margin = (say.name(c.quantity), states.index(c.when.name), line), shown(c.margin)
        said.add((*row, part, GRADE_TEXTS[c.grade], margin))
        rank = (-CHECK_GRADES.index(c.grade), c.margin)
        least[row] = min(least.get(row, (rank, margin)), (rank, margin))
    with workbench(tmp_path, text) as (house, _):
        opened(browser, house)
        cells = browser.execute_script(CELLS)
    drawn = {}
    for title, k, line, label in cells:
        where, _, what = label.rpartition(": ")
        grade, margin = what.removesuffix(" %").split(", ")
        parts = where.removeprefix(f"{title}, {say.state(states[k])}").removeprefix(", ")
        assert (title, k, line, parts, grade, margin) in said
        drawn.setdefault((title, k, line), set()).add(margin)
    assert drawn.keys() == least.keys()
    assert all(margin in drawn[row] for row, (_, margin) in least.items())


def shown(margin):
    """A margin as a cell has room for."""
    if abs(margin) > 9.99:
        return "> 999" if margin > 0 else "< −999"
    digits = 1 if 0 < abs(margin) < 0.0095 else 0
    return f"{100 * margin:+.{digits}f}".replace("-", "−").replace("+0", "0", margin == 0)


@pytest.mark.parametrize("lang", ["en", "pt"])
def test_dynamic_clearance_cell_opens_its_obstacle(browser, tmp_path, lang):
    """The value beside the obstacle is that of the cell, not the one of rubber that stands."""
    from selenium.webdriver.support.ui import Select

    say, least = Translator(lang).with_minus_sign, {}
    for c in approve_application(reader.loads(TRUCK)).checks:
        if c.quantity == "clearance_on_rubber":
            state = say.state(c.when.name)
            least[state] = min(least.get(state, c.value), c.value)
    with workbench(tmp_path) as (house, _):
        opened(browser, house)
        Select(browser.find_elements("css selector", ".tools select")[0]).select_by_visible_text(
            lang
        )
        name = {"en": "Dynamic clearance", "pt": "Folga dinâmica"}[lang]
        row = f"//*[contains(@class, 'heat')]//tr[th[starts-with(., '{name}')]]"
        wait(browser, "return document.documentElement.lang.startsWith(arguments[0])", lang)
        wait(browser, SETTLED)
        cell = browser.find_elements("xpath", f"{row}//button[contains(@class, 'fail')]")[-1]
        browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", cell)
        cell.click()
        wait(browser, "return document.querySelector('.drawing .obstacle.chosen')")
        assert browser.find_elements("css selector", ".drawing .tube.chosen")
        left = browser.find_element("css selector", ".room .onrubber").text
        free = browser.find_element("css selector", ".room text:nth-child(2)").text
        state = browser.find_element("css selector", ".poser .chips [aria-pressed='true']").text
        room = f"{1e3 * least[state]:.1f}".replace("-", "−")
        room = room.replace(".", ",") if lang == "pt" else room
        assert left == say("{room} mm free on rubber", room=room)
        assert free != f"{room} mm"
        # And on a telephone, where the columns are taken apart.
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": 390, "height": 900, "deviceScaleFactor": 1, "mobile": True,
        })  # fmt: skip
        wait(browser, "return document.querySelector('.drawing').clientWidth < 390")
        assert browser.find_element("css selector", ".room .onrubber").is_displayed()
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        detail = browser.find_element("css selector", ".detail").text
        assert name in detail
        assert "cr = c + a" in detail
        clean(browser)
        Select(browser.find_elements("css selector", ".tools select")[0]).select_by_visible_text(
            "en"
        )


def test_sliders_show_positions_between_load_states(browser, tmp_path):
    with workbench(tmp_path) as (house, _):
        opened(browser, house)
        shown = browser.find_element("css selector", ".angles table").text
        slide = """const [k, to] = arguments;
            const e = document.querySelectorAll('.poser input[type=range]')[k];
            e.value = to; e.dispatchEvent(new Event('input', {bubbles: true}));"""
        browser.execute_script(slide, 0, -40)
        wait(browser, "return document.querySelector('.angles').innerText.includes('sliders')")
        at = "return document.querySelector('.angles table').innerText"
        wait(browser, f"{at} !== arguments[0]", shown)
        still = browser.execute_script(at)
        browser.execute_script(slide, 1, 5000)
        wait(browser, f"{at} !== arguments[0]", still)
        assert "+" in browser.find_elements("css selector", ".poser output")[1].text
        assert len(browser.find_elements("css selector", ".poser .plot canvas")) == 4


def test_phase_dial_rotates_yoke(browser, tmp_path):
    from selenium.webdriver.common.keys import Keys

    with workbench(tmp_path, CHAIN) as (house, _):
        opened(browser, house)
        was, sum_ = text_of(browser), browser.find_element("css selector", ".figure b").text
        dial = on(browser, "phase/driveline.shafts[2].phase_deg")
        browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", dial)
        dial.send_keys(Keys.PAGE_UP, Keys.PAGE_UP, Keys.ENTER)
        now = edited(browser, was)
        assert reader.loads(now).lines[0].line.phases[1] == pytest.approx(0.349, abs=1e-3)
        assert browser.find_element("css selector", ".figure b").text != sum_
        assert len(browser.find_elements("css selector", ".dials .plot canvas")) == 2


def test_dragged_phase_dial_shows_equivalent_angle_of_check(browser, tmp_path):
    """The angle below the phasors is that of AE-7, summed here by hand from the members' bends."""
    with workbench(tmp_path) as (house, _):
        opened(browser, house)
        was, angle = text_of(browser), "document.querySelector('.figure b').innerText"
        first, at = browser.execute_script(f"return {angle}"), "driveline.shafts[3].phase_deg"
        dial = on(browser, f"phase/{at}")
        browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", dial)
        hand = drag(browser, f"phase/{at}", 4, -4, dot=".knob")
        hand.perform()
        wait(browser, f"return {angle} !== arguments[0]", first)  # held: the sum has followed
        assert text_of(browser) == was
        hand.reset_actions()
        hand.release().perform()
        app = reader.loads(edited(browser, was))
        turned = float(dial.get_attribute("aria-valuenow"))
        assert turned > 20
        assert app.lines[0].line.phases[2] == pytest.approx(turned * deg, abs=1e-9)
        shown = browser.find_elements("css selector", ".poser .chips button")
        (state,) = (k for k, b in enumerate(shown) if b.get_attribute("aria-pressed") == "true")
        response = approve_application(app).line_responses[0]
        bends = response.kinematics.side_angles[state] - 1j * response.kinematics.top_angles[state]
        turns = np.cumsum([0.0, *(shaft.phase for shaft in app.lines[0].line.shafts)])
        whole = abs(
            sum(
                (-1) ** k * (b * np.exp(1j * p)) ** 2
                for k, (b, p) in enumerate(zip(bends, turns, strict=True))
            )
        )
        told = float(browser.execute_script(f"return {angle}").removesuffix("°"))
        # The exact sum differs by what the squares of the angles are of 1.
        assert told == pytest.approx(whole**0.5 / deg, rel=max(abs(bends)) ** 2)
        clean(browser)


def test_joint_replacement_shows_catalogue_ratings(browser, tmp_path):
    """Its torques are those of the row in the catalogue's own file."""
    from selenium.webdriver.support.ui import Select

    catalogue = resources.files("cardan.application").joinpath("catalogues/joints.csv")
    rows = {row["name"]: row for row in csv.DictReader(StringIO(catalogue.read_text("utf-8")))}
    with workbench(tmp_path) as (house, _):
        opened(browser, house)
        was, at = text_of(browser), "[data-part='driveline.joints']"
        before = browser.find_element("css selector", ".counts").text
        Select(browser.find_element("css selector", at)).select_by_value("2065")
        now = edited(browser, was)
        joints = reader.loads(now).lines[0].line.joints
        assert {j.name for j in joints} == {"2065"}
        cells = browser.find_elements("css selector", ".parts tbody tr:first-child td.n")
        peak, reversing, _ = (c.text.removesuffix(" N·m") for c in cells)
        assert float(peak) == float(rows["2065"]["peak_Nm"]) == joints[0].peak_torque
        assert float(reversing) == float(rows["2065"]["reversing_Nm"])
        assert browser.find_element("css selector", ".counts").text != before
        browser.find_element("css selector", "[aria-label='undo']").click()
        assert edited(browser, now) == was
        clean(browser)


def test_single_correction_is_applied_by_click(browser, tmp_path):
    with workbench(tmp_path, CHAIN) as (house, _):
        opened(browser, house)
        was = text_of(browser)
        browser.find_element("css selector", ".helps > header button").click()
        wait(browser, "return document.querySelector('.help li button')")
        browser.find_element("css selector", ".help li button").click()
        now = edited(browser, was)
        assert approve_application(reader.loads(was)).verdict == "warn"
        assert approve_application(reader.loads(now)).verdict == "pass"
        assert "✓ approved" in browser.find_element("css selector", ".verdict").text.lower()


def test_tube_is_replaced_from_catalogue(browser, tmp_path):
    from selenium.webdriver.support.ui import Select

    with workbench(tmp_path) as (house, _):
        opened(browser, house)
        was = text_of(browser)
        chosen = browser.find_element("css selector", "[data-part='driveline.shafts[2].tube']")
        Select(chosen).select_by_value("100x3")
        now = edited(browser, was)
        assert reader.loads(now).lines[0].line.shafts[1].tube.outer == pytest.approx(0.1)
        assert now.count("120x4") == was.count("120x4") - 1
        browser.find_element("css selector", "[aria-label='undo']").click()
        assert edited(browser, now) == was


def test_unsaved_edit_survives_crash_and_external_file_change(browser, tmp_path):
    with workbench(tmp_path, CHAIN) as (house, path):
        opened(browser, house)
        was = text_of(browser)
        button = "document.querySelectorAll('.dial .set button')[1].click()"
        browser.execute_script(button)
        now = edited(browser, was)
        wait(browser, "return performance.now() > 1500")
        time.sleep(0.6)
        browser.refresh()
        wait(browser, SETTLED)
        assert text_of(browser) == now
        assert (
            "Unsaved changes of last time" in browser.find_element("css selector", ".notice").text
        )
    with workbench(tmp_path, CHAIN) as (house, path):  # as after a crash of the server
        opened(browser, house)
        assert text_of(browser) == now
        path.write_text(CHAIN + "# somebody else\n", "utf-8")
        wait(browser, "return document.querySelector('.notice.warn')")
        browser.find_element("css selector", ".notice.warn button").click()
        assert edited(browser, now).endswith("# somebody else\n")
        browser.find_element("css selector", "[aria-label='undo']").click()
        assert edited(browser, CHAIN + "# somebody else\n") == now


def test_typed_text_is_checked_and_error_position_is_shown(browser, tmp_path):
    with workbench(tmp_path, CHAIN) as (house, _):
        opened(browser, house)
        put = """const e = document.querySelector('.editor textarea'); e.value = arguments[0];
            e.dispatchEvent(new Event('input', {bubbles: true}));"""
        browser.execute_script(put, CHAIN.replace("2800", "fast"))
        wait(browser, "return document.querySelector('.problems .fail')")
        assert "11:12" in browser.find_element("css selector", ".problems").text
        assert browser.find_element("css selector", ".drawing")
        browser.execute_script(put, CHAIN.replace("2800", "900"))
        wait(browser, "return !document.querySelector('.problems .fail')")
        wait(browser, SETTLED)
        assert "✓ approved" in browser.find_element("css selector", ".verdict").text.lower()


def test_three_dimensional_view_is_drawn(tmp_path):
    with browsing(deep=True) as driver, workbench(tmp_path, CHAIN) as (house, _):
        opened(driver, house)
        driver.find_elements("css selector", ".views .chips button")[-1].click()
        wait(driver, "return document.querySelector('.canvas canvas')")
        colours = """
            const c = document.querySelector('.canvas canvas');
            const d = document.createElement('canvas');
            [d.width, d.height] = [c.width, c.height];
            const x = d.getContext('2d');
            x.drawImage(c, 0, 0);
            const pixels = x.getImageData(0, 0, d.width, d.height).data.buffer;
            return new Set(new Uint32Array(pixels)).size"""
        end = time.monotonic() + PATIENCE
        while driver.execute_script(colours) < 50 and time.monotonic() < end:
            time.sleep(0.1)
        assert driver.execute_script(colours) > 50
        clean(driver)


def test_yoke_phase_is_seen_in_three_dimensions(tmp_path):
    """A joint was a ball: a shaft in phase and one out of phase looked alike."""
    picture = "return document.querySelector('.canvas canvas').toDataURL()"
    with browsing(deep=True) as driver, workbench(tmp_path, CHAIN) as (house, _):
        opened(driver, house)
        driver.find_elements("css selector", ".views .chips button")[-1].click()
        wait(driver, "return document.querySelector('.canvas canvas')")
        driver.execute_async_script("setTimeout(arguments[0], 500)")
        in_phase = driver.execute_script(picture)
        driver.execute_script("document.querySelectorAll('.dials .set button')[1].click()")
        wait(driver, SETTLED)
        wait(driver, f"{picture} !== arguments[0]", in_phase)
        clean(driver)


DRAWN = """
    const c = document.querySelector('.canvas canvas'), d = document.createElement('canvas');
    [d.width, d.height] = [c.width, c.height];
    const x = d.getContext('2d');
    x.drawImage(c, 0, 0);
    const alpha = x.getImageData(0, 0, d.width, d.height).data.filter((_, k) => k % 4 === 3);
    const along = Array.from(alpha, (a, k) => (a ? k % d.width : -1)).filter((k) => k >= 0);
    const [low, high] = along.reduce(([a, b], k) => [Math.min(a, k), Math.max(b, k)], [1e9, -1]);
    return [d.width, low / d.width, high / d.width]"""
"""How wide a picture is, and from where to where of it something is drawn."""


def test_three_dimensional_view_fits_resized_page(tmp_path):
    """On a page made narrow the picture stayed as wide as it was, and was cut."""
    with browsing(deep=True) as driver, workbench(tmp_path, CHAIN) as (house, _):
        opened(driver, house)
        driver.find_elements("css selector", ".views .chips button")[-1].click()
        wait(driver, "return document.querySelector('.canvas canvas')")
        for width in (390, 1024, 390):
            driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
                "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500,
            })  # fmt: skip
            wait(driver, "return Math.abs(document.querySelector('.canvas').clientWidth / "
                         "document.querySelector('.canvas canvas').width - 1) < .01")  # fmt: skip
            size, low, high = wait(driver, DRAWN)
            assert size < width
            # Margins of an eighth about points; what stands about them reaches into those.
            assert 0 < low < 0.15 < 0.85 < high < 1
        clean(driver)


def test_off_screen_limits_update_after_drag_and_visible_ones_during(tmp_path):
    """The limits of a telephone lie far below what is dragged there."""
    heat = "return document.querySelector('.heat tbody').innerText"
    with browsing() as driver, workbench(tmp_path) as (house, _):
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": 390, "height": 700, "deviceScaleFactor": 1, "mobile": True,
        })  # fmt: skip
        opened(driver, house)
        driver.execute_script("document.querySelector('.views').scrollIntoView()")
        was, strip = (
            driver.execute_script(heat),
            "return document.querySelector('.strip').innerText",
        )
        verdict = driver.execute_script(strip)
        driver.execute_script("""
            const e = document.querySelector("[data-handle='side/main/bearing/2']");
            e.setPointerCapture = () => {};
            window.hand = (kind, up) => e.dispatchEvent(new PointerEvent(kind, {
                bubbles: true, pointerId: 1, button: 0, clientX: 200, clientY: 300 - up}));
            hand('pointerdown', 0); hand('pointermove', 8);""")
        wait(driver, f"{strip} !== arguments[0]", verdict)
        assert driver.execute_script(heat) == was
        driver.execute_script("document.querySelector('.heat').scrollIntoView()")
        wait(driver, f"{heat} !== arguments[0]", was)
        moved = driver.execute_script(heat)
        driver.execute_script("document.querySelector('.views').scrollIntoView()")
        time.sleep(0.5)
        driver.execute_script("hand('pointermove', 16)")
        driver.execute_script("hand('pointerup', 16)")
        wait(driver, SETTLED)
        assert driver.execute_script(heat) != moved
        clean(driver)


@pytest.mark.parametrize(("code", "theme"), [("en", "light"), ("pt", "dark")])
def test_views_have_no_accessibility_faults_or_external_requests(browser, tmp_path, code, theme):
    with workbench(tmp_path) as (house, _):
        opened(browser, house)
        browser.execute_script(
            "localStorage.setItem('cardan-lang', arguments[0]);"
            "localStorage.setItem('cardan-theme', arguments[1])", code, theme,
        )  # fmt: skip
        browser.refresh()
        wait(browser, SETTLED)
        assert browser.execute_script("return document.documentElement.lang")[:2] == code
        browser.find_element("css selector", ".cell.fail").click()
        browser.find_element("css selector", ".helps > header button").click()
        wait(browser, "return document.querySelector('.detail') && document.querySelector('.help')")
        browser.execute_script(
            "document.querySelectorAll('details').forEach(d => { d.open = true })"
        )
        wait(browser, SETTLED)
        assert serious(browser) == []
        fetched = browser.execute_script(
            "return performance.getEntriesByType('resource').map(e => new URL(e.name).host)"
        )
        assert set(fetched) == {f"127.0.0.1:{house.port}"}
        assert browser.execute_script("return location.href").endswith(f":{house.port}/")
        browser.execute_script("localStorage.clear()")
        clean(browser)


@pytest.mark.parametrize("width", [390, 768, 1920])
def test_workbench_fits_screen_width(tmp_path, width):
    with browsing(500, 900) as driver, workbench(tmp_path) as (house, _):
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500,
        })  # fmt: skip
        opened(driver, house)
        wide = driver.execute_script("return [document.documentElement.scrollWidth, innerWidth]")
        assert wide[0] <= wide[1] == width
        small = driver.execute_script("""
            return [...document.querySelectorAll('button, select, input')]
              .map(e => [e.innerText, e.getBoundingClientRect()])
              .filter(([, r]) => r.width && r.height < 24).map(([t, r]) => [t, r.height])""")
        assert [s for s in small if s[1] < 16] == []


HOSTILE = [
    "<img src=x onerror=document.title=1>",
    "</script><script>alert(1)</script>",
    "カルダン" * 50,
]


@pytest.mark.parametrize("name", HOSTILE, ids=["markup", "script", "wide"])
def test_hostile_name_is_shown_as_text_in_every_view(browser, tmp_path, name):
    quoted = '"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"'
    text = TRUCK.replace("title: Refuse collector 6x2, three shafts", f"title: {quoted}")
    text = text.replace("name: auxiliary beam", f"name: {quoted}")
    text = text.replace("{name: full rebound, kind", f"{{name: {quoted}, kind")
    with workbench(tmp_path, text) as (house, _):
        opened(browser, house)
        browser.find_element("css selector", ".cell.fail").click()
        browser.find_element("css selector", ".helps > header button").click()
        wait(browser, "return document.querySelector('.detail') && document.querySelector('.help')")
        assert browser.find_element("css selector", "h1").get_attribute("title") == name
        assert not browser.find_elements("css selector", "img, main script, h1 *")
        assert name in browser.execute_script("return document.title")
        browser.execute_script("document.querySelector('.views .chips button').click()")  # pinned
        shown = {"speed": ".waterfall canvas", "change": ".map canvas", "variants": ".variants td",
                 "bracket": ".asking", "recording": ".drop", "limits": ".limits td",
                 "library": ".library li b", "new": ".guide", "line": ".drawing"}  # fmt: skip
        for view, there in shown.items():
            browser.execute_script(f"document.querySelector('[data-view={view}]').click()")
            wait(browser, f"return document.querySelector({there!r})")
            assert not browser.find_elements("css selector", "main img, main script, h1 *")
            wide = browser.execute_script(
                "return [document.documentElement.scrollWidth, innerWidth]"
            )
            assert wide[0] <= wide[1], view
        clean(browser)


def test_page_without_token_shows_how_to_start_server(tmp_path):
    with browsing() as driver, workbench(tmp_path, CHAIN) as (house, _):
        driver.get(f"http://127.0.0.1:{house.port}/")
        wait(driver, "return document.body.innerText.includes('cardan serve')")
