"""What every test stands on."""

import os
import re
import signal
from pathlib import Path

import pytest

# Matrices here are small: BLAS's own threads cost more than they bring, and many times that
# where several processes test at once. Before NumPy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A shell that starts us in the background has interrupts ignored, by whatever we start too.
signal.signal(signal.SIGINT, signal.default_int_handler)

MAKEFILE = Path(__file__).parents[1] / "Makefile"
KINDS = ("oracle", "bracket", "office", "browser", "slow")


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
