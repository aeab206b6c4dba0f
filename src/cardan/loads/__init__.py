"""What the torque of a line does to its joints and bearings round a turn."""

from cardan.loads.approximate import small_angle
from cardan.loads.cycle import Cycle
from cardan.loads.ends import Reactions, bearing_pair, gwb_reactions
from cardan.loads.statics import Loads, Rotating, loads, slip_force, unbalance

__all__ = [
    "Cycle",
    "Loads",
    "Reactions",
    "Rotating",
    "bearing_pair",
    "gwb_reactions",
    "loads",
    "slip_force",
    "small_angle",
    "unbalance",
]
