"""A joint shakes a shaft up at its natural frequency, and shafts at sums of their frequencies.

Tongues grow from the speeds where twice the turning meets 2 w1, w1 + w2 and 2 w2, and thin
ones where four times it does; the difference has none. Damping lifts their tips: each is
followed down to where it closes, far narrower than any grid of a chart.
"""

import matplotlib.pyplot as plt
import numpy as np

from cardan.physics.dynamics.floquet import growth_rate, hill_multipliers
from cardan.physics.dynamics.stability_chart import instability_tongue
from cardan.physics.dynamics.torsional_line import (
    TorsionalLine,
    instability_zones,
    linearised_about_rigid_rotation,
    natural_frequencies,
)


def line(beta, damping):
    """Spring, inertia, joint, spring, inertia: all ones (Asokanthan & Hwang 1996)."""
    beta = np.asarray(beta, dtype=float)
    return TorsionalLine(
        beta=np.stack([beta, np.zeros_like(beta)], axis=-1), stiffness=np.ones(2),
        driving=np.ones(2), driven=np.zeros(2), damping=damping,
    )  # fmt: skip


w1, w2 = natural_frequencies(line(0.0, 0.0))
centres = {
    "$\\omega_1$": w1, "$(\\omega_1+\\omega_2)/2$": (w1 + w2) / 2, "$\\omega_2$": w2,
    "$(\\omega_1+\\omega_2)/4$": (w1 + w2) / 4, "$\\omega_2/2$": w2 / 2,
}  # fmt: skip
figure, axes = plt.subplots(figsize=(8, 4.5))
tips = {}
for damping, colour in ((0.002, "tab:blue"), (0.02, "tab:orange")):
    for name, centre in centres.items():
        found = instability_tongue(
            lambda speed, beta, c=damping: growth_rate(
                linearised_about_rigid_rotation(line(beta, c), speed), tolerance=1e-7
            ),
            centre=centre, x=(0.45, 2.0), y=(0.0, np.radians(35)), reach=0.012, rows=14,
        )  # fmt: skip
        if found is None:
            continue
        tips[damping, name] = found.tip
        axes.fill(found.outline[:, 0], np.degrees(found.outline[:, 1]), color=colour, alpha=0.5)
        axes.plot(found.tip[0], np.degrees(found.tip[1]), "o", color=colour, ms=3)
    axes.fill([], [], color=colour, alpha=0.5, label=f"damping {damping:g}")
for k, (name, speed) in enumerate(centres.items()):
    axes.axvline(speed, color="0.8", lw=0.8, zorder=0)
    axes.text(speed, 36 + 2.2 * (k > 2), name, ha="center", fontsize="small")
axes.set(xlabel="speed, 1", ylabel="joint angle, deg", ylim=(0, 35), xlim=(0.45, 2.0))
axes.legend()
plt.show()

found = {(z.kind, z.modes): z for z in instability_zones(line(np.radians(20), 0.0))}
assert np.round(found["principal", (1, 1)].low, 4) == 0.6096
assert np.round(found["sum", (1, 2)].high, 4) == 1.1247
assert not found["difference", (1, 2)].is_open  # what stands near it is (w1 + w2)/4

# First-order theory: the tip is where tan²(beta/2) |Kh_ij| / (2 √(w_i w_j)) = √(d_i d_j), with
# d = c w²/2 and Kh = V' [[2, -1], [-1, 0]] V of the modes V.
V = np.linalg.eigh(np.array([[2.0, -1.0], [-1.0, 1.0]]))[1]
Kh, w = V.T @ np.array([[2.0, -1.0], [-1.0, 0.0]]) @ V, np.array([w1, w2])
for c in (0.002, 0.02):
    for name, i, j in (("$\\omega_1$", 0, 0), ("$(\\omega_1+\\omega_2)/2$", 0, 1),
                       ("$\\omega_2$", 1, 1)):  # fmt: skip
        r = c / 2 * w[i] * w[j] * 2 * np.sqrt(w[i] * w[j]) / abs(Kh[i, j])
        theory = 2 * np.arctan(np.sqrt(r))
        assert abs(tips[c, name][1] / theory - 1) < (0.002 if c == 0.002 else 0.01)
# The thin ones, where Hill's determinant agrees that nothing grows; with more damping, none.
for name, low, high in (("$(\\omega_1+\\omega_2)/4$", 20.0, 20.5), ("$\\omega_2/2$", 32.0, 32.5)):
    speed, beta = tips[0.002, name]
    assert low < np.degrees(beta) < high
    system = linearised_about_rigid_rotation(line(beta, 0.002), speed)
    assert abs(np.log(np.abs(hill_multipliers(system)).max())) < 1e-5
    assert (0.02, name) not in tips
