"""Yokes welded at any angle: the best twist is that of a search through all of them."""

import numpy as np
import pytest

import cardan

LINE = """title: Two shafts
speed_rpm: 536
driveline:
  slopes: {side_deg: [0, 15, 3.5, 3.5], top_deg: [0, 7, 19, 19]}
  shafts: [{phase_deg: 0}, {}]
adjust: {twist_deg: {1: [-90, 90]}}
limits:
  - {quantity: torsional_acceleration, unit: rad/s2, maximum: 500, source: made up}
"""


def shaken(app, phase):
    """Torsional acceleration, rad/s², of the file with another phase."""
    changed = cardan.change(app, {"driveline.shafts[1].phase_deg": float(phase)})
    (check,) = cardan.check(changed).checks
    return check.value


@pytest.mark.slow
def test_best_yoke_phase_matches_full_sweep():
    """Joints of 15/7 and -11.5/12 deg cancel nearly at -72 deg, and in no phase of 0 or 90."""
    app = cardan.loads(LINE)
    swept = np.arange(-90, 91, 1.0)
    values = np.array([shaken(app, phase) for phase in swept])
    best = max(cardan.fix(app), key=lambda p: p.margin)
    (move,) = best.adjustments
    assert np.degrees(move.amount) == pytest.approx(swept[values.argmin()], abs=1e-9)
    (check,) = best.checks
    assert check.value == pytest.approx(values.min(), rel=1e-9)
    assert values.min() < 0.03 * shaken(app, 0)
    assert min(shaken(app, 0), shaken(app, 90)) > 10 * values.min()


@pytest.mark.slow
def test_best_yoke_phase_is_found_despite_local_minima():
    """From the best trial SLSQP steps over the crest into another valley, and back to nothing."""
    text = LINE.replace("[0, 15, 3.5, 3.5]", "[0, 15, -11.5, 0]").replace(
        "[0, 7, 19, 19]", "[0, 7, 12, 0]"
    )
    app = cardan.loads(text.replace("shafts: [{phase_deg: 0}, {}]", "shafts: [{}, {phase_deg: 0}]")
                       .replace("{1: [-90", "{2: [-90"))  # fmt: skip
    swept = np.arange(-90, 91, 1.0)
    values = []
    for phase in swept:
        changed = cardan.change(app, {"driveline.shafts[2].phase_deg": float(phase)})
        values.append(cardan.check(changed).checks[0].value)
    best = max(cardan.fix(app), key=lambda p: p.margin)
    assert best.checks[0].value == pytest.approx(min(values), rel=1e-9)


def test_intermediate_yoke_phase_is_not_tried_unless_allowed():
    """Other parts are needed: without the key aligned and crossed is all that is tried."""
    app = cardan.loads(LINE.replace("adjust: {twist_deg: {1: [-90, 90]}}\n", ""))
    assert all(
        m.adjustable.adjustment_key != "twist" for p in cardan.fix(app) for m in p.adjustments
    )
