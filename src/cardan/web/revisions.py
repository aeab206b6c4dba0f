"""Revisions: released texts, with copies of the files they name, and later changes of these.

What a text names of its folder is copied, the smallest first, up to `MAX_COPIED_BYTES`. What is
heavier, recordings of gigabytes, is given a second name instead: that takes no room and no time,
and the file stays where its first name is thrown away or goes to another. Only a write into the
file itself changes both; so what each holds when it is released is written down, as `sha256sum -c`
reads it, and changes since are reported on request.
"""

import hashlib
import os
import shutil
from contextlib import suppress
from dataclasses import replace
from datetime import date
from functools import lru_cache
from pathlib import Path

from cardan.application import reader
from cardan.application.yaml_edit import YamlEditor
from cardan.core.errors import CardanError, FileIssue, InvalidFileError
from cardan.schema.atomic_write import encode_text, write_atomically
from cardan.schema.node_reader import FileChangeStamp, ReferencedFile, file_stamp
from cardan.schema.yaml_tree import read_text, replace_hidden_characters
from cardan.topics.recording import campaign_schema as campaign

MAX_COPIED_BYTES = 64_000_000
"""Bytes of the files that a revision keeps copies of."""
CHECKSUM_FILE_NAME = "SHA256SUMS"
MAX_REVISIONS = 500
"""Revisions of a file."""
MAX_LISTED_REVISIONS = 20
"""Revisions that are listed, the last."""


def release_revision(file: Path, text: str, *, by: str, note: str) -> None:
    """Keep a text as a revision of a file that nothing writes over, with what it names.

    It lies in the folder `revisions` next to the file, with who released it and when in its head:
    what the program says of it, it says for good.

    Raises
    ------
    InvalidFileError
        If it cannot be read, so that what is signed is unknown, no name is given, or it cannot
        be written; nothing is left then.
    """
    # An invisible character would make a revision that cannot be read.
    by, note = (" ".join(replace_hidden_characters(s).split()) for s in (by, note))
    if not by:
        raise InvalidFileError(file.name, (FileIssue(message="is frozen by somebody: sign it"),))
    encode_text(file, text)  # refused by its own lines
    beside = [b for b in _referenced_files(file, text) if b.path.is_file()]
    folder = _revision_folder(file)
    folder.mkdir(exist_ok=True)
    if not folder.resolve().is_relative_to(file.parent.resolve()):
        problem = FileIssue(message="revisions is a link that leads out of the folder")
        raise InvalidFileError(file.name, (problem,))
    head = f"# frozen {date.today().isoformat()}: {'; '.join(filter(None, (by, note)))}\n"
    for k in range(1, MAX_REVISIONS):
        path = folder / f"{file.stem}.{k}.yaml"
        own = _copies_folder(path)
        if path.exists():
            continue
        try:
            if beside:
                own.mkdir()  # a new folder: ours from here on
        except FileExistsError:
            continue
        try:
            _store_files({_relative_name(b, file.parent): b.path for b in beside}, own)
            whole = head + _with_stored_names(text, file, own, beside)
            write_atomically(path, whole, within=Path(os.path.realpath(file.parent)))
        except BaseException as error:
            if beside:
                shutil.rmtree(own, ignore_errors=True)
            if isinstance(error, InvalidFileError) and path.exists():
                continue  # another process's, meanwhile
            raise
        return
    raise InvalidFileError(
        file.name, (FileIssue(message=f"has {MAX_REVISIONS} revisions already"),)
    )


def list_revisions(file: Path) -> list[dict[str, str]]:
    """Return the revisions of a file, the last one first: name, what its head says, text."""
    found: list[tuple[int, dict[str, str]]] = []
    folder = _revision_folder(file)
    for path in folder.glob("*.yaml") if folder.is_dir() else ():
        stem, _, k = path.stem.rpartition(".")
        mine = stem == file.stem and k.isdecimal()
        if mine and path.resolve().is_relative_to(file.parent.resolve()):
            with suppress(CardanError):
                whole = read_text(path).replace("\r\n", "\n").replace("\r", "\n")
                head, _, text = whole.partition("\n")
                told = head.removeprefix("# frozen ")
                row = {"name": k, "said": told, "text": _with_original_names(path, text)}
                found.append((int(k), row))
    return [row for _, row in sorted(found, key=lambda r: -r[0])[:MAX_LISTED_REVISIONS]]


# --------------------------------------------------------------------------- what became of it


def current_checksum(path: Path) -> str | None:
    """Return what distinguishes the contents of a file from others; None where there is no file."""
    try:
        return _checksum(path, file_stamp(path))
    except OSError:
        return None


def released_checksum(path: Path) -> str | None:
    """Return what a revision's file held when it was released; any other's is what it holds."""
    own = next((p for p in path.parents if (p / CHECKSUM_FILE_NAME).is_file()), None)
    if own is None or own.suffix != ".files":
        return current_checksum(path)
    with suppress(CardanError):
        rows = (row.partition("  ") for row in read_text(own / CHECKSUM_FILE_NAME).splitlines())
        return {name: was for was, _, name in rows}.get(path.relative_to(own).as_posix())
    return None


@lru_cache(maxsize=1000)
def _checksum(path: Path, _: FileChangeStamp) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


# --------------------------------------------------------------------------- what it names


def _referenced_files(file: Path, text: str) -> list[ReferencedFile]:
    """Return the files that a text names, and those that they name."""
    beside: list[ReferencedFile] = []
    if campaign.campaign_title(YamlEditor(text, file.name)) is None:
        reader.loads(text, name=file.name, folder=file.parent, warn=False, beside=beside)
    else:
        campaign.read_campaign_text(text, name=file.name, folder=file.parent, beside=beside)
    return [replace(b, path=Path(os.path.normpath(b.path))) for b in beside]


def _relative_name(of: ReferencedFile, folder: Path) -> str:
    """Return how a file is called from a folder."""
    return Path(os.path.relpath(of.path, folder)).as_posix()


def _store_files(named: dict[str, Path], own: Path) -> None:
    """Keep files in a folder, under the names that they had from their own, and what they hold."""
    spare, sums = MAX_COPIED_BYTES, list[str]()
    for rest, file in sorted(named.items(), key=lambda row: row[1].stat().st_size):
        target = own / rest
        target.parent.mkdir(parents=True, exist_ok=True)
        spare -= file.stat().st_size
        if spare >= 0:
            write_atomically(target, file.read_bytes())
        else:
            _link_or_copy(file, target)
        sums.append(f"{current_checksum(target)}  {rest}\n")
    if sums:
        write_atomically(own / CHECKSUM_FILE_NAME, "".join(sums))


def _link_or_copy(file: Path, target: Path) -> None:
    """Give a file a second name; where disks cannot, or another owns it, it is copied."""
    try:
        os.link(os.path.realpath(file), target)
    except OSError:
        shutil.copyfile(file, target)


def _with_stored_names(text: str, file: Path, own: Path, beside: list[ReferencedFile]) -> str:
    """Return a text that names what is kept in a folder in place of what it was kept of."""
    if not beside:
        return text
    of = YamlEditor(text, file.name)
    return of.with_changes({
        at: f"{own.name}/{_relative_name(b, file.parent)}"
        for b in beside for at in of.addresses
        if b.is_named_at(at) and of.scalar_text(at) == b.name
    })  # fmt: skip


def _with_original_names(path: Path, text: str) -> str:
    """Return the text of a revision with what it keeps called as from the folder."""
    own = _copies_folder(path)
    if own.is_dir():
        with suppress(CardanError):
            of, copies = YamlEditor(text, path.name), f"{own.name}/"
            said = {at: of.scalar_text(at) or "" for at in of.addresses}
            return of.with_changes(
                {at: f"{path.parent.name}/{to}" for at, to in said.items() if to.startswith(copies)}
            )
    return text


def _revision_folder(file: Path) -> Path:
    return file.parent / "revisions"


def _copies_folder(path: Path) -> Path:
    """Return the folder of the files that a revision keeps."""
    return path.with_name(f"{path.stem}.files")
