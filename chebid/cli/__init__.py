"""The command line: options in, one call, one rendering out. No mathematics, and nothing heavy at import time."""

import io
import os
import sys

import typer

from chebid.cli.add import add
from chebid.cli.compare import compare
from chebid.cli.derive import derive
from chebid.cli.diagnose import diagnose
from chebid.cli.excite import excite
from chebid.cli.freqresp import freqresp
from chebid.cli.identify import identify
from chebid.cli.predict import predict
from chebid.cli.project import project
from chebid.cli.refine import refine
from chebid.cli.report import report
from chebid.cli.simulate import simulate
from chebid.errors import ChebidError

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
    help="From a robot's log (joint positions, motor torques) to a dynamic model one can trust.",
    epilog="Every command: --quiet silences progress and warnings, --debug shows tracebacks. SI units throughout.",
)
for command in (project, derive, identify, freqresp, predict, compare, diagnose, add, refine, excite, simulate, report):
    app.command()(command)


@app.callback(invoke_without_command=True)
def _version(version: bool = typer.Option(False, "--version", help="Print the version and stop.")) -> None:
    if version:
        from chebid import __version__

        typer.echo(f"chebid {__version__}")
        raise typer.Exit


def main() -> None:
    """Entry point of the console script: run, and end with the exit status of the agreement."""
    sys.exit(run(sys.argv[1:]))


def run(arguments: list[str]) -> int:
    """`chebid ARGUMENTS` in this process: the exit status."""
    # small problems are slower on two threads than on one, and on a busy machine far slower
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    debug, quiet = "--debug" in arguments, "--quiet" in arguments
    os.environ["CHEBID_QUIET"] = "1" if quiet else ""
    arguments = [argument for argument in arguments if argument not in ("--debug", "--quiet")]
    return _run(arguments, debug)


def _run(arguments: list[str], debug: bool) -> int:
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a name that the terminal cannot show is no reason to stop
    try:
        # not app(): it has an opinion of its own on closed pipes and interruptions
        command = typer.main.get_command(app)
        with command.make_context("chebid", arguments) as context:
            command.invoke(context)
        sys.stdout.flush()
        return 0
    except typer.Exit as stop:
        return stop.exit_code
    except ChebidError as err:
        if debug:
            raise
        return _report(str(err), err.hint, err.status)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        return _report("interrupted", "nothing was written", 130)
    except MemoryError:
        return _report("not enough memory", "use a part of the log, or a machine with more memory", 1)
    except Exception as err:
        return _unexpected(err, debug)


def _unexpected(err: Exception, debug: bool) -> int:
    """Wrong usage as the option parser reports it; anything else is a bug, and says so."""
    kind, message = type(err).__name__, getattr(err, "format_message", None)
    if kind == "NoArgsIsHelpError":
        sys.stderr.write(f"{err}\n")
        return 2
    if callable(message):
        command = getattr(getattr(err, "ctx", None), "command_path", "chebid")
        return _report(message(), f"see {command} --help", 2)
    if kind == "Abort":
        return _report("stopped", "nothing was written", 1)
    if debug:
        raise err
    return _report(f"{kind}: {err}", "this is a bug in chebid: run again with --debug and report it", 1)


def _report(message: str, hint: str, status: int) -> int:
    one_line = " ".join(message.split())
    sys.stderr.write(f"error: {one_line}\nhint: {' '.join(hint.split())}\n")
    return status
