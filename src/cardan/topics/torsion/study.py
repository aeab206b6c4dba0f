"""Evaluate whether an application vibrates: the whole vehicle in torsion, and each hung shaft.

Every gear is evaluated in every state, at the speeds it has there: from idling with the clutch
closed, from standstill while it slips, up to what governs it or the state's own speed.
"""

from collections.abc import Iterator
from dataclasses import fields

import numpy as np

from cardan.approval.study import VIBRATION_STUDY_NAME, StudyResult, limits_of_study
from cardan.core.arrays import FloatArray
from cardan.core.errors import DesignError
from cardan.core.status import ProgressCallback, ignore_status
from cardan.model.application import Application, GearboxAndAxleRotors
from cardan.physics.dynamics.torsional_network import (
    torsional_modes,
)
from cardan.physics.vehicle.state_demand import (
    line_state_demand,
)
from cardan.topics.torsion.operating_grid import OperatingGrid
from cardan.topics.torsion.powertrain_model import (
    VehicleTorsionModel,
    vehicle_torsion_model,
)
from cardan.topics.torsion.vibration_checks import check_limit
from cardan.topics.torsion.vibration_result import (
    LineVibration,
    ModeSensitivity,
    PowertrainVibration,
    VibrationResult,
)

DEFAULT_RUBBER_LOSS_FACTOR = 0.1
"""Loss factor of a centre bearing's rubber if not given: assumed."""


def run_vibration_study(
    application: Application, *, surroundings: GearboxAndAxleRotors | None, tell: ProgressCallback
) -> StudyResult[VibrationResult]:
    """Evaluate how every line vibrates, and compare it with its limits.

    Raises
    ------
    DesignError
        If nothing says how fast the line turns or what torque it carries.
    """
    answer = analyse_vibration(application, surroundings=surroundings, tell=tell)
    limits = limits_of_study(VIBRATION_STUDY_NAME, application)
    found = [check_limit(answer, limit) for limit in limits]
    return StudyResult(
        study=VIBRATION_STUDY_NAME,
        answer=answer,
        checks=tuple(c for checks, _ in found for c in checks),
        unevaluated=tuple(u for _, silent_of in found for u in silent_of),
        failure_reasons=answer.doubts,
    )


def analyse_vibration(
    application: Application,
    *,
    surroundings: GearboxAndAxleRotors | None = None,
    tell: ProgressCallback = ignore_status,
) -> VibrationResult:
    """Return how an application vibrates, in every gear and state."""
    said = {
        f.name: value
        for source in (application.torsion, surroundings)
        for f in fields(GearboxAndAxleRotors)
        if (value := getattr(source, f.name, None)) is not None
    }
    around = GearboxAndAxleRotors(**said)
    parts = vehicle_torsion_model(application, surroundings=around)
    asked = tuple(line_state_demand(line) for line in parts.lines)
    if np.isnan(asked[0].speed).all() or np.isnan(asked[0].torque).all():
        msg = f"line {asked[0].installed.line.name} needs a speed and a torque for its vibration"
        raise DesignError(msg)
    tell(VIBRATION_STUDY_NAME, 0, 4)
    running = OperatingGrid(parts=parts, demands=asked, adjacent_rotors=around)
    closed = running.driven(parts.closed, running.closed_ranges)
    tell(VIBRATION_STUDY_NAME, 1, 4)
    slipping = running.driven(parts.slipping, running.slipping_ranges)
    tell(VIBRATION_STUDY_NAME, 2, 4)
    zones = tuple(running.zones(closed))
    speeds, amplitudes = running.curve(closed)
    tell(VIBRATION_STUDY_NAME, 3, 4)
    loss = around.rubber_loss or DEFAULT_RUBBER_LOSS_FACTOR
    launches = tuple(running.launches())
    return VibrationResult(
        application=application,
        surroundings=around,
        given=frozenset(said),
        drivetrain=parts,
        gears=running.gears,
        states=parts.states,
        closed=closed,
        slipping=slipping,
        zones=zones,
        speeds=speeds,
        amplitudes=amplitudes,
        firing_torque=running.largest_firing_torque(closed),
        shifts=tuple(_mode_sensitivities(application, around, parts, closed)),
        lines=tuple(
            LineVibration(line=d.installed.line, lateral_growth=running.lateral(d, loss))
            for d in asked
        ),
        launches=launches,
        failed_launches=tuple(running.failed_launches),
        doubts=tuple(running.doubts),
    )


def _mode_sensitivities(
    application: Application,
    around: GearboxAndAxleRotors,
    parts: VehicleTorsionModel,
    closed: PowertrainVibration,
) -> Iterator[ModeSensitivity]:
    """Yield how far the modes move with what is assumed, those that move any by 2 % alone."""
    state = -1
    base = closed.frequencies[:, state]
    count = min(4, base.shape[-1])
    seen: set[str] = set()
    for assumption in parts.assumed:
        q = assumption.typical
        if q.quantity in seen or q.low == q.high:
            continue
        seen.add(q.quantity)
        ends: list[FloatArray] = []
        for value in (q.low, q.high):
            other = vehicle_torsion_model(
                application, surroundings=around, replaced={q.quantity: value}
            )
            line = other.closed.line.select_case(slice(None), [state])
            ends.append(torsional_modes(line).frequency[:, 0, 1 : 1 + count])
        moved = np.stack(ends)
        gear = int(np.abs(moved / base[:, :count] - 1).max((0, 2)).argmax())
        if np.abs(moved[:, gear] / base[gear, :count] - 1).max() > 0.02:
            yield ModeSensitivity(
                assumption=assumption, gear=parts.gears[gear], frequencies=moved[:, gear]
            )
