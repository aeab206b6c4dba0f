"""What may be moved of a line, and what the line does when it is: many variants at a time."""

from dataclasses import dataclass

import numpy as np

from cardan.base.arrays import FloatArray, stacked
from cardan.demand.states import Demand
from cardan.model.application import Adjustable
from cardan.model.layout import Layout
from cardan.model.movable import MOVABLES, Moved
from cardan.quantity.response import Response, respond


@dataclass(frozen=True, kw_only=True)
class Move:
    """One thing moved, by how much: metres up or to the right, radians of shim or phase."""

    adjustable: Adjustable
    amount: float

    @property
    def cost(self) -> float:
        """Share of its range that it uses; a turned yoke counts as half a full way."""
        if MOVABLES[self.adjustable.what].choice:
            return 0.5
        bound = self.adjustable.high if self.amount > 0 else self.adjustable.low
        return abs(self.amount / bound)


def adjustables(response: Response) -> tuple[Adjustable, ...]:
    """Return what may be moved in a line: what the application allows, or house practice."""
    application, name = response.application, response.line.name
    if application.adjustables:
        return tuple(a for a in application.adjustables if a.line == name and not a.hold)
    return tuple(
        Adjustable(what=m.key, part=k, low=m.reach[0], high=m.reach[1], line=name)
        for m in MOVABLES.values()
        for k in range(1, m.count(response.line) + 1)
    )


def tried(response: Response, movable: tuple[Adjustable, ...], amounts: FloatArray) -> Response:
    """Return the response of a line with each thing moved by its amount, (V, movable) SI.

    Of one variant, (movable,), it has no axis of variants.
    """
    moved = Moved.still(response.line, variants=len(np.atleast_2d(amounts)))
    for adjustable, amount in zip(movable, np.atleast_2d(amounts).T, strict=True):
        MOVABLES[adjustable.what].move(moved, adjustable.part, amount)
    shift, shim, phases = moved.bearing_shift, moved.shim, moved.phases
    if amounts.ndim == 1:
        shift, shim, phases = shift[0], shim[0], phases[0]

    def lay(demand: Demand) -> Layout:
        return demand.corrected(bearing_shift=shift, shim=shim)

    return respond(
        response.application,
        response.demand,
        lay=lay,
        phases=stacked(response.line.phases) + phases,
    )
