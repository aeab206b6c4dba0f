"""Help of a command that has many options: in groups by purpose."""

from collections.abc import Mapping

import click

from cardan.cli.exit_codes import NoRepeatedOptionCommand


class GroupedOptionsCommand(NoRepeatedOptionCommand):
    """A command whose help lists options by purpose, in the order of declaration.

    `option_groups` has the title of each group with the name of its first option.
    """

    option_groups: Mapping[str, str]

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options in sections."""
        titles = {first: title for title, first in self.option_groups.items()}
        title, sections = "Options", dict[str, list[tuple[str, str]]]()
        for parameter in self.get_params(ctx):
            title = titles.get(parameter.name or "", title)
            record = parameter.get_help_record(ctx)
            if record is not None and isinstance(parameter, click.Option):
                sections.setdefault(title, []).append(record)
        for title, records in sections.items():
            with formatter.section(title):
                formatter.write_dl(records)
