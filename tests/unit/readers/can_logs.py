"""CAN logs for tests: a database, frames, and files of them as other programs write them."""

import numpy as np

DBC = """VERSION ""

NS_ :

BS_:

BU_: ECU TCU

BO_ 2364540158 EEC1: 8 ECU
 SG_ EngSpeed : 24|16@1+ (0.125,0) [0|8031.875] "rpm" TCU
 SG_ ActualEngPercentTorque : 16|8@1+ (1,-125) [-125|125] "%" TCU
 SG_ EngTorqueMode : 0|4@1+ (1,0) [0|15] "" TCU

BO_ 2364539646 ETC1: 8 TCU
 SG_ ShaftSpeed : 8|16@1+ (0.125,0) [0|8031.875] "rpm" ECU

BO_ 2364540414 ETC2: 8 TCU
 SG_ CurrentGear : 24|8@1+ (1,-125) [-125|125] "" ECU

BO_ 291 Pages: 8 ECU
 SG_ Page M : 0|8@1+ (1,0) [0|255] "" TCU
 SG_ Pressure m0 : 8|16@1- (0.1,0) [0|0] "kPa" TCU
 SG_ Inner m1M : 8|8@1+ (1,0) [0|255] "" TCU
 SG_ Level m3 : 16|12@1- (0.5,-3) [0|0] "" TCU
 SG_ Torque : 39|13@0- (0.25,1) [0|0] "Nm" TCU

BO_ 292 Floats: 16 ECU
 SG_ Little : 0|32@1- (1,0) [0|0] "MPa" TCU
 SG_ Big : 39|32@0- (2,1) [0|0] "MPa" TCU
 SG_ Double : 64|64@1- (1,0) [0|0] "" TCU

CM_ SG_ 291 Page "which of them
 SG_ Comment : 0|8@1+ (1,0) [0|255] is sent";
BA_DEF_ SG_ "SPN" INT 0 524287;
BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","reserved","J1939PG";
BA_DEF_DEF_ "SPN" 0;
BA_DEF_DEF_ "VFrameFormat" "StandardCAN";
BA_ "SPN" SG_ 2364540158 EngSpeed 190;
BA_ "VFrameFormat" BO_ 2364540158 3;
VAL_ 292 Little 0 "zero" ;
SIG_VALTYPE_ 292 Little : 1;
SIG_VALTYPE_ 292 Big : 1;
SIG_VALTYPE_ 292 Double : 2;
SG_MUL_VAL_ 291 Pressure Page 0-0;
SG_MUL_VAL_ 291 Inner Page 1-1;
SG_MUL_VAL_ 291 Level Inner 3-5, 8-9;
"""

EEC1, ETC1, ETC2 = 0x0CF00400, 0x0CF00203, 0x0CF00503
PAGES, FLOATS = 291, 292


def dbc(path, text=DBC):
    path.write_text(text, encoding="cp1252")
    return path


def frames_of_every_kind(count=400):
    """Frames (time s, bus, identifier, extended, data), evenly but for a twentieth of a step."""
    rng = np.random.default_rng(5)
    found = []
    for k in range(count):
        t = round(0.5 + 0.01 * k + rng.uniform(-5e-4, 5e-4), 6)
        every = [
            (1, EEC1, True, rng.integers(0, 250, 8, np.uint8).tobytes()),
            (2, ETC1, True, rng.integers(0, 250, 8, np.uint8).tobytes()),
            (3, PAGES, False, bytes([rng.choice([0, 1]), rng.choice([3, 4, 8, 9])])
             + rng.integers(0, 256, 6, np.uint8).tobytes()),
            (4, FLOATS, False, np.array(rng.normal(), "<f4").tobytes()
             + np.array(rng.normal(), ">f4").tobytes() + np.array(rng.normal(), "<f8").tobytes()),
        ]  # fmt: skip
        for step, name, extended, data in every:
            if k % step == 0:
                found.append((round(t + 1e-3 * step, 6), 1, name, extended, data))
    return found


def _python_can(writer, path, frames, **how):
    can = __import__("can")
    with getattr(can, writer)(path, **how) as log:
        for t, bus, name, extended, data in frames:
            log.on_message_received(
                can.Message(
                    timestamp=t, arbitration_id=name, is_extended_id=extended, data=data,
                    channel=bus - 1, is_fd=len(data) > 8,
                )
            )  # fmt: skip


def blf(path, frames, **how):
    _python_can("BLFWriter", path, frames, **how)


def asc(path, frames):
    _python_can("ASCWriter", path, frames)


def frames_signal(frames, name="CAN_DataFrame"):
    from asammdf import Signal
    from asammdf.blocks.source_utils import Source

    width = max(len(f[4]) for f in frames)
    kinds = [
        ("BusChannel", "u1"), ("ID", "<u4"), ("IDE", "u1"), ("DLC", "u1"), ("DataLength", "u1"),
        ("DataBytes", "u1", (width,)), ("Dir", "u1"),
    ]  # fmt: skip
    rows = np.zeros(len(frames), [(f"{name}.{k[0]}", *k[1:]) for k in kinds])
    for row, (_, bus, identifier, extended, data) in zip(rows, frames, strict=True):
        row[f"{name}.BusChannel"], row[f"{name}.ID"] = bus, identifier
        row[f"{name}.IDE"], row[f"{name}.DataLength"] = extended, len(data)
        row[f"{name}.DataBytes"][: len(data)] = np.frombuffer(data, np.uint8)
    source = Source("CAN1", "CAN1", "", source_type=2, bus_type=2)
    return Signal(rows, np.array([f[0] for f in frames]), name=name, source=source)


def mf4(path, frames, *others):
    """MDF4 bus logging; `others` are groups of signals beside it."""
    from asammdf import MDF

    with MDF(version="4.10") as file:
        for group in others:
            file.append(group)
        file.append(frames_signal(frames))
        file.groups[-1].channel_group.flags |= 2  # bus event
        file.save(path.with_suffix(".mf4"), overwrite=True)
    if path.suffix != ".mf4":
        path.with_suffix(".mf4").rename(path)


WRITERS = {"blf": blf, "asc": asc, "mf4": mf4}
