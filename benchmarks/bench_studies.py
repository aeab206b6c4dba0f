"""A study of the refuse collector's settings: variants a second of a core, and of several.

    python benchmarks/bench_studies.py

Every limit in seven states at all operating points, bearings on rubber; the limits of its
geometry alone; and the yield alone, which stops at what fails without rubber. Seconds of a core
are the processor's, so that other work does not count; of several they are the clock's, one worker
and two in turn.
"""

import json
import os
import resource
import subprocess
import sys
from concurrent.futures import Executor, ThreadPoolExecutor, wait
from contextlib import ExitStack, contextmanager
from functools import partial
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter, process_time, sleep, thread_time

from cardan.application import reader
from cardan.core.arrays import retain_freed_memory, single_threaded_blas
from cardan.model.variants import VariantOutputs
from cardan.topics.variants import runner, shard_job
from cardan.topics.variants.evaluation import VariantEvaluator, build_variants
from cardan.topics.variants.executors import open_executor
from cardan.topics.variants.runner import run_study
from cardan.topics.variants.shard_job import ShardJob, deserialise_shard_job, serialise_shard_job

TRUCK = Path(__file__).parents[1] / "examples" / "refuse-collector-6x2.yaml"
TOLERANCES = {
    "bearing_height_mm[*]": {"normal": 1.0},
    "shim_deg": {"normal": 0.167},
    "phase_deg[*]": {"normal": 0.667},
}
GEOMETRY = (
    "torsional_acceleration", "inertia_coast_acceleration", "inertia_drive_acceleration",
    "joint_angle", "joint_angle_min", "angle_for_speed", "clearance",
)  # fmt: skip
CORRECTED = {"bearing_height_mm[2]": {"choice": [18]}, "shim_deg": {"choice": [1.0]}}
SET = {"bearing_height_mm[2]": {"choice": [15]}, "shim_deg": {"choice": [0.5]}}
COUNT, SHARD, SHARDS, TURNS, MILLION = 512, 256, 8, 3, 1_000_000


@contextmanager
def cluster():
    """Give the address of a cluster of two on this machine."""
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as found:
        yield found.scheduler_address


def main() -> None:
    """Print the rows."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    truck = reader.read(TRUCK)
    print("| what | target | measured |\n| --- | --- | --- |")
    with single_threaded_blas():
        for what, limits in (("every limit", ()), ("limits of its geometry alone", GEOMETRY)):
            bench = VariantEvaluator.from_application(
                truck, build_variants({}, TOLERANCES, ask=VariantOutputs(limits=limits))
            )
            bench.evaluate_range(0, 64)  # warm
            begun = process_time()
            bench.evaluate_range(0, count)
            rate = count / (process_time() - begun)
            print(f"| variants a second a core, {what} | 10000 | {rate:.0f} |", flush=True)
    with single_threaded_blas():
        for what, chosen in (("as it is", {}), ("corrected", CORRECTED)):
            whole, stopped, alone = yield_alone(truck, chosen, count // 2)
            print(
                f"| every limit over the yield alone, {what}: {100 * stopped:.0f} % fail without "
                f"rubber | 8 | {whole / alone:.1f} |",
                flush=True,
            )
    with single_threaded_blas():
        for what, limits in (("every limit", ()), ("limits of its geometry alone", GEOMETRY)):
            each = [
                processor_ms(truck, {k: TOLERANCES[k] for k in some}, limits, count // 2)
                for some in (TOLERANCES, ["phase_deg[*]"], ["shim_deg"])
            ]
            print(
                f"| phases alone, the shim alone, over all that scatters, {what} | 0.5 "
                f"| {each[1] / each[0]:.2f}, {each[2] / each[0]:.2f} |",
                flush=True,
            )
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"| memory at its peak, {count} variants | bounded | {peak:.0f} MiB |")

    for what, limits in (("geometry", GEOMETRY), ("every limit", ())):
        asked = build_variants(SET, TOLERANCES, ask=VariantOutputs(limits=limits, foretold=MILLION))
        begun, spent = perf_counter(), process_time()
        found = run_study(truck, asked, count=2048, workers=2).surrogate_yield
        print(
            f"| a million draws, {what}, foretold from 2048 asked, 2 threads | 10 s "
            f"| {perf_counter() - begun:.1f} s, {process_time() - spent:.1f} of the processor: "
            f"{100 * found.share:.2f} % fit, {100 * found.low:.2f} to {100 * found.high:.2f} |",
            flush=True,
        )  # fmt: skip

    asked = build_variants(SET, TOLERANCES, ask=VariantOutputs(limits=GEOMETRY))
    parcel = serialise_shard_job(ShardJob.from_study(truck, asked, seed=0, points=None))

    def told(what: str, target: str, pool: Executor) -> None:
        def of_two() -> tuple[float, float]:
            """Return the clock's seconds of two at a time, and the processor's of a shard."""
            begun = perf_counter()
            each = [pool.submit(cost, parcel, k * SHARD, (k + 1) * SHARD) for k in range(SHARDS)]
            spent = [f.result() for f in each]
            return perf_counter() - begun, sum(spent) / SHARDS

        def of_halves() -> float:
            """Return the clock's seconds of two that are handed half of the shards at once."""
            begun = perf_counter()
            ends = range(0, SHARDS + 1, SHARDS // 2)
            each = [pool.submit(costs, parcel, a, b) for a, b in pairwise(ends)]
            wait(each)
            return perf_counter() - begun

        def of_one() -> tuple[float, float]:
            begun = perf_counter()
            spent = [cost(parcel, k * SHARD, (k + 1) * SHARD) for k in range(SHARDS)]
            return perf_counter() - begun, sum(spent) / SHARDS

        of_two(), of_one()  # warm: whoever computes has read everything
        each = [(of_one(), of_two(), of_halves()) for _ in range(TURNS)]
        clock = median(one[0] / two[0] / 2 for one, two, _ in each)
        work = median(one[1] / two[1] for one, two, _ in each)
        most = median(one[0] / halves / 2 for one, _, halves in each)
        given = median(halves / two[0] for _, two, halves in each)
        print(
            f"| two {what}: efficiency by the clock; of two that are handed half at once; the "
            f"first over the second, which is what handing out costs; processor time of a shard, "
            f"alone over there | {target} | {clock:.2f}; {most:.2f}; {given:.2f}; {work:.2f} |",
            flush=True,
        )  # fmt: skip

    if (os.cpu_count() or 1) < 2:
        return
    with ThreadPoolExecutor(2) as threads:
        told("threads", "-", threads)
    with open_executor("processes", 2) as pool:
        told("processes", "0.9", pool)
    if find_spec("distributed"):
        with cluster() as address, open_executor(address, 2) as pool:
            told("workers of a Dask cluster", "0.8", pool)
        for seconds, of in (
            (30.0, "a task of one shard"),
            (2.0, "a shard of 2 s, of several a task"),
        ):
            each = [handing_out(truck, asked, seconds, kept=kept) for kept in (False, True)]
            print(
                f"| processor time of client and scheduler, {of}; kept in a folder | 2 ms "
                f"| {each[0]:.1f} ms; {each[1]:.1f} ms |",
                flush=True,
            )


def processor_ms(truck, scatter, limits: tuple[str, ...], count: int) -> float:
    """Return the milliseconds of a variant."""
    asked = build_variants({}, scatter, ask=VariantOutputs(limits=limits))
    bench = VariantEvaluator.from_application(truck, asked)
    bench.evaluate_range(0, 64)  # warm
    begun = process_time()
    bench.evaluate_range(0, count)
    return 1e3 * (process_time() - begun) / count


def handing_out(truck, asked, seconds: float, *, kept: bool) -> float:
    """Return the milliseconds of client and scheduler for a shard that two workers do not compute.

    Each says that its shards took so many `seconds`.
    """
    shards = 400
    with scheduler_and_two_workers() as (pid, address), open_executor(address, 2) as pool:
        runner.compute_shards = partial(shards_of_before, seconds)
        run_study(truck, asked, count=16 * SHARD, shard=SHARD, executor=pool, workers=2)  # warm
        with TemporaryDirectory() as folder:
            begun = process_time() + processor_seconds(pid)
            run_study(
                truck, asked, count=shards * SHARD, shard=SHARD, executor=pool, workers=2,
                folder=Path(folder) / "study" if kept else None,
            )  # fmt: skip
            spent = process_time() + processor_seconds(pid) - begun
        runner.compute_shards = shard_job.compute_shards
    return 1e3 * spent / shards


def shards_of_before(seconds: float, job: str, spans, *, merged: bool):
    """Return shards of four variants, which a worker computes once."""
    if not hasattr(shard_job, "before"):
        shard_job.before = deserialise_shard_job(shard_job._HELD_JOBS[job]).run_shard(0, 4)
    results = (shard_job.before,) * (1 if merged else len(spans))
    return shard_job.ComputedShards(results=results, seconds=seconds * len(spans))


@contextmanager
def scheduler_and_two_workers():
    """Give the process of a scheduler, and its address."""
    dask = sys.executable, "-m", "dask"
    with TemporaryDirectory() as folder, ExitStack() as stack:
        where = Path(folder) / "scheduler.json"
        local = "--scheduler-file", str(where), "--no-dashboard"

        def begin(*command: str) -> subprocess.Popen:
            run = subprocess.Popen(
                [*dask, *command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
            )
            stack.callback(run.wait)
            stack.callback(run.kill)
            return run

        first = begin("scheduler", *local, "--host", "127.0.0.1", "--port", "0")
        while not where.exists():
            sleep(0.05)
        for _ in range(2):
            begin("worker", *local, "--no-nanny", "--nthreads", "1", "--local-directory", folder)
        yield first.pid, json.loads(where.read_text())["address"]


def processor_seconds(pid: int) -> float:
    """Return the processor time that a process has had, s, on Linux."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def yield_alone(truck, chosen, count: int) -> tuple[float, float, float]:
    """Return seconds of every limit, the share that stops before rubber, and seconds of that."""
    seconds, found = [], None
    for only in (False, True):
        asked = build_variants(chosen, TOLERANCES, ask=VariantOutputs(yield_only=only))
        bench = VariantEvaluator.from_application(truck, asked)
        bench.evaluate_range(0, 64)  # warm
        begun = process_time()
        was, found = found, bench.evaluate_range(0, count)
        seconds.append(process_time() - begun)
        assert was is None or was.verdicts == found.verdicts
    return seconds[0], found.results.stopped.mean(), seconds[1]


def cost(job: bytes, start: int, stop: int) -> float:
    """Return the processor time of a shard, s, of the thread that asks it."""
    with single_threaded_blas(), retain_freed_memory():
        begun = thread_time()
        deserialise_shard_job(job).run_shard(start, stop)
        return thread_time() - begun


def costs(job: bytes, first: int, last: int) -> float:
    """Return the processor time of several shards, one after the other, with nobody to wait for."""
    return sum(cost(job, k * SHARD, (k + 1) * SHARD) for k in range(first, last))


if __name__ == "__main__":
    main()
