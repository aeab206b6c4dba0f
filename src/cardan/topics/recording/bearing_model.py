"""An application's centre bearing at the torques and speeds of a recording: its force by orders.

A resonance that is passed remembers: what its modes keep of a changing speed is added by their
poles to the force of a steady one.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from cardan.application.layout_writer import yaml_address_of_line
from cardan.application.yaml_edit import YamlEditor
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.core.arrays import ArrayLike, ComplexArray, FloatArray, IntArray
from cardan.core.errors import DesignError
from cardan.core.labels import Part
from cardan.model.application import Application
from cardan.model.layout import Layout, unit_vector
from cardan.model.parts import Line
from cardan.physics.kinematics.joint_chain import cross_product
from cardan.physics.loads.centre_bearing import bearing_forces
from cardan.physics.loads.rubber_mount import MountedLine
from cardan.physics.signals.order_cuts import OrderWindows, order_windows
from cardan.physics.signals.shaft_angle import ShaftAngle
from cardan.physics.vehicle.state_demand import (
    demand_with_axle_moved_by_torque,
    line_state_demand,
    resolve_line_references,
)
from cardan.topics.recording.shaft_signals import MAX_TACHO_LAG_S

FITTED_ORDERS = (1.0, 2.0, 4.0)
"""Orders that are held against each other."""

STIFFNESS_NAMES = "vertical", "lateral"
"""Names of a bearing's stiffnesses."""

MAX_SPEED_TO_ANGLE_INTEGRATION_S = 10.0
"""Seconds over which an angle from a channel of speed is trusted to keep its zero."""

MAX_ANALYSED_DURATION_S = 900.0
"""Seconds of a recording that are looked at, in stretches spread over all of it."""

FINE_MODE_SIMULATION_RATE_HZ, COARSE_MODE_SIMULATION_RATE_HZ = 250.0, 60.0
"""Samples a second at which a mode's memory is stepped: of waves that turn one way. The coarser
clock, a fifth of a standard deviation off at most, is for the search among many places."""

MAX_KEPT_FORCE_COUNT, MAX_KEPT_POLE_COUNT = 40, 480
"""Lines whose forces, and poles whose part in an order, are kept for the next of a search: those of
all slopes at a place."""


@dataclass(frozen=True)
class MeasurementWindows:
    """The recording as the model sees it: windows, and the fine clock between them."""

    at: OrderWindows
    torque: FloatArray  # (W,)
    block: IntArray  # (W,), of one angle's zero
    rate: float  # of the fine clock, Hz
    fine_angle: FloatArray  # turns on it
    fine_speed: FloatArray
    fine_torque: FloatArray
    place: IntArray  # fine samples of all windows, one after the other
    start: IntArray  # where each window begins in `place`
    weight: FloatArray  # of each, sum 1 a window

    def met(self, z: ComplexArray, order: float) -> ComplexArray:
        """Amplitude (W,) of an order in a turning signal (fine,), as the cuts meet it."""
        return np.add.reduceat(z[self.place] * self._against[order], self.start)

    @cached_property
    def _against(self) -> dict[float, Any]:
        """What an order is met with: windows' weights that turn back."""
        angle = self.fine_angle[self.place]
        return {k: self.weight * np.exp(-2j * np.pi * k * angle) for k in FITTED_ORDERS}

    @cached_property
    def waves(self) -> dict[float, Any]:
        """The load of each order on the fine clock: of unbalance, the speed's square."""
        loads = {k: self.fine_speed**2 if k == 1 else self.fine_torque for k in FITTED_ORDERS}
        return {k: v * np.exp(2j * np.pi * k * self.fine_angle) for k, v in loads.items()}

    @cached_property
    def turning(self) -> dict[float, Any]:
        """How each order turns on the fine clock: its speed 1/s, and how far back in a step."""
        speeds = {k: 2j * np.pi * k * self.fine_speed for k in FITTED_ORDERS}
        return {k: (W, np.exp(-W / self.rate)) for k, W in speeds.items()}

    @cached_property
    def _met_by_pole(self) -> dict[tuple[complex, float], ComplexArray]:
        return {}

    def met_by_poles(self, poles: ComplexArray, order: float) -> ComplexArray:
        """Return what poles (m,) make of the load of an order, as the cuts meet it, (m, W).

        A search changes few numbers at a time, and so few poles: the others are kept.
        """
        kept, keys = self._met_by_pole, [(complex(p), order) for p in poles]
        for key in keys:
            if key not in kept:
                kept[key] = self.met(stepped_pole(self, *key), order)
        found = np.stack([kept[key] for key in keys])
        discard_oldest(kept, MAX_KEPT_POLE_COUNT)
        return found

    def load(self, order: float) -> FloatArray:
        """Return the load of an order in each window, (W,)."""
        return self.at.speed**2 if order == 1 else self.torque


class BearingModel:
    """An application's bearing in one state, at the torques and speeds of a recording."""

    def __init__(
        self, application: Application, *, state: str, bearing: int, scene: MeasurementWindows
    ) -> None:
        alone = replace(
            application,
            states=tuple(s for s in application.states if s.name == state),
        )
        if not alone.states:
            names = ", ".join(s.name for s in application.states)
            msg = f"no state {state!r}; there are: {names}"
            raise DesignError(msg)
        asked = line_state_demand(resolve_line_references(alone, alone.lines[0]))
        self.response: LineResponse = compute_line_response(alone, asked)
        held = self.response.mounts.mounted_line
        if held is None:
            msg = (
                "a recording is held against a line on its rubber: the application has to give "
                "tubes and the stiffness of a centre bearing"
            )
            raise DesignError(msg)
        self.held: MountedLine = held
        if not 1 <= bearing <= held.stiffness.shape[-2]:
            count = held.stiffness.shape[-2]
            msg = f"line {alone.lines[0].line.name} has {count} centre bearings, not a {bearing}."
            raise DesignError(msg)
        self.bearing, self.scene = bearing - 1, scene
        self._kept: dict[bytes, tuple[ComplexArray, FloatArray]] = {}
        torque = scene.torque[:, None]
        speed = 2 * np.pi * scene.at.speed[:, None]
        under = demand_with_axle_moved_by_torque(
            asked, torque=torque, speed=speed, coasts=torque < 0
        )
        self.layout: Layout = self.response.layout_for(under)
        self.torque, self.speed = torque, speed
        hung = 2 * np.pi * np.array(self.hung(held))
        passed = hung[hung < 4 * speed.max()]
        # Of a drive that comes near none, the lowest.
        self.usual = float(np.exp(np.log(passed if passed.size else hung.min()).mean()))
        self.shaft = [k for k, s in enumerate(self.response.line.shafts) if s.centre_bearing][
            self.bearing
        ]

    def lossy(self, held: MountedLine, law: float, order: float) -> MountedLine:
        """Return the line with the loss of its rubber as it is at an order of each window."""
        swift = (order * self.speed / self.usual) ** law
        return replace(held, loss=held.loss * swift[..., None])

    def forces(self, held: MountedLine, phases: FloatArray, law: float) -> ComplexArray:
        """Force (W, K, 3) N on the bearing; order 1 of 1 kg m at the rear of its shaft.

        `mean` is then its mean. The forces of a few lines are kept: a bracket's mode changes none.
        """
        asked = array_bytes(held.stiffness, held.loss, phases, law)
        if asked not in self._kept:
            self._kept[asked] = self._forces(held, phases, law)
            discard_oldest(self._kept, MAX_KEPT_FORCE_COUNT)
        waves, self.mean = self._kept[asked]
        return waves

    def _forces(
        self, held: MountedLine, phases: FloatArray, law: float
    ) -> tuple[ComplexArray, FloatArray]:
        """Return what `forces` does, and the mean force (W, 3) N."""
        r = self.response
        run = bearing_forces(
            self.layout, r.line, phases, torque=self.torque, speed=self.speed,
            held=self.lossy(held, law, 2.0), inertias=r.inputs.shaft_inertias,
        )  # fmt: skip
        waves = run.waves[:, 0, self.bearing]
        side = unit_vector(cross_product(held.shaft_directions, np.array([0.0, 0.0, 1.0])))
        turning = (side - 1j * cross_product(held.shaft_directions, side))[..., self.shaft, :]
        push = (turning[..., None, :] @ held.rear[..., self.shaft, :, :])[..., 0, :]
        once = self.lossy(held, law, 1.0).response(
            push * self.speed[..., None] ** 2, frequency=self.speed, speed=self.speed,
            torque=self.torque,
        )  # fmt: skip
        orders = np.stack(
            [once.bearing_forces[:, 0, self.bearing], waves[:, 0], waves[:, 1]], axis=1
        )
        return orders, run.mean[:, 0, self.bearing]

    def hung(self, held: MountedLine) -> tuple[float, ...]:
        """Return the frequencies Hz of the line on its rubber, in the mean of the torque."""
        modes = held.modes(torque=float(np.sqrt(np.mean(self.torque**2))))
        return tuple(np.sort(modes.frequency[0] / (2 * np.pi)).tolist())

    def poles(
        self, held: MountedLine, mode: tuple[float, float] | None, law: float
    ) -> ComplexArray:
        """Return the poles that a drive through its speeds can shake, 1/s."""
        mean = float(np.sqrt(np.mean(self.torque**2)))
        modes = held.modes(torque=mean)
        f = modes.frequency[0]
        d = np.minimum(modes.damping_ratio[0] * (f / self.usual) ** law, 0.5)
        top = 1.3 * 4 * float(self.speed.max())
        near = f < top
        found = [_pole(w, z) for w, z in zip(f[near].tolist(), d[near].tolist(), strict=True)]
        if mode is not None:
            found.append(_pole(2 * np.pi * mode[0], mode[1]))
        return np.array(found)


def _pole(w: float, z: float) -> complex:
    """Return the pole of a mode, 1/s; one damped beyond 1, which a search may try, creeps back."""
    return w * (-z + 1j * complex(1 - z * z) ** 0.5)


def bracket_mode_gain(mode: tuple[float, float] | None, W: FloatArray) -> ComplexArray:
    """Response (...) of a bracket's mode at W rad/s, 1 where it stands."""
    if mode is None:
        return np.ones_like(W, dtype=complex)
    r = W / (2 * np.pi * mode[0])
    return 1 / (1 - r * r + 2j * mode[1] * r)


def pole_shares(
    scene: MeasurementWindows, steady: ComplexArray, poles: ComplexArray, order: float
) -> ComplexArray:
    """Return what each pole has in an order's steady amplitude per load, (C, W) to (C, poles)."""
    W, load = 2 * np.pi * order * scene.at.speed, scene.load(order)
    basis = 1 / (1j * W - poles[:, None])  # (poles, W)
    scale = np.abs(basis).max(-1)
    top = float(np.abs(W).max())
    rest = np.stack([np.ones_like(W), (W / top) ** 2, 1j * W / top])
    rows = np.concatenate([basis / scale[:, None], rest]) * load
    gram = rows @ np.conj(rows).T
    gram += 1e-8 * np.trace(gram).real * np.eye(len(rows))
    right = steady @ np.conj(rows).T
    return np.linalg.solve(gram.T, right.T).T[:, : poles.size] / scale


def stepped_pole(scene: MeasurementWindows, pole: complex, order: float) -> ComplexArray:
    """Return how one pole follows the load of an order on the fine clock, (fine,).

    Stepped so that a steady load is followed exactly.
    """
    from scipy.signal import lfilter

    W, back = scene.turning[order]
    step = np.exp(pole / scene.rate)
    return lfilter([1], [1, -step], scene.waves[order] * (1 - step * back) / (W - pole))


def remembered_response(
    scene: MeasurementWindows, steady: ComplexArray, poles: ComplexArray, order: float
) -> ComplexArray:
    """Return what modes add to an order's steady amplitude (C, W), as its speed and load change.

    The steady response per load is a sum over poles; each of them is stepped through the
    drive, met like the signal, and its steady part is taken off.
    """
    load = scene.load(order)
    if not poles.size or not np.abs(load).max() > 0:
        return np.zeros_like(steady)
    basis = 1 / (2j * np.pi * order * scene.at.speed - poles[:, None])
    met = scene.met_by_poles(poles, order)
    return pole_shares(scene, steady, poles, order) @ (met - basis * load)


def array_bytes(*numbers: ArrayLike) -> bytes:
    """Return numbers as a key of what was computed from them."""
    return b"".join(np.asarray(n, dtype=float).tobytes() for n in numbers)


def discard_oldest(kept: dict[Any, Any], most: int) -> None:
    """Take out what was kept first, down to so many."""
    while len(kept) > most:
        del kept[next(iter(kept))]


def line_file_address(r: LineResponse) -> str:
    """Return where the line stands in its application's file."""
    written = r.application.written
    assert written is not None
    return yaml_address_of_line(r.demand.installed, YamlEditor(written.text, written.name))


def check_stiffness_keys(of: LineResponse) -> None:
    """Refuse a file that gives rubber by keys that what is found cannot be written to."""
    numbers = of.application.written.numbers if of.application.written else {}
    for name, _, place, _ in identifiable_numbers(of.line):
        if name in STIFFNESS_NAMES and (at := f"{line_file_address(of)}.{place}") not in numbers:
            msg = (
                f"{at}: a recording is held against vertical_stiffness_N_mm and "
                "lateral_stiffness_N_mm: give both in place of what says it otherwise"
            )
            raise DesignError(msg)


def identifiable_numbers(of: Line) -> Iterator[tuple[str, Part, str, float]]:
    """Yield what a recording may identify of a line: name, part, address, and the file's value.

    nan where the file says nothing.
    """
    nth = 0
    for k, s in enumerate(of.shafts):
        b = s.centre_bearing
        nth += b is not None
        if b is None or b.stiffness is None:
            continue
        where, part = f"shafts[{k + 1}].centre_bearing", Part("centre bearing", nth)
        for name, value in zip(STIFFNESS_NAMES, b.stiffness, strict=True):
            yield name, part, f"{where}.{name}_stiffness_N_mm", float(value)
        loss = np.nan if b.loss_factor is None else float(b.loss_factor)
        yield "loss", part, f"{where}.loss_factor", loss
    for k, s in enumerate(of.shafts):
        yield "phase", Part("shaft", k + 1), f"shafts[{k + 1}].phase_deg", float(s.phase)


def measurement_windows(
    angle: ShaftAngle, torque: tuple[FloatArray, float], seconds: float,
    *, rate: float = FINE_MODE_SIMULATION_RATE_HZ, few: slice = slice(None),
) -> MeasurementWindows:  # fmt: skip
    """Return windows of a recording, of a long one those in stretches spread over it.

    A few of them if fewer are requested, and a clock of so many Hz between them.
    """
    at = order_windows(angle.rotation, until=seconds)
    if at.time.size < 12:
        msg = (
            "the shaft turns too little to be held against a model: 12 windows of 8 turns at least"
        )
        raise DesignError(msg)
    stretch = (at.start / MAX_SPEED_TO_ANGLE_INTEGRATION_S).astype(int)
    wanted = np.unique(stretch)[:: int(np.ceil(seconds / MAX_ANALYSED_DURATION_S))]
    keep = np.flatnonzero(np.isin(stretch, wanted))[few]
    at = OrderWindows(*(getattr(at, n)[keep] for n in ("start", "stop", "first", "turns")))
    stretch = stretch[keep]
    read, often = torque
    known = np.flatnonzero(~np.isnan(read))
    if not known.size:
        msg = "the torque says nothing: no value in all the recording"
        raise DesignError(msg)
    clock = np.arange(int(seconds * rate)) / rate
    load = np.interp(clock, known / often, read[known])
    angles, speed = angle.rotation.at(clock), angle.rotation.speed(clock)
    first = np.floor(at.start * rate).astype(int)
    last = np.minimum(np.ceil(at.stop * rate).astype(int) + 1, clock.size)
    place = np.concatenate([np.arange(a, b) for a, b in zip(first, last, strict=True)])
    start = np.concatenate([[0], np.cumsum(last - first)[:-1]])
    each = np.repeat(np.arange(at.time.size), last - first)
    share = (angles[place] - at.first[each]) / at.turns[each]
    weight = np.where((share >= 0) & (share <= 1), 1 - np.cos(2 * np.pi * share), 0.0)
    weight = weight * speed[place]
    weight = weight / np.add.reduceat(weight, start)[each]
    mean = np.add.reduceat(load[place] * weight, start)
    # A tacho counts every turn; a channel of speed loses its zero sooner or later.
    counted = angle.trusted and angle.lag <= MAX_TACHO_LAG_S
    block = np.zeros(at.time.size, int) if counted else np.unique(stretch, return_inverse=True)[1]
    return MeasurementWindows(at, mean, block, rate, angles, speed, load, place, start, weight)
