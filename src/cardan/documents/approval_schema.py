"""The JSON Schema of the contract: what is written by hand, and what declarations add."""

import json
from importlib.resources import files
from typing import Any

from cardan.checks.quantities.declaration import Quantity
from cardan.checks.quantities.registry import LINE_QUANTITIES
from cardan.model.adjustments import ADJUSTMENTS

NUMBER_OR_NULL = ["number", "null"]


def schema() -> dict[str, Any]:
    """Return the schema (draft 2020-12) of what `--json` writes.

    A quantity's place in a state comes from its declaration, unless the file next to this
    module describes it at more length; what can be moved comes from declarations too.
    """
    text = files("cardan.documents").joinpath("contract.schema.json").read_text(encoding="utf-8")
    found: dict[str, Any] = json.loads(text)
    tables = found["$defs"]
    for quantity in LINE_QUANTITIES.values():
        if quantity.json_path:
            _add_quantity(tables["line_state"], quantity.json_path.split("."), quantity, tables)
    tables["move"]["properties"]["what"]["enum"] = list(ADJUSTMENTS)
    state, line = tables["state"], tables["line_state"]
    state["properties"] = {**line["properties"], **state["properties"]}
    state["required"] = [*line["required"], *state["required"]]
    return found


def _add_quantity(table: dict[str, Any], path: list[str], quantity: Quantity, tables: Any) -> None:
    """Describe a quantity at a path of the contract, where nothing does yet."""
    key, *rest = path
    name = key.rstrip("[]{}")
    described = {"type": NUMBER_OR_NULL, "description": f"{quantity.name}, {quantity.unit_symbol}"}
    if key.endswith("[]"):
        described = {"type": "array", "description": described["description"],
                     "items": {"type": NUMBER_OR_NULL}}  # fmt: skip
    elif key.endswith("{}"):
        described = {"type": "object", "description": described["description"],
                     "additionalProperties": {"type": NUMBER_OR_NULL}}  # fmt: skip
    elif rest:
        inner = table["properties"].setdefault(name, {"type": "object", "properties": {}})
        inner = inner.get("items", inner)
        if "$ref" in inner:
            inner = tables[inner["$ref"].rpartition("/")[2]]
        _add_quantity(inner, rest, quantity, tables)
        return
    table["properties"].setdefault(name, described)
