"""The JSON Schema of an application file, from the declarations that read it."""

from typing import Any


def application_schema() -> dict[str, Any]:
    """Return the schema (draft 2020-12) that editors complete and check application files by.

    It knows every key with its units and bounds. What needs arithmetic, or a look into a
    catalogue, only `read` can check.
    """
    from cardan.application.reader import ApplicationTable

    defs: dict[str, Any] = {}
    root = ApplicationTable.schema(defs)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "cardan application",
        **root,
        "$defs": dict(sorted(defs.items())),
    }
