"""Traps: values that are plausible and wrong. Each is refused or warned of, at its own line.

A file that is right but for one slip (another unit, a diameter for a radius, a lost sign, two
values swapped) must not pass in silence. A trap is a file, what is changed in it, and into
what; the answer must stand in the line of the change, or in the line of a text that is named.
"""

import re

import pytest
from repository import ROOT

from cardan.application.reader import loads, read
from cardan.application.templates import template_text
from cardan.core.errors import InvalidFileError
from cardan.core.units import deg
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

TRUCK = template_text("truck")
SMALL = template_text("small")
REFUSE = (ROOT / "examples" / "refuse-collector-6x2.yaml").read_text(encoding="utf-8")
TANDEM = (ROOT / "examples" / "tandem-6x4.yaml").read_text(encoding="utf-8")
MEDIUM = (ROOT / "examples" / "medium-truck-4x2.yaml").read_text(encoding="utf-8")

BASES = {"truck": TRUCK, "small": SMALL, "refuse": REFUSE, "tandem": TANDEM, "medium": MEDIUM}

TRAPS = {
    # --- another unit
    "shaft in centimetres": ("small", "length_mm: 1200", "length_mm: 120"),
    "shaft in inches": ("small", "length_mm: 1200", "length_mm: 47.2"),
    "shaft in metres": ("small", "length_mm: 1200", "length_mm: 1.2"),
    "shaft ten times too long": ("small", "length_mm: 1500", "length_mm: 15000"),
    "shaft of a thousandth millimetre": ("small", "length_mm: 1500", "length_mm: 0.001"),
    "tube in inches": ("small", "{outer_mm: 101.6, wall_mm: 3.2}\n      phase_deg: 0\n\n",
                       "{outer_mm: 4, wall_mm: 0.126}\n      phase_deg: 0\n\n"),
    "wall in centimetres": ("small", "{outer_mm: 101.6, wall_mm: 3.2}\n      phase_deg: 0\n\n",
                            "{outer_mm: 101.6, wall_mm: 0.32}\n      phase_deg: 0\n\n"),
    "wall ten times too thick": ("small", "{outer_mm: 101.6, wall_mm: 3.2}\n      phase_deg: 0\n\n",
                                 "{outer_mm: 101.6, wall_mm: 22}\n      phase_deg: 0\n\n"),
    "points in metres": ("truck", "[[0, 0, 0], [1240, 0, -60], [2750, 0, -165]]",
                         "[[0, 0, 0], [12.4, 0, -0.6], [27.5, 0, -1.65]]"),
    "points in inches": ("truck", "[[0, 0, 0], [1240, 0, -60], [2750, 0, -165]]",
                         "[[0, 0, 0], [48.8, 0, -2.4], [108.3, 0, -6.5]]"),
    "points in centimetres": ("truck", "[[0, 0, 0], [1240, 0, -60], [2750, 0, -165]]",
                              "[[0, 0, 0], [124, 0, -6], [275, 0, -16.5]]"),
    "slopes in radians": ("small", "side_deg: [3.0, 1.0, 4.5, 2.0]",
                          "side_deg: [0.052, 0.017, 0.079, 0.035]"),
    "gearbox slope in radians": ("truck", "gearbox_slope: {side_deg: 4.0",
                                 "gearbox_slope: {side_deg: 0.07"),
    "pinion slope in radians": ("truck", "pinion_slope: {side_deg: 2.4",
                                "pinion_slope: {side_deg: 0.042"),
    "top speed in hertz": ("small", "speed_rpm: 2500", "speed_rpm: 41.7"),
    "top speed in rad/s": ("refuse", "speed_rpm: 2400  ", "speed_rpm: 251  "),
    "top speed of the wheels": ("refuse", "speed_rpm: 2400  ", "speed_rpm: 400  "),
    "torque in kNm": ("small", "torque_Nm: 8000", "torque_Nm: 8"),
    "torque ten times too large": ("small", "torque_Nm: 8000", "torque_Nm: 80000"),
    "torque in Nmm": ("small", "torque_Nm: 8000", "torque_Nm: 8e6"),
    "engine speed in hertz": ("truck", "speed_rpm: [1000, 1200, 1600, 2200, 2500]",
                              "speed_rpm: [16.7, 20, 26.7, 36.7, 41.7]"),
    "engine speed in rad/s": ("truck", "speed_rpm: [1000, 1200, 1600, 2200, 2500]",
                              "speed_rpm: [105, 126, 168, 230, 262]"),
    "engine torque in kNm": ("truck", "torque_Nm: [850, 950, 950, 850, 700]",
                             "torque_Nm: [0.85, 0.95, 0.95, 0.85, 0.7]"),
    "engine torque of the axle": ("truck", "torque_Nm: [850, 950, 950, 850, 700]",
                                  "torque_Nm: [41000, 42000, 42000, 41000, 35000]"),
    "brake torque of the gearbox output": ("truck", "brake_torque_Nm: 350",
                                           "brake_torque_Nm: 3500"),
    "axle load in tonnes": ("truck", "front_axle_kg: 4800, rear_axle_kg: 6500",
                            "front_axle_kg: 4.8, rear_axle_kg: 6.5"),
    "one axle load in tonnes": ("truck", "front_axle_kg: 4800, rear_axle_kg: 6500",
                                "front_axle_kg: 4.8, rear_axle_kg: 6500"),
    "axle load in newton": ("refuse", "gvw: {front_axle_kg: 6000, rear_axle_kg: 17000",
                            "gvw: {front_axle_kg: 58800, rear_axle_kg: 166700"),
    "mass in tonnes": ("truck", "mass_kg: 23000", "mass_kg: 23"),
    "wheelbase in centimetres": ("truck", "wheelbase_mm: 4800", "wheelbase_mm: 480"),
    "wheelbase in inches": ("truck", "wheelbase_mm: 4800", "wheelbase_mm: 189"),
    "centre of gravity in centimetres": ("truck", "cg_height_mm: 1500", "cg_height_mm: 150"),
    "centre of gravity in metres": ("truck", "cg_height_mm: 1500", "cg_height_mm: 1.5"),
    "unsprung mass in tonnes": ("truck", "unsprung_mass_kg: 900", "unsprung_mass_kg: 0.9"),
    "unsprung mass in newton": ("truck", "unsprung_mass_kg: 900", "unsprung_mass_kg: 8830"),
    "tyre in inches": ("truck", "static_radius_mm: 480", "static_radius_mm: 18.9"),
    "spring loads in kilogram": ("truck", "load_N: [0, 20000, 46000, 75000]",
                                 "load_N: [0, 2040, 4690, 7650]"),
    "spring deflections in centimetres": ("truck", "deflection_mm: [0, 70, 150, 220]",
                                          "deflection_mm: [0, 7, 15, 22]"),
    "spring rates in N/m": ("medium", "rates_N_mm: [165, 235]", "rates_N_m: [165, 235]"),
    "spring rates in kgf/mm": ("medium", "rates_N_mm: [165, 235]", "rates_N_mm: [16.8, 24]"),
    "spring rates in N/cm": ("medium", "rates_N_mm: [165, 235]", "rates_N_mm: [1650, 2350]"),
    "wind-up in Nm": ("truck", "windup_stiffness_kNm_deg: 16", "windup_stiffness_Nm_deg: 16"),
    "wind-up per radian": ("truck", "windup_stiffness_kNm_deg: 16",
                           "windup_stiffness_kNm_deg: 916"),
    "wind-up of a radian in Nm": ("truck", "windup_stiffness_kNm_deg: 16",
                                  "windup_stiffness_Nm_rad: 16000"),
    "pitch rate per metre": ("truck", "pitch_rate_deg_mm: 0.002", "pitch_rate_deg_mm: 2"),
    "pitch rate in rad/mm": ("truck", "pitch_rate_deg_mm: 0.002", "pitch_rate_rad_m: 0.002"),
    "link angle in radians": ("truck", "angle_deg: 4 ", "angle_deg: 0.07 "),
    "front half in centimetres": ("truck", "front_half_length_mm: 760", "front_half_length_mm: 76"),
    "bearing stiffness in N/m": ("truck", "vertical_stiffness_N_mm: 200",
                                 "vertical_stiffness_N_m: 200"),
    "bearing stiffness times a million": ("truck", "vertical_stiffness_N_mm: 200",
                                          "vertical_stiffness_N_mm: 200000000"),
    "axial stiffness in N/m": ("truck", "axial_stiffness_N_mm: 60", "axial_stiffness_N_m: 60"),
    "axial stiffness of the bracket alone": ("truck", "axial_stiffness_N_mm: 60",
                                             "axial_stiffness_N_mm: 6000"),
    "loss factor in percent": ("truck", "loss_factor: 0.1", "loss_factor: 10"),
    "loss factor hardly any": ("truck", "loss_factor: 0.1", "loss_factor: 0.001"),
    "bearing place in centimetres": ("truck", "from_rear_joint_mm: 150", "from_rear_joint_mm: 15"),
    "bearing place from the front": ("truck", "from_rear_joint_mm: 150",
                                     "from_rear_joint_mm: 1090"),
    "spline in centimetres": ("truck", "plunge_mm: 60,", "plunge_mm: 0.6,"),
    "spline radius in metres": ("truck", "mean_radius_mm: 32", "mean_radius_mm: 0.032"),
    "yokes in gram": ("truck", "yoke_mass_kg: [9, 11]", "yoke_mass_kg: [9000, 11000]"),
    "obstacle in metres": ("truck", "start_mm: [2100, -500, -350]", "start_mm: [2.1, -0.5, -0.35]"),
    "obstacle's radius in metres": ("truck", "radius_mm: 60   ", "radius_mm: 0.06   "),
    "travel in metres": ("truck", "travel_mm: -30", "travel_mm: -0.03"),
    "pitch in radians": ("truck", "pitch_deg: 0.2}", "pitch_deg: 0.0035}"),
    "jounce in centimetres": ("truck", "jounce_deflection_mm: 215", "jounce_deflection_mm: 21.5"),
    "duty torque of the axle": ("truck", "torque_Nm: 3200, speed_rpm: 400",
                                "torque_Nm: 15600, speed_rpm: 400"),
    "duty speed of the engine": ("truck", "torque_Nm: 900, speed_rpm: 1500",
                                 "torque_Nm: 900, speed_rpm: 15000"),
    "duty beyond full power": ("truck", "torque_Nm: 3200, speed_rpm: 400",
                               "torque_Nm: 3200, speed_rpm: 1400"),
    "density in g/cm3": ("small", "{outer_mm: 101.6, wall_mm: 3.2}\n      phase_deg: 0\n\n",
                         "{outer_mm: 101.6, wall_mm: 3.2, material: {youngs_modulus_GPa: 206, "
                         "density_kg_m3: 7.85}}\n      phase_deg: 0\n\n"),
    "Young's modulus in MPa": ("small", "{outer_mm: 101.6, wall_mm: 3.2}\n      phase_deg: 0\n\n",
                               "{outer_mm: 101.6, wall_mm: 3.2, material: {youngs_modulus_GPa: "
                               "206000, density_kg_m3: 7850}}\n      phase_deg: 0\n\n"),
    "yield above ultimate": ("small", "{outer_mm: 101.6, wall_mm: 3.2}\n      phase_deg: 0\n\n",
                             "{outer_mm: 101.6, wall_mm: 3.2, material: {youngs_modulus_GPa: 206, "
                             "density_kg_m3: 7850, yield_MPa: 490, ultimate_MPa: 355}}\n"
                             "      phase_deg: 0\n\n", "ultimate_MPa"),
    "shim in radians": ("truck", "shim_deg: [-3, 3]", "shim_deg: [-0.05, 0.05]"),
    "bearing moves in metres": ("truck", "bearing_height_mm: {1: [-20, 30]}",
                                "bearing_height_mm: {1: [-0.02, 0.03]}"),
    "grade as a share": ("truck", "grade_percent: 0 ", "grade_percent: 0.1 "),
    "front axle in units of its own": ("refuse", "gvw: {front_axle_kg: 6000, rear_axle_kg: 17000",
                                       "gvw: {front_axle_kg: 256, rear_axle_kg: 20000"),
    "rubber fifty times as stiff upright": ("truck", "vertical_stiffness_N_mm: 200",
                                            "vertical_stiffness_N_mm: 6000"),
    "engine without torque in between": ("truck", "torque_Nm: [850, 950, 950, 850, 700]",
                                         "torque_Nm: [850, 950, 0, 850, 700]"),
    "engine from next to nothing": ("truck", "speed_rpm: [1000, 1200, 1600, 2200, 2500]",
                                    "speed_rpm: [0.000001, 1200, 1600, 2200, 2500]"),
    "brake stronger than the engine": ("truck", "brake_torque_Nm: 350", "brake_torque_Nm: 2100"),
    "yokes ten times as heavy": ("truck", "yoke_mass_kg: [12, 9]", "yoke_mass_kg: [180, 9]"),
    "balance of a ship's diesel": ("truck", "balance_grade: G40  ", "balance_grade: G4000  "),
    "balance of a gyroscope": ("truck", "balance_grade: G40  ", "balance_grade: 0.4  "),
    "centre of gravity below the wheels": ("truck", "cg_height_mm: 1500", "cg_height_mm: 345"),
    # --- a diameter for a radius, an inverse, a swap
    "tyre by its diameter": ("truck", "static_radius_mm: 480", "static_radius_mm: 960"),
    "tyre rolling on less": ("truck", "dynamic_radius_mm: 495", "dynamic_radius_mm: 465"),
    "tyre rolling on its diameter": ("truck", "dynamic_radius_mm: 495", "dynamic_radius_mm: 990"),
    "axle ratio inverse": ("truck", "ratio: 4.88", "ratio: 0.205"),
    "axle ratio without its point": ("truck", "ratio: 4.88", "ratio: 48.8"),
    "gear ratios inverse": ("truck", "ratios: [9.2, 5.3, 3.2, 2.0, 1.35, 1.0]",
                            "ratios: [1.0, 0.741, 0.5, 0.312, 0.189, 0.109]"),
    "gear ratios in percent": ("truck", "ratios: [9.2, 5.3, 3.2, 2.0, 1.35, 1.0]",
                               "ratios: [92, 53, 32, 20, 13.5, 10]"),
    "reverse ratio inverse": ("truck", "reverse_ratio: 8.6", "reverse_ratio: 0.116"),
    "reverse ratio in percent": ("truck", "reverse_ratio: 8.6", "reverse_ratio: 86"),
    "reverse ratio times the axle's": ("truck", "reverse_ratio: 8.6", "reverse_ratio: 27"),
    "retarder at the wheels": ("truck", "  efficiency: 0.95", "  retarder_torque_Nm: 18000\n"
                               "  efficiency: 0.95"),
    "efficiency as a loss": ("truck", "efficiency: 0.95", "efficiency: 0.05"),
    "axle efficiency as a loss": ("truck", "efficiency: 0.96", "efficiency: 0.04"),
    "hardly any efficiency": ("truck", "efficiency: 0.96", "efficiency: 1e-300"),
    "converter off": ("refuse", "converter_ratio: 1.98", "converter_ratio: 9.8"),
    "tyre friction of ice": ("truck", "friction: 0.8 ", "friction: 0.08 "),
    "spline friction of percent": ("truck", "friction: 0.11}", "friction: 1.1}"),
    "empty and laden swapped": ("refuse", "empty: {front_axle_kg: 4900, rear_axle_kg: 7600",
                                "empty: {front_axle_kg: 6000, rear_axle_kg: 27000"),
    "curb heavier than empty": ("truck", "curb: {front_axle_kg: 4100, rear_axle_kg: 3700",
                                "curb: {front_axle_kg: 4100, rear_axle_kg: 13700"),
    "gvw of a payload": ("truck", "mass_kg: 23000", "mass_kg: 9000"),
    "centre of gravity behind the bogie": ("truck", "cg_behind_front_mm: 3548",
                                           "cg_behind_front_mm: 5348"),
    "centre of gravity from the rear": ("truck", "cg_behind_front_mm: 3548",
                                        "cg_behind_front_mm: 252"),
    "centre of gravity above the roof": ("truck", "cg_height_mm: 1500", "cg_height_mm: 4500"),
    "pinion in metres": ("truck", "ahead_mm: 420", "ahead_mm: 0.42"),
    "pinion in centimetres": ("truck", "ahead_mm: 420", "ahead_mm: 42"),
    "pinion far off": ("truck", "ahead_mm: 420", "ahead_mm: 1420"),
    "pinion behind the wheels": ("truck", "ahead_mm: 420", "behind_mm: 420"),
    "pinion above the tyre": ("truck", "above_mm: 20}", "above_mm: 520}"),
    "output joint on the wrong side": ("tandem", "output_joint: {behind_mm: 330",
                                       "output_joint: {ahead_mm: 330"),
    "wheelbase shorter than the line": ("truck", "wheelbase_mm: 4800", "wheelbase_mm: 2400"),
    "jounce below the load": ("truck", "jounce_deflection_mm: 215", "jounce_deflection_mm: 60"),
    "check strap above the load": ("truck", "full_rebound_deflection_mm: 45",
                                   "full_rebound_deflection_mm: 200"),
    "check strap above the axle unladen": ("truck", "full_rebound_deflection_mm: 45",
                                           "full_rebound_deflection_mm: 60"),
    "joint bears more than its peak": ("small", "joints: 1710", "joints: "
                                       "{peak_Nm: 1200, reversing_Nm: 12000}", "reversing_Nm"),
    # --- a lost sign
    "gearbox slope rising": ("truck", "gearbox_slope: {side_deg: 4.0",
                             "gearbox_slope: {side_deg: -4.0"),
    "pinion slope rising": ("truck", "pinion_slope: {side_deg: 2.4",
                            "pinion_slope: {side_deg: -2.4"),
    "spline by its diameter": ("truck", "mean_radius_mm: 32", "mean_radius_mm: 64"),
    "a point above the line": ("truck", "[1240, 0, -60]", "[1240, 0, 60]"),
    "a shaft rising": ("tandem", "points_mm: [[0, 0, 0], [640, 0, -55]]",
                       "points_mm: [[0, 0, 0], [640, 0, 55]]"),
    # --- what contradicts engine and gears
    "top speed above the engine's": ("refuse", "speed_rpm: 2400  ", "speed_rpm: 5400  "),
    "state torque above the engine's": ("refuse", "  - gvw\n",
                                        "  - {name: hot, kind: gvw, torque_Nm: 40000}\n"),
    "state speed above the engine's": ("refuse", "  - gvw\n",
                                       "  - {name: fast, kind: gvw, speed_rpm: 9000}\n"),
    "torque above the engine's": ("refuse", "speed_rpm: 2400  ",
                                  "torque_Nm: 80000\nspeed_rpm: 2400  ", "torque_Nm: 80000"),
    "nothing turns": ("small", "speed_rpm: 2500", "speed_rpm: 0"),
    "nothing pulls": ("small", "torque_Nm: 8000", "torque_Nm: 0"),
}  # fmt: skip


def told(text: str) -> list[str]:
    """Everything a reader of the text is told, refused or not."""
    try:
        application = loads(text, name="f")
    except InvalidFileError as error:
        return str(error).splitlines()
    return [w.format_with_location("f") for w in application.warnings]


@pytest.mark.parametrize("trap", TRAPS)
def test_a_trap_is_told_in_its_own_line(trap):
    base, old, new, *marker = TRAPS[trap]
    text = BASES[base]
    assert text.count(old) >= 1
    changed = text.replace(old, new, 1)
    start = changed.index(marker[0] if marker else new)
    line = changed.count("\n", 0, start) + 1
    answers = told(changed)
    assert any(a.startswith(f"f:{line}:") for a in answers), (line, answers)


def test_the_pitch_that_is_wondered_at_is_that_of_the_wound_up_axle():
    """Half a bogie's line winds up one of its two axles, the line before it each of both."""
    application = loads(
        TANDEM.replace("windup_stiffness_kNm_deg: 30", "windup_stiffness_kNm_deg: 1")
    )
    said = "\n".join(w.message for w in application.warnings)
    asked = [line_state_demand(resolve_line_references(application, i)) for i in application.lines]
    turned = {f"{d.pitch[d.states.index('windup')] / deg:.3g}" for d in asked}
    assert set(re.findall(r"pitch under full torque is ([\d.]+) deg", said)) == turned


@pytest.mark.parametrize("base", BASES)
def test_what_is_right_passes_in_silence(base):
    assert told(BASES[base]) == []


@pytest.mark.parametrize("file", ["van", "three-joint-chain"])
def test_the_other_examples_pass_in_silence(file):
    assert read(ROOT / "examples" / f"{file}.yaml").warnings == ()


def test_a_tube_longer_than_its_shaft_is_told_once():
    """5 m of tube on 1.1 m of shaft twisted without a word."""
    text = (ROOT / "examples" / "medium-truck-4x2.yaml").read_text("utf-8")
    at = "    - tube: 100x3\n"
    long = text.replace(at, at + "      tube_length_mm: 5000\n", 1)
    assert long != text
    told = [w.message for w in loads(long).warnings]
    assert told == ["the tube is longer than its shaft, which is 1122.53 mm"]
