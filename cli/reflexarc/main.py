"""The front door: one command, each of its subcommands loaded from its room only when used.

Exit status: 0 success, 1 the answer is no, 2 wrong use or bad input, said in one line.
"""

import contextlib
import io
import logging
import re
import sys
from collections.abc import Sequence
from typing import Annotated, Any

import tyro

from reflexarc.commands.demo import Demo
from reflexarc.commands.evaluate import Evaluate
from reflexarc.commands.export import Export
from reflexarc.commands.info import Info
from reflexarc.commands.record import Record
from reflexarc.commands.recover import Recover
from reflexarc.commands.replay import Replay
from reflexarc.commands.run import Run
from reflexarc.commands.sim import Sim
from reflexarc.commands.train import Train
from reflexarc_runtime.errors import ReflexarcError

COMMANDS = (Demo, Train, Export, Evaluate, Sim, Run, Record, Replay, Recover, Info)
BAD_INPUT = 2

DESCRIPTION = "A learned reflex for robots: train, export, run, record, replay."


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status."""
    logging.basicConfig(format="reflexarc: %(message)s", level=logging.WARNING)
    words = list(sys.argv[1:] if arguments is None else arguments) or ["--help"]
    try:
        return _parse(words).run()
    except ReflexarcError as error:
        return _refuse(str(error))
    except ModuleNotFoundError as error:
        return _refuse(_explain_missing(error))
    except BrokenPipeError:
        sys.stderr.close()  # the reader went away; nothing is left to say, and nobody to hear it
        return 0
    except KeyboardInterrupt:
        return 130


def _parse(words: list[str]) -> Any:
    """Parse the command line; tyro's framed complaints become one line."""
    complaint = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaint):
            return tyro.cli(
                _any_command(),
                prog="reflexarc",
                description=DESCRIPTION,
                args=words,
                config=(tyro.conf.FlagCreatePairsOff, tyro.conf.OmitArgPrefixes),
            )
    except SystemExit as end:
        if end.code:
            raise SystemExit(_refuse(_one_line(complaint.getvalue()))) from None
        raise


def _any_command() -> Any:
    choices = tuple(
        Annotated[kind, tyro.conf.subcommand(name=kind.__name__.lower())] for kind in COMMANDS
    )
    union: Any = choices[0]
    for choice in choices[1:]:
        union = union | choice
    return union


def _one_line(complaint: str) -> str:
    """The words of a framed message, without its frame."""
    words = re.sub(r"[^\x20-\x7e]|[─-╿]", " ", complaint)
    return re.sub(r"-{3,}", " ", re.sub(r"\s+", " ", words)).strip()


def _explain_missing(error: ModuleNotFoundError) -> str:
    extra = "train" if error.name in ("torch", "matplotlib") else "sim"
    return (
        f"this command needs {error.name}, which is not installed here; "
        f"install the extra: pip install 'reflexarc[{extra}]'"
    )


def _refuse(reason: str) -> int:
    print(f"reflexarc: {reason}", file=sys.stderr)
    return BAD_INPUT
