"""What turns and springs between engine and road in a file, each part at its own speed."""

from typing import Annotated, Any

import numpy as np

from cardan.application.typical_values import find_csv_row_by_name, shipped_csv_rows
from cardan.model.material import STEEL
from cardan.model.powertrain import (
    Clutch,
    DualMassFlywheel,
    InterAxleDifferential,
    Launch,
    TorqueConverter,
    WheelRotors,
    torsion_bar_stiffness,
)
from cardan.schema.field_types import IntegerField, ListField, NumberField, TextField
from cardan.schema.fields import (
    AngularPlay,
    ConverterTorqueRatio,
    DamperCurveAngles,
    DamperCurveTorques,
    Diameter,
    Duration,
    EngineSpeed,
    Inertia,
    PositiveInertia,
    RoadGrade,
    ShareFromZeroToOne,
    Torque,
    TorsionDamping,
    TorsionStiffness,
)  # fmt: skip
from cardan.schema.tables import Table, table_key_field


class ClutchTable(Table):
    """A friction clutch with the damper in its disc."""

    at_most_one_of = (("stiffness", "torque"), ("stiffness", "angle"))

    stiffness: TorsionStiffness | None = table_key_field("of the damper", default=None)
    hysteresis: Torque | None = table_key_field("of the damper", default=None)
    damping: TorsionDamping | None = table_key_field("of the damper", default=None)
    disc_inertia: PositiveInertia | None = table_key_field("on the friction's side", default=None)
    capacity: Torque | None = table_key_field(
        "largest torque that the friction holds", default=None
    )
    angle: DamperCurveAngles = table_key_field("the damper's curve: angles, rising", default=())
    torque: DamperCurveTorques = table_key_field("the damper's curve: torques, rising", default=())

    def build(self) -> Clutch:
        """Return the clutch in SI."""
        if len(self.angle) != len(self.torque):
            self.reader_of("torque" if self.torque else "angle").reject(
                "angle_deg and torque_Nm go together, as many of one as of the other"
            )
        return Clutch(
            stiffness=self.stiffness,
            hysteresis=self.hysteresis,
            damping=self.damping,
            disc_inertia=self.disc_inertia,
            capacity=self.capacity,
            angle=self.angle,
            torque=self.torque,
        )


class DualMassFlywheelTable(Table):
    """A flywheel in two halves; what the engine's own half weighs is in its inertia."""

    stiffness: TorsionStiffness = table_key_field("between its halves")
    secondary_inertia: PositiveInertia = table_key_field("of the half at the clutch")
    damping: TorsionDamping | None = table_key_field("between its halves", default=None)

    def build(self) -> DualMassFlywheel:
        """Return it in SI."""
        return DualMassFlywheel(
            stiffness=self.stiffness,
            secondary_inertia=self.secondary_inertia,
            damping=self.damping,
        )


class ConverterTable(Table):
    """A torque converter in place of the clutch."""

    stall_torque_ratio: ConverterTorqueRatio = table_key_field(
        "turbine over pump torque at stall", default=1.0
    )
    pump_inertia: PositiveInertia | None = table_key_field("on the engine's side", default=None)
    turbine_inertia: PositiveInertia | None = table_key_field("on the gearbox's side", default=None)
    lockup_stiffness: TorsionStiffness | None = table_key_field(
        "of the lock-up's damper", default=None
    )

    def build(self) -> TorqueConverter:
        """Return it in SI."""
        return TorqueConverter(
            stall_torque_ratio=self.stall_torque_ratio,
            pump_inertia=self.pump_inertia,
            turbine_inertia=self.turbine_inertia,
            lockup_stiffness=self.lockup_stiffness,
        )


_SIDES = ListField(
    NumberField("mm", "m", "in", least=5e-3, most=20, usual=(0.2, 3)), "left", "right"
)
_SPRINGS = ListField(
    NumberField(
        "Nm_deg", "Nm_rad", "kNm_deg", "kNm_rad", least=1e-3, most=1e12, usual=(100.0, 1e9)
    ),
    "left",
    "right",
)


class HalfShaftsTable(Table):
    """The shafts between differential and wheels: round bars of steel, or their stiffness."""

    one_of = (("diameter", "stiffness"),)

    diameter: Diameter | None = table_key_field("where they are thinnest", default=None)
    lengths: Annotated[tuple[float, float], _SIDES] | None = table_key_field(
        "of the left and the right one at that diameter", default=None
    )
    stiffness: Annotated[tuple[float, float], _SPRINGS] | None = table_key_field(
        "of the left and the right one", default=None
    )

    def build(self) -> tuple[float, float]:
        """Return the stiffness of the left and of the right one, N m/rad."""
        if (self.diameter is None) != (self.lengths is None):
            self.reader_of().reject(
                "diameter_mm and lengths_mm go together; or give stiffness_kNm_rad"
            )
        if self.diameter is None or self.lengths is None:
            assert self.stiffness is not None  # one_of refuses neither
            return self.stiffness
        G = STEEL.shear_modulus
        d, (left, right) = self.diameter, self.lengths
        return (
            torsion_bar_stiffness(diameter=d, length=left, shear_modulus=G),
            torsion_bar_stiffness(diameter=d, length=right, shear_modulus=G),
        )


class InterAxleDifferentialTable(Table):
    """The differential between the two driven axles of a tandem."""

    torque_split: ShareFromZeroToOne = table_key_field(
        "share of the torque that goes on to the axle behind", default=0.5
    )
    through_inertia: PositiveInertia | None = table_key_field(
        "what turns with the line behind", default=None
    )
    cage_inertia: PositiveInertia | None = table_key_field(
        "what turns with the line ahead", default=None
    )
    locked: bool = table_key_field("whether it is locked", default=False)

    def build(self) -> InterAxleDifferential:
        """Return it in SI."""
        return self.attempt(
            lambda: InterAxleDifferential(
                torque_split=self.torque_split,
                through_inertia=self.through_inertia,
                cage_inertia=self.cage_inertia,
                locked=self.locked,
            )
        )


class TyreName(TextField):
    """The size of a tyre, as the catalogue has it, blanks and case aside."""

    def schema(self, defs: dict[str, Any], unit: str) -> dict[str, Any]:
        """Return a shipped size, which editors offer, or any spelling of one."""
        sizes = [row["name"] for row in shipped_csv_rows("tyres.csv")]
        return {"anyOf": [{"enum": sizes}, super().schema(defs, unit)]}


class WheelsTable(Table):
    """The wheels with their tyres, all alike."""

    at_most_one_of = (("tyre", "inertia"),)

    inertia: PositiveInertia | None = table_key_field("of one wheel with its tyre", default=None)
    tyre: Annotated[str, TyreName()] | None = table_key_field(
        "its size, of a catalogue", default=None
    )
    per_axle: Annotated[int, IntegerField(16)] | None = table_key_field(
        "wheels on a driven axle", default=None
    )
    hub_inertia: Inertia | None = table_key_field(
        "of hub and brake at one end of an axle; 0 if that of the wheels has it", default=None
    )

    def build(self) -> WheelRotors:
        """Return them in SI."""
        inertia = self.inertia
        if self.tyre is not None:
            known, advice = find_csv_row_by_name("tyres.csv", self.tyre)
            if known is None:
                self.reader_of("tyre").reject("no tyre of this size is in the catalogue", advice,
                                       got=self.tyre)  # fmt: skip
            inertia = float(known["wheel_inertia_kg_m2"])
        return WheelRotors(inertia=inertia, per_axle=self.per_axle, hub_inertia=self.hub_inertia)


class LaunchTable(Table):
    """A start from rest: the clutch's torque rises in a ramp, until it locks."""

    at_most_one_of = (("grade_percent", "grade"),)

    gear: Annotated[str, TextField()] = table_key_field("which", default="1")
    ramp: Duration = table_key_field("in which the clutch's torque rises", default=0.5)
    clutch_torque: Torque | None = table_key_field(
        "at the end of the ramp; the engine's largest if left out", default=None
    )
    capacity: Annotated[float, NumberField(least=0.05, most=10)] = table_key_field(
        "what the clutch holds over that: above 1 it is dropped", default=1.0
    )
    engine: EngineSpeed | None = table_key_field("speed before the clutch grips", default=None)
    grade_percent: Annotated[float, NumberField(above=-100, below=100, usual=(0.5, 100))] | None = (
        table_key_field("slope of the road, rise over run, up positive", default=None)
    )
    grade: RoadGrade | None = table_key_field("slope of the road, up positive", default=None)
    load: Annotated[str, TextField()] | None = table_key_field(
        "state of load, by its name", default=None
    )
    play: AngularPlay = table_key_field("backlash at the pinion; none if left out", default=0.0)

    def build(self) -> Launch:
        """Return the launch in SI."""
        percent = 0.0 if self.grade_percent is None else self.grade_percent
        grade = np.arctan(percent / 100) if self.grade is None else self.grade
        if np.any(grade < 0):
            self.reader_of("grade_percent" if self.grade is None else "grade").reject(
                "a start downhill is not evaluated: the road makes it, not the clutch",
                "give 0 or more",
            )
        return Launch(
            gear=str(self.gear),
            ramp=self.ramp,
            clutch_torque=self.clutch_torque,
            capacity=self.capacity,
            engine_speed=self.engine,
            grade=grade,
            load=self.load,
            play=self.play,
        )
