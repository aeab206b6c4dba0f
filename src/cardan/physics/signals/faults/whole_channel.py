"""Kinds of fault of a channel or gauge as a whole, which no detector of this package finds.

A channel's levels show whether it drifts (`ChannelReport.drifts`); what was said of a gauge shows
whether its stress is possible (`DeclaredRecordingProperties.contradictions`).
"""

from cardan.physics.signals.faults.fault_kind import FaultKind, FaultSource

FAULT_DRIFT, FAULT_UNIT, FAULT_RATE, FAULT_ABOVE_TENSILE_STRENGTH = (
    "drift",
    "unit",
    "rate",
    "strength",
)

DRIFT_SOURCE = FaultSource(kinds=(FaultKind(code=FAULT_DRIFT),))
CONTRADICTION_SOURCE = FaultSource(
    kinds=tuple(
        FaultKind(code=code, impossible=True)
        for code in (FAULT_UNIT, FAULT_RATE, FAULT_ABOVE_TENSILE_STRENGTH)
    )
)
