"""`cardan serve`: the workbench, in the browser of this machine."""

from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path

import click

from cardan.base.errors import NotInstalled
from cardan.cli.common import LANG, note, put
from cardan.cli.ending import Once, kindly


@click.command(cls=Once)
@click.argument(
    "opened", metavar="[FILE|FOLDER]", default=".", type=click.Path(path_type=Path, exists=True)
)
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="0, the default: any free.")
@click.option("--no-browser", is_flag=True, help="Print the address, open nothing.")
@LANG
@kindly
def serve(opened: Path, *, port: int, no_browser: bool, lang: str) -> None:
    """Open the workbench: drag a bearing, see the verdict.

    On this machine alone; its address is for you: whoever has it can edit the files. Ends
    with Ctrl-C. The page asks the browser which language; --lang is of what is written here.
    """
    for name in ("starlette", "uvicorn", "websockets"):
        if find_spec(name) is None:
            msg = f"the workbench needs {name}: pip install 'cardan[web]'"
            raise NotInstalled(msg)
    from cardan.report.language import Language
    from cardan.web import server
    from cardan.web.desk import Desk

    desk = Desk(opened)
    with ExitStack() as held:
        listening = [held.enter_context(one) for one in server.sockets(port)]
        house = server.House(desk, port=listening[0].getsockname()[1])

        def ready() -> None:
            put(house.address)
            note(Language(lang)("Ends with Ctrl-C."))
            if not no_browser:
                import webbrowser

                webbrowser.open(house.opening)

        server.serve(house, listening, ready=ready)
