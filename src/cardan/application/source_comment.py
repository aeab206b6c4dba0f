"""Comments that say where a value is from, next to values that are written anew."""

import re
from collections.abc import Collection

from cardan.application.yaml_edit import YamlEditor
from cardan.schema.yaml_tree import to_one_line

_SAYS_SOURCE = re.compile(
    r"(?:published|assumed|ours|measured|entered|re-read|by definition|second hand|from memory)\b"
    r"|[\w .,()\[\]-]+\.(?:csv|tsv|txt|dat|v[a-z]{3,5})(?:$|: |; | at )",
    re.IGNORECASE,
)
"""A word for the source, or a file's name; other comments say what a value is, and stay."""

_LINE = re.compile(r"[^\r\n]*(?:\r\n|\r|\n)|[^\r\n]+\Z")


def changed_addresses(before: str, after: str) -> tuple[str, ...]:
    """Return the addresses whose single values differ between two texts of an application."""
    was, now = YamlEditor(before), YamlEditor(after)
    return tuple(
        at
        for at in now.addresses
        if (said := now.scalar_text(at)) is not None
        and said != was.scalar_text(at)
        and not at.startswith("placeholders[")
    )


def text_with_source(changed: Collection[str], text: str, source: str) -> str:
    """Return a text whose changed values have another source in the comments of their lines.

    A comment that names a source is replaced. Where its line has other values, it stays as theirs.
    Lines without such a comment stay as they are.

    Parameters
    ----------
    changed
        Addresses of what changed; that of a table or list is of the line of its key.
    text
        The text after the change.
    source
        Name of the file that the values are from.
    """
    editor = YamlEditor(text)
    lines = _LINE.findall(text)
    source = to_one_line(source)
    by_line: dict[int, list[tuple[str, int]]] = {}
    for at, line, end in editor.scalar_ends():
        by_line.setdefault(line, []).append((at, end))
    for line, values in by_line.items():
        new = [at for at, _ in values if at in changed]
        if new:
            kept = len(new) < len(values)
            start = max(end for _, end in values)
            lines[line - 1] = _commented(lines[line - 1], start, source, new if kept else [])
    for at in changed:
        line = editor.line_of_key(at)
        if line is not None and line not in by_line:
            lines[line - 1] = _commented(lines[line - 1], 0, source, [])
    return "".join(lines)


def _commented(line: str, start: int, source: str, names: list[str]) -> str:
    """Return a line with a source in the comment behind `start`, of all its values or of some."""
    bare = line.rstrip("\r\n")
    at = bare.find(" #", start)
    said = bare[at + 2 :].strip() if at >= 0 else ""
    if not _SAYS_SOURCE.match(said):
        return line
    some = ", ".join(name.rpartition(".")[2] for name in names)
    now = f"{some} {source}; others {said}" if some else source
    return f"{bare[: at + 2]} {now}{line[len(bare) :]}"
