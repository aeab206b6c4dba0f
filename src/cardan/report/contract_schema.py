"""The JSON Schema of the contract: what is written by hand, and what declarations add."""

import json
from importlib.resources import files
from typing import Any

from cardan.model.movable import MOVABLES
from cardan.quantity.declared import Quantity
from cardan.quantity.quantities import ANSWERED

NUMBER = ["number", "null"]


def schema() -> dict[str, Any]:
    """Return the schema (draft 2020-12) of what `--json` writes.

    A quantity's place in a state comes from its declaration, unless the file beside this
    module describes it at more length; what can be moved comes from declarations too.
    """
    text = files("cardan.report").joinpath("contract.schema.json").read_text(encoding="utf-8")
    found: dict[str, Any] = json.loads(text)
    tables = found["$defs"]
    for quantity in ANSWERED.values():
        if quantity.contract:
            _add(tables["line_state"], quantity.contract.split("."), quantity, tables)
    tables["move"]["properties"]["what"]["enum"] = list(MOVABLES)
    state, line = tables["state"], tables["line_state"]
    state["properties"] = {**line["properties"], **state["properties"]}
    state["required"] = [*line["required"], *state["required"]]
    return found


def _add(table: dict[str, Any], path: list[str], quantity: Quantity, tables: Any) -> None:
    """Describe a quantity at a path of the contract, where nothing does yet."""
    key, *rest = path
    name = key.rstrip("[]{}")
    described = {"type": NUMBER, "description": f"{quantity.name}, {quantity.unit_name}"}
    if key.endswith("[]"):
        described = {"type": "array", "description": described["description"],
                     "items": {"type": NUMBER}}  # fmt: skip
    elif key.endswith("{}"):
        described = {"type": "object", "description": described["description"],
                     "additionalProperties": {"type": NUMBER}}  # fmt: skip
    elif rest:
        inner = table["properties"].setdefault(name, {"type": "object", "properties": {}})
        inner = inner.get("items", inner)
        if "$ref" in inner:
            inner = tables[inner["$ref"].rpartition("/")[2]]
        _add(inner, rest, quantity, tables)
        return
    table["properties"].setdefault(name, described)
