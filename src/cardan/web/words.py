"""What the workbench says, from the catalogues that every medium reads.

The front names a text by its English wording, as everywhere in the house; a test holds the
two lists against each other.
"""

from typing import Any

from cardan.base.units import mm
from cardan.files.catalogue import Kind, find, shipped
from cardan.quantity.quantities import QUANTITIES
from cardan.report.language import CODES, Language
from cardan.report.wording import cited

KINDS: tuple[Kind, ...] = ("joint", "tube")

WORDS: tuple[str, ...] = (
    "Colours",
    "Corrections",
    "Drawing",
    "Drawn behind",
    "Equation",
    "Everything passes.",
    "File",
    "Files",
    "Fill in the slopes and lengths: the verdict follows.",
    "Force",
    "Force by gear and speed: choose with the arrow keys",
    "Force on bearings over speed",
    "From a protractor's readings",
    "How the joints add up: equivalent angle {angle} deg",
    "Joints",
    "Language",
    "Limits by state",
    "Limits of use",
    "Line",
    "Look from",
    "Make a file of it",
    "Map of two moves",
    "Map of two moves: choose with the arrow keys",
    "New",
    "Notes",
    "Nothing that may move changes anything for the better.",
    "One standard deviation each, about what the file says; assumed.",
    "Orders of the force over speed, {gear}",
    "Parts",
    "Paste the joints' points from a spreadsheet",
    "Pin a variant, change something, and both stand side by side here.",
    "Pin this variant",
    "Resonances",
    "Save",
    "Shown is the last that could be read: {why}",
    "Side view, from the left",
    "Source of the equation",
    "Source of the limit",
    "Speed",
    "State",
    "Sum of the joints",
    "The file",
    "The file cannot be read as it is: see what is wrong below.",
    "The file gives no suspension: there is no travel to show.",
    "The file was changed on disk while there are unsaved edits here.",
    "The file was changed on disk, and is shown as it is now.",
    "The line by",
    "The line has no centre bearing, or nothing says its torque over speed.",
    "The line in three dimensions",
    "The whole vehicle in torsion, and its launches",
    "There are no two things to move.",
    "There is no application file in this folder; `cardan new` writes one.",
    "This browser draws nothing in three dimensions.",
    "This page does not know the workbench: open the address that `cardan serve` printed.",
    "Top view",
    "Torque, winding the axle up",
    "Travel",
    "Variants",
    "Variants side by side",
    "Verdict",
    "Vibration and stability",
    "Views",
    "What it comes to",
    "What remains under tolerances",
    "What to change",
    "What was not saved last time is here again; undo goes back to the file.",
    "What would help",
    "Without an answer",
    "Without bearing forces sought over all speeds.",
    "Yoke phases",
    "[deg] over deg",
    "above",
    "across {times} times as large",
    "angle",
    "apply it, pin what is",
    "as shown",
    "as the system",
    "aside",
    "ask",
    "asking …",
    "axes",
    "bearing ahead of the rear joint",
    "bearing forces follow …",
    "bearings",
    "cases by their smallest margin",
    "centre bearing {n}",
    "clearance",
    "close",
    "coast",
    "connection lost",
    "cost",
    "dark",
    "drive",
    "drop variant {n}",
    "each move alone; a click makes it",
    "elastic limit",
    "equivalent angle",
    "equivalent angle over the phase of shaft {n}",
    "every joint",
    "fail",
    "fatigue",
    "file",
    "force [N]",
    "force on the bearings [N] over time [s]",
    "frequency [Hz] over the shaft's speed [rpm]",
    "gear",
    "gearbox",
    "gearbox slope",
    "height",
    "in steps of {step}",
    "joint",
    "joint angles [deg]",
    "joint {n}",
    "jounce",
    "largest force",
    "largest torque [N·m]",
    "largest {peak} N·m, T i {target} N·m",
    "length",
    "lengths in",
    "light",
    "light: the other states; dashed: as installed",
    "limit",
    "limits",
    "line",
    "look for corrections",
    "margin",
    "margin against cost",
    "margin in %, where it is smallest",
    "margin {margin} % after {before} %, cost {cost}",
    "may be built ({low} to {high} %, of {count} tried)",
    "move it there",
    "name of variant {n}",
    "not saved",
    "nothing behind",
    "nothing that can be moved alone",
    "of the catalogue, with their ratings",
    "of the file as it was",
    "order {order}",
    "outside",
    "over the shaft's speed [rpm]",
    "over the torque [N·m]",
    "over the travel [mm]",
    "part",
    "phase [deg]",
    "phase of shaft {n}: drag, or use the arrow keys",
    "pinion",
    "pinion slope",
    "plane at",
    "points, pasted from a spreadsheet",
    "put them in",
    "rebound",
    "redo",
    "save mine over it",
    "seen from the gearbox",
    "shaft {n}",
    "shafts",
    "side and top",
    "side slope [deg]",
    "side view",
    "size",
    "slopes and lengths",
    "slopes down to the rear are positive, to the right too",
    "speed",
    "speed over the gearbox's, less 1 [%], round the turn [deg]",
    "spline travel",
    "squared angles, deg²",
    "still",
    "stop",
    "stopped",
    "take it",
    "take the file; undo keeps mine",
    "the left",
    "the rear",
    "title",
    "to scale",
    "to the page",
    "to the right",
    "to the side",
    "top slope [deg]",
    "top speed [rpm]",
    "top view",
    "torque",
    "torque of the first shaft [N·m] over time [s]",
    "try {count}",
    "tube",
    "tube of shaft {n}",
    "tyres slide",
    "undo",
    "up",
    "value",
    "warn",
    "what may move",
    "what shakes it",
    "where an order meets a frequency is resonance",
    "where the sliders have it",
    "with bearing forces over all speeds: takes longer",
    "worst first",
    "x ahead, y to the left, z up",
    "x to the rear, y to the right, z up",
    "x, y and z of every joint, a row each, gearbox first",
    "{count} more that pass",
    "{count} unanswered",
    "{part}, {way}: drag, or use the arrow keys",
)


def texts(say: Language) -> dict[str, str]:
    """Return every text of the front by its English wording."""
    return {word: say(word) for word in WORDS}


def quantities(say: Language) -> dict[str, dict[str, Any]]:
    """Return what each quantity is: symbol, equation, where it stands, source, limits of use."""
    return {
        q.key: {
            "name": say.name(q.key),
            "symbol": q.symbol,
            "unit": q.unit_name,
            "equation": say.given(q.stated),
            "where": [[symbol, say.given(meaning)] for symbol, meaning in q.where.items()],
            "use": say.given(q.use) if q.use else "",
            "source": cited(q.source, say),
        }
        for q in QUANTITIES.values()
    }


def catalogue() -> dict[str, list[dict[str, Any]]]:
    """Return the joints and tubes that come with the program, with what they are chosen by."""

    def shown(value: float | None, unit: float = 1.0) -> float | None:
        return None if value is None else float(f"{value / unit:.6g}")

    found = {kind: [find(name, kind) for name in shipped(kind).rows] for kind in KINDS}
    return {
        "joints": [
            {
                "name": j.name,
                "series": j.series,
                "peak_Nm": shown(j.peak_torque),
                "reversing_Nm": shown(j.reversing_torque),
                "bearing_Nm": shown(j.bearing_torque),
            }
            for j in found["joint"]
        ],
        "tubes": [
            {"name": name, "outer_mm": shown(tube.outer, mm), "wall_mm": shown(tube.wall, mm)}
            for name, tube in zip(shipped("tube").rows, found["tube"], strict=True)
        ],
    }


def languages() -> list[str]:
    """Return the codes of the languages there are."""
    return list(CODES)
