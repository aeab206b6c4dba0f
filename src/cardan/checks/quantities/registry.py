"""Every quantity of the program by its key, from the modules that declare them by topic.

A quantity is added in the module of its topic alone: its name, unit, equation and source,
how a line answers it, where tables and the JSON contract hold it.
"""

from cardan.checks.quantities import (
    bearings,
    bracket,
    excitation,
    fatigue,
    geometry,
    strength,
    vehicle,
    vibration,
)
from cardan.checks.quantities import clearance as room
from cardan.checks.quantities.declaration import Quantity

_TOPICS = (vehicle, geometry, excitation, bearings, strength, room, vibration, bracket, fatigue)

QUANTITIES: dict[str, Quantity] = {q.key: q for topic in _TOPICS for q in topic.DECLARATIONS}
"""The declarations by key, in the order tables show them."""

LINE_QUANTITIES: dict[str, Quantity] = {
    k: q for k, q in QUANTITIES.items() if q.compute is not None
}
"""Those that a line in its states answers; studies of their own answer others."""

LIMITABLE_QUANTITIES: tuple[str, ...] = tuple(
    k for k, q in QUANTITIES.items() if q.compute or q.study
)
"""Those that a limit may apply to."""
