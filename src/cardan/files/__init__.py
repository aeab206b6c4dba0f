"""Files: applications, limit profiles and catalogues, read into parts; and written safely."""

from cardan.border.writer import write
from cardan.files.application import loads, read
from cardan.files.change import addresses, change
from cardan.files.limit import limits
from cardan.files.schema import schema
from cardan.files.starter import starter

__all__ = ["addresses", "change", "limits", "loads", "read", "schema", "starter", "write"]
