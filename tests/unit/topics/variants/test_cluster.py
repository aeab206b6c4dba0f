"""A study on a Dask cluster of two, by its address: what is killed there changes no bit."""

import heapq
import logging
import os
import signal
import socket
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from threading import Event
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from cardan.application import reader
from cardan.cli import cli
from cardan.core.arrays import MALLOC_TRIM_VARIABLE, retain_freed_memory
from cardan.topics.variants import executors, runner
from cardan.topics.variants.executors import DaskExecutor
from cardan.topics.variants.presentation import progress_text
from cardan.topics.variants.shard_job import ComputedShards
from cardan.topics.variants.shard_log import log_entries
from cardan.topics.variants.shard_store import SHARD_LOG_FILE_NAME
from cardan.topics.variants.shard_tree import shards_of

pytest.importorskip("distributed", reason="a cluster needs pip install 'cardan[cluster]'")

LINE = """
title: Two-piece driveline
speed_rpm: 2500
torque_Nm: 3000
driveline:
  slopes:
    side_deg: [3.0, 1.0, 4.5, 2.0]
  joints: "1710"
  shafts:
    - length_mm: 1200
      tube: {outer_mm: 101.6, wall_mm: 3.2}
      centre_bearing: {from_rear_joint_mm: 140}
    - {length_mm: 1500, tube: {outer_mm: 101.6, wall_mm: 3.2}, phase_deg: 0}
limits:
  - {quantity: torsional_acceleration, normal: 350, maximum: 500, source: ours}
  - {quantity: joint_angle, maximum: 3.7, source: ours}
study:
  tolerances: {"driveline.slopes.side_deg[*]": {normal: 0.2}}
  ask: {rows: float64, quantiles: [0.5]}
"""
COUNT = "20480"
SHARDS = 40
WAIT = 120  # s: a machine may be busy


def until(done, what):
    """Wait for what must come."""
    deadline = time.monotonic() + WAIT
    while not done():
        assert time.monotonic() < deadline, f"waited in vain for {what}"
        time.sleep(0.002)


@contextmanager
def running(*command, env=None):
    """Give a process, which does not outlive the test."""
    run = subprocess.Popen(command, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield run
    finally:
        run.kill()
        run.wait()


@pytest.fixture
def schedulers():
    """Give those of the clusters of a test."""
    return []


@pytest.fixture
def cluster(tmp_path, schedulers):
    """Give the address of a scheduler with two workers, and those."""
    env = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        MALLOC_TRIM_VARIABLE: "65536",
    }
    where = tmp_path / "scheduler.json"
    dask = (sys.executable, "-m", "dask")
    local = ("--scheduler-file", str(where), "--no-dashboard")
    with ExitStack() as stack:
        schedulers.append(stack.enter_context(running(
            *dask, "scheduler", *local, "--host", "127.0.0.1", "--port", "0", env=env,
        )))  # fmt: skip
        until(where.exists, "a scheduler")
        workers = [
            stack.enter_context(running(
                *dask, "worker", *local, "--no-nanny", "--nthreads", "1",
                "--local-directory", str(tmp_path), env=env,
            ))
            for _ in range(2)
        ]  # fmt: skip
        from distributed import Client

        with Client(scheduler_file=str(where)) as client:
            client.wait_for_workers(2, timeout=WAIT)
            address = client.scheduler.address
        yield address, workers


def kept(folder):
    """Return the shards there."""
    return {e.about["shard"] for e in log_entries(folder / SHARD_LOG_FILE_NAME) if e}


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="has no such signal")
@pytest.mark.filterwarnings("default")  # the cluster's own
def test_killed_cluster_study_resumes_with_identical_result(tmp_path, cluster):
    address, workers = cluster
    (tmp_path / "line.yaml").write_text(LINE)
    command = [sys.executable, "-m", "cardan", "study", str(tmp_path / "line.yaml"), "--n", COUNT]
    whole, out = tmp_path / "whole", tmp_path / "out"
    subprocess.run([*command, "--out", str(whole), "--workers", "1"], check=True)
    there = [*command, "--out", str(out), "--executor", address]
    # The one who hands out the work.
    with running(*there) as study:
        until(lambda: len(kept(out)) >= 3, "the first shards")
        os.kill(study.pid, signal.SIGKILL)
        study.wait()
    before = kept(out)
    assert 3 <= len(before) < SHARDS
    # Then one of those who do it.
    with running(*there, "--resume") as study:
        until(lambda: len(kept(out)) >= len(before) + 3, "more shards")
        os.kill(workers[0].pid, signal.SIGKILL)
        done = kept(out)
        assert len(done) < SHARDS
        assert study.wait(WAIT) == 0
    # What was done is done: the loss of a worker costs the shards it had.
    assert before <= done
    assert kept(out) == set(range(SHARDS))
    assert sorted(p.name for p in out.iterdir()) == sorted(p.name for p in whole.iterdir())
    for path in whole.iterdir():
        assert path.read_bytes() == (out / path.name).read_bytes(), path.name


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="has no such signal")
def test_lost_scheduler_is_reported_and_results_are_kept(tmp_path, cluster, schedulers):
    address, _ = cluster
    (tmp_path / "line.yaml").write_text(LINE)
    command = [sys.executable, "-m", "cardan", "study", str(tmp_path / "line.yaml"), "--n", COUNT]
    out, whole = tmp_path / "out", tmp_path / "whole"
    env = {**os.environ, "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "2s"}
    with subprocess.Popen(
        [*command, "--out", str(out), "--executor", address],
        env=env, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    ) as study:  # fmt: skip
        until(lambda: len(kept(out)) >= 3, "the first shards")
        schedulers[0].kill()
        _, said = study.communicate(timeout=WAIT)
    assert study.returncode == 2, said
    assert f"the cluster at {address} is gone" in said
    words = {line.partition(" ")[0] for line in said.splitlines()}
    assert words <= {"warning:", "waiting", "calculating:", "error:"}
    assert 3 <= len(kept(out)) < SHARDS
    subprocess.run([*command, "--out", str(out), "--resume"], check=True)
    subprocess.run([*command, "--out", str(whole)], check=True)
    for path in whole.iterdir():
        assert path.read_bytes() == (out / path.name).read_bytes(), path.name


@pytest.mark.slow
@pytest.mark.parametrize(
    ("address", "why"),
    [
        ("tls://127.0.0.1:8786", "needs certificates: name them in Dask's configuration"),
        ("tcp://127.0.0.1", "give its protocol, host and port, as tcp://host:8786"),
        ("tcp://127.0.0.1:0", "give its protocol, host and port, as tcp://host:8786"),
        ("tcp://127.0.0.1:99999", "give its protocol, host and port, as tcp://host:8786"),
        ("tcp://:8786", "give its protocol, host and port, as tcp://host:8786"),
        ("ftp://127.0.0.1:21", "is no address of a Dask scheduler"),
        ("tcp://127.0.0.1:{port}", "no Dask scheduler answers at tcp://127.0.0.1:"),
    ],
)
def test_address_of_no_scheduler_is_rejected_with_reason(tmp_path, monkeypatch, address, why):
    """One raised, one blamed the study's file, one waited without an end and without a word."""
    monkeypatch.setattr(executors, "SCHEDULER_TIMEOUT_S", 1)
    monkeypatch.setattr(logging.root.manager, "disable", logging.NOTSET)  # as it was, afterwards
    (tmp_path / "line.yaml").write_text(LINE)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = address.format(port=silent.getsockname()[1])
        run = CliRunner().invoke(
            cli, ["study", str(tmp_path / "line.yaml"), "--n", "20", "--executor", address]
        )
    assert run.exit_code == 2, run.output
    _, waits, error = run.output.splitlines()
    assert waits == f"waiting at most 1 s for the Dask scheduler at {address}"
    assert error.startswith("error: ")
    assert why in error
    assert "line.yaml" not in error


def same(one, other):
    """Hold two studies against each other, to the last bit."""
    for name, state in one.statistics.items():
        for key, value in state.items():
            np.testing.assert_array_equal(value, other.statistics[name][key], err_msg=name)


class Waiting:
    """Stands for a client whose cluster gets a worker when it is told that it has none."""

    status = "running"

    def __init__(self):
        self.begin, self.most, self.pending, self.plugins = Event(), 0, 0, {}
        self.threads = ThreadPoolExecutor(16)

    def ncores(self):
        return {"one": 4} if self.begin.is_set() else {}

    def get_executor(self):
        return None

    def register_plugin(self, plugin, *, name):
        self.plugins[name] = plugin
        plugin.setup(None)

    def unregister_worker_plugin(self, name):
        self.plugins.pop(name).teardown(None)

    def map(self, fn, calls, *, pure):
        assert not pure
        self.pending += len(calls)
        self.most = max(self.most, self.pending)

        def asked(call):
            self.begin.wait()
            return fn(call)

        found = [self.threads.submit(asked, call) for call in calls]
        for future in found:
            future.key, future.status = str(id(future)), "finished"
        return found

    def gather(self, futures):
        self.pending -= len(futures)
        return [future.result() for future in futures]


def test_cluster_without_workers_is_reported_and_awaited(monkeypatch):
    monkeypatch.setattr(runner, "WORKER_TIMEOUT_S", 0.05)
    client, told = Waiting(), []

    def hear(progress):
        told.append(progress)
        if progress.idle:
            client.begin.set()

    application = reader.loads(LINE.replace("rows: float64, ", ""))
    found = runner.run_study(
        application,
        application.variants,
        count=600,
        shard=20,
        executor=DaskExecutor(client),
        workers=None,
        hear=hear,
    )
    assert found.count == 600
    assert not client.plugins
    alone = runner.run_study(application, application.variants, count=600, shard=20)
    same(found, alone)
    assert any(p.idle and p.done == 0 for p in told)
    assert "no worker" in progress_text(next(p for p in told if p.idle))
    # Nobody there gets as much as one would; four, what keeps four at it.
    assert 4 < client.most <= 4 * runner.QUEUE_DEPTH_PER_CLUSTER_WORKER


class SimulatedCluster(DaskExecutor):
    """Workers by a clock of its own: each shard takes as long, and nothing is computed."""

    def __init__(self, workers, seconds):
        self.free, self.seconds, self.clock = [0.0] * workers, seconds, 0.0
        self.tasks, self.messages, self.out = [], 0, []

    worker_threads = property(lambda self: len(self.free))
    pending_count = property(lambda self: len(self.out))

    @contextmanager
    def held_by_workers(self, job):
        del job
        yield "job"

    def submit_all(self, calls):
        self.messages += 1
        for node in calls:
            took = self.seconds * len(shards_of(node))
            self.tasks.append(took)
            begun = max(heapq.heappop(self.free), self.clock)
            heapq.heappush(self.free, begun + took)
            heapq.heappush(self.out, (begun + took, node))

    def finished(self, timeout):
        del timeout
        self.clock, node = heapq.heappop(self.out)
        took = self.seconds * len(shards_of(node))
        return [(node, ComputedShards(results=(None,), seconds=took))]

    def cancel_all(self):
        assert not self.out


@pytest.mark.parametrize(
    ("seconds", "shards", "busy", "long"), [(0.1, 195_000, 0.8, 0.0), (7.0, 60_000, 0.98, 0.8)]
)
def test_thousand_workers_are_kept_busy_by_few_long_tasks(seconds, shards, busy, long):
    cluster, done = SimulatedCluster(1000, seconds), set()
    runner._run_shards(
        SimpleNamespace(), {k: (k, k + 1) for k in range(shards)},
        lambda node, _: done.update(shards_of(node)), executor=cluster, workers=None, merged=True,
        idle=lambda: None,
    )  # fmt: skip
    assert done == set(range(shards))
    assert shards * seconds / 1000 / cluster.clock > busy
    assert max(cluster.tasks) <= runner.MAX_TASK_S
    assert sum(t for t in cluster.tasks if t > 10) >= long * shards * seconds
    # Client and scheduler are not what all wait for, and calls go out hundreds at a time.
    assert len(cluster.tasks) * runner.TASK_OVERHEAD_S < cluster.clock
    assert cluster.messages < len(cluster.tasks) / 200


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="of the GNU C library")
@pytest.mark.parametrize("numbers", [10_000, 100_000])
def test_worker_keeps_freed_memory_during_computation(numbers):
    """Dask's workers are told so, and each array then faults anew: twice the time.

    Arrays above 128 KiB, which are mapped one by one, did so while it computed as well.
    """
    code = (
        "import resource, numpy as np\n"
        "from contextlib import nullcontext\n"
        "from cardan.core.arrays import retain_freed_memory\n"
        "def faults(context):\n"
        "    with context:\n"
        f"        a = np.ones({numbers})\n"
        "        before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt\n"
        "        for _ in range(300): [a + k for k in range(8)]\n"
        "        return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before\n"
        "print(faults(nullcontext()), faults(retain_freed_memory()))\n"
    )
    env = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        MALLOC_TRIM_VARIABLE: "65536",
    }
    told = subprocess.run(
        [sys.executable, "-c", code], env=env, check=True, capture_output=True, text=True
    ).stdout
    at_once, held = map(int, told.split())
    if at_once < 10_000:
        pytest.skip("another C library, which was not told so")
    assert held < at_once / 10


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="of the GNU C library")
def test_last_thread_restores_memory_trimming(monkeypatch):
    told = []
    monkeypatch.setenv(MALLOC_TRIM_VARIABLE, "65536")
    monkeypatch.setattr("ctypes.CDLL", lambda _: SimpleNamespace(mallopt=lambda *a: told.append(a)))
    one, other = retain_freed_memory(), retain_freed_memory()
    one.__enter__()
    other.__enter__()
    one.__exit__(None, None, None)
    assert (-1, 65536) not in told
    other.__exit__(None, None, None)
    assert told[-2:] == [(-1, 65536), (-3, 2**17)]


def test_memory_trimming_is_unchanged_if_not_configured(monkeypatch):
    monkeypatch.delenv(MALLOC_TRIM_VARIABLE, raising=False)
    with retain_freed_memory():
        pass
