"""From the joints' couples to the stress at a hot spot: a line, its rubber and its bracket shaken.

One transfer function, damped: the crosses' moments shake the line, whose bearing hangs on
rubber in a bracket that gives (`cardan.physics.loads.rubber_mount`, `MountedLine.with_bracket`);
the force that arrives stresses the bracket as it would at rest, and by what its modes swing beyond
that (`cardan.model.bracket_compliance`). Along the torque of each gear it is the response over
speed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cardan.checks.line_response import LineResponse
from cardan.core.arrays import ComplexArray, FloatArray
from cardan.model.bracket import Bracket
from cardan.model.bracket_compliance import BracketCompliance
from cardan.model.layout import Layout
from cardan.physics.fatigue.critical_plane import normal_stress_on_planes, plane_directions
from cardan.physics.fem.unit_loads import UNIT_LOAD_NAMES
from cardan.physics.loads.centre_bearing import BEARING_FORCE_ORDERS, bearing_forces
from cardan.physics.vehicle.operating_points import TorqueCurves, demand_at_operating_points

_SPEEDS, _NEAR = 60, 25
"""Speeds over the range that shakes most, and round each that meets a mode."""
_BEYOND = 4.0
"""Multiples of the fastest mode on rubber: above them little arrives."""
RIGID_MOUNT_STIFFNESS_RATIO = 100.0
"""Times as stiff as the bracket, from which rubber is as good as rigid."""
_LISTED = 1000.0
"""Hz, up to which modes are reported."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BearingForceSweep:
    """What a bearing hands to its bracket along its torque curves, C of them, at Q speeds.

    Attributes
    ----------
    state
        Where the suspension is: the state in which most arrives.
    gears, directions : C
    speed : (Q,) rad/s
    torque : (C, Q) N m
        nan where a curve has no such speed.
    force_amplitudes, rigid_force_amplitudes : (C, Q, 3, 3) N
        Complex amplitudes of orders 2, 4 and 6 along x, y, z; and as they would be in a
        bracket that does not give.
    frequencies, damping : (m,) Hz, 1
        Of the line on rubber and bracket.
    mode_names : m
        What those modes are called.
    """

    state: str
    gears: tuple[str, ...]
    directions: tuple[str, ...]
    speed: FloatArray
    torque: FloatArray
    force_amplitudes: ComplexArray
    rigid_force_amplitudes: ComplexArray
    frequencies: FloatArray
    damping: FloatArray
    mode_names: tuple[str, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class ForcedResponse:
    """The response of a bracket over speed, at F features.

    Attributes
    ----------
    sweep : BearingForceSweep
    stress : (C, Q, F) Pa
        Amplitude of the normal stress on the plane where it swings most: orders 2, 4 and 6
        where they add up.
    rigid_stress : (C, Q, F) Pa
        The same as if bracket were rigid to the line and at rest to itself.
    """

    sweep: BearingForceSweep
    stress: FloatArray
    rigid_stress: FloatArray

    @property
    def worst(self) -> tuple[int, int, int]:
        """Curve, speed and feature of the highest stress."""
        flat = int(np.nan_to_num(self.stress).argmax())
        c, q, f = np.unravel_index(flat, self.stress.shape)
        return int(c), int(q), int(f)


def has_elastic_mount(response: LineResponse, bracket: Bracket) -> bool:
    """Whether it is given how the bearing hangs in its bracket: no bearing hangs rigidly.

    Then the response at a speed can be computed; else loads are those of rigid supports.
    """
    shaft = response.line.shafts[bracket.bearing - 1]
    bearing = shaft.centre_bearing
    return bearing is not None and (bracket.rubber or bearing.stiffness) is not None


def line_response_on_bracket(
    response: LineResponse, bracket: Bracket, seat: BracketCompliance
) -> LineResponse:
    """Return a line's response with its bearing in a bracket that gives.

    The rubber is that of the bracket, or of a bearing whose bracket is given separately. Where it
    is not, the bearing's stiffness is that of rubber and bracket in series, as the driveline gives
    it, and what is left of it without the bracket is the rubber's; where nothing is left of it the
    bearing is rigid that way.
    """
    k = bracket.bearing - 1
    shafts = list(response.line.shafts)
    bearing = shafts[k].centre_bearing
    assert bearing is not None  # the file counts them
    if bracket.rubber is not None:
        along, across, up = bracket.rubber
        bearing = replace(bearing, stiffness=(up, across), axial_stiffness=along)
    elif bearing.stiffness is not None and bearing.bracket_stiffness is None:
        bearing = replace(bearing, stiffness=_less(bearing.stiffness, seat))
    bearing = replace(bearing, bracket_stiffness=None)  # the seat says it better, its loss too
    shafts[k] = replace(shafts[k], centre_bearing=bearing)
    line = replace(response.line, shafts=tuple(shafts))
    installed = replace(response.demand.installed, line=line)
    asked = replace(response.demand, installed=installed)
    return response.with_inputs(demand=asked, bracket_compliances={k: seat})


def _less(stiffness: tuple[float, float], seat: BracketCompliance) -> tuple[float, float] | None:
    """Return the rubber's stiffness, up and level, of that in series with a bracket.

    Where nothing is left of one it is as good as rigid that way; of both, rigid.
    """
    give = seat.static_compliance[[2, 1], [2, 1]]
    left = 1 / np.array(stiffness) - give
    if not left.max() > 0:
        return None
    up, level = (1 / np.maximum(left, give / RIGID_MOUNT_STIFFNESS_RATIO)).tolist()
    return up, level


def bearing_force_sweep(response: LineResponse, bearing: int) -> BearingForceSweep | None:
    """Return what a bearing hands to its bracket over speed; None where unknown.

    In the state, and up to the speeds, that shake it; `response` has the bracket's seat.
    """
    held = response.mounts.mounted_line
    if held is None or "dynamic" not in response.mount_loads.worst_bearing_forces:
        return None
    worst = response.mount_loads.worst_bearing_forces["dynamic"]
    s = int(np.nan_to_num(worst.results.dynamic[:, bearing]).argmax())
    end = worst.curves.max_speed[:, s]
    if not np.nanmax(end, initial=0.0) > 0:
        return None
    modes = held.select_case(s).modes()
    low = response.line.rigid_body_mode_count  # the rest bends tubes and brackets
    speed = _speeds(modes.frequency, top=float(np.nanmax(end)), low=low)
    drawn = worst.curves.curves_to_draw(s)
    torque, waves = _along(response, speed, worst.curves, drawn, state=s, bearing=bearing)
    stiff = response.with_inputs(bracket_compliances={})
    counted = modes.frequency < 2 * np.pi * _LISTED
    return BearingForceSweep(
        state=response.demand.states[s],
        gears=tuple(worst.curves.gears[k] for k in drawn),
        directions=tuple(worst.curves.directions[k] for k in drawn),
        speed=speed,
        torque=torque,
        force_amplitudes=waves,
        rigid_force_amplitudes=_along(stiff, speed, worst.curves, drawn, state=s, bearing=bearing)[
            1
        ],
        frequencies=modes.frequency[counted] / (2 * np.pi),
        damping=modes.damping_ratio[counted],
        mode_names=tuple(np.array(modes.mode_names())[counted].tolist()),
    )


def _speeds(frequency: FloatArray, *, top: float, low: int) -> FloatArray:
    """Return speeds (Q,) rad/s up to a top, closer where order 2 meets a mode (m,) rad/s."""
    meets = frequency / 2
    near = meets[meets < top, None] * np.linspace(0.85, 1.15, _NEAR)
    far = min(top, _BEYOND * float(meets[:low].max()))
    speed = np.concatenate([
        np.linspace(far / _SPEEDS, far, _SPEEDS), np.linspace(far, top, _SPEEDS // 3), near.ravel()
    ])  # fmt: skip
    return np.unique(speed[speed <= top])


def _along(
    response: LineResponse,
    speed: FloatArray,
    found: TorqueCurves,
    drawn: Sequence[int],
    *,
    state: int,
    bearing: int,
) -> tuple[FloatArray, ComplexArray]:
    """Return torque (C, Q) N m and waves (C, Q, 3, 3) N along curves in one state."""
    curve = np.repeat(np.asarray(drawn), len(speed))
    every = np.full((len(curve), len(response.demand.states)), np.nan)
    every[:, state] = np.tile(speed, len(drawn))
    asked = demand_at_operating_points(response.demand, found, curve=curve, speed=every)
    lies, torque = response.layout_for(asked), asked.torque[:, state]
    held = response.mounts.mounted_line
    carried = bearing_forces(
        Layout(points=lies.points[:, state], directions=lies.directions[:, state]),
        response.line,
        response.phases,
        torque=np.nan_to_num(torque),
        speed=asked.signed_speed[:, state],
        held=None if held is None else held.select_case(state),
        inertias=response.inputs.shaft_inertias,
    )
    waves = np.where(np.isnan(torque)[:, None, None], np.nan, carried.waves[:, bearing])
    shape = (len(drawn), len(speed))
    return torque.reshape(shape), waves.reshape(*shape, *waves.shape[1:])


def largest_normal_stress_amplitude(
    unit: FloatArray,
    normals: FloatArray,
    waves: ComplexArray,
    *,
    speed: FloatArray,
    seat: BracketCompliance | None = None,
    orders: Sequence[int] = BEARING_FORCE_ORDERS,
) -> FloatArray:
    """Return the swing of the normal stress at places, where their planes have it largest.

    Parameters
    ----------
    unit : (F, c, 6) Pa
        Stress of each unit load, and of each mode of the seat.
    normals : (F, 3)
        Of the surface.
    waves : (..., K, 3) N
        Complex amplitudes of the force on the seat at K `orders`.
    speed : (...) rad/s
    seat
        How the bracket swings; None where it is loaded as if each moment lasted.

    Returns
    -------
    (..., F) Pa
        0-to-peak, all orders where they add up.
    """
    stress = normal_stress_on_planes(unit, plane_directions(normals))
    swings = unit.shape[1] - len(UNIT_LOAD_NAMES)
    total = np.zeros((*waves.shape[:-2], *stress.shape[:2]))
    for k, order in enumerate(orders):
        force = waves[..., k, :]
        columns = np.zeros((*force.shape[:-1], len(UNIT_LOAD_NAMES) + swings), dtype=complex)
        columns[..., :3] = force
        if seat is not None:
            beyond = seat.dynamic_increment(force, order * speed)
            columns[..., :3] += beyond[..., :3]
            columns[..., len(UNIT_LOAD_NAMES) :] = beyond[..., 3:]
        total += np.abs(np.einsum("...c,fpc->...fp", columns, stress))
    return total.max(axis=-1)
