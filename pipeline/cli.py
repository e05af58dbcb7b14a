"""The command `bipedstudy`: finds the command's module when it is asked for, and turns errors into sentences."""

from __future__ import annotations

import contextlib
import importlib
import os
import signal
import sys
from typing import Any, NoReturn

import click

from pipeline.errors import BAD_INPUT, FAILED, StudyError

_COMMANDS = {
    "run-all": "run_all",
    "run": "run",
    "status": "status",
    "graph": "graph",
    "show": "show",
    "claims": "claims",
    "report": "report",
    "figures": "figures",
    "ingest": "ingest",
    "gait": "gait",
    "continue": "continue_gait",
    "basin": "basin",
    "design": "design",
    "sweep": "sweep",
    "init": "init",
    "doctor": "doctor",
}
_INTERRUPTED = 130


class _Commands(click.Group):
    """Loads a command's module, `pipeline.commands.<name>`, only when it is used."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names in the order of use."""
        return list(_COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command, or None for an unknown name."""
        if cmd_name not in _COMMANDS:
            return None
        command: click.Command = importlib.import_module(f"pipeline.commands.{_COMMANDS[cmd_name]}").command
        return command

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """As click does, with the nearest name for a misspelt one."""
        if args and not args[0].startswith("-") and args[0] not in _COMMANDS:
            from pipeline.errors import nearest

            raise StudyError(f'there is no command "{args[0]}"{nearest(args[0], _COMMANDS)} (see bipedstudy --help)')
        return super().resolve_command(ctx, args)


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(package_name="bipedstudy")
def cli() -> None:
    """Reproducible study of a passive biped walker.

    Parameters stand in params/*.yaml, stages in dvc.yaml, results in results/. Start with `bipedstudy run-all`.
    """


def main(arguments: list[str] | None = None) -> NoReturn:
    """Run the command line; ends the process with 0, 1 (a stage failed), 2 (bad input) or 3 (the answer is no)."""
    signal.signal(signal.SIGTERM, _interrupt)
    try:
        code = cli.main(args=arguments, prog_name="bipedstudy", standalone_mode=False)
        code = code if isinstance(code, int) else 0
        sys.stdout.flush()
    except StudyError as error:
        code = _say(error.sentences, error.exit_code)
    except click.exceptions.Exit as error:
        code = error.exit_code
    except click.UsageError as error:
        where = error.ctx.command_path if error.ctx else "bipedstudy"
        code = _say([f"{error.format_message().rstrip('.')} (see {where} --help)"], BAD_INPUT)
    except click.ClickException as error:
        code = _say([error.format_message()], BAD_INPUT)
    except (KeyboardInterrupt, click.Abort):
        code = _say(["stopped; everything computed before is kept"], _INTERRUPTED)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        code = 0
    except OSError as error:
        about = f"{error.filename}: " if error.filename else ""
        code = _say([f"{about}{error.strerror or error}"], FAILED)
    except Exception as error:
        code = _say([f"unexpected {type(error).__name__}: {error}; {_account()}"], FAILED)
    sys.exit(code)


def _account() -> str:
    """Keep the traceback of the error being handled in a file, and say where."""
    import tempfile
    import traceback

    try:
        with tempfile.NamedTemporaryFile("w", prefix="bipedstudy-", suffix=".log", delete=False) as file:
            traceback.print_exc(file=file)
    except OSError:
        return "its full account could not be kept"
    return f"the full account is in {file.name}"


def _say(sentences: Any, code: int) -> int:
    with contextlib.suppress(OSError):
        for sentence in sentences:
            print(f"error: {sentence}", file=sys.stderr)
    return code


def _interrupt(number: int, frame: Any) -> None:
    raise KeyboardInterrupt


if __name__ == "__main__":
    main()
