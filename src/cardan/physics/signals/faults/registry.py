"""The kinds of fault that there are: one line a module, in the order in which they are listed."""

from cardan.physics.signals.faults import (
    duplicate_blocks,
    gain_change,
    intermittent_contact,
    lost_response,
    mains_hum,
    rectified,
    stuck_bit,
    value_steps,
    waveform,
    whole_channel,
)

FAULT_SOURCES = (
    value_steps.FAULT_SOURCE,
    waveform.FAULT_SOURCE,
    rectified.FAULT_SOURCE,
    gain_change.FAULT_SOURCE,
    lost_response.FAULT_SOURCE,
    intermittent_contact.FAULT_SOURCE,
    duplicate_blocks.FAULT_SOURCE,
    whole_channel.DRIFT_SOURCE,
    mains_hum.FAULT_SOURCE,
    whole_channel.CONTRADICTION_SOURCE,
    stuck_bit.FAULT_SOURCE,
)
"""What declares kinds; if two find the same kind in a channel, the later one counts."""

FAULTS_BY_CODE = {kind.code: kind for source in FAULT_SOURCES for kind in source.kinds}
FAULT_KINDS = tuple(FAULTS_BY_CODE)
FAULTS_OF_ANY_CHANNEL = tuple(k for k, of in FAULTS_BY_CODE.items() if of.of_any_channel)
"""What is no value in any channel; all else is of a gauge, that swings about a zero of its own."""
IMPOSSIBLE_STRESS_FAULTS = tuple(k for k, of in FAULTS_BY_CODE.items() if of.impossible)
"""What a gauge's stress cannot be, if all was said as it is: of it there is no damage without."""
MASKABLE_FAULTS = tuple(k for k, of in FAULTS_BY_CODE.items() if of.maskable)
"""What a hole can be made of: what a clip cut off, and where a drift began, is unknown."""
CORRECTABLE_FAULTS = tuple(k for k, of in FAULTS_BY_CODE.items() if of.correctable)
"""What makes no hole: it is taken off, and the rest is what was measured."""
MASKABLE_OR_CORRECTABLE_FAULTS = (*MASKABLE_FAULTS, *CORRECTABLE_FAULTS)
"""What a rule can take out."""
