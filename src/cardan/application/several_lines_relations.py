"""Relations between the lines of one vehicle, and between a through-driven axle and its lines."""

from collections.abc import Iterator

import numpy as np

from cardan.application.relation_context import (
    ComparedValue,
    ComparedValues,
    LineContext,
    RelationContext,
    ratio,
)
from cardan.core.units import deg, mm


def compare_torque_shares(of: RelationContext) -> ComparedValues:
    """Sum of the torque shares of all lines that leave the gearbox, 1 if none is missing."""
    lines = [line for line in of.lines if line.leaves_gearbox]
    vehicle = of.application.vehicle
    driven = {"rear": vehicle.driven_rear, "front": vehicle.driven_front} if vehicle else {}
    drives = {line.installed.drives for line in lines}
    if "all" in drives or any(count and end not in drives for end, count in driven.items()):
        return
    total = sum(line.installed.torque_share for line in lines)
    for line in lines:
        yield ComparedValue((f"{line.at}.torque_share", line.at), float(total), default="1")


def compare_torque_for_load(of: RelationContext) -> ComparedValues:
    """Torque share of a line of an all-wheel drive over its axles' share of the load at gvw.

    A share of 1, as where nothing is given, is the most that there can be: not compared.
    """
    vehicle = of.application.vehicle
    laden = next((load for load in vehicle.loads if load.name == "gvw"), None) if vehicle else None
    if vehicle is None or not (vehicle.driven_front and vehicle.driven_rear) or laden is None:
        return
    loads = {"front": laden.front_load, "rear": laden.rear_load}
    for line in of.lines:
        if line.leaves_gearbox and line.installed.drives in loads and all(loads.values()):
            carried = ratio(loads[line.installed.drives], sum(v or 0.0 for v in loads.values()))
            share = line.installed.torque_share
            value = ratio(share if share < 1 else None, carried)
            yield ComparedValue((f"{line.at}.torque_share",), value, ("vehicle.loads.gvw",))


def compare_inter_axle_shares(of: RelationContext) -> ComparedValues:
    """Torque share of a line between axles over that of the line ahead of it."""
    for line, ahead in _inter_axle_lines(of):
        value = ratio(line.installed.torque_share, ahead.installed.torque_share)
        keys = (f"{line.at}.torque_share", line.at)
        yield ComparedValue(keys, value, (f"{ahead.at}.torque_share",), default="1")


def compare_inter_axle_load_shares(of: RelationContext) -> ComparedValues:
    """Load share behind a line between axles over that behind the line ahead of it."""
    for line, ahead in _inter_axle_lines(of):
        value = ratio(line.installed.load_share, ahead.installed.load_share)
        keys = (f"{line.at}.load_share", line.at)
        yield ComparedValue(keys, value, (f"{ahead.at}.load_share",), default="1")


def compare_lines_over_axles(of: RelationContext) -> ComparedValues:
    """Lines to rear axles over the number of driven rear axles."""
    vehicle = of.application.vehicle
    rear = [line for line in of.lines if line.installed.drives == "rear"]
    if vehicle and vehicle.driven_rear and rear and len(rear) == len(of.lines):
        value = len(rear) / vehicle.driven_rear
        yield ComparedValue(("vehicle.drive",), value, ("driveline", "drivelines"))


def compare_through_driven_axles(of: RelationContext) -> ComparedValues:
    """Rear axles that lines reach from axle to axle over the number of driven ones."""
    vehicle = of.application.vehicle
    through = [line for line, _ in _inter_axle_lines(of) if line.installed.drives == "rear"]
    if vehicle and through and vehicle.driven_rear:
        value = (len(through) + 1) / vehicle.driven_rear
        yield ComparedValue(("vehicle.drive",), value, (through[0].at,))


def compare_axle_ratios_alike(of: RelationContext) -> ComparedValues:
    """Pinion speed for one wheel speed of a line over that of the first line."""
    geared = [line for line in of.lines if line.installed.axle]
    for line in geared[1:]:
        first, own = geared[0].installed, line.installed
        assert first.axle
        assert own.axle
        value = (own.axle.ratio / own.speed_ratio) / (first.axle.ratio / first.speed_ratio)
        yield ComparedValue((f"{line.axle}.ratio",), value, (f"{geared[0].axle}.ratio",))


def compare_transfer_power(of: RelationContext) -> ComparedValues:
    """Torque ratio times speed ratio of a line: gears keep power."""
    for line in of.lines:
        value = line.installed.torque_ratio * line.installed.speed_ratio
        keys = f"{line.at}.torque_ratio", f"{line.at}.speed_ratio", line.at
        yield ComparedValue(keys, float(value), (f"{line.at}.speed_ratio",))


# --- through-driven axles


def compare_through_shaft(of: RelationContext) -> ComparedValues:
    """Slope from the pinion of a through-driven axle to its output less the pinion's own, deg.

    The shaft through the axle is one straight line, or nearly so.
    """
    for line, ahead in _inter_axle_lines(of):
        axle, output = ahead.installed.axle, line.installed.output_joint
        if axle and output and axle.pinion_joint[0]:  # else its place is not known
            along, up = output[0] - axle.pinion_joint[0], axle.pinion_joint[1] - output[1]
            slope = np.degrees(np.arctan2(up, along))
            value = abs(slope - float(ahead.installed.layout.side[-1]) / deg)
            keys = f"{line.at}.output_joint.above", f"{line.at}.output_joint.below"
            against = f"{ahead.axle}.pinion", f"{ahead.at}.pinion_slope"
            yield ComparedValue(keys, float(value), against)


def compare_through_slope(of: RelationContext) -> ComparedValues:
    """Slope at joint 1 of an inter-axle line less that of the pinion ahead, deg."""
    for line, ahead in _inter_axle_lines(of):
        slope = line.installed.layout.side[0] - ahead.installed.layout.side[-1]
        keys = f"{line.at}.gearbox_slope.side", f"{line.at}.slopes.side"
        against = f"{ahead.at}.pinion_slope.side", f"{ahead.at}.slopes.side"
        yield ComparedValue(keys, abs(float(slope)) / deg, against)


def compare_inter_axle_drop(of: RelationContext) -> ComparedValues:
    """Drop of an inter-axle line less that between its joints as both axles place them, mm.

    On the road all wheels stand at one height.
    """
    for line, _ in _inter_axle_lines(of):
        axle, output = line.installed.axle, line.installed.output_joint
        if axle and output and of.application.tyre and axle.pinion_joint[0]:
            points = line.installed.layout.points
            drop = float(points[0, 2] - points[-1, 2])
            value = abs(drop - (output[1] - axle.pinion_joint[1])) / mm
            keys = f"{line.at}.points[{len(points)}]", f"{line.at}.slopes.side"
            against = f"{line.at}.output_joint", f"{line.axle}.pinion"
            yield ComparedValue(keys, value, against)


def compare_axle_spacing(of: RelationContext) -> ComparedValues:
    """Distance of two driven axles, as the line between them says, over the tyre's diameter."""
    for line, _ in _inter_axle_lines(of):
        axle, output, tyre = (
            line.installed.axle,
            line.installed.output_joint,
            of.application.tyre,
        )
        if axle and output and tyre and axle.pinion_joint[0]:
            x = line.installed.layout.points[:, 0]
            spacing = output[0] + float(x[-1] - x[0]) - axle.pinion_joint[0]
            keys = f"{line.at}.points[{len(x)}]", f"{line.at}.shafts[1].length"
            against = f"{line.at}.output_joint", f"{line.axle}.pinion", "tyre.static_radius"
            yield ComparedValue(keys, ratio(spacing, 2 * tyre.static_radius), against)


def _inter_axle_lines(of: RelationContext) -> Iterator[tuple[LineContext, LineContext]]:
    """Yield each line from axle to axle with the one ahead of it."""
    for line in of.lines:
        for ahead in of.lines:
            if line.installed.starts_at_axle_of(ahead.installed):
                yield line, ahead
