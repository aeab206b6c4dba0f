"""Revisions: texts that were frozen, what they name kept beside them, and what became of that.

What a text names of its folder is copied, the smallest first, up to `HEAVIEST`. What is heavier,
recordings of gigabytes, is given a second name instead: that takes no room and no time, and the
file stays where its first name is thrown away or goes to another. Only who writes into the file
itself changes both; so what each holds when it is frozen is written down, as `sha256sum -c`
reads it, and who asks what changed since is told.
"""

import hashlib
import os
import shutil
from contextlib import suppress
from dataclasses import replace
from datetime import date
from functools import lru_cache
from pathlib import Path

from cardan import files
from cardan.base.errors import BadFile, CardanError, Problem
from cardan.border.document import text_of, visible
from cardan.border.table import Beside, Stamp, stamp
from cardan.border.writer import encoded, write
from cardan.files import campaign
from cardan.files.manuscript import Manuscript

HEAVIEST = 64_000_000
"""Bytes of the files that a revision keeps copies of."""
SUMS = "SHA256SUMS"
MOST = 500
"""Revisions of a file."""
SHOWN = 20
"""Revisions that are listed, the last."""


def freeze(file: Path, text: str, *, by: str, note: str) -> None:
    """Keep a text as a revision of a file that nothing writes over, with what it names.

    It lies in the folder `revisions` beside the file, headed by who froze it and when: what the
    program says of it, it says for good.

    Raises
    ------
    BadFile
        If it cannot be read, so that nobody knows what is signed, nobody signs it, or it cannot
        be written; nothing is left then.
    """
    # A character that nobody sees would make a revision that nobody can read.
    by, note = (" ".join(visible(s).split()) for s in (by, note))
    if not by:
        raise BadFile(file.name, (Problem(message="is frozen by somebody: sign it"),))
    encoded(file, text)  # refused by its own lines
    beside = [b for b in _beside(file, text) if b.path.is_file()]
    folder = _folder(file)
    folder.mkdir(exist_ok=True)
    if not folder.resolve().is_relative_to(file.parent.resolve()):
        problem = Problem(message="revisions is a link that leads out of the folder")
        raise BadFile(file.name, (problem,))
    head = f"# frozen {date.today().isoformat()}: {'; '.join(filter(None, (by, note)))}\n"
    for k in range(1, MOST):
        path = folder / f"{file.stem}.{k}.yaml"
        own = _copies(path)
        if path.exists():
            continue
        try:
            if beside:
                own.mkdir()  # nobody else's: ours from here on
        except FileExistsError:
            continue
        try:
            _keep({_called(b, file.parent): b.path for b in beside}, own)
            write(path, head + _renamed(text, file, own, beside))
        except BaseException as error:
            if beside:
                shutil.rmtree(own, ignore_errors=True)
            if isinstance(error, BadFile) and path.exists():
                continue  # somebody else's, meanwhile
            raise
        return
    raise BadFile(file.name, (Problem(message=f"has {MOST} revisions already"),))


def listed(file: Path) -> list[dict[str, str]]:
    """Return the revisions of a file, the last one first: name, what its head says, text."""
    found: list[tuple[int, dict[str, str]]] = []
    folder = _folder(file)
    for path in folder.glob("*.yaml") if folder.is_dir() else ():
        stem, _, k = path.stem.rpartition(".")
        mine = stem == file.stem and k.isdecimal()
        if mine and path.resolve().is_relative_to(file.parent.resolve()):
            with suppress(CardanError):
                whole = text_of(path).replace("\r\n", "\n").replace("\r", "\n")
                head, _, text = whole.partition("\n")
                told = head.removeprefix("# frozen ")
                row = {"name": k, "said": told, "text": _restored(path, text)}
                found.append((int(k), row))
    return [row for _, row in sorted(found, key=lambda r: -r[0])[:SHOWN]]


# --------------------------------------------------------------------------- what became of it


def held(path: Path) -> str | None:
    """Return what tells the contents of a file from others; None where there is no file."""
    try:
        return _sum(path, stamp(path))
    except OSError:
        return None


def kept(path: Path) -> str | None:
    """Return what a revision's file held when it was frozen; any other's is what it holds."""
    own = next((p for p in path.parents if (p / SUMS).is_file()), None)
    if own is None or own.suffix != ".files":
        return held(path)
    with suppress(CardanError):
        rows = (row.partition("  ") for row in text_of(own / SUMS).splitlines())
        return {name: was for was, _, name in rows}.get(path.relative_to(own).as_posix())
    return None


@lru_cache(maxsize=1000)
def _sum(path: Path, _: Stamp) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


# --------------------------------------------------------------------------- what it names


def _beside(file: Path, text: str) -> list[Beside]:
    """Return the files that a text names, and those that they name."""
    beside: list[Beside] = []
    if campaign.title(Manuscript(text, file.name)) is None:
        files.loads(text, name=file.name, folder=file.parent, warn=False, beside=beside)
    else:
        campaign.loads(text, name=file.name, folder=file.parent, beside=beside)
    return [replace(b, path=Path(os.path.normpath(b.path))) for b in beside]


def _called(of: Beside, folder: Path) -> str:
    """Return how a file is called from a folder."""
    return Path(os.path.relpath(of.path, folder)).as_posix()


def _keep(named: dict[str, Path], own: Path) -> None:
    """Keep files in a folder, under the names that they had from theirs, and what they hold."""
    spare, sums = HEAVIEST, list[str]()
    for rest, file in sorted(named.items(), key=lambda row: row[1].stat().st_size):
        target = own / rest
        target.parent.mkdir(parents=True, exist_ok=True)
        spare -= file.stat().st_size
        if spare >= 0:
            write(target, file.read_bytes())
        else:
            _link(file, target)
        sums.append(f"{held(target)}  {rest}\n")
    if sums:
        write(own / SUMS, "".join(sums))


def _link(file: Path, target: Path) -> None:
    """Give a file a second name; where disks cannot, or another owns it, it is copied."""
    try:
        os.link(os.path.realpath(file), target)
    except OSError:
        shutil.copyfile(file, target)


def _renamed(text: str, file: Path, own: Path, beside: list[Beside]) -> str:
    """Return a text that names what is kept in a folder in place of what it was kept of."""
    if not beside:
        return text
    of = Manuscript(text, file.name)
    return of.with_({
        at: f"{own.name}/{_called(b, file.parent)}"
        for b in beside for at in of.addresses
        if b.stands(at) and of.written(at) == b.name
    })  # fmt: skip


def _restored(path: Path, text: str) -> str:
    """Return the text of a revision with what it keeps called as from the folder."""
    own = _copies(path)
    if own.is_dir():
        with suppress(CardanError):
            of, copies = Manuscript(text, path.name), f"{own.name}/"
            said = {at: of.written(at) or "" for at in of.addresses}
            return of.with_(
                {at: f"{path.parent.name}/{to}" for at, to in said.items() if to.startswith(copies)}
            )
    return text


def _folder(file: Path) -> Path:
    return file.parent / "revisions"


def _copies(path: Path) -> Path:
    """Return the folder of what a revision keeps beside it."""
    return path.with_name(f"{path.stem}.files")
