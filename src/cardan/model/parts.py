"""The parts of a line: tube, joint, centre bearing, spline, shaft. All SI."""

from math import isnan, pi
from typing import Literal, TypeAlias

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, stack_on_last_axis
from cardan.core.errors import DesignError, require_positive, values_of_first_violating_case
from cardan.core.lazy_dataclass import dataclass
from cardan.core.provenance import SOURCE_ASSUMED, Source
from cardan.core.units import Kilogram, Metre, Newton, NewtonMetre, Radian, mm
from cardan.model.bracket_compliance import DEFAULT_BRACKET_LOSS_FACTOR
from cardan.model.laminate import CompositeTube
from cardan.model.material import STEEL, Material


@dataclass(frozen=True, slots=True, kw_only=True)
class Tube:
    """A round tube's section."""

    outer: Metre
    wall: Metre
    material: Material = STEEL
    name: str = ""
    source: Source = SOURCE_ASSUMED

    def __post_init__(self) -> None:
        half = self.outer / 2
        if wrong := values_of_first_violating_case(
            (self.wall > 0) & (self.wall <= half), half, self.wall
        ):
            most, wall = wrong
            msg = (
                f"wall of a tube must be above 0 and at most half its outside diameter, "
                f"{most / mm:g} mm, got {wall / mm:g} mm"
            )
            raise DesignError(msg)

    @property
    def inner(self) -> Metre:
        """Inside diameter."""
        return self.outer - 2 * self.wall

    @property
    def area(self) -> float:
        """Area of the section, m²."""
        return pi / 4 * (self.outer**2 - self.inner**2)

    @property
    def second_moment(self) -> float:
        """Second moment of area in bending, m⁴; the polar one is twice that."""
        return pi / 64 * (self.outer**4 - self.inner**4)

    @property
    def bending_stiffness(self) -> float:
        """E I, N m²."""
        return self.material.youngs_modulus * self.second_moment

    @property
    def torsional_stiffness(self) -> float:
        """G J, N m²: torque over twist per length."""
        return self.material.shear_modulus * 2 * self.second_moment

    @property
    def shear_coefficient(self) -> float:
        """Share κ of the section that carries shear, by Cowper.

        κ = 6 (1+ν) (1+m²)² / ((7+6ν) (1+m²)² + (20+12ν) m²),  m = inside / outside diameter.

        About 0.53 for a thin tube, 0.89 for a bar. Source: Cowper, The shear coefficient in
        Timoshenko's beam theory, J. Applied Mechanics 33 (1966), table 1.
        """
        nu, m2 = self.material.poisson, (self.inner / self.outer) ** 2
        return 6 * (1 + nu) * (1 + m2) ** 2 / ((7 + 6 * nu) * (1 + m2) ** 2 + (20 + 12 * nu) * m2)

    @property
    def shear_stiffness(self) -> float:
        """κ G A, N."""
        return self.shear_coefficient * self.material.shear_modulus * self.area

    @property
    def mass_per_length(self) -> float:
        """Mass per length, kg/m."""
        return self.material.density * self.area

    @property
    def polar_inertia_per_length(self) -> float:
        """Mass moment of inertia about the axis per length, kg m."""
        return self.material.density * 2 * self.second_moment


_KEYS = {
    "peak_torque": "peak", "reversing_torque": "reversing", "pulsating_torque": "pulsating",
    "bearing_torque": "bearing_Td", "bearing_factor": "bearing_Lc", "speed_angle_max": "n_beta_max",
}  # fmt: skip
"""What catalogues call the values of a joint, where that is another name."""

JointKind: TypeAlias = Literal["cross", "double cardan", "rzeppa", "tripod", "flexible disc"]


@dataclass(frozen=True, slots=True, kw_only=True)
class JointSize:
    """A joint as catalogues rate it; None is "not published".

    `peak_torque` is the functional (elastic) limit, `reversing_torque` the fatigue limit
    under alternating and `pulsating_torque` under pulsating torque. `bearing_torque` Td is
    carried for 5000 h at 100 rpm and 3 deg; `bearing_factor` is GWB's Lc (kN m based).

    Of a Rzeppa or tripod joint the `bearing_torque` is carried for `rated_life` at
    `rated_speed` and `rated_angle`; `pitch_radius` is from the axis to its balls or rollers,
    `plunge` how far it slides either way. Of a double cardan `centre_distance` is between its
    crosses, `ball_from_rear` from its centring ball to the rear one; Td is that of a cross.
    A flexible disc (Hardy disc, coupling of links or membranes) turns by `torsional_stiffness`
    under torque and resists its angle by `bending_stiffness`, N m/rad; its `plunge` is how far it
    may give along the line, either way.
    """

    name: str
    kind: JointKind = "cross"
    rated_life: float | None = None
    """s; `rated_speed` in rad/s."""
    rated_speed: float | None = None
    rated_angle: Radian | None = None
    pitch_radius: Metre | None = None
    centre_distance: Metre | None = None
    ball_from_rear: Metre | None = None
    plunge: Metre | None = None
    torsional_stiffness: float | None = None
    bending_stiffness: float | None = None
    series: str = ""
    peak_torque: NewtonMetre | None = None
    reversing_torque: NewtonMetre | None = None
    pulsating_torque: NewtonMetre | None = None
    bearing_torque: NewtonMetre | None = None
    bearing_factor: float | None = None
    angle_max: Radian | None = None
    speed_angle_max: float | None = None
    """Largest speed times joint angle, rad²/s (catalogues: rpm deg, deg/min)."""
    speed_max: float | None = None
    cross_width: Metre | None = None
    cup_diameter: Metre | None = None
    cup_length: Metre | None = None
    needle_circle: Metre | None = None
    swing_diameter: Metre | None = None
    """Of the ball that its yokes turn in, whatever the angle."""
    mass: Kilogram | None = None
    source: Source = SOURCE_ASSUMED
    note: str = ""

    @property
    def cup_spacing(self) -> Metre | None:
        """Between the middles of opposite cups, which carry the torque; None if not known."""
        if self.cross_width is None or self.cup_length is None:
            return None
        return self.cross_width - self.cup_length

    def source_of(self, rating: str) -> Source:
        """Return the source of one of its values, by the name that it has here."""
        return self.source.source_of_value(_KEYS.get(rating, rating))


@dataclass(frozen=True, slots=True, kw_only=True)
class CentreBearing:
    """The bearing a shaft hangs on near its rear joint.

    `stiffness` is that of rubber and bracket across the shaft, N/m, vertical and lateral;
    None is rigid. `axial_stiffness` is that of the rubber along the shaft, N/m; None slides
    freely. Where `bracket_stiffness` is given, N/m along x, y and z of the vehicle, those two
    are the rubber's alone, in series with it, and `bracket_loss` is the share of its energy that
    the bracket loses in a radian. `loss_factor` is the rubber's, the tangent of its loss angle;
    None is not known. `travel` is how far the rubber goes across the shaft from where the line
    hangs at rest, before it meets its stop; None is not known. `from_rear_joint` is how far ahead
    of the rear joint centre it sits.
    """

    from_rear_joint: Metre = 0.0
    stiffness: tuple[float, float] | None = None
    axial_stiffness: float | None = None
    loss_factor: float | None = None
    bracket_stiffness: tuple[float, float, float] | None = None
    bracket_loss: float = DEFAULT_BRACKET_LOSS_FACTOR
    travel: Metre | None = None
    stop_stiffness_ratio: float | None = None
    """Stiffness beyond that travel over `stiffness`; None is not known."""
    stiffness_range: tuple[float, float] | None = None
    """Its stiffness hot and cold, over `stiffness`; None is not known."""

    @property
    def transverse_stiffness(self) -> tuple[float, float] | None:
        """Vertical and lateral stiffness of rubber and bracket together, N/m; None is rigid."""
        if self.bracket_stiffness is None:
            return self.stiffness
        _, y, z = self.bracket_stiffness
        if self.stiffness is None:
            return z, y
        vertical, lateral = self.stiffness
        return 1 / (1 / vertical + 1 / z), 1 / (1 / lateral + 1 / y)

    def __post_init__(self) -> None:
        if wrong := values_of_first_violating_case(self.from_rear_joint >= 0, self.from_rear_joint):
            msg = (
                "a centre bearing sits ahead of its rear joint: from_rear_joint must be 0 or "
                f"more, got {wrong[0] / mm:g} mm"
            )
            raise DesignError(msg)
        if self.stiffness is not None:
            require_positive(
                "a centre bearing",
                **dict(zip(("vertical", "lateral"), self.stiffness, strict=True)),
            )
        require_positive(
            "a centre bearing", axial_stiffness=self.axial_stiffness, travel=self.travel
        )
        if self.bracket_stiffness is not None:
            require_positive("a bracket", **dict(zip("xyz", self.bracket_stiffness, strict=True)))
        for part, loss in (("centre bearing", self.loss_factor), ("bracket", self.bracket_loss)):
            if loss is not None and (
                wrong := values_of_first_violating_case((loss > 0) & (loss < 1), loss)
            ):
                msg = f"loss_factor of a {part} must be above 0 and below 1, got {wrong[0]:g}"
                raise DesignError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class Flange:
    """What holds the first or last joint of a line: the transmission's tail, or the axle.

    Attributes
    ----------
    stiffness : (vertical, lateral) N/m
        At the joint centre, across the member; None is rigid.
    loss_factor : 1
        The tangent of its loss angle.
    mass : kg
        What moves with the joint centre.
    """

    stiffness: tuple[float, float] | None = None
    loss_factor: float = 0.0
    mass: Kilogram = 0.0

    def __post_init__(self) -> None:
        if self.stiffness is not None:
            require_positive(
                "a flange", **dict(zip(("vertical", "lateral"), self.stiffness, strict=True))
            )
        loss = self.loss_factor
        if wrong := values_of_first_violating_case((loss >= 0) & (loss < 1), loss):
            msg = f"loss_factor of a flange must be 0 or more and below 1, got {wrong[0]:g}"
            raise DesignError(msg)


RIGID_FLANGE = Flange()


@dataclass(frozen=True, slots=True, kw_only=True)
class Spline:
    """The sliding spline: how far it can move from its installed place, and how it rubs.

    `plunge` is the travel left in shortening, `draw` in lengthening. `mass` is what it adds
    to the tube, `from_front_joint` how far behind the front joint centre that sits.
    """

    plunge: Metre | None = None
    draw: Metre | None = None
    mean_radius: Metre | None = None
    friction: float = 0.11
    mass: Kilogram = 0.0
    from_front_joint: Metre = 0.0

    def __post_init__(self) -> None:
        require_positive(
            "a spline", plunge=self.plunge, draw=self.draw, mean_radius=self.mean_radius
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Shaft:
    """One shaft between two joint centres.

    `phase` is the yoke phase: 0 where the pin axes of its two yokes are parallel
    (aligned), pi/2 crossed. `yoke_mass` is the mass at its front and rear end beyond the
    tube. `polar_inertia` replaces what tube and yokes add up to. A length of nan is not known:
    how a line turns does not depend on it, and what does is nan.
    """

    length: Metre
    tube: Tube | CompositeTube | None = None
    phase: Radian = 0.0
    centre_bearing: CentreBearing | None = None
    spline: Spline | None = None
    yoke_mass: tuple[Kilogram, Kilogram] = (0.0, 0.0)
    yoke_inertia: float = 0.0
    """Of both yokes together, about the axis."""
    yoke_inertias: tuple[float, float] | None = None
    """Of the front and of the rear yoke, if they differ."""
    tube_length: Metre | None = None
    """Of the tube between its yokes, which are stiff in torsion; None: the whole length."""
    polar_inertia_given: float | None = None
    balance_grade: float | None = None
    """ISO 21940-11 grade G, mm/s as the standard prints it."""

    def __post_init__(self) -> None:
        unknown = isinstance(self.length, float) and isnan(self.length)
        length = None if unknown else self.length
        require_positive("a shaft", length=length, polar_inertia=self.polar_inertia_given)
        bearing = self.centre_bearing
        if bearing is None or unknown:
            return
        place = bearing.from_rear_joint
        if wrong := values_of_first_violating_case(place < self.length, self.length, place):
            msg = (
                f"a centre bearing must sit on its shaft: from_rear_joint must be below its "
                f"length {wrong[0] / mm:g} mm, got {wrong[1] / mm:g} mm"
            )
            raise DesignError(msg)

    @property
    def torsional_flexibility(self) -> float:
        """L / G J of the tube between its yokes, rad/(N m); 0 if not given."""
        if self.tube is None or (isinstance(self.length, float) and isnan(self.length)):
            return 0.0
        return (self.tube_length or self.length) / self.tube.torsional_stiffness

    @property
    def mass(self) -> Kilogram:
        """Mass of tube, yokes and spline."""
        tube = self.tube.mass_per_length * self.length if self.tube else 0.0
        return tube + sum(self.yoke_mass) + (self.spline.mass if self.spline else 0.0)

    @property
    def polar_inertia(self) -> float | None:
        """Mass moment of inertia about the axis, kg m²; None without tube or given value."""
        if self.polar_inertia_given is not None:
            return self.polar_inertia_given
        if self.tube is None:
            return None
        return self.tube.polar_inertia_per_length * self.length + self.yoke_inertia


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """A driveline: n joints, n-1 shafts, gearbox first, pinion last.

    All shafts but the last hang on a centre bearing. `axial_freedom` says where the line
    takes up length: in the spline of its last shaft, or in a floating gearbox flange.
    """

    name: str = "main"
    shafts: tuple[Shaft, ...]
    joints: tuple[JointSize | None, ...] = ()
    axial_freedom: Literal["last_shaft", "gearbox_flange"] = "last_shaft"
    gearbox_bearing_spacing: Metre | None = None
    gearbox_bearing_overhang: Metre | None = None
    pinion_bearing_spacing: Metre | None = None
    pinion_bearing_overhang: Metre | None = None
    gearbox_bearing_rating: tuple[Newton, Newton] | None = None
    """Radial force that the line may put on the output's bearings: the one farther from joint 1,
    and the nearer one."""
    pinion_bearing_rating: tuple[Newton, Newton] | None = None
    """The same of the pinion's bearings: the one farther from the last joint, and the nearer."""
    gearbox_flange: Flange = RIGID_FLANGE
    pinion_flange: Flange = RIGID_FLANGE

    def __post_init__(self) -> None:
        if not self.shafts:
            msg = f"line {self.name} has no shaft"
            raise DesignError(msg)
        for k, shaft in enumerate(self.shafts, 1):
            if (shaft.centre_bearing is None) != (k == len(self.shafts)):
                what = "carries no" if k == len(self.shafts) else "needs a"
                msg = f"shaft {k} of line {self.name} {what} centre bearing"
                raise DesignError(msg)
        if self.joints and len(self.joints) != self.joint_count:
            msg = (
                f"line {self.name} has {self.joint_count} joints, one more than shafts; "
                f"{len(self.joints)} are given"
            )
            raise DesignError(msg)

    @property
    def joint_count(self) -> int:
        """Number of joints: one more than shafts."""
        return len(self.shafts) + 1

    @property
    def centre_bearings(self) -> tuple[CentreBearing, ...]:
        """What its shafts hang on, gearbox first."""
        return tuple(s.centre_bearing for s in self.shafts if s.centre_bearing)

    @property
    def flanges(self) -> tuple[Flange, Flange]:
        """What holds the first joint and the last."""
        return self.gearbox_flange, self.pinion_flange

    @property
    def rigid_body_mode_count(self) -> int:
        """Number of ways in which its shafts swing without bending."""
        soft = sum(f.stiffness is not None for f in self.flanges)
        return 2 * (len(self.shafts) - 1 + soft)

    @property
    def has_lengths(self) -> bool:
        """Whether the lengths of its shafts are known, and not slopes alone."""
        return not any(isinstance(s.length, float) and isnan(s.length) for s in self.shafts)

    @property
    def joint_kinds(self) -> tuple[JointKind, ...]:
        """Kind of every joint; a cross where no size says another."""
        sizes = self.joints or (None,) * self.joint_count
        return tuple(size.kind if size else "cross" for size in sizes)

    @property
    def is_cross(self) -> tuple[float, ...]:
        """1 for every joint that is a cross, 0 for one of constant velocity."""
        return tuple(1.0 if kind == "cross" else 0.0 for kind in self.joint_kinds)

    @property
    def phases(self) -> tuple[Radian, ...]:
        """Yoke phase of every shaft."""
        return tuple(s.phase for s in self.shafts)

    @property
    def torsional_flexibilities(self) -> tuple[float, ...]:
        """What twists between the yokes of each shaft, rad/(N m): its tube, a disc at its front.

        A disc ahead of the first shaft turns the whole line, and one behind the last the pinion.
        """
        front = (None, *self.joints[1:-1]) if self.joints else (None,) * len(self.shafts)
        return tuple(
            shaft.torsional_flexibility
            + (1 / k if disc and (k := disc.torsional_stiffness) is not None else 0.0)
            for shaft, disc in zip(self.shafts, front, strict=True)
        )

    @property
    def joint_bending_stiffnesses(self) -> tuple[float, ...] | None:
        """What each joint resists its angle with, N m/rad; None if none does."""
        each = [size.bending_stiffness if size else None for size in self.joints]
        if all(k is None for k in each):
            return None
        return tuple(0.0 if k is None else k for k in each)

    def phases_under_torque(self, phases: ArrayLike, torque: ArrayLike) -> FloatArray:
        """Return yoke phases (..., n-1) rad as torque (...) N m leaves them, of those welded.

        It turns the rear yoke of each shaft back against the front one, by T L / G J, and what
        is behind a flexible disc by T over its stiffness.
        """
        torque = np.asarray(torque, dtype=float)[..., None]
        return np.asarray(phases) - torque * stack_on_last_axis(self.torsional_flexibilities)

    @property
    def lengths(self) -> tuple[Metre, ...]:
        """Length of every shaft, joint centre to joint centre."""
        return tuple(s.length for s in self.shafts)
