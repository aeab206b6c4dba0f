"""The workbench's pictures in these pages, taken anew: `make pictures`, and look at each.

Needs Chromium with chromedriver, the extras `web` and `browser`, and the built page.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from browsing import ROOT, SETTLED, TRUCK, browsing, opened, wait, workbench

from cardan.base.units import MPa
from cardan.fatigue.synthetic import Gains, synthetic


def recorded(path: Path) -> None:
    """Write a recording: S1 shaken by its joints and by the road, two spikes in it; S2 not."""
    gains = {"S1": Gains(joints=40 * MPa, road=4 * MPa), "S2": Gains(road=10 * MPa)}
    made = synthetic(seconds=150, rate=400, seed=6, gains=gains).recording
    data = made.whole()
    data[0, 3000:3003] += 900
    data[0, 20000:20002] -= 700
    head = ",".join(("time_s", *(f"{c.name} [{c.unit}]" for c in made.channels)))
    rows = np.vstack([np.arange(data.shape[1]) / made.rate, data]).T
    np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.6g")


def main() -> None:
    """Take every picture."""
    from selenium.webdriver.support.ui import Select

    with tempfile.TemporaryDirectory() as folder, browsing(deep=True) as driver:
        here = Path(folder)
        recorded(here / "run.csv")

        def press(selector: str, there: str) -> None:
            """Click what is there, and wait until something else is."""
            wait(driver, "return document.querySelector(arguments[0])", selector)
            driver.execute_script("document.querySelector(arguments[0]).click()", selector)
            wait(driver, f"return {there}")

        def take(name: str, top: str = "") -> None:
            driver.execute_script(
                "document.activeElement?.blur(); scrollTo(0, 0);"
                "document.querySelector(arguments[0] || 'x')?.scrollIntoView();", top
            )  # fmt: skip
            driver.execute_async_script("setTimeout(arguments[0], 800)")
            driver.save_screenshot(str(ROOT / "docs" / f"{name}.png"))

        with workbench(here, TRUCK) as (house, _):
            opened(driver, house)
            take("workbench")
            press("[data-view=speed]", "document.querySelector('.waterfall canvas')")
            take("workbench-speed")
            press("[data-view=change]", "document.querySelector('.map canvas')")
            press(".fix .asking button", "document.querySelector('.proposals li')")
            wait(driver, "return !document.querySelector('.map progress, .fix progress')")
            take("workbench-change")
            press("[data-view=recording]", "document.querySelector('[data-field=recording]')")
            driver.find_element("css selector", "[data-field=recording]").send_keys(
                str(here / "run.csv")
            )
            wait(driver, "return document.querySelectorAll('.channels li').length > 5")
            for field, value in (("amplitude", "80"), ("cycles", "2e6"), ("slope", "5")):
                driver.find_element("css selector", f"[data-field={field}]").send_keys(value)
            Select(driver.find_element("css selector", "[data-rule='S1=spike']")).select_by_value(
                "mask"
            )
            press(".asks .asking button", "document.querySelector('.removed rect')")
            wait(driver, "return !document.querySelector('.asks progress, .asks [role=status]')")
            take("workbench-recording", ".tabs")
            press("[data-view=line]", "document.querySelector('[data-handle]')")
            colours = driver.find_element("css selector", "[aria-label=Colours]")
            Select(colours).select_by_visible_text("dark")
            driver.execute_script(
                "[...document.querySelectorAll('.views .chips button')].at(-1).click();"
                "document.querySelector('.heat button.cell.fail').click()"
            )
            wait(driver, SETTLED)
            wait(driver, "return document.querySelector('.detail')")
            take("workbench-dark")


if __name__ == "__main__":
    main()
