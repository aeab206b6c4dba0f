"""A line in its vehicle, resolved once: what demand reads, and nobody looks up again."""

import numpy as np

from cardan.base.arrays import BoolArray
from cardan.base.errors import DesignError
from cardan.base.frozen import dataclass
from cardan.base.units import NewtonMetre, RadianPerSecond
from cardan.demand.suspension import AT_LIMIT, OVERLOAD
from cardan.demand.torque import DIRECT, Gears, gears, reverse_gears
from cardan.model.application import Application, Installed, Obstacle, State
from cardan.model.layout import Layout
from cardan.model.parts import Line
from cardan.model.vehicle import (
    Axle,
    Engine,
    Gearbox,
    LoadState,
    Suspension,
    SuspensionState,
    Tyre,
    Vehicle,
)

# A hanging axle counts as empty: it hangs for a moment, in a vehicle that still drives.
_LOADED_AS: dict[SuspensionState, str] = {
    "full rebound": "empty", "rebound": "empty", "curb": "curb", "empty": "empty",
    "gvw": "gvw", "overload": "gvw", "jounce": "gvw", "windup": "gvw", "windup brake": "gvw",
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Loading:
    """What loads the vehicle in a state: a load state, so many times over.

    `load` is None where the vehicle gives none of that name.
    """

    name: str
    times: float
    load: LoadState | None

    @property
    def key(self) -> tuple[str, float]:
        """What tells it from others."""
        return self.name, self.times


@dataclass(frozen=True, kw_only=True, eq=False)
class ResolvedLine:
    """A line with all that its demand follows from, looked up in the application once.

    Attributes
    ----------
    installed
        The line in its place.
    states
        The S states it is asked in.
    loadings
        What loads the vehicle in each of them.
    reference
        The state in which its layout is given.
    reference_loading
        What loads the vehicle in that.
    own : S layouts or None
        Where a state itself says how the line runs.
    suspension
        What moves its axle; the application's own is that of the rear axles.
    share
        The largest part it may have of the gearbox output's torque: behind a locked
        differential all that goes there.
    usual_share
        What it has of that torque while all wheels hold.
    push_share
        Part of what all wheels push that its own do, while it has its largest share.
    torque, coast_torque, speed : N m, N m, rad/s
        Of the gearbox output where the application says so, in place of engine and tyres.
    gears
        Its torque and speed gear by gear; None without an engine.
    reverse
        The same in reverse; None where nobody gives the ratio.
    obstacles
        What it must clear.
    """

    installed: Installed
    states: tuple[State, ...]
    loadings: tuple[Loading, ...]
    reference: State
    reference_loading: Loading
    own: tuple[Layout | None, ...]
    vehicle: Vehicle | None
    engine: Engine | None
    gearbox: Gearbox
    tyre: Tyre | None
    suspension: Suspension | None
    share: float
    usual_share: float
    push_share: float
    torque: NewtonMetre | None
    coast_torque: NewtonMetre | None
    speed: RadianPerSecond | None
    gears: Gears | None
    reverse: Gears | None
    obstacles: tuple[Obstacle, ...]

    @property
    def line(self) -> Line:
        """Its parts."""
        return self.installed.line

    @property
    def axle(self) -> Axle | None:
        """The axle its pinion is part of."""
        return self.installed.axle

    @property
    def ahead(self) -> float:
        """Sign of the vehicle's x and pitch in the line's frame: they turn on the way forward."""
        return -1.0 if self.installed.forward else 1.0

    @property
    def free(self) -> BoolArray:
        """Where the suspension places the axle, (S,).

        A state's own layout is the truth about it, and the frame holds a transfer case.
        """
        return np.array([o is None and self.installed.drives != "all" for o in self.own])

    @property
    def rests(self) -> BoolArray:
        """Where the suspension carries the axle's load between its ends, (S,).

        A state of no kind lies as the reference does.
        """
        kinds = [s.kind or self.reference.kind for s in self.states]
        return np.array([kind not in AT_LIMIT for kind in kinds])

    def winds(self, kind: SuspensionState) -> BoolArray:
        """Return where the suspension is in a state, (S,)."""
        return np.array([s.kind == kind for s in self.states])


def resolve(application: Application, installed: Installed) -> ResolvedLine:
    """Return one of an application's lines with all that its demand follows from.

    Raises
    ------
    DesignError
        If the application has no state, or a state names what there is not.
    """
    states = application.states
    if not states:
        msg = f"application {application.title} has no state to check"
        raise DesignError(msg, about="states")
    suspension = installed.suspension
    if suspension is None and installed.drives == "rear":
        suspension = application.suspension
    reference = State(name="reference", kind=suspension.reference if suspension else "gvw")
    usual = _usual_share(installed)
    share = _largest_share(application, installed)
    engine, gearbox = application.engine, application.gearbox or DIRECT
    line_over_output = {"torque_ratio": share, "speed_ratio": installed.speed_ratio}
    return ResolvedLine(
        installed=installed,
        states=states,
        loadings=tuple(_loading(application.vehicle, s) for s in states),
        reference=reference,
        reference_loading=_loading(application.vehicle, reference),
        own=tuple(_own(installed, s) for s in states),
        vehicle=application.vehicle,
        engine=engine,
        gearbox=gearbox,
        tyre=application.tyre,
        suspension=suspension,
        share=share,
        usual_share=usual,
        push_share=np.minimum(share / installed.torque_ratio, 1.0),
        torque=application.torque,
        coast_torque=application.coast_torque,
        speed=application.speed,
        gears=engine and gears(engine, gearbox, **line_over_output),
        reverse=engine and reverse_gears(engine, gearbox, **line_over_output),
        obstacles=tuple(o for o in application.obstacles if o.line == installed.line.name),
    )


def _usual_share(installed: Installed) -> float:
    """Return what a line has of the gearbox output's torque while all wheels hold."""
    return installed.torque_ratio * installed.torque_share


def _largest_share(application: Application, installed: Installed) -> float:
    """Return the same where the wheels of the axle ahead hold nothing.

    A locked inter-axle differential then leaves it all to the line between the axles; an open
    one lets no side have more than it has of what the other slips with.
    """
    usual, between = _usual_share(installed), application.inter_axle
    if between is None or not between.locked:
        return usual
    return np.maximum.reduce([
        usual,
        *(
            _usual_share(ahead) for ahead in application.lines if installed.leaves(ahead)
        ),
    ])  # fmt: skip


def _loading(vehicle: Vehicle | None, state: State) -> Loading:
    """Return what loads the vehicle in a state."""
    loads = {load.name: load for load in vehicle.loads} if vehicle else {}
    if state.load is not None and state.load not in loads:
        msg = f"state {state.name} has no load state {state.load}; there are: {', '.join(loads)}"
        raise DesignError(msg)
    kind = state.kind or "gvw"
    name = state.load or (kind if kind in loads else _LOADED_AS[kind])
    times = OVERLOAD if kind == "overload" and name != "overload" else 1.0
    return Loading(name=name, times=times, load=loads.get(name))


def height(state: State, loading: Loading) -> object:
    """Return what places the axle in a state: states alike in it are equally high."""
    return state.kind if state.kind in AT_LIMIT else loading.key


def _own(installed: Installed, state: State) -> Layout | None:
    """Return a state's own layout of a line, if it has one."""
    own = (state.layouts or {}).get(installed.line.name)
    if own is not None and own.points.shape[-2] != installed.line.joint_count:
        msg = (
            f"line {installed.line.name} has {installed.line.joint_count} joints in every "
            "state; a state gives it another number"
        )
        raise DesignError(msg)
    return own
