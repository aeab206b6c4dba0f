"""The media of reports: one list, from which commands, interface and workbench take their media."""

from importlib import import_module
from typing import TYPE_CHECKING

from cardan.core.lazy_dataclass import dataclass

if TYPE_CHECKING:
    from cardan.render.blocks import ReportDocument


@dataclass(frozen=True, kw_only=True)
class ReportMedium:
    """A medium that a report is written in.

    Attributes
    ----------
    name
        Name of the command-line option and ending of the file.
    media_type
        Media type, as a server states it.
    help
        Help of the option.
    writer
        Function that returns a report as text or bytes: `module:function`, imported on first use.
    """

    name: str
    media_type: str
    help: str
    writer: str

    def write(self, document: "ReportDocument") -> str | bytes:
        """Return a report in this medium."""
        module, name = self.writer.split(":")
        return getattr(import_module(module), name)(document)


REPORT_MEDIA = (
    ReportMedium(
        name="html",
        media_type="text/html",
        help="A report: a page that needs nothing else.",
        writer="cardan.render.html:html_page",
    ),
    ReportMedium(
        name="pdf",
        media_type="application/pdf",
        help="A report: a document to sign.",
        writer="cardan.render.pdf:pdf_document",
    ),
)
"""Media of reports, in the order of help and menus."""
