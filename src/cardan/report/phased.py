"""Yoke phases side by side: what each way of putting a line together excites."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.units import Radian, deg
from cardan.quantity.response import Response
from cardan.report.blocks import Table
from cardan.report.language import EN, Language
from cardan.study.phasings import phasings


def table(r: Response, say: Language = EN) -> Iterator[Table]:
    """Yield a line with its yokes in every way; nothing where there is but one way."""
    found = phasings(r)
    if not found:
        return
    caption = say("Yoke phases side by side, largest over all states")
    if len(r.demand.states) == 1:
        caption = say("Yoke phases side by side")
    yield Table(
        caption=caption,
        head=(
            say("yokes, shaft by shaft"),
            say("torsional [deg]"), say("by AE-7 [deg]"), say("torsional [rad/s²]"),
            say("drive [deg]"), say("drive [rad/s²]"), say("coast [deg]"), say("coast [rad/s²]"),
        ),
        rows=tuple(
            (
                " – ".join(phased(p, say) for p in one.phases)
                + (" " + say("(as installed)") if one.installed else ""),
                _most(one.exact.torsional.angle / deg, say),
                _most(one.ae7.torsional.angle / deg, say),
                _most(one.exact.torsional.acceleration, say),
                _most(one.exact.drive.angle / deg, say),
                _most(one.exact.drive.acceleration, say),
                _most(one.exact.coast.angle / deg, say),
                _most(one.exact.coast.acceleration, say),
            )
            for one in found
        ),
        words=1,
    )  # fmt: skip


def phased(phase: Radian, say: Language) -> str:
    """Return how a shaft's yokes stand to each other."""
    turned = round(phase / deg, 6) % 180
    if turned == 0:
        return say("aligned")
    return say("crossed") if turned == 90 else f"{say.short(phase / deg)} deg"


def document(r: Response) -> list[dict[str, Any]]:
    """Return a line's phasings for programs, state by state."""
    return [
        {
            "phases_deg": [p / deg for p in one.phases],
            "installed": one.installed,
            "states": [
                {
                    "name": name,
                    **{
                        kind: {
                            "equivalent_angle_deg": float(joint.angle[s] / deg),
                            "acceleration_rad_s2": float(joint.acceleration[s]),
                        }
                        for kind, joint in (
                            ("torsional", one.exact.torsional),
                            ("drive", one.exact.drive),
                            ("coast", one.exact.coast),
                        )
                    },
                    "ae7": {"torsional": {"equivalent_angle_deg": float(
                        one.ae7.torsional.angle[s] / deg)}},
                }
                for s, name in enumerate(one.states)
            ],
        }
        for one in phasings(r)
    ]  # fmt: skip


def _most(values: FloatArray, say: Language) -> str:
    return "-" if np.isnan(values).all() else say.number(float(np.nanmax(values)))
