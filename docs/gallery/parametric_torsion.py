"""A joint shakes a shaft up at its natural frequency, and shafts at sums of theirs.

The chart is found by its boundaries: three tongues grow from the speeds where twice the
turning meets 2 w1, w1 + w2 and 2 w2; the difference has none. Damping lifts their tips.
"""

import matplotlib.pyplot as plt
import numpy as np

from cardan.dynamics.chart import boundary
from cardan.dynamics.periodic import growth, over
from cardan.dynamics.torsion import TorsionLine, about_rigid_rotation, natural_frequencies, zones


def line(beta, damping):
    """Spring, inertia, joint, spring, inertia: all ones (Asokanthan & Hwang 1996)."""
    beta = np.asarray(beta, dtype=float)
    return TorsionLine(
        beta=np.stack([beta, np.zeros_like(beta)], axis=-1), stiffness=np.ones(2),
        driving=np.ones(2), driven=np.zeros(2), damping=damping,
    )  # fmt: skip


figure, axes = plt.subplots(figsize=(7, 4))
for damping, colour in ((0.002, "tab:blue"), (0.02, "tab:orange")):
    edge = boundary(
        lambda speed, beta, damping=damping: over(
            lambda s, b: growth(about_rigid_rotation(line(b, damping), s)), speed, beta
        ),
        x=(0.45, 2.0), y=(np.radians(2), np.radians(35)), start=(120, 12), levels=2,
    )  # fmt: skip
    for piece in edge.pieces:
        axes.plot(piece[:, 0], np.degrees(piece[:, 1]), color=colour, lw=1)
    axes.plot([], [], color=colour, label=f"damping {damping:g}")
w1, w2 = natural_frequencies(line(0.0, 0.0))
for speed, name in ((w1, "$\\omega_1$"), ((w1 + w2) / 2, "$(\\omega_1+\\omega_2)/2$"),
                    (w2, "$\\omega_2$")):  # fmt: skip
    axes.axvline(speed, color="0.8", lw=0.8, zorder=0)
    axes.text(speed, 36, name, ha="center")
axes.set(xlabel="speed, 1", ylabel="joint angle, deg", ylim=(0, 35))
axes.legend()
plt.show()

found = {(z.kind, z.modes): z for z in zones(line(np.radians(20), 0.0))}
assert np.round(found["principal", (1, 1)].low, 4) == 0.6096
assert np.round(found["sum", (1, 2)].high, 4) == 1.1247
assert not found["difference", (1, 2)].open
