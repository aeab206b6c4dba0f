"""Which tolerance decides whether the refuse collector's line passes: how high bearing 1 hangs.

After a cheap correction, bearing 2 up 18 mm and the pinion up 1 deg, nothing of its geometry
fails on paper. As trucks scatter 10 in a hundred do not keep it. A first bearing hung half as far
off wins most of those back; half the scatter of anything else alone wins little.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import cardan
from cardan.topics.variants.schema import read_variant_study
from cardan.topics.variants.statistics import halved_tolerance_yields, yield_map_cell_counts

here = Path(cardan.__file__).parents[2]
truck = cardan.read(here / "examples" / "refuse-collector-6x2.yaml")
request = read_variant_study(here / "docs" / "gallery" / "tolerances.yaml", truck)
found = cardan.study(
    truck, request.vary, tolerances=request.tolerances, n=1024, limits=request.ask.limits, rows=None
)
names = [found.sampling_plan.name_of(f) for f in found.sampling_plan.factors if f.tolerance]
share, error = halved_tolerance_yields(found.statistics["tighter"])
gain = 100 * (share[:, 0] - found.yield_)
order = np.argsort(gain)

figure, (bars, scatter) = plt.subplots(2, 1, figsize=(7, 7))
bars.barh([names[k] for k in order], gain[order], xerr=200 * error[order, 0])
bars.set(xlabel=f"gain in yield with half the tolerance, % (of {found.yield_:.0%} now)")
worst = int(found.statistics["counts"]["grades"][:, 2].argmax())
limit = found.limits[worst][1]
values, counts = yield_map_cell_counts(found.statistics["values"], worst)
scatter.hist(values, bins=40, weights=counts)
scatter.axvline(limit.maximum, color="r")
scatter.set(xlabel=f"{limit.quantity}, SI, and its maximum", ylabel="trucks")
figure.tight_layout()
plt.show()

low, high = found.interval()
assert low < 0.9 < 0.93 < share[:, 0].max()
assert names[int(gain.argmax())] == "bearing_height_mm[1]"
assert np.sort(gain)[-2] < gain.max() / 2
