"""How a run ends: its exit code and what it says, each in a process of its own."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[2] / "examples" / "van.yaml"
FAULTY = """\
import sys
from cardan.study import assess
def faulty(*_):
    raise {error}
assess.assess = faulty
from cardan.cli import cli
cli(sys.argv[1:])
"""


def run(*arguments: object, code: str | None = None, **how) -> subprocess.CompletedProcess:
    start = ["-m", "cardan"] if code is None else ["-c", code]
    command = [sys.executable, *start, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, encoding="utf-8", check=False, **how)


def test_the_module_is_the_program():
    result = run("check", "-q", EXAMPLE)
    assert result.stdout.startswith("Van 4x2")
    assert (result.stderr, result.returncode) == ("", 0)
    assert run("--help").stdout.startswith("Usage: cardan [OPTIONS]")


@pytest.mark.parametrize(
    "wrong",
    [("check",), ("chek",), ("check", "--lang", "la", "x"), ("--colour",), ("fix", "a", "b")],
)
def test_a_wrong_command_line_is_bad_input(wrong):
    result = run(*wrong)
    assert result.returncode == 2
    assert "Traceback" not in result.stderr
    assert result.stdout == ""


def test_a_fault_of_the_program_says_where_to_report_it():
    code = FAULTY.format(error="ZeroDivisionError('float division by zero')")
    result = run("check", EXAMPLE, code=code)
    assert result.returncode == 3
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    for said in (
        "error: cardan itself is at fault: ZeroDivisionError: float division by zero",
        "CONTRIBUTING.md says how to report it",
        f"command: cardan check {EXAMPLE}",
        "cardan 0.",
    ):
        assert said in result.stderr


def test_debug_shows_where_a_fault_happened():
    code = FAULTY.format(error="ZeroDivisionError('float division by zero')")
    result = run("--debug", "check", EXAMPLE, code=code)
    assert result.returncode == 3
    assert "Traceback" in result.stderr
    assert "in faulty" in result.stderr


def test_from_the_keyboard_it_stops_without_a_word():
    result = run("check", EXAMPLE, code=FAULTY.format(error="KeyboardInterrupt"))
    assert (result.returncode, result.stdout, result.stderr) == (130, "", "\n")


@pytest.mark.skipif(os.name == "nt", reason="signals of Unix")
def test_an_interrupt_from_outside_is_one_from_the_keyboard():
    """A FIFO nobody writes to holds the program while it is stopped."""
    code = FAULTY.format(error="AssertionError").replace(
        "    raise AssertionError",
        "    print('here', flush=True)\n    import time\n    time.sleep(60)",
    )
    command = [sys.executable, "-c", code, "check", str(EXAMPLE)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"here\n"
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=20)
    assert (process.returncode, said) == (130, b"\n")


@pytest.mark.parametrize(
    "command", [("explain",), ("check", EXAMPLE), ("schema",), ("--help",), ("check", "--help")]
)
def test_a_reader_that_leaves_early_is_no_error(command):
    """As in `cardan explain | head -1`: nobody reads on when it starts to write."""
    reading, writing = os.pipe()
    os.close(reading)
    arguments = [sys.executable, "-m", "cardan", *map(str, command)]
    try:
        result = subprocess.run(arguments, stdout=writing, stderr=subprocess.PIPE, check=False)
    finally:
        os.close(writing)
    assert (result.returncode, result.stderr) == (141, b"")
