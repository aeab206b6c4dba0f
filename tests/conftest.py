"""What every test stands on."""

import hashlib
import os
import pickle
import re
import shutil
import signal
import tempfile
from pathlib import Path

import pytest

# Matrices here are small: BLAS's own threads cost more than they bring, and many times that
# where several processes test at once. Before NumPy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

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
    for item in items:
        its = {kind: item.get_closest_marker(kind) is not None for kind in KINDS}
        runs = [stage for stage in stages if eval(stage, {}, its)]
        if len(runs) != 1:
            msg = f"{item.nodeid} is run by {runs or 'no stage'} of the Makefile"
            raise pytest.UsageError(msg)


def pytest_configure(config):
    if SOLVED not in os.environ:  # else one of a run's processes
        os.environ[SOLVED] = tempfile.mkdtemp(prefix="cardan-solved-")
        config.add_cleanup(lambda: shutil.rmtree(os.environ.pop(SOLVED), ignore_errors=True))


@pytest.fixture(scope="session", autouse=True)
def solved_once(request):
    """A bracket is solved once a run: the same question has the same answer, and is told so."""
    if not any(item.get_closest_marker("bracket") for item in request.session.items):
        yield
        return
    from cardan.study import bracket_judge

    solve = bracket_judge.solved_apart

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
        patch.setattr(bracket_judge, "solved_apart", remembered)
        yield
