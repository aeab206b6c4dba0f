"""Whether what gauges and torque say can be of one bearing at all, before numbers are reported.

Two ways of a force on a bearing do something known at each gauge, so three gauges and more have to
agree. One that reads the other way round, half as much or at another's place does not, and least
squares would bend every stiffness to it, with narrow intervals. Source: derived.
"""

import numpy as np

from cardan.core.arrays import BoolArray, ComplexArray, FloatArray
from cardan.core.message import TranslatableMessage, translatable_message

MAX_GAUGE_DISAGREEMENT_SHARE = 0.05
"""Share of order 2, all gauges alike, that no force explains: half a hundredth where scales are off
by 10 %, one standard deviation; of one gauge that reads half up to 0.08, backwards a half."""
MAX_DISAGREEMENT_RATIO_LEAVING_ONE_OUT = 0.25
"""Of that share, that is left where the one gauge that is wrong is left out."""
MIN_RELATIVE_GAUGE_SCALE_ERROR = 0.25
"""By which it has to read otherwise than the others say."""
MIN_WINDOWS = 12
"""Windows that hold information."""
MAX_CORRELATION_OF_REVERSED_TORQUE = -0.3
"""Correlation of a torque with how the shaft gains speed, from which its sign is the other."""
MIN_SHAFT_SPEED_REV_S = 0.5
"""Turns a second from which a shaft is under way."""
MAX_UNEXPLAINED_SHARE_OF_ORDER2_STRESS = 0.5
"""Share of order 2, beyond what noise does, from which what is left out is the most of it."""

DOUBT_ONE_INCONSISTENT_GAUGE = (
    "{gauge} reads {ratio} times what the other gauges say of one force: its sign, its scale, or "
    "are two exchanged?"
)
DOUBT_SEVERAL_INCONSISTENT_GAUGES = (
    "by what a force does at each, the gauges contradict one another: a sign, a scale, or are two "
    "exchanged?"
)
DOUBT_TORQUE_SIGN = (
    "the shaft loses speed where its torque drives it, and gains where it brakes: is its sign the "
    "other way round?"
)
DOUBT_WRONG_DRIVELINE_FILE = (
    "more than half of order 2 is explained by no such line: is the file that of another, or a "
    "bearing, a gauge or a speed the wrong one?"
)


def inconsistent_gauge(
    order2: ComplexArray, noise: FloatArray, *, units: FloatArray, gauges: tuple[str, ...]
) -> TranslatableMessage | None:
    """Return which gauge contradicts the others, or that some do; None where none does.

    Parameters
    ----------
    order2, noise : (gauges, W) Pa
        Cuts, nan where they are not known, and what noise makes of them.
    units : (gauges, 3) Pa/N
        What a unit force does at each; along the shaft hardly any is.
    gauges
        Their names.
    """
    known = ~np.isnan(order2).any(0)
    if np.count_nonzero(known) < MIN_WINDOWS or len(gauges) < 3:
        return None
    size = np.sqrt(np.mean(np.abs(order2[:, known]) ** 2, axis=-1, keepdims=True))
    a, heard, u = order2[:, known] / size, noise[:, known] / size, units[:, 1:] / size

    def told(use: BoolArray) -> tuple[ComplexArray, float]:
        """Return what the others say of all (gauges, W), and how far they contradict each other."""
        said_ = u @ (np.linalg.pinv(u[use]) @ a[use])
        left = np.abs(a - said_)[use] ** 2 - heard[use] ** 2
        return said_, float(left.sum() / (np.abs(a[use]) ** 2).sum())

    every = np.ones(len(gauges), bool)
    _, whole = told(every)
    if not whole > MAX_GAUGE_DISAGREEMENT_SHARE:
        return None
    if len(gauges) > 3:
        best = min(range(len(gauges)), key=lambda g: told(np.arange(len(gauges)) != g)[1])
        others, left = told(np.arange(len(gauges)) != best)
        ratio = float((np.vdot(others[best], a[best]) / np.vdot(others[best], others[best])).real)
        if (
            left < MAX_DISAGREEMENT_RATIO_LEAVING_ONE_OUT * whole
            and abs(ratio - 1) > MIN_RELATIVE_GAUGE_SCALE_ERROR
        ):
            return translatable_message(
                DOUBT_ONE_INCONSISTENT_GAUGE, gauge=gauges[best], ratio=f"{ratio:.2f}"
            )
    return translatable_message(DOUBT_SEVERAL_INCONSISTENT_GAUGES)


def doubt_of_reversed_torque_sign(
    torque: FloatArray, speed: FloatArray, *, rate: float
) -> TranslatableMessage | None:
    """Return that a torque (n,) is of the other sign, by speed (n,) turns/s; None if not."""
    from scipy.ndimage import uniform_filter1d

    n = max(round(rate), 1)
    gains = uniform_filter1d(np.gradient(speed), n)
    pulls = uniform_filter1d(torque, n)
    way = speed > MIN_SHAFT_SPEED_REV_S
    if np.count_nonzero(way) < MIN_WINDOWS * n or not (np.ptp(gains[way]) > 0 < np.ptp(pulls[way])):
        return None
    together = np.corrcoef(gains[way], pulls[way])[0, 1]
    return (
        translatable_message(DOUBT_TORQUE_SIGN)
        if together < MAX_CORRELATION_OF_REVERSED_TORQUE
        else None
    )


def doubt_of_order2_unexplained_by_line(
    order2: ComplexArray, noise: FloatArray, computed: ComplexArray
) -> TranslatableMessage | None:
    """Return that no such line as was computed explains cuts (gauges, W); None if it does."""
    known = ~np.isnan(order2)
    heard = float((noise[known] ** 2).sum())
    left = float((np.abs(order2 - computed)[known] ** 2).sum()) - heard
    there = float((np.abs(order2[known]) ** 2).sum()) - heard
    return (
        translatable_message(DOUBT_WRONG_DRIVELINE_FILE)
        if there > 0 and left > MAX_UNEXPLAINED_SHARE_OF_ORDER2_STRESS * there
        else None
    )
