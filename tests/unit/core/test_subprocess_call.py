"""A child process returns a result or an error, and is stopped beyond its limits."""

import errno
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
from repository import ROOT

from cardan.core import subprocess_call
from cardan.core.errors import DesignError
from cardan.core.subprocess_call import (
    ChildProcessCrashedError,
    ChildProcessKilledError,
    call_in_subprocess,
    cpu_seconds,
)

LIMITS = {"memory": 4e9, "seconds": 60.0}


# The child imports these by name: they stand at the top level of this module.


def add(a, b, tell):
    tell("adding")
    return np.asarray(a) + b


def refuse(what, _tell):
    raise DesignError(what, about="bracket.step")


def die(how, tell):
    tell("now")
    os.kill(os.getpid(), how)


def sleep(seconds, _tell):
    time.sleep(seconds)


def work(seconds, _tell):
    while time.process_time() < seconds:
        pass


def grow(count, _tell):
    held = np.ones(count)
    time.sleep(20)
    return float(held.sum())


def test_result_and_progress_come_back():
    told = []
    found = call_in_subprocess(add, np.arange(3), 2, tell=told.append, **LIMITS)
    assert found.tolist() == [2, 3, 4]
    assert told == ["adding"]


@pytest.mark.slow
def test_limits_and_progress_can_be_left_out():
    assert call_in_subprocess(add, 1.0, 2.0) == 3.0
    with pytest.raises(ChildProcessKilledError, match="longer than"):
        call_in_subprocess(work, 60.0, seconds=0.3)


def test_error_of_the_child_is_raised_in_the_parent():
    with pytest.raises(DesignError, match="too thin") as refused:
        call_in_subprocess(refuse, "too thin", tell=print, **LIMITS)
    assert refused.value.about == "bracket.step"


def test_crash_is_reported_with_its_signal():
    told = []
    with pytest.raises(ChildProcessCrashedError, match="SIGSEGV"):
        call_in_subprocess(die, signal.SIGSEGV, tell=told.append, **LIMITS)
    assert told == ["now"]


@pytest.mark.slow
def test_child_beyond_its_time_or_memory_is_stopped():
    start = time.monotonic()
    with pytest.raises(ChildProcessKilledError, match=r"longer than 0\.0\d+ minutes"):
        call_in_subprocess(sleep, 60, tell=print, memory=4e9, seconds=1.0)
    assert time.monotonic() - start < 30
    if not Path("/proc/self/statm").exists():
        pytest.skip("this system does not tell what a process holds")
    with pytest.raises(ChildProcessKilledError, match=r"held 0\.\d+ GB of the 0\.3 GB allowed"):
        call_in_subprocess(grow, 100_000_000, tell=print, memory=3e8, seconds=60.0)


def big(count, _tell):
    return np.zeros(count)


def full(_tell):
    raise OSError(errno.ENOSPC, "No space left on device")


@pytest.mark.slow
def test_full_temporary_folder_is_named_as_the_cause(tmp_path, monkeypatch):
    """A file may have no more than 64 kB: an answer of 80 MB does not fit, nor what asks for it."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    told = rf"temporary files, {tmp_path}, cannot be written .*TMPDIR"
    with pytest.raises(DesignError, match=told):
        call_in_subprocess(full, tell=print, **LIMITS)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (65536, hard))
    try:
        for function, asked in ((big, 10_000_000), (add, np.zeros(20_000))):
            with pytest.raises(DesignError, match=told):
                call_in_subprocess(
                    function, asked, *([1.0] if function is add else []), tell=print, **LIMITS
                )
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, before)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "nowhere"))
    with pytest.raises(DesignError, match=r"temporary files, .*nowhere, cannot be written"):
        call_in_subprocess(add, 1.0, 1.0, tell=print, **LIMITS)


def begin(seconds, tell):
    tell("begun")
    time.sleep(seconds)
    return tell("done")  # to nobody


@pytest.mark.skipif(sys.platform == "win32", reason="nobody is killed like that there")
def test_killed_parent_leaves_no_folder_behind(tmp_path):
    """What it had asked for ends by itself, and takes the folder with it."""
    here = [str(Path(__file__).parent), str(ROOT / "tests")]
    asks = (
        f"import sys; sys.path[:0] = {here}\n"
        "from test_subprocess_call import LIMITS, begin\n"
        "from cardan.core.subprocess_call import call_in_subprocess\n"
        "call_in_subprocess(begin, 1.0, tell=lambda said: print(said, flush=True), **LIMITS)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", asks], stdout=subprocess.PIPE, text=True,
        env={**os.environ, "TMPDIR": str(tmp_path)},
    ) as asking:  # fmt: skip
        assert asking.stdout.readline() == "begun\n"
        assert [*tmp_path.glob("cardan-*/question")]
        asking.kill()
    end = time.monotonic() + 30
    while [*tmp_path.iterdir()] and time.monotonic() < end:
        time.sleep(0.1)
    assert not [*tmp_path.iterdir()]


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="does not tell what it worked")
@pytest.mark.slow
def test_child_waiting_for_a_busy_processor_is_not_stopped():
    """It sleeps for twice its seconds. A bracket was stopped, with 183 of its 900 s worked."""
    assert call_in_subprocess(sleep, 4.0, tell=print, memory=4e9, seconds=2.0) is None
    with pytest.raises(ChildProcessKilledError, match="longer than"):
        call_in_subprocess(work, 60.0, tell=print, memory=4e9, seconds=2.0)
    assert cpu_seconds(os.getpid()) == pytest.approx(time.process_time(), abs=0.1)


def test_one_thread_is_used_on_a_busy_machine(monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 8)
    monkeypatch.setattr(os, "getloadavg", lambda: (0.1, 0, 0))
    assert subprocess_call._threads() == "4"
    monkeypatch.setattr(os, "getloadavg", lambda: (9.0, 0, 0))
    assert subprocess_call._threads() == "1"
