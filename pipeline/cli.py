"""The command `bipedstudy`: finds a command's module, or a stage's question, and turns errors into sentences."""

from __future__ import annotations

import contextlib
import importlib
import io
import os
import re
import shlex
import signal
import sys
from typing import Any, NoReturn

import click

from pipeline import trust
from pipeline.cache import processor
from pipeline.errors import BAD_INPUT, FAILED, STOPPING, Stopped, StudyError, nearest
from pipeline.home import DISTRIBUTION, engine, program
from pipeline.study import locate

_BY_SIGNAL = 128
#: As of a program that SIGPIPE ends, so that a run that was cut off is not taken for a whole one.
_NOBODY_READS = _BY_SIGNAL + 13
_STOPPED = "stopped; everything computed before is kept"
#: Signals that have stopped this command.
_arrived: set[int] = set()
#: Each command's module in `pipeline`, where it is called as it is typed, by what it is for; the stages' questions
#: stand after the study.
_GROUPS = {
    "Study": {"init": "commands.house", "run-all": "commands.run", "run": "commands.run",
              "status": "commands.status", "graph": "commands.status", "sweep": "commands.run"},
    "Looking": {"show": "commands.show", "claims": "commands.claims", "report": "report.page",
                "figures": "report.figures", "compare": "changes.command",
                "recompute": "changes.recompute", "package": "package.command"},
    "Housekeeping": {"doctor": "commands.house", "clean": "commands.house"},
}  # fmt: skip
_COMMANDS = {name: module for group in _GROUPS.values() for name, module in group.items()}
#: Most columns of a command's first sentence, which goes over as many lines as it takes.
_SENTENCE = 400
#: A word that is empty, or an option whose value is.
_EMPTY = re.compile(r"(--[\w-]+=)?")


class _Commands(click.Group):
    """Loads a command's module only when it is used; other names are stages' questions."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names in the order of use, then the questions."""
        return [*_COMMANDS, *_questions()[0]]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command, or None for an unknown name."""
        if cmd_name in _COMMANDS:
            module = importlib.import_module(f"pipeline.{_COMMANDS[cmd_name]}")
            command: click.Command = getattr(module, cmd_name.replace("-", "_"))
            return command
        known, _ = _questions()
        return known[cmd_name][1] if cmd_name in known else None

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """As click does, with the nearest name for a misspelt one.

        Raises `StudyError` in a checkout of its own, and for an empty word: often a variable of the shell that is not
        set, which would be the default of one option and the working folder of another.
        """
        locate()
        empty = next((place for place, word in enumerate(args, 1) if _EMPTY.fullmatch(word)), None)
        if empty:
            raise StudyError(f"{shlex.join(args[:empty])}: ends with an empty value; give one, or leave it out")
        if args and not args[0].startswith("-") and args[0] not in _COMMANDS:
            known, broken = _questions()
            if args[0] not in known:
                hint = nearest(args[0], (*_COMMANDS, *known))
                raise StudyError([f'there is no command "{args[0]}"{hint} (see bipedstudy --help)', *broken])
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The commands by what they are for, and the questions of each stage."""
        (study, *others), (known, broken) = _GROUPS.items(), _questions()
        parts = {study[0]: [*study[1]]}
        for name, (stage, _) in known.items():
            parts.setdefault(f"Questions to stage {stage}", []).append(name)
        for title, names in {**parts, **dict(others)}.items():
            commands = [(name, self.get_command(ctx, name)) for name in names]
            with formatter.section(title):
                formatter.write_dl([(name, item.get_short_help_str(_SENTENCE)) for name, item in commands if item])
        if broken:
            formatter.write_text("\n".join(broken))


def _questions() -> tuple[dict[str, tuple[str, click.Command]], Any]:
    """Stage and command of all that the stages of the study at hand can be asked, and why others cannot be."""
    from pipeline.questions.command import offered

    try:
        return offered(locate(), frozenset(_COMMANDS))
    except StudyError as error:  # commands that need the study say so themselves
        return {}, error.sentences


def _version(ctx: click.Context, parameter: click.Parameter, requested: bool) -> None:
    """Print the version, the commit and a digest of the code, if asked."""
    if requested and not ctx.resilient_parsing:
        version = importlib.import_module("importlib.metadata").version(DISTRIBUTION)
        click.echo(program(engine() / "stages", f"{DISTRIBUTION}, version {version}"))
        ctx.exit()


def _trust(ctx: click.Context, parameter: click.Parameter, requested: bool) -> None:
    """Note whether this command agrees to the study's code."""
    trust.agree(requested and not ctx.resilient_parsing, True)


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.option("--version", is_flag=True, expose_value=False, is_eager=True, callback=_version,
              help="Show the version, the commit and a digest of the code, and exit.")
@click.option("--trust", is_flag=True, expose_value=False, is_eager=True, callback=_trust,
              help="Agree to run the code of the study at hand, and remember that.")
def cli() -> None:
    """Bring a study of stages up to date, and ask its stages questions.

    Parameters stand in params/*.yaml, stages in dvc.yaml, results in results/. Start with `bipedstudy run-all`.
    """


def main(arguments: list[str] | None = None) -> NoReturn:
    """Run the command line; ends the process with 0, 1 (a stage failed), 2 (bad input) or 3 (the answer is no).

    Stopped by a signal it ends with 128 and the signal's number: 130 by Ctrl-C, 143 by SIGTERM, 129 where
    its terminal closes, 141 where nobody reads on what it prints.
    """
    _have_streams()
    _arrived.clear()
    for number in STOPPING:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _interrupt)
    sys.unraisablehook = _unraisable
    processor.take()
    os.environ["MPLBACKEND"] = "Agg"  # that of a notebook, which its commands inherit, may not be installed here
    out = sys.stdout
    code, sentences = 0, tuple[str, ...]()
    try:
        answer = cli.main(args=arguments, prog_name="bipedstudy", standalone_mode=False)
        code = answer if isinstance(answer, int) else 0
        sys.stdout.flush()
    except SystemExit:
        if sys.stdout is out:
            raise
        code = _NOBODY_READS  # click met a closed pipe, and put streams there that pass over it
    except (Exception, KeyboardInterrupt) as error:
        code, sentences = _ending(error)
    with contextlib.suppress(OSError):
        for sentence in sentences:
            print(f"error: {sentence}", file=sys.stderr)
    sys.exit(code)


def _have_streams() -> None:
    """Open those that whoever started this has closed: the next file that is opened would take their numbers.

    A letter that standard output lacks, as a terminal of Latin 1 or ASCII may, is written as standard error has it.
    """
    for name, mode in {"stdin": "r", "stdout": "w", "stderr": "w"}.items():
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode))  # noqa: SIM115 - until the process ends
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def _ending(error: BaseException) -> tuple[int, tuple[str, ...]]:
    """How a command ends by what it raised: the exit code, and what is said."""
    if isinstance(error, StudyError):
        return error.exit_code, error.sentences
    if isinstance(error, click.exceptions.NoArgsIsHelpError):
        error.show()
    if isinstance(error, (click.exceptions.Exit, click.exceptions.NoArgsIsHelpError)):
        return error.exit_code, ()
    if isinstance(error, click.UsageError):
        where = error.ctx.command_path if error.ctx else "bipedstudy"
        number = isinstance(error, click.NoSuchOption) and error.option_name.lstrip("-")[:1].isdigit()
        hint = "; what begins with a minus stands after -- and behind all options" if number else ""
        return BAD_INPUT, (f"{error.format_message().rstrip('.')}{hint} (see {where} --help)",)
    if isinstance(error, click.ClickException):
        return BAD_INPUT, (error.format_message(),)
    if isinstance(error, BrokenPipeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return _NOBODY_READS, ()
    if _arrived or isinstance(error, (KeyboardInterrupt, click.Abort)):
        return Stopped.exit_code, (_STOPPED,)  # or in a library's callback, or where the terminal is gone
    if isinstance(error, OSError):
        return FAILED, (f"{f'{error.filename}: ' if error.filename else ''}{error.strerror or error}",)
    return FAILED, (f"unexpected {type(error).__name__}: {error}; {_account()}",)


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


def _interrupt(number: int, frame: Any) -> None:
    _arrived.add(number)
    Stopped.exit_code = _BY_SIGNAL + number
    raise KeyboardInterrupt


def _unraisable(seen: sys.UnraisableHookArgs) -> None:
    if not (_arrived and seen.exc_type is KeyboardInterrupt):
        sys.__unraisablehook__(seen)


if __name__ == "__main__":
    main()
