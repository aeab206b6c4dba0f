"""Intervals of 90 % hold what is so of trucks that a multibody engine (EXUDYN) drove.

`many_trucks.py` draws them: joints off by 1.5 mm, rubber by 20 %, welds by 2.5 degrees, gauges by
5 %, brackets that give way and have a mode of their own. None of them was looked at one by one.
"""

from collections import Counter

import pytest
from many_trucks import drive, found, held, truck

pytestmark = [pytest.mark.oracle, pytest.mark.slow, pytest.mark.filterwarnings("ignore")]

TRUCKS = range(100, 132)


def test_nine_intervals_of_ten_hold_the_truth():
    """At least 85 % of each kind: 32 trucks leave a scatter of a twentieth about the 90."""
    pytest.importorskip("exudyn")
    inside, every = Counter(), Counter()
    for seed in TRUCKS:
        of = truck(seed)
        for name, holds in held(of, found(drive(of)).parameters):
            inside[name] += holds
            every[name] += 1
    share = {name: inside[name] / every[name] for name in every}
    assert set(share) == {"vertical", "lateral", "loss", "phase", "gain", "unbalance"}
    assert min(share.values()) >= 0.85, share
