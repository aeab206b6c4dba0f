"""How near shafts come to obstacles where the rubber of their centre bearings meets its stop."""

from collections.abc import Callable

import numpy as np

from cardan.checks.line_inputs import LineInputs
from cardan.core.arrays import FloatArray, IntArray
from cardan.core.lazy_dataclass import dataclass
from cardan.model.layout import Layout
from cardan.physics.loads.centre_bearing import ThrustEffect
from cardan.physics.loads.rubber_mount import MountedLine
from cardan.physics.loads.rubber_stop_contact import round_the_half_turn
from cardan.physics.loads.rubber_stop_receptance import at_places
from cardan.physics.vehicle.clearance import shaft_obstacle_clearances


@dataclass(frozen=True, kw_only=True, eq=False)
class ObstaclesAlongSweeps:
    """Obstacles next to a line at the speeds Q of sweeps C; A pairs of shaft and obstacle.

    Attributes
    ----------
    clearance : (Q, C, A, 5) m
        Free distance at the places of a shaft that may be nearest, on rubber that does not deflect;
        less what thrust of the spline takes of it where the line lies, as on linear rubber.
    away : (Q, C, A, 5, 2 B) 1
        How far each bearing's travel across its shaft takes that place from the obstacle.
    """

    clearance: FloatArray
    away: FloatArray

    def reach(self, travel: FloatArray, place: FloatArray, of: IntArray) -> FloatArray:
        """Return how far shafts reach into obstacles at most, (K, A) m, in K motions.

        `travel` (K, M, 2 B) m are components as `StoppedLine.free` has them, found at `place`
        (K,) of the speeds of the sweeps `of` (K,). Negative is free.
        """
        moved = round_the_half_turn(travel)  # (K, samples, 2 B)
        clearance, away = at_places(self.clearance, place, of), at_places(self.away, place, of)
        left = (  # one by one: there may be many
            (free[..., None] + ways @ moved.mT).min(axis=(-2, -1))
            for free, ways in zip(clearance.swapaxes(0, 1), away.swapaxes(0, 1), strict=True)
        )
        return -np.stack(tuple(left), axis=-1)


def obstacles_along_sweeps(
    inputs: LineInputs,
    laid: Layout,
    *,
    travel: FloatArray,
    thrust: ThrustEffect | None,
    on: MountedLine,
    own: Callable[[FloatArray, int], FloatArray],
) -> ObstaclesAlongSweeps:
    """Return the obstacles of a line laid out at points (P, S), with axle `travel` there, m.

    Parameters
    ----------
    on
        The line on its slowest modes in the states of the sweeps, (C). What its bearings' travel
        leaves open, as flanges that give, stays where it is.
    own
        Takes values (P, S, ...) to the sweeps, (Q, C, ...); with how many axes of their own.
    """
    there = shaft_obstacle_clearances(laid, inputs.line, inputs.obstacles, travel=travel)
    clearance, fraction = own(there.clearance, 3), own(there.shaft_fraction, 3)
    across = np.arange(on.bearing_matrix.shape[-2]) % 3 < 2
    motions = np.linalg.pinv(on.bearing_matrix[..., across, :])  # of a unit of each travel
    ends = on.shaft_end_motion(motions.mT.astype(complex)).real  # (C, 2 B, n-1, 2, 3)
    share, direction = np.stack([1 - fraction, fraction], axis=-1), own(there.direction, 4)
    away = np.einsum("qcsopi,cbsei,qcsope->qcsopb", direction, ends, share, optimize=True)
    if thrust is not None:
        moved = np.stack([own(each, 3) for each in thrust.shaft_ends])
        taken = np.einsum("qcsopi,vqcsei,qcsope->vqcsop", direction, moved, share, optimize=True)
        clearance = clearance + np.minimum(0.0, taken.min(axis=0))
    pairs = clearance.shape[2] * clearance.shape[3]
    return ObstaclesAlongSweeps(
        clearance=clearance.reshape(*clearance.shape[:2], pairs, -1),
        away=away.reshape(*away.shape[:2], pairs, *away.shape[-2:]),
    )
