"""What may be moved of a line, and what the line does when it is: many variants at a time."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cardan.base.arrays import FloatArray, stacked
from cardan.demand.motion import Ride, moved
from cardan.demand.states import Demand, demand, resolve
from cardan.model.application import Adjustable, Application
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


def in_states(response: Response, states: Sequence[int]) -> Response:
    """Return the response of a line as installed, in some of its states alone."""
    application = response.application
    some = replace(application, states=tuple(application.states[s] for s in states))
    return respond(some, demand(resolve(some, response.demand.installed)))


def tried(response: Response, movable: tuple[Adjustable, ...], amounts: FloatArray) -> Response:
    """Return the response of a line with each thing moved by its amount, (V, movable) SI.

    Of one variant, (movable,), it has no axis of variants.
    """
    by = _by(response, movable, np.atleast_2d(amounts))
    shift, shim, phases = by.bearing_shift, by.shim, by.phases
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


def corrected(
    response: Response, movable: tuple[Adjustable, ...], amounts: FloatArray
) -> Application:
    """Return the application with things of a line moved by these amounts (movable), SI.

    Its layouts, yoke phases and pinion are as a file would say them after the correction, for
    studies that ask the application anew. Not so its spline: what travel is left in one
    counts from where the line was first installed, and the driveline's own answer is `tried`.
    """
    by = _by(response, movable, amounts[None])
    shift, shim = by.bearing_shift[0, 0], float(by.shim[0, 0])
    application, installed = response.application, response.demand.installed
    axle, line = installed.axle, installed.line
    x, z = axle.pinion_joint if axle else (0.0, 0.0)
    arm = np.array([x, 0.0, z])

    def after(layout: Layout) -> Layout:
        return moved(layout, line, bearing_shift=shift, pinion_pitch=shim, pinion_arm=arm)

    layout = after(installed.layout)
    turned, _, raised = Ride(pitch=shim).carried(arm, arm)[1].tolist()
    shafts = [
        replace(s, phase=s.phase + float(turn))
        for s, turn in zip(line.shafts, by.phases[0, 0], strict=True)
    ]
    shafts[-1] = replace(shafts[-1], length=float(layout.lengths[..., -1]))
    new = replace(
        installed,
        line=replace(line, shafts=tuple(shafts)),
        layout=layout,
        axle=axle and replace(axle, pinion_joint=(turned, raised)),
    )
    return replace(
        application,
        lines=tuple(new if i is installed else i for i in application.lines),
        states=tuple(
            replace(s, layouts={n: after(o) if n == line.name else o for n, o in s.layouts.items()})
            if s.layouts
            else s
            for s in application.states
        ),
    )


def _by(response: Response, movable: tuple[Adjustable, ...], amounts: FloatArray) -> Moved:
    """Return how far things of a line move with amounts (V, movable)."""
    by = Moved.still(response.line, variants=len(amounts))
    for adjustable, amount in zip(movable, amounts.T, strict=True):
        MOVABLES[adjustable.what].move(by, adjustable.part, amount)
    return by
