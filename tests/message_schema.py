"""The schema of the messages of the workbench."""

import json
from importlib.resources import files as resources

from jsonschema import Draft202012Validator

SCHEMA = json.loads(resources("cardan.web").joinpath("messages.schema.json").read_text("utf-8"))


def wrong(name, told):
    told = {k: v for k, v in json.loads(json.dumps(told)).items() if k not in ("text", "edits")}
    schema = {**SCHEMA, "$ref": f"#/$defs/{name}"}
    errors = Draft202012Validator(schema).iter_errors(told)
    return [(list(e.absolute_path), e.message[:200]) for e in errors]
