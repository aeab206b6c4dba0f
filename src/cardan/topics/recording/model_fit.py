"""Fit of a bearing's model to the order cuts of gauges: residuals, priors and whitening."""

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from cardan.core.arrays import ComplexArray, FloatArray
from cardan.core.labels import WHOLE_LINE, Part
from cardan.core.units import deg
from cardan.physics.loads.rubber_mount import DEFAULT_LOSS_FACTOR, MountedLine
from cardan.physics.signals.order_cuts import OrderCuts
from cardan.topics.recording.bearing_model import (
    FITTED_ORDERS,
    MAX_KEPT_FORCE_COUNT,
    STIFFNESS_NAMES,
    BearingModel,
    array_bytes,
    bracket_mode_gain,
    discard_oldest,
    identifiable_numbers,
    line_file_address,
    remembered_response,
)

PRIOR_LOG_SD_BY_PARAMETER = {
    "stiffness": 0.5,
    "loss": 0.7,
    "gain": 0.1,
    "askew": 0.1,
    "mode damping": 0.7,
}
"""How far the truth may lie from the file, one standard deviation of its logarithm, assumed."""

PRIOR_YOKE_PHASE_SD_RAD = 3 * deg
"""How far a yoke phase may lie from its drawing, one standard deviation, assumed: welds, splines
with play. A wrong tooth is looked for by itself."""

CORRELATED_MODEL_ERROR_SHARE, MODEL_ERROR_CORRELATION_OCTAVES = 0.06, (0.25, 1.0, 100.0)
"""Share of the force that the model leaves out alike at speeds so many octaves apart, one standard
deviation of each, assumed: however often a speed is passed, that does not average out
(`tests/verify/many_trucks.py`)."""

MIN_CORRELATED_ERROR_TO_NOISE_RATIO = 0.1
"""Standard deviations from which what is left out alike counts next to noise."""

CROSS_AXIS_GAIN_PARAMETER_NAME = "askew"
"""What is computed of a gauge up over what is computed of it across, beyond its gain: is not
reported, and makes intervals as wide as it leaves them."""

PRIOR_LOSS_FREQUENCY_EXPONENT_SD = 0.7
"""Exponent of frequency by which the loss of rubber grows, one standard deviation, assumed: none
of an ideal one, 1 of a damper."""

BRACKET_COMPLIANCE_PARAMETER_NAMES, PRIOR_BRACKET_COMPLIANCE_SD_S2 = (
    ("seat sideways", "seat up"),
    (1 / 60) ** 2,
)
"""By what times frequency squared a bracket's own mode, far above, raises what is felt each way:
one standard deviation, s², assumed; that of a mode at 60 Hz."""


@dataclass(frozen=True)
class FreeParameter:
    """One number that may move: as a logarithm where it cannot be zero."""

    name: str
    part: Part
    start: float
    prior: float  # standard deviation; inf where nothing is known
    log: bool = True
    address: str = ""
    was: float = np.nan

    def value(self, x: float) -> float:
        """Return the number at a place of the search."""
        return self.start * float(np.exp(x)) if self.log else self.start + x


class LeastSquaresFit:
    """Least squares of a model against cuts."""

    def __init__(
        self, model: BearingModel, cuts: OrderCuts, units: FloatArray, gauges: Sequence[str],
        *, noise: FloatArray,
    ) -> None:  # fmt: skip
        self.model, self.scene, self.cuts = model, model.scene, cuts
        self.units, self.gauges, self.noise = units, gauges, noise
        self.blocks = int(model.scene.block.max(initial=0)) + 1
        self.white: list[WhiteningFilter] = []
        self.kept: dict[bytes, ComplexArray] = {}

    def free(
        self, *, turned: tuple[int, float] | None, mode: tuple[float, float] | None
    ) -> list[FreeParameter]:
        """Return what may move from the file: with one shaft turned by rad, and with a mode."""
        at = line_file_address(self.model.response)
        found: list[FreeParameter] = []
        for name, part, place, was in identifiable_numbers(self.model.response.line):
            start, prior = was, PRIOR_LOG_SD_BY_PARAMETER["stiffness"]
            if name == "loss":
                start, prior = (
                    DEFAULT_LOSS_FACTOR if np.isnan(was) else was,
                    PRIOR_LOG_SD_BY_PARAMETER["loss"],
                )
            elif name == "phase":
                by = turned[1] if turned and part == Part("shaft", turned[0] + 1) else 0.0
                start, prior = was + by, np.inf if by else PRIOR_YOKE_PHASE_SD_RAD
            found.append(
                FreeParameter(
                    name, part, start, prior, log=name != "phase", address=f"{at}.{place}", was=was
                )
            )
        found += [
            FreeParameter(
                "gain", Part("gauge", 0, g), 1.0, PRIOR_LOG_SD_BY_PARAMETER["gain"], was=1.0
            )
            for g in self.gauges
        ]
        # How a flange is held moves what a gauge reads of one way of pulling more than of another.
        found += [
            FreeParameter(
                CROSS_AXIS_GAIN_PARAMETER_NAME,
                Part("gauge", 0, g),
                1.0,
                PRIOR_LOG_SD_BY_PARAMETER[CROSS_AXIS_GAIN_PARAMETER_NAME],
            )
            for g in self.gauges
        ]
        found.append(
            FreeParameter("law", WHOLE_LINE, 0.0, PRIOR_LOSS_FREQUENCY_EXPONENT_SD, log=False)
        )
        found += [
            FreeParameter(name, WHOLE_LINE, 0.0, 1.0, log=False)
            for name in BRACKET_COMPLIANCE_PARAMETER_NAMES
        ]
        late = PRIOR_BUS_LAG_SD_S if self.blocks > 1 else PRIOR_LOGGER_DELAY_SD_S
        found.append(FreeParameter("lag", WHOLE_LINE, 0.0, late, log=False))
        if mode is not None:
            part = Part("gauge", 0, "bracket")
            found += [
                FreeParameter("mode", part, mode[0], np.inf),
                FreeParameter(
                    "mode damping", part, mode[1], PRIOR_LOG_SD_BY_PARAMETER["mode damping"]
                ),
            ]
        return found

    def said(self, free: Sequence[FreeParameter], x: FloatArray) -> "ModelParameters":
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
            for k, name in enumerate(STIFFNESS_NAMES):
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
        askew = np.array(
            [
                values.get((CROSS_AXIS_GAIN_PARAMETER_NAME, Part("gauge", 0, g)), 1.0)
                for g in self.gauges
            ]
        )
        held = replace(self.model.held, stiffness=stiffness, loss=loss)
        return ModelParameters(
            held,
            phases,
            mode,
            gain,
            askew,
            values.get(("lag", WHOLE_LINE), 0.0),
            values.get(("law", WHOLE_LINE), 0.0),
            PRIOR_BRACKET_COMPLIANCE_SD_S2
            * np.array(
                [
                    0.0,
                    *(values.get((n, WHOLE_LINE), 0.0) for n in BRACKET_COMPLIANCE_PARAMETER_NAMES),
                ]
            ),
        )

    def stress(self, said: "ModelParameters") -> ComplexArray:
        """Return computed cuts (gauges, K, W) Pa, order 1 of 1 kg m, the mark at the yoke."""
        return np.tensordot(self.felt(said), self.force(said), axes=1)

    def force(self, said: "ModelParameters") -> ComplexArray:
        """Return the force that makes them, its three ways, (3, K, W) N."""
        scene, held = self.scene, said.held
        asked = array_bytes(held.stiffness, held.loss, said.phases, said.law, said.mode or 0)
        if asked not in self.kept:
            self.kept[asked] = self._force(said)
            discard_oldest(self.kept, MAX_KEPT_FORCE_COUNT)
        W = np.multiply.outer(FITTED_ORDERS, scene.at.speed)
        late = np.exp(2j * np.pi * said.lag * W)
        return self.kept[asked] * late * (1 + said.seat[:, None, None] * W**2)

    def _force(self, said: "ModelParameters") -> ComplexArray:
        scene = self.scene
        W = 2 * np.pi * np.multiply.outer(FITTED_ORDERS, scene.at.speed)
        out = self.model.forces(said.held, said.phases, said.law).T * bracket_mode_gain(
            said.mode, W
        )
        poles = self.model.poles(said.held, said.mode, said.law)
        for k, order in enumerate(FITTED_ORDERS):
            out[:, k] += remembered_response(scene, out[:, k], poles, order)
        return out

    def felt(self, said: "ModelParameters") -> FloatArray:
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
        """Measured less computed (gauges, K, W), in standard deviations; zero where unknown."""
        turn, *_ = self.turned(computed)
        off = np.nan_to_num((self.cuts.amplitude - computed * turn) / self.noise)
        for k, white in enumerate(self.white):
            off[:, k] = white.of(off[:, k].ravel()).reshape(off[:, k].shape)
        return off

    def allowing(self, said: "ModelParameters") -> "LeastSquaresFit":
        """Return the same with what the model leaves out of the force alike at alike speeds.

        A part of each way's force, by order: its covariance whitens what is left over.
        """
        force, felt = self.force(said), self.felt(said)
        turn, *_ = self.turned(np.tensordot(felt, force, axes=1))
        hats = shared_error_patterns(self.scene.at.speed, self.scene.torque)
        known = np.where(
            np.isnan(self.cuts.amplitude), 0, CORRELATED_MODEL_ERROR_SHARE / self.noise
        )
        other = copy(self)
        other.white = [
            WhiteningFilter.by(
                np.einsum("gw,gc,cw,jw->gwcj", known[:, k], felt, force[:, k] * turn[k], hats)
                .reshape(felt.shape[0] * hats.shape[1], -1)
            )
            for k in range(len(FITTED_ORDERS))
        ]  # fmt: skip
        return other

    def residuals(self, free: Sequence[FreeParameter], x: FloatArray) -> FloatArray:
        """Return what is left over, real and imaginary, blows cut down, and what priors say."""
        off = self.off(self.stress(self.said(free, x))).ravel()
        size = np.abs(off)
        blow = np.maximum(size, 3.0)
        off = off * np.sqrt(3 * (2 * blow - 3)) / blow
        prior = x / np.array([f.prior for f in free])
        return np.concatenate([off.real, off.imag, prior])


@dataclass(frozen=True)
class ModelParameters:
    """Numbers of the model."""

    held: MountedLine
    phases: FloatArray
    mode: tuple[float, float] | None
    gain: FloatArray
    askew: FloatArray
    lag: float
    law: float
    seat: FloatArray


@dataclass(frozen=True)
class WhiteningFilter:
    """What makes errors of covariance 1 + C Cᴴ independent: its square root's inverse."""

    ways: ComplexArray  # (m, j), square to one another
    share: FloatArray  # (j,), that is taken off of each

    @classmethod
    def by(cls, columns: ComplexArray) -> "WhiteningFilter":
        """Return it for columns C (m, n); those that are faint compared with 1 are left out."""
        ways, size, _ = np.linalg.svd(columns, full_matrices=False)
        kept = size > MIN_CORRELATED_ERROR_TO_NOISE_RATIO
        return cls(ways[:, kept], 1 - 1 / np.sqrt(1 + size[kept] ** 2))

    def of(self, off: ComplexArray) -> ComplexArray:
        """Return errors (m,) whitened."""
        return off - self.ways @ (self.share * (np.conj(self.ways).T @ off))


def shared_error_patterns(speed: FloatArray, torque: FloatArray) -> FloatArray:
    """Return what windows (W,) share of what is left out alike at alike speeds, (parts, W).

    Straight between knots of speed, as far apart as each of `MODEL_ERROR_CORRELATION_OCTAVES`; a
    line in overrun rests on other flanks than one that is driven, and shares nothing with it.
    """
    pace, coasts = np.log2(speed), torque < 0
    hats = np.concatenate([_hats(pace / o) for o in MODEL_ERROR_CORRELATION_OCTAVES])
    return np.concatenate([hats * coasts, hats * ~coasts])


def _hats(at: FloatArray) -> FloatArray:
    """Return what is straight between whole numbers, 1 at one of them: (knots, W) of (W,)."""
    knots = np.arange(np.floor(at.min()), np.ceil(at.max()) + 1)
    return np.maximum(1 - np.abs(at - knots[:, None]), 0.0)


PRIOR_LOGGER_DELAY_SD_S = 0.0005
"""What a logger's filters put a gauge behind the tacho by, s, one standard deviation, assumed."""

PRIOR_BUS_LAG_SD_S = 0.005
"""Standard deviation of a bus's lag once it is estimated from the stress, s, assumed."""
