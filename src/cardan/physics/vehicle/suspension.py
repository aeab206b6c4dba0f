"""Where the suspension puts the axle: spring, height in each state, its path, wind-up.

Deflection counts from the free spring, in its direction of load; the axle rises by as much
towards the frame. Motions are in the vehicle's frame, x rearward and z up; pitch is of the
pinion's nose, and of wind-up about y.
"""

from math import nan

import numpy as np

from cardan.core.arrays import ArrayLike, BoolArray, FloatArray, stack_on_last_axis
from cardan.core.compiled import POINT_LOOP_CASE_FACTOR, is_compiled_batch
from cardan.core.errors import DesignError, values_of_first_violating_case
from cardan.core.units import g, inch, mm
from cardan.model.vehicle import Linkage, Spring, Suspension, SuspensionState
from cardan.physics.vehicle.compiled_squat import SquatKernel, squat_kernel

COMFORT_FREQUENCY_RANGE_HZ = (1.0, 1.3)
"""Natural frequencies people bear best, Hz. Source: Souza (2014), 2.3, after SAE AE-11."""

OVERLOAD_STATE_AXLE_LOAD_FACTOR = 1.1
"""Load of the overload state over the axle's rating. Source: Souza (2014), figure 13."""

SQUAT_ITERATIONS = 14
"""Steps in which an axle finds where its springs hold what pulls: of a link of 0.5 m on leaf
springs each is a fifth of the last, and the last one 1e-12 m."""

POSITION_TOLERANCE_M = 0.5 * mm
"""How far past a stop a height counts as on it."""

STATES_AT_SUSPENSION_TRAVEL_LIMIT = ("full rebound", "rebound", "jounce")
"""States in which the spring's travel, not the axle's load, says where the axle is."""


def _through(x: ArrayLike, xs: ArrayLike, ys: ArrayLike) -> FloatArray:
    """Values (...) at x of tables (..., points) joined by straight lines.

    Their outer slopes go on beyond their ends.
    """
    x, xs, ys = (np.asarray(a, dtype=float) for a in (x, xs, ys))
    slopes, lines = np.diff(ys) / np.diff(xs), xs.shape[-1] - 1
    found = np.broadcast_to(ys[..., 0], np.broadcast_shapes(x.shape, ys.shape[:-1]))
    for k in range(lines):  # how far x has come along each; the outer ones have no outer end
        along = x - xs[..., k]
        if k > 0:
            along = np.maximum(along, 0.0)
        if k + 1 < lines:
            along = np.minimum(along, xs[..., k + 1] - xs[..., k])
        found = found + slopes[..., k] * along
    return found


def spring_load(spring: Spring, deflection: ArrayLike) -> FloatArray:
    """Load of one spring, (...) N, at deflections (...) m; negative where it is pulled."""
    return _through(
        deflection, stack_on_last_axis(spring.deflection), stack_on_last_axis(spring.load)
    )


def spring_deflection(spring: Spring, load: ArrayLike) -> FloatArray:
    """Deflection of one spring, (...) m, under loads (...) N."""
    return _through(load, stack_on_last_axis(spring.load), stack_on_last_axis(spring.deflection))


def spring_table_rates(spring: Spring) -> FloatArray:
    """Rate of a spring between the points of its table, (..., points - 1) N/m."""
    return np.diff(stack_on_last_axis(spring.load)) / np.diff(stack_on_last_axis(spring.deflection))


def spring_rate(spring: Spring, deflection: ArrayLike, *, amplitude: float = 1 * mm) -> FloatArray:
    """Rate of a spring about deflections (...) m, (...) N/m.

    The mean over plus and minus an amplitude (m): the table's slope, and continuous across
    its corners, where the drawing's own load points so often lie.
    """
    deflection = np.asarray(deflection, dtype=float)
    span = spring_load(spring, deflection + amplitude) - spring_load(spring, deflection - amplitude)
    return span / (2 * amplitude)


def natural_frequency(spring: Spring, load: ArrayLike) -> FloatArray:
    """Frequency in Hz at which the mass on a spring bounces, (...), under loads (...) N.

    f = √(k/m) / 2π, with k the table's rate there and m = load/g: the mass the spring holds.

    Notes
    -----
    Small motion; neither tyres, dampers nor friction between leaves.
    `COMFORT_FREQUENCY_RANGE_HZ` is the band
    to aim at. Source: Souza (2014), section 2.3.
    """
    load = np.asarray(load, dtype=float)
    rate = spring_rate(spring, spring_deflection(spring, load))
    return np.sqrt(rate * g / load) / (2 * np.pi)


def load_per_spring(suspension: Suspension, axle_load: ArrayLike) -> FloatArray:
    """Load on each spring, (...) N, of an axle that loads the ground with (...) N."""
    axle_load = np.asarray(axle_load, dtype=float)
    return (axle_load - suspension.unsprung_mass * g) / suspension.springs_per_axle


def deflection_in_state(
    suspension: Suspension, state: SuspensionState, *, axle_load: ArrayLike = nan
) -> FloatArray:
    """Deflection of the springs in a named state, (...) m.

    Parameters
    ----------
    suspension
        Springs, unsprung mass, and where check strap or bump stop act.
    state
        Full rebound: the axle hangs on the springs, or as far down as
        rebound at least. Rebound: spring free, and one inch more. `jounce`: the bump stop, or
        the end of the spring's table, metal to metal. Curb, empty, gvw, overload: under the
        axle's load. Wind-up: as high as its load state has it.
    axle_load : (...) N
        Load of the axle on the ground (overload included); unused in states of
        `STATES_AT_SUSPENSION_TRAVEL_LIMIT`.

    Raises
    ------
    DesignError
        If the state needs an axle load that is not known (nan), or a stop that is not given.

    Notes
    -----
    Source: Souza (2014), section 2.3 and figure 13.
    """
    spring = suspension.spring
    if state == "jounce":
        if (stop := _bump_stop(suspension)) is None:
            msg = "state `jounce` needs `jounce_deflection`: a spring given by rates has no end"
            raise DesignError(msg)
        return stop
    if state in STATES_AT_SUSPENSION_TRAVEL_LIMIT:
        inch_more = spring_deflection(spring, 0.0) - inch
        hanging = spring_deflection(spring, load_per_spring(suspension, 0.0))
        given = suspension.full_rebound_deflection
        lowest = np.minimum(hanging, inch_more) if given is None else np.asarray(given)
        return lowest if state == "full rebound" else np.maximum(inch_more, lowest)
    if np.isnan(axle_load).any():
        msg = f"suspension state {state} needs the axle's load: give the vehicle a load state"
        raise DesignError(msg)
    return spring_deflection(spring, load_per_spring(suspension, axle_load))


def _bump_stop(suspension: Suspension) -> FloatArray | None:
    """Return the deflection, (...) m, at which springs stop; None if not given."""
    given, spring = suspension.jounce_deflection, suspension.spring
    if given is None and not spring.ends:
        return None
    return np.asarray(spring.deflection[-1] if given is None else given)


def is_beyond_suspension_stops(suspension: Suspension, stands: FloatArray) -> BoolArray:
    """Return where springs deflected by (...) m stand beyond check strap or bump stop."""
    stop, strap = _bump_stop(suspension), suspension.full_rebound_deflection
    most = np.inf if stop is None else stop + POSITION_TOLERANCE_M
    least = -np.inf if strap is None else strap - POSITION_TOLERANCE_M
    return (stands > most) | (stands < least)


def tyre_load_at_travel_limit(suspension: Suspension, state: SuspensionState) -> FloatArray:
    """Return what an axle's tyres carry at a limit of its travel, (...) N; none pulls.

    What its springs bear there, and its own weight. At a bump stop it may be more.
    """
    springs = suspension.springs_per_axle * spring_load(
        suspension.spring, deflection_in_state(suspension, state)
    )
    weight = suspension.unsprung_mass * g
    borne = springs + weight
    return np.where(borne > 1e-9 * weight, borne, 0.0)  # what hangs has rounding alone


def axle_path(linkage: Linkage, travel: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Rearward motion dx (...) m and pitch (...) rad of an axle that rises by `travel` (...) m.

    All from the reference state, where travel is zero and so is what this returns. The link
    turns about its pivot ahead of the axle, sin a = sin a₀ − travel/R and
    dx = R (cos a − cos a₀); a table is joined by straight lines and goes on beyond its ends.

    Raises
    ------
    DesignError
        If the travel is more than the link can follow.
    """
    travel = np.asarray(travel, dtype=float)
    if linkage.travel:
        rises = stack_on_last_axis(linkage.travel)
        dx, pitch = (
            _through(travel, rises, stack_on_last_axis(column))
            - _through(0.0, rises, stack_on_last_axis(column))
            if column
            else np.zeros_like(travel)
            for column in (linkage.dx, linkage.pitch)
        )
        return dx, pitch
    pitch = linkage.pitch_rate * travel
    if linkage.radius is None:
        return np.zeros_like(travel), pitch
    sine = np.sin(linkage.angle) - travel / linkage.radius
    if wrong := values_of_first_violating_case(np.abs(sine) <= 1, linkage.radius, travel):
        msg = (
            f"a link of radius {wrong[0] / mm:g} mm cannot follow an axle travel of "
            f"{wrong[1] / mm:g} mm"
        )
        raise DesignError(msg, about="linkage")
    return linkage.radius * (np.sqrt(1 - sine**2) - np.cos(linkage.angle)), pitch


def squat_travel(
    suspension: Suspension,
    travel: ArrayLike,
    *,
    axle_load: ArrayLike,
    drawn: ArrayLike,
    force: ArrayLike,
    torque: ArrayLike,
    ahead: float = 1.0,
    stands: ArrayLike = np.nan,
) -> FloatArray:
    r"""Return how much further an axle rises towards the frame as its tyres pull, (...) m.

    The springs carry what the force moves onto the axle, and what it and its torque do along
    the axle's path: n (S(d + z) - S(d)) = N - F x'(z) + M φ'(z), with x and φ of `axle_path`.

    Parameters
    ----------
    suspension
        Springs, stops, and the path.
    travel : (...) m
        Where the axle is at rest: its load has it there, or it is held.
    axle_load, drawn : (...) N
        That load, and what the force moves onto the axle, N.
    force : (...) N
        With which its tyres push the vehicle ahead, F.
    torque : (...) N m
        On its housing, as `windup` has it, M.
    ahead
        -1 of a pinion that faces rearward: its nose sinks where others rise.
    stands : (...) m
        Deflection of its springs there, which need not be what its load says; nan if unknown.

    Notes
    -----
    Quasi-static. The gears lock the wheels to the housing while the driveline stands still, so
    F works where the tyre meets the ground: as F at the wheel's centre and M = F r. Between the
    stops; a state whose load is beyond one stays there, but one past the end of its spring's
    table has none. Derived by virtual work; load transfer as in Gillespie, Fundamentals of Vehicle
    Dynamics (1992), ch. 7 (anti-squat).
    """
    z0, at_rest = np.asarray(travel, dtype=float), np.asarray(axle_load, dtype=float)
    each = suspension.springs_per_axle
    borne = load_per_spring(suspension, at_rest)
    moved, pulls, turns = (np.asarray(v, dtype=float) for v in (drawn, force, torque))
    start = spring_deflection(suspension.spring, borne)
    there = np.where(np.isnan(stands), start, stands)
    lowest = np.minimum(deflection_in_state(suspension, "full rebound") - there, 0.0)
    highest, stop = np.inf, _bump_stop(suspension)
    if stop is not None:
        past = (there > stop) & (suspension.jounce_deflection is None)
        highest = np.where(past, np.inf, np.maximum(stop - there, 0.0))
    shape = np.broadcast_shapes(z0.shape, start.shape, *map(np.shape, (moved, pulls, turns)))
    # Of points, variants and states: points of one design are too few to load a compiler for.
    many = (
        len(shape) > 2
        and is_compiled_batch(shape[-2:], points=POINT_LOOP_CASE_FACTOR)
        and _is_one_link(suspension)
    )
    kernel = squat_kernel() if many else None
    if kernel is not None:
        turned = ahead * turns * suspension.linkage.pitch_rate
        rows = z0, borne + (moved + turned) / each, pulls / each, start, lowest, highest
        return _squat_by_loop(kernel, suspension, rows, shape)
    gone = np.zeros(shape)
    for _ in range(SQUAT_ITERATIONS):
        dx, pitch = _path_slopes(suspension.linkage, z0 + gone)
        pushed = moved - pulls * dx + ahead * turns * pitch
        there = spring_deflection(suspension.spring, borne + pushed / each)
        gone = np.clip(there - start, lowest, highest)
    return gone


def _is_one_link(suspension: Suspension) -> bool:
    """Return whether an axle's path is that of a link, and it and the spring are of all cases."""
    link, spring = suspension.linkage, suspension.spring
    numbers = (link.radius, link.angle, link.pitch_rate, *spring.load, *spring.deflection)
    return not link.travel and all(v is None or np.ndim(v) == 0 for v in numbers)


def _squat_by_loop(
    kernel: SquatKernel,
    suspension: Suspension,
    rows: tuple[FloatArray | float, ...],
    shape: tuple[int, ...],
) -> FloatArray:
    """Return `squat_travel` (...) m of a compiled loop, of rows as it has them, of a `shape`."""
    link, spring = suspension.linkage, suspension.spring
    cases = np.empty((len(rows), *shape))
    for into, values in zip(cases, rows, strict=True):
        into[...] = values
    load, deflection = np.array(spring.load, float), np.array(spring.deflection, float)
    begins, count = np.diff(load), len(load) - 1
    least, most = np.zeros(count), begins.copy()
    least[0], most[-1] = -np.inf, np.inf  # outer slopes go on
    lines = np.stack([load[:-1], np.diff(deflection) / begins, least, most])
    sine, inverse = (0.0, 0.0) if link.radius is None else (np.sin(link.angle), 1 / link.radius)
    gone = np.empty(shape)
    kernel(
        cases.reshape(len(rows), -1), lines, np.array([sine, inverse, deflection[0]]),
        SQUAT_ITERATIONS, gone.reshape(-1),
    )  # fmt: skip
    return gone


def _path_slopes(linkage: Linkage, travel: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return dx/dz (...) 1 and dpitch/dz (...) rad/m of `axle_path`; of tables about 1 mm."""
    if linkage.travel:
        before, after = (axle_path(linkage, travel + k * mm) for k in (-1, 1))
        dx, pitch = ((b - a) / (2 * mm) for a, b in zip(before, after, strict=True))
        return dx, pitch
    pitch = linkage.pitch_rate * np.ones_like(travel)
    if linkage.radius is None:
        return np.zeros_like(travel), pitch
    sine = np.sin(linkage.angle) - travel / linkage.radius
    return sine / np.sqrt(1 - sine**2), pitch


def axle_windup(torque: ArrayLike, *, stiffness: ArrayLike) -> FloatArray:
    """Pitch (...) rad of an axle under torques (...) N m on its housing, about y.

    Rolling ahead the wheels turn about -y, so traction turns the housing about +y: a pinion
    that faces forward rises, one that faces rearward sinks. Brakes do the opposite.

    The torque is that of the wheels, i η times the pinion's; the pinion's own reaction is
    about its axis, rolls the axle and does not pitch it.

    Notes
    -----
    Quasi-static, springs linear in wind-up. Derived: moments on the housing.
    """
    return np.asarray(torque, dtype=float) / np.asarray(stiffness)
