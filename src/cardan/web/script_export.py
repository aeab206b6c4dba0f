"""What was done to a file with a hand, as a script and as commands that do it again."""

import json
import shlex
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from cardan.application.overrides import addresses
from cardan.application.yaml_edit import YamlEditor
from cardan.core.errors import CardanError
from cardan.render.i18n import Translator
from cardan.web.parsed_document import Json, ParsedDocument, PartialResultCallback


def session_script(
    read: ParsedDocument, args: Json, say: Translator, _: PartialResultCallback
) -> Json:
    """Return a Python script that makes of the saved file what is shown, and commands.

    For a campaign they compute its life. Numbers are changed by their addresses. What is no
    number, a part's name or a line that is new, cannot be said so: it is named, and the file
    has to be saved for it.

    The commands are for a POSIX shell. Where numbers are not saved yet the first of them is
    the script; those of `cardan` evaluate the file as saved.
    """
    name, drives = read.name, read.recording_campaign is not None
    try:
        was, now = YamlEditor(args.get("saved", ""), name), read.manuscript
        known = {} if drives else addresses(read.application)
        changed = {
            at: float(np.ravel(known[at])[0])
            for at in known
            if at in now
            and was.scalar_text(at) is not None
            and was.scalar_text(at) != now.scalar_text(at)
        }
        other = sorted(
            at
            for at in {*was.addresses, *now.addresses} - changed.keys()
            if was.scalar_text(at) != now.scalar_text(at)
        )
    except CardanError:
        changed, other = {}, [name]
    rows = "".join(f"    {at!r}: {v:.12g},\n" for at, v in changed.items() if isfinite(v))
    asked = f"cardan.life({name!r})" if drives else "cardan.check(app)"
    lines = ["import cardan", "", *([] if drives else [f"app = cardan.read({name!r})"])]
    if rows:
        lines.append("app = cardan.change(app, {\n" + rows + "})")
    text = "\n".join([*lines, f"found = {asked}", "print(found)", ""])
    quoted = shell_argument(name)
    line = (
        ""
        if drives
        else read.responses[min(int(args.get("line", 0)), len(read.responses) - 1)].line.name
    )
    asks = (
        [f"cardan life {quoted} --lang {say.code}"]
        if drives
        else [
            f"cardan check {quoted} --lang {say.code}",
            correction_command(name, line, args.get("hold", []), say),
        ]
    )
    return {
        "script": text,
        "commands": [
            *([f"python -c {shlex.quote(text)}"] if rows else []),
            *asks,
            f"cardan serve {quoted}",
        ],
        "other": other[:20],
    }


def shell_argument(name: str) -> str:
    """Return a file's name for a POSIX shell: never an option, nor anything a shell does."""
    return shlex.quote(f"./{name}" if name.startswith("-") else name)


def correction_command(
    name: str, line: str, hold: Sequence[str], say: Translator, count: int | None = None
) -> str:
    """Return the command that looks for corrections of a line, with what is to stay."""
    options = [("line", line), *(("hold", what) for what in hold)]
    options += [("count", count)] if count else []
    said = (f"--{key}={shlex.quote(str(value))}" for key, value in (*options, ("lang", say.code)))
    return " ".join(("cardan fix", shell_argument(name), *said))


def study_commands(
    name: str, what: str, count: int, say: Translator, *, ask: Mapping[str, Any], **varies: Any
) -> list[str]:
    """Return a command and a script that run a study again on the file as it is saved.

    The study's settings stand in a file next to it, named after `what` it is.
    """
    beside = shell_argument(f"{Path(name).stem}.{what}.json")
    asked = json.dumps({**varies, "ask": ask})  # YAML too; ASCII, and one line
    words = {**varies, "n": count, **ask}
    rows = "".join(f"    {key}={value!r},\n" for key, value in words.items())
    return [
        f"cat > {beside} <<'END'\n{asked}\nEND\n"
        f"cardan study {shell_argument(name)} --study {beside} --n {count} --lang {say.code}",
        f"import cardan\n\napp = cardan.read({name!r})\nprint(cardan.study(\n    app,\n{rows}))\n",
    ]
