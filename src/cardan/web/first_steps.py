"""What an empty view needs and shows: libraries that are not installed, and an example."""

from importlib.util import find_spec
from typing import NamedTuple

from cardan.render.i18n import Translator

_BRACKET_EXAMPLE = """
bracket:                          # {example}
  bearing: 1
  u_shape: {{seat_diameter_mm: 120, width_mm: 64, thickness_mm: 5, height_mm: 120, flange_mm: 50,
            bend_radius_mm: 8, bolt_diameter_mm: 11, bolt_pitch_mm: 36}}
  material: LNE380
  carried_mass_kg: 32
  rubber_N_mm: [150, 120, 200]    # {axes}
"""


def bracket_example(say: Translator) -> str:
    """Return a bracket's section of an application file, to be put behind what is there."""
    return _BRACKET_EXAMPLE.format(
        example=say("an example: replace its values by those of your drawing"),
        axes=say("along, across, up"),
    )


class OptionalLibrary(NamedTuple):
    """A library that comes with an extra of cardan, and what cannot be read or solved without."""

    module: str
    extra: str
    use: str


OPTIONAL_LIBRARIES = (
    OptionalLibrary("h5py", "recordings", "HDF5, MATLAB 7.3"),
    OptionalLibrary("nptdms", "recordings", "TDMS"),
    OptionalLibrary("asammdf", "mdf", "MDF4"),
    OptionalLibrary("imctermite", "famos", "imc FAMOS"),
    OptionalLibrary("ngsolve", "bracket", "bracket"),
)
"""CSV, Parquet and all other recordings need nothing but the workbench's own extra."""


def missing_libraries() -> list[dict[str, str]]:
    """Return the use and the extra of each optional library that is not installed."""
    return [
        {"use": library.use, "extra": library.extra}
        for library in OPTIONAL_LIBRARIES
        if find_spec(library.module) is None
    ]
