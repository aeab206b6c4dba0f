"""`cardan serve`: the workbench, in the browser of this machine."""

import signal
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path

import click

from cardan.cli.common import LANG_OPTION, echo, echo_to_stderr
from cardan.cli.exit_codes import NoRepeatedOptionCommand, exit_with_code_2_on_known_errors
from cardan.core.errors import MissingDependencyError


@click.command(cls=NoRepeatedOptionCommand)
@click.argument(
    "opened", metavar="[FILE|FOLDER]", default=".", type=click.Path(path_type=Path, exists=True)
)
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="0, the default: any free.")
@click.option("--no-browser", is_flag=True, help="Print the address, open nothing.")
@LANG_OPTION
@exit_with_code_2_on_known_errors
def serve(opened: Path, *, port: int, no_browser: bool, lang: str) -> None:
    """Open the workbench: drag a bearing, see the verdict.

    On this machine alone; keep its address to yourself: it permits editing the files. Ends
    with Ctrl-C. The page takes the browser's language; --lang is of what is written here.
    """
    for name in ("starlette", "uvicorn", "websockets"):
        if find_spec(name) is None:
            msg = f"the workbench needs {name}: pip install 'cardan[web]'"
            raise MissingDependencyError(msg)
    from cardan.render.i18n import Translator
    from cardan.web import server
    from cardan.web.workspace import Workspace

    desk = Workspace(opened)
    with ExitStack() as held:
        listening = [held.enter_context(one) for one in server.listening_sockets(port)]
        house = server.WorkbenchApp(desk, port=listening[0].getsockname()[1])

        def ready() -> None:
            echo(house.address)
            echo_to_stderr(Translator(lang)("Ends with Ctrl-C."))
            if not no_browser:
                import webbrowser

                webbrowser.open(house.one_time_address)

        signal.signal(
            signal.SIGINT, signal.default_int_handler
        )  # asyncio takes only this one's place
        server.serve(house, listening, ready=ready)
