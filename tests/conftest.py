"""What every test stands on."""

import copy
import hashlib
import os
import pickle
import re
import shutil
import signal
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# The time of an example depends on the load of the machine, so no test is held to it.
settings.register_profile(
    "any machine", deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("any machine")

# Matrices here are small: BLAS's own threads cost more than they bring, and many times that
# where several processes test at once. Before NumPy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Commands answer in the locale's language; tests read English.
for _named in ("LC_ALL", "LC_MESSAGES", "LANG"):
    if os.environ.get(_named, "")[:2] in ("pt", "it"):
        os.environ[_named] = "C.UTF-8"

# A shell that starts us in the background has interrupts ignored, by whatever we start too.
signal.signal(signal.SIGINT, signal.default_int_handler)

MAKEFILE = Path(__file__).parents[1] / "Makefile"
SOLVED = "CARDAN_TESTS_SOLVED"
"""Names the folder of what this run has solved, to its processes."""
KINDS = ("oracle", "bracket", "office", "browser", "slow", "long")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Refuse a test that no stage of `make` runs, or two do: one of them lacks what it needs."""
    stages = re.findall(r'(?i)pytest\b.* -m "([^"]+)"', MAKEFILE.read_text("utf-8"))
    stages.append(" and ".join(f"not {k}" for k in KINDS))
    compiled = [(stage, compile(stage, "Makefile", "eval")) for stage in stages]
    for item in items:
        its = {kind: item.get_closest_marker(kind) is not None for kind in KINDS}
        runs = [stage for stage, expression in compiled if eval(expression, {}, its)]
        if len(runs) != 1:
            msg = f"{item.nodeid} is run by {runs or 'no stage'} of the Makefile"
            raise pytest.UsageError(msg)


def pytest_configure(config):
    if SOLVED not in os.environ:  # else one of a run's processes
        os.environ[SOLVED] = tempfile.mkdtemp(prefix="cardan-solved-")
        config.add_cleanup(lambda: shutil.rmtree(os.environ.pop(SOLVED), ignore_errors=True))


@pytest.fixture(autouse=True)
def same_numbers(request, monkeypatch):
    """A module's RNG begins anew at each test, whichever tests run before it."""
    if hasattr(request.module, "RNG"):
        monkeypatch.setattr(request.module, "RNG", copy.deepcopy(request.module.RNG))


@pytest.fixture(scope="session", autouse=True)
def solved_once(request):
    """A bracket is solved once a run: the same question has the same answer, and is told so."""
    if not any(item.get_closest_marker("bracket") for item in request.session.items):
        yield
        return
    from cardan.topics.bracket import shape_assessment as bracket_judge

    solve = bracket_judge.solve_in_subprocess

    def remembered(task, *, tell):
        asked = pickle.dumps(task)
        file = Path(os.environ[SOLVED], hashlib.sha256(asked).hexdigest())
        said = []
        if file.exists():
            found, said = pickle.loads(file.read_bytes())
            for what in said:
                tell(what)
            return found
        found = solve(task, tell=lambda what: (said.append(what), tell(what)))
        part = file.with_suffix(f".{os.getpid()}")
        part.write_bytes(pickle.dumps((found, said)))
        part.rename(file)
        return found

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bracket_judge, "solve_in_subprocess", remembered)
        yield
