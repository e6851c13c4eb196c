"""The command line: parses it, runs one command, and turns every error into one line.

A command imports what it needs only when it runs. Exit status: 0 success, 1 the answer is no, 2
wrong use or bad input.
"""

import contextlib
import errno
import io
import logging
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import tyro

from reflexarc.config_file.reading import config_in, settings_of
from reflexarc.loading import uncollected
from reflexarc.one_command import description_of, found_by_name, name_of
from reflexarc.terminal.compilation import show_compilation
from reflexarc.terminal.complaint import in_one_line
from reflexarc.terminal.output import console
from reflexarc.terminal.plain_console import accept_every_word, to_nowhere
from reflexarc_runtime.errors import ReflexarcError
from reflexarc_runtime.words.shown import plain, shown

BAD_INPUT = 2

_SIM = ("numba", "llvmlite", "gymnasium")
EXTRAS = {
    "sim": _SIM,
    "pictures": (*_SIM, "matplotlib", "PIL"),
    "train": (*_SIM, "matplotlib", "PIL", "torch"),
    "ros2": ("rosbags",),
    "camera": ("cv2",),
    "parquet": ("pyarrow",),
    "view": ("rerun",),
    "secure": ("cryptography",),
    "metrics": ("prometheus_client",),
}
"""Extra → the modules that it brings, smaller extras first. `train --tensorboard` names its own."""

NEEDS = {
    **dict.fromkeys(("demo", "train", "export", "study"), "train"),
    "render": "pictures",
    "ros2": "ros2",
    "camera": "camera",
    "view": "view",
    "secure": "secure",
}
"""Command → the extra with all that it needs; it is named whichever of these is missing."""

_NO_DEFAULT = tyro.MISSING_NONPROP
_STYLE = (tyro.conf.FlagCreatePairsOff, tyro.conf.OmitArgPrefixes, tyro.conf.DisallowNone)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status."""
    accept_every_word()
    logging.basicConfig(handlers=[_handler()], level=logging.WARNING)
    _quieten_threads()
    words = list(sys.argv[1:] if arguments is None else arguments) or ["--help"]
    try:
        status = _answer(words)
        _flush()
        return status
    except ReflexarcError as error:
        return _refuse(str(error))
    except ModuleNotFoundError as error:
        return _refuse(_explain_missing(error, words[0]))
    except OSError as error:
        if isinstance(error, BrokenPipeError) or error.errno == errno.EIO:
            return _end_without_reader()  # the reader, or the terminal, is gone
        return _refuse(f"{error.filename or 'system'}: {error.strerror or error}")
    except KeyboardInterrupt:
        return 130


def _answer(words: list[str]) -> int:
    if words[0] in ("-h", "--help"):
        from reflexarc.command_groups import overview

        console.print(overview())
        return 0
    with uncollected():
        command = _parse(words)
    with show_compilation():
        status: int = command.run()
    return status


def _handler() -> logging.Handler:
    """What is logged, in which names from outside stand, as it is shown elsewhere."""
    handler = logging.StreamHandler()
    handler.setFormatter(_ShownFormatter("reflexarc: %(message)s"))
    return handler


class _ShownFormatter(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        return shown(super().format(record))


def _flush() -> None:
    """Write what is still held back; that nobody reads it any more changes no answer."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        to_nowhere(sys.stdout)


def _quieten_threads() -> None:
    """Configure the threads of NumPy and numba before they load: one each, idle while they wait."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")


def _parse(words: list[str]) -> Any:
    """Parse the command line; tyro's framed complaints become one line."""
    complaint = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaint):
            return _parsed(words, config_in(words))
    except SystemExit as end:
        if end.code:
            said = in_one_line(complaint.getvalue(), words[0])
            raise SystemExit(_refuse(said)) from None
        raise


def _parsed(words: list[str], config: Path | None) -> Any:
    """The command that is asked for; only where none has that name, all are looked at.

    Its defaults are those of a file, where there is one and the command takes one.
    """
    command = found_by_name(words[0])
    if command is None:
        from reflexarc.command_groups import DESCRIPTION

        everything = _any_command(words[0])
        return tyro.cli(
            everything, prog="reflexarc", description=DESCRIPTION, args=words, config=_STYLE
        )
    takes_file = config is not None and hasattr(command, "show_config")
    default = settings_of(command, config) if config and takes_file else _NO_DEFAULT
    # A file may have switched on what the command line switches on, or off: both forms are known.
    style = _STYLE[1:] if takes_file else _STYLE
    return tyro.cli(
        command,
        prog=f"reflexarc {words[0]}",
        description=description_of(command),
        args=words[1:],
        default=default,
        config=style,
    )


def _any_command(asked: str) -> Any:
    """The union of all commands, with the full description of the one that is asked for."""
    from reflexarc.command_groups import COMMANDS, summary_of

    union: Any = None
    for command in COMMANDS:
        name = name_of(command)
        description = description_of(command) if name == asked else summary_of(command)
        choice: Any = Annotated[
            command,
            tyro.conf.subcommand(name, description=description),
        ]
        union = choice if union is None else union | choice
    return union


def _explain_missing(error: ModuleNotFoundError, command: str) -> str:
    module = (error.name or "").partition(".")[0]
    extras = [extra for extra, modules in EXTRAS.items() if module in modules]
    if not extras:  # what every installation has: this one is damaged
        return f"{command}: expected the module {module}, found none; install reflexarc again"
    extra = NEEDS[command] if NEEDS.get(command) in extras else extras[0]
    return (
        f"{command}: expected the module {module}, found none; "
        f"install the extra: pip install 'reflexarc[{extra}]'"
    )


def _end_without_reader() -> int:
    """End quietly when the reader of the output is gone, also at Python's last flush."""
    to_nowhere(sys.stdout)
    to_nowhere(sys.stderr)
    return 0


def _refuse(reason: str) -> int:
    print(plain(f"reflexarc: {reason}"), file=sys.stderr)
    return BAD_INPUT
