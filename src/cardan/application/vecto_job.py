"""A job of VECTO: engine, gearbox, axle, tyre and loads, each with the key it came from.

Source: VECTO User Manual, chapters on the job, engine, gearbox and vehicle file, full load curve,
loss map and torque converter; checked with generic vehicles of the tool, file versions 3 to 8.
"""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cardan.application.typical_values import find_csv_row_by_name
from cardan.application.vecto_files import (
    RATIO,
    ROTATION_SPEED,
    TORQUE,
    JobValue,
    VectoPart,
    read_part,
    read_table,
)
from cardan.core.lazy_dataclass import dataclass
from cardan.core.message import TranslatableMessage, translatable_message
from cardan.core.units import mm, rpm

_AXLES = re.compile(r"(\d+)x(\d+)")
MAX_GROSS_MASS_T = 100.0
"""A larger `MassMax` is no mass in tonnes."""
DYNAMIC_RADIUS_RANGE_MM = (200.0, 1000.0)
MAX_POWER_DEVIATION = 0.1
"""Share by which the curve may miss the rated power before that is left out."""


@dataclass(frozen=True, kw_only=True)
class VectoJob:
    """What a job says of a powertrain. SI, but for `engine_speed` in rpm; None is not given.

    Attributes
    ----------
    path
        The job file.
    drive, category
        Wheel configuration, `4x2`, and the tool's category of vehicle, `RigidTruck`.
    gross_mass, curb_mass
        kg.
    front_share, driven_share
        Share of the vehicle's load on its front axles, and of its rear axles' on the driven ones.
    dynamic_radius
        Of the driven wheels, m.
    engine_speed, engine_torque
        Full load, rpm and N m.
    drag_torque
        The most with which the engine holds back, N m.
    rated_power
        W.
    ratios, gearbox_efficiency, axle_ratio, axle_efficiency, converter_ratio
        Of the gears from the lowest, of the first of them at the engine's largest torque, and of
        the axle; torque ratio of a converter at stall.
    remarks
        What the job holds that is not carried over, or lacks.
    """

    path: Path
    drive: JobValue
    category: str
    gross_mass: JobValue | None
    curb_mass: JobValue | None
    front_share: JobValue | None
    driven_share: JobValue | None
    dynamic_radius: JobValue | None
    engine_name: str
    engine_speed: JobValue
    engine_torque: JobValue
    drag_torque: JobValue | None
    rated_power: JobValue | None
    ratios: JobValue
    gearbox_efficiency: JobValue | None
    axle_ratio: JobValue
    axle_efficiency: JobValue | None
    converter_ratio: JobValue | None
    remarks: tuple[TranslatableMessage, ...]

    @property
    def largest_torque(self) -> float:
        """Largest torque at the gearbox output, N m: the engine's in the lowest gear."""
        losses = self.gearbox_efficiency.value if self.gearbox_efficiency else 1.0
        stall = self.converter_ratio.value if self.converter_ratio else 1.0
        return max(self.engine_torque.value) * max(self.ratios.value) * losses * stall


def read_job(path: Path) -> VectoJob:
    """Return what a job file and the files that it names say of the powertrain.

    Raises
    ------
    InvalidFileError
        If a file is missing, cannot be read, or lacks what an application needs.
    """
    job = read_part(path)
    for key in ("ElectricMotors", "Batteries", "HybridStrategyParams"):
        if job.get(key):
            job.refuse(key, "electric and hybrid powertrains are not read")
    if job.get("EngineOnlyMode") is True:
        job.refuse("EngineOnlyMode", "the job is of an engine alone, without a driveline")
    engine, gearbox, vehicle = (
        read_part(job.required_file(key)) for key in ("EngineFile", "GearboxFile", "VehicleFile")
    )
    speed, torque, drag = _full_load(engine)
    axle, *gears = gearbox.tables("Gears") or [{}]
    if not gears:
        gearbox.refuse("Gears", "needs the axle first, then at least one gear")
    ratios = tuple(_ratio(gearbox, gear, k) for k, gear in enumerate(gears, 1))
    if list(ratios) != sorted(ratios, reverse=True):
        gearbox.refuse("Gears", "ratios must fall from the lowest gear to the highest", got=ratios)
    largest = max(torque.value)
    first_loss = _efficiency(gearbox, gears[0], "Gears[1]", largest)
    axle_loss = _efficiency(gearbox, axle, "Gears[0]", largest * ratios[0])
    drive, axles = _axles(vehicle)
    front, driven = _shares(vehicle, drive.value, axles)
    return VectoJob(
        path=path,
        drive=drive,
        category=str(vehicle.get("VehCat") or vehicle.get("VehicleCategory") or ""),
        gross_mass=_gross_mass(vehicle),
        curb_mass=vehicle.number("CurbWeight"),
        front_share=front,
        driven_share=driven,
        dynamic_radius=_dynamic_radius(vehicle, axles),
        engine_name=str(engine.get("ModelName") or ""),
        engine_speed=speed,
        engine_torque=torque,
        drag_torque=drag,
        rated_power=_rated_power(engine, speed, torque),
        ratios=JobValue(
            value=ratios, source=gearbox.source(f"Gears[1] to Gears[{len(gears)}].Ratio")
        ),
        gearbox_efficiency=first_loss,
        axle_ratio=JobValue(
            value=_ratio(gearbox, axle, 0), source=gearbox.source("Gears[0].Ratio")
        ),
        axle_efficiency=axle_loss,
        converter_ratio=_stall_ratio(gearbox),
        remarks=tuple(_remarks(gearbox, vehicle, gears)),
    )


# --------------------------------------------------------------------------- engine


def _full_load(engine: VectoPart) -> tuple[JobValue, JobValue, JobValue | None]:
    """Return speeds (rpm), torques (N m) and the largest drag of the full load curve."""
    listed = engine.tables("FullLoadCurves")  # before file version 3: a list, by gears
    path = engine.file("Path", listed[0]) if listed else engine.required_file("FullLoadCurve")
    if path is None or not path.is_file():
        engine.refuse("FullLoadCurves", "names a file that does not exist", got=path or "")
    table = read_table(path)
    turning = table.column_in_si("engine speed", "n", place=0, unit=ROTATION_SPEED)
    torque = table.column_in_si("full load torque", "Mfull", place=1, unit=TORQUE)
    drag = table.find_in_si("motoring torque", "drag torque", "Mdrag", unit=TORQUE)
    speed = turning / rpm
    last = int(np.flatnonzero(torque > 0)[-1]) + 1 if (torque > 0).any() else 0
    speed, torque = speed[:last], torque[:last]  # beyond it a governor has taken all torque away
    if last < 1 or not (np.diff(speed) > 0).all() or not (torque > 0).all():
        engine.refuse("FullLoadCurve", "needs torques above 0 at speeds that rise", got=path.name)
    held = None
    if drag is not None and np.isfinite(drag).any() and np.nanmin(drag) < 0:
        held = JobValue(value=-float(np.nanmin(drag)), source=f"{path.name}: motoring torque")
    return (
        JobValue(value=tuple(speed.tolist()), source=f"{path.name}: engine speed"),
        JobValue(value=tuple(torque.tolist()), source=f"{path.name}: full load torque"),
        held,
    )


def _rated_power(engine: VectoPart, speed: JobValue, torque: JobValue) -> JobValue | None:
    """Return the rated power, W; None where the curve says that it is another quantity."""
    given = engine.number("RatedPower")
    reached = float(np.max(np.array(speed.value) * rpm * np.array(torque.value)))
    if given is None or abs(given.value / reached - 1) > MAX_POWER_DEVIATION:
        return None
    return given


# --------------------------------------------------------------------------- gearbox, axle


def _ratio(gearbox: VectoPart, gear: Mapping[str, Any], k: int) -> float:
    found = gearbox.number("Ratio", gear, label=f"Gears[{k}].Ratio", nth=k)
    if found is None:
        gearbox.refuse(f"Gears[{k}].Ratio", "must be a number above 0", nth=k)
    return found.value


def _efficiency(
    gearbox: VectoPart, gear: Mapping[str, Any], label: str, torque: float
) -> JobValue | None:
    """Return the efficiency of a gear at a torque (N m): a number, or the best of its loss map.

    None if the job gives none, or a map that is not there.
    """
    for key in ("Efficiency", "LossMap"):
        try:
            given = float(gearbox.get(key, gear) or "nan")
        except (TypeError, ValueError):
            continue
        if 0 < given <= 1:
            return JobValue(value=given, source=gearbox.source(f"{label}.{key}"))
    path = gearbox.file("LossMap", gear)
    if path is None or not path.is_file():
        return None
    table = read_table(path)
    into = table.column_in_si("input torque", place=1, unit=TORQUE)
    loss = table.column_in_si("torque loss", place=2, unit=TORQUE)
    if not (usable := (into > 0) & (into <= torque * (1 + 1e-9)) & (loss < into)).any():
        return None
    at = usable & (into == into[usable].max())
    best = float(np.max(1 - loss[at] / into[at]))
    return JobValue(value=round(min(best, 1.0), 4), source=f"{path.name} at {into[at][0]:g} Nm")


def _stall_ratio(gearbox: VectoPart) -> JobValue | None:
    """Return the torque ratio of the converter at stall; None without a converter."""
    converter = gearbox.table("TorqueConverter")
    path = gearbox.file("File", converter)
    if gearbox.get("Enabled", converter) is not True or path is None or not path.is_file():
        return None
    table = read_table(path)
    speed = table.column_in_si("Speed Ratio", place=0, unit=RATIO)
    ratio = table.column_in_si("Torque Ratio", place=1, unit=RATIO)
    k = int(np.argmin(np.abs(speed)))
    return JobValue(
        value=max(float(ratio[k]), 1.0), source=f"{path.name} at speed ratio {speed[k]:g}"
    )


# --------------------------------------------------------------------------- vehicle


def _axles(vehicle: VectoPart) -> tuple[JobValue, list[Mapping[str, Any]]]:
    """Return the wheel configuration and the vehicle's own axles, those of trailers left out."""
    config = vehicle.table("AxleConfig")
    said = str(vehicle.get("Type", config) or "")
    found = _AXLES.match(said)
    if not found:
        vehicle.refuse("AxleConfig.Type", "must be a configuration such as 4x2", got=said)
    if said.upper().endswith("F"):
        vehicle.refuse("AxleConfig.Type", "the vehicle has driven front axles alone", got=said)
    axles = vehicle.tables("Axles", config)
    own = int(found[1]) // 2
    if len(axles) < own:
        vehicle.refuse("AxleConfig.Axles", f"{found[0]} has {own} axles", got=len(axles))
    return JobValue(value=found[0], source=vehicle.source("AxleConfig.Type")), axles[:own]


def _shares(
    vehicle: VectoPart, drive: str, axles: list[Mapping[str, Any]]
) -> tuple[JobValue | None, JobValue | None]:
    """Return the share of load in front, and of the rear load on driven axles."""
    given = [
        vehicle.number("AxleWeightShare", a, label=f"AxleConfig.Axles[{k}].AxleWeightShare", nth=k)
        for k, a in enumerate(axles)
    ]
    if any(one is None for one in given):
        return None, None
    shares = np.array([one.value for one in given if one is not None])
    source = vehicle.source("AxleConfig.Axles[*].AxleWeightShare")
    front = 2 if drive.startswith("8") else 1
    turned = _driven(vehicle, axles)
    rear = shares[front:]
    driven = float(shares[[k for k in turned if k >= front]].sum() / rear.sum())
    return (
        JobValue(value=float(shares[:front].sum() / shares.sum()), source=source),
        JobValue(value=driven, source=source),
    )


def _driven(vehicle: VectoPart, axles: list[Mapping[str, Any]]) -> list[int]:
    """Return which axles are driven: those that say so, else the first rear one with twins."""
    said = [k for k, a in enumerate(axles) if vehicle.get("Type", a) == "VehicleDriven"]
    twins = [k for k, a in enumerate(axles) if k and vehicle.get("TwinTyres", a) is True]
    return said or twins[:1] or [1]


def _gross_mass(vehicle: VectoPart) -> JobValue | None:
    """Return the largest mass of the vehicle without its trailer, kg."""
    given = vehicle.number("MassMax") or vehicle.number("GrossVehicleMassRating")
    if given is None:
        return None
    if given.value >= MAX_GROSS_MASS_T:
        vehicle.refuse("MassMax", "must be tonnes, below 100", got=f"{given.value:g}")
    return JobValue(value=1e3 * given.value, source=given.source)


def _dynamic_radius(vehicle: VectoPart, axles: list[Mapping[str, Any]]) -> JobValue | None:
    """Return the dynamic radius of the driven wheels, m: as given, or of their tyre."""
    low, high = DYNAMIC_RADIUS_RANGE_MM
    if given := vehicle.number("rdyn"):
        if not low <= given.value <= high:
            vehicle.refuse("rdyn", f"must be {low:g} to {high:g} mm", got=f"{given.value:g}")
        return JobValue(value=given.value * mm, source=given.source)
    k = _driven(vehicle, axles)[0]
    name = str(vehicle.get("Wheels", axles[k]) or "")
    row, _ = find_csv_row_by_name("tyres.csv", name) if name else (None, "")
    if row is None:
        return None
    at = vehicle.source(f"AxleConfig.Axles[{k}].Wheels, {name}; radius by `cardan catalogue tyres`")
    return JobValue(value=float(row["dynamic_radius_mm_computed"]) * mm, source=at)


# --------------------------------------------------------------------------- what is left out


def _remarks(
    gearbox: VectoPart, vehicle: VectoPart, gears: list[Mapping[str, Any]]
) -> Iterator[TranslatableMessage]:
    """Yield what the job holds that an application has no key for, or lacks."""
    limits = vehicle.table("TorqueLimits")
    by_gear = [*limits.items()]
    by_gear += [
        (k, most) for k, gear in enumerate(gears, 1) if (most := gearbox.get("MaxTorque", gear))
    ]
    if by_gear:
        yield translatable_message(
            "torque limits by gear are not applied: {limits}",
            limits=tuple(
                translatable_message("gear {gear}: {torque} Nm", gear=gear, torque=torque)
                for gear, torque in by_gear
            ),
        )
    for key in ("Retarder", "Angledrive"):
        kind = str(vehicle.get("Type", vehicle.table(key)) or "None")
        if kind.casefold() not in ("none", "losses included in gearbox"):
            yield translatable_message(
                "{key} is {kind}: not carried over", key=vehicle.source(key), kind=kind
            )
    converter = gearbox.table("TorqueConverter")
    if gearbox.get("Enabled", converter) is True and _stall_ratio(gearbox) is None:
        yield translatable_message(
            "the file of the torque converter does not exist: its stall torque ratio is missing"
        )
