"""A recording on its way from the page: piece by piece into a file of ours, gone with the page.

The page says what it is called and how long it is; where it lies here only this module decides.
"""

import shutil
import tempfile
from base64 import b64decode
from binascii import Error
from pathlib import Path, PurePath

from cardan.core.errors import CardanError
from cardan.readers.dispatch import formats_by_extension
from cardan.schema.yaml_tree import replace_hidden_characters
from cardan.web.jobs import InvalidMessageError, Json, integer_field, text_field

MAX_UPLOAD_BYTES = 256_000_000
"""Bytes of a recording."""

MAX_CHUNK_CHARACTERS = 1_500_000
"""Letters of a piece: a megabyte, as base64."""


class Upload:
    """What one page has brought: one recording at a time."""

    def __init__(self) -> None:
        self.id, self.name, self.size, self.received_bytes = 0, "", 0, 0
        self._folder: Path | None = None

    def begin(self, said: Json) -> None:
        """Make ready for a recording, in place of what was brought before.

        Raises
        ------
        CardanError
            If none of that name or size is read.
        """
        self.close()
        self.id = integer_field(said, "id", 2**53)
        name, size = text_field(said, "name", 1000), integer_field(said, "size", 2**53)
        ending = PurePath(name).suffix.lower()
        if ending not in (known := formats_by_extension()):
            msg = f"no reader for {ending!r} files; known are {', '.join(sorted(known))}"
            raise CardanError(msg)
        if not size:
            msg = f"{replace_hidden_characters(name)} is empty"
            raise CardanError(msg)
        if size > MAX_UPLOAD_BYTES:
            most, of = MAX_UPLOAD_BYTES / 1e6, size / 1e6
            msg = f"a recording of {most:.0f} MB at most can be brought, not of {of:.0f}"
            raise CardanError(msg)
        self._folder = Path(tempfile.mkdtemp(prefix="cardan-"))
        self.name, self.size = (
            replace_hidden_characters(name.replace("\\", "/").rpartition("/")[2][:200]),
            size,
        )
        self._path.touch()

    def append_chunk(self, said: Json) -> None:
        """Take the next piece."""
        try:
            piece = b64decode(text_field(said, "data", MAX_CHUNK_CHARACTERS), validate=True)
        except (Error, ValueError):
            raise InvalidMessageError from None
        fits = bool(piece) and self.received_bytes + len(piece) <= self.size
        if (
            self._folder is None
            or integer_field(said, "at", 2**53) != self.received_bytes
            or not fits
        ):
            raise InvalidMessageError
        with self._path.open("ab") as file:
            file.write(piece)
        self.received_bytes += len(piece)

    @property
    def complete_file(self) -> Json | None:
        """Where it lies and what it is called; None where it has not come whole."""
        come = self._folder is not None and self.received_bytes == self.size
        return {"path": str(self._path), "name": self.name} if come else None

    @property
    def _path(self) -> Path:
        assert self._folder is not None
        return self._folder / f"recording{PurePath(self.name).suffix.lower()}"

    def close(self) -> None:
        """Throw away what was brought."""
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
        self.name, self.size, self.received_bytes, self._folder = "", 0, 0, None
