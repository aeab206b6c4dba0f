"""Rainflow beside other packages, and `cardan life` on a recording of a gigabyte.

    python benchmarks/bench_fatigue.py [--samples 10000000] [--gigabytes 1.0] [--keep FILE]

Everything is timed in one run on one machine, in turn and warm, so the ratios hold. Peers run in
an environment of their own (`CARDAN_PEERS`, its Python); those not there are left out. The
recording is synthetic.
"""

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

RATE = 2000
GAUGES = ("S1", "S2", "S3", "S4", "S5")


ROUNDS = 3
"""Each is timed as often, in turn, and warm; the median counts."""


def clock(work):
    start = time.perf_counter()
    result = work()
    return time.perf_counter() - start, result


PEERS = {
    "pyLife, four-point": """
from pylife.stress.rainflow import FourPointDetector, FullRecorder
def count(x):
    recorder = FullRecorder()
    FourPointDetector(recorder=recorder).process(x)
    return len(recorder.values_from)
""",
    "fatpack, 64 classes": """
import fatpack
def count(x):
    return fatpack.find_rainflow_ranges(x).size
""",
    "rainflow": """
import rainflow
def count(x):
    return sum(1 for _ in rainflow.extract_cycles(x))
""",
    "py-fatigue": """
from py_fatigue.cycle_count.rainflow import rainflow
def count(x):
    return len(rainflow(x)[0])
""",
    "rfcnt, 512 classes": """
import rfcnt
def count(x):
    low, high = x.min(), x.max()
    found = rfcnt.rfc(
        x, (high - low) / 500, class_count=512, class_offset=low - (high - low) / 100,
        hysteresis=0.0, residual_method=0,
    )["rfm"]
    return float(np.sum(found[:, 2] if found.shape[1] == 3 else found))
""",
}
"""Peers, each in a process of the environment that `CARDAN_PEERS` names: theirs, not ours."""

PEER = """
import json, sys, time
import numpy as np
x = np.load(sys.argv[1])
{count}
count(x[:20000])
start = time.perf_counter()
cycles = count(x)
print(json.dumps([time.perf_counter() - start, float(cycles)]))
"""


def peer(name, signal):
    """Seconds and cycles of a peer on a signal's file; None where it is not there."""
    python = os.environ.get("CARDAN_PEERS", sys.executable)
    code = PEER.replace("{count}", PEERS[name])
    done = subprocess.run([python, "-c", code, signal], capture_output=True, text=True, check=False)
    if done.returncode:
        said = (done.stderr.strip().splitlines() or ["no word"])[-1]
        return None, said
    return json.loads(done.stdout.strip().splitlines()[-1]), ""


def rainflow_rows(samples):
    """Seconds of each package for the same signal, and the cycles it closed."""
    from scipy.signal import lfilter

    from cardan.physics.fatigue.rainflow import (
        EMPTY_REVERSALS,
        FromToMatrix,
        concatenate_cycles,
        four_point,
        rainflow,
    )
    from cardan.physics.fatigue.rainflow_kernels import extract_closed_cycles_without_numba

    rng = np.random.default_rng(0)
    x = lfilter([0.1], [1, -0.9], rng.normal(size=samples))
    four_point(x[:1000])  # compiled here, once

    def in_pieces():
        matrix, residue = FromToMatrix.empty(), EMPTY_REVERSALS
        for start in range(0, samples, 1 << 18):
            cycles, residue = four_point(x[start : start + (1 << 18)], residue=residue)
            matrix = matrix.with_cycles(cycles)
        return matrix.counts.sum()

    def without_numba():
        closed, _ = four_point(x, kernel=extract_closed_cycles_without_numba)
        return concatenate_cycles([closed]).count.size

    ours = {
        "cardan, whole signal, every cycle": lambda: rainflow(x).count.size,
        "cardan, in pieces, into a matrix": in_pieces, "cardan without numba": without_numba,
    }  # fmt: skip
    timed = {name: [] for name in (*ours, *PEERS)}
    with tempfile.TemporaryDirectory() as folder:
        signal = str(Path(folder) / "signal.npy")
        np.save(signal, x)
        for _ in range(ROUNDS):
            for name, work in ours.items():
                timed[name].append(clock(work))
            for name in list(timed):
                if name in PEERS:
                    answer, said = peer(name, signal)
                    if answer is None:
                        print(f"  {name}: left out, {said}")
                        del timed[name]
                    else:
                        timed[name].append(answer)
    return [
        (name, float(np.median([t for t, _ in rounds])), rounds[0][1])
        for name, rounds in timed.items()
    ]


def write_recording(path, gigabytes):
    """Five gauges, shaft and engine speed, torque: float32, repeated with fresh noise."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    from cardan.core.units import MPa
    from cardan.physics.signals.synthetic import GaugeStressPerCause, synthetic_recording

    made = synthetic_recording(
        seconds=524.288,
        rate=RATE,
        gains={g: GaugeStressPerCause(joints=(3 + 8 * k) * MPa) for k, g in enumerate(GAUGES)},
        seed=1,
    )
    names = [*GAUGES, "shaft_speed", "engine_speed", "torque"]
    data = made.recording.read_all(names).astype(np.float32)
    units = [made.recording.channel(n).unit for n in names]
    schema = pa.schema(
        [
            pa.field(n, pa.float32(), metadata={"unit": u})
            for n, u in zip(names, units, strict=True)
        ],
        metadata={"rate_Hz": str(RATE), "note": "synthetic: made by a generator, not measured"},
    )
    rng = np.random.default_rng(2)
    blocks = round(gigabytes * 1e9 / data.nbytes)
    with pq.ParquetWriter(
        path, schema, compression="zstd", use_dictionary=False, use_byte_stream_split=True
    ) as writer:
        for _ in range(blocks):
            noisy = data.copy()
            noisy[: len(GAUGES)] += rng.normal(0, 0.3, (len(GAUGES), data.shape[1]))
            writer.write_table(pa.table(list(noisy), schema=schema), row_group_size=1 << 18)
    return blocks * data.nbytes


MDF = {
    "whole, once, by asammdf": (
        "import asammdf;"
        "f = asammdf.MDF(path); kept = f.select([c.name for c in r.channels]); f.close()"
    ),
    "in stretches": "for piece in r.pieces(): pass",
}


def write_mdf(path, parquet, gigabytes, *, compression):
    """Write as much of a Parquet recording as MDF4."""
    import asammdf
    import pyarrow.parquet as pq

    with pq.ParquetFile(parquet) as source:
        names, schema = source.schema_arrow.names, source.schema_arrow
        rows = round(gigabytes * 1e9 / 4 / len(names))
        groups = range(min(-(-rows // (1 << 18)), source.num_row_groups))
        table = source.read_row_groups(list(groups))
    time_of = np.arange(table.num_rows) / RATE
    signals = [
        asammdf.Signal(
            table.column(n).to_numpy(), time_of, name=n,
            unit=(schema.displacement_field(n).metadata or {}).get(b"unit", b"").decode(),
        )
        for n in names
    ]  # fmt: skip
    with asammdf.MDF(version="4.10") as file:
        file.append(signals)
        file.save(path, overwrite=True, compression=compression)
    return table.nbytes


WORK = {
    "just reading": "for piece in r.pieces(): pass",
    "speed estimated from a gauge": (
        "estimate_rotation_from_vibration(r.pieces(plan.gauges[0].channels), rate=r.rate)"
    ),
    "life of five gauges": "assess_gauges(r, plan=plan)",
    "life and causes of one gauge": (
        "plan = replace(plan, gauges=plan.gauges[:1]);"
        "h = survey_channel_quality(r, channels=plan.channels);"
        "assess_gauges(r, plan=plan, healths=h);"
        "s, e = (rotation_from_speed(r.pieces([c]), rate=r.rate, unit=1 / 60)"
        " for c in ('shaft_speed', 'engine_speed'));"
        "how = source_separation(vibration_sources(s, engine=e), rate=r.rate);"
        "attribute_damage(r, plan=plan, healths=h, how=how)"
    ),
}
SETUP = """
import time, json
from dataclasses import replace
from pathlib import Path
from cardan.core.units import MPa
from cardan.physics.signals.damage_attribution import source_separation, vibration_sources
from cardan.physics.signals.assessment import AssessmentSettings, assess_gauges
from cardan.physics.signals.assessment import survey_channel_quality
from cardan.physics.signals.cause_assessment import attribute_damage
from cardan.physics.signals.order_tracking import estimate_rotation_from_vibration
from cardan.physics.signals.order_tracking import rotation_from_speed
from cardan.physics.fatigue.rainflow import four_point
from cardan.physics.fatigue.strain_gauges import single_gauge
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.readers.dispatch import open_recording
path = {path!r}
r = open_recording(Path(path))
plan = AssessmentSettings(gauges=tuple(single_gauge(g, g, factor=MPa) for g in {gauges!r}),
            curve=SNCurve(amplitude=30 * MPa, cycles=2e6, slope=5).modified())
four_point([0.0, 1.0])
import scipy.signal  # a second of imports, once a process
start, used = time.perf_counter(), time.process_time()
{work}
seconds, used = time.perf_counter() - start, time.process_time() - used
lines = Path("/proc/self/status").read_text().splitlines()  # getrusage inherits the parent's peak
peak = next(int(s.split()[1]) for s in lines if s.startswith("VmHWM")) / 1024
print(json.dumps([seconds, used, peak]))
"""


def end_to_end(path, works):
    """Seconds, CPU seconds and peak MB of each kind of work, each in its own process, in turn."""
    rounds = {name: [] for name in works}
    for _ in range(ROUNDS):
        for name, work in works.items():
            code = SETUP.format(path=str(path), gauges=GAUGES, work=work)
            done = subprocess.run(
                [sys.executable, "-c", code], capture_output=True, text=True, check=True
            )
            rounds[name].append(json.loads(done.stdout))
    return [(name, *np.median(each, axis=0)) for name, each in rounds.items()]


def told(what, path, size, works):
    """Print how long each kind of work takes on a file, over the first of them."""
    print(
        f"\n| {what} ({path.stat().st_size / 1e9:.2f} GB as a file) "
        "| seconds | over reading | CPU seconds | over reading | MB/s | peak MB |"
    )
    print("|---|---|---|---|---|---|---|")
    rows = end_to_end(path, works)
    for name, seconds, used, peak in rows:
        print(
            f"| {name} | {seconds:.1f} | {seconds / rows[0][1]:.1f} "
            f"| {used:.1f} | {used / rows[0][2]:.1f} "
            f"| {size / 1e6 / seconds:.0f} | {peak:.0f} |",
            flush=True,
        )


def main():
    ask = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    ask.add_argument("--samples", type=int, default=10_000_000)
    ask.add_argument("--gigabytes", type=float, default=1.0)
    ask.add_argument("--keep", type=Path, help="Write the recording here and keep it.")
    how = ask.parse_args()
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    print(f"load average {os.getloadavg()[0]:.1f} at the start\n")
    print(f"| rainflow of {how.samples:,} samples | seconds | over cardan | cycles |")
    print("|---|---|---|---|")
    rows = rainflow_rows(how.samples)
    for name, seconds, cycles in rows:
        print(f"| {name} | {seconds:.2f} | {seconds / rows[0][1]:.1f} | {cycles:,.0f} |")
    with tempfile.TemporaryDirectory() as folder:
        path = how.keep or Path(folder) / "synthetic.parquet"
        size = write_recording(path, how.gigabytes)
        told(f"{size / 1e9:.2f} GB of float32", path, size, WORK)
        for compression, named in ((0, "not compressed"), (2, "compressed")):
            mdf = Path(folder) / "synthetic.mf4"
            size = write_mdf(mdf, path, how.gigabytes / 2, compression=compression)
            told(f"{size / 1e9:.2f} GB as MDF4, {named}", mdf, size, MDF)
    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"\nThe benchmark itself peaked at {own:.0f} MB, the whole signal in memory.")


if __name__ == "__main__":
    main()
