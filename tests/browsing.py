"""A real browser on a workbench, and what a hand does in it."""

import os
import shutil
import time
from contextlib import contextmanager
from pathlib import Path

from workbench import PATIENCE, running

from cardan.web import server

ROOT = Path(__file__).parents[1]
AXE = Path(os.environ.get("AXE", ROOT / "node_modules/axe-core/axe.min.js"))
TRUCK = (ROOT / "examples/refuse-collector-6x2.yaml").read_text("utf-8")
CHAIN = (ROOT / "examples/three-joint-chain.yaml").read_text("utf-8")
SETTLED = (
    "return document.querySelector('.strip .counts .pass')"
    " && !document.querySelector('.strip.open')"
)


@contextmanager
def browsing(width=1440, height=1000, *, deep=False):
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    drawn = (
        ("--use-angle=swiftshader", "--enable-unsafe-swiftshader") if deep else ("--disable-gpu",)
    )
    options = webdriver.ChromeOptions()
    for flag in ("--headless=new", "--no-sandbox", f"--window-size={width},{height}", *drawn,
                 "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"):  # fmt: skip
        options.add_argument(flag)
    options.binary_location = shutil.which("chromium") or shutil.which("google-chrome") or ""
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
    try:
        yield driver
    finally:
        driver.quit()


@contextmanager
def workbench(tmp_path, text=TRUCK, name="truck.yaml", *, folder=False):
    """Serve a file, or an empty folder; yield the house and what it serves."""
    if folder:
        (tmp_path / "desk").mkdir(exist_ok=True)
        with running(tmp_path / "desk", tmp_path / "drafts", built=server.static_files()) as house:
            yield house, tmp_path / "desk"
        return
    path = tmp_path / name
    if not path.exists():
        path.write_text(text, "utf-8")
    with running(path, tmp_path / "drafts", built=server.static_files()) as house:
        yield house, path


def wait(driver, script, *arguments):
    """Return what a script comes to, once that is something."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if found := driver.execute_script(script, *arguments):
            return found
        time.sleep(0.03)
    said = driver.execute_script("return document.querySelector('main')?.innerText.slice(0, 300)")
    msg = f"{script}: {said} {driver.get_log('browser')}"
    raise TimeoutError(msg)


def arrived(driver, house):
    driver.get("about:blank")
    driver.get_log("browser")  # of pages before: their servers are gone
    driver.get(house.address)


def opened(driver, house):
    arrived(driver, house)
    wait(driver, SETTLED)


def text_of(driver):
    return driver.execute_script("return document.querySelector('.editor textarea').value")


def on(driver, handle):
    return driver.find_element("css selector", f"[data-handle='{handle}']")


def drag(driver, handle, dx, dy, steps=6, dot=".dot"):
    from selenium.webdriver.common.action_chains import ActionChains

    at = driver.find_element("css selector", f"[data-handle='{handle}'] {dot}")
    hand = ActionChains(driver, duration=10).move_to_element(at).click_and_hold()
    for _ in range(steps):
        hand.move_by_offset(dx, dy)
    return hand


def edited(driver, was):
    """Return the text once it is another, and settled."""
    wait(driver, "return document.querySelector('.editor textarea').value !== arguments[0]", was)
    wait(driver, SETTLED)
    return text_of(driver)


def clean(driver):
    log = [e for e in driver.get_log("browser") if e["level"] in ("SEVERE", "WARNING")]
    assert [e for e in log if "GPU" not in e["message"] and "GL Driver" not in e["message"]] == []


def serious(driver):
    driver.execute_script(AXE.read_text(encoding="utf-8"))
    report = driver.execute_async_script(
        "const done = arguments[arguments.length - 1]; axe.run().then(done, e => done(String(e)));"
    )
    assert report["passes"]
    return [(v["id"], v["impact"], v["nodes"][0]["html"][:200]) for v in report["violations"]
            if v["impact"] in ("serious", "critical")]  # fmt: skip
