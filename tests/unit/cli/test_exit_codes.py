"""How a run ends: its exit code and what it says, each in a process of its own."""

import os
import signal
import subprocess
import sys

import pytest
from repository import EXAMPLES

EXAMPLE = EXAMPLES / "van.yaml"
FAULTY = """\
import sys
from cardan.approval import approval
def faulty(*_, **__):
    raise {error}
approval.approve_application = faulty
from cardan.cli import cli
cli(sys.argv[1:])
"""


def run(*arguments: object, code: str | None = None, **how) -> subprocess.CompletedProcess:
    start = ["-m", "cardan"] if code is None else ["-c", code]
    command = [sys.executable, *start, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, encoding="utf-8", check=False, **how)


@pytest.mark.slow
def test_module_runs_as_program():
    result = run("check", "-q", EXAMPLE)
    assert result.stdout.startswith("Van 4x2")
    assert (result.stderr, result.returncode) == ("", 0)
    assert run("--help").stdout.startswith("Usage: cardan [OPTIONS]")


@pytest.mark.slow
@pytest.mark.parametrize(
    "wrong",
    [("check",), ("chek",), ("check", "--lang", "la", "x"), ("--colour",), ("fix", "a", "b")],
)
def test_invalid_command_line_exits_with_code_2(wrong):
    result = run(*wrong)
    assert result.returncode == 2
    assert "Traceback" not in result.stderr
    assert result.stdout == ""


@pytest.mark.slow
def test_internal_error_exits_with_code_3_and_report_instructions():
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


@pytest.mark.slow
def test_debug_option_prints_traceback_of_internal_error():
    code = FAULTY.format(error="ZeroDivisionError('float division by zero')")
    result = run("--debug", "check", EXAMPLE, code=code)
    assert result.returncode == 3
    assert "Traceback" in result.stderr
    assert "in faulty" in result.stderr


@pytest.mark.slow
def test_keyboard_interrupt_exits_with_code_130_silently():
    result = run("check", EXAMPLE, code=FAULTY.format(error="KeyboardInterrupt"))
    assert (result.returncode, result.stdout, result.stderr) == (130, "", "\n")


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals of Unix")
def test_interrupt_signal_exits_like_keyboard_interrupt():
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


@pytest.mark.slow
@pytest.mark.parametrize(
    "command", [("explain",), ("check", EXAMPLE), ("schema",), ("--help",), ("check", "--help")]
)
def test_closed_output_pipe_is_not_an_error(command):
    """As in `cardan explain | head -1`: nobody reads on when it starts to write."""
    reading, writing = os.pipe()
    os.close(reading)
    arguments = [sys.executable, "-m", "cardan", *map(str, command)]
    try:
        result = subprocess.run(arguments, stdout=writing, stderr=subprocess.PIPE, check=False)
    finally:
        os.close(writing)
    assert (result.returncode, result.stderr) == (141, b"")


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="descriptors of Unix")
@pytest.mark.parametrize("arguments", [("check", "-q", EXAMPLE), ("check", "no.yaml")])
@pytest.mark.parametrize("lost", ["stderr closed", "stderr unread", "all closed"])
def test_exit_code_and_output_do_not_depend_on_who_reads_messages(arguments, lost):
    expected = run(*arguments)
    command = [sys.executable, "-m", "cardan", *map(str, arguments)]
    closing = {"stderr closed": "exec 2>&-", "stderr unread": "", "all closed": "exec <&- >&- 2>&-"}
    reading, writing = os.pipe()
    os.close(reading)
    try:
        result = subprocess.run(
            ["/bin/sh", "-c", f'{closing[lost]}; exec "$@"'.removeprefix("; "), "sh", *command],
            stdout=subprocess.PIPE, stderr=writing, encoding="utf-8", check=False,
        )  # fmt: skip
    finally:
        os.close(writing)
    assert result.returncode == expected.returncode
    assert result.stdout == ("" if lost == "all closed" else expected.stdout)


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals of Unix")
@pytest.mark.parametrize("module", ["click", "numpy.exceptions"])
def test_interrupt_while_modules_are_imported_prints_no_traceback(module):
    command = [sys.executable, "-X", "importtime", "-m", "cardan", "check", str(EXAMPLE)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stderr is not None
        imported = any(line.rstrip().endswith(b" " + module.encode()) for line in process.stderr)
        assert imported
        process.send_signal(signal.SIGINT)
        output, messages = process.communicate(timeout=20)
    rest = [m for m in messages.splitlines() if m and not m.startswith(b"import time:")]
    assert (process.returncode, output, rest) == (130, b"", [])
