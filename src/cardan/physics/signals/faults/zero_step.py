"""Steps of the zero: from some sample on the level is another, and the signal goes on as before."""

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray
from cardan.physics.signals.faults.fault_kind import FaultKind
from cardan.physics.signals.faults.intervals import FaultIntervals

FAULT_ZERO_SHIFT = "zero-step"


def cumulative_offset_of_zero_steps(steps: FaultIntervals, samples: ArrayLike) -> FloatArray:
    """Return what steps of the zero have added up to at samples (n,)."""
    total = np.append(0.0, np.cumsum(steps.sizes))
    return total[np.searchsorted(steps.runs[:, 0], np.asarray(samples), side="right")]


def without_zero_steps(x: FloatArray, start: int, steps: FaultIntervals) -> FloatArray:
    """Return samples (n,) from `start` on with steps of the zero taken off."""
    return x - cumulative_offset_of_zero_steps(steps, np.arange(start, start + x.size))


KIND = FaultKind(code=FAULT_ZERO_SHIFT, correction=without_zero_steps, correctable=True)
