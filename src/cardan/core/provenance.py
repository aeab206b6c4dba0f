"""Where a number comes from."""

import re
from dataclasses import replace

from cardan.core.lazy_dataclass import dataclass

PROVENANCE_CODES = ("re-read", "by definition", "second hand", "from memory", "assumed")
"""How a number was obtained, the surest first: read in the publisher's own text, true by
what the quantity is, read in a transcription, believed to stand there, our own choice."""

_PROVENANCE_WORDS = {"re-read": "checked", "second hand": "quoted", "from memory": "unverified"}
_PROVENANCE_CODE = re.compile("|".join(_PROVENANCE_WORDS))


def provenance_text(code: str) -> str:
    """Return how a number was read, in the words shown: checked, quoted, unverified, assumed.

    A code may stand within a remark: `re-read, slope computed`.
    """
    return _PROVENANCE_CODE.sub(lambda found: _PROVENANCE_WORDS[found[0]], code)


@dataclass(frozen=True, slots=True)
class Source:
    """A publication or an agreement, with the place in it: `AE7.at("p. 50")`.

    `how_read` is a word of `PROVENANCE_CODES`, empty if not given; `apart` are the values that
    were read otherwise, by name: of a limit `normal`, `maximum` or `band`, of a catalogue's
    row the key without its unit.
    """

    title: str
    place: str = ""
    how_read: str = ""
    apart: tuple[tuple[str, str], ...] = ()

    def with_place(self, place: str) -> "Source":
        """Return the same source, opened at a page, section or equation."""
        return replace(self, place=place)

    def source_of_value(self, value: str) -> "Source":
        """Return the source of one of its values."""
        return Source(self.title, self.place, dict(self.apart).get(value, self.how_read))

    def __str__(self) -> str:
        """Return title and place as a reader would write them."""
        return f"{self.title}, {self.place}" if self.place else self.title


SAE_AE7 = Source("SAE AE-7, Universal Joint and Driveshaft Design Manual")
SPICER_J3311 = Source("Dana Spicer J3311-1, Driveshaft application guidelines")
GWB_CATALOGUE = Source("Dana GWB, Cardan shafts for industrial applications, catalogue")
SEHERR_THOSS_2006 = Source(
    "Seherr-Thoss, Schmelz & Aucktor, Universal Joints and Driveshafts, 2nd ed. 2006"
)
IIW_2016 = Source("Hobbacher, IIW Recommendations for Fatigue Design of Welded Joints, 2016")
SOUZA_2014_BRACKET_FAILURE = Source(
    "Souza, Analysis of the failure of a cardan bearing bracket, Unesp 2014"
)
PME2540_AUTOMOTIVE_COURSE_EXERCISE_E2 = Source("PME 2540 Automotive Engineering, exercise E2")
ELBE_CATALOGUE = Source("Elbe, Cardan shaft catalogue")
ISO_21940_11 = Source("ISO 21940-11, Mechanical vibration: rotor balancing")
GILLESPIE_1992 = Source("Gillespie, Fundamentals of Vehicle Dynamics, SAE 1992")
WONG_2008 = Source("Wong, Theory of Ground Vehicles, 4th ed. 2008")
ASOKANTHAN_HWANG_1996 = Source("Asokanthan & Hwang, J. Vib. Acoust. 118 (1996) 368-374")
MAZZEI_1999 = Source("Mazzei, Argento & Scott, J. Sound Vib. 222 (1999) 19-47")
ASTM_E1049 = Source("ASTM E1049-85 (2017), Standard practices for cycle counting in fatigue")
MINER_1945 = Source("Miner, Cumulative damage in fatigue, J. Appl. Mech. 12 (1945)")
WIRSCHING_1984 = Source("Wirsching, Fatigue reliability for offshore structures, ASCE 1984")
SHAPLEY_1953 = Source("Shapley, A value for n-person games, 1953")
VDI_2230_2015 = Source(
    "VDI 2230 part 1, Systematic calculation of highly stressed bolted joints, 2015"
)
SOURCE_DERIVED = Source("Derived from first principles")
SOURCE_ASSUMED = Source("Assumed: not given in the application")
