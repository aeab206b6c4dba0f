"""A recording on its way from the page: piece by piece into a file of ours, gone with the page.

The page says what it is called and how long it is; where it lies here nobody but us decides.
"""

import shutil
import tempfile
from base64 import b64decode
from binascii import Error
from pathlib import Path, PurePath

from cardan.base.errors import CardanError
from cardan.border.document import visible
from cardan.files.recordings import ENDINGS
from cardan.web.jobs import Json, Wrong, text, whole

MOST = 256_000_000
"""Bytes of a recording."""

PIECE = 1_500_000
"""Letters of a piece: a megabyte, as base64."""


class Parcel:
    """What one page has brought: one recording at a time."""

    def __init__(self) -> None:
        self.id, self.name, self.size, self.got = 0, "", 0, 0
        self._folder: Path | None = None

    def begin(self, said: Json) -> None:
        """Make ready for a recording, in place of what was brought before.

        Raises
        ------
        CardanError
            If none of that name or size is read.
        """
        self.close()
        self.id = whole(said, "id", 2**53)
        name, size = text(said, "name", 1000), whole(said, "size", 2**53)
        ending = PurePath(name).suffix.lower()
        if ending not in ENDINGS:
            msg = f"no reader for {ending!r} files; known are {', '.join(sorted(ENDINGS))}"
            raise CardanError(msg)
        if not size:
            msg = f"{visible(name)} is empty"
            raise CardanError(msg)
        if size > MOST:
            most, of = MOST / 1e6, size / 1e6
            msg = f"a recording of {most:.0f} MB at most can be brought, not of {of:.0f}"
            raise CardanError(msg)
        self._folder = Path(tempfile.mkdtemp(prefix="cardan-"))
        self.name, self.size = visible(name.replace("\\", "/").rpartition("/")[2][:200]), size
        self._file.touch()

    def take(self, said: Json) -> None:
        """Take the next piece."""
        try:
            piece = b64decode(text(said, "data", PIECE), validate=True)
        except (Error, ValueError):
            raise Wrong from None
        fits = bool(piece) and self.got + len(piece) <= self.size
        if self._folder is None or whole(said, "at", 2**53) != self.got or not fits:
            raise Wrong
        with self._file.open("ab") as file:
            file.write(piece)
        self.got += len(piece)

    @property
    def here(self) -> Json | None:
        """Where it lies and what it is called; None where it has not come whole."""
        come = self._folder is not None and self.got == self.size
        return {"path": str(self._file), "name": self.name} if come else None

    @property
    def _file(self) -> Path:
        assert self._folder is not None
        return self._folder / f"recording{PurePath(self.name).suffix.lower()}"

    def close(self) -> None:
        """Throw away what was brought."""
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
        self.name, self.size, self.got, self._folder = "", 0, 0, None
