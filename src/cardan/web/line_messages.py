"""Messages about a line as the workbench draws it: geometry, parts, phasors, rings of limits."""

from typing import Any

import numpy as np

from cardan.application.layout_writer import yaml_address_of_part_name, yaml_address_of_yoke_phase
from cardan.application.yaml_edit import YamlEditor
from cardan.checks.line_response import LineResponse
from cardan.core.units import deg, mm, rpm
from cardan.model.application import InstalledLine
from cardan.model.layout import Layout
from cardan.model.parts import Line, Shaft
from cardan.physics.kinematics.equivalent_angle import ae7_phasor_terms
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.render.i18n import Translator
from cardan.topics.design.drag_handles import STUB_SHAFT_TO_LINE_LENGTH_RATIO
from cardan.web import correction_handlers as changes
from cardan.web.parsed_document import (
    Json,
    round_decimals,
    round_decimals_list,
    round_significant_list,
)

QUARTER_TURN = 1
"""Index, among four angles of a turn, at which the gearbox's yoke is upright."""


def state_row(r: LineResponse, s: int, say: Translator) -> Json:
    """Return a state: its name, its words, its kind."""
    name = r.demand.states[s]
    return {"name": name, "said": say.state(name), "kind": r.state_kinds[s]}


def line_message(r: LineResponse, text: YamlEditor, say: Translator) -> Json:
    """Return a line: what it consists of, where that stands in a text, and where it runs."""
    line = r.line
    return {
        "name": line.name,
        "tubes": [round_decimals(s.tube.outer / mm) if s.tube else None for s in line.shafts],
        "tube_names": [_tube_text(s, say) for s in line.shafts],
        "joints": [s.name if s else "" for s in r.joint_sizes],
        **_part_addresses(r.demand.installed, text),
        "movable": changes.adjustable_parameters_json(r, say),
        "obstacles": [r.application.obstacles.index(o) for o in r.inputs.obstacles],
        **moving_numbers(r),
    }


def moving_numbers(r: LineResponse) -> Json:
    """Return what of a line moves with a hand: where it runs, as installed and in each state."""
    installed = r.demand.installed
    return {
        "installed": layout_message(installed.layout, installed),
        "states": [layout_message(r.layout[s], installed) for s in range(len(r.demand.states))],
        "phases": [round(s.phase / deg, 3) for s in r.line.shafts],
        "angles": round_decimals_list(r.joint_angles / deg, 3),
        "side_angles": round_decimals_list(r.kinematics.side_angles / deg, 3),
        "top_angles": round_decimals_list(r.kinematics.top_angles / deg, 3),
        "positions": round_decimals_list(r.kinematics.joint_plane_positions / deg, 1),
        "side": round_decimals_list(r.layout.side / deg, 3),
        "top": round_decimals_list(r.layout.top / deg, 3),
        "lengths": round_decimals_list(r.layout.lengths / mm, 1),
        "plunge": round_decimals_list(r.clearances.spline_travel / mm, 4),
        "travel": round_decimals_list(r.demand.travel / mm, 2),
        "torque": round_significant_list(r.demand.torque),
        "speed": round_significant_list(r.demand.speed / rpm),
        "clearance": [round_decimals_list(c / mm, 4) for c in r.clearances.obstacle_clearances],
        "phasors": phasor_numbers(r),
        "equivalent": round_decimals_list(r.kinematics.excitation.torsional.angle / deg, 3),
        "rings": [_limit_rings(r, s) for s in range(len(r.demand.states))],
    }


def _part_addresses(of: InstalledLine, text: YamlEditor) -> Json:
    """Return where phases and names of parts stand in a text, and which; "" where none does."""
    shafts, joints = range(1, len(of.line.shafts) + 1), range(1, of.line.joint_count + 1)
    tubes = [yaml_address_of_part_name(of, text, shaft=k) for k in shafts]
    sizes = [yaml_address_of_part_name(of, text, joint=k) for k in joints]
    return {
        "phase_at": [yaml_address_of_yoke_phase(of, k, text) for k in shafts],
        "tube_at": tubes,
        "tube_now": [text.scalar_text(at) or "" for at in tubes],
        "joint_at": sizes,
        "joint_now": [text.scalar_text(at) or "" for at in sizes],
    }


def _tube_text(shaft: Shaft, say: Translator) -> str:
    """Return a shaft's tube as drawings name it: 120 × 4; nothing where none is known."""
    if shaft.tube is None:
        return ""
    return (
        f"{say.compact_number(shaft.tube.outer / mm)} × {say.compact_number(shaft.tube.wall / mm)}"
    )


def layout_message(layout: Layout, installed: InstalledLine) -> Json:
    """Return a layout (n, 3): joints, bearings, ends of the stubs at gearbox and pinion, mm.

    And the two pin axes of each cross, with the gearbox's yoke upright.
    """
    p, d = layout.points, layout.directions
    stub = STUB_SHAFT_TO_LINE_LENGTH_RATIO * float(np.linalg.norm(p[-1] - p[0]))
    bearings = [
        p[k] - s.centre_bearing.from_rear_joint * d[k]
        for k, s in enumerate(installed.line.shafts, 1)
        if s.centre_bearing
    ]
    return {
        "joints": round_decimals_list(p / mm, 2),
        "bearings": [round_decimals_list(b / mm, 2) for b in bearings],
        "ends": [
            round_decimals_list((p[0] - stub * d[0]) / mm, 2),
            round_decimals_list((p[-1] + stub * d[-1]) / mm, 2),
        ],
        "pins": _pin_axes(layout, installed.line),
    }


def _pin_axes(layout: Layout, line: Line) -> list[list[list[float]]]:
    """Return the driving and the driven pin axis of each joint, unit vectors; none of no cross."""
    d = layout.directions
    turn = rotate_chain(d, phases=[s.phase for s in line.shafts], crosses=line.is_cross, samples=4)
    driving = turn.driving_pins[:, QUARTER_TURN]
    driven = np.cross(d[1:], driving)
    driven /= np.linalg.norm(driven, axis=-1, keepdims=True)
    pins: list[list[list[float]]] = round_decimals_list(np.stack([driving, driven], axis=1), 4)
    return [both if kind else [] for both, kind in zip(pins, line.is_cross, strict=True)]


def phasor_numbers(r: LineResponse) -> Any:
    """Return where the joints' sum gets to one by one in each state, (states, joints + 1, 2).

    As AE-7 has it, deg² along 0 and 45 deg.
    """
    side, top, phases = r.kinematics.phasor_angles
    ends = np.cumsum(ae7_phasor_terms(side, top, phases=phases), axis=-1) / deg**2
    ends = np.concatenate([np.zeros_like(ends[..., :1]), ends], axis=-1)
    return round_decimals_list(np.stack([ends.real, ends.imag], axis=-1), 3)


def _limit_rings(r: LineResponse, s: int) -> list[Json]:
    """Return how large the sum may be at a state's speed, deg², by the grade it begins."""
    speed = float(r.demand.speed[s])
    if not speed > 0:
        return []
    return [
        {"grade": grade, "radius": round_decimals(bound / speed**2 / deg**2, 3)}
        for limit in r.application.limits
        if limit.quantity == "torsional_acceleration"
        for grade, bound in (("warn", limit.normal), ("fail", limit.maximum))
        if bound is not None
    ]


def obstacle_message(o: Any) -> Json:
    """Return an obstacle: its name, where it stands, its size."""
    return {
        "name": o.name,
        "line": o.line,
        "radius": round_decimals(o.radius / mm, 2),
        "share": o.travel_share,
        "start": [round_decimals(x / mm, 2) for x in o.start],
        "end": [round_decimals(x / mm, 2) for x in o.end],
    }
