"""Force on a bearing over a recording's drive, of the line as it was identified or of another."""

from collections.abc import Callable

import numpy as np

from cardan.core.arrays import ComplexArray, FloatArray
from cardan.model.application import Application
from cardan.physics.loads.centre_bearing import bearing_forces
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.shaft_angle import ShaftAngle
from cardan.topics.recording.bearing_model import (
    FINE_MODE_SIMULATION_RATE_HZ,
    FITTED_ORDERS,
    BearingModel,
    measurement_windows,
    pole_shares,
    stepped_pole,
)
from cardan.topics.recording.identification_result import IdentificationResult


def joint_force_history(
    of: IdentificationResult,
    rotation: ShaftRotation,
    torque: tuple[FloatArray, float],
    *,
    seconds: float,
    rate: float = FINE_MODE_SIMULATION_RATE_HZ,
    application: Application | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Force on the bearing over the recording's drive, (n,) s and (n, 3) N, vehicle axes.

    As `bearing_force_over_time` computes it. For the bracket's damage.
    """
    time = np.arange(int(seconds * rate)) / rate
    return time, bearing_force_over_time(
        of, rotation, torque, seconds=seconds, application=application
    )(time)


def bearing_force_over_time(
    of: IdentificationResult,
    rotation: ShaftRotation,
    torque: tuple[FloatArray, float],
    *,
    seconds: float,
    application: Application | None = None,
) -> Callable[[FloatArray], FloatArray]:
    """Return the force on the bearing (n, 3) N, vehicle axes, as a function of times (n,) s.

    Of the application as it was identified, or of another one driven so: mean and orders at each
    window's torque and speed, with what modes remember where they are passed, straight between
    windows; what is unbalanced is not in it.
    """
    scene = measurement_windows(ShaftAngle(rotation, lag=0.0), torque, seconds)
    r = BearingModel(application or of.identified, state=of.state, bearing=of.bearing, scene=scene)
    phases = np.array([float(s.phase) for s in r.response.line.shafts])
    run = bearing_forces(
        r.layout, r.response.line, phases, torque=r.torque, speed=r.speed, held=r.held,
        inertias=r.response.inputs.shaft_inertias,
    )  # fmt: skip
    mean, waves = run.mean[:, 0, r.bearing].T, run.waves[:, 0, r.bearing]
    poles = r.poles(r.held, None, 0.0)
    clock = np.arange(scene.fine_angle.size) / FINE_MODE_SIMULATION_RATE_HZ

    ways: list[tuple[float, ComplexArray, list[tuple[ComplexArray, ComplexArray]]]] = []
    for k, order in enumerate((2.0, 4.0, 6.0)):
        steady = waves[:, k].T
        slow = steady
        remembered: list[tuple[ComplexArray, ComplexArray]] = []
        if order in FITTED_ORDERS and poles.size:
            # What is left besides the poles is slow; they themselves go through the drive.
            share = pole_shares(scene, steady, poles, order)
            basis = 1 / (2j * np.pi * order * scene.at.speed - poles[:, None])
            slow = steady - share @ (basis * scene.load(order))
            back = np.exp(-2j * np.pi * order * scene.fine_angle)
            remembered = [
                (share[:, r_], stepped_pole(scene, complex(pole), order) * back)
                for r_, pole in enumerate(poles)
            ]
        ways.append((order, slow, remembered))

    def force(time: FloatArray) -> FloatArray:
        def between(at: FloatArray, z: ComplexArray) -> ComplexArray:
            return np.interp(time, at, z.real) + 1j * np.interp(time, at, z.imag)

        near = np.searchsorted(scene.at.time[:-1], time)
        turns = rotation.at(time) + of.tacho_mark_angle[near] / (2 * np.pi)
        total = np.stack([np.interp(time, scene.at.time, m) for m in mean], axis=-1)
        for order, slow, remembered in ways:
            turning = np.exp(2j * np.pi * order * turns)
            for share, z in remembered:
                total += ((between(clock, z) * turning)[:, None] * share).real
            total += np.stack([(between(scene.at.time, z) * turning).real for z in slow], axis=-1)
        return total

    return force
