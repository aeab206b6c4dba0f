"""A recording on its way from the page: piece by piece into a file of ours, gone with the page.

The page says what it is called and how long it is; where it lies here is decided by this module.
CAN databases that it brings before a log decode that log, and go with it.
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


DATABASE_ENDING = ".dbc"
"""Of a CAN database, by which the frames of a log are decoded."""

MAX_DATABASES = 8
"""Databases of one log: a bus has two or three."""


class Upload:
    """What one page has brought: one recording at a time, and the databases of its frames."""

    def __init__(self) -> None:
        self.id, self.name, self.size, self.received_bytes = 0, "", 0, 0
        self._folder: Path | None = None
        self._databases: list[Path] = []

    def begin(self, said: Json) -> None:
        """Make ready for a recording in place of what was brought before, or for its database.

        Raises
        ------
        CardanError
            If none of that name or size is read.
        """
        self.id = integer_field(said, "id", 2**53)
        name, size = text_field(said, "name", 1000), integer_field(said, "size", 2**53)
        ending = PurePath(name).suffix.lower()
        if not self._holds_databases_alone:
            self.close()
        if ending not in (known := {*formats_by_extension(), DATABASE_ENDING}):
            msg = f"no reader for {ending!r} files; known are {', '.join(sorted(known))}"
            raise CardanError(msg)
        if ending == DATABASE_ENDING and len(self._databases) == MAX_DATABASES:
            msg = f"a log has {MAX_DATABASES} CAN databases at most"
            raise CardanError(msg)
        if not size:
            msg = f"{replace_hidden_characters(name)} is empty"
            raise CardanError(msg)
        if size > MAX_UPLOAD_BYTES:
            most, of = MAX_UPLOAD_BYTES / 1e6, size / 1e6
            msg = f"a recording of {most:.0f} MB at most can be brought, not of {of:.0f}"
            raise CardanError(msg)
        self._folder = self._folder or Path(tempfile.mkdtemp(prefix="cardan-"))
        self.name, self.size, self.received_bytes = (
            replace_hidden_characters(name.replace("\\", "/").rpartition("/")[2][:200]),
            size,
            0,
        )
        if ending == DATABASE_ENDING:
            self._databases.append(self._folder / f"database-{len(self._databases)}.dbc")
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
        """Where the recording and its databases lie, and its name; None until it is whole."""
        if self._folder is None or self._is_database or self.received_bytes != self.size:
            return None
        return {
            "path": str(self._path), "name": self.name, "databases": [*map(str, self._databases)],
        }  # fmt: skip

    @property
    def _is_database(self) -> bool:
        return PurePath(self.name).suffix.lower() == DATABASE_ENDING

    @property
    def _holds_databases_alone(self) -> bool:
        """Whether all that is here are whole databases: they are of the log that follows."""
        return self._folder is not None and self._is_database and self.received_bytes == self.size

    @property
    def _path(self) -> Path:
        assert self._folder is not None
        if self._is_database:
            return self._databases[-1]
        return self._folder / f"recording{PurePath(self.name).suffix.lower()}"

    def close(self) -> None:
        """Throw away what was brought."""
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
        self.name, self.size, self.received_bytes, self._folder = "", 0, 0, None
        self._databases = []
