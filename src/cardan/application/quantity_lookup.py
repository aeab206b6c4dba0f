"""Declarations of quantities by key, imported when first needed.

A recording without limits names no quantity; it does not wait for the physics of a driveline,
which the declarations compute with.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cardan.checks.quantities.declaration import Quantity


def declared_quantity(key: str) -> "Quantity":
    """Return the declaration of a quantity."""
    from cardan.checks.quantities.registry import QUANTITIES

    return QUANTITIES[key]
