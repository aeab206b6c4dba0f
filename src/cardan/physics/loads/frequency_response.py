"""Frequency response of a line on its mounts.

The algebra of `cardan.physics.loads.rubber_mount`.

Matrices (N, N, ...) and vectors (N, ...) have their cases last (`cardan.core.batched_linalg`):
lines have few coordinates, and are evaluated at thousands of speeds.
"""

from math import prod
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import ComplexArray, FloatArray
from cardan.core.batched_linalg import (
    CaseBlockSlices,
    append_column,
    broadcast_cases,
    case_table,
    matrix_product,
    slice_case_block,
    solve,
)
from cardan.core.lazy_dataclass import dataclass

OrderCoupling: TypeAlias = tuple[ComplexArray, ComplexArray | None]
"""How forces of order 2 follow a motion: L (N, n, ...) times R (n, N, ...), or L alone."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DynamicStiffness:
    """A line of N coordinates.

    Attributes
    ----------
    still, lost : (N, N, ...)
        N/m of tubes, rubber and brackets, and what they lose.
    gyroscopic, mass, torsion : (N, N, ...)
        As `MountedLine` has them.
    """

    still: FloatArray
    lost: FloatArray
    gyroscopic: FloatArray
    mass: FloatArray
    torsion: FloatArray

    @property
    def cases(self) -> tuple[int, ...]:
        """The cases of the line."""
        return np.broadcast_shapes(self.still.shape[2:], self.mass.shape[2:], self.lost.shape[2:])

    def case_table(self, cases: tuple[int, ...]) -> FloatArray:
        """Return the matrices of each of C cases in one piece of memory, (C, 5, N, N)."""
        each = self.still, self.lost, self.gyroscopic, self.mass, self.torsion
        return case_table([(m, 2) for m in each], cases).reshape(
            prod(cases), 5, *self.mass.shape[:2]
        )

    def select_cases(self, of: CaseBlockSlices, axes: int) -> "DynamicStiffness":
        """Return the line in a stretch of its cases, as cases of so many axes."""
        return DynamicStiffness(
            still=slice_case_block(broadcast_cases(self.still, axes, of=2), of),
            lost=slice_case_block(broadcast_cases(self.lost, axes, of=2), of),
            gyroscopic=slice_case_block(broadcast_cases(self.gyroscopic, axes, of=2), of),
            mass=slice_case_block(broadcast_cases(self.mass, axes, of=2), of),
            torsion=slice_case_block(broadcast_cases(self.torsion, axes, of=2), of),
        )

    def dynamic_stiffness(
        self, frequency: FloatArray, speed: FloatArray, torque: FloatArray
    ) -> ComplexArray:
        """Return the stiffness at a frequency W rad/s, (N, N, ...) N/m; none is lost at 0."""
        turning = np.sign(frequency) * self.lost + frequency * speed * self.gyroscopic
        still = self.stiffness_under_torque(torque) - frequency**2 * self.mass
        found = np.empty(np.broadcast_shapes(still.shape, turning.shape), dtype=complex)
        found.real, found.imag = still, turning
        return found

    def stiffness_under_torque(self, torque: FloatArray) -> FloatArray:
        """Return the stiffness that a torque leaves, (N, N, ...) N/m."""
        return self.still + torque * self.torsion

    def harmonic_balance(
        self, f0: Any, f2: Any, f4: Any, tie: OrderCoupling, *, speed: Any, torque: Any
    ) -> tuple[FloatArray, ComplexArray, ComplexArray]:
        """Return motions (N, ...) of orders 0, 2 and 4 under forces that follow them.

        Forces (N, ...) where nothing has moved, `f0` real, `f4` None where there is none, and
        how their order 2 follows the motion.
        """
        left, right = tie
        ties = left.shape[1]

        def felt(motion: Any) -> Any:
            return motion if right is None else matrix_product(right, motion)

        def returned(motion: Any) -> Any:
            """Return what a motion does on the order below its own, by way of `left`."""
            return (motion if right is None else matrix_product(np.conj(right), motion)) / 2

        back = np.conj(left)
        above = solve(
            self.dynamic_stiffness(4 * speed, speed, torque),
            left if f4 is None else append_column(left, f4),
        )
        if f4 is not None:
            f2 = f2 + matrix_product(back, returned(above[:, ties]))
        own = returned(above[:, :ties]) / 2
        second = self.dynamic_stiffness(2 * speed, speed, torque)
        second -= matrix_product(back, own if right is None else matrix_product(own, right))
        tied = solve(second, append_column(left, f2))
        own = returned(tied)
        loose = own[:, :ties] if right is None else matrix_product(own[:, :ties], right)
        still = self.stiffness_under_torque(torque) - matrix_product(back, loose).real
        pushed = f0 + matrix_product(back, own[:, ties]).real
        still = solve(still, pushed[:, None])[:, 0]
        twice = matrix_product(tied[:, :ties], felt(still)) + tied[:, ties]
        fourth = matrix_product(above[:, :ties], felt(twice)) / 2
        return still, twice, fourth if f4 is None else fourth + above[:, ties]
