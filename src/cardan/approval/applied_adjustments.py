"""What may be moved of a line, and what the line does when it is: many variants at a time."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.core.arrays import FloatArray, make_components_contiguous, stack_on_last_axis
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import Metre, Radian
from cardan.model.adjustments import ADJUSTMENTS, AdjustmentAmounts, permitted_adjustments_by_name
from cardan.model.application import Application, PermittedAdjustment
from cardan.model.layout import Layout
from cardan.model.parts import CentreBearing
from cardan.physics.loads.rubber_mount import DEFAULT_LOSS_FACTOR
from cardan.physics.vehicle.axle_motion import AxleMotion, layout_after_axle_motion
from cardan.physics.vehicle.state_demand import (
    LineStateDemand,
    line_state_demand,
    resolve_line_references,
)


@dataclass(frozen=True, kw_only=True)
class AppliedAdjustment:
    """One thing moved, by how much: metres up or to the right, radians of shim or phase."""

    adjustable: PermittedAdjustment
    amount: float

    @property
    def cost(self) -> float:
        """Share of its range that it uses; a turned yoke counts as half a full way."""
        if ADJUSTMENTS[self.adjustable.adjustment_key].extremes_only:
            return 0.5
        bound = self.adjustable.high if self.amount > 0 else self.adjustable.low
        return abs(self.amount / bound)


ADJUSTMENTS_OF_LINE_WITHOUT_LENGTHS = ("phase", "shim")
"""What can be moved of a line that is known by its slopes alone."""


def allowed_adjustments(response: LineResponse) -> tuple[PermittedAdjustment, ...]:
    """Return what may be moved in a line: what the application allows, or engineering judgement."""
    application, name = response.application, response.line.name
    if application.adjustables:
        return tuple(a for a in application.adjustables if a.line == name and not a.hold)
    return tuple(
        PermittedAdjustment(
            adjustment_key=m.key,
            part=k,
            low=m.default_range[0],
            high=m.default_range[1],
            line=name,
            step=m.resolution,
        )
        for m in ADJUSTMENTS.values()
        if not m.explicit_only
        and (response.line.has_lengths or m.key in ADJUSTMENTS_OF_LINE_WITHOUT_LENGTHS)
        for k in range(1, m.count(response.line) + 1)
    )


def all_adjustments(response: LineResponse) -> tuple[PermittedAdjustment, ...]:
    """Return everything that can be moved in a line: as far as its file allows, or by practice."""
    name = response.line.name
    said = {
        (a.adjustment_key, a.part): a for a in response.application.adjustables if a.line == name
    }
    return tuple(
        said.get((a.adjustment_key, a.part), a)
        for a in permitted_adjustments_by_name([response.line]).values()
    )


def alternative_mount_adjustments(response: LineResponse) -> tuple[PermittedAdjustment, ...]:
    """Return what other mounts would move of a line, allowed or not."""
    line = response.line
    found: list[PermittedAdjustment] = []
    for m in ADJUSTMENTS.values():
        mounts = m.explicit_only and m.subject == "line" and line.has_lengths
        parts = range(1, m.count(line) + 1) if mounts else ()
        for k in parts:
            low, high = np.clip(m.default_range, *m.available_range(line)).tolist()
            found.append(
                PermittedAdjustment(
                    adjustment_key=m.key,
                    part=k,
                    low=low,
                    high=high,
                    line=line.name,
                    step=m.resolution,
                )
            )
    return tuple(found)


def line_response_in_states(response: LineResponse, states: Sequence[int]) -> LineResponse:
    """Return the response of a line as installed, in some of its states alone.

    Its suspension goes through all of them, and its spline is pushed in by that.
    """
    application = response.application
    some = replace(
        application,
        states=tuple(application.states[s] for s in states),
        stroke_states=application.stroke_states or application.states,
    )
    return compute_line_response(
        some, line_state_demand(resolve_line_references(some, response.demand.installed))
    )


def response_with_adjustments(
    response: LineResponse,
    movable: tuple[PermittedAdjustment, ...],
    amounts: FloatArray,
    *,
    shared: bool = False,
) -> LineResponse:
    """Return the response of a line with each thing moved by its amount, (V, movable) SI.

    Those are the line's own, or the shim of an axle that it leaves (`adjustment_affects_line`).
    Of one variant, (movable,), it has no axis of variants. With `shared`, what all variants have
    alike has one, (1, ...): layouts, if phases alone differ. What follows from that alone is
    computed once.
    """
    by = _by(response, movable, np.atleast_2d(amounts))
    shift, shim, ahead, phases = (
        v[:1] if shared and (v == v[:1]).all() else v
        for v in (by.bearing_shift, by.shim, by.input_axle_shim, by.phases)
    )
    shift, phases = make_components_contiguous(shift, of=2), make_components_contiguous(phases)
    if amounts.ndim == 1:
        shift, shim, ahead, phases = shift[0], shim[0], ahead[0], phases[0]
    response = _refitted(response, by)

    def lay(demand: LineStateDemand) -> Layout:
        return demand.corrected_layout(bearing_shift=shift, shim=shim, shim_ahead=ahead)

    return compute_line_response(
        response.application,
        response.demand,
        lay=lay,
        phases=stack_on_last_axis(response.line.phases) + phases,
    )


def corrected_application(
    response: LineResponse, movable: tuple[PermittedAdjustment, ...], amounts: FloatArray
) -> Application:
    """Return the application with things of a line moved by these amounts (movable), SI.

    Its layouts, yoke phases and pinion are as a file would say them after the correction, and so
    is where a line begins that leaves a shimmed axle, for studies that evaluate the application
    anew. Not so its spline: what travel is left in one counts from where the line was first
    installed, and the driveline's own answer is `tried`.
    """
    by = _by(response, movable, amounts[None])
    shift, shim = by.bearing_shift[0, 0], float(by.shim[0, 0])
    response = _refitted(response, by)
    application, installed = response.application, response.demand.installed
    axle, line = installed.axle, installed.line
    arm = _arm(axle.pinion_joint if axle else (0.0, 0.0))

    def after(layout: Layout) -> Layout:
        return layout_after_axle_motion(
            layout, line, bearing_shift=shift, pinion_pitch=shim, pinion_arm=arm
        )

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
        if (joint := other.output_joint) is not None and other.starts_at_axle_of(installed):
            first = AxleMotion(pitch=shim, joint_offset=_arm(joint))
            laid[other.line.name] = partial(layout_after_axle_motion, line=other.line, first=first)
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
    x, _, z = AxleMotion(pitch=pitch, joint_offset=arm).displace(arm, arm)[1].tolist()
    return x, z


def _refitted(response: LineResponse, by: AdjustmentAmounts) -> LineResponse:
    """Return the response of a line with the mounts it would have; itself if those stay."""
    mounts = by.stiffness_increase, by.loss_factor_increase, by.bearing_offset_increase
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
            else (DEFAULT_LOSS_FACTOR if loss is None else loss) * (1 + lossier),
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
    return compute_line_response(
        application,
        line_state_demand(resolve_line_references(application, new)),
        phases=response.phases,
    )


def _by(
    response: LineResponse, movable: tuple[PermittedAdjustment, ...], amounts: FloatArray
) -> AdjustmentAmounts:
    """Return how far things of a line move with amounts (V, movable)."""
    by = AdjustmentAmounts.zero(response.line, variants=len(amounts))
    for adjustable, amount in zip(movable, amounts.T, strict=True):
        if adjustable.line not in _ahead(response):
            ADJUSTMENTS[adjustable.adjustment_key].apply(by, adjustable.part, amount)
        elif adjustable.adjustment_key == "shim":
            by.input_axle_shim[:, 0] = amount
    return by


def _ahead(response: LineResponse) -> set[str]:
    """Return the lines that end at the axle which a line leaves; none where the frame holds it."""
    installed = response.demand.installed
    return {i.line.name for i in response.application.lines if installed.starts_at_axle_of(i)}


def adjustment_affects_line(response: LineResponse, adjustable: PermittedAdjustment) -> bool:
    """Return whether a line is otherwise where something is moved: of it, or of the axle ahead."""
    shims = adjustable.adjustment_key == "shim" and adjustable.line in _ahead(response)
    return shims or adjustable.line == response.line.name


def affected_lines(
    response: LineResponse, movable: Sequence[PermittedAdjustment]
) -> tuple[LineResponse, ...]:
    """Return the lines that are otherwise where things of a line are moved, that one first.

    Its shim turns those with it that leave its axle.
    """
    application, installed = response.application, response.demand.installed
    behind = (i for i in application.lines if i.starts_at_axle_of(installed))
    shims = any(a.adjustment_key == "shim" for a in movable)
    others = (
        compute_line_response(
            application, line_state_demand(resolve_line_references(application, i))
        )
        for i in behind
    )
    return response, *(others if shims else ())
