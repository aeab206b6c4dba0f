"""Where a number comes from."""

from dataclasses import replace

from cardan.base.frozen import dataclass

HOW_READ = ("re-read", "by definition", "second hand", "from memory", "assumed")
"""How somebody came to a number, the surest first: read in the publisher's own text, true by
what the quantity is, read in a transcription, believed to stand there, our own choice."""


@dataclass(frozen=True, slots=True)
class Source:
    """A publication or an agreement, with the place in it: `AE7.at("p. 50")`.

    `how_read` is a word of `HOW_READ`, empty where nobody said; `apart` are the values that
    were read otherwise, by name: of a limit `normal`, `maximum` or `band`, of a catalogue's
    row the key without its unit.
    """

    title: str
    place: str = ""
    how_read: str = ""
    apart: tuple[tuple[str, str], ...] = ()

    def at(self, place: str) -> "Source":
        """Return the same source, opened at a page, section or equation."""
        return replace(self, place=place)

    def of(self, value: str) -> "Source":
        """Return the source of one of its values."""
        return Source(self.title, self.place, dict(self.apart).get(value, self.how_read))

    def __str__(self) -> str:
        """Return title and place as a reader would write them."""
        return f"{self.title}, {self.place}" if self.place else self.title


AE7 = Source("SAE AE-7, Universal Joint and Driveshaft Design Manual")
J3311 = Source("Dana Spicer J3311-1, Driveshaft application guidelines")
GWB = Source("Dana GWB, Cardan shafts for industrial applications, catalogue")
SEHERR = Source("Seherr-Thoss, Schmelz & Aucktor, Universal Joints and Driveshafts, 2nd ed. 2006")
IIW = Source("Hobbacher, IIW Recommendations for Fatigue Design of Welded Joints, 2016")
SOUZA = Source("Souza, Analysis of the failure of a cardan bearing bracket, Unesp 2014")
E2 = Source("PME 2540 Automotive Engineering, exercise E2")
OMAR = Source("ITIS Omar, Il giunto di Cardano")
ELBE = Source("Elbe, Cardan shaft catalogue")
ISO21940 = Source("ISO 21940-11, Mechanical vibration: rotor balancing")
GILLESPIE = Source("Gillespie, Fundamentals of Vehicle Dynamics, SAE 1992")
WONG = Source("Wong, Theory of Ground Vehicles, 4th ed. 2008")
HS788 = Source("SAE HS-788, Manual on Design and Application of Leaf Springs")
ASOKANTHAN = Source("Asokanthan & Hwang, J. Vib. Acoust. 118 (1996) 368-374")
MAZZEI = Source("Mazzei, Argento & Scott, J. Sound Vib. 222 (1999) 19-47")
ASTM_E1049 = Source("ASTM E1049-85 (2017), Standard practices for cycle counting in fatigue")
MINER = Source("Miner, Cumulative damage in fatigue, J. Appl. Mech. 12 (1945)")
WIRSCHING = Source("Wirsching, Fatigue reliability for offshore structures, ASCE 1984")
SHAPLEY = Source("Shapley, A value for n-person games, 1953")
VDI2230 = Source("VDI 2230 part 1, Systematic calculation of highly stressed bolted joints, 2015")
DERIVED = Source("Derived from first principles")
ASSUMED = Source("Assumed: not given in the application")
