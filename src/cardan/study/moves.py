"""What may be moved of a line, and what the line does when it is: many variants at a time."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from cardan.base.arrays import FloatArray, apart, stacked
from cardan.base.frozen import dataclass
from cardan.base.units import Metre, Radian
from cardan.demand.motion import Ride, moved
from cardan.demand.states import Demand, demand, resolve
from cardan.loads.rubber import LOSS
from cardan.model.application import Adjustable, Application
from cardan.model.layout import Layout
from cardan.model.movable import MOVABLES, Moved, movable
from cardan.model.parts import CentreBearing
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


UNMEASURED = ("phase", "shim")
"""What can be moved of a line that is known by its slopes alone."""


def adjustables(response: Response) -> tuple[Adjustable, ...]:
    """Return what may be moved in a line: what the application allows, or house practice."""
    application, name = response.application, response.line.name
    if application.adjustables:
        return tuple(a for a in application.adjustables if a.line == name and not a.hold)
    return tuple(
        Adjustable(
            what=m.key, part=k, low=m.reach[0], high=m.reach[1], line=name, step=m.resolution
        )
        for m in MOVABLES.values()
        if not m.fitted and (response.line.measured or m.key in UNMEASURED)
        for k in range(1, m.count(response.line) + 1)
    )


def movables(response: Response) -> tuple[Adjustable, ...]:
    """Return everything that can be moved in a line: as far as its file allows, or by practice."""
    name = response.line.name
    said = {(a.what, a.part): a for a in response.application.adjustables if a.line == name}
    return tuple(said.get((a.what, a.part), a) for a in movable([response.line]).values())


def fitted(response: Response) -> tuple[Adjustable, ...]:
    """Return what other mounts would move of a line, whoever allows it."""
    line = response.line
    found: list[Adjustable] = []
    for m in MOVABLES.values():
        mounts = m.fitted and m.of == "line" and line.measured
        parts = range(1, m.count(line) + 1) if mounts else ()
        for k in parts:
            low, high = np.clip(m.reach, *m.room(line)).tolist()
            found.append(
                Adjustable(
                    what=m.key, part=k, low=low, high=high, line=line.name, step=m.resolution
                )
            )
    return tuple(found)


def in_states(response: Response, states: Sequence[int]) -> Response:
    """Return the response of a line as installed, in some of its states alone."""
    application = response.application
    some = replace(application, states=tuple(application.states[s] for s in states))
    return respond(some, demand(resolve(some, response.demand.installed)))


def tried(response: Response, movable: tuple[Adjustable, ...], amounts: FloatArray) -> Response:
    """Return the response of a line with each thing moved by its amount, (V, movable) SI.

    Those are the line's own, or the shim of an axle that it leaves (`acts_on`).
    Of one variant, (movable,), it has no axis of variants.
    """
    by = _by(response, movable, np.atleast_2d(amounts))
    shift, shim, phases = apart(by.bearing_shift, of=2), by.shim, apart(by.phases)
    ahead = by.shim_ahead
    if amounts.ndim == 1:
        shift, shim, ahead, phases = shift[0], shim[0], ahead[0], phases[0]
    response = _refitted(response, by)

    def lay(demand: Demand) -> Layout:
        return demand.corrected(bearing_shift=shift, shim=shim, shim_ahead=ahead)

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

    Its layouts, yoke phases and pinion are as a file would say them after the correction, and so
    is where a line begins that leaves a shimmed axle, for studies that ask the application anew.
    Not so its spline: what travel is left in one counts from where the line was first installed,
    and the driveline's own answer is `tried`.
    """
    by = _by(response, movable, amounts[None])
    shift, shim = by.bearing_shift[0, 0], float(by.shim[0, 0])
    response = _refitted(response, by)
    application, installed = response.application, response.demand.installed
    axle, line = installed.axle, installed.line
    arm = _arm(axle.pinion_joint if axle else (0.0, 0.0))

    def after(layout: Layout) -> Layout:
        return moved(layout, line, bearing_shift=shift, pinion_pitch=shim, pinion_arm=arm)

    layout = after(installed.layout)
    shafts = [
        replace(s, phase=s.phase + float(turn))
        for s, turn in zip(line.shafts, by.phases[0, 0], strict=True)
    ]
    shafts[-1] = replace(shafts[-1], length=float(layout.lengths[..., -1]))
    new = replace(
        installed,
        line=replace(line, shafts=tuple(shafts)),
        layout=layout,
        axle=axle and replace(axle, pinion_joint=_pitched(axle.pinion_joint, shim)),
    )
    laid = {line.name: after}
    lines = [new if i is installed else i for i in application.lines]
    for k, other in enumerate(application.lines):
        if (joint := other.output_joint) is not None and other.leaves(installed):
            first = Ride(pitch=shim, arm=_arm(joint))
            laid[other.line.name] = partial(moved, line=other.line, first=first)
            lines[k] = replace(
                other,
                layout=laid[other.line.name](other.layout),
                output_joint=_pitched(joint, shim),
            )
    return replace(
        application,
        lines=tuple(lines),
        states=tuple(
            replace(s, layouts={n: laid[n](o) if n in laid else o for n, o in s.layouts.items()})
            if s.layouts
            else s
            for s in application.states
        ),
    )


def _arm(joint: tuple[Metre, Metre]) -> FloatArray:
    """Return a joint that an axle carries, (x, z) from its wheels, as (3,) m."""
    return np.array([joint[0], 0.0, joint[1]])


def _pitched(joint: tuple[Metre, Metre], pitch: Radian) -> tuple[Metre, Metre]:
    """Return where such a joint is from the wheels as the axle has turned."""
    arm = _arm(joint)
    x, _, z = Ride(pitch=pitch, arm=arm).carried(arm, arm)[1].tolist()
    return x, z


def _refitted(response: Response, by: Moved) -> Response:
    """Return the response of a line with the mounts it would have; itself if those stay."""
    mounts = by.stiffer, by.lossier, by.ahead
    if not any(v.any() for v in mounts):
        return response
    stiffer, lossier, ahead = (float(v[0, 0]) if len(v) == 1 else v for v in mounts)

    def mounted(of: CentreBearing) -> CentreBearing:
        k, along, loss = of.stiffness, of.axial_stiffness, of.loss_factor
        return replace(
            of,
            stiffness=k and (k[0] * (1 + stiffer), k[1] * (1 + stiffer)),
            axial_stiffness=None if along is None else along * (1 + stiffer),
            loss_factor=loss
            if not np.any(lossier)
            else (LOSS if loss is None else loss) * (1 + lossier),
            from_rear_joint=of.from_rear_joint + ahead,
        )

    application, installed = response.application, response.demand.installed
    shafts = tuple(
        replace(s, centre_bearing=s.centre_bearing and mounted(s.centre_bearing))
        for s in installed.line.shafts
    )
    new = replace(installed, line=replace(installed.line, shafts=shafts))
    application = replace(
        application, lines=tuple(new if i is installed else i for i in application.lines)
    )
    return respond(application, demand(resolve(application, new)), phases=response.phases)


def _by(response: Response, movable: tuple[Adjustable, ...], amounts: FloatArray) -> Moved:
    """Return how far things of a line move with amounts (V, movable)."""
    by = Moved.still(response.line, variants=len(amounts))
    for adjustable, amount in zip(movable, amounts.T, strict=True):
        if adjustable.line not in _ahead(response):
            MOVABLES[adjustable.what].move(by, adjustable.part, amount)
        elif adjustable.what == "shim":
            by.shim_ahead[:, 0] = amount
    return by


def _ahead(response: Response) -> set[str]:
    """Return the lines that end at the axle which a line leaves; none where the frame holds it."""
    installed = response.demand.installed
    return {i.line.name for i in response.application.lines if installed.leaves(i)}


def acts_on(response: Response, adjustable: Adjustable) -> bool:
    """Return whether a line is otherwise where something is moved: of it, or of the axle ahead."""
    shims = adjustable.what == "shim" and adjustable.line in _ahead(response)
    return shims or adjustable.line == response.line.name


def turned(response: Response, movable: Sequence[Adjustable]) -> tuple[Response, ...]:
    """Return the lines that are otherwise where things of a line are moved, that one first.

    Its shim turns those with it that leave its axle.
    """
    application, installed = response.application, response.demand.installed
    behind = (i for i in application.lines if i.leaves(installed))
    shims = any(a.what == "shim" for a in movable)
    others = (respond(application, demand(resolve(application, i))) for i in behind)
    return response, *(others if shims else ())
