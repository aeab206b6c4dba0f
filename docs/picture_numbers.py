"""The numbers behind the pictures of these pages, kept when the pictures are made.

`docs/pictures.json` has, of each picture of an example, the verdict and the lowest and highest
value of every limited quantity, from the program that drew it. A test compares them with the kept
documents of the examples (`tests/golden`): a picture whose numbers moved by more than it prints is
stale.
"""

import json
from collections.abc import Iterable
from pathlib import Path

from cardan.approval.approval import Approval
from cardan.documents.approval_json import json_document

RECORD = Path(__file__).with_name("pictures.json")


def value_ranges(checks: Iterable[tuple[str, float | None]]) -> dict[str, list[float]]:
    """Return the lowest and highest value of each quantity, four digits each."""
    found: dict[str, list[float]] = {}
    for quantity, value in checks:
        if value is not None:
            found.setdefault(quantity, []).append(float(f"{value:.4g}"))
    return {quantity: [min(values), max(values)] for quantity, values in sorted(found.items())}


def record_numbers(pictures: str, example: str, approval: Approval) -> None:
    """Keep the numbers of an example's approval as those of pictures (a pattern)."""
    document = json_document(approval)
    numbers = {
        "example": example,
        "verdict": document["verdict"],
        "values": value_ranges((c["quantity"], c["value"]) for c in document["checks"]),
    }
    kept = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.exists() else {}
    kept[pictures] = numbers
    rows = (f"{json.dumps(k)}: {json.dumps(kept[k])}" for k in sorted(kept))
    RECORD.write_text("{\n" + ",\n".join(rows) + "\n}\n", encoding="utf-8")
