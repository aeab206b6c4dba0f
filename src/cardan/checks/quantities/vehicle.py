"""What the vehicle requires of a line: torque, speed, axle loads, where the axle is."""

from typing import Any

import numpy as np

from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.declaration import (
    NEEDS_SUSPENSION,
    Quantity,
    make_whole_line_quantity_function,
    whole_line,
)
from cardan.core.arrays import FloatArray
from cardan.core.labels import WHOLE_LINE, Part, PartKind
from cardan.core.provenance import (
    GILLESPIE_1992,
    SOURCE_DERIVED,
    SOUZA_2014_BRACKET_FAILURE,
    SPICER_J3311,
    WONG_2008,
)
from cardan.core.symbolic import trace_expression
from cardan.model.application import (
    STATE_KIND_GROUPS,
    STATE_KINDS_AT_LOADED_RIDE_HEIGHT,
    InstalledLine,
)
from cardan.model.vehicle import Suspension
from cardan.physics.vehicle.torque import slip_torque_at_friction


def _through(torque: Any, ratio: Any, efficiency: Any, converter: Any, share: Any) -> Any:
    """Return the engine's torque behind the gears (`cardan.physics.vehicle.torque.gear_table`)."""
    return torque * ratio * efficiency * converter * share


def _suspended(r: LineResponse) -> tuple[Part, ...]:
    """Return the line, if what carries its axle carries that of no line before it."""
    lines = r.application.lines
    mine = r.demand.installed
    before = lines[: next(k for k, other in enumerate(lines) if other.line.name == mine.line.name)]
    sprung = [_springs(r, other) for other in before]
    own = _springs(r, mine)
    asked = (own is None and not before) or (own is not None and all(own is not s for s in sprung))
    return (WHOLE_LINE,) if asked else ()


def _axles(r: LineResponse) -> tuple[Part, ...]:
    """Return the vehicle's axles, by its first line."""
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


def _springs(r: LineResponse, installed: InstalledLine) -> Suspension | None:
    """Return what carries the axle of a line; the application's springs are the rear's."""
    rear = r.application.suspension if installed.drives == "rear" else None
    return installed.suspension or rear


def _suspension_frequency(r: LineResponse) -> FloatArray:
    frequency = np.broadcast_to(r.demand.suspension_frequency, r.joint_angles.shape[:-1])
    return np.repeat(frequency[..., None], len(_suspended(r)), axis=-1)


DECLARATIONS = (
    Quantity(
        key="torque",
        signed=True,
        name="Shaft torque",
        symbol="T",
        unit="Nm",
        equation="T = min(engine torque, tyre slip torque)",
        source=SOUZA_2014_BRACKET_FAILURE.with_place("eq. 1-3"),
        validity=(
            "Loads are computed with the smaller; the joint's size is held against the engine's."
        ),
        compute=make_whole_line_quantity_function(lambda r: r.demand.torque),
        parts=whole_line,
        section="Demand",
        json_path="torque_Nm",
    ),
    Quantity(
        key="engine_torque",
        name="Torque from the engine",
        symbol="TT",
        unit="Nm",
        equation=trace_expression(_through, "Tm", "i", "η", "k", "s"),
        symbol_meanings={
            "Tm": "engine torque",
            "i": "gear ratio, times a transfer case's",
            "η": "efficiency",
            "k": "converter torque ratio",
            "s": "share of the torque",
        },
        source=SOUZA_2014_BRACKET_FAILURE.with_place("eq. 1"),
        compute=make_whole_line_quantity_function(lambda r: r.demand.engine_torque),
        parts=whole_line,
        section="Demand",
        json_path="engine_torque_Nm",
    ),
    Quantity(
        key="slip_torque",
        name="Torque at tyre slip",
        symbol="Ts",
        unit="Nm",
        equation=trace_expression(
            slip_torque_at_friction, "N", friction="μ", radius="re", ratio="iD", efficiency="ηD"
        ),
        symbol_meanings={
            "μ": "friction",
            "N": "load on the driven wheels",
            "re": "static loaded radius",
            "iD, ηD": "axle ratio and efficiency",
        },
        source=SOUZA_2014_BRACKET_FAILURE.with_place("eq. 2-3"),
        compute=make_whole_line_quantity_function(lambda r: r.demand.slip_torque),
        parts=whole_line,
        section="Demand",
        json_path="slip_torque_Nm",
    ),
    Quantity(
        key="coast_torque",
        name="Torque held back on the overrun",
        symbol="Tb",
        unit="Nm",
        equation="Tb = min(Tm,b i / η, torque at tyre slip as the wheels drive the line)",
        symbol_meanings={
            "Tm,b": "engine brake or retarder torque",
            "i": "gear ratio",
            "η": "efficiency",
        },
        source=SOURCE_DERIVED,
        validity="What the gears lose helps to brake, so the efficiency divides.",
        compute=make_whole_line_quantity_function(lambda r: r.demand.coast_torque),
        parts=whole_line,
        section="Demand",
        json_path="coast_torque_Nm",
    ),
    Quantity(
        key="low_gear_torque",
        name="Low gear torque, J3311",
        symbol="LGT",
        unit="Nm",
        equation="LGT = T · TLGR · TE · SR · TCR · C",
        symbol_meanings={
            "T": "net engine torque",
            "TLGR": "lowest gear ratio",
            "TE": "efficiency, 0.85 manual, 0.80 automatic",
            "SR": "stall ratio of a converter",
            "TCR, C": "ratio and efficiency (0.95) of a transfer case",
        },
        source=SPICER_J3311.with_place("Driveshaft torque"),
        compute=make_whole_line_quantity_function(lambda r: r.demand.low_gear_torque),
        parts=whole_line,
    ),
    Quantity(
        key="wheel_slip_torque",
        name="Wheel slip torque, J3311",
        symbol="WST",
        unit="Nm",
        equation="WST = 0.71 W RR / (0.95 AR);  with RR in inches 12 × 0.95 = 11.4",
        symbol_meanings={"W": "axle capacity", "RR": "rolling radius", "AR": "axle ratio"},
        source=SPICER_J3311.with_place("Driveshaft torque"),
        compute=make_whole_line_quantity_function(lambda r: r.demand.wheel_slip_torque),
        parts=whole_line,
    ),
    Quantity(
        key="speed",
        name="Shaft speed",
        symbol="n",
        unit="rpm",
        equation="n = n_engine / i_gear",
        source=SOUZA_2014_BRACKET_FAILURE.with_place("2.4"),
        compute=make_whole_line_quantity_function(lambda r: r.demand.speed),
        parts=whole_line,
        section="Demand",
        json_path="speed_rpm",
    ),
    Quantity(
        key="axle_load",
        name="Axle load",
        symbol="N",
        unit="N",
        equation="Nr = (W lf − Σ A x) / L,  Nf = W − Nr − Σ A",
        symbol_meanings={
            "W": "weight",
            "lf": "centre of gravity behind the front axle",
            "L": "wheelbase",
            "A, x": "load and place of auxiliary axles on air",
        },
        source=GILLESPIE_1992.with_place("ch. 1"),
        validity="At rest on level ground. A group's axles share its load as the application says.",
        compute=make_whole_line_quantity_function(lambda r: r.demand.axle_load),
        parts=whole_line,
        json_path="axle_load_N",
    ),
    Quantity(
        key="driven_load",
        name="Load on the driven wheels at slip",
        symbol="N′",
        unit="N",
        equation="Nr′ = (Nr + μ sf W h/L) / (1 − μ (sr − sf) h/L)",
        symbol_meanings={
            "μ": "friction",
            "h": "height of the centre of gravity",
            "L": "wheelbase",
            "sf, sr": "driven shares of the front and rear load",
        },
        source=WONG_2008.with_place("ch. 3"),
        validity="All driven wheels slip at once; no air drag or rolling resistance.",
        compute=make_whole_line_quantity_function(lambda r: r.demand.driven_load),
        parts=whole_line,
        json_path="driven_load_N",
    ),
    Quantity(
        key="axle_load_rest",
        name="Axle load at rest",
        symbol="Ni",
        unit="N",
        equation="Nr = (W lf − Σ A x) / L,  Nf = W − Nr − Σ A, each shared by its axles",
        symbol_meanings={
            "W": "weight",
            "lf": "centre of gravity behind the front axle",
            "L": "wheelbase",
            "A, x": "load and place of auxiliary axles on air",
        },
        source=GILLESPIE_1992.with_place("ch. 1"),
        validity="On level ground. The axles of a group share its load as the application says.",
        compute=lambda r: r.axle_loads[0][..., : len(_axles(r))],
        parts=_axles,
        section="Axle loads",
        json_path="axles.rest_N",
    ),
    Quantity(
        key="axle_load_slip",
        name="Axle load at tyre slip",
        symbol="Ni′",
        unit="N",
        equation="Nr′ = (Nr + μ sf W h/L) / (1 − μ (sr − sf) h/L)",
        symbol_meanings={
            "μ": "friction",
            "h": "height of the centre of gravity",
            "L": "wheelbase",
            "sf, sr": "driven shares of the front and rear load",
        },
        source=WONG_2008.with_place("ch. 3"),
        validity="All driven wheels slip at once, on the vehicle's grade; no air drag.",
        compute=lambda r: r.axle_loads[1][..., : len(_axles(r))],
        parts=_axles,
        section="Axle loads",
        json_path="axles.slip_N",
    ),
    Quantity(
        key="axle_to_frame",
        signed=True,
        name="Axle centre to frame",
        symbol="hF",
        unit="mm",
        equation="hF = what the application gives in the reference state − z",
        symbol_meanings={"z": "axle travel"},
        source=SOUZA_2014_BRACKET_FAILURE.with_place("figure 43"),
        compute=make_whole_line_quantity_function(lambda r: r.axle_to_frame),
        parts=whole_line,
        section="Slopes and lengths",
        json_path="axle_to_frame_mm",
    ),
    Quantity(
        key="axle_travel",
        signed=True,
        name="Axle travel",
        symbol="z",
        unit="mm",
        equation="z = spring deflection in the state − in the reference state",
        source=SOUZA_2014_BRACKET_FAILURE.with_place("2.3"),
        validity="Up to the frame is positive.",
        compute=make_whole_line_quantity_function(lambda r: r.demand.travel),
        hidden_if_zero=True,
        parts=whole_line,
        section="Demand",
        json_path="axle_travel_mm",
    ),
    Quantity(
        key="pinion_pitch",
        signed=True,
        name="Pinion pitch",
        symbol="ψ",
        unit="deg",
        equation="ψ = axle torque / wind-up stiffness + pitch of the linkage",
        source=SOURCE_DERIVED,
        validity="From the reference state; the pinion's nose rising is positive.",
        compute=make_whole_line_quantity_function(lambda r: r.demand.pitch),
        hidden_if_zero=True,
        parts=whole_line,
        section="Demand",
    ),
    Quantity(
        key="suspension_frequency",
        name="Suspension frequency",
        symbol="f",
        unit="Hz",
        equation="f = √(k/m) / 2π",
        symbol_meanings={
            "k": "slope of the spring's table at the state",
            "m": "mass the spring carries",
        },
        source=SOUZA_2014_BRACKET_FAILURE.with_place("2.3"),
        validity="1.0 to 1.3 Hz is comfortable.",
        compute=_suspension_frequency,
        parts=_suspended,
        requirements=(NEEDS_SUSPENSION,),
        states=STATE_KINDS_AT_LOADED_RIDE_HEIGHT | STATE_KIND_GROUPS["wound up"],
        section="Demand",
    ),
)
