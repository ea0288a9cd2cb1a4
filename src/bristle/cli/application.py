"""The command ``bristle``: its subcommands, and the function that runs them."""

from collections.abc import Iterable
from importlib import import_module
from typing import Annotated, cast

import typer

from bristle.cli.commands import COMMANDS
from bristle.cli.options import as_command, command_text
from bristle.cli.signals import INTERRUPTED
from bristle.cli.terminal import BAD_INPUT, complain
from bristle.core.former import successor

# Newer releases of typer contain their own copy of click: its errors are reached through public classes of typer.
UsageError = cast("type[typer.BadParameter]", typer.BadParameter.__mro__[1])


def application(names: Iterable[str] = tuple(COMMANDS)) -> typer.Typer:
    """Return the program with these commands, by default all."""
    app = typer.Typer(
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        add_completion=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback(invoke_without_command=True)(bristle)
    for name in names:
        module = import_module(COMMANDS[name])
        command_class = getattr(module, "COMMAND", None)
        app.command(name, cls=command_class, epilog=f"\b\n{module.EXAMPLE}")(
            as_command(getattr(module, name))
        )
    return app


def bristle(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
) -> None:
    """Turn the log of a motion axis into a friction model, a compensated loop and drive tables.

    Exit codes: 0 success, 1 negative answer, 2 bad input, 130 interrupted, 70 fault of bristle.
    """
    if version:
        from importlib.metadata import version as installed

        typer.echo(f"bristle {installed('bristle')}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


def _named(arguments: list[str]) -> Iterable[str]:
    """Return the command that a command line begins with; all, if it begins with none."""
    if arguments and arguments[0] in COMMANDS:
        return arguments[:1]
    return COMMANDS


def run(arguments: list[str]) -> int:
    """Run one command and return its exit code. Report a mistyped command line in one line."""
    first = " ".join(["bristle", *arguments[:1]])  # parsing consumes the arguments
    command = typer.main.get_command(application(_named(arguments)))
    try:
        with command.make_context("bristle", arguments, obj=command_text(arguments)) as context:
            return command.invoke(context) or 0
    except typer.Exit as ended:
        return ended.exit_code
    except typer.Abort:
        return INTERRUPTED
    except UsageError as error:
        place = "bristle"
        if error.ctx is not None:
            place = error.ctx.command_path
        typed = getattr(error, "option_name", first)
        advice = successor(f"{place.removeprefix('bristle ')} {typed}", typed)
        if advice:
            complain(f"{typed} was removed. {advice}")
            return BAD_INPUT
        text = error.format_message()
        if not text.endswith((".", "?")):
            text += "."
        complain(f"{text} Try: {place} --help")
        return BAD_INPUT
