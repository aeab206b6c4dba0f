"""What a channel of a recording is, guessed by its unit and its name."""

import re
from collections.abc import Mapping
from typing import Literal, TypeAlias

from cardan.physics.signals.channel_units import (
    AMPLIFIER_UNITS,
    ROTATION_SPEED_UNITS,
    STRAIN_UNITS,
    STRESS_UNITS,
    TORQUE_UNITS,
    VEHICLE_SPEED_UNITS,
)
from cardan.physics.signals.recording import Channel
from cardan.topics.recording.channel_reading import channel_unit

ChannelRole: TypeAlias = Literal[
    "gauge", "speed", "engine", "tacho", "vehicle speed", "torque", "gear", "acceleration",
    "temperature", "",
]  # fmt: skip
"""What a channel is; "" if neither unit nor name says it."""

_ACCELERATION_UNITS = ("m/s2", "m/s^2", "m/s²", "mm/s2", "mm/s²", "ms-2", "g", "gn", "mg")
_TEMPERATURE_UNITS = ("°c", "degc", "deg c", "celsius", "°f", "degf", "k", "c", "ºc")

_WORDS_BY_ROLE: Mapping[ChannelRole, str] = {
    "tacho": r"tach?o",
    "temperature": r"temperatur|temp(?![a-zß-ÿ])",
    "acceleration": r"acc(?:el|(?![a-zß-ÿ]))|beschl|acelera",
    "gear": r"\w*gear(?!box|[\W_]*ratio)|gang(?![a-zß-ÿ])|marcha|marcia",
    "torque": r"torque|drehmoment|coppia|momento|moment(?![a-zß-ÿ])",
    "speed": r"rpm|speed|drehzahl|rotação|rotacao|giri|n(?=$|[\s_])",
    "gauge": r"s\d+(?![a-zß-ÿ])|sg\W*_*\d*(?![a-zß-ÿ])|dms|strain|gauge|stress|dehnung|"
    r"spannung|tens[ãi]o|deforma|sigma|epsilon|mikrodehn",
}
"""What a name speaks of, where the unit says nothing; the first counts."""
_ENGINE = re.compile(
    r"(?i:engine|motor|verbrenner|crank|kurbelwelle|virabrequim|gomiti)"
    r"|(?<![A-Za-z])(?:[Ee]ng(?=[A-Z\W_])|(?i:mot|ice)(?![A-Za-z]))"
)
_SHAFT = re.compile(
    r"[kc]ardan|prop|shaft|welle|output|abtrieb|ausgang|sa[ií]da|uscita|albero|eixo", re.IGNORECASE
)
_OTHER_PART = re.compile(
    r"wheel|(?<![a-zß-ÿ])rad(?![a-z])|raddreh|roda|ruota|l(?:ü|ue)fter|(?<![a-z])fan|turb|yaw|"
    r"pitch|roll|(?<![a-z])wind|gyro|input|eingang|entrada|ingresso|pump|steer|lenk|brems|brak|"
    r"frei|freno", re.IGNORECASE,
)  # fmt: skip
"""Of what turns or is turned elsewhere than a propshaft."""
_STRAIN_IN_PERCENT = re.compile(r"strain|dehnung|deforma|epsilon", re.IGNORECASE)
_PRESSURE = re.compile(r"press(?!ure[\W_]*stress)|druck|boost|oil|(?<![a-z])p(?![a-z])", re.I)
"""Of a channel in kPa or Pa that is no stress of a gauge."""
_PRESSURE_WORD = re.compile(r"pressure(?![\W_]*stress)|druck(?!spannung)|press[ãi]o|hydraul", re.I)
"""Of one in any unit."""
_VEHICLE = re.compile(r"speed|veh|veloc|geschw|wheel|vel(?![a-z])|(?<![a-z])v(?![a-z])", re.I)
"""Of a channel in m/s that is no vibration."""


def guess_channel_role(channel: Channel) -> ChannelRole:
    """Return what a channel is by its unit, and its name where that says which: a guess.

    An engine's speed is in units of speed: its torque, or strain on its mount, is none.
    """
    unit, name = channel_unit(channel), channel.name
    measured = _role_of_unit(unit, name)
    if measured == "":
        return "" if unit not in AMPLIFIER_UNITS else _role_of_name(name, unit)
    if _ENGINE.search(name) and measured in ("speed", "torque"):
        return "engine" if measured == "speed" else ""
    return "" if measured in ("speed", "torque") and _OTHER_PART.search(name) else measured


def names_propshaft(channel: Channel) -> bool:
    """Return whether a channel's name speaks of a propshaft, or of the shaft it is driven by."""
    return _SHAFT.search(channel.name) is not None


def _role_of_unit(unit: str, name: str) -> ChannelRole:
    """Return what a unit measures; "" where it leaves that open."""
    if unit == "%":
        return "gauge" if _STRAIN_IN_PERCENT.search(name) else ""
    if (unit in ("kPa", "Pa") and _PRESSURE.search(name)) or _PRESSURE_WORD.search(name):
        return ""
    if unit in STRESS_UNITS or unit in STRAIN_UNITS:
        return "gauge"
    if unit in ROTATION_SPEED_UNITS and unit not in ("Hz", "1/s"):
        return "tacho" if _speaks_of(name, "tacho") else "speed"
    if unit in TORQUE_UNITS:
        return "torque"
    if unit in VEHICLE_SPEED_UNITS and (unit != "m/s" or _VEHICLE.search(name)):
        return "vehicle speed"
    low = unit.lower()
    if low in _TEMPERATURE_UNITS:
        return "temperature"
    if low in _ACCELERATION_UNITS:
        return "acceleration"
    return "gauge" if unit in ("mV/V", "V/V") else ""


def _role_of_name(name: str, unit: str) -> ChannelRole:
    """Return what a name speaks of, of a channel whose unit says nothing of it."""
    spoken: list[ChannelRole] = [role for role in _WORDS_BY_ROLE if _speaks_of(name, role)]
    found = spoken[0] if spoken else ""
    if found == "gear" and unit:
        return ""
    if found in ("", "speed") and _ENGINE.search(name):
        return "engine"
    elsewhere = _OTHER_PART.search(name) or (found == "torque" and _ENGINE.search(name))
    return "" if found in ("speed", "torque") and elsewhere else found


def _speaks_of(name: str, role: ChannelRole) -> bool:
    """Return whether a word of a name begins as one of a role."""
    words = rf"(?<![a-zß-ÿ])(?:{_WORDS_BY_ROLE[role]})"
    return re.search(words, name, re.IGNORECASE) is not None
