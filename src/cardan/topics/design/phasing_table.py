"""Yoke phases side by side: what each way of putting a line together excites."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from cardan.checks.line_response import LineResponse
from cardan.core.arrays import FloatArray
from cardan.core.units import Radian, deg
from cardan.render.blocks import Table
from cardan.render.i18n import ENGLISH, Translator
from cardan.topics.design.yoke_phasing import yoke_phasings


def yoke_phasing_table(r: LineResponse, say: Translator = ENGLISH) -> Iterator[Table]:
    """Yield a line with its yokes in every way; nothing where there is but one way."""
    found = yoke_phasings(r)
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
            say("drive [deg]"), say("drive [rad/s²]"),
            say("overrun [deg]"), say("overrun [rad/s²]"),
        ),
        rows=tuple(
            (
                " – ".join(yoke_phase_name(p, say) for p in one.phases)
                + (" " + say("(as installed)") if one.is_installed else ""),
                _most(one.exact_excitation.torsional.angle / deg, say),
                _most(one.ae7_excitation.torsional.angle / deg, say),
                _most(one.exact_excitation.torsional.acceleration, say),
                _most(one.exact_excitation.drive.angle / deg, say),
                _most(one.exact_excitation.drive.acceleration, say),
                _most(one.exact_excitation.coast.angle / deg, say),
                _most(one.exact_excitation.coast.acceleration, say),
            )
            for one in found
        ),
        words=1,
    )  # fmt: skip


def yoke_phase_name(phase: Radian, say: Translator) -> str:
    """Return how a shaft's yokes stand to each other."""
    turned = round(phase / deg, 6) % 180
    if turned == 0:
        return say("in phase")
    return say("90° out of phase") if turned == 90 else f"{say.compact_number(phase / deg)} deg"


def json_document(r: LineResponse) -> list[dict[str, Any]]:
    """Return a line's phasings for programs, state by state."""
    return [
        {
            "phases_deg": [p / deg for p in one.phases],
            "installed": one.is_installed,
            "states": [
                {
                    "name": name,
                    **{
                        kind: {
                            "equivalent_angle_deg": float(joint.angle[s] / deg),
                            "acceleration_rad_s2": float(joint.acceleration[s]),
                        }
                        for kind, joint in (
                            ("torsional", one.exact_excitation.torsional),
                            ("drive", one.exact_excitation.drive),
                            ("coast", one.exact_excitation.coast),
                        )
                    },
                    "ae7": {"torsional": {"equivalent_angle_deg": float(
                        one.ae7_excitation.torsional.angle[s] / deg)}},
                }
                for s, name in enumerate(one.state_names)
            ],
        }
        for one in yoke_phasings(r)
    ]  # fmt: skip


def _most(values: FloatArray, say: Translator) -> str:
    return "-" if np.isnan(values).all() else say.number(float(np.nanmax(values)))
