"""Section `report` of the application file: customer, drawing and signatures of its reports."""

from typing import Annotated, TypeAlias

from cardan.model.application import ReportIdentification
from cardan.schema.field_types import TextField
from cardan.schema.tables import Table, table_key_field

MAX_REPORT_TEXT_CHARACTERS = 60
"""Of customer, drawing and names: more has no room over a signature."""

ReportText: TypeAlias = Annotated[str, TextField(MAX_REPORT_TEXT_CHARACTERS)]


class ReportTable(Table):
    """What the first page of a report says of customer, drawing and signatures."""

    customer: ReportText = table_key_field("for whom the report is made", default="")
    company: ReportText = table_key_field("who makes it", default="")
    vehicle: ReportText = table_key_field("type or number of the vehicle", default="")
    drawing: ReportText = table_key_field("number of the drawing", default="")
    revision: ReportText = table_key_field("of the drawing", default="")
    author: ReportText = table_key_field("name over the signature: made by", default="")
    checker: ReportText = table_key_field("name over the signature: checked by", default="")
    approver: ReportText = table_key_field("name over the signature: approved by", default="")

    def build(self) -> ReportIdentification:
        """Return the texts."""
        return ReportIdentification(
            customer=self.customer,
            company=self.company,
            vehicle=self.vehicle,
            drawing=self.drawing,
            revision=self.revision,
            author=self.author,
            checker=self.checker,
            approver=self.approver,
        )
