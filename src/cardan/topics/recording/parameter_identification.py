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
raises and what a logger's filters delay moves with the rest, and is not reported. Other places that
fit as well are in the interval. Gains are those of the plain sum above.
Source: derived from first principles; Ljung, System Identification (1999), ch. 7;
Cameron & Miller, A practitioner's guide to cluster-robust inference, J. Hum. Resour. 50 (2015);
Kennedy & O'Hagan, Bayesian calibration of computer models, J. R. Stat. Soc. B 63 (2001).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from cardan.core.arrays import ComplexArray, FloatArray
from cardan.core.errors import DesignError
from cardan.core.labels import Part
from cardan.core.units import deg
from cardan.model.application import Application
from cardan.physics.signals.order_cuts import order_cuts
from cardan.physics.signals.shaft_angle import ShaftAngle
from cardan.topics.recording.bearing_model import (
    COARSE_MODE_SIMULATION_RATE_HZ,
    FITTED_ORDERS,
    STIFFNESS_NAMES,
    BearingModel,
    check_stiffness_keys,
    measurement_windows,
)
from cardan.topics.recording.gauge_consistency import (
    doubt_of_order2_unexplained_by_line,
    doubt_of_reversed_torque_sign,
    inconsistent_gauge,
)
from cardan.topics.recording.identification_result import (
    IdentificationResult,
    IdentifiedParameter,
    application_with_changes,
)
from cardan.topics.recording.model_fit import (
    BRACKET_COMPLIANCE_PARAMETER_NAMES,
    CROSS_AXIS_GAIN_PARAMETER_NAME,
    FreeParameter,
    LeastSquaresFit,
    ModelParameters,
)
from cardan.topics.recording.multistart_least_squares import (
    LeastSquaresResult,
    distinct_minima,
    levenberg_marquardt,
    multistart,
    sum_of_squares,
)

MODEL_ERROR_SHARE_PER_WINDOW = 0.02
"""Share of an amplitude that the model leaves out by itself in each window, assumed."""


MAX_RIVAL_MINIMUM_EXTRA_MISFIT_VARIANCES = 9.0
"""Misfit in variances by which another place may fit worse and still be the truth."""

MIN_CONFIDENCE_HALF_WIDTH_BY_PARAMETER = {
    "vertical": 0.03,
    "lateral": 0.03,
    "loss": 0.06,
    "gain": 0.025,
    "mode damping": 0.03,
}
"""Half of the narrowest interval that is reported, relative: joints 2 mm from where they are drawn,
and gauges whose stress is that of a flange held otherwise, move the answers by as much
(`tests/verify/many_trucks.py`, `collector_day.py`)."""

HALF_WIDTH_OF_90_PERCENT_INTERVAL_SD = 1.645
"""Standard deviations to either side of a 90 % interval."""


MAX_INTERVAL_TO_PRIOR_WIDTH_RATIO = 0.5
"""A parameter is reported if its interval is narrower than this share of what was assumed."""


MAX_SEARCH_WINDOWS = 120
"""Windows up to which all are looked at in that search."""

MAX_GOOD_FIT_VARIANCES = 1.5
"""Misfit of a number, in variances, up to which the file's own parts explain a recording."""

MAX_PRIOR_DEVIATION_SD = 3.0
"""Standard deviations from what was assumed from which something else is looked for."""


MIN_MISFIT_REDUCTION_VARIANCES = 14.0
"""Variances by which a shaft put together otherwise, or a mode, has to fit better to be likelier:
2 ln of a dozen places that are looked at, where one line of a hundred has it."""

MIN_MISFIT_REDUCTION_SHARE = 0.3
"""Share of the misfit that another yoke phase or a mode of the bracket has to take away."""


def identify_parameters(
    application: Application,
    pieces: Iterator[FloatArray],
    *,
    rate: float,
    gauges: Sequence[str],
    units: FloatArray,
    angle: ShaftAngle,
    torque: tuple[FloatArray, float],
    seconds: float,
    state: str = "gvw",
    bearing: int = 1,
    phases: bool = True,
) -> IdentificationResult:
    """Identify from a recording which parameters of its application differ.

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
    scene = measurement_windows(angle, torque, seconds)
    cuts = order_cuts(pieces, rate=rate, rotation=angle.rotation, at=scene.at, orders=FITTED_ORDERS)
    model = BearingModel(application, state=state, bearing=bearing, scene=scene)
    check_stiffness_keys(model.response)
    level = _smoothed(cuts.noise)
    # What is small compared with the rest of its order is known no better than that.
    size = np.abs(cuts.amplitude)
    rough = size**2 + np.nanmean(size[:, 1:2] ** 2, axis=-1, keepdims=True)
    noise = np.nan_to_num(np.sqrt(level**2 + MODEL_ERROR_SHARE_PER_WINDOW**2 * rough), nan=1.0)
    fit = LeastSquaresFit(model, cuts, units, gauges, noise=noise)
    few = slice(None, None, int(np.ceil(scene.at.time.size / MAX_SEARCH_WINDOWS)))
    coarse = LeastSquaresFit(
        BearingModel(
            application,
            state=state,
            bearing=bearing,
            scene=measurement_windows(
                angle, torque, seconds, rate=COARSE_MODE_SIMULATION_RATE_HZ, few=few
            ),
        ),
        replace(cuts, amplitude=cuts.amplitude[..., few]),
        units,
        gauges,
        noise=noise[..., few],
    )
    places = _best(fit, coarse, phases=phases)
    plain = places[0]
    width = _spread(fit, plain)
    fit = fit.allowing(fit.said(plain.free, plain.x))
    minima = _apart(
        [_ended(fit, one.free, one.x, steps=40, gain=1e-6) for one in places[:MAX_RIVAL_MINIMA]]
    )
    return _told(fit, minima, (plain.x, width), application, state=state, bearing=bearing)


STIFFNESS_SEARCH_FACTOR = 2.25
"""How many times stiffer or softer than written rubber is looked for. A case of two bearings whose
file had one twice as stiff as it was had been identified, as certain, as four times that."""

MAX_RIVAL_MINIMA = 3
"""How many of the places that were found are fitted again with what the model leaves out alike."""

WINDOWS_PER_CORRELATED_ERROR_BLOCK = 12
"""Adjacent windows that err together."""


def _smoothed(noise: FloatArray) -> FloatArray:
    """Return the median (..., W) of fifteen windows: a resonance that is passed is no noise."""
    from scipy.ndimage import median_filter

    known = np.where(np.isnan(noise), np.nanmedian(noise, axis=-1, keepdims=True), noise)
    size = min(15, known.shape[-1])
    return median_filter(known, size=(*[1] * (known.ndim - 1), size), mode="nearest")


@dataclass(frozen=True)
class _FittedMinimum(LeastSquaresResult):
    """Where least squares ended, and what moved there."""

    free: list[FreeParameter]

    @property
    def worth(self) -> float:
        """In variances, of a number."""
        return self.misfit / max(self.residuals.size - self.x.size, 1)

    @property
    def strain(self) -> float:
        """Largest departure from what was assumed, in standard deviations."""
        return float(np.abs(self.residuals[-self.x.size :]).max())

    def value(self, name: str) -> float:
        """Return the first number of a name."""
        return next(f.value(v) for f, v in zip(self.free, self.x, strict=True) if f.name == name)

    def beginning(self, free: Sequence[FreeParameter]) -> FloatArray:
        """Return where others would begin: here, as far as they are the same."""
        here = {(f.name, f.part): v for f, v in zip(self.free, self.x, strict=True)}
        return np.array([here.get((f.name, f.part), 0.0) for f in free])


def _best(fit: LeastSquaresFit, coarse: LeastSquaresFit, *, phases: bool) -> list[_FittedMinimum]:
    """Return the fit that is best, and after it others of the same numbers elsewhere.

    Where the numbers of the file's own parts explain what was measured, nothing else is looked
    for. Else one shaft may have been put together otherwise than drawn, or the bracket may have
    a mode of its own.
    """
    found = _searched(fit, coarse, fit.free(turned=None, mode=None))
    best = found[0]
    if best.worth < MAX_GOOD_FIT_VARIANCES and best.strain < MAX_PRIOR_DEVIATION_SD:
        return found
    turned = _otherwise(coarse, best) if phases else []
    options = [_ended(fit, free, np.zeros(len(free))) for free in turned]
    modes = [_ended(fit, free, best.beginning(free)) for free in _modes(coarse, best)]
    # Above all that the orders reach it is no mode, but whatever makes gauges feel more with speed.
    reach = max(FITTED_ORDERS) * float(fit.scene.at.speed.max())
    options += [one for one in modes if one.value("mode") < reach]
    if not options:
        return found
    better = min(options, key=lambda one: one.misfit)
    # What explains as much by numbers that are likely is better as well.
    likelier = (
        better.misfit < best.misfit - MIN_MISFIT_REDUCTION_VARIANCES
        and better.strain < MAX_PRIOR_DEVIATION_SD <= best.strain
    )
    if not likelier and better.misfit > (1 - MIN_MISFIT_REDUCTION_SHARE) * best.misfit:
        return found
    return _apart([better, *_searched(fit, coarse, better.free)])


def _searched(
    fit: LeastSquaresFit, coarse: LeastSquaresFit, free: list[FreeParameter]
) -> list[_FittedMinimum]:
    """Return the places where least squares end, apart from one another, the best first.

    Lines of several bearings have many, of which one is true: rubber is looked for as the file
    has it, and up to `STIFFNESS_SEARCH_FACTOR` times as stiff and as soft.
    """
    far = np.zeros(len(free))
    far[_moved(free, *STIFFNESS_NAMES)] = np.log(STIFFNESS_SEARCH_FACTOR)
    places = multistart(partial(coarse.residuals, free), far=far)
    return _apart([_ended(fit, free, one.x) for one in places[:MAX_RIVAL_MINIMA]])


def _ended(
    fit: LeastSquaresFit, free: list[FreeParameter], x: FloatArray, **how: Any
) -> _FittedMinimum:
    """Return where least squares end that begin at a place (p,), as `least` is called."""
    at = levenberg_marquardt(partial(fit.residuals, free), x, **how)
    return _FittedMinimum(at.x, at.residuals, at.jacobian, free)


def _apart(found: list[_FittedMinimum]) -> list[_FittedMinimum]:
    return distinct_minima(found, _moved(found[0].free, *STIFFNESS_NAMES))


def _otherwise(fit: LeastSquaresFit, best: _FittedMinimum) -> list[list[FreeParameter]]:
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


def _modes(fit: LeastSquaresFit, best: _FittedMinimum) -> list[list[FreeParameter]]:
    """Return what may move with a mode of the bracket, of the two likeliest to be left out."""
    speed = fit.scene.at.speed
    options = [
        fit.free(turned=None, mode=(float(f), d))
        for f in np.geomspace(max(2.5 * speed.min(), 4.0), 5 * speed.max(), 18)
        for d in (0.02, 0.06)
    ]
    return sorted(options, key=lambda free: _rough(fit, free, best))[:2]


def _rough(fit: LeastSquaresFit, free: list[FreeParameter], best: _FittedMinimum) -> float:
    """Return the misfit of other shafts or modes where the rest stays."""
    return sum_of_squares(fit.residuals(free, best.beginning(free)))


def _moved(free: Sequence[FreeParameter], *names: str) -> list[int]:
    """Return which of what may move have one of some names."""
    return [k for k, f in enumerate(free) if f.name in names]


def _told(
    fit: LeastSquaresFit,
    minima: list[_FittedMinimum],
    plain: tuple[FloatArray, FloatArray],
    application: Application,
    *,
    state: str,
    bearing: int,
) -> IdentificationResult:
    """Return what was found with its intervals: of the best minimum, and of those as likely.

    Gains are those of the plain fit, given with its widths. What the model leaves out of the force
    alike at all speeds cannot be distinguished from them, so where it is allowed for, what was
    assumed decides; the plain amplitude is what was recorded, and by it force is read back. The
    interval holds both.
    """
    found = minima[0]
    rivals = [
        one
        for one in minima
        if one.misfit - found.misfit < MAX_RIVAL_MINIMUM_EXTRA_MISFIT_VARIANCES
    ]
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
    parameters: list[IdentifiedParameter] = []
    for n, f in enumerate(free):
        if f.name in (
            "lag",
            "law",
            *BRACKET_COMPLIANCE_PARAMETER_NAMES,
            CROSS_AXIS_GAIN_PARAMETER_NAME,
        ):
            continue
        floor = MIN_CONFIDENCE_HALF_WIDTH_BY_PARAMETER.get(f.name, 0.01 if f.log else 0.5 * deg)
        at = x[n]
        places = [*likely, plain] if gain[n] else likely
        low = min(
            float(y[n]) - max(HALF_WIDTH_OF_90_PERCENT_INTERVAL_SD * float(s[n]), floor)
            for y, s in places
        )
        high = max(
            float(y[n]) + max(HALF_WIDTH_OF_90_PERCENT_INTERVAL_SD * float(s[n]), floor)
            for y, s in places
        )
        told = (
            not np.isfinite(f.prior)
            or (high - low) / 2
            < HALF_WIDTH_OF_90_PERCENT_INTERVAL_SD * MAX_INTERVAL_TO_PRIOR_WIDTH_RATIO * f.prior
        )
        low, high = f.value(low), f.value(high)
        parameters.append(
            IdentifiedParameter(
                name=f.name, part=f.part, file_value=f.was, value=f.value(at), low=low, high=high,
                identifiable=bool(told), assumed=not told, address=f.address,
            )
        )  # fmt: skip
    parameters += _unbalance(fit, said, computed[:, 0], U)
    second, noise, scene = fit.cuts.amplitude[:, 1], fit.cuts.noise[:, 1], fit.scene
    asked = (
        inconsistent_gauge(second, noise, units=fit.units, gauges=tuple(fit.gauges)),
        doubt_of_reversed_torque_sign(scene.fine_torque, scene.fine_speed, rate=scene.rate),
        doubt_of_order2_unexplained_by_line(second, noise, computed[:, 1]),
    )
    doubts = tuple(doubt for doubt in asked if doubt is not None)
    if doubts:  # numbers that fit what is wrong are wrong, and surely so
        parameters = [replace(p, identifiable=False, assumed=False) for p in parameters]
    result = IdentificationResult(
        application=application,
        identified=application,
        state=state,
        bearing=bearing,
        parameters=tuple(parameters),
        gauges=tuple(fit.gauges),
        cuts=fit.cuts,
        torque=fit.scene.torque,
        computed_before=written,
        computed_after=computed,
        unit_stress=units,
        mean_stress=units @ fit.model.mean.T,
        tacho_mark_angle=mark,
        misfit=(_share(fit, written), _share(fit, computed)),
        line_frequencies=fit.model.hung(said.held),
        doubts=doubts,
    )
    changes = {p.address: p.in_display_unit(p.value) for p in parameters if p.needs_rewrite}
    return replace(result, identified=application_with_changes(application, changes))


def _spread(fit: LeastSquaresFit, found: _FittedMinimum) -> FloatArray:
    """Return standard deviations (p,), by blocks of windows: neighbours err alike."""
    p = found.x.size
    body, prior = found.jacobian[:-p], found.jacobian[-p:]
    left = found.residuals[:-p]
    G, K, W = fit.cuts.amplitude.shape
    windows_of = np.tile(np.arange(W), G * K * 2)
    block = windows_of // WINDOWS_PER_CORRELATED_ERROR_BLOCK
    count = int(block.max()) + 1
    score = np.stack([body[block == b].T @ left[block == b] for b in range(count)])
    gram = body.T @ body + prior.T @ prior
    inverse = np.linalg.pinv(gram, hermitian=True)
    middle = score.T @ score * (count / max(count - 1, 1)) + prior.T @ prior
    robust = inverse @ middle @ inverse
    noise = max(float(left @ left) / max(left.size - p, 1), 0.0)
    plain = inverse * max(noise, 1.0) * 1.5  # windows overlap by half
    return np.sqrt(np.maximum(np.diag(robust), np.diag(plain)))


def _unbalance(
    fit: LeastSquaresFit, said: ModelParameters, fitted: ComplexArray, U: complex
) -> list[IdentifiedParameter]:
    """Return what is unbalanced at the rear of the bearing's shaft, kg m."""
    measured = fit.cuts.amplitude[:, 0]
    w = np.where(np.isnan(measured), 0.0, 1 / fit.noise[:, 0] ** 2)
    one = fitted / U if U else np.zeros_like(fitted)
    power = max(float((np.abs(one) ** 2 * w).sum()), 1e-300)
    # Gauges feel the same road, and neighbours err alike: what is left over, block by block.
    each = (np.conj(one) * np.nan_to_num(measured - fitted) * w).sum(0)
    score = np.add.reduceat(each, np.arange(0, each.size, WINDOWS_PER_CORRELATED_ERROR_BLOCK))
    # Windows overlap by half; what the model leaves out of an order is in the noise.
    sigma = float(np.sqrt(max(1.5 / power, (np.abs(score) ** 2).sum() / power**2)))
    half = HALF_WIDTH_OF_90_PERCENT_INTERVAL_SD * sigma + 0.03 * abs(U)
    size = abs(U)
    # A mode of the bracket just above what order 2 reached would have raised order 1 by a third.
    raised = 4 / 3 if said.mode is None else 1.0
    part = Part("shaft", fit.model.shaft + 1)
    return [
        IdentifiedParameter(
            name="unbalance",
            part=part,
            file_value=np.nan,
            value=size,
            low=max(size - half, 0.0) / raised,
            high=size + half,
            identifiable=size > half,
        )
    ]


def _share(fit: LeastSquaresFit, computed: ComplexArray) -> float:
    """Share of the measured order 2's energy that is not explained."""
    a = fit.cuts.amplitude[:, 1]
    known = ~np.isnan(a)
    return float((np.abs(a - computed[:, 1])[known] ** 2).sum() / (np.abs(a[known]) ** 2).sum())
