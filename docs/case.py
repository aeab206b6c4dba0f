"""Draw docs/case.png: python docs/case.py, from the root of the repository."""

import json
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from cardan.core.units import MPa
from cardan.topics.recording.campaign_study import analyse_campaign

CASE = Path("examples/refuse-collector")
DAYS = {"joints": "promise.yaml", "road": "tracks.yaml", "engine": "direct.yaml"}
heard = {day: analyse_campaign(CASE / file).answer.parts[0][2] for day, file in DAYS.items()}
truth = {day: json.loads((CASE / f"{day}.truth.json").read_text()) for day in DAYS}

figure, (cause, cut, cure) = plt.subplots(1, 3, figsize=(14.5, 4.4), layout="constrained")
of = heard["joints"].identification
g, speed = of.gauges.index("S3"), of.cuts.windows.speed * 60
for name, z, style in (
    ("recorded", of.cuts.amplitude, "k."),
    ("as drawn", of.computed_before, "C1+"),
    ("as found", of.computed_after, "C0x"),
):
    cut.plot(speed, np.abs(z[g, 1]) / MPa, style, ms=4, label=name)
cut.set(
    xlim=(0, 600),
    xlabel="shaft speed, rpm",
    ylabel="order 2 at S3, MPa",
    title="Section 4: the line, identified",
)
cut.legend()

place, names = 0, []
for day, one in heard.items():
    for gauge, e in zip(one.causes.gauges, one.causes.joint_attributions, strict=True):
        low, high = e.interval
        cause.plot([low, high], [place, place], "C0", lw=6, alpha=0.5)
        cause.plot(truth[day]["gauges"][gauge]["removed"], place, "k|", ms=14, mew=2)
        names.append(f"{DAYS[day]}, {gauge}:\n{e.verdict}")
        place -= 1
cause.set_yticks(-np.arange(len(names)), names)
cause.set(
    xlabel="joints' share of the damage: 90 % interval, truth (|)", title="Section 3: the cause"
)

known = truth["joints"]["cured"]["gauges"]
kept = heard["joints"].predicted_lives
x = np.arange(len(kept))
for k, (name, hours) in enumerate((
    ("recorded", [p.recorded.hours for p in kept]),
    ("predicted", [p.changed.hours for p in kept]),
    ("driven in the multibody engine", [known[p.gauge]["hours"] for p in kept]),
)):  # fmt: skip
    cure.bar(x + 0.27 * (k - 1), hours, 0.25, label=name)
cure.set_xticks(x, [p.gauge for p in kept])
cure.set(
    yscale="log", ylim=(1e3, 1e9), ylabel="life, h", title="Section 6: the correction"
)  # room for the legend
cure.legend(loc="upper center")
figure.savefig("docs/case.png", dpi=80)
