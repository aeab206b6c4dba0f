"""The workbench's page over what was computed beforehand: one file that needs no server.

States, travel, limits and the three dimensions are there; nothing can be changed. The page is
the same as that of `cardan serve`, built once more into one script.
"""

import json
from base64 import b64encode
from collections.abc import Sequence
from hashlib import sha256
from html import escape
from importlib import resources
from pathlib import Path

import numpy as np

from cardan.application import reader
from cardan.core.errors import MissingDependencyError
from cardan.core.version import __version__
from cardan.render.i18n import Translator
from cardan.web import ui_texts as words
from cardan.web.handlers import handle_request
from cardan.web.parsed_document import Json

AXLE_TRAVEL_POSITION_COUNT = 41
"""Places of the axle that the slider stops at."""


def standalone_page(text: str, *, name: str, folder: str | None, say: Translator) -> str:
    """Return an application as a page of its own.

    Raises
    ------
    InvalidFileError
        If the text cannot be read.
    MissingDependencyError
        If the page has not been built.
    """
    style, code = _style_and_script()
    told = json.dumps(
        _precomputed_answers(text, name, folder, say), ensure_ascii=False, separators=(",", ":")
    )
    kept = told.replace("<", "\\u003c")  # no name of the file ends the element it stands in
    title = escape(json.loads(told)["live"]["title"][:200])
    lang = {"pt": "pt-BR"}.get(say.code, say.code)
    policy = (
        f"default-src 'none'; script-src {_csp_hash(code)}; style-src {_csp_hash(style)}; "
        "img-src data:"
    )
    return (
        f'<!doctype html>\n<html lang="{lang}"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        f'<meta name="color-scheme" content="light dark"><title>{title}</title>'
        f'<style>{style}</style></head><body><div id="page"></div>'
        f'<script type="application/json" id="live">{kept}</script>'
        f"<script>{code}</script></body></html>\n"
    )


def _style_and_script() -> tuple[str, str]:
    """Return style and script of the page, as they stand in elements of their own."""
    folder = resources.files("cardan.web").joinpath("static/live")
    try:
        style, code = (folder.joinpath(n).read_text("utf-8") for n in ("live.css", "live.js"))
    except OSError:
        msg = "the workbench's page is not built: `make serve` builds it where Node is installed"
        raise MissingDependencyError(msg) from None
    return style.replace("</style", "<\\/style"), code.replace("</script", "<\\/script")


def _csp_hash(of: str) -> str:
    return f"'sha256-{b64encode(sha256(of.encode()).digest()).decode()}'"


def _precomputed_answers(text: str, name: str, folder: str | None, say: Translator) -> Json:
    """Return everything that the page receives, in reply to any request."""
    question = {"text": text, "name": name, "folder": folder, "lang": say.code}
    reader.loads(text, name=name, folder=Path(folder) if folder else None)  # refuses, and says why
    live = handle_request({**question, "job": "live", "pose": {"line": 0}, "want": []})
    lines = [
        _line_poses(
            question, k, len(live["states"]), [m for m in live["limits"] if m["line"] == of["name"]]
        )
        for k, of in enumerate(live["lines"])
    ]
    return {
        "welcome": {
            "version": __version__, "token": "", "lang": say.code, "languages": [say.code],
            "texts": words.translated_texts(say), "quantities": words.quantity_explanations(say),
            "catalogue": {"joints": [], "tubes": []}, "profiles": [], "files": [name],
        },
        "live": {**live, "text": "", "handles": []},
        "full": {**handle_request({**question, "job": "full"}), "text": ""},
        "lines": lines,
    }  # fmt: skip


def _line_poses(question: Json, line: int, states: int, limits: Sequence[Json]) -> Json:
    """Return a line's poses: in every state, over its axle's travel, where limits are worst.

    No other torque is sent: there is none that a slider of torque could go to.
    """

    def pose(want: tuple[str, ...], **where: float | str) -> Json:
        asked = {"job": "pose", "pose": {"line": line, **where}, "want": want}
        return {**handle_request({**question, **asked})["pose"], "torque_reach": [0, 0]}

    found = [pose(("curves",), state=s) for s in range(states)]
    low, high = found[0]["travel_reach"]
    worst = {
        (s, spot["torque_Nm"], spot["way"])
        for m in limits
        for s, parts in enumerate(m.get("spots", ()))
        for spot in parts
        if spot
    }
    heights = np.linspace(low, high, AXLE_TRAVEL_POSITION_COUNT) if high > low else np.array([])
    return {
        "states": found,
        "travel": [pose((), travel_mm=float(z), torque_Nm=0.0) for z in heights],
        "wound": [
            {"state": s, "torque_Nm": torque, "way": way,
             "pose": pose((), state=s, torque_Nm=torque, way=way)}
            for s, torque, way in sorted(worst)
        ],
    }  # fmt: skip
