"""Words for what analyses of recordings find: their physics gives codes and values only."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from cardan.core.finding import Finding
from cardan.core.message import TranslatableMessage, translatable_message
from cardan.core.units import MPa
from cardan.physics.signals.attribution_result import (
    DOUBT_BUMP_STOP_IMPACTS,
    DOUBT_CONSTANT_FREQUENCY,
    DOUBT_DAMAGE_WITHOUT_SPEED,
    DOUBT_DATA_REJECTED,
    DOUBT_DOUBLE_SPEED,
    DOUBT_ENGINE_ORDER_OVERLAP,
    DOUBT_HALF_SPEED,
    DOUBT_INTERMITTENT_SIDEBANDS,
    DOUBT_LINE_RESTS_ON_BUMP_STOP,
    DOUBT_NEGATIVE_SPEED,
    DOUBT_NO_ENGINE_SPEED,
    DOUBT_NO_RELIABLE_SHAFT_ANGLE,
    DOUBT_NO_TORQUE,
    DOUBT_ORDER_6_SUGGESTS_RATTLE,
    DOUBT_RESPONSE_STEP,
    DOUBT_SHAFT_ANGLE_MAY_SLIP,
    DOUBT_SHAFT_STOPPED,
    DOUBT_SHORT_TORQUE_PULSE,
    DOUBT_SIDEBANDS,
    DOUBT_SPEED_MISSING,
    DOUBT_SPEED_OF_OTHER_SHAFT,
    DOUBT_SPEED_SCALE,
    DOUBT_SPEEDS_SWAPPED,
    DOUBT_TORQUE_INDEPENDENT,
    DOUBT_WEAK_SYNCHRONOUS_PART,
)
from cardan.physics.signals.cause_assessment import (
    DOUBT_ENGINE_AT_SHAFT_SPEED,
    DOUBT_ENGINE_SPEED_NOT_GIVEN,
    DOUBT_OF_NAMED_GAUGE,
    DOUBT_ORDERS_COINCIDE,
    DOUBT_TORQUE_NOT_GIVEN,
)
from cardan.physics.signals.conditioning import FINDING_DEAD
from cardan.physics.signals.data_quality import (
    DOUBT_DAMAGE_ABOVE_FAILURE,
    DOUBT_STRAIN_NAMED_AS_STRESS,
    DOUBT_STRESS_NAMED_AS_STRAIN,
    REASON_ABOVE_TENSILE_STRENGTH,
    REASON_INTERPOLATED,
    REASON_RATE_TOO_HIGH,
    REASON_RATE_TOO_LOW,
    REASON_RATE_TOO_LOW_FOR_SPEED,
    REASON_STRESS_TOO_HIGH,
    REASON_STRESS_TOO_LOW,
    REASON_STUCK_BIT,
)

CHANNEL_PHRASES = {
    FINDING_DEAD.code: "dead: it never changes",
    "hole": "samples missing: {samples} ({share}), longest hole {hole} s",
    "sentinel": (
        "samples with a logger's number for no value: {samples}; places: {places}, the "
        "first at {first} s"
    ),
    "spike": "samples like spikes: {samples}; places: {places}, the first at {first} s",
    "dropout": "samples like dropouts: {samples}; places: {places}, the first at {first} s",
    "clip": "samples that look clipped: {samples}; places: {places}, the first at {first} s",
    "freeze": "samples standing still: {samples}; places: {places}, the first at {first} s",
    "zero-step": "steps of the zero: {places}, the first at {first} s",
    "gain": "changes of the gain: {places}, the first at {first} s",
    "response": (
        "stops responding, wholly or above a frequency, while another gauge goes on, or its "
        "values lose their step; places: {places}, the first at {first} s"
    ),
    "noise": (
        "samples of white noise, as of a contact that chatters: {samples}; places: "
        "{places}, the first at {first} s"
    ),
    "repeat": (
        "samples that were there before, to the last digit: {samples}; places: {places}, "
        "the first at {first} s"
    ),
    "drift": "drifts by {drift} from its first tenth to its last",
    "hum": "a steady tone of {frequency} Hz, amplitude {size}, as the mains hum",
}
"""What is said of a channel, by the kind of fault."""

OTHER_FAULT_PHRASE = "samples that look wrong: {samples}; places: {places}, the first at {first} s"
"""What is said of a kind of fault without a phrase of its own."""

INTERVAL_PHRASES = {
    DOUBT_NO_RELIABLE_SHAFT_ANGLE.code: (
        "the speed gives no angle to trust: all that is near order 2 may be theirs"
    ),
    DOUBT_NO_TORQUE.code: (
        "no torque shows when the joints pull: all that is near order 2 may be the joints'"
    ),
    DOUBT_WEAK_SYNCHRONOUS_PART.code: (
        "little is locked to the shaft: the interval is wider by a tenth"
    ),
    DOUBT_SHAFT_ANGLE_MAY_SLIP.code: (
        "what is locked does not explain the large cycles: the angle may slip"
    ),
    DOUBT_ORDER_6_SUGGESTS_RATTLE.code: (
        "order 6 is locked too, as of rattling contact: they may have done more"
    ),
    DOUBT_ENGINE_ORDER_OVERLAP.code: (
        "an engine order coincides with order 2, and phase and torque do not separate them: the "
        "interval counts what may be the engine's"
    ),
    DOUBT_NO_ENGINE_SPEED.code: (
        "no engine speed and no engine orders are given: an engine of four cylinders in "
        "direct gear does the same as the joints"
    ),
    DOUBT_TORQUE_INDEPENDENT.code: (
        "order 2 is the same whatever the torque, and what joints do goes with it: a "
        "wheel's, a bent flange's, or is the torque another's?"
    ),
    DOUBT_RESPONSE_STEP.code: (
        "order 2 per torque is {factor} times as large from about {time} s on: if the gauge's gain "
        "changed there, and not the line, the damage may be {low} to {high} times that shown"
    ),
    DOUBT_CONSTANT_FREQUENCY.code: (
        "neither speed nor torque changes: a tone of its own, of a pump or a fan, would do "
        "the same as the joints"
    ),
    DOUBT_DOUBLE_SPEED.code: (
        "what goes with the torque turns at twice the speed given: is it the shaft's own?"
    ),
    DOUBT_HALF_SPEED.code: (
        "what goes with the torque turns at half the speed given: is it the shaft's own?"
    ),
    DOUBT_SPEED_SCALE.code: (
        "more is locked near the orders of the speed given: is its scale wrong, as by a number "
        "of teeth, or does something else turn there?"
    ),
    DOUBT_SPEED_OF_OTHER_SHAFT.code: (
        "what is locked goes with another scale of the speed, and at that one an order of "
        "the wheels lies, or the engine in direct gear says that the speed is right: it may "
        "be another's"
    ),
    DOUBT_SIDEBANDS.code: (
        "more is close to order 2 than farther off: angles that vary with the suspension "
        "may hide the joints"
    ),
    DOUBT_INTERMITTENT_SIDEBANDS.code: (
        "what stands about order 2 comes and goes with it, though nothing is locked: angles "
        "that ride may hide them"
    ),
    DOUBT_SHORT_TORQUE_PULSE.code: (
        "the damage comes with a torque of a few seconds: too short to find its cause"
    ),
    DOUBT_BUMP_STOP_IMPACTS.code: (
        "blows come where order 2 is loud, as of a stop that it reaches: they may be theirs"
    ),
    DOUBT_LINE_RESTS_ON_BUMP_STOP.code: (
        "crests rise and fall with the torque, as of a stop that the line stands on: no road "
        "does that"
    ),
    DOUBT_SHAFT_STOPPED.code: (
        "by its speed the shaft hardly turned: what does the damage is locked to nothing "
        "that is known"
    ),
    DOUBT_NEGATIVE_SPEED.code: (
        "the shaft's speed is negative for a third of the time under way or more: reverse, or "
        "not the quantity it is taken for"
    ),
    DOUBT_SPEED_MISSING.code: (
        "for a third of the time under way and more nothing says how fast the shaft turned: "
        "its speed is missing, or stands still while the engine's changes"
    ),
    DOUBT_SPEEDS_SWAPPED.code: (
        "the engine turns at less than six tenths of the shaft's speed, as in no gear: are "
        "the two swapped, or is one wrong?"
    ),
    DOUBT_DAMAGE_WITHOUT_SPEED.code: (
        "damage was done while nothing said how fast the shaft turned: all of that may be theirs"
    ),
    DOUBT_DATA_REJECTED.code: (
        "data rejected (review needed): the cause depends on what spoiled the recording"
    ),
}
"""Why the interval of what the joints did is wider, or says nothing."""

CAUSE_PHRASES = {
    DOUBT_ORDERS_COINCIDE.code: (
        "{one} order {order} and {other} order {second} run together for {share} of the time: "
        "nothing in the signal separates them there"
    ),
    DOUBT_OF_NAMED_GAUGE.code: "{gauge}: {doubt}",
    DOUBT_ENGINE_SPEED_NOT_GIVEN.code: (
        "no engine speed was given: an engine order that coincides with order 2 would not show"
    ),
    DOUBT_ENGINE_AT_SHAFT_SPEED.code: (
        "the engine turns with the shaft for {share} of the time: one whose order 2 is "
        "strong, of four cylinders, would do the same as the joints"
    ),
    DOUBT_TORQUE_NOT_GIVEN.code: (
        "no torque was given: only the phase separates the joints from other causes"
    ),
}
"""Why a cause is left open."""

QUALITY_PHRASES = {
    REASON_STRESS_TOO_HIGH.code: (
        "{size} MPa of stress, more than any metal bears ({most} MPa): are its numbers in "
        "another unit?"
    ),
    REASON_STRESS_TOO_LOW.code: (
        "it moves by {size} MPa in all, less than a gauge's noise ({least} MPa): are its "
        "numbers in another unit?"
    ),
    REASON_RATE_TOO_LOW.code: (
        "{rate} samples a second, fewer than a driveline's stress takes ({least}): what "
        "moves between them is lost; or does its clock count something else than seconds "
        "(--time CLOCK:ms)?"
    ),
    REASON_INTERPOLATED.code: (
        "lines go from one to the next of {rate} samples a second, fewer than {least}: what "
        "moves between them is lost, unless they are all its turns"
    ),
    REASON_RATE_TOO_HIGH.code: (
        "{rate} samples a second, more than a strain gauge has: does its clock count "
        "something else (--time CLOCK:s)?"
    ),
    REASON_RATE_TOO_LOW_FOR_SPEED.code: (
        "the shaft's order 2 reaches {frequency} Hz, and {rate} samples a second hold what "
        "is below {most} Hz: larger cycles may have happened between them"
    ),
    REASON_ABOVE_TENSILE_STRENGTH.code: (
        "its crests reach {size} MPa, and the tensile strength that was given is {ultimate} "
        "MPa: no part bore both"
    ),
    DOUBT_DAMAGE_ABOVE_FAILURE.code: (
        "in this recording alone the damage is {times} times what breaks the part: if it did "
        "not break, unit, scale or S-N curve are not its own"
    ),
    DOUBT_STRESS_NAMED_AS_STRAIN.code: (
        "its name speaks of strain, and it is taken for a stress in {unit}"
    ),
    DOUBT_STRAIN_NAMED_AS_STRESS.code: (
        "its name speaks of stress, and it is taken for a strain in {unit}"
    ),
    REASON_STUCK_BIT.code: (
        "each second band of {width} of its values is empty: a bit of the converter stands still"
    ),
}
"""Why a gauge's answer cannot be true, or is doubtful."""

PHRASES: Mapping[str, str] = {
    **CHANNEL_PHRASES,
    **INTERVAL_PHRASES,
    **CAUSE_PHRASES,
    **QUALITY_PHRASES,
}
"""English templates by the code of a finding."""


def _number(format_spec: str, *, unit: float = 1.0) -> Callable[[Any], str]:
    return lambda value: format(value / unit, format_spec)


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def _missing(*, missing: int, samples: int, longest: float) -> dict[str, object]:
    share = f"{100 * missing / samples:.2f} %"
    return {"samples": missing, "share": share, "hole": f"{longest:.3g}"}


def _drift(*, drift: float, unit: str) -> dict[str, object]:
    return {"drift": f"{drift:.4g} {unit}".rstrip()}


def _hum(*, size: float, unit: str, frequencies: Iterable[float]) -> dict[str, object]:
    return {
        "frequency": ", ".join(f"{f:g}" for f in frequencies),
        "size": f"{size:.3g} {unit}".rstrip(),
    }


_VALUE_SETS: Mapping[str, Callable[..., dict[str, object]]] = {
    "hole": _missing, "drift": _drift, "hum": _hum
}  # fmt: skip
"""What a template takes that is made of several values."""

_FORMATS: Mapping[str, Mapping[str, Callable[[Any], object]]] = {
    REASON_STRESS_TOO_HIGH.code: {
        "size": _number(".3g", unit=MPa), "most": _number("g", unit=MPa)
    },
    REASON_STRESS_TOO_LOW.code: {
        "size": _number(".2g", unit=MPa), "least": _number("g", unit=MPa)
    },
    REASON_ABOVE_TENSILE_STRENGTH.code: {
        "size": _number(".4g", unit=MPa), "ultimate": _number("g", unit=MPa)
    },
    REASON_INTERPOLATED.code: {"rate": _number(".2g"), "least": _number(".3g")},
    REASON_RATE_TOO_LOW.code: {"rate": _number(".4g"), "least": _number("g")},
    REASON_RATE_TOO_HIGH.code: {"rate": _number(".4g")},
    REASON_RATE_TOO_LOW_FOR_SPEED.code: {
        "frequency": _number(".3g"), "rate": _number(".4g"), "most": _number(".3g")
    },
    REASON_STUCK_BIT.code: {"width": _number(".3g")},
    DOUBT_DAMAGE_ABOVE_FAILURE.code: {"times": _number(".3g")},
    DOUBT_RESPONSE_STEP.code: {
        "time": _number(".3g"), "factor": _number(".2f"), "low": _number(".2g"),
        "high": _number(".2g"),
    },
    DOUBT_ORDERS_COINCIDE.code: {
        "order": _number("g"), "second": _number("g"), "share": _percent
    },
    DOUBT_ENGINE_AT_SHAFT_SPEED.code: {"share": _percent},
}  # fmt: skip
"""How each value is written; as it is where nothing stands here."""
_PLACE_FORMATS: Mapping[str, Callable[[Any], object]] = {"first": _number(".6g")}
"""How the values of a fault with places are written."""


def finding_message(of: Finding) -> TranslatableMessage:
    """Return the sentence of a finding."""
    values = dict(of.values)
    if of.code in _VALUE_SETS:
        return translatable_message(PHRASES[of.code], **_VALUE_SETS[of.code](**values))
    formats = _FORMATS.get(of.code, _PLACE_FORMATS)
    filled = {
        name: finding_message(value)
        if isinstance(value, Finding)
        else formats.get(name, _as_it_is)(value)
        for name, value in values.items()
    }
    return translatable_message(PHRASES.get(of.code, OTHER_FAULT_PHRASE), **filled)


def finding_messages(of: Iterable[Finding]) -> tuple[TranslatableMessage, ...]:
    """Return the sentences of findings, each once."""
    return tuple(dict.fromkeys(map(finding_message, of)))


def _as_it_is(value: object) -> object:
    return value
