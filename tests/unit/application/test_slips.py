"""Slips of the pen on two shipped trucks: each is refused, or named by the relation it breaks.

A slip is a file, keys with wrong values, and what names it: a relation of the table, `measure` (a
value is unusual by itself), `refused`, or `silent` for those that nothing in the file contradicts.
"""

from typing import Any, NamedTuple

import pytest
import yaml
from repository import ROOT

from cardan.application.plausibility import PLAUSIBILITY_RULES, with_limit_profile
from cardan.application.reader import loads, read
from cardan.application.templates import template_text
from cardan.approval.approval import approve_driveline
from cardan.approval.notes import approval_notes
from cardan.core.errors import CardanError, InvalidFileError
from cardan.render.i18n import ENGLISH

MEASURE, REFUSED, SILENT = "measure", "refused", "silent"


class Raw(str):
    """A text that stands in the file as it is, without quotes."""


class Slip(NamedTuple):
    """Keys of a file with wrong values, and what names them; None deletes a key."""

    edits: dict[str, Any]
    named: str


GVW, EMPTY, SPRING, LINK = (
    "vehicle.loads.gvw", "vehicle.loads.empty", "suspension.spring", "suspension.linkage"
)  # fmt: skip
SHAFT1, SHAFT2, SHAFT3 = (f"driveline.shafts.{k}" for k in range(3))
FRONT = "drivelines.front"
BEARING = f"{SHAFT1}.centre_bearing"

VAN = [
    # --- vehicle
    Slip({"vehicle.wheelbase_mm": 5000}, "gearbox_place"),
    Slip({"vehicle.wheelbase_mm": 1500}, "line_reach"),
    Slip({f"{EMPTY}.front_axle_kg": 790, f"{EMPTY}.rear_axle_kg": 1260}, "payload_place"),
    Slip({f"{GVW}.front_axle_kg": 2050, f"{GVW}.rear_axle_kg": 1450}, "payload_place"),
    Slip({f"{GVW}.front_axle_kg": 3197, f"{GVW}.rear_axle_kg": 4519}, "jounce_distance"),
    Slip(
        {
            f"{EMPTY}.front_axle_kg": 1450,
            f"{EMPTY}.rear_axle_kg": 2050,
            f"{GVW}.front_axle_kg": 1260,
            f"{GVW}.rear_axle_kg": 790,
        },
        "empty_over_gvw",
    ),
    Slip(
        {
            f"{GVW}.front_axle_kg": 725,
            f"{GVW}.rear_axle_kg": 1025,
            f"{EMPTY}.front_axle_kg": 630,
            f"{EMPTY}.rear_axle_kg": 395,
        },
        "helper_contact",
    ),
    Slip({f"{GVW}.rear_axle_kg": 1025}, "helper_contact"),
    Slip({f"{GVW}.cg_height_mm": 31.5}, MEASURE),
    Slip({f"{GVW}.cg_height_mm": 300}, "centre_over_tyre"),
    Slip({f"{GVW}.cg_height_mm": -800}, REFUSED),
    Slip({"vehicle.drive": "6x4"}, "lines_over_axles"),
    # --- engine
    Slip({"engine.torque_Nm": [199, 199, 153]}, "torque_per_tonne"),
    Slip({"engine.torque_Nm": [27.5, 27.5, 21.2]}, "torque_per_tonne"),
    Slip({"engine.torque_Nm": [51, 85, 85]}, "curve_fall"),
    Slip({"engine.torque_Nm": [27, 270, 208]}, "curve_start"),
    Slip({"engine.torque_Nm": [720, 270, 208]}, "curve_end"),
    Slip({"engine.torque_Nm": [720, 720, 208]}, "curve_end"),
    Slip({"engine.speed_rpm": [188, 314, 408]}, "part_speeds"),
    Slip({"prime_mover": "electric"}, "motor_speeds"),
    # --- gears, axle, tyre
    Slip({"axle.ratio": 2.73}, "road_speed"),
    Slip({"axle.ratio": 4.99, "gearbox.ratios": [3.73, 2.60, 1.52, 1.00, 0.78]}, "reverse_ratio"),
    Slip({"axle.ratio": 0.268}, MEASURE),
    Slip({"gearbox.ratios": [18.6, 9.7, 5.67, 3.73, 2.91]}, "reverse_ratio"),
    Slip({"gearbox.ratios": [2.60, 1.52, 1.00, 0.78]}, "reverse_ratio"),
    Slip({"gearbox.ratios": [0.499, 2.60, 1.52, 1.00, 0.78]}, REFUSED),
    Slip({"gearbox.reverse_ratio": 0.46}, "reverse_ratio"),
    Slip({"axle.efficiency": 0.69}, MEASURE),
    Slip({"gearbox.efficiency": 0.69}, MEASURE),
    Slip({"tyre.static_radius_mm": 650}, "rolling_radius"),
    Slip({"tyre.static_radius_mm": 650, "tyre.dynamic_radius_mm": 676}, "tyre_size"),
    Slip({"tyre.static_radius_mm": 203, "tyre.dynamic_radius_mm": 203}, "tyre_size"),
    Slip({"tyre.static_radius_mm": 225}, "rolling_radius"),
    Slip({"tyre.friction": 0.09}, MEASURE),
    Slip({"tyre.friction": 0.3}, MEASURE),
    # --- suspension
    Slip({"suspension.springs_per_axle": 1}, "jounce_distance"),
    Slip({f"{SPRING}.rates_N_mm": [550, 850]}, "ride_frequency"),
    Slip({f"{SPRING}.rates_N_mm": [5.6, 8.7]}, "ride_frequency"),
    Slip({f"{SPRING}.rates_N_mm": [314, 485]}, "helper_contact"),
    Slip({f"{SPRING}.rates_N_mm": [85, 55]}, "spring_progression"),
    Slip({f"{SPRING}.contact_mm": 9}, "helper_contact"),
    Slip({f"{SPRING}.contact_mm": 900}, "helper_contact"),
    Slip({"suspension.unsprung_mass_kg": 16}, MEASURE),
    Slip({f"{LINK}.front_half_length_mm": 1200}, "leaf_length"),
    Slip({f"{LINK}.front_half_length_mm": 23.6}, MEASURE),
    Slip({f"{LINK}.angle_deg": -2}, "link_angle"),
    Slip({f"{LINK}.angle_deg": 0.035}, MEASURE),
    Slip({f"{LINK}.pitch_rate_deg_mm": -0.004}, "pitch_rate"),
    Slip({f"{LINK}.pitch_rate_deg_mm": 0.04}, "pitch_rate"),
    Slip({f"{LINK}.pitch_rate_deg_mm": 0.00007}, MEASURE),
    Slip({"suspension.windup_stiffness_kNm_deg": 22}, "axle_windup"),
    Slip({"suspension.windup_stiffness_kNm_deg": 1.1}, "axle_windup"),
    Slip({"suspension.windup_stiffness_kNm_deg": 126}, "axle_windup"),
    Slip({"suspension.reference": "empty"}, SILENT),
    Slip({"suspension.jounce_deflection_mm": 19}, "jounce_distance"),
    Slip({"suspension.jounce_deflection_mm": 1900}, MEASURE),
    # --- where the line runs
    Slip({"axle.pinion.ahead_mm": 27}, "pinion_ahead"),
    Slip({"axle.pinion.ahead_mm": -270}, "pinion_ahead"),
    Slip({"axle.pinion.above_mm": -15}, SILENT),
    Slip({"axle.pinion.above_mm": 150}, "single_pinion_height"),
    Slip({"driveline.points_mm.1": [1430, 0, 105]}, "lost_sign"),
    Slip({"driveline.points_mm.1": [1430, 0, -10.5]}, "line_drop"),
    Slip({"driveline.points_mm.1": [143, 0, -105]}, "slenderness"),
    Slip({"driveline.points_mm.1": [4130, 0, -105]}, "line_reach"),
    Slip({"driveline.points_mm.1": [1430, -105, 0]}, "line_offset"),
    Slip({"driveline.points_mm.1": [Raw("1.430"), 0, -105]}, REFUSED),
    Slip({"driveline.gearbox_slope.side_deg": 0.091}, MEASURE),
    Slip({"driveline.gearbox_slope.side_deg": 52}, MEASURE),
    Slip({"driveline.gearbox_slope.side_deg": -5.2}, "lost_sign"),
    Slip({"driveline.pinion_slope.side_deg": -5.0}, "lost_sign"),
    Slip(
        {"driveline.gearbox_slope.side_deg": -5.2, "driveline.pinion_slope.side_deg": -5.0},
        "line_drop",
    ),
    Slip({"driveline.gearbox_slope.side_deg": 5.0, "driveline.pinion_slope.side_deg": 5.2}, SILENT),
    Slip(
        {"driveline.gearbox_slope.side_deg": 9.1, "driveline.pinion_slope.side_deg": 8.75},
        "line_drop",
    ),
    Slip({"driveline.gearbox_slope.side_deg": Raw("5:12")}, REFUSED),
    # --- parts
    Slip({"driveline.joints": "2065"}, "joint_reserve"),
    Slip({"driveline.joints": "1410"}, "published_joint"),
    Slip({f"{SHAFT1}.tube": "3.500x0.650in"}, "tube_thinness"),
    Slip({f"{SHAFT1}.tube": "35.00x0.065in"}, REFUSED),
    Slip({f"{SHAFT1}.tube": "88.9x1.65in"}, REFUSED),
    Slip({f"{SHAFT1}.tube": "3.500x0.065"}, REFUSED),
    Slip({f"{SHAFT1}.tube": "5.300x0.065in"}, "tube_for_joint"),
    Slip({f"{SHAFT1}.phase_deg": 90}, "yokes_out_of_line"),
    Slip({f"{SHAFT1}.phase_deg": 1.5708}, MEASURE),
    Slip({f"{SHAFT1}.phase_deg": 3}, "yoke_phase"),
    Slip({f"{SHAFT1}.phase_deg": 180}, "yoke_phase"),
    Slip({f"{SHAFT1}.spline.plunge_mm": 450}, MEASURE),
    Slip({f"{SHAFT1}.spline.plunge_mm": 4.5, f"{SHAFT1}.spline.draw_mm": 4.5}, "spline_travel"),
    Slip({f"{SHAFT1}.spline.mean_radius_mm": 34}, "spline_size"),
    Slip({f"{SHAFT1}.spline.friction": 0.8}, MEASURE),
    Slip({f"{SHAFT1}.spline.mass_kg": 150}, "spline_mass"),
    Slip({f"{SHAFT1}.spline.from_front_joint_mm": 1200}, "spline_place"),
    Slip({f"{SHAFT1}.yoke_mass_kg": [3.97, 3.97]}, "yoke_size"),
    Slip({f"{SHAFT1}.yoke_mass_kg": [0.018, 0.018]}, "yoke_mass"),
    Slip({f"{SHAFT1}.balance_grade": "G1.6"}, MEASURE),
    Slip({f"{SHAFT1}.balance_grade": "G160"}, MEASURE),
    # --- speed, states, limits
    Slip({"speed_rpm": 1180}, "top_speed"),
    Slip({"speed_rpm": 440}, "top_speed"),
    Slip({"speed_rpm": 150}, MEASURE),
    Slip({"states.5.speed_rpm": 7800}, "part_speeds"),
    Slip({"states.4": None}, "expected_states"),
    Slip({"states": ["gvw"]}, "expected_states"),
    Slip({"shock_factor": 1}, "shock_factor"),
    Slip({"shock_factor": None}, "shock_factor"),
    Slip({"shock_factor": 0.13}, REFUSED),
    Slip({"limits": "heavy-truck"}, "heavy_truck_limits"),
    # --- numbers as some write them
    Slip({"axle.ratio": Raw("3,73")}, REFUSED),
    Slip({"vehicle.wheelbase_mm": Raw("3.000")}, REFUSED),
    Slip({"tyre.static_radius_mm": Raw("0325")}, REFUSED),
    Slip({"tyre.static_radius_mm": Raw("3_25")}, REFUSED),
    Slip({"limits": Raw("van\nlimits: van")}, REFUSED),
]
VECTO = [
    Slip({f"{BEARING}.from_rear_joint_mm": 770}, "bearing_place"),
    Slip({f"{BEARING}.vertical_stiffness_N_mm": 900,
          f"{BEARING}.lateral_stiffness_N_mm": 600}, "rubber_bounce"),
    Slip({f"{BEARING}.vertical_stiffness_N_mm": 9,
          f"{BEARING}.lateral_stiffness_N_mm": 6}, MEASURE),
    Slip({f"{BEARING}.vertical_stiffness_N_mm": 60,
          f"{BEARING}.lateral_stiffness_N_mm": 90}, "rubber_directions"),
    Slip({f"{BEARING}.loss_factor": 2}, REFUSED),
    Slip({f"{BEARING}.loss_factor": 20}, REFUSED),
    Slip({f"{BEARING}.loss_factor": 0.9}, MEASURE),
    Slip({"driveline.points_mm.1": [900, 0, 52]}, "lost_sign"),
    Slip({"driveline.points_mm.1": [900, 0, -5.2]}, "inner_bend"),
    Slip({"driveline.points_mm.1": [90, 0, -52]}, REFUSED),
    Slip({"driveline.points_mm.2": [2090, -26, -122]}, SILENT),
    Slip({"driveline.torque_share": 0.5}, "torque_shares"),
    Slip({f"{SHAFT2}.phase_deg": 90}, "yokes_out_of_line"),
    Slip({f"{SHAFT1}.tube": "120x30"}, "tube_thinness"),
    Slip({f"{SHAFT1}.tube": "120x0.3"}, "tube_thinness"),
    Slip({f"{SHAFT1}.tube": {"outer_mm": 120, "wall_mm": 3, "material":
          {"youngs_modulus_GPa": 69, "density_kg_m3": 7850, "yield_MPa": 355,
           "ultimate_MPa": 490}}}, "sound_speed"),
    Slip({"engine.brake_torque_Nm": 20}, "brake_torque"),
    Slip({"engine.brake_torque_Nm": 2000}, "brake_torque"),
    Slip({"axle.ratio": 1.48}, "road_speed"),
    Slip({"gearbox.ratios": [6.70, 3.80, 2.29, 1.48, 100, 0.73]}, REFUSED),
]  # fmt: skip
SLIPS = [*(("van", s) for s in VAN), *(("vecto-4x2", s) for s in VECTO)]

BUS, INDUSTRIAL, SMALL, TRUCK, TANDEM, PICK_UP, MEDIUM, REFUSE, CHAIN = (
    "starter:bus", "starter:industrial", "starter:small", "starter:truck", "tandem-6x4",
    "pick-up-4x4", "medium-truck-4x2", "refuse-collector-6x2", "three-joint-chain",
)  # fmt: skip
MAIN, SIX = "drivelines.main", "starter:6x4"
STRONG = {"youngs_modulus_GPa": 210, "density_kg_m3": 7850, "yield_MPa": 900, "ultimate_MPa": 1000}


def loosened(profile: str, **limits: dict[str, float]) -> dict[str, Any]:
    """A profile with some of its limits replaced."""
    rows = [{"quantity": key, **bounds, "source": "own"} for key, bounds in limits.items()]
    return {"profile": profile, "overrides": rows}


OTHERS = [
    (BUS, Slip({"axle.ratio": 3.1}, "gradeability")),
    (BUS, Slip({"states.5.speed_rpm": 4000}, "windup_speeds")),
    (BUS, Slip({"suspension.spring.load_N": [0, 2200, 4500, 8000]}, "ride_frequency")),
    (BUS, Slip({"gearbox.converter_ratio": 1.0}, "reverse_ratio")),
    (BUS, Slip({"driveline.points_mm.2": [2350, 0, -213]}, "inner_bend")),
    (BUS, Slip({"duty.2.speed_rpm": 16}, "duty_speeds")),
    (BUS, Slip({"vehicle.loads.gvw.rear_axle_kg": 1100}, "payload_place")),
    (TANDEM, Slip({"drivelines.inter-axle.torque_share": None}, "inter_axle_shares")),
    (TANDEM, Slip({"drivelines.inter-axle.load_share": None}, "inter_axle_load_shares")),
    (TANDEM, Slip({"drivelines.inter-axle.axle.ratio": 4.51}, "axle_ratios_alike")),
    (TANDEM, Slip({"drivelines.inter-axle.output_joint.behind_mm": 33}, "output_behind")),
    (TANDEM, Slip({"states.7.articulation_mm": 400}, "given_travel")),
    (TANDEM, Slip({"suspension.spring.contact_mm": 600}, "helper_contact")),
    (TANDEM, Slip({"gearbox.ratios": [9.5, 6.65, 4.8, 3.65, 2.6, 1.8, 1.3, 1.0]}, "reverse_ratio")),
    (INDUSTRIAL, Slip({"torque_Nm": 42000}, "joint_reserve")),
    (INDUSTRIAL, Slip({"speed_rpm": 90}, "duty_speeds")),
    (INDUSTRIAL, Slip({"coast_torque_Nm": 15000}, "coast_over_drive")),
    (INDUSTRIAL, Slip({"driveline.joints": 2015}, "yoke_size")),
    (INDUSTRIAL, Slip({f"{SHAFT1}.tube": {"outer_mm": 60, "wall_mm": 6}}, "tube_at_joint_peak")),
    (PICK_UP, Slip({f"{FRONT}.axle.ratio": 3.19}, "axle_ratios_alike")),
    (PICK_UP, Slip({f"{FRONT}.torque_share": 0.6}, "torque_shares")),
    (PICK_UP, Slip({f"{FRONT}.joints.0.centre_distance_mm": 760}, "double_cardan_distance")),
    (PICK_UP, Slip({f"{FRONT}.suspension.spring.rates_N_mm": [380]}, "ride_frequency")),
    (MEDIUM, Slip({"suspension.brake_torque_Nm": 1400}, "brake_hold")),
    (MEDIUM, Slip({f"{SHAFT2}.yoke_mass_kg": [6, 0.6]}, "yokes_alike")),
    # --- what damps: a percentage point missed
    ("vecto-4x2", Slip({f"{BEARING}.loss_factor": 0.3}, "rubber_loss")),
    (TANDEM, Slip({f"{MAIN}.shafts.0.centre_bearing.loss_factor": 0.35}, "rubber_loss")),
    # --- torque in lbf ft, typed as N m
    ("van", Slip({"engine.power_kW": 85, "engine.torque_Nm": [199, 199, 153]}, "rated_power")),
    (MEDIUM, Slip({"engine.power_kW": 185, "engine.torque_Nm": [561, 627, 627, 521]},
                  "rated_power")),
    (MEDIUM, Slip({"torque_Nm": 4190}, "withheld_torque")),
    ("van", Slip({"torque_Nm": 954}, "withheld_torque")),
    # --- a tube's diameter doubled or halved, its wall beyond any shipped tube
    (TANDEM, Slip({f"{MAIN}.shafts.0.tube": {"outer_mm": 240, "wall_mm": 6}}, "tube_for_joint")),
    (SMALL, Slip({f"{SHAFT2}.tube": {"outer_mm": 203.2, "wall_mm": 3.2}}, "tube_for_joint")),
    (CHAIN, Slip({f"{SHAFT1}.tube": {"outer_mm": 200, "wall_mm": 3}}, "tube_for_torque")),
    (SMALL, Slip({f"{SHAFT1}.tube": {"outer_mm": 101.6, "wall_mm": 9}}, "tube_thinness")),
    (MEDIUM, Slip({f"{SHAFT1}.tube": {"outer_mm": 100, "wall_mm": 1}}, "tube_thinness")),
    # --- a shaft ten times too short
    (SMALL, Slip({f"{SHAFT2}.length_mm": 270}, "slenderness")),
    (SMALL, Slip({f"{SHAFT2}.length_mm": 2700, f"{SHAFT1}.length_mm": 600}, "shafts_alike")),
    (MEDIUM, Slip({"driveline.points_mm.2": [1120, 28, -66]}, "slenderness")),
    (SMALL, Slip({"vehicle": {"drive": "4x2", "wheelbase_mm": 6500, "loads": {"gvw": {
        "front_axle_kg": 4000, "rear_axle_kg": 7000, "cg_height_mm": 1300}}}}, "gearbox_place")),
    # --- a strength that no steel of tubes has
    (SMALL, Slip({f"{SHAFT2}.tube": {"outer_mm": 101.6, "wall_mm": 3.2, "material": STRONG}},
                 "steel_yield")),
    (TANDEM, Slip({f"{MAIN}.shafts.1.tube": {"outer_mm": 120, "wall_mm": 6, "material": STRONG}},
                  "steel_yield")),
    # --- obstacles
    (REFUSE, Slip({"obstacles.0.start_mm": [2550, -500, 277],
                   "obstacles.0.end_mm": [2550, 500, 277]}, "obstacle_sign")),
    (REFUSE, Slip({"obstacles.0.start_mm": [2550, 500, -277]}, "obstacle_slenderness")),
    (REFUSE, Slip({"obstacles.0.radius_mm": 6.5}, "obstacle_slenderness")),
    (REFUSE, Slip({"obstacles.0.radius_mm": 650}, "obstacle_thickness")),
    (REFUSE, Slip({"obstacles.0.radius_mm": None}, "obstacle_thickness")),
    (TRUCK, Slip({"obstacles.0.start_mm": [2100, -500, -1350],
                  "obstacles.0.end_mm": [2100, 500, -1350]}, "obstacle_distance")),
    (REFUSE, Slip({"obstacles.0.start_mm": [2550, -500, -377]}, "cross_member_skew")),
    (TRUCK, Slip({"obstacles.0.end_mm": [2200, 500, -350]}, "cross_member_skew")),
    # --- digits swapped, a digit missing
    (REFUSE, Slip({"gearbox.reverse_ratio": 3.05}, "planetary_reverse_ratio")),
    ("van", Slip({"gearbox.reverse_ratio": 3.06}, "reverse_ratio")),
    # VECTO's own regional delivery reaches 0.226 of a truck's largest torque, and is none.
    (REFUSE, Slip({"duty.0.torque_Nm": 400, "duty.1.torque_Nm": 180}, "largest_duty_torque")),
    (BUS, Slip({"duty.0.torque_Nm": 260}, "largest_duty_torque")),
    # --- the whole stroke given each way
    (REFUSE, Slip({f"{SHAFT3}.spline.plunge_mm": 110, f"{SHAFT3}.spline.draw_mm": 110},
                  "spline_stroke")),
    ("van", Slip({f"{SHAFT1}.spline.plunge_mm": 90, f"{SHAFT1}.spline.draw_mm": 90},
                 "spline_stroke")),
    # --- a joint one size too large, or of another series
    (SMALL, Slip({"driveline.joints": 1810}, "joint_over_tube")),
    (MEDIUM, Slip({"driveline.joints": "2040"}, "published_joint")),
    ("vecto-4x2", Slip({"driveline.joints": "2045"}, "published_joint")),
    (TRUCK, Slip({"driveline.joints": [2045, 1760, 2045]}, "joint_series")),
    ("pick-up-4x4", Slip({"drivelines.front.joints.0.bearing_Td_Nm": 3100},
                         "joint_bearing_rating")),
    # --- every slope with the other sign
    (SMALL, Slip({"driveline.slopes.side_deg": [-3.0, -1.0, -4.5, -2.0]}, "gearbox_slope")),
    # --- a height of the centre of gravity that puts the payload below the floor
    ("van", Slip({f"{GVW}.cg_height_mm": 650}, "payload_height")),
    # --- a limit loosened, one turned into a warning
    ("van", Slip({"limits": loosened("van", critical_speed_ratio={"maximum": 1.2})},
                 "looser_limits")),
    (MEDIUM, Slip({"limits": loosened("medium-truck", clearance={"maximum": 1})},
                  "looser_limits")),
    (TANDEM, Slip({"limits": [{"quantity": "half_critical_band", "band": [0.49, 0.58],
                               "source": "own"}]}, "looser_limits")),
    (MEDIUM, Slip({"limits": loosened("medium-truck", joint_angle={"normal": 6})},
                  "limits_without_maximum")),
    # --- one of two strokes doubled, or the whole stroke each way on a thin spline
    (TRUCK, Slip({f"{SHAFT2}.spline.plunge_mm": 120}, "spline_balance")),
    ("van", Slip({f"{SHAFT1}.spline.draw_mm": 90}, "stroke_over_diameter")),
    # --- a rate or a rating of another order of magnitude
    (BUS, Slip({"suspension.linkage.pitch_rate_deg_mm": 0.001}, "pitch_for_link")),
    ("van", Slip({f"{LINK}.pitch_rate_deg_mm": 0.0004}, "pitch_for_link")),
    (BUS, Slip({"gearbox.retarder_torque_Nm": 140}, "retarder_per_tonne")),
    (PICK_UP, Slip({f"{MAIN}.joints.1.n_beta_max_deg_min": 600000}, "speed_angle_product")),
    (BUS, Slip({"suspension.spring.load_N": [0, 2200, 45000, 80000]}, "spring_steps")),
    (TRUCK, Slip({"suspension.windup_stiffness_kNm_deg": 61}, "leaf_windup")),
    (TANDEM, Slip({"drivelines.inter-axle.output_joint.above_mm": 1050}, "output_height")),
    # --- the duty cycle of another use; a digit missing in a share of the life
    (PICK_UP, Slip({"duty": "long-haul"}, "named_duty")),
    ("mtv-6x6", Slip({"duty": "distribution"}, "named_duty")),
    (INDUSTRIAL, Slip({"duty.1.torque_Nm": 230}, "duty_powers")),
    (REFUSE, Slip({"duty.1.speed_rpm": 70}, "duty_powers")),
    # --- obstacles: on the frame, where axles are; one end elsewhere
    (TRUCK, Slip({"obstacles.0.travel_share": 0}, "fixed_member_height")),
    (REFUSE, Slip({"obstacles.0.travel_share": 0.1}, "obstacle_share")),
    (REFUSE, Slip({"obstacles.0.end_mm": [5250, 500, -277]}, "cross_member_skew")),
    (TRUCK, Slip({"obstacles.0.start_mm": [2100, -500, -530],
                  "obstacles.0.end_mm": [2100, 500, -530]}, "obstacle_distance")),
    # --- digits swapped
    (PICK_UP, Slip({"vehicle.wheelbase_mm": 2300}, "transfer_case_reach")),
    (REFUSE, Slip({"axle.ratio": 8.48}, "governed_road_speed")),
    (REFUSE, Slip({f"{EMPTY}.cg_height_mm": 2150}, "centre_rise")),
    ("mtv-6x6", Slip({"drivelines.main.torque_share": 0.5}, "inter_axle_shares")),
    # --- limits of angles alone for a machine with a duty; shocks left out there too
    (INDUSTRIAL, Slip({"limits": "protractor"}, "unused_inputs")),
    (INDUSTRIAL, Slip({"shock_factor": None}, "shock_factor")),
    # --- the through-drive's pinion with the values of the plain one, or the other sign
    (TANDEM, Slip({f"{MAIN}.axle.pinion.ahead_mm": 380, f"{MAIN}.axle.pinion.above_mm": 50},
                  "through_shaft")),
    (TANDEM, Slip({"drivelines.inter-axle.output_joint.above_mm": -105}, "through_shaft")),
    # --- what stands on two axles of one bogie: a decimal moved, digits swapped, one lost
    (SIX, Slip({"drivelines.inter-axle.points_mm.1": [640, 0, -5.5]}, "inter_axle_drop")),
    (SIX, Slip({"drivelines.inter-axle.axle.pinion.above_mm": 5}, "inter_axle_drop")),
    (SIX, Slip({"drivelines.inter-axle.gearbox_slope.side_deg": 2.3}, "through_slope")),
    (SIX, Slip({"drivelines.inter-axle.points_mm.1": [1640, 0, -55]}, "axle_spacing")),
    # --- a joint of constant velocity with a value of another key or another kind
    (PICK_UP, Slip({f"{MAIN}.joints.1.bearing_Td_Nm": 4000}, "roller_rating")),
    (PICK_UP, Slip({f"{MAIN}.joints.1.rated_angle_deg": 40}, "rated_angle")),
    (PICK_UP, Slip({f"{MAIN}.joints.2.angle_max_deg": 40}, "angle_of_kind")),
    # --- pounds for kilograms, digits of a diameter swapped, a friction that no spline has
    (SIX, Slip({f"{MAIN}.shafts.0.yoke_mass_kg": [6.4, 7.7]}, "yoke_size")),
    (SMALL, Slip({f"{SHAFT1}.tube": {"outer_mm": 106.1, "wall_mm": 3.2}}, "tube_digits")),
    (SMALL, Slip({f"{SHAFT1}.tube": {"outer_mm": 110.6, "wall_mm": 3.2}}, "tube_digits")),
    (SIX, Slip({f"{MAIN}.shafts.1.spline.friction": 0.04}, MEASURE)),
    (PICK_UP, Slip({"gearbox.ratios": [4.31, 2.33, 1.44, 1.00, 0.97, 0.68]}, "gear_steps")),
    # --- one state copied for another
    (MEDIUM, Slip({EMPTY: {"front_axle_kg": 4300, "rear_axle_kg": 7700, "cg_height_mm": 1350}},
                  "load_states_alike")),
    ("van", Slip({"states.3": {"name": "overload", "kind": "gvw"}}, "states_alike")),
    (TANDEM, Slip({"states.7.articulation_mm": 4}, "given_travel")),
    # --- rates of both springs
    (TANDEM, Slip({"suspension.spring.rates_N_mm": [600, 840]}, "stop_load")),
    # --- a drive with fewer axles than the lines reach; shares of front and rear swapped
    (TANDEM, Slip({"vehicle.drive": "6x2"}, "through_driven_axles")),
    (PICK_UP, Slip({f"{MAIN}.torque_share": 0.4, f"{FRONT}.torque_share": 0.6},
                   "torque_for_load")),
    # --- an obstacle behind the line, one on the axle a hand too low
    (REFUSE, Slip({"obstacles.0.start_mm": [3550, -500, -277],
                   "obstacles.0.end_mm": [3550, 500, -277]}, "obstacle_beyond_line")),
    (REFUSE, Slip({"obstacles.0.start_mm": [2550, -500, -377],
                   "obstacles.0.end_mm": [2550, 500, -377]}, "riding_member_height")),
    # --- kgf/mm for N/mm, a line half as long, an axle without its hubs
    (MEDIUM, Slip({f"{BEARING}.vertical_stiffness_N_mm": 15.3,
                   f"{BEARING}.lateral_stiffness_N_mm": 10.2}, "rubber_bounce")),
    ("composite-van", Slip({"driveline.points_mm.1": [1280, 0, -155]}, "gearbox_place")),
    ("mtv-6x6", Slip({f"{MAIN}.axle.ratio": 3.9, "drivelines.inter-axle.axle.ratio": 3.9},
               "governed_road_speed")),
    # --- a digit missing or a value doubled, in what had no partner yet
    (TANDEM, Slip({"states.7.speed_rpm": 30}, "state_road_speed")),
    ("vecto-4x2", Slip({"states.0.speed_rpm": 60}, "state_road_speed")),
    ("van", Slip({"axle.pinion.ahead_mm": 540}, "pinion_ahead")),
    ("van", Slip({"engine.speed_rpm": [180, 3000, 3900]}, "curve_speeds")),
    (PICK_UP, Slip({f"{FRONT}.joints.1.rated_angle_deg": 0.4}, "rated_angle")),
    (PICK_UP, Slip({f"{MAIN}.shafts.0.centre_bearing.vertical_stiffness_N_mm": 76},
                   "rubber_directions")),
    (INDUSTRIAL, Slip({"states.0.points_mm.1": [1300, 0, 23]}, "fixed_joints")),
    # --- limits of another class
    ("van", Slip({"limits": "body-builder"}, "body_builder_limits")),
    ("van", Slip({"limits": loosened("van", centre_bearing_peak={"maximum": 5000})},
                 "limits_over_profile")),
    ("van", Slip({"limits": [{"quantity": "joint_life", "unit": "h", "normal": 5000,
                              "maximum": 1500, "source": "own"}]}, "looser_limits")),
    (PICK_UP, Slip({"limits": [{"quantity": "centre_bearing_static", "normal": 1000,
                                "maximum": 1750, "source": "own"}]}, "limits_over_profile")),
    (MEDIUM, Slip({"limits": loosened("medium-truck", centre_bearing_static={"maximum": 17500})},
                  "looser_limits")),
]  # fmt: skip
"""Slips on other vehicles and on a machine."""


def with_slip(example: str, slip: Slip) -> str:
    """The text of an example with some values replaced."""
    kind, _, starter = example.partition(":")
    tree = yaml.safe_load(
        template_text(starter)
        if starter
        else (ROOT / "examples" / f"{kind}.yaml").read_text(encoding="utf-8")
    )
    raw: dict[str, str] = {}
    for address, value in slip.edits.items():
        *parents, last = address.split(".")
        at = tree
        for key in parents:
            at = at[int(key) if isinstance(at, list) else key]
        key = int(last) if isinstance(at, list) else last
        if value is None:
            del at[key]
        else:
            at[key] = _plain(value, raw)
    text = yaml.safe_dump(tree, sort_keys=False, allow_unicode=True)
    for token, written in raw.items():
        text = text.replace(token, written)
    return text


def _plain(value: Any, raw: dict[str, str]) -> Any:
    if isinstance(value, Raw):
        token = f"RAWTEXT{len(raw)}X"
        raw[token] = str(value)
        return token
    return [_plain(v, raw) for v in value] if isinstance(value, list) else value


def names_of(text: str) -> set[str]:
    """What names the slips of a text: relations, `measure`, `refused`; empty if nothing does."""
    try:
        application = loads(text)
        named = {w.relation or MEASURE for w in application.warnings}
        if not named:
            approve_driveline(application)
    except (InvalidFileError, CardanError):
        return {REFUSED}
    return named


FAST = [
    ("van", VAN[k])
    for k, slip in enumerate(VAN)
    if slip.named in {
        "gearbox_place", "payload_place", "torque_per_tonne", "curve_fall", "road_speed",
        "reverse_ratio", "tyre_size", "yokes_out_of_line", "published_joint", "top_speed",
        "expected_states", "heavy_truck_limits",
    }
]  # fmt: skip
"""The kinds of slip that left a verdict as it was, one or two of each."""


@pytest.mark.parametrize(("example", "slip"), [*FAST, *OTHERS])
def test_slip_is_named_by_its_relation(example, slip):
    assert slip.named in names_of(with_slip(example, slip))


@pytest.mark.parametrize("key", ["torque_share", "load_share"])
def test_missing_key_of_the_inter_axle_line_is_named(key):
    text = with_slip(TANDEM, Slip({f"drivelines.inter-axle.{key}": None}, ""))
    (warning,) = loads(text).warnings
    assert warning.key == f"drivelines.inter-axle.{key}"
    assert "got nothing, 1 is taken" in warning.format_with_location("f")


@pytest.mark.parametrize("example", [REFUSE, TRUCK])
def test_obstacles_left_out_are_named(example):
    note = "clearance is not evaluated (input missing: obstacles)"
    for edits, told in (({}, False), ({"obstacles": None}, True)):
        application = loads(with_slip(example, Slip(edits, "")))
        assert (note in [n.text for n in approval_notes(application, ())]) is told


@pytest.mark.parametrize(
    ("example", "keys"),
    [(SMALL, "torque_Nm, speed_rpm"), (INDUSTRIAL, "torque_Nm, speed_rpm"), ("van", "")],
)
def test_torque_and_speed_that_nothing_confirms_are_named(example, keys):
    """A torque in lbf ft under torque_Nm contradicts nothing where there is no engine."""
    notes = approval_notes(loads(with_slip(example, Slip({}, ""))), ())
    found = [ENGLISH.translate_message(note) for note in notes]
    named = [text for text in found if text.startswith(f"nothing in the file confirms {keys}")]
    assert len(named) == bool(keys)


@pytest.mark.parametrize(
    ("example", "told"), [(SMALL, "the lengths of the shafts"), ("mtv-6x6", "engine.torque_Nm")]
)
def test_lengths_and_engine_torque_that_nothing_confirms_are_named(example, told):
    """A length of 1050 for 1500 contradicts nothing where no wheelbase is given."""
    for other, expected in ((example, True), ("van", False)):
        notes = [str(n) for n in approval_notes(loads(with_slip(other, Slip({}, ""))), ())]
        assert any(f"nothing in the file confirms {told}" in n for n in notes) is expected


@pytest.mark.parametrize("example", ["van", CHAIN])
def test_limits_of_a_command_are_compared_as_those_of_the_file(example, tmp_path):
    own = tmp_path / "own.yaml"
    row = {"quantity": "critical_speed_ratio", "maximum": 1.2, "source": "own"}
    own.write_text(yaml.safe_dump({"profile": "own", "limits": [row]}), "utf-8")
    application = read(ROOT / "examples" / f"{example}.yaml")
    (warning,) = with_limit_profile(application, str(own)).warnings
    assert (warning.relation, warning.key) == ("looser_limits", str(own))
    assert with_limit_profile(application, "protractor").warnings == ()


@pytest.mark.slow
def test_at_most_three_slips_change_nothing_and_are_not_named():
    named = {k: names_of(with_slip(*slip)) for k, slip in enumerate(SLIPS)}
    wrong = [
        (slip, named[k])
        for k, (_, slip) in enumerate(SLIPS)
        if (named[k] if slip.named == SILENT else slip.named not in named[k])
    ]
    assert wrong == []
    verdicts = {
        example: approve_driveline(read(ROOT / "examples" / f"{example}.yaml")).verdict
        for example, _ in SLIPS
    }
    unchanged = [
        slip
        for k, (example, slip) in enumerate(SLIPS)
        if not named[k]
        and approve_driveline(loads(with_slip(example, slip))).verdict == verdicts[example]
    ]
    assert len(unchanged) <= 3


@pytest.mark.parametrize(
    ("example", "edits"),
    [
        (PICK_UP, {f"{MAIN}.torque_share": 0.5, f"{FRONT}.torque_share": 0.5}),
        ("van", {"limits": loosened("van", centre_bearing_peak={"maximum": 2300})}),
        (REFUSE, {"obstacles.0.start_mm": [3380, -500, -277],
                  "obstacles.0.end_mm": [3380, 500, -277]}),
        (TANDEM, {"states.7.articulation_mm": 15}),
        (MEDIUM, {f"{BEARING}.vertical_stiffness_N_mm": 75,
                  f"{BEARING}.lateral_stiffness_N_mm": 50}),
        ("van", {"states.3": {"name": "overload", "kind": "gvw", "speed_rpm": 3000}}),
        (INDUSTRIAL, {"states.1.points_mm": [[0, 0, 0], [1300, 0, -23], [2900, 0, -107]]}),
    ],
)  # fmt: skip
def test_value_another_design_may_have_is_not_named(example, edits):
    assert loads(with_slip(example, Slip(edits, ""))).warnings == ()


def test_relations_have_names_of_their_own_and_a_source():
    names = [rule.name for rule in PLAUSIBILITY_RULES]
    assert len(set(names)) == len(names)
    assert all(rule.source and rule.description for rule in PLAUSIBILITY_RULES)


def test_warning_names_the_values_it_compares_with_their_lines():
    text = (
        (ROOT / "examples" / "van.yaml").read_text("utf-8").replace("plunge_mm: 45", "plunge_mm: 5")
    )
    text = text.replace("draw_mm: 45", "draw_mm: 200")
    (warning,) = [w for w in loads(text).warnings if w.relation == "spline_balance"]
    line = 1 + text[: text.index("draw_mm: 200")].count("\n")
    assert warning.key == "driveline.shafts[1].spline.draw_mm"
    assert (warning.value, warning.line) == ("200", line)
    assert warning.against_text == f"driveline.shafts[1].spline.plunge_mm 5 (line {line})"
    assert warning.source.endswith("range assumed")
    assert "(got 200); compared with driveline.shafts[1].spline.plunge_mm 5" in (
        warning.format_with_location("van.yaml")
    )


@pytest.mark.parametrize("outer", [101.6, 100, 102, 110, 114.3, 120])
def test_diameters_of_catalogues_and_round_ones_are_not_named(outer):
    edits = {f"{SHAFT1}.tube": {"outer_mm": outer, "wall_mm": 3.2}}
    assert "tube_digits" not in names_of(with_slip(SMALL, Slip(edits, "")))
