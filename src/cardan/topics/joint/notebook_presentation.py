"""A joint, or two, as `cardan.joint` returns it: short text, table, plot, frame."""

from html import escape
from typing import Any

import numpy as np

from cardan.core.errors import DesignError
from cardan.core.optional_import import import_optional
from cardan.core.units import deg, rpm
from cardan.render.text_layout import without_colours
from cardan.schema.quantity_parser import argument_value
from cardan.topics.joint import result_presentation as presentation
from cardan.topics.joint.argument_units import ARGUMENT_UNITS
from cardan.topics.joint.joint_result import JointResult, joint_result
from cardan.topics.joint.presentation import RADIANS_PER_ARCMINUTE
from cardan.topics.joint.single_joint import SingleJoint

PLOT_POINT_COUNT = 721
"""Points of a turn that a plot is drawn through."""


class PrintedText(str):
    """Text that shows its lines at a prompt and in a notebook, as `print` does."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


class Joint(JointResult):
    """Motion of a universal joint, or of two with a shaft between them.

    `output` is the joint that turns the output shaft: the only one, or the equivalent of two. It
    holds `irregularity`, `max_acceleration` in rad/s², `max_lead_angle` and `angle` in rad.
    `pair` holds `best_phase` and `output_at_best_phase`, `limits` the largest angle of each.
    """

    def __repr__(self) -> str:
        return "\n".join(presentation.summary_lines(self))

    def _repr_html_(self) -> str:
        return f"<pre>{escape(repr(self))}</pre>"

    def table(self) -> PrintedText:
        """Return what `cardan joint` prints."""
        return PrintedText(without_colours(presentation.text_lines(self)))

    def plot(self) -> Any:
        """Draw angle, speed and acceleration over a turn with matplotlib; return the three axes.

        Raises
        ------
        MissingDependencyError
            Without matplotlib.
        """
        import_optional("matplotlib", purpose="a plot")
        from matplotlib import pyplot as plt

        columns = self._columns(np.linspace(0, 360, PLOT_POINT_COUNT))
        _, axes = plt.subplots(3, 1, sharex=True, figsize=(7, 7), layout="constrained")
        named = (("ahead_min", "angle ahead, min"), ("speed_rpm", "speed, rpm"),
                 ("acceleration_rad_s2", "acceleration, rad/s²"))  # fmt: skip
        for axis, (column, label) in zip(axes, named, strict=True):
            if self.pair is not None:
                axis.plot(columns["theta_deg"], columns[f"shaft_{column}"], "--",
                          label="shaft between")  # fmt: skip
            axis.plot(columns["theta_deg"], columns[column], label="output")
            axis.set_ylabel(label)
            axis.grid(alpha=0.4)
        if self.pair is not None:
            axes[0].legend()
        title = "\n".join(repr(self).splitlines()[: 1 if self.pair is None else 2])
        axes[0].set_title(title, fontsize="medium")
        axes[-1].set(xlabel="θ, deg", xlim=(0, 360), xticks=range(0, 361, 45))
        return axes

    def to_frame(self) -> Any:
        """Return a pandas frame with a row for each degree of a turn.

        Angle ahead of the driving shaft, speed and acceleration of the output; with two joints
        also of the shaft between, in columns that begin with `shaft_`.

        Raises
        ------
        MissingDependencyError
            Without pandas.
        """
        frame = import_optional("pandas", extra="frame", purpose="a frame").DataFrame
        return frame(self._columns(np.arange(360.0)))

    def to_dict(self) -> dict[str, Any]:
        """Return what `cardan joint --json` writes."""
        return presentation.json_document(self)

    def _columns(self, theta: Any) -> dict[str, Any]:
        columns = {"theta_deg": theta, **_motion_columns(self.output, theta)}
        if self.pair is not None:
            between = _motion_columns(self.joint, theta)
            columns |= {f"shaft_{name}": values for name, values in between.items()}
        return columns


def joint(
    angle: str | float | None = None,
    speed: str | float | None = None,
    *,
    angle2: str | float | None = None,
    phase: str | float | None = None,
    plane_angle: str | float | None = None,
    torque: str | float | None = None,
    across: str | float | None = None,
    acceleration_limit: str | float | None = None,
    irregularity_limit: str | float | None = None,
) -> Joint:
    """Compute the motion of a universal joint, or of two with a shaft between them.

        cardan.joint("4.5deg", "3600rpm")
        cardan.joint("4.5deg", "3600rpm", angle2="4.5deg", phase="90deg")
        cardan.joint(speed="3600rpm", acceleration_limit="1000rad/s2")

    Parameters
    ----------
    angle, speed
        Of the joint, and of the driving shaft, with units. Numbers alone are deg and rpm. Without
        an angle the joint has the largest angle that keeps the limits.
    angle2
        Of a second joint. The result then holds the output of both and the best phase.
    phase, plane_angle
        Yoke phase of the shaft between, and angle from the plane of joint 1 to that of joint 2:
        0 for the W arrangement, 180deg for Z. Both are 0 by default, right-handed about the shaft.
    torque, across
        In the driving shaft (N·m), and between opposite needle rows (mm): couples and forces.
    acceleration_limit, irregularity_limit
        Limits of the output, rad/s² and % of the mean speed.

    Raises
    ------
    DesignError
        If an argument is missing, has an unknown unit or is out of its range.
    """
    given = {name: value for name, value in locals().items() if value is not None}
    if speed is None:
        msg = 'a joint needs a speed: add speed="3600rpm"'
        raise DesignError(msg)
    values = {
        name: argument_value(name, value, ARGUMENT_UNITS[name]) for name, value in given.items()
    }
    found = joint_result(**values)
    return Joint(joint=found.joint, pair=found.pair, limits=found.limits)


def _motion_columns(of: SingleJoint, theta: Any) -> dict[str, Any]:
    c = of.curves_over_turn(theta * deg)
    return {
        "ahead_min": c.lead_angle / RADIANS_PER_ARCMINUTE,
        "speed_rpm": c.driven_speed / rpm,
        "acceleration_rad_s2": c.driven_acceleration,
    }
