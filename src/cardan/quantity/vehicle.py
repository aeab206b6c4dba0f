"""What the vehicle asks of a line: torque, speed, axle loads, where the axle is."""

from typing import Any

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.formula import written
from cardan.base.part import LINE, Part, PartKind
from cardan.base.source import DERIVED, GILLESPIE, J3311, SOUZA, WONG
from cardan.demand.torque import slip_torque
from cardan.model.application import KIND_GROUPS, RIDING, Installed
from cardan.model.vehicle import Suspension
from cardan.quantity.declared import SPRINGS, Quantity, line, of_line
from cardan.quantity.response import Response


def _through(torque: Any, ratio: Any, efficiency: Any, converter: Any, share: Any) -> Any:
    """Return the engine's torque behind the gears, as `cardan.demand.torque.gears` has it."""
    return torque * ratio * efficiency * converter * share


def _suspended(r: Response) -> tuple[Part, ...]:
    """Return the line, if what carries its axle carries that of no line before it."""
    lines = r.application.lines
    mine = r.demand.installed
    before = lines[: next(k for k, other in enumerate(lines) if other.line.name == mine.line.name)]
    sprung = [_springs(r, other) for other in before]
    own = _springs(r, mine)
    asked = (own is None and not before) or (own is not None and all(own is not s for s in sprung))
    return (LINE,) if asked else ()


def _axles(r: Response) -> tuple[Part, ...]:
    """Return the vehicle's axles, told by its first line."""
    vehicle, lines = r.application.vehicle, r.application.lines
    if vehicle is None or r.line.name != lines[0].line.name:
        return ()
    counts: tuple[tuple[PartKind, int], ...] = (
        ("front axle", vehicle.front_group),
        ("driven rear axle", vehicle.driven_rear),
        ("rear axle", vehicle.rear_group - vehicle.driven_rear),
        ("auxiliary axle", len(vehicle.auxiliary)),
    )
    return tuple(
        Part(kind, k if count > 1 else 0) for kind, count in counts for k in range(1, count + 1)
    )


def _springs(r: Response, installed: Installed) -> Suspension | None:
    """Return what carries the axle of a line; the application's springs are the rear's."""
    rear = r.application.suspension if installed.drives == "rear" else None
    return installed.suspension or rear


def _suspension_frequency(r: Response) -> FloatArray:
    frequency = np.broadcast_to(r.demand.suspension_frequency, r.angles.shape[:-1])
    return np.repeat(frequency[..., None], len(_suspended(r)), axis=-1)


DECLARED = (
    Quantity(
        key="torque",
        signed=True,
        name="Shaft torque",
        symbol="T",
        unit="Nm",
        equation="T = min(engine torque, tyre slip torque)",
        source=SOUZA.at("eq. 1-3"),
        use="Loads are computed with the smaller; the joint's size is held against the engine's.",
        of=of_line(lambda r: r.demand.torque),
        parts=line,
        section="Demand",
        contract="torque_Nm",
    ),
    Quantity(
        key="engine_torque",
        name="Torque from the engine",
        symbol="TT",
        unit="Nm",
        equation=written(_through, "Tm", "i", "η", "k", "s"),
        where={
            "Tm": "engine torque",
            "i": "gear ratio, times a transfer case's",
            "η": "efficiency",
            "k": "converter torque ratio",
            "s": "share of the torque",
        },
        source=SOUZA.at("eq. 1"),
        of=of_line(lambda r: r.demand.engine_torque),
        parts=line,
        section="Demand",
        contract="engine_torque_Nm",
    ),
    Quantity(
        key="slip_torque",
        name="Torque at tyre slip",
        symbol="Ts",
        unit="Nm",
        equation=written(slip_torque, "N", friction="μ", radius="re", ratio="iD", efficiency="ηD"),
        where={
            "μ": "friction",
            "N": "load on the driven wheels",
            "re": "static loaded radius",
            "iD, ηD": "axle ratio and efficiency",
        },
        source=SOUZA.at("eq. 2-3"),
        of=of_line(lambda r: r.demand.slip_torque),
        parts=line,
        section="Demand",
        contract="slip_torque_Nm",
    ),
    Quantity(
        key="coast_torque",
        name="Torque held back on the overrun",
        symbol="Tb",
        unit="Nm",
        equation="Tb = min(Tm,b i / η, torque at tyre slip as the wheels drive the line)",
        where={"Tm,b": "engine brake or retarder torque", "i": "gear ratio", "η": "efficiency"},
        source=DERIVED,
        use="What the gears lose helps to brake, so the efficiency divides.",
        of=of_line(lambda r: r.demand.coast_torque),
        parts=line,
        section="Demand",
        contract="coast_torque_Nm",
    ),
    Quantity(
        key="low_gear_torque",
        name="Low gear torque, J3311",
        symbol="LGT",
        unit="Nm",
        equation="LGT = T · TLGR · TE · SR · TCR · C",
        where={
            "T": "net engine torque",
            "TLGR": "lowest gear ratio",
            "TE": "efficiency, 0.85 manual, 0.80 automatic",
            "SR": "stall ratio of a converter",
            "TCR, C": "ratio and efficiency (0.95) of a transfer case",
        },
        source=J3311.at("Driveshaft torque"),
        of=of_line(lambda r: r.demand.low_gear_torque),
        parts=line,
    ),
    Quantity(
        key="wheel_slip_torque",
        name="Wheel slip torque, J3311",
        symbol="WST",
        unit="Nm",
        equation="WST = 0.71 W RR / (0.95 AR);  with RR in inches 12 × 0.95 = 11.4",
        where={"W": "axle capacity", "RR": "rolling radius", "AR": "axle ratio"},
        source=J3311.at("Driveshaft torque"),
        of=of_line(lambda r: r.demand.wheel_slip_torque),
        parts=line,
    ),
    Quantity(
        key="speed",
        name="Shaft speed",
        symbol="n",
        unit="rpm",
        equation="n = n_engine / i_gear",
        source=SOUZA.at("2.4"),
        of=of_line(lambda r: r.demand.speed),
        parts=line,
        section="Demand",
        contract="speed_rpm",
    ),
    Quantity(
        key="axle_load",
        name="Axle load",
        symbol="N",
        unit="N",
        equation="Nr = (W lf − Σ A x) / L,  Nf = W − Nr − Σ A",
        where={
            "W": "weight",
            "lf": "centre of gravity behind the front axle",
            "L": "wheelbase",
            "A, x": "load and place of auxiliary axles on air",
        },
        source=GILLESPIE.at("ch. 1"),
        use="At rest on level ground. A group's axles share its load as the application says.",
        of=of_line(lambda r: r.demand.axle_load),
        parts=line,
        contract="axle_load_N",
    ),
    Quantity(
        key="driven_load",
        name="Load on the driven wheels at slip",
        symbol="N′",
        unit="N",
        equation="Nr′ = (Nr + μ sf W h/L) / (1 − μ (sr − sf) h/L)",
        where={
            "μ": "friction",
            "h": "height of the centre of gravity",
            "L": "wheelbase",
            "sf, sr": "driven shares of the front and rear load",
        },
        source=WONG.at("ch. 3"),
        use="All driven wheels slip at once; no air drag or rolling resistance.",
        of=of_line(lambda r: r.demand.driven_load),
        parts=line,
        contract="driven_load_N",
    ),
    Quantity(
        key="axle_load_rest",
        name="Axle load at rest",
        symbol="Ni",
        unit="N",
        equation="Nr = (W lf − Σ A x) / L,  Nf = W − Nr − Σ A, each shared by its axles",
        where={
            "W": "weight",
            "lf": "centre of gravity behind the front axle",
            "L": "wheelbase",
            "A, x": "load and place of auxiliary axles on air",
        },
        source=GILLESPIE.at("ch. 1"),
        use="On level ground. The axles of a group share its load as the application says.",
        of=lambda r: r.axle_loads[0][..., : len(_axles(r))],
        parts=_axles,
        section="Axle loads",
        contract="axles.rest_N",
    ),
    Quantity(
        key="axle_load_slip",
        name="Axle load at tyre slip",
        symbol="Ni′",
        unit="N",
        equation="Nr′ = (Nr + μ sf W h/L) / (1 − μ (sr − sf) h/L)",
        where={
            "μ": "friction",
            "h": "height of the centre of gravity",
            "L": "wheelbase",
            "sf, sr": "driven shares of the front and rear load",
        },
        source=WONG.at("ch. 3"),
        use="All driven wheels slip at once, on the vehicle's grade; no air drag.",
        of=lambda r: r.axle_loads[1][..., : len(_axles(r))],
        parts=_axles,
        section="Axle loads",
        contract="axles.slip_N",
    ),
    Quantity(
        key="axle_to_frame",
        signed=True,
        name="Axle centre to frame",
        symbol="hF",
        unit="mm",
        equation="hF = what the application gives in the reference state − z",
        where={"z": "axle travel"},
        source=SOUZA.at("figure 43"),
        of=of_line(lambda r: r.axle_to_frame),
        parts=line,
        section="Slopes and lengths",
        contract="axle_to_frame_mm",
    ),
    Quantity(
        key="axle_travel",
        signed=True,
        name="Axle travel",
        symbol="z",
        unit="mm",
        equation="z = spring deflection in the state − in the reference state",
        source=SOUZA.at("2.3"),
        use="Up to the frame is positive.",
        of=of_line(lambda r: r.demand.travel),
        quiet=True,
        parts=line,
        section="Demand",
        contract="axle_travel_mm",
    ),
    Quantity(
        key="pinion_pitch",
        signed=True,
        name="Pinion pitch",
        symbol="ψ",
        unit="deg",
        equation="ψ = axle torque / wind-up stiffness + pitch of the linkage",
        source=DERIVED,
        use="From the reference state; the pinion's nose rising is positive.",
        of=of_line(lambda r: r.demand.pitch),
        quiet=True,
        parts=line,
        section="Demand",
    ),
    Quantity(
        key="suspension_frequency",
        name="Suspension frequency",
        symbol="f",
        unit="Hz",
        equation="f = √(k/m) / 2π",
        where={"k": "slope of the spring's table at the state", "m": "mass the spring carries"},
        source=SOUZA.at("2.3"),
        use="1.0 to 1.3 Hz is comfortable.",
        of=_suspension_frequency,
        parts=_suspended,
        needs=(SPRINGS,),
        states=RIDING | KIND_GROUPS["wound up"],
        section="Demand",
    ),
)
