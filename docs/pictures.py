"""The workbench's pictures in these pages, taken anew: `make pictures`, and look at each.

`python docs/pictures.py NAME...` takes some of them. The live page of an example, which opens
without an installation, is written with them. Needs Chromium with chromedriver, the extras `web`
and `browser`, and the built page.
"""

import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
sys.path.insert(0, str(Path(__file__).parent))

from browsing import CHAIN, ROOT, SETTLED, TRUCK, browsing, opened, wait, workbench
from picture_numbers import record_numbers

from cardan.application.reader import read
from cardan.approval.approval import Approval, approve_driveline
from cardan.core.units import MPa
from cardan.physics.signals.synthetic import GaugeStressPerCause, synthetic_recording
from cardan.render.i18n import ENGLISH
from cardan.web.static_export import standalone_page

DOCS = Path(__file__).parent
EXAMPLE = "refuse-collector-6x2"
"""The example that `browsing.TRUCK` is the text of."""
SMALL_EXAMPLE = "three-joint-chain"
"""That of `browsing.CHAIN`: its corrections and their map take seconds, a truck's minutes."""


def recorded(path: Path) -> None:
    """Write a recording: S1 shaken by its joints and by the road, two spikes in it; S2 not."""
    gains = {
        "S1": GaugeStressPerCause(joints=40 * MPa, road=4 * MPa),
        "S2": GaugeStressPerCause(road=10 * MPa),
    }
    made = synthetic_recording(seconds=150, rate=400, seed=6, gains=gains).recording
    data = made.read_all()
    data[0, 3000:3003] += 900
    data[0, 20000:20002] -= 700
    head = ",".join(("time_s", *(f"{c.name} [{c.unit}]" for c in made.channels)))
    rows = np.vstack([np.arange(data.shape[1]) / made.rate, data]).T
    np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.6g")


class Workbench:
    """A page of the workbench in a browser, and what a hand does on it."""

    def __init__(self, driver: Any, folder: Path) -> None:
        self.driver, self.folder = driver, folder

    def wait(self, script: str, *arguments: str) -> None:
        wait(self.driver, script, *arguments)

    def press(self, selector: str, there: str) -> None:
        """Click what is there, and wait until something else is."""
        self.wait("return document.querySelector(arguments[0])", selector)
        self.driver.execute_script("document.querySelector(arguments[0]).click()", selector)
        self.wait(f"return {there}")

    def take(self, name: str, top: str = "") -> None:
        """Write a picture, from where an element begins."""
        self.driver.execute_script(
            "document.activeElement?.blur(); scrollTo(0, 0);"
            "document.querySelector(arguments[0] || 'x')?.scrollIntoView();", top
        )  # fmt: skip
        self.driver.execute_async_script("setTimeout(arguments[0], 800)")
        self.driver.save_screenshot(str(DOCS / name))


def line(page: Workbench) -> None:
    page.take("workbench.png")


def speed(page: Workbench) -> None:
    page.press("[data-view=speed]", "document.querySelector('.waterfall canvas')")
    page.take("workbench-speed.png")


def change(page: Workbench) -> None:
    page.press("[data-view=change]", "document.querySelector('.map canvas')")
    page.press(".fix .asking button", "document.querySelector('.proposals li')")
    page.wait("return !document.querySelector('.map progress, .fix progress')")
    page.take("workbench-change.png")


def recording(page: Workbench) -> None:
    from selenium.webdriver.support.ui import Select

    recorded(page.folder / "run.csv")
    find = page.driver.find_element
    page.press("[data-view=recording]", "document.querySelector('[data-field=recording]')")
    find("css selector", "[data-field=recording]").send_keys(str(page.folder / "run.csv"))
    page.wait("return document.querySelectorAll('.channels li').length > 5")
    for field, value in (("amplitude", "80"), ("cycles", "2e6"), ("slope", "5")):
        find("css selector", f"[data-field={field}]").send_keys(value)
    Select(find("css selector", "[data-rule='S1=spike']")).select_by_value("mask")
    page.press(".asks .asking button", "document.querySelector('.removed rect')")
    page.wait("return !document.querySelector('.asks progress, .asks [role=status]')")
    page.take("workbench-recording.png", ".tabs")


def dark(page: Workbench) -> None:
    from selenium.webdriver.support.ui import Select

    page.press("[data-view=line]", "document.querySelector('[data-handle]')")
    colours = page.driver.find_element("css selector", "[aria-label=Colours]")
    Select(colours).select_by_visible_text("dark")
    page.driver.execute_script(
        "[...document.querySelectorAll('.views .chips button')].at(-1).click();"
        "document.querySelector('.heat button.cell.fail').click()"
    )
    page.wait(SETTLED)
    page.wait("return document.querySelector('.detail')")
    page.take("workbench-dark.png")


VIEWS = {
    EXAMPLE: {
        "workbench.png": line,
        "workbench-speed.png": speed,
        "workbench-recording.png": recording,
        "workbench-dark.png": dark,
    },
    SMALL_EXAMPLE: {"workbench-change.png": change},
}
"""What draws each picture, by the example that it shows."""
TEXTS = {EXAMPLE: TRUCK, SMALL_EXAMPLE: CHAIN}
LIVE = "live.html"


def live() -> None:
    """Write the live page of the example, without a path of this machine."""
    file = ROOT / "examples" / f"{EXAMPLE}.yaml"
    text = file.read_text("utf-8")
    page = standalone_page(text, name=file.name, folder=None, say=ENGLISH)
    (DOCS / LIVE).write_text(page, encoding="utf-8")


def approved(example: str) -> Approval:
    """Return the approval of an example."""
    return approve_driveline(read(ROOT / "examples" / f"{example}.yaml"))


def main() -> None:
    """Take the pictures that are named, or every one, and keep the numbers behind them."""
    chosen = sys.argv[1:]
    if LIVE in chosen or not chosen:
        live()
        record_numbers(LIVE, EXAMPLE, approved(EXAMPLE))
    for example, views in VIEWS.items():
        names = [name for name in views if name in chosen or not chosen]
        if not names:
            continue
        found = approved(example)
        with (
            tempfile.TemporaryDirectory() as folder,
            browsing(deep=True) as driver,
            workbench(Path(folder), TEXTS[example]) as (house, _),
        ):
            opened(driver, house)
            for name in names:
                views[name](Workbench(driver, Path(folder)))
                record_numbers(name, example, found)


if __name__ == "__main__":
    main()
