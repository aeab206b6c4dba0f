"""Cardan: universal-joint drivelines, from hardpoints to verdict.

    import cardan

    app = cardan.read("truck.yaml")
    cardan.check(app)

The names in `__all__` are defined in `cardan.api` and imported on first use, so that
`import cardan` costs nothing.
"""

from cardan.core.version import __version__

__all__ = [
    "Application",
    "Approval",
    "CompositeTube",
    "Corrections",
    "Joint",
    "JointWithBacklash",
    "MotorDrivenShaft",
    "QuantityValues",
    "RainflowMatrices",
    "RecordingResult",
    "Sizing",
    "Steering",
    "Sweep",
    "__version__",
    "addresses",
    "bracket",
    "buckling_torques",
    "change",
    "check",
    "fix",
    "hysteretic_threshold",
    "joint",
    "life",
    "lightest_layup",
    "loads",
    "read",
    "read_rainflow",
    "resonance_passage",
    "run_up_outcomes",
    "simulate_rattle",
    "simulate_shimmy",
    "size",
    "stability",
    "study",
    "viscous_threshold",
    "write_drive_file",
]  # fmt: skip

TYPE_CHECKING = False  # as type checkers know it; `typing` itself takes longer than all the rest
if TYPE_CHECKING:
    from cardan.api import (
        Application,
        Approval,
        CompositeTube,
        Corrections,
        Joint,
        JointWithBacklash,
        MotorDrivenShaft,
        QuantityValues,
        RainflowMatrices,
        RecordingResult,
        Sizing,
        Steering,
        Sweep,
        addresses,
        bracket,
        buckling_torques,
        change,
        check,
        fix,
        hysteretic_threshold,
        joint,
        life,
        lightest_layup,
        loads,
        read,
        read_rainflow,
        resonance_passage,
        run_up_outcomes,
        simulate_rattle,
        simulate_shimmy,
        size,
        stability,
        study,
        viscous_threshold,
        write_drive_file,
    )


def __getattr__(name: str) -> object:
    """Import a public name from `cardan.api` on first use."""
    if name not in __all__:
        msg = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(msg)
    from importlib import import_module

    return getattr(import_module(f"{__name__}.api"), name)


_RESULT_TYPES = {
    "Application", "Approval", "Corrections", "Joint", "QuantityValues", "RainflowMatrices",
    "RecordingResult", "Sizing", "Sweep",
}  # fmt: skip


def __dir__() -> list[str]:
    """List the functions, and the parts that some of them take; results come from functions."""
    return sorted(set(__all__) - _RESULT_TYPES)
