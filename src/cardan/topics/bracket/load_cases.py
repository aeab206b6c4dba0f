"""Load cases of a bracket, and the load histories of its duty cycle."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.labels import EvaluationCondition, OperatingPoint
from cardan.model.bracket import FATIGUE_ZONES, FatigueZone
from cardan.physics.fatigue.critical_plane import principal_extremes
from cardan.physics.fem.strain_gauges import RecoveredLoads
from cardan.topics.bracket.forced_response import BearingForceSweep

WIDEST_STRESS_SWING_CASE_NAMES: dict[FatigueZone, str] = {
    zone: f"widest swing, {zone}" for zone in FATIGUE_ZONES
}
"""What a case of a state takes where a zone swings most, if that is not where it stresses most."""


@dataclass(frozen=True)
class BearingLoadCase:
    """A load history on the bearing, (t, 9) as in `cardan.physics.fem.unit_loads.UNIT_LOAD_NAMES`.

    Where `turns` of the shaft or `duration` (s) are known it is one pass of a history that
    repeats, and does damage; else a load by itself. `pass_count` counts passes one after the
    other of which only the worst happens. A case of a state is called after it and the
    `component` it takes of its loads.
    """

    name: str
    loads: FloatArray
    turns: float = np.nan
    duration: float = np.nan
    pass_count: int = 1
    component: str = ""
    operating_point: OperatingPoint | None = None
    """The operating point whose loads these are, where it is not the state's own."""
    is_dynamic: bool = False
    """Whether the bracket answers as it swings: else it is loaded as if each moment lasted."""
    stress_factors: FloatArray | None = None
    """Swing of each feature in contact, (features,), over that by the two ways held."""
    occurs_once: bool = False
    """Whether it is unknown how often it happens: it does no damage."""
    recovered_loads: RecoveredLoads | None = None
    """How its forces were read from gauges; None where they were not."""
    stop_margin: float = np.inf
    """Share of the travel to a stop that rubber has free; negative where its forces, of linear
    rubber, are lower bounds."""
    alternatives: tuple["BearingLoadCase", ...] = ()
    """The same at each operating point: the worst of these is reported."""

    @property
    def when(self) -> EvaluationCondition:
        """The case as an occasion of checks."""
        return EvaluationCondition("case", self.name, self.component)

    @property
    def extreme_loads(self) -> FloatArray:
        """The loads (k, 9) that a mesh is made for: of many points those that go farthest."""
        return (
            principal_extremes(np.concatenate([c.loads for c in self.alternatives]))
            if self.alternatives
            else self.loads
        )

    @property
    def repeats(self) -> bool:
        """Whether it is a pass of something, and no load by itself."""
        return not (self.occurs_once or (np.isnan(self.turns) and np.isnan(self.duration)))


DutyCycleLoadHistories: TypeAlias = Mapping[
    EvaluationCondition, Sequence[tuple[float, BearingLoadCase]]
]
"""The histories of a duty cycle with their shares, in each state that lasts."""


@dataclass(frozen=True, kw_only=True)
class BracketLoads:
    """What a line loads a bracket with that gives under it: cases, duty cycle, over speed."""

    cases: tuple[BearingLoadCase, ...]
    duty: DutyCycleLoadHistories
    sweep: BearingForceSweep | None
