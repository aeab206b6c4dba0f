"""Many cases at a time: chunks on a pool give what one call gives, in order."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from cardan.core.arrays import in_chunks, single_threaded_blas
from cardan.model.layout import direction_from_slopes
from cardan.physics.kinematics.equivalent_angle import (
    excitation_approximations,
    excitation_of_rotating_chain,
)
from cardan.physics.kinematics.joint_chain import rotate_chain

RNG = np.random.default_rng(1)
SIDE, TOP = RNG.uniform(-0.1, 0.1, (2, 1000, 4))


def exact(side, top, speed):
    return excitation_of_rotating_chain(
        rotate_chain(direction_from_slopes(side=side, top=top), phases=[0, 0.3]), speed=speed
    )


def test_chunked_result_equals_single_call():
    speed = RNG.uniform(100, 300, 1000)
    whole, parts = exact(SIDE, TOP, speed), in_chunks(exact, SIDE, TOP, speed, size=37)
    assert parts.drive_torque is None
    # Not bit by bit: how NumPy rounds an element depends on its place in the array.
    assert parts.torsional.angle == pytest.approx(whole.torsional.angle, rel=1e-13)
    assert parts.coast.acceleration == pytest.approx(whole.coast.acceleration, rel=1e-12)


def test_chunked_joins_dicts_tuples_and_shared_parameters():
    both = partial(excitation_approximations, phases=[0, 0.3, 1.0], speed=200.0)
    parts = in_chunks(lambda s, t: (both(s, t), s), SIDE, TOP, size=300)
    assert np.array_equal(parts[0]["ae7"].drive.angle, both(SIDE, TOP)["ae7"].drive.angle)
    assert np.array_equal(parts[1], SIDE)


def test_chunk_size_is_limited_and_any_executor_is_accepted():
    seen = []

    def work(side):
        seen.append(len(side))
        return side.sum(-1)

    with ThreadPoolExecutor(1) as executor:
        total = in_chunks(work, SIDE, size=300, executor=executor)
    assert seen == [300, 300, 300, 100]
    assert np.array_equal(total, SIDE.sum(-1))
    assert in_chunks(work, SIDE[:0]).shape == (0,)


def test_arrays_with_different_case_counts_are_rejected():
    with pytest.raises(ValueError, match=r"same number of cases, got \[2, 3\]"):
        in_chunks(np.add, np.ones(2), np.ones(3))


@pytest.mark.slow
def test_blas_loaded_later_is_limited_to_one_thread():
    """SciPy brings its own; found once and for all, NumPy's alone was held."""
    code = """
from cardan.core.arrays import single_threaded_blas
from threadpoolctl import threadpool_info, threadpool_limits

with single_threaded_blas():
    import scipy.linalg
with threadpool_limits(2, "blas"), single_threaded_blas():
    print({b["num_threads"] for b in threadpool_info() if b["user_api"] == "blas"})
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "{1}"


def test_blas_thread_limit_is_restored_after_use():
    """Of NumPy's BLAS, as threadpoolctl sees it; what it had before comes back."""

    def threads():
        return {b["num_threads"] for b in threadpool_info() if b["user_api"] == "blas"}

    with threadpool_limits(limits=2, user_api="blas"):
        before = threads()
        inside = []
        with pytest.raises(ValueError, match="so"), single_threaded_blas():  # noqa: PT012
            inside.append(threads())
            msg = "so"
            raise ValueError(msg)
        assert inside == [{1}]
        assert threads() == before
        assert (
            in_chunks(lambda x: x * 0 + max(threads()), np.zeros(10), size=5).tolist() == [1] * 10
        )


def test_concurrent_threads_search_for_blas_once():
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
from cardan.core.arrays import single_threaded_blas

inside, together = [], Barrier(4)

def asked(_):
    together.wait()
    with single_threaded_blas():
        inside.append(1)

with ThreadPoolExecutor(4) as pool:
    list(pool.map(asked, range(4)))
print(looks)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[[]]"


def test_last_thread_restores_blas_thread_limit():
    """The first to leave gave it back to all, and the last left it with one thread for ever."""

    def threads():
        return {b["num_threads"] for b in threadpool_info() if b["user_api"] == "blas"}

    one, other = single_threaded_blas(), single_threaded_blas()
    with threadpool_limits(limits=2, user_api="blas"):
        before = threads()
        one.__enter__()
        other.__enter__()
        one.__exit__(None, None, None)
        assert threads() == {1}
        other.__exit__(None, None, None)
        assert threads() == before
