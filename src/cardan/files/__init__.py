"""Files: applications, limit profiles and catalogues, read into parts; and written safely."""

from cardan.files.application import loads, read
from cardan.files.cycle import cycle
from cardan.files.limit import limits
from cardan.files.origin import located, place
from cardan.files.schema import schema
from cardan.files.starter import starter, write

__all__ = ["cycle", "limits", "loads", "located", "place", "read", "schema", "starter", "write"]
