"""The next size: which tube, joint, split of the length or bearing place passes where none does.

What moving cannot help, another part may. Offers of one kind are tried from the smallest on,
each as the whole line with it in place; the first that passes, and makes nothing else worse,
is proposed.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from cardan.application.limit_profiles import limits_to_evaluate
from cardan.application.reader import catalogue_of_application
from cardan.approval.approval import Approval, approve_application, approve_driveline
from cardan.approval.driveline_study import check_limit_at_part, evaluate_limits, line_checks
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.checks.quantities.registry import LINE_QUANTITIES
from cardan.core.errors import DesignError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import Kilogram, Metre, Radian, deg, mm
from cardan.core.verdict import CHECK_GRADES, Check
from cardan.model.application import Application, InstalledLine
from cardan.model.layout import layout_from_points
from cardan.model.parts import CentreBearing, JointSize, Line, Shaft, Tube
from cardan.physics.strength.bearing_life import rated_torque_from_catalogue
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

if TYPE_CHECKING:
    from cardan.topics.design.robustness import ToleranceModel, ToleranceYield

PartProposalKind: TypeAlias = Literal["tube", "joint", "split", "bearing place", "further shaft"]

PROPOSAL_KINDS_BY_QUANTITY: dict[str, tuple[PartProposalKind, ...]] = {
    "tube_shear_utilisation": ("tube",),
    "tube_fatigue_utilisation": ("tube",),
    "tube_buckling_utilisation": ("tube",),
    "critical_speed_ratio": ("tube", "split", "further shaft"),
    "half_critical_band": ("tube", "split"),
    "joint_torque_utilisation": ("joint",),
    "joint_fatigue_utilisation": ("joint",),
    "joint_life": ("joint",),
    "n_beta": ("joint",),
    "joint_speed": ("joint",),
    "centre_bearing_static": ("bearing place",),
    "centre_bearing_dynamic": ("bearing place",),
    "centre_bearing_peak": ("bearing place",),
    "centre_bearing_travel": ("bearing place",),
    "centre_bearing_travel_utilisation": ("bearing place",),
}
"""What may answer a limit of each quantity, the usual way first."""

SHAFT_SPLIT_STEP_M, MAX_SHAFT_SPLIT_SHIFT_M = 25 * mm, 400 * mm
"""By what steps, and how far at most, a centre bearing goes along the line with its joint."""

BEARING_POSITION_STEP_M, MIN_BEARING_TO_JOINT_M = 10 * mm, 60 * mm
"""By what steps a bearing's place on its shaft moves, and how near to its rear joint."""

FURTHER_SHAFT_SHARES = (0.5, 0.45, 0.55)
"""At which shares of a shaft that is too long a further joint is tried, the middle first."""

FURTHER_JOINT_ANGLES_RAD = tuple(sign * k * deg for k in (1.0, 1.5, 2.5, 4.0) for sign in (1, -1))
"""Angles of a further joint, upward positive: needles must roll, and 1 deg lets them."""

NEW_BEARING_TO_JOINT_M = 150 * mm
"""How far ahead of its joint a further bearing sits where the line has none to take after."""

MAX_ELASTIC_MODULUS_DIFFERENCE_SHARE = 0.2
"""Share by which the moduli of one metal's grades may differ."""

MAX_PART_CHANGES = 12
"""Parts that are changed at most: three shafts' tubes, their joints, splits and places."""


@dataclass(frozen=True, kw_only=True)
class FurtherShaft:
    """A shaft made two, with a joint and a centre bearing between them.

    Attributes
    ----------
    share : 1
        How far along the shaft the further joint is.
    joint_angle : rad
        Of the further joint, positive where it lies above the straight line.
    phase : rad
        Yoke phase of the front half; the rear half keeps that of the shaft.
    lengths : (front, rear) m
    height : m
        Of the further joint above the straight line between its neighbours.
    bearing
        What the front half hangs on, rigid where the line has no bearing to take after.
    """

    share: float
    joint_angle: Radian
    phase: Radian
    lengths: tuple[Metre, Metre]
    height: Metre
    bearing: CentreBearing


@dataclass(frozen=True, kw_only=True)
class PartProposal:
    """Another part of a line, or another place of one.

    Attributes
    ----------
    line, kind, part_numbers
        Which line, what it is, and the numbers of the shafts, joints or bearings.
    part, replaced_part_name
        Of tubes and joints: the new one, and what the one that is there is called.
    rearward_shift : m
        Of a split or a bearing's place: how far to the rear.
    mass_change : kg
        What the line gains; None where a joint's mass is not published.
    """

    line: str
    kind: PartProposalKind
    part_numbers: tuple[int, ...]
    part: Tube | JointSize | None = None
    replaced_part_name: str = ""
    rearward_shift: Metre = 0.0
    mass_change: Kilogram | None = 0.0
    further_shaft: "FurtherShaft | None" = None


@dataclass(frozen=True, kw_only=True)
class Remedy:
    """An offer, and the checks that need it, each as it was and with the offer in place.

    `worsened_checks` are those that then warn and did not before. `tolerance_yield` is how many
    trucks keep what the line then comes to, as they scatter by `tolerance_model`. `alternatives`
    are other ways to answer the same.
    """

    offer: PartProposal
    resolved_checks: tuple[tuple[Check, Check], ...]
    worsened_checks: tuple[Check, ...] = ()
    tolerance_yield: "ToleranceYield | None" = None
    tolerance_model: "ToleranceModel | None" = None
    alternatives: "tuple[Remedy, ...]" = ()

    def with_tolerance_yield(self, application: Application) -> "Remedy":
        """Return it with how many trucks keep the line of an application that it is part of.

        Not reported if numbers of the file scatter: they are of the file, which has other parts.
        """
        from cardan.topics.design.robustness import (
            ToleranceModel,  # what `cardan check` starts without
        )

        trucks = ToleranceModel.from_application(application, self.offer.line)
        if trucks is None or not trucks.only_adjustments_vary:
            return self
        return replace(
            self, tolerance_model=trucks, tolerance_yield=trucks.survival((), np.empty(0))
        )


@dataclass(frozen=True, kw_only=True)
class UnresolvedCheck:
    """A check that nothing on offer answers.

    `offer` is the smallest that would, if `newly_failing_check` did not then fail; None where there
    is none.
    """

    check: Check
    offer: PartProposal | None = None
    newly_failing_check: Check | None = None


@dataclass(frozen=True, kw_only=True)
class SizingResult:
    """What other parts come to: the remedies, and the approval with all of them in place."""

    approval_before: Approval
    remedies: tuple[Remedy, ...]
    unresolved: tuple[UnresolvedCheck, ...]
    approval: Approval

    @property
    def mass_change(self) -> Kilogram | None:
        """What the vehicle gains; None where it is not known of every part."""
        masses = [r.offer.mass_change for r in self.remedies]
        return None if None in masses else sum(m for m in masses if m is not None)

    @cached_property
    def further_shafts(self) -> dict[str, Approval]:
        """Approvals with a further shaft, by line: with all parts where it is the first way.

        Where another part goes first it is that of the line today with a further shaft alone.
        """
        found = {r.offer.line: self.approval for r in self.remedies if r.offer.further_shaft}
        if found:  # it renumbers the parts behind it
            return found
        for other in (o for r in self.remedies for o in r.alternatives if o.offer.further_shaft):
            with_it = application_with_proposal(self.approval_before.application, other.offer)
            found.setdefault(other.offer.line, approve_driveline(with_it))
        return found

    @property
    def failures_without_remedy(self) -> tuple[Check, ...]:
        """What fails with all parts in place and no part is sought for, the worst of a quantity."""
        worst: dict[tuple[str, str], Check] = {}
        for one in sorted(self.approval.checks, key=_badness):
            if one.grade == "fail" and one.quantity not in PROPOSAL_KINDS_BY_QUANTITY:
                worst.setdefault((one.line, one.quantity), one)
        return tuple(worst.values())


def propose_parts(
    application: Application,
    *,
    line: str | None = None,
    tell: Callable[[int, int], None] | None = None,
) -> SizingResult:
    """Propose other parts until what a part can answer is answered.

    Parameters
    ----------
    application
        Parts are of its own catalogues and those shipped.
    line
        Only this line's.
    tell
        Called with how many parts have been changed, and how many may be at most.

    Raises
    ------
    DesignError
        If the application has no such line.

    Notes
    -----
    The worst check comes first; the next one is evaluated on the line as it then is. A part
    will do if the check that needs it passes, no other of its line comes to a worse grade,
    and nothing that was evaluated is left unevaluated. Where none does that, and the
    check fails, one after which it warns, or others warn, will do. The smallest of tubes is
    the lightest, of joints that of the least peak torque, of splits and places the one that
    moves least. Of several ways the one goes first that most trucks keep as they scatter, the
    usual one where as many keep it. Yokes are taken to stay as heavy as they are.
    """
    from cardan.topics.design.robustness import PRODUCTION_YIELD_CLASS_COUNT

    names = [i.line.name for i in application.lines]
    if line is not None and line not in names:
        msg = f"there is no line {line}; there are: {', '.join(names)}"
        raise DesignError(msg)
    before = approve_application(application)
    remedies: list[Remedy] = []
    done: set[tuple[str, str, str]] = set()
    hopeless: list[UnresolvedCheck] = []
    while len(remedies) < MAX_PART_CHANGES:
        if tell:
            tell(len(remedies), MAX_PART_CHANGES)
        asking = (p for p in resolvable_checks(application, line=line) if _id(p) not in done)
        problem = next(asking, None)
        if problem is None:
            break
        found = smallest_sufficient_proposals(application, problem)
        ways = [
            a.with_tolerance_yield(application_with_proposal(application, a.offer))
            for a in found
            if isinstance(a, Remedy)
        ]
        ways.sort(
            key=lambda w: (
                -w.tolerance_yield.yield_class
                if w.tolerance_yield
                else -PRODUCTION_YIELD_CLASS_COUNT
            )
        )
        if not ways:
            missed = [a for a in found if isinstance(a, UnresolvedCheck)]
            hopeless += sorted(missed, key=lambda a: a.offer is None)[:1]
        if not ways or any(after.grade != "pass" for _, after in ways[0].resolved_checks):
            done.add(_id(problem))  # more cannot be had
        if ways:
            remedies.append(replace(ways[0], alternatives=tuple(ways[1:])))
            application = application_with_proposal(application, ways[0].offer)
    return SizingResult(
        approval_before=before,
        remedies=tuple(_together(application, remedies)),
        unresolved=tuple(hopeless),
        approval=approve_application(application) if remedies else before,
    )


def _together(application: Application, remedies: list[Remedy]) -> Iterator[Remedy]:
    """Yield remedies with those of the same part made one, each check as it is at the end."""
    same: dict[tuple[str, PartProposalKind, tuple[int, ...]], list[Remedy]] = {}
    for r in remedies:
        same.setdefault((r.offer.line, r.offer.kind, r.offer.part_numbers), []).append(r)
    for (line, _, _), group in same.items():
        response = _response(application, line)
        offers = [r.offer for r in group]
        masses = [o.mass_change for o in offers]
        asked_by = {
            _id(was): (was, after) for r in reversed(group) for was, after in r.resolved_checks
        }
        yield Remedy(
            offer=replace(
                offers[-1],
                replaced_part_name=offers[0].replaced_part_name,
                rearward_shift=sum(o.rearward_shift for o in offers),
                mass_change=None if None in masses else sum(m for m in masses if m is not None),
            ),
            resolved_checks=tuple(
                (was, _after(response, was) or after) for was, after in reversed(asked_by.values())
            ),
            worsened_checks=group[-1].worsened_checks,
            alternatives=group[0].alternatives if len(group) == 1 else (),
        ).with_tolerance_yield(application)


def next_part_sizes(
    application: Application, checks: Iterable[Check]
) -> dict[tuple[str, str], Remedy]:
    """Return the tube or joint that answers each of some failures, by line and quantity.

    In place of all of `sizing`, to save time: one of each, evaluated by itself; what only warns
    is not.
    """
    found: dict[tuple[str, str], Remedy] = {}
    for one in checks:
        kind = next(iter(PROPOSAL_KINDS_BY_QUANTITY.get(one.quantity, ())), None)
        known = (one.line, one.quantity) in found
        if kind in ("tube", "joint") and one.grade == "fail" and not known:
            (answer,) = smallest_sufficient_proposals(application, one, kinds=(kind,))
            if isinstance(answer, Remedy):
                found[one.line, one.quantity] = answer
    return found


def resolvable_checks(application: Application, *, line: str | None = None) -> list[Check]:
    """Return the checks that another part might answer, the worst first, one a quantity and part.

    Of quantities that are not sought at every operating point.
    """
    worst: dict[tuple[str, str, str], Check] = {}
    for installed in application.lines:
        if line not in (None, installed.line.name):
            continue
        response = compute_line_response(
            application, line_state_demand(resolve_line_references(application, installed))
        )
        bad = (
            c
            for c in line_checks(response)
            if c.quantity in PROPOSAL_KINDS_BY_QUANTITY and c.grade != "pass"
        )
        for one in sorted(bad, key=_badness):
            worst.setdefault(_id(one), one)
    return sorted(worst.values(), key=_badness)


def _badness(of: Check) -> tuple[int, float, bool]:
    """Return what checks are sorted by: a shaft goes before the line that is as bad for it."""
    return -CHECK_GRADES.index(of.grade), of.margin, not of.part.number


def _id(of: Check) -> tuple[str, str, str]:
    return of.line, of.quantity, str(of.part)


# --------------------------------------------------------------------------- what is tried


def smallest_sufficient_proposals(
    application: Application, problem: Check, *, kinds: Sequence[PartProposalKind] | None = None
) -> tuple[Remedy | UnresolvedCheck, ...]:
    """Return the smallest offer of each kind that answers a check, or that none does."""
    before = _worst(_response(application, problem.line))
    return tuple(
        _smallest(application, _offers(application, problem, kind), problem, before)
        for kind in (PROPOSAL_KINDS_BY_QUANTITY[problem.quantity] if kinds is None else kinds)
        # A shaft that is only near its limit is not worth a joint and a bearing more.
        if kind != "further shaft" or problem.grade == "fail"
    )


WorstCheckByQuantityStatePart: TypeAlias = dict[tuple[str, str, str], Check]
"""The worst check of each quantity, state and part of a line."""


def _smallest(
    application: Application,
    offers: Iterator[PartProposal],
    problem: Check,
    before: WorstCheckByQuantityStatePart,
) -> Remedy | UnresolvedCheck:
    """Return the first offer that answers a check and makes nothing worse, or what comes nearest.

    Of a check that fails that is the first after which nothing fails that did not.
    """
    nearest: Remedy | None = None
    blocked: UnresolvedCheck | None = None
    for offer in offers:
        try:
            response = _response(application_with_proposal(application, offer), offer.line)
            after = _after(response, problem)  # quick: it alone
            if after is None or _place(after) >= _place(problem):
                continue
            now = _worst(response)
        except DesignError:  # such a line cannot exist
            continue
        if _answered(before, offer) - _answered(now, offer):
            continue  # what was answered is not
        worse = tuple(c for c in now.values() if _place(c) > _grade_before(c, offer, before))
        found = Remedy(offer=offer, resolved_checks=((problem, after),), worsened_checks=worse)
        if after.grade == "pass" and not worse:
            return found
        fails = next((c for c in worse if c.grade_as_exceeded == "fail"), None)
        if fails:
            blocked = blocked or UnresolvedCheck(
                check=problem, offer=offer, newly_failing_check=fails
            )
        elif problem.grade_as_exceeded == "fail":
            nearest = nearest or found
    return nearest or blocked or UnresolvedCheck(check=problem)


def _answered(checks: WorstCheckByQuantityStatePart, offer: PartProposal) -> set[tuple[str, ...]]:
    """Return what got a number: quantity, state and part, of a further shaft without the part.

    Equal end angles are a rule for one shaft with two joints.
    """
    if offer.further_shaft is None:
        return set(checks)
    return {(q, state) for q, state, _ in checks if q != "end_angle_difference"}


def _grade_before(of: Check, offer: PartProposal, before: WorstCheckByQuantityStatePart) -> int:
    """Return the place of the grade that a check had before an offer; of a new part, a pass.

    Of a shaft made two both halves were the one, and parts behind it had a number less.
    """
    part = of.part
    if offer.further_shaft is not None and part.kind in _NUMBERED_ALONG_LINE:
        (number,) = offer.part_numbers
        part = replace(part, number=int(part.number) - (int(part.number) > number))
    was = before.get((of.quantity, of.state, str(part)))
    return 0 if was is None else _place(was)


def _place(of: Check) -> int:
    """Return the place of a check's grade, from best to worst; a lower bound counts as failing."""
    return CHECK_GRADES.index(of.grade_as_exceeded)


_NUMBERED_ALONG_LINE = ("shaft", "joint", "centre bearing", "clearance")


def _worst(response: LineResponse) -> WorstCheckByQuantityStatePart:
    found: WorstCheckByQuantityStatePart = {}
    for c in sorted(line_checks(response), key=_badness):
        found.setdefault((c.quantity, c.state, str(c.part)), c)
    return found


def _response(application: Application, line: str) -> LineResponse:
    installed = _installed(application, line)
    return compute_line_response(
        application, line_state_demand(resolve_line_references(application, installed))
    )


def _installed(application: Application, line: str) -> InstalledLine:
    return next(i for i in application.lines if i.line.name == line)


def _after(response: LineResponse, problem: Check) -> Check | None:
    """Return a check's quantity and part where it is worst now; None if not evaluated.

    With a joint of its own rating another limit may apply than before; a joint without a rating
    does not settle the rating of another.
    """
    found: list[Check] = []
    limits = limits_to_evaluate(response.application)
    for question in evaluate_limits(response, quantities={problem.quantity}):
        for k, part in enumerate(question.parts):
            if part == problem.part:
                states = range(len(question.values))
                every = [check_limit_at_part(response, question, state, k) for state in states]
                if any(c is None and question.asks[s, k] for s, c in enumerate(every)):
                    return None
                found += filter(None, every)
    if problem.limit not in limits and all(c.limit in limits for c in found):
        return None
    return min(found, key=_badness, default=None)


# --------------------------------------------------------------------------- what is on offer


def _offers(
    application: Application, problem: Check, kind: PartProposalKind
) -> Iterator[PartProposal]:
    """Yield what may stand in place of a part, the smallest first."""
    line, number = _installed(application, problem.line).line, _number(application, problem)
    match kind:
        case "tube":
            yield from _tubes(application, line, number)
        case "joint":
            yield from _joints(application, line, number)
        case "split":
            yield from _splits(application, line, number)
        case "bearing place":
            yield from _places(line, number)
        case "further shaft":
            yield from _further_shafts(application, problem.line, number)


def _number(application: Application, problem: Check) -> int:
    """Return the number of the shaft, joint or bearing; of a whole line's whirl, its first shaft.

    First is the one of the lowest critical speed.
    """
    if problem.part.number:
        return int(problem.part.number)
    speeds = LINE_QUANTITIES["critical_speed"].values(_response(application, problem.line))
    return 1 + int(np.nanmin(speeds, axis=-2).argmin())


def _tubes(application: Application, line: Line, number: int) -> Iterator[PartProposal]:
    """Yield all tubes of the catalogues for a shaft, the lightest first.

    Its yokes are welded to it: what is steel stays steel. A yoke for a metric tube fits no tube
    in inches; a tube of a name of its own, from a file's own catalogue, is for either.
    """
    shaft = line.shafts[number - 1]
    now = shaft.tube.material.youngs_modulus if isinstance(shaft.tube, Tube) else None
    in_inches = isinstance(shaft.tube, Tube) and bool(_is_in_inches(shaft.tube))
    tubes: list[Tube] = [
        tube
        for tube in catalogue_of_application(application).parts("tube")
        if now is None
        or abs(tube.material.youngs_modulus / now - 1) < MAX_ELASTIC_MODULUS_DIFFERENCE_SHARE
    ]
    if shaft.tube is not None:
        tubes = [tube for tube in tubes if _is_in_inches(tube) in (in_inches, None)] or tubes
    for tube in sorted(tubes, key=lambda t: t.mass_per_length):
        yield PartProposal(
            line=line.name,
            kind="tube",
            part_numbers=(number,),
            part=tube,
            replaced_part_name=_called(shaft),
            mass_change=replace(shaft, tube=tube).mass - shaft.mass,
        )


def _is_in_inches(tube: Tube) -> bool | None:
    """Return whether a tube's name gives its sizes in inches; None where it gives no sizes."""
    sizes = re.match(r"[\d.]+x[\d.]+(in\b)?", tube.name)
    return None if sizes is None else sizes[1] is not None


def _called(shaft: Shaft) -> str:
    """Return what a shaft's tube is called, or its size in mm."""
    tube = shaft.tube
    if tube is None or tube.name:
        return tube.name if tube else ""
    return f"{tube.outer / mm:g}x{tube.wall / mm:g}" if isinstance(tube, Tube) else ""


def _joints(application: Application, line: Line, number: int) -> Iterator[PartProposal]:
    """Yield all crosses of the catalogues for joints that are of one size, the smallest first."""
    size = line.joints[number - 1] if line.joints else None
    of = catalogue_of_application(application)
    rated = (j for j in of.parts("joint") if j.kind == "cross" and j.peak_torque)
    parts = tuple(k for k, other in enumerate(line.joints, 1) if other == size)
    for joint in sorted(rated, key=_size):
        yield PartProposal(
            line=line.name, kind="joint", part_numbers=parts or (number,), part=joint,
            replaced_part_name=size.name if size else "",
            mass_change=_gained(joint, size, len(parts)),
        )  # fmt: skip


def _gained(joint: JointSize, size: JointSize | None, count: int) -> Kilogram | None:
    if size is None or size.mass is None or joint.mass is None:
        return None
    return count * (joint.mass - size.mass)


def _size(joint: JointSize) -> tuple[float, float]:
    return joint.peak_torque or inf, rated_torque_from_catalogue(joint) or inf


def _splits(application: Application, line: Line, number: int) -> Iterator[PartProposal]:
    """Yield ways to make a shaft shorter: a centre bearing of it along the line, nearest first."""
    if any(state.layouts for state in application.states):
        return  # every state says by itself where the joints are
    bearings = [b for b in (number - 1, number) if 1 <= b < len(line.shafts)]
    for size in np.arange(SHAFT_SPLIT_STEP_M, MAX_SHAFT_SPLIT_SHIFT_M, SHAFT_SPLIT_STEP_M):
        for b in bearings:
            rearward = size if b < number else -size
            yield PartProposal(
                line=line.name, kind="split", part_numbers=(b,), rearward_shift=float(rearward)
            )


def _further_shafts(application: Application, name: str, number: int) -> Iterator[PartProposal]:
    """Yield ways to make a shaft two, the smallest angle of the further joint first."""
    installed = _installed(application, name)
    line = installed.line
    # States with a geometry of their own say where each joint is, a bracket which bearing is its.
    if any(s.layouts for s in application.states) or application.bracket or not line.has_lengths:
        return
    length = line.shafts[number - 1].length
    like = line.centre_bearings[-1] if line.centre_bearings else None
    bearing = like or CentreBearing(from_rear_joint=NEW_BEARING_TO_JOINT_M)
    for angle in FURTHER_JOINT_ANGLES_RAD:
        for share in FURTHER_SHAFT_SHARES:
            height = np.tan(angle) * share * (1 - share) * length
            front, rear = (float(np.hypot(s * length, height)) for s in (share, 1 - share))
            if min(front, rear) <= 2 * bearing.from_rear_joint:
                continue
            for phase in (0.0, np.pi / 2):
                yield PartProposal(
                    line=name,
                    kind="further shaft",
                    part_numbers=(number,),
                    mass_change=None,
                    further_shaft=FurtherShaft(
                        share=share,
                        joint_angle=angle,
                        phase=phase,
                        lengths=(front, rear),
                        height=float(height),
                        bearing=bearing,
                    ),
                )


def _places(line: Line, number: int) -> Iterator[PartProposal]:
    """Yield places of a bearing on its shaft, the nearest first."""
    shaft = line.shafts[number - 1]
    assert shaft.centre_bearing is not None
    now = shaft.centre_bearing.from_rear_joint
    for size in np.arange(
        BEARING_POSITION_STEP_M, float(shaft.length) / 2, BEARING_POSITION_STEP_M
    ):
        for rearward in (float(size), -float(size)):
            if MIN_BEARING_TO_JOINT_M <= now - rearward <= shaft.length / 2:
                yield PartProposal(
                    line=line.name,
                    kind="bearing place",
                    part_numbers=(number,),
                    rearward_shift=rearward,
                )


# --------------------------------------------------------------------------- putting it in


def application_with_proposal(application: Application, offer: PartProposal) -> Application:
    """Return the application with an offer in place."""
    installed = _installed(application, offer.line)
    line, layout = installed.line, installed.layout
    shafts, joints = list(line.shafts), list(line.joints)
    match offer.kind:
        case "tube":
            assert not isinstance(offer.part, JointSize)
            (number,) = offer.part_numbers
            shafts[number - 1] = _with_tube(shafts[number - 1], offer.part)
        case "joint":
            assert isinstance(offer.part, JointSize)
            for number in offer.part_numbers:
                joints[number - 1] = offer.part
        case "bearing place":
            (number,) = offer.part_numbers
            bearing = shafts[number - 1].centre_bearing
            assert bearing is not None
            place = bearing.from_rear_joint - offer.rearward_shift
            shafts[number - 1] = replace(
                shafts[number - 1], centre_bearing=replace(bearing, from_rear_joint=place)
            )
        case "further shaft":
            assert offer.further_shaft is not None
            return _with_further_shaft(application, installed, offer)
        case "split":
            (number,) = offer.part_numbers
            points = np.array(layout.points)
            # Joint b + 1 hangs behind bearing b: along the shaft it goes into, so that the
            # line stays where it was.
            along = layout.directions[..., number + (1 if offer.rearward_shift > 0 else 0), :]
            points[..., number, :] += offer.rearward_shift * along
            ends = layout.directions
            layout = layout_from_points(points, gearbox=ends[..., 0, :], pinion=ends[..., -1, :])
            lengths = layout.lengths.tolist()
            shafts = [
                replace(s, length=x, tube_length=s.tube_length and s.tube_length + x - s.length)
                for s, x in zip(shafts, lengths, strict=True)
            ]
    new = replace(
        installed, line=replace(line, shafts=tuple(shafts), joints=tuple(joints)), layout=layout
    )
    return replace(
        application, lines=tuple(new if i is installed else i for i in application.lines)
    )


def _with_tube(shaft: Shaft, tube: Tube | None) -> Shaft:
    """Return a shaft with another tube; a polar inertia that was given changes with it."""
    given = shaft.polar_inertia_given
    if given is not None:
        before = shaft.tube.polar_inertia_per_length if shaft.tube else 0.0
        after = tube.polar_inertia_per_length if tube else 0.0
        given = given + (after - before) * shaft.length
    return replace(shaft, tube=tube, polar_inertia_given=given)


def _with_further_shaft(
    application: Application, installed: InstalledLine, offer: PartProposal
) -> Application:
    """Return the application with a shaft made two."""
    further, (number,) = offer.further_shaft, offer.part_numbers
    assert further is not None
    line, layout = installed.line, installed.layout
    old, at = line.shafts[number - 1], number - 1
    along = layout.directions[number]
    up = np.array([0.0, 0.0, 1.0]) - along[2] * along
    joint = (
        layout.points[at] + further.share * old.length * along
        + further.height * up / np.linalg.norm(up)
    )  # fmt: skip
    moved = layout_from_points(
        np.insert(layout.points, number, joint, axis=0),
        gearbox=layout.directions[0],
        pinion=layout.directions[-1],
    )
    front, rear = (
        replace(
            old,
            length=length,
            tube_length=old.tube_length
            and max(old.tube_length - (old.length - length), 0.5 * length),
            polar_inertia_given=old.polar_inertia_given
            and old.polar_inertia_given * length / old.length,
        )
        for length in further.lengths
    )
    front = replace(front, phase=further.phase, spline=None, centre_bearing=further.bearing)
    new = replace(
        installed,
        line=replace(
            line,
            shafts=(*line.shafts[:at], front, rear, *line.shafts[number:]),
            joints=(*line.joints[:number], *line.joints[at:number], *line.joints[number:]),
        ),
        layout=moved,
    )
    return replace(
        application, lines=tuple(new if i is installed else i for i in application.lines)
    )
