"""Who broke the bracket? Told from a recording, once with guilty joints and once without.

A two-piece driveline hangs on a centre bearing whose bracket cracks. Its gauge is recorded on
the route. The geometry says how hard the joints shake the bearing (order 2, in proportion to
torque), a unit load case of the bracket says what that is at the gauge, and the recording says
what was really there. The recordings are synthetic: made by a generator, so that the truth is
known. The bracket's unit stresses are assumed.
"""

import matplotlib.pyplot as plt
import numpy as np

from cardan.base.units import MPa, deg
from cardan.fatigue.cause import EVENTS, JOINTS, separation, stress_per_torque, suspects
from cardan.fatigue.life import Plan, causes, life, look
from cardan.fatigue.orders import rotation_from_speed
from cardan.fatigue.strain import direct
from cardan.fatigue.strength import SNCurve
from cardan.fatigue.synthetic import AXLE_RATIO, Gains, synthetic
from cardan.kinematics.chain import turn
from cardan.loads import loads
from cardan.model.layout import from_slopes
from cardan.model.parts import CentreBearing, Line, Shaft
from cardan.report.language import EN
from cardan.report.life import figure, gauges, who
from cardan.report.terminal import columns

UNIT_STRESS = np.array([10.0, 25.0, 35.0]) * MPa / 1e3  # per N along x, y, z: assumed
LENGTHS = (1.2, 1.5)
CURVE = SNCurve(amplitude=30 * MPa, cycles=2e6, slope=5, scatter=0.05).modified()

# The same line as designed, and after a repair that hung the bearing 42 mm too high and put
# the yokes of the first shaft together a quarter turn out: side slopes and yoke phase.
CASES = {
    "as designed": ((3.0, 1.0, 4.5, 2.0), 0 * deg),
    "after the repair": ((3.0, -1.0, 6.1, 2.0), 90 * deg),
}


def predicted(side, phase):
    """Order-2 stress at the gauge per shaft torque, Pa per N m."""
    line = Line(
        shafts=(
            Shaft(length=LENGTHS[0], centre_bearing=CentreBearing(), phase=phase),
            Shaft(length=LENGTHS[1]),
        )
    )
    layout = from_slopes(side=np.array(side) * deg, top=np.zeros(4), lengths=LENGTHS)
    chain = turn(layout.directions, phases=line.phases)
    force = loads(layout, chain, line, torque=1.0).bearing_forces.order(2)[0]
    return float(stress_per_torque(force, UNIT_STRESS))


def analysed(per_torque, seed):
    """Drive the route, analyse the recording and say who did it."""
    gains = Gains(joints=per_torque * 10e3, events=35 * MPa, road=4 * MPa)
    drive = synthetic(seconds=600, gains={"S1": gains}, seed=seed).recording
    plan = Plan(gauges=(direct("S1", "S1", factor=MPa),), curve=CURVE, gauge_error=0.03)
    shaft, engine = (
        rotation_from_speed(drive.pieces([c]), rate=drive.rate, unit=1 / 60)
        for c in ("shaft_speed", "engine_speed")
    )
    named = suspects(shaft, engine=engine, wheel=shaft.geared(1 / AXLE_RATIO))
    healths = look(drive, channels=plan.channels)
    lives = life(drive, plan=plan, healths=healths)
    found = causes(
        drive, plan=plan, healths=healths, how=separation(named, rate=drive.rate),
        torque=("torque", 1e3), predicted={"S1": per_torque},
    )  # fmt: skip
    return drive, plan, lives, found


told = {}
for seed, (name, (side, phase)) in enumerate(CASES.items(), start=7):
    per_torque = predicted(side, phase)
    drive, plan, lives, found = analysed(per_torque, seed)
    told[name] = found.attributions[0], found.comparisons[0]
    print(f"{name}: predicted order 2 {per_torque * 1e3 / MPa:.2f} MPa per kN m at the gauge")
    for line in (*columns(gauges(lives, EN)), *who(lives, found)):
        print("  " + line)
    sheet = plt.figure(figsize=(11, 10), layout="constrained")
    figure(sheet, recording=drive, lives=lives, causes=found)

innocent, guilty = (told[name][0] for name in CASES)
assert innocent.share(JOINTS) < 0.03
assert max(innocent.shares, key=innocent.share) == EVENTS
assert guilty.share(JOINTS) > 0.5
assert guilty.without(JOINTS) < guilty.whole / 2
for _, comparison in told.values():
    assert abs(comparison.ratio - 1) < 0.1  # the geometry predicts what the gauge felt
