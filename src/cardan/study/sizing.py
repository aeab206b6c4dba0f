"""The next size: which tube, joint, split of the length or bearing place passes where none does.

What moving cannot help, another part may. Offers of one kind are tried from the smallest on,
each as the whole line with it in place; the first that passes, and makes nothing else worse,
is proposed.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from cardan.base.errors import DesignError
from cardan.base.frozen import dataclass
from cardan.base.units import Kilogram, Metre, mm
from cardan.base.verdict import GRADES, Check
from cardan.demand.states import demand, resolve
from cardan.files.application import catalogue_of
from cardan.model.application import Application, Installed
from cardan.model.layout import from_points
from cardan.model.parts import JointSize, Line, Shaft, Tube
from cardan.quantity.quantities import ANSWERED
from cardan.quantity.response import Response, respond
from cardan.shaft.life import life_rating
from cardan.study.approval import Approval, approve
from cardan.study.driveline import asked, check, checks_of

if TYPE_CHECKING:
    from cardan.study.robust import Survival, Trucks

Kind: TypeAlias = Literal["tube", "joint", "split", "bearing place"]

WAYS: dict[str, tuple[Kind, ...]] = {
    "tube_shear_utilisation": ("tube",),
    "tube_fatigue_utilisation": ("tube",),
    "tube_buckling_utilisation": ("tube",),
    "critical_speed_ratio": ("tube", "split"),
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

SPLIT, FARTHEST = 25 * mm, 400 * mm
"""By what steps, and how far at most, a centre bearing goes along the line with its joint."""

PLACE, NEAREST = 10 * mm, 60 * mm
"""By what steps a bearing's place on its shaft moves, and how near to its rear joint."""

ALIKE = 0.2
"""Share by which the moduli of one metal's grades may differ."""

ROUNDS = 12
"""Parts that are changed at most: three shafts' tubes, their joints, splits and places."""


@dataclass(frozen=True, kw_only=True)
class Offer:
    """Another part of a line, or another place of one.

    Attributes
    ----------
    line, kind, parts
        Which line, what it is, and the numbers of the shafts, joints or bearings.
    part, before
        Of tubes and joints: the new one, and what the one that is there is called.
    amount : m
        Of a split or a bearing's place: how far to the rear.
    mass : kg
        What the line gains; None where a joint's mass is not published.
    """

    line: str
    kind: Kind
    parts: tuple[int, ...]
    part: Tube | JointSize | None = None
    before: str = ""
    amount: Metre = 0.0
    mass: Kilogram | None = 0.0


@dataclass(frozen=True, kw_only=True)
class Remedy:
    """An offer, and the checks that asked for it, each as it was and with the offer in place.

    `worse` are checks that then warn and did not before. `survival` tells how many trucks keep
    what the line then comes to, as `trucks` scatter. `others` are other ways to answer the same.
    """

    offer: Offer
    answered: tuple[tuple[Check, Check], ...]
    worse: tuple[Check, ...] = ()
    survival: "Survival | None" = None
    trucks: "Trucks | None" = None
    others: "tuple[Remedy, ...]" = ()

    def kept(self, application: Application) -> "Remedy":
        """Return it with how many trucks keep the line of an application that it is part of.

        Not told where numbers of the file scatter: they are of the file, which has other parts.
        """
        from cardan.study.robust import Trucks  # what `cardan check` starts without

        trucks = Trucks.of(application, self.offer.line)
        if trucks is None or not trucks.of_moves:
            return self
        return replace(self, trucks=trucks, survival=trucks.survival((), np.empty(0)))


@dataclass(frozen=True, kw_only=True)
class Hopeless:
    """A check that nothing on offer answers.

    `offer` is the smallest that would, if `fails` did not then fail; None where there is none.
    """

    problem: Check
    offer: Offer | None = None
    fails: Check | None = None


@dataclass(frozen=True, kw_only=True)
class Sizing:
    """What other parts come to: the remedies, and the approval with all of them in place."""

    before: Approval
    remedies: tuple[Remedy, ...]
    hopeless: tuple[Hopeless, ...]
    approval: Approval

    @property
    def mass(self) -> Kilogram | None:
        """What the vehicle gains; None where it is not known of every part."""
        masses = [r.offer.mass for r in self.remedies]
        return None if None in masses else sum(m for m in masses if m is not None)

    @property
    def beyond(self) -> tuple[Check, ...]:
        """What fails with all parts in place and no part is sought for, the worst of a quantity."""
        worst: dict[tuple[str, str], Check] = {}
        for one in sorted(self.approval.checks, key=_badness):
            if one.grade == "fail" and one.quantity not in WAYS:
                worst.setdefault((one.line, one.quantity), one)
        return tuple(worst.values())


def sizing(
    application: Application,
    *,
    line: str | None = None,
    tell: Callable[[int, int], None] | None = None,
) -> Sizing:
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
    The worst check is answered first; the next one is asked of the line as it then is. A part
    does where the check that asked for it passes, no other of its line comes to a worse grade,
    and nothing that was answered is left without an answer. Where none does that, and the
    check fails, one after which it warns, or others warn, will do. The smallest of tubes is
    the lightest, of joints that of the least peak torque, of splits and places the one that
    moves least. Of several ways the one goes first that most trucks keep as they scatter, the
    usual one where as many keep it. Yokes are taken to stay as heavy as they are.
    """
    from cardan.study.robust import CLASSES

    names = [i.line.name for i in application.lines]
    if line is not None and line not in names:
        msg = f"there is no line {line}; there are: {', '.join(names)}"
        raise DesignError(msg)
    before = approve(application)
    remedies: list[Remedy] = []
    done: set[tuple[str, str, str]] = set()
    hopeless: list[Hopeless] = []
    while len(remedies) < ROUNDS:
        if tell:
            tell(len(remedies), ROUNDS)
        asking = (p for p in problems(application, line=line) if _id(p) not in done)
        problem = next(asking, None)
        if problem is None:
            break
        found = answers(application, problem)
        ways = [a.kept(changed(application, a.offer)) for a in found if isinstance(a, Remedy)]
        ways.sort(key=lambda w: -w.survival.sure if w.survival else -CLASSES)
        if not ways:
            hopeless += (a for a in found[:1] if isinstance(a, Hopeless))
        if not ways or any(after.grade != "pass" for _, after in ways[0].answered):
            done.add(_id(problem))  # more cannot be had
        if ways:
            remedies.append(replace(ways[0], others=tuple(ways[1:])))
            application = changed(application, ways[0].offer)
    return Sizing(
        before=before,
        remedies=tuple(_together(application, remedies)),
        hopeless=tuple(hopeless),
        approval=approve(application) if remedies else before,
    )


def _together(application: Application, remedies: list[Remedy]) -> Iterator[Remedy]:
    """Yield remedies with those of the same part made one, each check as it is at the end."""
    same: dict[tuple[str, Kind, tuple[int, ...]], list[Remedy]] = {}
    for r in remedies:
        same.setdefault((r.offer.line, r.offer.kind, r.offer.parts), []).append(r)
    for (line, _, _), group in same.items():
        response = _response(application, line)
        offers = [r.offer for r in group]
        masses = [o.mass for o in offers]
        asked_by = {_id(was): (was, after) for r in reversed(group) for was, after in r.answered}
        yield Remedy(
            offer=replace(
                offers[-1],
                before=offers[0].before,
                amount=sum(o.amount for o in offers),
                mass=None if None in masses else sum(m for m in masses if m is not None),
            ),
            answered=tuple(
                (was, _after(response, was) or after) for was, after in reversed(asked_by.values())
            ),
            worse=group[-1].worse,
            others=group[0].others if len(group) == 1 else (),
        ).kept(application)


def next_sizes(application: Application, checks: Iterable[Check]) -> dict[tuple[str, str], Remedy]:
    """Return the tube or joint that answers each of some failures, by line and quantity.

    For whoever has no time for all of `sizing`: one of each, asked by itself; what only warns
    is not.
    """
    found: dict[tuple[str, str], Remedy] = {}
    for one in checks:
        kind = next(iter(WAYS.get(one.quantity, ())), None)
        known = (one.line, one.quantity) in found
        if kind in ("tube", "joint") and one.grade == "fail" and not known:
            (answer,) = answers(application, one, kinds=(kind,))
            if isinstance(answer, Remedy):
                found[one.line, one.quantity] = answer
    return found


def problems(application: Application, *, line: str | None = None) -> list[Check]:
    """Return the checks that another part might answer, the worst first, one a quantity and part.

    Of quantities that are not sought at every operating point: see `WAYS`.
    """
    worst: dict[tuple[str, str, str], Check] = {}
    for installed in application.lines:
        if line not in (None, installed.line.name):
            continue
        response = respond(application, demand(resolve(application, installed)))
        bad = (c for c in checks_of(response) if c.quantity in WAYS and c.grade != "pass")
        for one in sorted(bad, key=_badness):
            worst.setdefault(_id(one), one)
    return sorted(worst.values(), key=_badness)


def _badness(of: Check) -> tuple[int, float, bool]:
    """Return what checks are sorted by: a shaft goes before the line that is as bad for it."""
    return -GRADES.index(of.grade), of.margin, not of.part.number


def _id(of: Check) -> tuple[str, str, str]:
    return of.line, of.quantity, str(of.part)


# --------------------------------------------------------------------------- what is tried


def answers(
    application: Application, problem: Check, *, kinds: Sequence[Kind] | None = None
) -> tuple[Remedy | Hopeless, ...]:
    """Return the smallest offer of each kind that answers a check, or that none does."""
    before = _worst(_response(application, problem.line))
    return tuple(
        _smallest(application, _offers(application, problem, kind), problem, before)
        for kind in (WAYS[problem.quantity] if kinds is None else kinds)
    )


Worst: TypeAlias = dict[tuple[str, str, str], Check]
"""The worst check of each quantity, state and part of a line."""


def _smallest(
    application: Application, offers: Iterator[Offer], problem: Check, before: Worst
) -> Remedy | Hopeless:
    """Return the first offer that answers a check and makes nothing worse, or what comes nearest.

    Of a check that fails that is the first after which nothing fails that did not.
    """
    nearest: Remedy | None = None
    blocked: Hopeless | None = None
    for offer in offers:
        try:
            response = _response(changed(application, offer), offer.line)
            after = _after(response, problem)  # quick: it alone
            if after is None or GRADES.index(after.grade) >= GRADES.index(problem.grade):
                continue
            now = _worst(response)
        except DesignError:  # such a line cannot exist
            continue
        if before.keys() - now.keys():
            continue  # what was answered is not
        worse = tuple(
            c for key, c in now.items()
            if GRADES.index(c.grade) > (GRADES.index(before[key].grade) if key in before else 0)
        )  # fmt: skip
        found = Remedy(offer=offer, answered=((problem, after),), worse=worse)
        if after.grade == "pass" and not worse:
            return found
        fails = next((c for c in worse if c.grade == "fail"), None)
        if fails:
            blocked = blocked or Hopeless(problem=problem, offer=offer, fails=fails)
        elif problem.grade == "fail":
            nearest = nearest or found
    return nearest or blocked or Hopeless(problem=problem)


def _worst(response: Response) -> Worst:
    found: Worst = {}
    for c in sorted(checks_of(response), key=_badness):
        found.setdefault((c.quantity, c.state, str(c.part)), c)
    return found


def _response(application: Application, line: str) -> Response:
    installed = _installed(application, line)
    return respond(application, demand(resolve(application, installed)))


def _installed(application: Application, line: str) -> Installed:
    return next(i for i in application.lines if i.line.name == line)


def _after(response: Response, problem: Check) -> Check | None:
    """Return a check's quantity and part where it is worst now; None where it has no answer.

    With a joint of its own rating another limit may ask than before; a joint that nobody rates
    is no answer to the rating of another.
    """
    found: list[Check] = []
    limits = response.application.limits
    for question in asked(response, quantities={problem.quantity}):
        for k, part in enumerate(question.parts):
            if part == problem.part:
                states = range(len(question.values))
                every = [check(response, question, state, k) for state in states]
                if any(c is None and question.asks[s, k] for s, c in enumerate(every)):
                    return None
                found += filter(None, every)
    if problem.limit not in limits and all(c.limit in limits for c in found):
        return None
    return min(found, key=_badness, default=None)


# --------------------------------------------------------------------------- what is on offer


def _offers(application: Application, problem: Check, kind: Kind) -> Iterator[Offer]:
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


def _number(application: Application, problem: Check) -> int:
    """Return the number of the shaft, joint or bearing; of a whole line's whirl, its first shaft.

    First is the one of the lowest critical speed.
    """
    if problem.part.number:
        return int(problem.part.number)
    speeds = ANSWERED["critical_speed"].values(_response(application, problem.line))
    return 1 + int(np.nanmin(speeds, axis=-2).argmin())


def _tubes(application: Application, line: Line, number: int) -> Iterator[Offer]:
    """Yield all tubes of the catalogues for a shaft, the lightest first.

    Its yokes are welded to it: what is steel stays steel.
    """
    shaft = line.shafts[number - 1]
    now = shaft.tube.material.youngs_modulus if isinstance(shaft.tube, Tube) else None
    tubes: list[Tube] = [
        tube
        for tube in catalogue_of(application).every("tube")
        if now is None or abs(tube.material.youngs_modulus / now - 1) < ALIKE
    ]
    for tube in sorted(tubes, key=lambda t: t.mass_per_length):
        yield Offer(
            line=line.name, kind="tube", parts=(number,), part=tube, before=_called(shaft),
            mass=replace(shaft, tube=tube).mass - shaft.mass,
        )  # fmt: skip


def _called(shaft: Shaft) -> str:
    """Return what a shaft's tube is called, or its size in mm."""
    tube = shaft.tube
    if tube is None or tube.name:
        return tube.name if tube else ""
    return f"{tube.outer / mm:g}x{tube.wall / mm:g}" if isinstance(tube, Tube) else ""


def _joints(application: Application, line: Line, number: int) -> Iterator[Offer]:
    """Yield all crosses of the catalogues for joints that are of one size, the smallest first."""
    size = line.joints[number - 1] if line.joints else None
    of = catalogue_of(application)
    rated = (j for j in of.every("joint") if j.kind == "cross" and j.peak_torque)
    parts = tuple(k for k, other in enumerate(line.joints, 1) if other == size)
    for joint in sorted(rated, key=_size):
        yield Offer(
            line=line.name, kind="joint", parts=parts or (number,), part=joint,
            before=size.name if size else "",
            mass=_gained(joint, size, len(parts)),
        )  # fmt: skip


def _gained(joint: JointSize, size: JointSize | None, count: int) -> Kilogram | None:
    if size is None or size.mass is None or joint.mass is None:
        return None
    return count * (joint.mass - size.mass)


def _size(joint: JointSize) -> tuple[float, float]:
    return joint.peak_torque or inf, life_rating(joint) or inf


def _splits(application: Application, line: Line, number: int) -> Iterator[Offer]:
    """Yield ways to make a shaft shorter: a centre bearing of it along the line, nearest first."""
    if any(state.layouts for state in application.states):
        return  # every state says by itself where the joints are
    bearings = [b for b in (number - 1, number) if 1 <= b < len(line.shafts)]
    for size in np.arange(SPLIT, FARTHEST, SPLIT):
        for b in bearings:
            rearward = size if b < number else -size
            yield Offer(line=line.name, kind="split", parts=(b,), amount=float(rearward))


def _places(line: Line, number: int) -> Iterator[Offer]:
    """Yield places of a bearing on its shaft, the nearest first."""
    shaft = line.shafts[number - 1]
    assert shaft.centre_bearing is not None
    now = shaft.centre_bearing.from_rear_joint
    for size in np.arange(PLACE, float(shaft.length) / 2, PLACE):
        for rearward in (float(size), -float(size)):
            if NEAREST <= now - rearward <= shaft.length / 2:
                yield Offer(line=line.name, kind="bearing place", parts=(number,), amount=rearward)


# --------------------------------------------------------------------------- putting it in


def changed(application: Application, offer: Offer) -> Application:
    """Return the application with an offer in place."""
    installed = _installed(application, offer.line)
    line, layout = installed.line, installed.layout
    shafts, joints = list(line.shafts), list(line.joints)
    match offer.kind:
        case "tube":
            assert not isinstance(offer.part, JointSize)
            (number,) = offer.parts
            shafts[number - 1] = _with_tube(shafts[number - 1], offer.part)
        case "joint":
            assert isinstance(offer.part, JointSize)
            for number in offer.parts:
                joints[number - 1] = offer.part
        case "bearing place":
            (number,) = offer.parts
            bearing = shafts[number - 1].centre_bearing
            assert bearing is not None
            place = bearing.from_rear_joint - offer.amount
            shafts[number - 1] = replace(
                shafts[number - 1], centre_bearing=replace(bearing, from_rear_joint=place)
            )
        case "split":
            (number,) = offer.parts
            points = np.array(layout.points)
            # Joint b + 1 hangs behind bearing b: along the shaft it goes into, so that the
            # line stays where it was.
            along = layout.directions[..., number + (1 if offer.amount > 0 else 0), :]
            points[..., number, :] += offer.amount * along
            ends = layout.directions
            layout = from_points(points, gearbox=ends[..., 0, :], pinion=ends[..., -1, :])
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
