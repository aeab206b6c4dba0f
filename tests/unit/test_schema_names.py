"""What editors offer where a name of a catalogue or a profile is asked for."""

import json

from cardan import files
from cardan.files.catalogue import shipped
from cardan.files.limit import names


def offered(entry):
    """Every value that some alternative of a schema enumerates."""
    found = set(entry.get("enum", [])) if isinstance(entry, dict) else set()
    inside = entry.values() if isinstance(entry, dict) else entry if isinstance(entry, list) else ()
    return found.union(*(offered(one) for one in inside)) if inside else found


def test_the_schema_offers_the_names_of_catalogues_and_profiles():
    tables = files.schema()["$defs"]
    assert set(shipped("tube").rows) <= offered(tables["Shaft"]["properties"]["tube"])
    assert set(shipped("joint").rows) <= offered(tables["Line"]["properties"]["joints"])
    assert set(shipped("material").rows) <= offered(tables["Tube"]["properties"]["material"])
    assert set(names()) <= offered(tables["Application"]["properties"]["limits"])


def test_a_name_of_ones_own_is_allowed_beside_them():
    """The lists are offers, not limits: own catalogues and profiles have other names."""
    tube = files.schema()["$defs"]["Shaft"]["properties"]["tube"]
    said = json.dumps(tube)
    assert '"type": ["string", "number"]' in said
