"""Files: applications, limit profiles and catalogues, read into parts."""

from cardan.files.application import loads, read
from cardan.files.change import addresses, change
from cardan.files.cycle import cycle
from cardan.files.limit import limits
from cardan.files.origin import located, place
from cardan.files.schema import schema
from cardan.files.starter import starter

__all__ = [
    "addresses", "change", "cycle", "limits", "loads", "located", "place", "read", "schema",
    "starter",
]  # fmt: skip
