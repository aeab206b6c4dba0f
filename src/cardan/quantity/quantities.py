"""Every quantity of the program by its key, from the modules that declare them by topic.

A quantity is added in the module of its topic alone: its name, unit, equation and source,
how a line answers it, where tables and the JSON contract hold it.
"""

from cardan.quantity import (
    bearings,
    bracket,
    excitation,
    fatigue,
    geometry,
    room,
    strength,
    vehicle,
    vibration,
)
from cardan.quantity.declared import Quantity

_TOPICS = (vehicle, geometry, excitation, bearings, strength, room, vibration, bracket, fatigue)

QUANTITIES: dict[str, Quantity] = {q.key: q for topic in _TOPICS for q in topic.DECLARED}
"""The declarations by key, in the order tables show them."""

ANSWERED: dict[str, Quantity] = {k: q for k, q in QUANTITIES.items() if q.of is not None}
"""Those that a line in its states answers; studies of their own answer others."""

LIMITABLE: tuple[str, ...] = tuple(k for k, q in QUANTITIES.items() if q.of or q.study)
"""Those that a limit may ask about."""
