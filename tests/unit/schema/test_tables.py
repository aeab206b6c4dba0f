"""Tables declare what a file may hold: reading, errors and schema come from one place."""

from typing import Annotated, Literal

import pytest

from cardan.core.errors import DesignError
from cardan.schema.field_types import Field, IntegerField, NumberField
from cardan.schema.node_reader import InvalidValueError, NodeReader, TableReadContext
from cardan.schema.tables import Table, table_key_field
from cardan.schema.yaml_tree import parse_yaml

Size = Annotated[float, NumberField("mm", "in", above=0, usual=(0.01, 1))]


class PlateTable(Table):
    """A plate."""

    width: Size = table_key_field("across")
    height: Size | None = table_key_field("upwards", default=None)
    holes: int = table_key_field("how many", default=0)
    grade: Literal["a", "b"] = table_key_field("quality", default="a")

    def build(self) -> tuple[float, ...]:
        """Return its sides."""
        if self.holes > 9:
            msg = "holes must leave some plate"
            raise DesignError(msg)
        if self.grade == "b":
            self.reader_of("grade").add_issue("we sell none")
        return self.width, self.height or self.width


class BoxTable(Table):
    """A box of plates."""

    one_of = (("plate", "plates"),)

    plate: Annotated[tuple[float, ...], PlateTable] | None = table_key_field("one", default=None)
    plates: dict[str, Annotated[tuple[float, ...], PlateTable]] = table_key_field(
        "several", default={}
    )
    order: dict[int, str] = table_key_field("which goes where", default={})


def told(table, text):
    reading = TableReadContext()
    try:
        made = table.read(NodeReader(parse_yaml(text, "f")[0], "", reading))
    except InvalidValueError:
        made = None
    return made, [p.format_with_location("f") for p in reading.problems]


def test_a_table_becomes_what_it_builds():
    assert told(PlateTable, "width_mm: 20") == ((0.02, 0.02), [])
    assert told(PlateTable, "{width_in: 1, height_mm: 30}") == ((0.0254, 0.03), [])


def test_a_nested_table_has_become_its_part_before_the_outer_one_is_built():
    box, problems = told(BoxTable, "{plates: {lid: {width_mm: 20}}, order: {1: lid}}")
    assert (box.plates, box.order, problems) == ({"lid": (0.02, 0.02)}, {1: "lid"}, [])


@pytest.mark.parametrize(
    ("table", "text", "message"),
    [
        (PlateTable, "{width_mm: 20, holes: 12}", "f:1:23: holes: holes must leave some plate"),
        (PlateTable, "{width_mm: 20, grade: b}", "f:1:23: grade: we sell none"),
        (PlateTable, "{height_mm: 20}", "f:1:1: width_mm or width_in is missing: across"),
        (PlateTable, "{width_mm: 20, with_in: 3}", "f:1:16: with_in: unknown key; did you mean "
         "width_in?"),
        (BoxTable, "{}", "f:1:1: needs plate or plates"),
        (BoxTable, "{plate: {width_mm: 1}, plates: {}}", "f:1:24: plates: plate and plates exclude "
         "each other; keep one of them"),
        (BoxTable, "{plates: {lid: 3}}", "f:1:16: plates.lid: must be a table with width_mm, "
         "height_mm, holes, grade (got 3)"),
        (BoxTable, "{plates: [3]}", "f:1:10: plates: must be a table from names to tables with "
         "width_mm, height_mm, holes, grade (got a list of 1)"),
        (BoxTable, "{plates: {}, order: {0: lid}}", "f:1:22: order.0: must be a whole number from "
         "1 to 1000 (got 0)"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_where(table, text, message):
    made, problems = told(table, text)
    assert made is None
    assert problems == [message]


def test_parts_are_tried_each_by_itself():
    _, problems = told(BoxTable, "plates:\n  a: {width_mm: 0}\n  b: {width_mm: 1, holes: 12}\n")
    assert [p.split(": ")[:2] for p in problems] == [
        ["f:2:17", "plates.a.width_mm"], ["f:3:27", "plates.b.holes"],
    ]  # fmt: skip


def test_what_is_spoilt_elsewhere_is_never_built():
    class Elsewhere(Field):
        def read(self, here):
            assert here.address == "part"
            raise InvalidValueError

    class OuterTable(Table):
        part: Annotated[float, Elsewhere()] = table_key_field("noted in another file")

        def build(self):
            pytest.fail("built from nothing")

    assert told(OuterTable, "part: 1") == (None, [])


def test_units_of_a_measure_are_keys_with_bounds_in_that_unit():
    defs = {}
    assert PlateTable.schema(defs) == {"$ref": "#/$defs/Plate"}
    plate = defs["Plate"]
    assert list(plate["properties"]) == [
        "width_mm", "width_in", "height_mm", "height_in", "holes", "grade",
    ]  # fmt: skip
    assert plate["properties"]["holes"] == {
        "description": "how many (default 0)", **IntegerField().schema({}, ""),
    }  # fmt: skip
    inches = NumberField("in", most=0.0508).schema({}, "in")
    assert inches == {"type": "number", "maximum": pytest.approx(2)}
    assert plate["allOf"][0] == {"oneOf": [{"required": ["width_mm"]}, {"required": ["width_in"]}]}
