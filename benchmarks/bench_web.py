"""The workbench in Chromium, from a hand's move to painted pixels, beside an empty echo page.

    python benchmarks/bench_web.py

The echo page sends a number over a socket of the same server, gets it back and writes it: what
is left is Chromium, loopback and Python's event loop. Both are measured in turn in one run.
The clock tells of whoever else uses the processors, too: beside it stand what a move takes of the
process that answers, and of the page's own, by the processor's time.
Needs Chromium with chromedriver, the extras `web` and `browser`, and the built page.
"""

import asyncio
import os
import shutil
import socket
import sys
import tempfile
import threading
from pathlib import Path
from statistics import median

ROOT = Path(__file__).parents[1]
TRUCK = ROOT / "examples" / "refuse-collector-6x2.yaml"
MOVES = 40
ROUNDS = 2

ECHO = """<!doctype html><title>echo</title><p id=at></p><script>
const ws = new WebSocket(`ws://${location.host}/ask`); window.took = [];
let since = 0;
ws.onmessage = e => { at.textContent = e.data; const from = since;
  requestAnimationFrame(() => { const c = new MessageChannel();
    c.port1.onmessage = () => took.push(performance.now() - from); c.port2.postMessage(0); }); };
window.move = k => { since = performance.now(); ws.send(String(k)); };
window.up = () => ws.readyState === 1;
</script>"""

HAND = """
const [kind, count, every, done] = arguments;
const acts = {
  drag(k) {
    const e = document.querySelector("[data-handle='side/main/bearing/2']");
    const at = {bubbles: true, pointerId: 1, button: 0, clientX: 300, clientY: 300 - (k % 20)};
    e.setPointerCapture = () => {};
    if (k === 0) e.dispatchEvent(new PointerEvent('pointerdown', {...at, clientY: 300}));
    e.dispatchEvent(new PointerEvent('pointermove', at));
    if (k === count - 1) e.dispatchEvent(new PointerEvent('pointercancel', at));
  },
  state(k) {
    const all = [...document.querySelectorAll('.poser .chips button')];
    all[k % all.length].click();
  },
  travel(k) {
    const e = document.querySelectorAll('.poser input[type=range]')[0];
    e.value = -100 + k; e.dispatchEvent(new Event('input', {bubbles: true}));
  },
  torque(k) {
    const e = document.querySelectorAll('.poser input[type=range]')[1];
    e.value = 100 * k; e.dispatchEvent(new Event('input', {bubbles: true}));
  },
  cell(k) {
    const all = [...document.querySelectorAll('.heat button.cell')];
    all[(k * 7) % all.length].click();
  },
};
performance.clearMeasures();
let k = 0;
const timer = setInterval(() => {
  acts[kind](k++);
  if (k < count) return;
  clearInterval(timer);
  const took = (name) => performance.getEntriesByName(name).map(e => e.duration);
  setTimeout(() => done([took('cardan:painted'), took('cardan:moved')]), 600);
}, every);
"""

EMPTY = """
const [count, every, done] = arguments; window.took = []; let k = 0;
const timer = setInterval(() => { move(k++); if (k < count) return; clearInterval(timer);
  setTimeout(() => done(took), 300); }, every);
"""

WAITED = """
const [act, seen, count, done] = arguments; const took = []; let k = 0;
const look = new Function('return ' + seen), hand = new Function('k', act);
const next = () => {
  if (k >= count) return done(took);
  const was = look(), since = performance.now();
  hand(k++);
  const tick = () => requestAnimationFrame(() => {
    if (look() === was) return performance.now() - since < 20000 ? tick() : done(took);
    const c = new MessageChannel();
    c.port1.onmessage = () => { took.push(performance.now() - since); setTimeout(next, 300); };
    c.port2.postMessage(0);
  });
  tick();
};
next();
"""
"""Until something on the page is another, and painted; what never is has no time."""

JOBS = (
    (
        "forces over speed, state by state", "speed", 300, 12, "", ".waterfall canvas",
        "const all = [...document.querySelectorAll('.left .chips')[0].children];"
        "all[(all.findIndex(b => b.ariaPressed === 'true') + 1) % all.length].click()",
        "document.querySelector('[aria-labelledby=forces] .note').innerText",
    ),
    (
        "`fix`: its first answer", "change", 1000, 1, "", ".fix .asking button",
        "document.querySelector('.fix .asking button').click()",
        "document.querySelectorAll('.fix .proposals li').length",
    ),
    (
        # The first is answered by now: another, with one thing held, is under way.
        "`fix`: stopped", "change", 300, 1,
        "document.querySelector('.fix fieldset input').click();"
        "setTimeout(() => document.querySelector('.fix .asking button').click(), 300)",
        ".fix .asking progress",
        "document.querySelector('.fix .asking button').click()",
        "document.querySelector('.fix .asking .fail') ? 1 : 0",
    ),
)  # fmt: skip
"""What takes a process of its own: name, view, target, how often, what comes before, what is there
then, hand, seen."""

LINE = ", the line alone"
"""What is drawn while the limits are still being asked."""

ROWS = (
    ("drag a bearing, move by move", "drag", 120, 35),
    ("drag a bearing, 60 moves a second", "drag", 16, 35),
    ("choose a state", "state", 150, 30),
    ("travel slider", "travel", 150, 30),
    ("torque slider", "torque", 150, 30),
    ("a cell of the heat map", "cell", 150, 50),
)


def missing() -> str:
    """Return what is not there to measure with."""
    if not (
        shutil.which("chromedriver") and (shutil.which("chromium") or shutil.which("google-chrome"))
    ):
        return "Chromium with chromedriver"
    try:
        import selenium  # noqa: F401

        from cardan.web import server

        server.static_files()
    except ModuleNotFoundError as error:
        return f"{error.name}"
    except Exception as error:  # noqa: BLE001  the page is not built
        return str(error)
    return ""


def browser():
    """Return a browser without windows."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    for flag in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1440,1000"):
        options.add_argument(flag)
    options.binary_location = shutil.which("chromium") or shutil.which("google-chrome") or ""
    return webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))


def echo(listening: socket.socket) -> None:
    """Serve the empty page, for as long as the process lasts."""
    import uvicorn
    from starlette.applications import Starlette
    from starlette.responses import HTMLResponse
    from starlette.routing import Route, WebSocketRoute

    async def page(_):
        return HTMLResponse(ECHO)

    async def ask(ws):
        await ws.accept()
        async for said in ws.iter_text():
            await ws.send_text(said)

    app = Starlette(routes=[Route("/", page), WebSocketRoute("/ask", ask)])
    config = uvicorn.Config(app, log_level="critical", lifespan="off", ws="websockets-sansio")
    asyncio.run(uvicorn.Server(config).serve(sockets=[listening]))


def until(driver, script: str) -> None:
    """Wait until a script is true."""
    from selenium.webdriver.support.ui import WebDriverWait

    WebDriverWait(driver, 60, 0.05).until(lambda d: d.execute_script(f"return !!({script})"))


def busy(pid: int | None) -> float:
    """Return how long a process has had a processor, s; nan where the system does not say."""
    try:
        numbers = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return float("nan")
    return (int(numbers[11]) + int(numbers[12])) / os.sysconf("SC_CLK_TCK")


def page_busy(driver) -> float:
    """Return how long a page's process has had a processor, s."""
    found = driver.execute_cdp_cmd("Performance.getMetrics", {})["metrics"]
    return next(m["value"] for m in found if m["name"] == "ProcessTime")


def main() -> None:
    """Print the rows."""
    if lacking := missing():
        print(f"not measured: {lacking} is missing")
        return
    sys.path.insert(0, str(ROOT / "tests"))
    from workbench import running

    from cardan.web import server

    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    quiet = socket.socket()
    quiet.bind(("127.0.0.1", 0))
    quiet.listen()
    threading.Thread(target=echo, args=(quiet,), daemon=True).start()
    took: dict[str, list[float]] = {}
    used: dict[str, list[tuple[float, float]]] = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / TRUCK.name
        path.write_bytes(TRUCK.read_bytes())
        with running(path, Path(folder) / "drafts", built=server.static_files()) as house:
            ours, theirs = browser(), browser()
            ours.set_script_timeout(120)  # a crowded machine
            try:
                ours.execute_cdp_cmd("Performance.enable", {})
                ours.get(house.address)
                until(ours, "document.querySelector('.strip .counts .pass')")
                theirs.get(f"http://127.0.0.1:{quiet.getsockname()[1]}/")
                until(theirs, "up()")
                for _ in range(ROUNDS):
                    ours.execute_script("document.querySelector('[data-view=line]').click()")
                    until(ours, "document.querySelector('[data-handle]')")
                    for name, kind, every, _target in ROWS:
                        empty = theirs.execute_async_script(EMPTY, MOVES, every)
                        took.setdefault(f"{name}/echo", []).extend(empty)
                        lanes = house.workers.quick, house.workers.limits
                        before = sum(busy(lane.pid) for lane in lanes), page_busy(ours)
                        found, moved = ours.execute_async_script(HAND, kind, MOVES, every)
                        after = sum(busy(lane.pid) for lane in lanes), page_busy(ours)
                        took.setdefault(name, []).extend(found)
                        took.setdefault(f"{name}{LINE}", []).extend(moved)
                        per = [1e3 * (b - a) / MOVES for a, b in zip(before, after, strict=True)]
                        used.setdefault(name, []).append((per[0], per[1]))
                        until(ours, "!document.querySelector('.strip.open')")
                    ours.refresh()  # what would help is not known yet
                    until(ours, "document.querySelector('.strip .counts .pass')")
                    until(ours, "!document.querySelector('.strip.open')")
                    for name, view, _target, count, before, there, act, seen in JOBS:
                        ours.execute_script(f"document.querySelector('[data-view={view}]').click()")
                        ours.execute_script(before)
                        until(ours, f"document.querySelector('{there}')")
                        found = ours.execute_async_script(WAITED, act, seen, count)
                        took.setdefault(name, []).extend(found)
                        took.setdefault(f"{name}/echo", []).extend(
                            theirs.execute_async_script(EMPTY, MOVES, 150)
                        )
            finally:
                ours.quit()
                theirs.quit()
    print("| what | target ms | median ms | 90th percentile ms | echo page ms | over echo "
          "| answering: processor ms | page: processor ms |")  # fmt: skip
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    rows = [(name, target) for name, _, _, target in ROWS] + [(r[0], r[2]) for r in JOBS]
    for name, target in rows:
        us, them = sorted(took[name]) or [float("nan")], median(took[f"{name}/echo"])
        theirs_and_ours = " | ".join(
            f"{median(v):.0f}" for v in zip(*used.get(name, []), strict=True)
        ) or " | "  # fmt: skip
        if line := took.get(f"{name}{LINE}"):
            print(f"| {name}{LINE} | {target} | {median(line):.0f} | | | | | |")
        last = us[min(int(0.9 * len(us)), len(us) - 1)]
        print(
            f"| {name} | {target} | {median(us):.0f} | {last:.0f} | {them:.1f} "
            f"| {median(us) / them:.0f} | {theirs_and_ours} |"
        )


if __name__ == "__main__":
    main()
