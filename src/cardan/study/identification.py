r"""From a recording to the model and back: what of an application a gauge says is otherwise.

The order cuts of a gauge are held against what its application computes for the same torques
and speeds: the line on its rubber (`loads.running`), through the stress that a unit force on
the bearing makes at the gauge. What makes them agree is found by least squares,

$$\min_p \sum \frac{|a_k - g\, s\, H(k Ω)\, F_k(T, Ω; p) e^{i k θ_0}|^2}{σ^2}$$

over the orders k = 1, 2, 4: stiffness and loss of the rubber, yoke phases, the scale g of
each gauge, a mode H of the bracket, what is unbalanced. θ₀ is where the tacho's mark stands;
where the angle comes from a channel of speed it is free every 10 s.

A resonance that is passed remembers. F is of a steady speed; what its modes remember of a
changing one is added by their poles, so a quick run-up bends no stiffness.

Intervals are of 90 %: what the noise does to the answer, taken from blocks of windows together,
for neighbours err alike, and what the model leaves out. Of the force that is a share which is
alike at alike speeds, so it does not average out where a speed is passed again: its covariance
whitens what is left over. How the rubber's loss goes with frequency, what a bracket's own mode
raises and what a logger's filters delay moves with the rest, and is not told. Other places that
fit as well are in the interval. Gains are those of the plain sum above.
Source: derived from first principles; Ljung, System Identification (1999), ch. 7;
Cameron & Miller, A practitioner's guide to cluster-robust inference, J. Hum. Resour. 50 (2015);
Kennedy & O'Hagan, Bayesian calibration of computer models, J. R. Stat. Soc. B 63 (2001).
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from cardan.base.arrays import ComplexArray, FloatArray, IntArray
from cardan.base.errors import DesignError
from cardan.base.part import LINE, Part
from cardan.base.said import Said
from cardan.base.units import deg, mm
from cardan.demand.states import demand, demand_under, resolve
from cardan.fatigue.angle import Angle
from cardan.fatigue.background import Mode
from cardan.fatigue.cuts import Cuts, Windows, order_cuts, windows
from cardan.fatigue.orders import Rotation
from cardan.files.application import understood
from cardan.files.manuscript import Manuscript
from cardan.files.placing import line_address
from cardan.kinematics.chain import cross
from cardan.loads.rubber import LOSS, Suspended
from cardan.loads.running import running
from cardan.model.application import Application
from cardan.model.layout import Layout, unit
from cardan.model.parts import Line
from cardan.quantity.response import Response, respond
from cardan.study.agreement import backwards, disagreeing, unlike
from cardan.study.minima import Minimum, apart, least, searched, squares

ORDERS = (1.0, 2.0, 4.0)
"""Orders that are held against each other."""

SPRINGS = "vertical", "lateral"
"""Names of a bearing's stiffnesses."""

PRIOR = {"stiffness": 0.5, "loss": 0.7, "gain": 0.1, "askew": 0.1, "mode damping": 0.7}
"""How far the truth may lie from the file, one standard deviation of its logarithm, assumed."""

CROOKED = 3 * deg
"""How far a yoke phase may lie from its drawing, one standard deviation, assumed: welds, splines
with play. A wrong tooth is looked for by itself."""

LEFT_OUT = 0.02
"""Share of an amplitude that the model leaves out by itself in each window, assumed."""

ALIKE_OUT, OCTAVES = 0.06, (0.25, 1.0, 100.0)
"""Share of the force that the model leaves out alike at speeds so many octaves apart, one standard
deviation of each, assumed: however often a speed is passed, that does not average out
(`tests/verify/many_trucks.py`)."""

FAINT = 0.1
"""Standard deviations from which what is left out alike counts beside noise."""

RIVAL = 9.0
"""Misfit in variances by which another place may fit worse and still be the truth."""

LEAST = {"vertical": 0.03, "lateral": 0.03, "loss": 0.06, "gain": 0.025, "mode damping": 0.03}
"""Half of the narrowest interval that is told, relative: joints 2 mm from where they are drawn, and
gauges whose stress is that of a flange held otherwise, move the answers by as much
(`tests/verify/many_trucks.py`, `collector_day.py`)."""

SURE = 1.645
"""Standard deviations to either side of a 90 % interval."""

STRETCH = 10.0
"""Seconds over which an angle from a channel of speed is trusted to keep its zero."""

LONGEST = 900.0
"""Seconds of a recording that are looked at, in stretches spread over all of it."""

ASKEW = "askew"
"""What is computed of a gauge up over what is computed of it across, beyond its gain: is not told,
and makes intervals as wide as it leaves them."""

LAW = 0.7
"""Exponent of frequency by which the loss of rubber grows, one standard deviation, assumed: none
of an ideal one, 1 of a damper."""

SEATS, SEAT = ("seat sideways", "seat up"), (1 / 60) ** 2
"""By what times frequency squared a bracket's own mode, far above, raises what is felt each way:
one standard deviation, s², assumed; that of a mode at 60 Hz."""

NARROWED = 0.5
"""A parameter is told where its interval is narrower than this share of what was assumed."""

KEPT = 40
"""Forces that are remembered: most of what moves from the file does not change them."""

FINE, COARSE = 250.0, 60.0
"""Samples a second at which a mode's memory is stepped: of waves that turn one way. The coarser
clock, a fifth of a standard deviation off at most, is for the search among many places."""

ENOUGH = 120
"""Windows up to which all are looked at in that search."""

GOOD = 1.5
"""Misfit of a number, in variances, up to which the file's own parts explain a recording."""

UNLIKELY = 3.0
"""Standard deviations from what was assumed from which something else is looked for."""

ALIKE, UNLIKE = 0.97, 0.9
"""Cosine of a mode's shape with what a force does at the gauges from which they are alike, and
below which they are told apart."""

NEAR = 1.1
"""Ratio of frequencies up to which a mode may be one of the line on its rubber."""

ODDS = 14.0
"""Variances by which a shaft put together otherwise, or a mode, has to fit better to be likelier:
2 ln of a dozen places that are looked at, where one line of a hundred has it."""

BETTER = 0.3
"""Share of the misfit that another yoke phase or a mode of the bracket has to take away."""


# --------------------------------------------------------------------------- answers


UNIT = {
    "vertical": ("N/mm", 1 / mm), "lateral": ("N/mm", 1 / mm), "loss": ("", 1.0),
    "phase": ("deg", deg), "gain": ("", 1.0), "mode": ("Hz", 1.0), "mode damping": ("", 1.0),
    "unbalance": ("g mm", 1e-6),
}  # fmt: skip
"""What numbers are told in, and what one of it is in SI."""


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One number that a recording says something of, SI.

    Attributes
    ----------
    name
        vertical, lateral, loss, phase, gain, mode, mode damping or unbalance.
    part
        What it belongs to.
    was
        In the application's file; nan where it says nothing.
    value, low, high
        As found, and the 90 % interval.
    told
        Whether the recording says it.
    assumed
        Whether it does not because more of the interval is what was assumed than what it says.
    address
        Of its number in the application's file; "" where there is none.
    """

    name: str
    part: Part
    was: float
    value: float
    low: float
    high: float
    told: bool = True
    assumed: bool = False
    address: str = ""

    @property
    def unit(self) -> str:
        """Unit that it is told in, that of its key in the file."""
        return UNIT[self.name][0]

    def told_in_unit(self, value: float) -> float:
        """Return a value of it in that unit."""
        return value / UNIT[self.name][1]

    @property
    def differs(self) -> bool:
        """Whether what the file says lies outside the interval."""
        return not np.isnan(self.was) and not self.low <= self.was <= self.high

    @property
    def otherwise(self) -> bool:
        """Whether the recording contradicts the file."""
        return self.told and self.differs

    @property
    def rewritten(self) -> bool:
        """Whether the file has to say it anew: it says otherwise, or nothing."""
        return bool(self.address) and (self.otherwise or (self.told and bool(np.isnan(self.was))))


@dataclass(frozen=True, kw_only=True)
class Identification:
    """What a recording says of its application.

    Attributes
    ----------
    application, identified
        As written, and with the numbers that the recording tells.
    state, bearing
        Which geometry, and whose force the gauges feel.
    parameters
        What was found.
    gauges
        Their names.
    cuts
        Measured at each gauge, Pa.
    torque : (W,) N m
        Mean in each window.
    written, found : (gauges, K, W) Pa, complex
        Computed by the file, and by what was found, with the tacho's mark where it is.
    units : (gauges, 3) Pa/N
        What a unit force of the bearing does at each, as found.
    mean : (gauges, W) Pa
        Stress of the mean force, as found.
    mark : (W,) rad
        How far the gearbox's yoke is ahead of the tacho's mark, to half a turn.
    misfit : before and after
        Share of the measured order 2's energy that is not explained.
    hung : Hz
        Frequencies of the line on its rubber, as found.
    shaken
        Modes that the gauges feel beside the orders: what road and engine shake.
    doubts
        Why no number is told, if any.
    """

    application: Application
    identified: Application
    state: str
    bearing: int
    parameters: tuple[Parameter, ...]
    gauges: tuple[str, ...]
    cuts: Cuts
    torque: FloatArray
    written: ComplexArray
    found: ComplexArray
    units: FloatArray
    mean: FloatArray
    mark: FloatArray
    misfit: tuple[float, float]
    hung: tuple[float, ...] = ()
    shaken: tuple[Mode, ...] = ()
    doubts: tuple[Said, ...] = ()

    def way(self, mode: Mode) -> int | None:
        """Return which way a force on the bearing does the same to the gauges as a mode.

        Along the shaft 0, sideways 1 or up 2; None where it is none of them, or more than one:
        two gauges at least have to tell them apart.
        """
        shape = np.array(mode.shape)
        size = np.linalg.norm(self.units, axis=0) * np.linalg.norm(shape)
        alike = np.abs(shape @ self.units) / np.where(size > 0, size, np.inf)
        best, second = np.argsort(-alike)[:2]
        return int(best) if alike[best] > ALIKE and alike[second] < UNLIKE else None

    def line(self, mode: Mode) -> float | None:
        """Return the frequency Hz of the line on its rubber that a mode may be; None if none is."""
        low, found, high = mode.frequency
        near = [f for f in self.hung if low / NEAR <= f <= high * NEAR]
        return min(near, key=lambda f: abs(f - found)) if near else None

    def changes(self) -> dict[str, float | str | list[float]]:
        """Return what the file would say instead, by address, in its keys' units."""
        return {
            p.address: float(f"{p.told_in_unit(p.value):.4g}")
            for p in self.parameters
            if p.rewritten
        }

    def text(self) -> str:
        """Return the application's file with the numbers found; comments stay.

        Raises
        ------
        BadFile
            If a number cannot be written where it would stand.
        """
        written = self.application.written
        assert written is not None  # `identify` refuses one without
        return Manuscript(written.text, written.name).with_(self.changes())


# --------------------------------------------------------------------------- the model


@dataclass(frozen=True)
class _Free:
    """One number that may move: as a logarithm where it cannot be nought."""

    name: str
    part: Part
    start: float
    prior: float  # standard deviation; inf where nothing is known
    log: bool = True
    address: str = ""
    was: float = np.nan

    def value(self, x: float) -> float:
        return self.start * float(np.exp(x)) if self.log else self.start + x


@dataclass(frozen=True)
class _Scene:
    """The recording as the model sees it: windows, and the fine clock between them."""

    at: Windows
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
        return {k: self.weight * np.exp(-2j * np.pi * k * angle) for k in ORDERS}

    @cached_property
    def waves(self) -> dict[float, Any]:
        """The load of each order on the fine clock: of unbalance, the speed's square."""
        loads = {k: self.fine_speed**2 if k == 1 else self.fine_torque for k in ORDERS}
        return {k: v * np.exp(2j * np.pi * k * self.fine_angle) for k, v in loads.items()}

    @cached_property
    def turning(self) -> dict[float, Any]:
        """How each order turns on the fine clock: its speed 1/s, and how far back in a step."""
        speeds = {k: 2j * np.pi * k * self.fine_speed for k in ORDERS}
        return {k: (W, np.exp(-W / self.rate)) for k, W in speeds.items()}

    def load(self, order: float) -> FloatArray:
        """Return the load of an order in each window, (W,)."""
        return self.at.speed**2 if order == 1 else self.torque


class _Model:
    """An application's bearing in one state, at the torques and speeds of a recording."""

    def __init__(
        self, application: Application, *, state: str, bearing: int, scene: _Scene
    ) -> None:
        alone = replace(
            application,
            states=tuple(s for s in application.states if s.name == state),
        )
        if not alone.states:
            names = ", ".join(s.name for s in application.states)
            msg = f"no state {state!r}; there are: {names}"
            raise DesignError(msg)
        asked = demand(resolve(alone, alone.lines[0]))
        self.response: Response = respond(alone, asked)
        held = self.response.held
        if held is None:
            msg = (
                "a recording is held against a line on its rubber: the application has to give "
                "tubes and the stiffness of a centre bearing"
            )
            raise DesignError(msg)
        self.held: Suspended = held
        if not 1 <= bearing <= held.stiffness.shape[-2]:
            count = held.stiffness.shape[-2]
            msg = f"line {alone.lines[0].line.name} has {count} centre bearings, not a {bearing}."
            raise DesignError(msg)
        self.bearing, self.scene = bearing - 1, scene
        torque = scene.torque[:, None]
        speed = 2 * np.pi * scene.at.speed[:, None]
        under = demand_under(asked, torque=torque, speed=speed, coasts=torque < 0)
        self.layout: Layout = self.response.lay(under)
        self.torque, self.speed = torque, speed
        hung = 2 * np.pi * np.array(self.hung(held))
        passed = hung[hung < 4 * speed.max()]
        # Of a drive that comes near none, the lowest.
        self.usual = float(np.exp(np.log(passed if passed.size else hung.min()).mean()))
        self.shaft = [k for k, s in enumerate(self.response.line.shafts) if s.centre_bearing][
            self.bearing
        ]

    def lossy(self, held: Suspended, law: float, order: float) -> Suspended:
        """Return the line with the loss of its rubber as it is at an order of each window."""
        swift = (order * self.speed / self.usual) ** law
        return replace(held, loss=held.loss * swift[..., None])

    def forces(self, held: Suspended, phases: FloatArray, law: float) -> ComplexArray:
        """Force (W, K, 3) N on the bearing; order 1 of 1 kg m at the rear of its shaft."""
        r = self.response
        run = running(
            self.layout, r.line, phases, torque=self.torque, speed=self.speed,
            held=self.lossy(held, law, 2.0), inertias=r.inertias,
        )  # fmt: skip
        waves = run.waves[:, 0, self.bearing]
        self.mean = run.mean[:, 0, self.bearing]
        side = unit(cross(held.along, np.array([0.0, 0.0, 1.0])))
        turning = (side - 1j * cross(held.along, side))[..., self.shaft, :]
        push = (turning[..., None, :] @ held.rear[..., self.shaft, :, :])[..., 0, :]
        once = self.lossy(held, law, 1.0).moved(
            push * self.speed[..., None] ** 2, frequency=self.speed, speed=self.speed,
            torque=self.torque,
        )  # fmt: skip
        return np.stack([once.bearing_forces[:, 0, self.bearing], waves[:, 0], waves[:, 1]], axis=1)

    def hung(self, held: Suspended) -> tuple[float, ...]:
        """Return the frequencies Hz of the line on its rubber, in the mean of the torque."""
        modes = held.modes(torque=float(np.sqrt(np.mean(self.torque**2))))
        return tuple(np.sort(modes.frequency[0] / (2 * np.pi)).tolist())

    def poles(self, held: Suspended, mode: tuple[float, float] | None, law: float) -> ComplexArray:
        """Return the poles that a drive through its speeds can shake, 1/s."""
        mean = float(np.sqrt(np.mean(self.torque**2)))
        modes = held.modes(torque=mean)
        f = modes.frequency[0]
        d = np.minimum(modes.damping[0] * (f / self.usual) ** law, 0.5)
        top = 1.3 * 4 * float(self.speed.max())
        near = f < top
        found = [_pole(w, z) for w, z in zip(f[near].tolist(), d[near].tolist(), strict=True)]
        if mode is not None:
            found.append(_pole(2 * np.pi * mode[0], mode[1]))
        return np.array(found)


def _pole(w: float, z: float) -> complex:
    """Return the pole of a mode, 1/s; one damped beyond 1, which a search may try, creeps back."""
    return w * (-z + 1j * complex(1 - z * z) ** 0.5)


def _gain_of(mode: tuple[float, float] | None, W: FloatArray) -> ComplexArray:
    """Response (...) of a bracket's mode at W rad/s, 1 where it stands."""
    if mode is None:
        return np.ones_like(W, dtype=complex)
    r = W / (2 * np.pi * mode[0])
    return 1 / (1 - r * r + 2j * mode[1] * r)


def _shares(scene: _Scene, steady: ComplexArray, poles: ComplexArray, order: float) -> ComplexArray:
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


def _stepped(scene: _Scene, pole: complex, order: float) -> ComplexArray:
    """Return how one pole follows the load of an order on the fine clock, (fine,).

    Stepped so that a steady load is followed exactly.
    """
    from scipy.signal import lfilter

    W, back = scene.turning[order]
    step = np.exp(pole / scene.rate)
    return lfilter([1], [1, -step], scene.waves[order] * (1 - step * back) / (W - pole))


def _remembered(
    scene: _Scene, steady: ComplexArray, poles: ComplexArray, order: float
) -> ComplexArray:
    """Return what modes add to an order's steady amplitude (C, W), as its speed and load change.

    The steady response per load is a sum over poles; each of them is stepped through the
    drive, met like the signal, and its steady part is taken off.
    """
    load = scene.load(order)
    if not poles.size or not np.abs(load).max() > 0:
        return np.zeros_like(steady)
    basis = 1 / (2j * np.pi * order * scene.at.speed - poles[:, None])
    met = np.stack([scene.met(_stepped(scene, complex(p), order), order) for p in poles])
    return _shares(scene, steady, poles, order) @ (met - basis * load)


class _Fit:
    """Least squares of a model against cuts."""

    def __init__(
        self, model: _Model, cuts: Cuts, units: FloatArray, gauges: Sequence[str],
        *, noise: FloatArray,
    ) -> None:  # fmt: skip
        self.model, self.scene, self.cuts = model, model.scene, cuts
        self.units, self.gauges, self.noise = units, gauges, noise
        self.blocks = int(model.scene.block.max(initial=0)) + 1
        self.white: list[_White] = []
        self.kept: dict[bytes, ComplexArray] = {}

    def free(
        self, *, turned: tuple[int, float] | None, mode: tuple[float, float] | None
    ) -> list[_Free]:
        """Return what may move from the file: with one shaft turned by rad, and with a mode."""
        at = _address(self.model.response)
        found: list[_Free] = []
        for name, part, place, was in _numbers(self.model.response.line):
            start, prior = was, PRIOR["stiffness"]
            if name == "loss":
                start, prior = LOSS if np.isnan(was) else was, PRIOR["loss"]
            elif name == "phase":
                by = turned[1] if turned and part == Part("shaft", turned[0] + 1) else 0.0
                start, prior = was + by, np.inf if by else CROOKED
            found.append(
                _Free(name, part, start, prior, log=name != "phase", address=f"{at}.{place}",
                      was=was)
            )  # fmt: skip
        found += [
            _Free("gain", Part("gauge", 0, g), 1.0, PRIOR["gain"], was=1.0) for g in self.gauges
        ]
        # How a flange is held moves what a gauge reads of one way of pulling more than of another.
        found += [_Free(ASKEW, Part("gauge", 0, g), 1.0, PRIOR[ASKEW]) for g in self.gauges]
        found.append(_Free("law", LINE, 0.0, LAW, log=False))
        found += [_Free(name, LINE, 0.0, 1.0, log=False) for name in SEATS]
        late = LATE if self.blocks > 1 else PROMPT
        found.append(_Free("lag", LINE, 0.0, late, log=False))
        if mode is not None:
            part = Part("gauge", 0, "bracket")
            found += [
                _Free("mode", part, mode[0], np.inf),
                _Free("mode damping", part, mode[1], PRIOR["mode damping"]),
            ]
        return found

    def said(self, free: Sequence[_Free], x: FloatArray) -> "_Said":
        """Return the numbers of the model at a place."""
        r = self.model.response
        values: dict[tuple[str, Part], float] = {
            (f.name, f.part): f.value(v) for f, v in zip(free, x, strict=True)
        }
        stiffness, loss = self.model.held.stiffness.copy(), self.model.held.loss.copy()
        nth = 0
        for s in r.line.shafts:
            if s.centre_bearing is None:
                continue
            part = Part("centre bearing", nth + 1)
            for k, name in enumerate(SPRINGS):
                stiffness[..., nth, k] = values.get((name, part), stiffness[..., nth, k])
            loss[..., nth] = values.get(("loss", part), loss[..., nth])
            nth += 1
        phases = np.array(
            [
                values.get(("phase", Part("shaft", k + 1)), float(s.phase))
                for k, s in enumerate(r.line.shafts)
            ]
        )
        bracket = Part("gauge", 0, "bracket")
        mode = (
            (values["mode", bracket], values["mode damping", bracket])
            if ("mode", bracket) in values
            else None
        )
        gain = np.array([values.get(("gain", Part("gauge", 0, g)), 1.0) for g in self.gauges])
        askew = np.array([values.get((ASKEW, Part("gauge", 0, g)), 1.0) for g in self.gauges])
        held = replace(self.model.held, stiffness=stiffness, loss=loss)
        return _Said(
            held, phases, mode, gain, askew, values.get(("lag", LINE), 0.0),
            values.get(("law", LINE), 0.0),
            SEAT * np.array([0.0, *(values.get((n, LINE), 0.0) for n in SEATS)]),
        )  # fmt: skip

    def stress(self, said: "_Said") -> ComplexArray:
        """Return computed cuts (gauges, K, W) Pa, order 1 of 1 kg m, the mark at the yoke."""
        return np.tensordot(self.felt(said), self.force(said), axes=1)

    def force(self, said: "_Said") -> ComplexArray:
        """Return the force that makes them, its three ways, (3, K, W) N."""
        scene, held = self.scene, said.held
        numbers = (held.stiffness, held.loss, said.phases, said.law, said.mode or 0)
        asked = b"".join(np.asarray(n, dtype=float).tobytes() for n in numbers)
        if asked not in self.kept:
            if len(self.kept) > KEPT:
                self.kept.clear()
            self.kept[asked] = self._force(said)
        W = np.multiply.outer(ORDERS, scene.at.speed)
        late = np.exp(2j * np.pi * said.lag * W)
        return self.kept[asked] * late * (1 + said.seat[:, None, None] * W**2)

    def _force(self, said: "_Said") -> ComplexArray:
        scene = self.scene
        W = 2 * np.pi * np.multiply.outer(ORDERS, scene.at.speed)
        out = self.model.forces(said.held, said.phases, said.law).T * _gain_of(said.mode, W)
        poles = self.model.poles(said.held, said.mode, said.law)
        for k, order in enumerate(ORDERS):
            out[:, k] += _remembered(scene, out[:, k], poles, order)
        return out

    def felt(self, said: "_Said") -> FloatArray:
        """Return what a unit force was found to do at each gauge, (gauges, 3) Pa/N."""
        across = np.ones_like(said.askew)
        return said.gain[:, None] * self.units * np.stack([across, across, said.askew], axis=-1)

    def turned(self, computed: ComplexArray) -> tuple[ComplexArray, complex, FloatArray]:
        """Return what makes computed cuts those that the tacho sees, unbalance and marks.

        A factor (K, W); the unbalance that fits order 1 is in it. Where the mark stands follows
        from order 2, block by block; of order 1, whose mark may be half a turn off by that, the
        half turn that fits.
        """
        cuts, w = self.cuts.amplitude, 1 / self.noise**2
        w = np.where(np.isnan(cuts), 0.0, w)
        cuts = np.nan_to_num(cuts)
        marks = np.zeros(self.blocks)
        for b in range(self.blocks):
            here = self.scene.block == b
            z = (np.conj(computed[:, 1, here]) * cuts[:, 1, here] * w[:, 1, here]).sum()
            marks[b] = np.angle(z) / 2
        mark = np.exp(1j * marks)[self.scene.block]
        one = computed[:, 0] * mark
        heavy = 0j
        signs = np.ones(self.blocks)
        for _ in range(4 if self.blocks > 1 else 1):
            sign = signs[self.scene.block]
            power = (np.abs(one) ** 2 * w[:, 0]).sum()
            heavy = complex((np.conj(one * sign) * cuts[:, 0] * w[:, 0]).sum() / max(power, 1e-300))
            for b in range(self.blocks):
                here = self.scene.block == b
                fit = (np.conj(one[:, here] * heavy) * cuts[:, 0, here] * w[:, 0, here]).sum()
                signs[b] = 1.0 if fit.real >= 0 else -1.0
        once = mark * signs[self.scene.block] * heavy
        turn = np.asarray(np.stack([once, mark**2, mark**4]), dtype=complex)
        return turn, heavy, marks[self.scene.block]

    def off(self, computed: ComplexArray) -> ComplexArray:
        """Measured less computed (gauges, K, W), in standard deviations; nought where unknown."""
        turn, *_ = self.turned(computed)
        off = np.nan_to_num((self.cuts.amplitude - computed * turn) / self.noise)
        for k, white in enumerate(self.white):
            off[:, k] = white.of(off[:, k].ravel()).reshape(off[:, k].shape)
        return off

    def allowing(self, said: "_Said") -> "_Fit":
        """Return the same with what the model leaves out of the force alike at alike speeds.

        A part of each way's force, by order: its covariance whitens what is left over.
        """
        force, felt = self.force(said), self.felt(said)
        turn, *_ = self.turned(np.tensordot(felt, force, axes=1))
        hats = _alike(self.scene.at.speed, self.scene.torque)
        known = np.where(np.isnan(self.cuts.amplitude), 0, ALIKE_OUT / self.noise)
        other = copy(self)
        other.white = [
            _White.by(
                np.einsum("gw,gc,cw,jw->gwcj", known[:, k], felt, force[:, k] * turn[k], hats)
                .reshape(felt.shape[0] * hats.shape[1], -1)
            )
            for k in range(len(ORDERS))
        ]  # fmt: skip
        return other

    def rows(self, free: Sequence[_Free], x: FloatArray) -> FloatArray:
        """Return what is left over, real and imaginary, blows cut down, and what priors say."""
        off = self.off(self.stress(self.said(free, x))).ravel()
        size = np.abs(off)
        blow = np.maximum(size, 3.0)
        off = off * np.sqrt(3 * (2 * blow - 3)) / blow
        prior = x / np.array([f.prior for f in free])
        return np.concatenate([off.real, off.imag, prior])


@dataclass(frozen=True)
class _Said:
    """Numbers of the model."""

    held: Suspended
    phases: FloatArray
    mode: tuple[float, float] | None
    gain: FloatArray
    askew: FloatArray
    lag: float
    law: float
    seat: FloatArray


@dataclass(frozen=True)
class _White:
    """What makes errors of covariance 1 + C Cᴴ independent: its square root's inverse."""

    ways: ComplexArray  # (m, j), square to one another
    share: FloatArray  # (j,), that is taken off of each

    @classmethod
    def by(cls, columns: ComplexArray) -> "_White":
        """Return it for columns C (m, n); those that are faint beside 1 are left out."""
        ways, size, _ = np.linalg.svd(columns, full_matrices=False)
        kept = size > FAINT
        return cls(ways[:, kept], 1 - 1 / np.sqrt(1 + size[kept] ** 2))

    def of(self, off: ComplexArray) -> ComplexArray:
        """Return errors (m,) whitened."""
        return off - self.ways @ (self.share * (np.conj(self.ways).T @ off))


def _alike(speed: FloatArray, torque: FloatArray) -> FloatArray:
    """Return what windows (W,) share of what is left out alike at alike speeds, (parts, W).

    Straight between knots of speed, as far apart as each of `OCTAVES`; a line that coasts rests on
    other flanks than one that is driven, and shares nothing with it.
    """
    pace, coasts = np.log2(speed), torque < 0
    hats = np.concatenate([_hats(pace / o) for o in OCTAVES])
    return np.concatenate([hats * coasts, hats * ~coasts])


def _hats(at: FloatArray) -> FloatArray:
    """Return what is straight between whole numbers, 1 at one of them: (knots, W) of (W,)."""
    knots = np.arange(np.floor(at.min()), np.ceil(at.max()) + 1)
    return np.maximum(1 - np.abs(at - knots[:, None]), 0.0)


def _address(r: Response) -> str:
    written = r.application.written
    assert written is not None
    return line_address(r.demand.installed, Manuscript(written.text, written.name))


def _written(of: Response) -> None:
    """Refuse a file that gives rubber by keys that what is found cannot be written to."""
    numbers = of.application.written.numbers if of.application.written else {}
    for name, _, place, _ in _numbers(of.line):
        if name in SPRINGS and (at := f"{_address(of)}.{place}") not in numbers:
            msg = (
                f"{at}: a recording is held against vertical_stiffness_N_mm and "
                "lateral_stiffness_N_mm: give both in place of what says it otherwise"
            )
            raise DesignError(msg)


def _numbers(of: Line) -> Iterator[tuple[str, Part, str, float]]:
    """Yield what a recording may tell of a line: name, part, address in it, and the file's value.

    nan where the file says nothing.
    """
    nth = 0
    for k, s in enumerate(of.shafts):
        b = s.centre_bearing
        nth += b is not None
        if b is None or b.stiffness is None:
            continue
        where, part = f"shafts[{k + 1}].centre_bearing", Part("centre bearing", nth)
        for name, value in zip(SPRINGS, b.stiffness, strict=True):
            yield name, part, f"{where}.{name}_stiffness_N_mm", float(value)
        loss = np.nan if b.loss_factor is None else float(b.loss_factor)
        yield "loss", part, f"{where}.loss_factor", loss
    for k, s in enumerate(of.shafts):
        yield "phase", Part("shaft", k + 1), f"shafts[{k + 1}].phase_deg", float(s.phase)


# --------------------------------------------------------------------------- the question


def identify(
    application: Application,
    pieces: Iterator[FloatArray],
    *,
    rate: float,
    gauges: Sequence[str],
    units: FloatArray,
    angle: Angle,
    torque: tuple[FloatArray, float],
    seconds: float,
    state: str = "gvw",
    bearing: int = 1,
    phases: bool = True,
) -> Identification:
    """Ask a recording what of its application is otherwise.

    Parameters
    ----------
    application
        As read from a file.
    pieces : (gauges, n) Pa
        Stress of the gauges from the start.
    rate : Hz
        Of its samples.
    gauges, units : (gauges, 3) Pa/N
        Their names, and what a unit force of the bearing does at each.
    angle
        Of the shaft.
    torque : (m,) N m and Hz
        Of the gearbox output, and how often it was read.
    seconds
        Length of the recording.
    state, bearing
        Whose geometry, and which centre bearing.
    phases
        Whether the shafts may be put together otherwise than the file says.

    Raises
    ------
    DesignError
        If the application has no line on rubber, no such state or bearing, or the shaft hardly
        turns.
    """
    if application.written is None:
        msg = "what a recording says can be held against an application from a file alone"
        raise DesignError(msg)
    scene = _scene(angle, torque, seconds)
    cuts = order_cuts(pieces, rate=rate, rotation=angle.rotation, at=scene.at, orders=ORDERS)
    model = _Model(application, state=state, bearing=bearing, scene=scene)
    _written(model.response)
    level = _smoothed(cuts.noise)
    # What is small beside the rest of its order is told no better than that.
    size = np.abs(cuts.amplitude)
    rough = size**2 + np.nanmean(size[:, 1:2] ** 2, axis=-1, keepdims=True)
    noise = np.nan_to_num(np.sqrt(level**2 + LEFT_OUT**2 * rough), nan=1.0)
    fit = _Fit(model, cuts, units, gauges, noise=noise)
    few = slice(None, None, int(np.ceil(scene.at.time.size / ENOUGH)))
    coarse = _Fit(
        _Model(
            application, state=state, bearing=bearing,
            scene=_scene(angle, torque, seconds, rate=COARSE, few=few),
        ),
        replace(cuts, amplitude=cuts.amplitude[..., few]),
        units, gauges, noise=noise[..., few],
    )  # fmt: skip
    places = _best(fit, coarse, phases=phases)
    plain = places[0]
    width = _spread(fit, plain)
    fit = fit.allowing(fit.said(plain.free, plain.x))
    minima = _apart([_ended(fit, one.free, one.x, steps=40, gain=1e-6) for one in places[:RIVALS]])
    return _told(fit, minima, (plain.x, width), application, state=state, bearing=bearing)


def _scene(
    angle: Angle, torque: tuple[FloatArray, float], seconds: float,
    *, rate: float = FINE, few: slice = slice(None),
) -> _Scene:  # fmt: skip
    """Return windows of a recording, of a long one those in stretches spread over it.

    A few of them where fewer are asked for, and a clock of so many Hz between them.
    """
    at = windows(angle.rotation, until=seconds)
    if at.time.size < 12:
        msg = (
            "the shaft turns too little to be held against a model: 12 windows of 8 turns at least"
        )
        raise DesignError(msg)
    stretch = (at.start / STRETCH).astype(int)
    wanted = np.unique(stretch)[:: int(np.ceil(seconds / LONGEST))]
    keep = np.flatnonzero(np.isin(stretch, wanted))[few]
    at = Windows(*(getattr(at, n)[keep] for n in ("start", "stop", "first", "turns")))
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
    counted = angle.trusted and angle.lag <= COUNTED
    block = np.zeros(at.time.size, int) if counted else np.unique(stretch, return_inverse=True)[1]
    return _Scene(at, mean, block, rate, angles, speed, load, place, start, weight)


FAR = 2.25
"""How many times stiffer or softer than written rubber is looked for. A case of two bearings whose
file had one twice as stiff as it was had been told, and surely, that it was four times that."""

RIVALS = 3
"""How many of the places that were found are asked again with what the model leaves out alike."""

BLOCK = 12
"""Windows beside one another that err together."""

PROMPT = 0.0005
"""What a logger's filters put a gauge behind the tacho by, s, one standard deviation, assumed."""

LATE = 0.005
"""What is left of a bus's lag once the stress has told it, s, one standard deviation, assumed."""

COUNTED = 0.05
"""Largest lag, s, of an angle that was counted by a tacho and not integrated."""


def _smoothed(noise: FloatArray) -> FloatArray:
    """Return the median (..., W) of fifteen windows: a resonance that is passed is no noise."""
    from scipy.ndimage import median_filter

    known = np.where(np.isnan(noise), np.nanmedian(noise, axis=-1, keepdims=True), noise)
    size = min(15, known.shape[-1])
    return median_filter(known, size=(*[1] * (known.ndim - 1), size), mode="nearest")


@dataclass(frozen=True)
class _Found(Minimum):
    """Where least squares ended, and what moved there."""

    free: list[_Free]

    @property
    def worth(self) -> float:
        """In variances, of a number."""
        return self.misfit / max(self.left.size - self.x.size, 1)

    @property
    def strain(self) -> float:
        """Largest departure from what was assumed, in standard deviations."""
        return float(np.abs(self.left[-self.x.size :]).max())

    def value(self, name: str) -> float:
        """Return the first number of a name."""
        return next(f.value(v) for f, v in zip(self.free, self.x, strict=True) if f.name == name)

    def beginning(self, free: Sequence[_Free]) -> FloatArray:
        """Return where others would begin: here, as far as they are the same."""
        here = {(f.name, f.part): v for f, v in zip(self.free, self.x, strict=True)}
        return np.array([here.get((f.name, f.part), 0.0) for f in free])


def _best(fit: _Fit, coarse: _Fit, *, phases: bool) -> list[_Found]:
    """Return the fit that is best, and after it others of the same numbers elsewhere.

    Where the numbers of the file's own parts explain what was measured, nothing else is looked
    for. Else one shaft may have been put together otherwise than drawn, or the bracket may have
    a mode of its own.
    """
    found = _searched(fit, coarse, fit.free(turned=None, mode=None))
    best = found[0]
    if best.worth < GOOD and best.strain < UNLIKELY:
        return found
    turned = _otherwise(coarse, best) if phases else []
    options = [_ended(fit, free, np.zeros(len(free))) for free in turned]
    modes = [_ended(fit, free, best.beginning(free)) for free in _modes(coarse, best)]
    # Above all that the orders reach it is no mode, but whatever makes gauges feel more with speed.
    reach = max(ORDERS) * float(fit.scene.at.speed.max())
    options += [one for one in modes if one.value("mode") < reach]
    if not options:
        return found
    better = min(options, key=lambda one: one.misfit)
    # What explains as much by numbers that are likely is better as well.
    likelier = better.misfit < best.misfit - ODDS and better.strain < UNLIKELY <= best.strain
    if not likelier and better.misfit > (1 - BETTER) * best.misfit:
        return found
    return _apart([better, *_searched(fit, coarse, better.free)])


def _searched(fit: _Fit, coarse: _Fit, free: list[_Free]) -> list[_Found]:
    """Return the places where least squares end, apart from one another, the best first.

    Lines of several bearings have many, of which one is true: rubber is looked for as the file
    has it, and up to `FAR` times as stiff and as soft.
    """
    far = np.zeros(len(free))
    far[_moved(free, *SPRINGS)] = np.log(FAR)
    places = searched(partial(coarse.rows, free), far=far)
    return _apart([_ended(fit, free, one.x) for one in places[:RIVALS]])


def _ended(fit: _Fit, free: list[_Free], x: FloatArray, **how: Any) -> _Found:
    """Return where least squares end that begin at a place (p,), as `least` is told."""
    at = least(partial(fit.rows, free), x, **how)
    return _Found(at.x, at.left, at.slope, free)


def _apart(found: list[_Found]) -> list[_Found]:
    return apart(found, _moved(found[0].free, *SPRINGS))


def _otherwise(fit: _Fit, best: _Found) -> list[list[_Free]]:
    """Return what may move with a shaft turned, of the two that fit best.

    A tooth of a spline is some 20 degrees, half a turn is none.
    """
    shafts = range(1, len(fit.model.response.line.shafts))
    options = [
        fit.free(turned=(k, float(a)), mode=None)
        for k in shafts
        for a in np.arange(1, 8) * np.pi / 8
    ]
    # The first shaft's phase and the tacho's mark are one where the others follow it.
    return sorted(options, key=lambda free: _rough(fit, free, best))[:2]


def _modes(fit: _Fit, best: _Found) -> list[list[_Free]]:
    """Return what may move with a mode of the bracket, of the two likeliest to be left out."""
    speed = fit.scene.at.speed
    options = [
        fit.free(turned=None, mode=(float(f), d))
        for f in np.geomspace(max(2.5 * speed.min(), 4.0), 5 * speed.max(), 18)
        for d in (0.02, 0.06)
    ]
    return sorted(options, key=lambda free: _rough(fit, free, best))[:2]


def _rough(fit: _Fit, free: list[_Free], best: _Found) -> float:
    """Return the misfit of other shafts or modes where the rest stays."""
    return squares(fit.rows(free, best.beginning(free)))


def _moved(free: Sequence[_Free], *names: str) -> list[int]:
    """Return which of what may move have one of some names."""
    return [k for k, f in enumerate(free) if f.name in names]


def _told(
    fit: _Fit, minima: list[_Found], plain: tuple[FloatArray, FloatArray], application: Application,
    *, state: str, bearing: int,
) -> Identification:  # fmt: skip
    """Return what was found with its intervals: of the best minimum, and of those as likely.

    Gains are those of the plain fit, given with its widths. What the model leaves out of the force
    alike at all speeds cannot be told from them, so where it is allowed for, what was assumed
    decides; the plain amplitude is what was recorded, and by it force is read back. The interval
    holds both.
    """
    found = minima[0]
    rivals = [one for one in minima if one.misfit - found.misfit < RIVAL]
    likely = [(one.x, _spread(fit, one)) for one in rivals]
    free = found.free
    gain = np.array([f.name == "gain" for f in free])
    x = np.where(gain, plain[0], found.x)
    said = fit.said(free, x)
    computed = fit.stress(said)
    turn, U, mark = fit.turned(computed)
    computed = computed * turn
    file = fit.free(turned=None, mode=None)
    written = fit.stress(fit.said(file, np.zeros(len(file))))
    written = written * fit.turned(written)[0]
    units = fit.felt(said)
    parameters: list[Parameter] = []
    for n, f in enumerate(free):
        if f.name in ("lag", "law", *SEATS, ASKEW):
            continue
        floor = LEAST.get(f.name, 0.01 if f.log else 0.5 * deg)
        at = x[n]
        places = [*likely, plain] if gain[n] else likely
        low = min(float(y[n]) - max(SURE * float(s[n]), floor) for y, s in places)
        high = max(float(y[n]) + max(SURE * float(s[n]), floor) for y, s in places)
        told = not np.isfinite(f.prior) or (high - low) / 2 < SURE * NARROWED * f.prior
        low, high = f.value(low), f.value(high)
        parameters.append(
            Parameter(
                name=f.name, part=f.part, was=f.was, value=f.value(at), low=low, high=high,
                told=bool(told), assumed=not told, address=f.address,
            )
        )  # fmt: skip
    parameters += _unbalance(fit, said, computed[:, 0], U)
    second, noise, scene = fit.cuts.amplitude[:, 1], fit.cuts.noise[:, 1], fit.scene
    asked = (
        disagreeing(second, noise, units=fit.units, gauges=tuple(fit.gauges)),
        backwards(scene.fine_torque, scene.fine_speed, rate=scene.rate),
        unlike(second, noise, computed[:, 1]),
    )
    doubts = tuple(doubt for doubt in asked if doubt is not None)
    if doubts:  # numbers that fit what is wrong are wrong, and surely so
        parameters = [replace(p, told=False, assumed=False) for p in parameters]
    result = Identification(
        application=application, identified=application, state=state, bearing=bearing,
        parameters=tuple(parameters), gauges=tuple(fit.gauges), cuts=fit.cuts,
        torque=fit.scene.torque, written=written, found=computed,
        units=units, mean=units @ fit.model.mean.T, mark=mark,
        misfit=(_share(fit, written), _share(fit, computed)), hung=fit.model.hung(said.held),
        doubts=doubts,
    )  # fmt: skip
    changes = {p.address: p.told_in_unit(p.value) for p in parameters if p.rewritten}
    return replace(result, identified=changed(application, changes))


@dataclass(frozen=True)
class Departure:
    """A number found otherwise than written, and what a changed application has in its place, SI.

    nan where it says nothing.
    """

    found: Parameter
    value: float


def departures(of: Identification, changed: Application) -> tuple[Departure, ...]:
    """Return where a changed application departs from what was found otherwise than written.

    It is the change that is asked about, or what the file said wrong of the line that was driven.
    """
    said = {(name, part): value for name, part, _, value in _numbers(changed.lines[0].line)}
    found = (Departure(p, said.get((p.name, p.part), np.nan)) for p in of.parameters if p.rewritten)
    return tuple(d for d in found if not d.found.low <= d.value <= d.found.high)


def changed(application: Application, changes: Mapping[str, float]) -> Application:
    """Return the application with other numbers; those that its file leaves out put into it."""
    written = application.written
    assert written is not None  # `identify` refuses one without
    absent = {at: value for at, value in changes.items() if at not in written.numbers}
    made: Mapping[str, Any] = dict(written.changes) | {
        at: value for at, value in changes.items() if at not in absent
    }
    text = Manuscript(written.text, written.name).with_(absent)
    return understood(replace(written, text=text, changes=made))


def _spread(fit: _Fit, found: _Found) -> FloatArray:
    """Return standard deviations (p,), by blocks of windows: neighbours err alike."""
    p = found.x.size
    body, prior = found.slope[:-p], found.slope[-p:]
    left = found.left[:-p]
    G, K, W = fit.cuts.amplitude.shape
    windows_of = np.tile(np.arange(W), G * K * 2)
    block = windows_of // BLOCK
    count = int(block.max()) + 1
    score = np.stack([body[block == b].T @ left[block == b] for b in range(count)])
    gram = body.T @ body + prior.T @ prior
    inverse = np.linalg.pinv(gram, hermitian=True)
    middle = score.T @ score * (count / max(count - 1, 1)) + prior.T @ prior
    robust = inverse @ middle @ inverse
    noise = max(float(left @ left) / max(left.size - p, 1), 0.0)
    plain = inverse * max(noise, 1.0) * 1.5  # windows overlap by half
    return np.sqrt(np.maximum(np.diag(robust), np.diag(plain)))


def _unbalance(fit: _Fit, said: _Said, fitted: ComplexArray, U: complex) -> list[Parameter]:
    """Return what is unbalanced at the rear of the bearing's shaft, kg m."""
    measured = fit.cuts.amplitude[:, 0]
    w = np.where(np.isnan(measured), 0.0, 1 / fit.noise[:, 0] ** 2)
    one = fitted / U if U else np.zeros_like(fitted)
    power = max(float((np.abs(one) ** 2 * w).sum()), 1e-300)
    # Gauges feel the same road, and neighbours err alike: what is left over, block by block.
    each = (np.conj(one) * np.nan_to_num(measured - fitted) * w).sum(0)
    score = np.add.reduceat(each, np.arange(0, each.size, BLOCK))
    # Windows overlap by half; what the model leaves out of an order is in the noise.
    sigma = float(np.sqrt(max(1.5 / power, (np.abs(score) ** 2).sum() / power**2)))
    half = SURE * sigma + 0.03 * abs(U)
    size = abs(U)
    # A mode of the bracket just above what order 2 reached would have raised order 1 by a third.
    raised = 4 / 3 if said.mode is None else 1.0
    part = Part("shaft", fit.model.shaft + 1)
    return [
        Parameter(
            name="unbalance", part=part, was=np.nan, value=size, low=max(size - half, 0.0) / raised,
            high=size + half, told=size > half,
        )
    ]  # fmt: skip


def _share(fit: _Fit, computed: ComplexArray) -> float:
    """Share of the measured order 2's energy that is not explained."""
    a = fit.cuts.amplitude[:, 1]
    known = ~np.isnan(a)
    return float((np.abs(a - computed[:, 1])[known] ** 2).sum() / (np.abs(a[known]) ** 2).sum())


def load_history(
    of: Identification, rotation: Rotation, torque: tuple[FloatArray, float], *, seconds: float,
    rate: float = FINE, application: Application | None = None,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Force on the bearing over the recording's drive, (n,) s and (n, 3) N, vehicle axes.

    As `load_at` tells it. For the bracket's damage.
    """
    time = np.arange(int(seconds * rate)) / rate
    return time, load_at(of, rotation, torque, seconds=seconds, application=application)(time)


def load_at(
    of: Identification, rotation: Rotation, torque: tuple[FloatArray, float], *, seconds: float,
    application: Application | None = None,
) -> Callable[[FloatArray], FloatArray]:  # fmt: skip
    """Return what tells the force on the bearing (n, 3) N, vehicle axes, at times (n,) s.

    Of the application as it was identified, or of another one driven so: mean and orders at each
    window's torque and speed, with what modes remember where they are passed, straight between
    windows; what is unbalanced is not in it.
    """
    scene = _scene(Angle(rotation, lag=0.0), torque, seconds)
    r = _Model(application or of.identified, state=of.state, bearing=of.bearing, scene=scene)
    phases = np.array([float(s.phase) for s in r.response.line.shafts])
    run = running(
        r.layout, r.response.line, phases, torque=r.torque, speed=r.speed, held=r.held,
        inertias=r.response.inertias,
    )  # fmt: skip
    mean, waves = run.mean[:, 0, r.bearing].T, run.waves[:, 0, r.bearing]
    poles = r.poles(r.held, None, 0.0)
    clock = np.arange(scene.fine_angle.size) / FINE

    ways: list[tuple[float, ComplexArray, list[tuple[ComplexArray, ComplexArray]]]] = []
    for k, order in enumerate((2.0, 4.0, 6.0)):
        steady = waves[:, k].T
        slow = steady
        remembered: list[tuple[ComplexArray, ComplexArray]] = []
        if order in ORDERS and poles.size:
            # What is left beside the poles is slow; they themselves go through the drive.
            share = _shares(scene, steady, poles, order)
            basis = 1 / (2j * np.pi * order * scene.at.speed - poles[:, None])
            slow = steady - share @ (basis * scene.load(order))
            back = np.exp(-2j * np.pi * order * scene.fine_angle)
            remembered = [
                (share[:, r_], _stepped(scene, complex(pole), order) * back)
                for r_, pole in enumerate(poles)
            ]
        ways.append((order, slow, remembered))

    def force(time: FloatArray) -> FloatArray:
        def between(at: FloatArray, z: ComplexArray) -> ComplexArray:
            return np.interp(time, at, z.real) + 1j * np.interp(time, at, z.imag)

        near = np.searchsorted(scene.at.time[:-1], time)
        turns = rotation.at(time) + of.mark[near] / (2 * np.pi)
        total = np.stack([np.interp(time, scene.at.time, m) for m in mean], axis=-1)
        for order, slow, remembered in ways:
            turning = np.exp(2j * np.pi * order * turns)
            for share, z in remembered:
                total += ((between(clock, z) * turning)[:, None] * share).real
            total += np.stack([(between(scene.at.time, z) * turning).real for z in slow], axis=-1)
        return total

    return force
