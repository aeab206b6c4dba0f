"""The vehicle of a file: engine, gearbox, axle, tyre, load states, suspension."""

from itertools import pairwise
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np

from cardan.model.powertrain import AxleRotors, GearboxRotors
from cardan.model.vehicle import (
    AuxiliaryAxle,
    Axle,
    DriveConfiguration,
    Engine,
    Gearbox,
    Linkage,
    LoadState,
    Spring,
    StaticSuspensionState,
    Suspension,
    Tyre,
    Vehicle,
)  # fmt: skip
from cardan.schema.field_types import IntegerField, ListField, MappingField, NumberField, TextField
from cardan.schema.fields import (
    AxleLoad,
    AxlePosition,
    AxleRatio,
    AxleTravelColumn,
    CentreOfGravityHeight,
    ConverterTorqueRatio,
    Coordinate,
    DampingLossFactor,
    Deflection,
    Deflections,
    Efficiency,
    EngineDisplacement,
    EngineSpeed,
    EngineSpeeds,
    GearRatio,
    GearRatios,
    LinkAngle,
    LinkLength,
    PitchAngles,
    PitchRate,
    PositiveInertia,
    PositiveInertias,
    RatedPower,
    RoadGrade,
    SecondSpringRateDeflection,
    ShareFromZeroToOne,
    SpringForceColumn,
    SpringRates,
    Stiffness,
    Torque,
    TorqueCurve,
    TorsionStiffness,
    TorsionStiffnesses,
    TransferRatio,
    TyreFriction,
    TyreRadius,
    TyreSlipStiffness,
    UnsprungMass,
    VehicleMass,
    Wheelbase,
    WindupStiffness,
)  # fmt: skip
from cardan.schema.tables import LazyTableField, Table, TableField, table_key_field


def _rise(table: Table, **columns: tuple[float, ...]) -> None:
    """Refuse a column of a table that does not rise."""
    for name, values in columns.items():
        for k, (a, b) in enumerate(pairwise(values), 2):
            if not np.all(b > a):
                table.reader_of(name, k).reject("must be above the value before it: these rise")


class EngineTable(Table):
    """The engine at full load: one point, or a curve joined by straight lines."""

    speed: EngineSpeed | EngineSpeeds = table_key_field("speed, or speeds that rise")
    torque: Torque | TorqueCurve = table_key_field("torque at each speed")
    brake_torque: Torque | None = table_key_field(
        "of engine brake or retarder, at the crankshaft; not known if left out", default=None
    )
    inertia: PositiveInertia | None = table_key_field(
        "with flywheel and clutch cover", default=None
    )
    displacement: EngineDisplacement | None = table_key_field(
        "by which an inertia is assumed", default=None
    )
    cylinders: Annotated[int, IntegerField(24)] | None = table_key_field(
        "of a four-stroke engine", default=None
    )
    idle: EngineSpeed | None = table_key_field("idling speed", default=None)
    governed: EngineSpeed | None = table_key_field("speed it is governed to", default=None)
    firing_torque: Torque | None = table_key_field(
        "of the firing order at full load, 0-to-peak", default=None
    )
    power: RatedPower | None = table_key_field(
        "rated power as published: speeds and torques are held against it", default=None
    )

    def build(self) -> Engine:
        """Return the engine in SI."""
        speed, torque = (v if isinstance(v, tuple) else (v,) for v in (self.speed, self.torque))
        if len(speed) != len(torque):
            message = f"must hold {len(speed)} values, one for each speed"
            self.reader_of("torque").reject(message, got=f"{len(torque)} values")
        _rise(self, speed=speed)
        return Engine(
            speed=speed,
            torque=torque,
            brake_torque=self.brake_torque,
            inertia=self.inertia,
            displacement=self.displacement,
            cylinders=self.cylinders,
            idle=self.idle,
            governed=self.governed,
            firing_torque=self.firing_torque,
            power=self.power,
        )


class GearboxTable(Table):
    """What stands between engine and driveline."""

    ratios: GearRatio | GearRatios = table_key_field(
        "lowest gear, which has the largest ratio, first"
    )
    efficiency: Efficiency = table_key_field("of the gearbox", default=1.0)
    converter_ratio: ConverterTorqueRatio = table_key_field(
        "torque ratio of a converter at stall", default=1.0
    )
    transfer_ratio: TransferRatio = table_key_field("low range of a transfer case", default=1.0)
    reverse_ratio: GearRatio | None = table_key_field(
        "engine speed over output speed in reverse; not asked if left out", default=None
    )
    retarder_torque: Torque | None = table_key_field(
        "of a retarder at the gearbox output; none known if left out", default=None
    )
    input_inertia: PositiveInertia | None = table_key_field(
        "what turns with its input", default=None
    )
    output_inertia: PositiveInertia | PositiveInertias | None = table_key_field(
        "what turns with its output; a list for the gears", default=None
    )
    stiffness: TorsionStiffness | TorsionStiffnesses | None = table_key_field(
        "from input to output, at the output; a list for the gears", default=None
    )

    def build(self) -> Gearbox:
        """Return the gearbox."""
        ratios = self.ratios if isinstance(self.ratios, tuple) else (self.ratios,)
        if not all(np.all(a >= b) for a, b in pairwise(ratios)):
            self.reader_of("ratios").reject("must fall from the lowest gear to the highest")
        each: dict[str, tuple[float, ...]] = {}
        for name in ("output_inertia", "stiffness"):
            value = getattr(self, name)
            given = value if isinstance(value, tuple) else () if value is None else (value,)
            if len(given) not in {0, 1, len(ratios)}:
                message = f"must be one value, or {len(ratios)}: one for each gear"
                self.reader_of(name).reject(message, got=f"{len(given)} values")
            each[name] = given
        return Gearbox(
            ratios=ratios,
            efficiency=self.efficiency,
            converter_ratio=self.converter_ratio,
            transfer_ratio=self.transfer_ratio,
            reverse_ratio=self.reverse_ratio,
            retarder_torque=self.retarder_torque,
            rotors=GearboxRotors(input_inertia=self.input_inertia, **each),
        )


class JointPositionTable(Table):
    """A joint centre seen from the wheel centre of its axle, across the wheels."""

    at_most_one_of = (("ahead", "behind"), ("above", "below"))

    ahead: Coordinate | None = table_key_field("towards the gearbox", default=None)
    behind: Coordinate | None = table_key_field("away from the gearbox", default=None)
    above: Coordinate | None = table_key_field("above the wheel centre", default=None)
    below: Coordinate | None = table_key_field("below the wheel centre", default=None)

    def build(self) -> tuple[float, float]:
        """Return (x, z): x along the flow of torque, z up."""
        behind, ahead, above, below = (
            0.0 if v is None else v for v in (self.behind, self.ahead, self.above, self.below)
        )
        return behind - ahead, above - below


JointPositionFromTable: TypeAlias = Annotated[tuple[float, float], JointPositionTable]


class PinionTable(JointPositionTable):
    """The pinion: where the last joint is, what turns there and how stiff its shaft is."""

    inertia: PositiveInertia | None = table_key_field("of the pinion", default=None)
    flange_inertia: PositiveInertia | None = table_key_field(
        "of the last joint's flange", default=None
    )
    stiffness: TorsionStiffness | None = table_key_field(
        "of its shaft, flange to teeth", default=None
    )

    def build(self) -> Any:
        """Return where the last joint is, and this table."""
        return super().build(), self


class AxleTable(Table):
    """The driven axle of a line."""

    ratio: AxleRatio = table_key_field("pinion speed over wheel speed")
    efficiency: Efficiency = table_key_field("of the axle", default=1.0)
    pinion: Annotated[Any, PinionTable] | None = table_key_field(
        "last joint from the wheel centre, and what turns there", default=None
    )
    ring_inertia: PositiveInertia | None = table_key_field(
        "of ring gear and differential", default=None
    )
    housing_inertia: PositiveInertia | None = table_key_field(
        "of the housing about the axle", default=None
    )
    differential: Literal["open", "locked"] = table_key_field("between its wheels", default="open")
    half_shafts: (
        Annotated[Any, LazyTableField("cardan.topics.torsion.schema", "HalfShaftsTable")] | None
    ) = table_key_field("between differential and wheels", default=None)
    hub_ratio: AxleRatio = table_key_field(
        "half shaft speed over wheel speed, where hubs reduce", default=1.0
    )

    def build(self) -> Axle:
        """Return the axle in SI."""
        place, pinion = self.pinion or ((0.0, 0.0), None)
        return Axle(
            ratio=self.ratio,
            efficiency=self.efficiency,
            pinion_joint=place,
            rotors=AxleRotors(
                pinion_inertia=pinion and pinion.inertia,
                flange_inertia=pinion and pinion.flange_inertia,
                pinion_stiffness=pinion and pinion.stiffness,
                ring_inertia=self.ring_inertia,
                housing_inertia=self.housing_inertia,
                half_shafts=self.half_shafts,
                hub_ratio=self.hub_ratio,
                locked=self.differential == "locked",
            ),
        )


AxleFromTable: TypeAlias = Annotated[Axle, AxleTable]


class TyreTable(Table):
    """Tyre and ground."""

    static_radius: TyreRadius = table_key_field("loaded, standing")
    friction: TyreFriction = table_key_field("of tyre on ground", default=0.8)
    dynamic_radius: TyreRadius | None = table_key_field("rolling", default=None)
    longitudinal_stiffness: Stiffness | None = table_key_field(
        "of one tyre, at its circumference", default=None
    )
    slip_stiffness: TyreSlipStiffness | None = table_key_field(
        "of one tyre, force over slip", default=None
    )

    def build(self) -> Tyre:
        """Return the tyre in SI."""
        return Tyre(
            static_radius=self.static_radius,
            friction=self.friction,
            dynamic_radius=self.dynamic_radius,
            longitudinal_stiffness=self.longitudinal_stiffness,
            slip_stiffness=self.slip_stiffness,
        )


class LoadStateTable(Table):
    """How the vehicle is loaded: mass with centre of gravity, or what its axles carry."""

    mass: VehicleMass | None = table_key_field("of the whole vehicle", default=None)
    cg_behind_front: AxlePosition | None = table_key_field(
        "centre of gravity behind the front axle (or the middle of two)", default=None
    )
    cg_height: CentreOfGravityHeight | None = table_key_field(
        "centre of gravity above the ground", default=None
    )
    front_axle: AxleLoad | None = table_key_field("on all front axles", default=None)
    rear_axle: AxleLoad | None = table_key_field("on the rear axle or bogie", default=None)
    auxiliary_lifted: bool = table_key_field(
        "whether auxiliary axles are off the ground", default=False
    )

    def load_state(self, name: str) -> LoadState:
        """Return the load state in SI."""
        return self.attempt(
            lambda: LoadState(
                name=name,
                mass=self.mass,
                cg_behind_front=self.cg_behind_front,
                cg_height=self.cg_height,
                front_load=self.front_axle,
                rear_load=self.rear_axle,
                auxiliary_lifted=self.auxiliary_lifted,
            )
        )

    def build(self) -> "LoadStateTable":
        """Return this table, tried: its name stands outside."""
        known = [self.has(n) for n in ("mass", "front_axle", "rear_axle")]
        by_mass, by_loads = known == [True, False, False], sum(known) == 2
        if self.has("cg_behind_front") != by_mass or not (by_mass or by_loads):
            self.reader_of().reject(
                "give mass_kg with cg_behind_front_mm, or two of mass_kg, front_axle_kg and "
                "rear_axle_kg without it"
            )
        self.load_state("")
        return self


class AuxiliaryAxleTable(Table):
    """An undriven axle on air, which carries the same load whatever the others do."""

    behind_front: AxlePosition = table_key_field("behind the front axle (or the middle of two)")
    load: AxleLoad = table_key_field("what it carries")

    def build(self) -> AuxiliaryAxle:
        """Return the axle in SI."""
        return AuxiliaryAxle(behind_front=self.behind_front, load=self.load)


class VehicleTable(Table):
    """Drive configuration, wheelbase, load states."""

    at_most_one_of = (("grade_percent", "grade"),)

    drive: DriveConfiguration = table_key_field("points on the ground x driven points")
    wheelbase: Wheelbase = table_key_field(
        "front axle (or the middle of two) to rear axle or bogie"
    )
    driven_share: ShareFromZeroToOne | None = table_key_field(
        "share of a bogie's load on its driven axles", default=None
    )
    grade: RoadGrade | None = table_key_field("slope of the road, up positive", default=None)
    grade_percent: Annotated[float, NumberField(above=-100, below=100, usual=(0.5, 45))] | None = (
        table_key_field("slope of the road, rise over run, up positive", default=None)
    )
    loads: Annotated[
        dict[str, LoadStateTable], MappingField(TextField(), TableField(LoadStateTable), most=50)
    ] = table_key_field("by name: curb, empty, gvw, ...", default={})
    front_axles: Annotated[int, IntegerField(3)] | None = table_key_field(
        "two on an 8x, else one", default=None
    )
    front_driven: bool | None = table_key_field(
        "only where every axle is, if not said", default=None
    )
    auxiliary: Annotated[
        tuple[AuxiliaryAxle, ...], ListField(TableField(AuxiliaryAxleTable), most=3)
    ] = table_key_field("axles on air", default=())

    def build(self) -> Vehicle:
        """Return the vehicle in SI."""
        percent = 0.0 if self.grade_percent is None else self.grade_percent
        return Vehicle(
            drive=self.drive,
            wheelbase=self.wheelbase,
            driven_share=self.driven_share,
            grade=np.arctan(percent / 100) if self.grade is None else self.grade,
            loads=tuple(load.load_state(name) for name, load in self.loads.items()),
            front_axles=self.front_axles,
            front_driven=self.front_driven,
            auxiliary=self.auxiliary,
        )


class SpringTable(Table):
    """A spring: loads over deflections, or one or two rates with where the second starts."""

    one_of = (("load", "rates"),)

    load: SpringForceColumn | None = table_key_field("table of loads, rising", default=None)
    deflection: Deflections | None = table_key_field("deflections under them", default=None)
    stated_rates: SpringRates = table_key_field(
        "the drawing's own rates, compared with the table's", default=()
    )
    rates: SpringRates | None = table_key_field("rate, or both rates", default=None)
    contact: SecondSpringRateDeflection | None = table_key_field(
        "deflection at which the second rate starts", default=None
    )

    def build(self) -> Spring:
        """Return the spring in SI."""
        if self.load is not None:
            return self._from_table(self.load)
        rates = list(self.rates or ())
        if self.has("deflection"):
            self.reader_of("deflection").reject("belongs to load_N, not to rates")
        if not 1 <= len(rates) <= 2:
            self.reader_of("rates").reject("must hold one rate or two", got=f"{len(rates)} rates")
        if (self.contact is None) != (len(rates) == 1):
            message = (
                "contact_mm says where the second rate starts: two rates need it, one does not"
            )
            self.reader_of("contact" if self.has("contact") else "rates").reject(message)
        first = 0.1 if self.contact is None else self.contact
        second = first * rates[0] + first * rates[-1]
        return Spring(
            load=(0.0, first * rates[0], second), deflection=(0.0, first, 2 * first), ends=False
        )

    def _from_table(self, load: tuple[float, ...]) -> Spring:
        if self.has("contact"):
            self.reader_of("contact").reject("belongs to rates, not to a table")
        if self.deflection is None:
            self.reader_of().reject("deflection_mm is missing: load_N needs it")
        if len(self.deflection) != len(load):
            message = f"must hold {len(load)} values, one for each load"
            self.reader_of("deflection").reject(message, got=f"{len(self.deflection)} values")
        _rise(self, load=load, deflection=self.deflection)
        return Spring(load=load, deflection=self.deflection, stated_rates=self.stated_rates)


class LinkageTable(Table):
    """How the axle moves fore and aft and pitches as it rises: a link, or a table."""

    at_most_one_of = (("radius", "front_half_length", "travel"),)

    radius: LinkLength | None = table_key_field(
        "of the link from its pivot ahead of the axle", default=None
    )
    front_half_length: LinkLength | None = table_key_field(
        "of a leaf spring: its link is three quarters as long", default=None
    )
    angle: LinkAngle = table_key_field(
        "of the link in the reference state, pivot above axle positive", default=0.0
    )
    pitch_rate: PitchRate = table_key_field(
        "pitch as the axle rises, pinion nose up positive", default=0.0
    )
    travel: AxleTravelColumn = table_key_field("table: rise of the axle", default=())
    dx: AxleTravelColumn = table_key_field("table: how far rearward it goes", default=())
    pitch: PitchAngles = table_key_field("table: its pitch, pinion nose up positive", default=())

    def build(self) -> Linkage:
        """Return the linkage in SI."""
        if self.travel:
            for name in ("angle", "pitch_rate"):
                if self.has(name):
                    self.reader_of(name).reject("belongs to a link; the table says it all")
        for name in ("dx", "pitch"):
            column: tuple[float, ...] = getattr(self, name)
            if self.has(name) and len(column) != len(self.travel):
                message = f"must hold {len(self.travel)} values, one for each travel"
                self.reader_of(name).reject(message, got=f"{len(column)} values")
        _rise(self, travel=self.travel)
        radius = self.radius
        if self.front_half_length is not None:
            radius = 0.75 * self.front_half_length
        return Linkage(
            radius=radius,
            angle=self.angle,
            pitch_rate=self.pitch_rate,
            travel=self.travel,
            dx=self.dx,
            pitch=self.pitch,
        )


class SuspensionTable(Table):
    """What moves the axle: springs, linkage, wind-up."""

    spring: Annotated[Spring, SpringTable] = table_key_field("one spring")
    springs_per_axle: Annotated[int, IntegerField(16)] = table_key_field(
        "springs on one axle", default=2
    )
    unsprung_mass: UnsprungMass = table_key_field("of one axle with its wheels", default=0.0)
    linkage: Annotated[Linkage, LinkageTable] = table_key_field(
        "how the axle is guided", default=Linkage()
    )
    windup_stiffness: WindupStiffness | None = table_key_field("of the axle in pitch", default=None)
    windup_loss_factor: DampingLossFactor | None = table_key_field(
        "of the springs in pitch", default=None
    )
    brake_torque: Torque = table_key_field(
        "of the brakes on the axle; 0: what the tyres hold", default=0.0
    )
    reference: StaticSuspensionState = table_key_field(
        "state in which the geometry is given", default="gvw"
    )
    full_rebound_deflection: Deflection | None = table_key_field(
        "where a check strap stops it", default=None
    )
    jounce_deflection: Deflection | None = table_key_field(
        "where a bump stop stops it", default=None
    )
    squat: bool = table_key_field(
        "whether what its tyres pull moves it on its springs", default=True
    )
    axle_to_frame: Coordinate | None = table_key_field(
        "from the axle's centre up to the frame, in the reference state", default=None
    )

    def build(self) -> Suspension:
        """Return the suspension in SI."""
        return Suspension(
            spring=self.spring,
            springs_per_axle=self.springs_per_axle,
            unsprung_mass=self.unsprung_mass,
            linkage=self.linkage,
            windup_stiffness=self.windup_stiffness,
            windup_loss_factor=self.windup_loss_factor,
            brake_torque=self.brake_torque,
            reference=self.reference,
            full_rebound_deflection=self.full_rebound_deflection,
            jounce_deflection=self.jounce_deflection,
            squats=self.squat,
            axle_to_frame=self.axle_to_frame,
        )


SuspensionFromTable: TypeAlias = Annotated[Suspension, SuspensionTable]
