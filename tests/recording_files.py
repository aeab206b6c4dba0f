"""Recordings of known content in every container: a gauge, and a bus of another clock.

The gauge is sampled at 500 Hz for 10 s; it misses 0.6 s and stands still for 1 s. The bus gives
speed and torque at 10 Hz, from 2.0005 s on, for 6 s: a moment that no sample of the gauge has.
WAV and RPC hold one clock and no missing sample; there the gauge and the bus begin together.
"""

import wave

import numpy as np
import pytest

RATE, SLOW_RATE = 500.0, 10.0
T = np.arange(5000) / RATE
SLOW_T = 2.0005 + np.arange(60) / SLOW_RATE
_RNG = np.random.default_rng(11)
WHOLE = np.rint(500 * np.sin(2 * np.pi * 7.3 * T) + 60 * _RNG.standard_normal(T.size)) / 10
WHOLE[3500:4000] = WHOLE[3500]
"""The gauge, MPa, without what is missing; whole tenths, so that 16 bits hold them."""
GAUGE = WHOLE.copy()
GAUGE[1000:1300] = np.nan
SPEED = 900 + 40 * np.sin(SLOW_T) + 5 * np.arange(60)
TORQUE = 300 + 100 * np.cos(SLOW_T)
UNITS = {"S1": "MPa", "speed": "rpm", "torque": "Nm"}


def _rows_of_both():
    """Rows of a table of both clocks in the order of time; those that are missing are no rows."""
    there = ~np.isnan(GAUGE)
    empty = np.full_like
    rows = np.concatenate(
        [
            np.stack([T, GAUGE, empty(T, np.nan), empty(T, np.nan)], 1)[there],
            np.stack([SLOW_T, empty(SLOW_T, np.nan), SPEED, TORQUE], 1),
        ]
    )
    return rows[np.argsort(rows[:, 0])]


def csv(path):
    head = "time [s],S1 [MPa],speed [rpm],torque [Nm]"
    rows = (",".join("" if np.isnan(v) else repr(v) for v in r) for r in _rows_of_both().tolist())
    path.write_text("\n".join([head, *rows]) + "\n")


def parquet(path):
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    fields = [("time", "s"), *UNITS.items()]
    schema = pa.schema([pa.field(n, pa.float64(), metadata={"unit": u}) for n, u in fields])
    columns = [pa.array(c, from_pandas=True) for c in _rows_of_both().T]
    pq.write_table(pa.table(columns, schema=schema), path)


def tdms(path):
    nptdms = pytest.importorskip("nptdms")

    def channel(group, name, x, rate, offset):
        how = {"wf_increment": 1 / rate, "wf_start_offset": offset, "unit_string": UNITS[name],
               "wf_start_time": np.datetime64("2026-01-01T00:00:00", "us")}  # fmt: skip
        return nptdms.ChannelObject(group, name, x, properties=how)

    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(
            [
                channel("gauges", "S1", GAUGE, RATE, 0.0),
                channel("can", "speed", SPEED, SLOW_RATE, SLOW_T[0]),
                channel("can", "torque", TORQUE, SLOW_RATE, SLOW_T[0]),
            ]
        )


def mdf(path):
    asammdf = pytest.importorskip("asammdf")
    file = asammdf.MDF(version="4.10")
    there = ~np.isnan(GAUGE)
    file.append([asammdf.Signal(GAUGE[there], T[there], name="S1", unit="MPa")])
    bus = (("speed", SPEED), ("torque", TORQUE))
    file.append([asammdf.Signal(x, SLOW_T, name=n, unit=UNITS[n]) for n, x in bus])
    saved = file.save(path.with_suffix(".mf4"))  # it takes no other ending
    file.close()
    saved.rename(path)


def hdf5(path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for group, time, channels in (
            ("gauges", T, {"S1": GAUGE}), ("can", SLOW_T, {"speed": SPEED, "torque": TORQUE})
        ):  # fmt: skip
            home = file.create_group(group)
            home["time"] = time
            home["time"].attrs["unit"] = "s"
            for name, x in channels.items():
                home[name] = x
                home[name].attrs["unit"] = UNITS[name]


def matlab(path):
    scipy_io = pytest.importorskip("scipy.io")
    scipy_io.savemat(
        path,
        {
            "gauges": {"time": T, "S1": GAUGE, "units": {"S1": "MPa"}},
            "can": {"time": SLOW_T, "speed": SPEED, "torque": TORQUE,
                    "units": {"speed": "rpm", "torque": "Nm"}},
        },
    )  # fmt: skip


def wav(path):
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(int(RATE))
        file.writeframes(np.rint(WHOLE * 10).astype("<i2").tobytes())


def rpc(path):
    import cardan

    cardan.write_drive_file(path, {"S1": WHOLE}, rate=RATE, units={"S1": "MPa"}, replace=True)


TWO_CLOCKS = (csv, parquet, tdms, mdf, hdf5, matlab)
ONE_CLOCK = (wav, rpc)
ALL = (*TWO_CLOCKS, *ONE_CLOCK)
