"""Relations between obstacles and where the shafts of their line run."""

from collections.abc import Iterator
from dataclasses import replace
from math import nan

import numpy as np

from cardan.application.relation_context import (
    ComparedValue,
    ComparedValues,
    LineContext,
    RelationContext,
    ratio,
)
from cardan.application.source_location import locate_yaml_address
from cardan.core.units import mm
from cardan.model.application import Obstacle
from cardan.physics.vehicle.clearance import clearances

NEAR_SHAFT = 100 * mm
"""What stands within this of a shaft, and does not touch it, is in the file for a reason."""

LEAST_SHARE_ON_AXLE = 0.8
"""Share of the axle's travel from which an obstacle rides on an axle: assumed."""

MAX_SKEW_DEG = 15.0
"""What runs across by more is built so: a strut, a Panhard rod, a pipe. Assumed."""


def compare_obstacle_distance(of: RelationContext) -> ComparedValues:
    """Least distance of an obstacle from a shaft of its line in all states, mm; 0 if they touch."""
    for address, line, (free, *_) in _clearances(of):
        against = f"{line.at}.points", f"{line.at}.slopes.side"
        yield ComparedValue((f"{address}.start", address), max(free, 0.0) / mm, against)


def compare_obstacle_sign(of: RelationContext) -> ComparedValues:
    """Distance of an obstacle that would be near a shaft if y or z had the other sign, mm."""
    for address, line, (free, *mirrored) in _clearances(of):
        near = any(0 <= other <= NEAR_SHAFT for other in mirrored)
        against = f"{line.at}.points", f"{line.at}.slopes.side"
        value = max(free, 0.0) / mm if near else nan
        yield ComparedValue((f"{address}.start", address), value, against)


def _clearances(of: RelationContext) -> Iterator[tuple[str, LineContext, list[float]]]:
    """Yield each obstacle's address, its line and its least clearance from it in all states, m.

    As it is, and mirrored in y and in z.
    """
    for line in of.lines:
        name = line.installed.line.name
        some = [(k, o) for k, o in enumerate(of.application.obstacles, 1) if o.line == name]
        if some and (demand := line.in_states):
            every = tuple(m for _, o in some for m in (o, _mirrored(o, 1), _mirrored(o, 2)))
            free = clearances(demand.layout, line.installed.line, every, travel=demand.travel)
            least = free.min(axis=tuple(range(free.ndim - 1))).reshape(-1, 3)
            for (k, _), values in zip(some, least.tolist(), strict=True):
                yield f"obstacles[{k}]", line, values


def _mirrored(obstacle: Obstacle, axis: int) -> Obstacle:
    """Return an obstacle with another sign of one coordinate of both ends."""
    signs = np.where(np.arange(3) == axis, -1.0, 1.0)
    start, end = ((signs * p).tolist() for p in (obstacle.start, obstacle.end))
    return replace(obstacle, start=tuple(start), end=tuple(end))


def compare_obstacle_beyond_line(of: RelationContext) -> ComparedValues:
    """Distance of an obstacle ahead of joint 1 or behind the last joint, mm; 0 between them."""
    for line in of.lines:
        x = line.installed.layout.points[:, 0]
        for k, obstacle in enumerate(of.application.obstacles, 1):
            if obstacle.line == line.installed.line.name:
                first, last = sorted((obstacle.start[0], obstacle.end[0]))
                beyond = max(x[0] - last, first - x[-1]) - obstacle.radius
                keys, against = (f"obstacles[{k}].start", f"obstacles[{k}]"), (f"{line.at}.points",)
                yield ComparedValue(keys, max(float(beyond), 0.0) / mm, against)


def compare_obstacle_thickness(of: RelationContext) -> ComparedValues:
    """Diameter of an obstacle, mm; 0 where the file gives none."""
    for k, obstacle in enumerate(of.application.obstacles, 1):
        at = f"obstacles[{k}]"
        keys = f"{at}.radius", f"{at}.diameter", at
        yield ComparedValue(keys, 2 * obstacle.radius / mm, default="0 mm")


def compare_cross_member_skew(of: RelationContext) -> ComparedValues:
    """Angle of a cross member from square to the vehicle, deg; both sides of a frame are alike.

    Of obstacles from one side of the vehicle to the other. Beyond `MAX_SKEW_DEG` it is no slip,
    unless both ends are as far out and one of their other coordinates is the same.
    """
    for k, obstacle in enumerate(of.application.obstacles, 1):
        dx, dy, dz = np.abs(np.subtract(obstacle.end, obstacle.start))
        if obstacle.start[1] * obstacle.end[1] < 0:
            angle = float(np.degrees(np.arctan2(np.hypot(dx, dz), dy)))
            mirrored = obstacle.start[1] == -obstacle.end[1] and (dx == 0) != (dz == 0)
            value = angle if angle < MAX_SKEW_DEG or mirrored else nan
            at = f"obstacles[{k}]"
            yield ComparedValue((f"{at}.end", at), value, (f"{at}.start",))


def compare_obstacle_share(of: RelationContext) -> ComparedValues:
    """Share of the axle's travel that an obstacle makes, of those that the frame does not hold."""
    for k, obstacle in enumerate(of.application.obstacles, 1):
        if obstacle.travel_share:
            yield ComparedValue((f"obstacles[{k}].travel_share",), float(obstacle.travel_share))


def compare_fixed_member_height(of: RelationContext) -> ComparedValues:
    """Height above the wheel centres of a cross member that the frame holds, in tyre radii.

    Of trucks and behind joint 2, up to the wheels: ahead of it a gearbox has its supports.
    """
    if of.vehicle_class in ("medium truck", "heavy truck"):
        for k, obstacle, line, height in _cross_member_heights(of):
            at = f"obstacles[{k}]"
            behind = line.installed.layout.points[1, 0] < min(obstacle.start[0], obstacle.end[0])
            value = height if behind and not obstacle.travel_share else nan
            keys, against = (f"{at}.travel_share", at), (f"{at}.start", f"{line.axle}.pinion")
            yield ComparedValue(keys, value, against, default="0")


def compare_riding_member_height(of: RelationContext) -> ComparedValues:
    """Height above the wheel centres of a cross member that rides on an axle, in tyre radii."""
    for k, obstacle, line, height in _cross_member_heights(of):
        rides = obstacle.travel_share >= LEAST_SHARE_ON_AXLE
        keys, against = (f"obstacles[{k}].start", f"obstacles[{k}]"), (f"{line.axle}.pinion",)
        yield ComparedValue(keys, height if rides else nan, against)


def _cross_member_heights(
    of: RelationContext,
) -> Iterator[tuple[int, Obstacle, LineContext, float]]:
    """Yield number, obstacle, line and height above the wheel centres in tyre radii.

    Of what runs across from side to side, ahead of the wheels of a line that leaves the gearbox.
    """
    tyre = of.application.tyre
    for line in of.lines if tyre else ():
        axle, points = line.installed.axle, line.installed.layout.points
        if axle is None or not line.leaves_gearbox:
            continue
        wheel = points[-1] - (axle.pinion_joint[0], 0.0, axle.pinion_joint[1])
        for k, obstacle in enumerate(of.application.obstacles, 1):
            across = obstacle.start[1] * obstacle.end[1] < 0
            ahead = min(obstacle.start[0], obstacle.end[0]) < wheel[0]
            if obstacle.line == line.installed.line.name and across and ahead:
                above = (obstacle.start[2] + obstacle.end[2]) / 2 - wheel[2]
                yield k, obstacle, line, float(ratio(above, tyre and tyre.static_radius))


def compare_obstacle_length_over_diameter(of: RelationContext) -> ComparedValues:
    """Length of an obstacle's axis over its diameter, of those that are given both ends."""
    for k, obstacle in enumerate(of.application.obstacles, 1):
        end = locate_yaml_address(of.application, f"obstacles[{k}].end")
        if end and ".end" in end.key and obstacle.radius:
            axis = np.subtract(obstacle.end, obstacle.start)
            value = float(np.linalg.norm(axis)) / (2 * obstacle.radius)
            against = f"obstacles[{k}].radius", f"obstacles[{k}].diameter", f"obstacles[{k}].start"
            yield ComparedValue((f"obstacles[{k}].end",), value, against)
