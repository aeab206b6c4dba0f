"""Applications made to come to one verdict by one quantity, for tests that ask every medium.

The truck of `tests/verify/by_hand.yaml` knows every quantity of the driveline; two of its
states and one of its lines are enough here, and its gearbox and axle turn with something.
Its limits are replaced by one that a quantity just misses, or just meets.
"""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import yaml

from cardan import files
from cardan.quantity.quantities import ANSWERED, LIMITABLE, QUANTITIES
from cardan.study.approval import Approval, approve

HERE = Path(__file__).parent
DRIVELINE = [q for q in LIMITABLE if q in ANSWERED]
VIBRATION = [q for q in LIMITABLE if QUANTITIES[q].study == "vibration"]
ASKED = [*DRIVELINE, *VIBRATION]
CATALOGUE = HERE / "verify/by_hand.csv"
JOINT = {"peak_kNm": 38, "reversing_kNm": 13, "pulsating_kNm": 21.5, "bearing_Td_kNm": 3.1}
"""A joint without limits of its own on angle and speed: what is asked is asked by one limit."""

LITTLE = 1e-6
"""How far beyond a value its limit lies, as a share: a thousand times what counts as equal,
and a thousandth of what AE-7 and the small angle are off."""


@cache
def base(odd: bool = False) -> dict:
    """The truck as data; `odd` is its line with an odd number of joints."""
    found = yaml.safe_load((HERE / "verify/by_hand.yaml").read_text(encoding="utf-8"))
    keep, drop = ("inter-axle", "main") if odd else ("main", "inter-axle")
    found["drivelines"] = {keep: found["drivelines"][keep]}
    found["obstacles"] = [o for o in found["obstacles"] if o.get("line", "main") != drop]
    found["drivelines"][keep]["joints"] = [JOINT] * (3 if odd else 4)
    found["states"] = ["gvw", "jounce"]
    return found


def truck(limits: list[dict], *, odd: bool = False, **more: object) -> str:
    """The truck as text, held against these limits; `more` keys replace its own, None drops."""
    found = {**base(odd), "limits": limits, **more}
    return yaml.safe_dump({k: v for k, v in found.items() if v is not None}, sort_keys=False)


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


@cache
def values(odd: bool, vibrates: bool) -> dict[str, float]:
    """The worst value of each quantity, in the unit that limits of it are given in."""
    import tempfile

    asked = VIBRATION if vibrates else DRIVELINE
    text = truck([limit(q, maximum=1.0) for q in asked], odd=odd, **_torsion(vibrates))
    with tempfile.TemporaryDirectory() as folder:
        found = read(put(Path(folder), "all", text))
    worst: dict[str, float] = {}
    for c in found.checks:
        value = c.value / QUANTITIES[c.quantity].factor
        most = max if c.limit.sense == "<=" else min
        worst[c.quantity] = most(value, worst.get(c.quantity, value))
    return worst


def read(path: Path) -> Approval:
    return approve(files.read(path))


def _torsion(vibrates: bool) -> dict:
    return {"torsion": {"axle_inertia_kgm2": 2.0}} if vibrates else {}


def _case(quantity: str, verdict: str, **bounds: float) -> Case:
    odd, vibrates = quantity == "odd_joint_angle", quantity in VIBRATION
    text = truck([limit(quantity, **bounds)], odd=odd, **_torsion(vibrates))
    return Case(f"{quantity}-{verdict}", text, verdict, quantity)


def bound(quantity: str, share: float) -> float:
    """A bound that the worst value of a quantity is past, by a share of itself."""
    odd = quantity == "odd_joint_angle"
    value = values(odd, quantity in VIBRATION)[quantity]
    safe = -1 if QUANTITIES[quantity].sense == "<=" else 1
    return value + safe * share * (abs(value) or 1.0)


def failing(quantity: str) -> Case:
    return _case(quantity, "fail", maximum=bound(quantity, LITTLE))


def warning(quantity: str) -> Case:
    return _case(quantity, "warn", normal=bound(quantity, LITTLE))


def passing(quantity: str) -> Case:
    return _case(quantity, "pass", maximum=bound(quantity, -LITTLE))


def equal() -> Case:
    """Every quantity of the line exactly at its limit."""
    asked = [q for q in DRIVELINE if q != "odd_joint_angle"]
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


def cases() -> list[Case]:
    """One failing case of every quantity, and of each other verdict some."""
    return [
        *map(failing, ASKED),
        *map(warning, ("torsional_acceleration", "clearance", "torsional_resonance")),
        *map(passing, ("torsional_acceleration", "clearance", "joint_angle", "joint_position")),
        equal(), incomplete(), unasked(),
    ]  # fmt: skip
