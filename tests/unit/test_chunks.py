"""Many cases at a time: chunks on a pool give what one call gives, in order."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from cardan.base.arrays import chunked, single_threaded
from cardan.kinematics.chain import turn
from cardan.kinematics.equivalent import approximations, excitation
from cardan.model.layout import direction

RNG = np.random.default_rng(1)
SIDE, TOP = RNG.uniform(-0.1, 0.1, (2, 1000, 4))


def exact(side, top, speed):
    return excitation(turn(direction(side=side, top=top), phases=[0, 0.3]), speed=speed)


def test_chunks_join_to_what_one_call_gives():
    speed = RNG.uniform(100, 300, 1000)
    whole, parts = exact(SIDE, TOP, speed), chunked(exact, SIDE, TOP, speed, size=37)
    assert parts.drive_torque is None
    # Not bit by bit: how NumPy rounds an element depends on its place in the array.
    assert parts.torsional.angle == pytest.approx(whole.torsional.angle, rel=1e-13)
    assert parts.coast.acceleration == pytest.approx(whole.coast.acceleration, rel=1e-12)


def test_dicts_tuples_and_parameters_shared_by_all_cases():
    both = partial(approximations, phases=[0, 0.3, 1.0], speed=200.0)
    parts = chunked(lambda s, t: (both(s, t), s), SIDE, TOP, size=300)
    assert np.array_equal(parts[0]["ae7"].drive.angle, both(SIDE, TOP)["ae7"].drive.angle)
    assert np.array_equal(parts[1], SIDE)


def test_no_chunk_holds_more_than_its_size_and_any_executor_serves():
    seen = []

    def work(side):
        seen.append(len(side))
        return side.sum(-1)

    with ThreadPoolExecutor(1) as executor:
        total = chunked(work, SIDE, size=300, executor=executor)
    assert seen == [300, 300, 300, 100]
    assert np.array_equal(total, SIDE.sum(-1))
    assert chunked(work, SIDE[:0]).shape == (0,)


def test_arrays_must_agree_on_the_cases():
    with pytest.raises(ValueError, match=r"same number of cases, got \[2, 3\]"):
        chunked(np.add, np.ones(2), np.ones(3))


def test_a_blas_that_comes_later_keeps_to_one_thread_too():
    """SciPy brings its own; found once and for all, NumPy's alone was held."""
    code = """
from cardan.base.arrays import single_threaded
from threadpoolctl import threadpool_info, threadpool_limits

with single_threaded():
    import scipy.linalg
with threadpool_limits(2, "blas"), single_threaded():
    print({b["num_threads"] for b in threadpool_info() if b["user_api"] == "blas"})
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "{1}"


def test_blas_keeps_to_one_thread_and_gets_its_own_back():
    """Of NumPy's BLAS, as threadpoolctl sees it; what it had before comes back."""

    def threads():
        return {b["num_threads"] for b in threadpool_info() if b["user_api"] == "blas"}

    with threadpool_limits(limits=2, user_api="blas"):
        before = threads()
        inside = []
        with pytest.raises(ValueError, match="so"), single_threaded():  # noqa: PT012
            inside.append(threads())
            msg = "so"
            raise ValueError(msg)
        assert inside == [{1}]
        assert threads() == before
        assert chunked(lambda x: x * 0 + max(threads()), np.zeros(10), size=5).tolist() == [1] * 10


def test_threads_that_begin_together_look_for_blas_once():
    """While one looks for it and another loads a library both wait for each other, for ever."""
    code = """
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier
from time import sleep

import threadpoolctl

looks = []

class Slow(threadpoolctl.ThreadpoolController):
    def __init__(self):
        looks.append(inside[:])
        sleep(0.1)
        super().__init__()

threadpoolctl.ThreadpoolController = Slow
from cardan.base.arrays import single_threaded

inside, together = [], Barrier(4)

def asked(_):
    together.wait()
    with single_threaded():
        inside.append(1)

with ThreadPoolExecutor(4) as pool:
    list(pool.map(asked, range(4)))
print(looks)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[[]]"


def test_the_last_of_several_threads_gives_blas_its_own_back():
    """The first to leave gave it back to all, and the last left it with one thread for ever."""

    def threads():
        return {b["num_threads"] for b in threadpool_info() if b["user_api"] == "blas"}

    one, other = single_threaded(), single_threaded()
    with threadpool_limits(limits=2, user_api="blas"):
        before = threads()
        one.__enter__()
        other.__enter__()
        one.__exit__(None, None, None)
        assert threads() == {1}
        other.__exit__(None, None, None)
        assert threads() == before
