"""`cardan convert`: a recording in another format."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import click

from cardan.cli.common import (
    FILE_ARGUMENT,
    LANG_OPTION,
    OUTPUT_PATH,
    QUIET_OPTION,
    echo,
    echo_to_stderr,
    progress_line,
    write_output,
)
from cardan.cli.exit_codes import NoRepeatedOptionCommand, exit_with_code_2_on_known_errors
from cardan.core.arrays import FloatArray
from cardan.core.errors import MissingDependencyError
from cardan.topics.recording.option_table import OPTIONS


@click.command(cls=NoRepeatedOptionCommand)
@FILE_ARGUMENT
@click.argument("out", type=OUTPUT_PATH)
@click.option("--channel", "channels", multiple=True, metavar="CHANNEL",
              help="Only this channel; may be repeated.")  # fmt: skip
@click.option("--rate", type=float, help=OPTIONS["rate"].help)
@click.option("--time", metavar=OPTIONS["time"].metavar, help=OPTIONS["time"].help)
@click.option("--group", default="", help=OPTIONS["group"].help)
@click.option("--dbc", metavar=OPTIONS["dbc"].metavar, multiple=True,
              type=click.Path(path_type=Path), help=OPTIONS["dbc"].help)  # fmt: skip
@click.option("--force", is_flag=True, help="Replace the file.")
@LANG_OPTION
@QUIET_OPTION
@exit_with_code_2_on_known_errors
def convert(
    file: Path,
    out: Path,
    *,
    channels: tuple[str, ...],
    rate: float | None,
    time: str | None,
    group: str,
    dbc: tuple[Path, ...],
    force: bool,
    lang: str,
    quiet: bool,
) -> None:
    """Write a recording FILE as OUT: .parquet, .csv, or RPC III (.rsp, .tim, .rpc, .drv).

    Names, units, rate and beginning stay, as `cardan life` reads them: on the clock of the
    fastest channels, those of others straight between their samples, nothing where there is
    nothing. RPC III holds 16 bits a sample and no missing one.
    """
    from cardan.readers.dispatch import open_recording
    from cardan.readers.recording_writer import recording_writer, with_channels
    from cardan.render.i18n import Translator
    from cardan.schema.atomic_write import check_output_paths

    say = Translator(lang)
    write = recording_writer(out)
    check_output_paths({"OUT": out}, inputs=[file, *dbc])
    recording = open_recording(file, rate=rate, time=time, group=group, dbc=dbc)
    if channels:
        recording = with_channels(recording, channels)
    with progress_line(say("writing {file}", file=out), quiet=quiet) as line:

        def read(places: tuple[int, ...]) -> Iterator[FloatArray]:
            done = 0
            for piece in recording.read(places):
                yield piece
                done += piece.shape[1]
                line.update(f"{done / recording.rate:.0f} s")

        try:
            write_output(out, write(replace(recording, read=read)), replace=force)
        except ImportError as error:
            msg = f"this needs {error.name}; pip install 'cardan[fatigue,recordings]'"
            raise MissingDependencyError(msg) from error
    for note in recording.notes:
        echo_to_stderr(say("  note: {note}", note=say.error(say.translate_if_known(note))).strip())
    echo(say("{file} is written.", file=out))
