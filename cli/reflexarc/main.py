"""The front door: one command, each of its subcommands loaded from its room only when used.

Exit status: 0 success, 1 the answer is no, 2 wrong use or bad input, said in one line.
"""

import contextlib
import io
import logging
import os
import re
import sys
from collections.abc import Sequence
from inspect import cleandoc
from typing import Annotated, Any

import tyro

from reflexarc.commands.demo import Demo
from reflexarc.commands.drive.camera import Camera
from reflexarc.commands.drive.ros2 import Ros2
from reflexarc.commands.drive.run import Run
from reflexarc.commands.drive.sim import Sim
from reflexarc.commands.learn.evaluate import Evaluate
from reflexarc.commands.learn.export import Export
from reflexarc.commands.learn.study import Study
from reflexarc.commands.learn.train import Train
from reflexarc.commands.remember.import_log import Import
from reflexarc.commands.remember.info import Info
from reflexarc.commands.remember.play import Play
from reflexarc.commands.remember.record import Record
from reflexarc.commands.remember.recover import Recover
from reflexarc.commands.remember.render import Render
from reflexarc.commands.remember.replay import Replay
from reflexarc.commands.worlds.worlds import Worlds
from reflexarc_runtime.errors import ReflexarcError

COMMANDS = (
    Demo,
    Train,
    Export,
    Evaluate,
    Study,
    Worlds,
    Sim,
    Ros2,
    Camera,
    Run,
    Record,
    Play,
    Replay,
    Render,
    Import,
    Recover,
    Info,
)
BAD_INPUT = 2

_EXTRAS = {
    "torch": "train",
    "rosbags": "ros2",
    "cv2": "camera",
    "tensorboard": "tensorboard",
}
"""Which extra brings a module that no other extra brings."""

_NEEDS = {**dict.fromkeys(("demo", "train", "study", "export"), "train"), "render": "pictures"}
"""Which extra a command needs, where the missing module does not tell."""

_STYLE = (tyro.conf.FlagCreatePairsOff, tyro.conf.OmitArgPrefixes, tyro.conf.DisallowNone)

DESCRIPTION = "A learned reflex for robots: train, export, run, record, replay."


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status."""
    logging.basicConfig(format="reflexarc: %(message)s", level=logging.WARNING)
    _quieten_threads()
    words = list(sys.argv[1:] if arguments is None else arguments) or ["--help"]
    try:
        status: int = _parse(words).run()
        return status
    except ReflexarcError as error:
        return _refuse(str(error))
    except ModuleNotFoundError as error:
        return _refuse(_explain_missing(error, words[0]))
    except OSError as error:
        if isinstance(error, BrokenPipeError):
            return _nobody_listens()
        return _refuse(f"{error.filename or 'system'}: {error.strerror or error}")
    except KeyboardInterrupt:
        return 130


def _quieten_threads() -> None:
    """Before NumPy and numba load: their threads must neither fight nor spin while they wait."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")


def _parse(words: list[str]) -> Any:
    """Parse the command line; tyro's framed complaints become one line."""
    complaint = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaint):
            return tyro.cli(
                _any_command(words[0]),
                prog="reflexarc",
                description=DESCRIPTION,
                args=words,
                config=_STYLE,
            )
    except SystemExit as end:
        if end.code:
            raise SystemExit(_refuse(_one_line(complaint.getvalue()))) from None
        raise


def _any_command(asked: str) -> Any:
    """The union of all commands; the one that is asked for tells all, the others their summary."""
    union: Any = None
    for kind in COMMANDS:
        name, text = kind.__name__.lower(), cleandoc(kind.__doc__ or "")
        description = text if name == asked else text.partition("\n\n")[0].replace("\n", " ")
        choice: Any = Annotated[
            kind,
            tyro.conf.subcommand(name, description=description),
        ]
        union = choice if union is None else union | choice
    return union


def _one_line(complaint: str) -> str:
    """The words of a framed message, without its frame."""
    words = re.sub(r"[^\x20-\x7e]|[─-╿]", " ", complaint)
    return re.sub(r"-{3,}", " ", re.sub(r"\s+", " ", words)).strip()


def _explain_missing(error: ModuleNotFoundError, command: str) -> str:
    module = (error.name or "").partition(".")[0]
    extra = _EXTRAS.get(module) or _NEEDS.get(command)
    extra = extra or ("pictures" if module in ("matplotlib", "PIL") else "sim")
    return (
        f"this command needs {module}, which is not installed here; "
        f"install the extra: pip install 'reflexarc[{extra}]'"
    )


def _nobody_listens() -> int:
    """The reader went away (`| head`): nothing is left to say, and Python must not try at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 0


def _refuse(reason: str) -> int:
    print(f"reflexarc: {reason}", file=sys.stderr)
    return BAD_INPUT
