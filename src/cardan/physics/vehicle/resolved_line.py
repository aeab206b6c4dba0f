"""A line in its vehicle, resolved once: what demand reads, and is not looked up again."""

import numpy as np

from cardan.core.arrays import BoolArray, FloatArray
from cardan.core.errors import DesignError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import NewtonMetre, RadianPerSecond
from cardan.model.application import Application, InstalledLine, Obstacle, VehicleState
from cardan.model.layout import Layout
from cardan.model.parts import Line
from cardan.model.vehicle import (
    Axle,
    Engine,
    Gearbox,
    Linkage,
    LoadState,
    Suspension,
    SuspensionState,
    Tyre,
    Vehicle,
)
from cardan.physics.vehicle.suspension import (
    OVERLOAD_STATE_AXLE_LOAD_FACTOR,
    STATES_AT_SUSPENSION_TRAVEL_LIMIT,
)
from cardan.physics.vehicle.torque import DIRECT_DRIVE, GearTable, gear_table, reverse_gear_table

# A hanging axle counts as empty: it hangs for a moment, in a vehicle that still drives.
_LOADED_AS: dict[SuspensionState, str] = {
    "full rebound": "empty", "rebound": "empty", "curb": "curb", "empty": "empty",
    "gvw": "gvw", "overload": "gvw", "jounce": "gvw", "windup": "gvw", "windup brake": "gvw",
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class LoadStateWithMultiplier:
    """What loads the vehicle in a state: a load state, so many times over.

    `load_state` is None where the vehicle gives none of that name.
    """

    name: str
    load_factor: float
    load_state: LoadState | None

    @property
    def key(self) -> tuple[str, float]:
        """What distinguishes it from others."""
        return self.name, self.load_factor


@dataclass(frozen=True, kw_only=True, eq=False)
class LineWithResolvedReferences:
    """A line with all that its demand follows from, looked up in the application once.

    Attributes
    ----------
    installed
        The line in its place.
    states
        The S states it is evaluated in.
    load_states
        What loads the vehicle in each of them.
    reference_state
        The state in which its layout is given.
    reference_load_state
        What loads the vehicle in that.
    own_layouts : S layouts or None
        Where a state itself says how the line runs.
    suspension
        What moves its axle; the application's own is that of the rear axles.
    linkage_ahead
        What guides the axle that it starts at; None where the frame holds its joint 1.
    max_torque_share
        The largest part it may have of the gearbox output's torque: behind a locked
        differential all that goes there.
    nominal_torque_share
        What it has of that torque while all wheels hold.
    traction_share
        Part of what all wheels push that its own do, while it has its largest share.
    torque, coast_torque, speed : N m, N m, rad/s
        Of the gearbox output where the application says so, in place of engine and tyres.
    gears
        Its torque and speed gear by gear; None without an engine.
    reverse_gears
        The same in reverse; None if the ratio is not given.
    obstacles
        What it must clear.
    """

    installed: InstalledLine
    states: tuple[VehicleState, ...]
    load_states: tuple[LoadStateWithMultiplier, ...]
    reference_state: VehicleState
    reference_load_state: LoadStateWithMultiplier
    own_layouts: tuple[Layout | None, ...]
    vehicle: Vehicle | None
    engine: Engine | None
    gearbox: Gearbox
    tyre: Tyre | None
    suspension: Suspension | None
    linkage_ahead: Linkage | None
    max_torque_share: float
    nominal_torque_share: float
    traction_share: float
    torque: NewtonMetre | None
    coast_torque: NewtonMetre | None
    speed: RadianPerSecond | None
    gears: GearTable | None
    reverse_gears: GearTable | None
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
    def forward_sign(self) -> float:
        """Sign of the vehicle's x and pitch in the line's frame: they turn on the way forward."""
        return -1.0 if self.installed.forward else 1.0

    @property
    def placed_by_suspension(self) -> BoolArray:
        """Where the suspension places the axle, (S,).

        A state's own layout is the truth about it, and the frame holds a transfer case.
        """
        return np.array([o is None and self.installed.drives != "all" for o in self.own_layouts])

    @property
    def between_stops(self) -> BoolArray:
        """Where the suspension carries the axle's load between its ends, (S,).

        A state of no kind lies as the reference does.
        """
        kinds = [s.kind or self.reference_state.kind for s in self.states]
        return np.array([kind not in STATES_AT_SUSPENSION_TRAVEL_LIMIT for kind in kinds])

    @property
    def bearing_offsets(self) -> FloatArray | None:
        """How far the frame has moved each centre bearing, (..., S, n-2, 3) m; None if nowhere."""
        own = [s.bearing_offsets.get(self.line.name, {}) for s in self.states]
        if not any(own):
            return None
        count = len(self.line.shafts) - 1
        zero = (0.0, 0.0)
        each = [
            np.asarray(of.get(bearing, zero)[axis], dtype=float)
            for of in own
            for bearing in range(1, count + 1)
            for axis in (0, 1)
        ]  # fmt: skip
        # A number that has variants comes as (V, 1), the last axis that of the states.
        columns = np.broadcast_arrays(*(v[..., 0] if v.ndim else v for v in each))
        across = np.stack(columns, axis=-1)
        across = across.reshape(*across.shape[:-1], len(own), count, 2)
        return np.concatenate([np.zeros_like(across[..., :1]), across], axis=-1)

    def in_suspension_state(self, kind: SuspensionState) -> BoolArray:
        """Return where the suspension is in a state, (S,)."""
        return np.array([s.kind == kind for s in self.states])


def resolve_line_references(
    application: Application, installed: InstalledLine
) -> LineWithResolvedReferences:
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
    suspension = _suspension_of(application, installed)
    reference = VehicleState(name="reference", kind=suspension.reference if suspension else "gvw")
    usual = _usual_share(installed)
    share = _largest_share(application, installed)
    engine, gearbox = application.engine, application.gearbox or DIRECT_DRIVE
    line_over_output = {"torque_ratio": share, "speed_ratio": installed.speed_ratio}
    return LineWithResolvedReferences(
        installed=installed,
        states=states,
        load_states=tuple(_loading(application.vehicle, s) for s in states),
        reference_state=reference,
        reference_load_state=_loading(application.vehicle, reference),
        own_layouts=tuple(_own(installed, s) for s in states),
        vehicle=application.vehicle,
        engine=engine,
        gearbox=gearbox,
        tyre=application.tyre,
        suspension=suspension,
        linkage_ahead=_linkage_ahead(application, installed),
        max_torque_share=share,
        nominal_torque_share=usual,
        traction_share=np.minimum(share / installed.torque_ratio, 1.0),
        torque=application.torque,
        coast_torque=application.coast_torque,
        speed=application.speed,
        gears=engine and gear_table(engine, gearbox, **line_over_output),
        reverse_gears=engine and reverse_gear_table(engine, gearbox, **line_over_output),
        obstacles=tuple(o for o in application.obstacles if o.line == installed.line.name),
    )


def _suspension_of(application: Application, installed: InstalledLine) -> Suspension | None:
    """Return what moves a line's axle; the application's own is that of the rear axles."""
    if installed.suspension is None and installed.drives == "rear":
        return application.suspension
    return installed.suspension


def _linkage_ahead(application: Application, installed: InstalledLine) -> Linkage | None:
    """Return what guides the axle that a line starts at: that of the line which ends there."""
    if installed.output_joint is None:
        return None
    ahead = next((i for i in application.lines if installed.starts_at_axle_of(i)), installed)
    suspension = _suspension_of(application, ahead)
    return suspension.linkage if suspension else Linkage()


def _usual_share(installed: InstalledLine) -> float:
    """Return what a line has of the gearbox output's torque while all wheels hold."""
    return installed.torque_ratio * installed.torque_share


def _largest_share(application: Application, installed: InstalledLine) -> float:
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
            _usual_share(ahead) for ahead in application.lines if installed.starts_at_axle_of(ahead)
        ),
    ])  # fmt: skip


def _loading(vehicle: Vehicle | None, state: VehicleState) -> LoadStateWithMultiplier:
    """Return what loads the vehicle in a state."""
    loads = {load.name: load for load in vehicle.loads} if vehicle else {}
    if state.load is not None and state.load not in loads:
        msg = f"state {state.name} has no load state {state.load}; there are: {', '.join(loads)}"
        raise DesignError(msg)
    kind = state.kind or "gvw"
    name = state.load or (kind if kind in loads else _LOADED_AS[kind])
    times = OVERLOAD_STATE_AXLE_LOAD_FACTOR if kind == "overload" and name != "overload" else 1.0
    return LoadStateWithMultiplier(name=name, load_factor=times, load_state=loads.get(name))


def axle_height_grouping_key(state: VehicleState, loading: LoadStateWithMultiplier) -> object:
    """Return what places the axle in a state: states alike in it are equally high."""
    return state.kind if state.kind in STATES_AT_SUSPENSION_TRAVEL_LIMIT else loading.key


def _own(installed: InstalledLine, state: VehicleState) -> Layout | None:
    """Return a state's own layout of a line, if it has one."""
    own = (state.layouts or {}).get(installed.line.name)
    if own is not None and own.points.shape[-2] != installed.line.joint_count:
        msg = (
            f"line {installed.line.name} has {installed.line.joint_count} joints in every "
            "state; a state gives it another number"
        )
        raise DesignError(msg)
    return own
