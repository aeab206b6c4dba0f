"""Clearance of a line: obstacles, and travel of its sliding fit."""

from functools import cached_property

import numpy as np

from cardan.checks.line_inputs import LineInputs
from cardan.core.arrays import FloatArray
from cardan.core.lazy_dataclass import dataclass
from cardan.physics.vehicle.clearance import clearances


@dataclass(frozen=True, kw_only=True)
class LineClearances:
    """Free distances and travel left of a line, (..., states)."""

    inputs: LineInputs

    @cached_property
    def obstacle_clearances(self) -> FloatArray:
        """Free distance of shafts and this line's obstacles, (..., n-1, obstacles) m."""
        return clearances(
            self.inputs.layout,
            self.inputs.line,
            self.inputs.obstacles,
            travel=self.inputs.demand.travel,
        )

    @cached_property
    def spline_travel(self) -> FloatArray:
        """Length of the last shaft less that of the reference layout, (...) m."""
        return (
            self.inputs.layout.lengths[..., -1]
            - self.inputs.demand.installed.layout.lengths[..., -1]
        )

    @cached_property
    def spline_travel_margin(self) -> FloatArray:
        """Travel left in the spline, (...) m; nan where its stroke is not given.

        Without a spline, in the joints of the last shaft that plunge.
        """
        spline = self.inputs.line.shafts[-1].spline
        plunge, draw = (spline.plunge, spline.draw) if spline else (None, None)
        if spline is None:
            slides = [
                s.plunge
                for s in self.inputs.joint_sizes[-2:]
                if s and s.plunge is not None and s.kind != "flexible disc"
            ]
            plunge = draw = sum(slides) if slides else None
        travel = self.spline_travel
        left = np.full_like(travel, np.inf)
        left = left if plunge is None else np.minimum(left, plunge + travel)
        left = left if draw is None else np.minimum(left, draw - travel)
        return np.where(np.isinf(left), np.nan, left)

    @property
    def length_taking_discs(self) -> tuple[int, ...]:
        """Flexible discs, from 0, that take up the last shaft's length: nothing else slides."""
        ends = tuple(enumerate(self.inputs.joint_sizes))[-2:]
        slides = any(s and s.kind != "flexible disc" and s.plunge is not None for _, s in ends)
        if slides or self.inputs.line.shafts[-1].spline is not None:
            return ()
        return tuple(k for k, s in ends if s and s.kind == "flexible disc")

    @property
    def disc_axial_utilisation(self) -> FloatArray:
        """What those discs give along the line over what they may, (..., discs) 1; nan if unknown.

        Each has its share by what it may give, so all have the same of it.
        """
        discs = [self.inputs.joint_sizes[k] for k in self.length_taking_discs]
        limits = [s.plunge if s and s.plunge is not None else np.nan for s in discs]
        used = np.abs(self.spline_travel) / sum(limits) if discs else self.spline_travel
        return np.repeat(np.asarray(used)[..., None], len(discs), axis=-1)
