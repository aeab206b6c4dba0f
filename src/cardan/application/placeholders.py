"""Keys of an application whose values are not the vehicle's yet."""

import re

from cardan.schema.node_reader import NodeReader, nearest_name_hint


def checked_placeholders(keys: tuple[str, ...], here: NodeReader) -> tuple[str, ...]:
    """Return the keys, with a warning if there is one.

    Each must stand in the file, so that no slip of the pen hides a placeholder.
    """
    there = here.context.locations
    for key in keys:
        if key not in there:
            message = "no such key stands in this file"
            here.reject(message, nearest_name_hint(key, there), got=key)
    if keys:
        here.warn(
            "nothing of this file is evaluated yet",
            "enter the vehicle's values, and take their keys out of the list",
        )
    return keys


def text_with_value_entered(text: str, key: str) -> str:
    """Return the text of an application without a key in `placeholders`, whose value is entered."""
    name = re.escape(key.rpartition(".")[2])
    text = re.sub(rf"(?m)^ *- {re.escape(key)} *\n", "", text)
    return re.sub(rf"(?m)^( *{name}: .*# )placeholder", r"\1entered", text)
