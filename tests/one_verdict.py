"""Applications made to come to one verdict by one quantity, for tests that ask every medium.

The truck of `tests/verify/by_hand.yaml` knows every quantity of the driveline; two of its
states and one of its lines are enough here, its gearbox and axle turn with something, and a
centre bearing hangs in a bracket. Its limits are replaced by one that a quantity just
misses, or just meets. What a recording tells is held against a profile of one row instead.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import patch

import numpy as np
import yaml

from cardan.application import reader
from cardan.approval.approval import Approval, approve_application, default_studies
from cardan.checks.quantities.registry import LIMITABLE_QUANTITIES, LINE_QUANTITIES, QUANTITIES
from cardan.core.labels import EvaluationCondition
from cardan.core.units import MPa, hour
from cardan.topics.bracket.assessment import BracketResult
from cardan.topics.bracket.life import DamageResult
from cardan.topics.bracket.load_cases import BearingLoadCase as LoadCase
from cardan.topics.bracket.registration import BracketStudy
from cardan.topics.bracket.shape_result import BoltSlipUtilisation, FatigueFeature

HERE = Path(__file__).parent


def _answered_by(study: str) -> list[str]:
    return [q for q in LIMITABLE_QUANTITIES if QUANTITIES[q].study == study]


DRIVELINE = [q for q in LIMITABLE_QUANTITIES if q in LINE_QUANTITIES]
VIBRATION, BRACKET, RECORDING = map(_answered_by, ("vibration", "bracket", "recording"))
ASKED = [*DRIVELINE, *VIBRATION, *BRACKET]
"""What `cardan check` can be asked, with the studies that answer it."""
CATALOGUE = HERE / "verify/by_hand.csv"
RATED = {"peak_kNm": 38, "reversing_kNm": 13, "pulsating_kNm": 21.5, "bearing_Td_kNm": 3.1}
JOINT = {**RATED, "cross_width_mm": 140, "cup_diameter_mm": 57, "cup_length_mm": 38}
"""A joint without limits of its own on angle and speed: what is asked is asked by one limit."""

OF_KINDS = ("joint_swing", "joint_orbit", "tube_buckling_utilisation")
"""What crosses have not, and what the workbook does not follow: a wall's buckling."""
KINDS = [
    {**JOINT, "kind": "double cardan", "centre_distance_mm": 80, "ball_from_rear_mm": 44},
    JOINT, JOINT,
    {**RATED, "kind": "tripod", "pitch_circle_mm": 90},
]  # fmt: skip
PLIES = {"outer_mm": 120, "layup": [{"ply": "T300/5208", "angle_deg": [45, -45], "times": 6}]}

LITTLE = 1e-6
"""How far beyond a value its limit lies, as a share: a thousand times what counts as equal,
and a thousandth of what AE-7 and the small angle are off."""


E355 = {"youngs_modulus_GPa": 210, "poisson": 0.3, "density_kg_m3": 7850, "yield_MPa": 355}

GIVEN = {
    "vibration": {"torsion": {"axle_inertia_kgm2": 2.0}},
    "bracket": {
        "bracket": {
            "u_shape": {
                "seat_diameter_mm": 100, "width_mm": 90, "thickness_mm": 9, "height_mm": 90,
                "flange_mm": 75, "bend_radius_mm": 12, "bolt_diameter_mm": 17, "bolt_pitch_mm": 45,
            },
            "material": "S355MC",
            "element_mm": 25,
            "carried_mass_kg": 18,
            "fatigue": {"amplitude_MPa": 40, "cycles": 1.0e6, "slope": 5},
            "bolts": {"preload_kN": 30},
        }
    },
}  # fmt: skip
"""What a study needs that the driveline does not."""


OF_ENDS = ("gearbox_bearing_utilisation", "pinion_bearing_utilisation")
ENDS = {"gearbox_bearing_rating_N": 1e6, "pinion_bearing_rating_N": 1e6}
DISC = {"kind": "flexible disc", "angle_max_deg": 8, "plunge_mm": 500}


def shape(quantity: str) -> str:
    """Which truck has a quantity: its main line, the odd one, or one of other parts."""
    if quantity in OF_ENDS:
        return "ends"
    shapes = {"odd_joint_angle": "odd", "disc_axial_utilisation": "disc"}
    return shapes.get(quantity, "kinds" if quantity in OF_KINDS else "main")


@cache
def base(which: str = "main") -> dict:
    """The truck as data, with one of its lines."""
    odd = which == "odd"
    found = yaml.safe_load((HERE / "verify/by_hand.yaml").read_text(encoding="utf-8"))
    keep, drop = ("inter-axle", "main") if odd else ("main", "inter-axle")
    found["drivelines"] = {keep: found["drivelines"][keep]}
    found["obstacles"] = [o for o in found["obstacles"] if o.get("line", "main") != drop]
    found["suspension"]["axle_to_frame_mm"] = 420
    line = found["drivelines"][keep]
    for shaft in line["shafts"]:
        if "centre_bearing" in shaft:  # or it swings by itself, and no force of it is known
            own = {"loss_factor": 0.2, "travel_mm": 90}
            shaft["centre_bearing"] = {**shaft["centre_bearing"], **own}
        if "spline" in shaft:  # or its thrust buckles the line, as no stroke is known
            shaft["spline"] = {**shaft["spline"], "friction": 0.05}
    line["joints"] = KINDS if which == "kinds" else [JOINT] * (3 if odd else 4)
    if which == "ends":
        line.update(ENDS)
    if which == "disc":
        line["joints"][-1] = DISC
        line["shafts"] = [{k: v for k, v in s.items() if k != "spline"} for s in line["shafts"]]
    for shaft in line["shafts"]:  # a material in place, with the endurance of its weld
        material = shaft["tube"]["material"]
        own = dict(E355) if isinstance(material, str) else material
        shaft["tube"] = {**shaft["tube"], "material": {**own, "fatigue_shear_MPa": 120}}
    if which == "kinds":
        line["shafts"][0] = {**line["shafts"][0], "tube": PLIES}
    found["states"] = ["gvw", "jounce"]
    return found


def truck(limits: list[dict], *, which: str = "main", **more: object) -> str:
    """The truck as text, held against these limits; `more` keys replace its own, None drops."""
    found = {**base(which), "limits": limits, **more}
    return yaml.safe_dump({k: v for k, v in found.items() if v is not None}, sort_keys=False)


def verdict_of_headline(text: str) -> str:
    """The verdict that a headline words: an approval says there what is not evaluated."""
    said = " ".join(text.lower().split()).partition(";")[0]
    if "approved" not in said:
        return said
    return "fail" if said.startswith("not ") else "warn" if "with warnings" in said else "pass"


def put(folder: Path, name: str, text: str) -> Path:
    """The truck as a file, beside its catalogue."""
    (folder / CATALOGUE.name).write_bytes(CATALOGUE.read_bytes())
    path = folder / f"{name}.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def limit(quantity: str, **bounds: object) -> dict:
    return {"quantity": quantity, "source": "made up", **bounds}


@dataclass(frozen=True)
class Case:
    """A truck and the one verdict it must get."""

    name: str
    text: str
    verdict: str
    quantity: str

    @property
    def hangs(self) -> bool:
        """Whether its bracket has to be asked."""
        return self.quantity in BRACKET and self.verdict != "incomplete"


@cache
def values(which: str, study: str) -> dict[str, float]:
    """The worst value of each quantity, in the unit that limits of it are given in."""
    import tempfile

    asked = _answered_by(study) if study else DRIVELINE
    text = truck([limit(q, maximum=1.0) for q in asked], which=which, **GIVEN.get(study, {}))
    with tempfile.TemporaryDirectory() as folder, made_up_bracket():
        return worst_of(read(put(Path(folder), "all", text), hangs=study == "bracket"))


def worst_of(found: Approval) -> dict[str, float]:
    """The worst value of each quantity of an approval."""
    worst: dict[str, float] = {}
    for c in found.checks:
        value = c.value / QUANTITIES[c.quantity].si_factor
        most = max if c.limit.sense == "<=" else min
        worst[c.quantity] = most(value, worst.get(c.quantity, value))
    return worst


def read(path: Path, *, hangs: bool = False) -> Approval:
    """The approval of a file, of its bracket too where it is asked."""
    application = reader.read(path)
    bracket = (BracketStudy(),) if hangs else ()
    return approve_application(application, (*default_studies(application), *bracket))


@contextmanager
def made_up_bracket() -> Iterator[None]:
    """Ask no solver: a bracket's stresses and damage are made up, all else is as it is."""
    spots = np.array([180.0, 240.0]) * MPa
    features = tuple(
        FatigueFeature(zone="sheet", number=k, point=(0, 0, 0), error=0.0) for k in (1, 2)
    )
    outcome = SimpleNamespace(
        case=LoadCase("gvw", np.zeros((1, 9)), component="peak"),
        feature_stress=spots,
        utilisation=spots / (300 * MPa),
        feature_stress_error=0 * spots,
        min_feature_stress=spots,
        damage_result=None,
        favourable_utilisation=spots / (300 * MPa),
        utilisation_bounds=np.stack([spots, spots], axis=-1) / (300 * MPa),
    )
    duty = DamageResult(
        when=EvaluationCondition("duty", "gvw"),
        hot_spot_damage=np.array([1e-4, 4e-4]),
        gauge_damage=np.zeros(0),
        turns=np.nan,
        duration=hour,
    )

    def study(application, **_: object) -> BracketResult:
        variant = SimpleNamespace(
            case_results=(outcome,),
            duty_damage=(duty,),
            bolt_slips=(BoltSlipUtilisation(outcome.case.when, 0.7),),
            features=features,
            loaded_frequencies=np.array([100.0]),
            frequencies=np.array([100.0]),
            lowest_frequency=(100.0, 0.0),
            forced_response=None,
        )
        return BracketResult(
            title=application.title, bracket=application.bracket, top_speed=200.0,
            variants=(variant, variant),
        )  # fmt: skip

    with patch("cardan.topics.bracket.assessment.analyse_bracket", study):
        yield


def made(quantity: str, verdict: str, **bounds: float) -> Case:
    """A truck with one limit, and what it comes to."""
    study = QUANTITIES[quantity].study
    text = truck([limit(quantity, **bounds)], which=shape(quantity), **GIVEN.get(study, {}))
    return Case(f"{quantity}-{verdict}", text, verdict, quantity)


def bound(quantity: str, share: float) -> float:
    """A bound that the worst value of a quantity is past, by a share of itself."""
    found = values(shape(quantity), QUANTITIES[quantity].study)
    return past(quantity, found[quantity], share)


def past(quantity: str, value: float, share: float) -> float:
    """A bound that a value of a quantity is past, by a share of itself."""
    safe = -1 if QUANTITIES[quantity].sense == "<=" else 1
    return value + safe * share * (abs(value) or 1.0)


def failing(quantity: str) -> Case:
    return made(quantity, "fail", maximum=bound(quantity, LITTLE))


def warning(quantity: str) -> Case:
    return made(quantity, "warn", normal=bound(quantity, LITTLE))


def passing(quantity: str) -> Case:
    return made(quantity, "pass", maximum=bound(quantity, -LITTLE))


def equal() -> Case:
    """Every quantity of the line exactly at its limit."""
    asked = [q for q in DRIVELINE if shape(q) == "main"]
    text = truck([limit(q, maximum=bound(q, 0.0)) for q in asked])
    return Case("equal", text, "pass", "")


def incomplete() -> Case:
    """A line whose bearings' life is required, and whose duty nobody has told."""
    limits = [limit("joint_angle", maximum=45), limit("joint_life", normal=1, required=True)]
    return Case("incomplete", truck(limits, duty=None), "incomplete", "joint_life")


def unasked() -> Case:
    """Nothing that anybody answers."""
    text = truck([limit("joint_life", normal=1)], duty=None)
    return Case("unasked", text, "incomplete", "joint_life")


def endless() -> Case:
    """Bearings that nothing wears live for ever, which no cell can hold."""
    limits = [limit("joint_life", maximum=1000, required=True)]
    duty = [{"share_percent": 100, "torque_Nm": 0, "speed_rpm": 1000}]
    return Case("endless", truck(limits, duty=duty), "pass", "joint_life")


def unheard(quantity: str) -> Case:
    """A limit that is required, and whose study nobody asks: a bracket's, a recording's."""
    limits = [limit("joint_angle", maximum=45), limit(quantity, maximum=1, required=True)]
    text = truck(limits, **GIVEN.get(QUANTITIES[quantity].study, {}))
    return Case(f"{quantity}-unheard", text, "incomplete", quantity)


def cases() -> list[Case]:
    """One failing case of every quantity of `cardan check`, and of each other verdict some."""
    return [
        *map(failing, ASKED),
        *map(warning, ("torsional_acceleration", "clearance", "torsional_resonance")),
        *map(passing, ("torsional_acceleration", "clearance", "joint_angle", "joint_position")),
        equal(), incomplete(), unasked(), endless(), *map(unheard, (*BRACKET, *RECORDING)),
    ]  # fmt: skip
