"""All commands in groups, and the help that shows them so."""

from inspect import cleandoc
from typing import Any, Protocol

from rich.console import Group
from rich.padding import Padding
from rich.table import Table

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


class Command(Protocol):
    """A command: a dataclass whose fields are its flags."""

    def run(self) -> int:
        """Do it; returns the exit status."""
        ...


GROUPS: dict[str, tuple[type[Command], ...]] = {
    "Everything in one go": (Demo,),
    "Learn and measure": (Train, Export, Evaluate, Study),
    "Worlds": (Worlds,),
    "Drive": (Sim, Ros2, Camera, Run),
    "Logs": (Record, Play, Replay, Render, Import, Recover, Info),
}
"""The title of each group → its commands, in the order in which the help shows them."""

COMMANDS = tuple(command for commands in GROUPS.values() for command in commands)

DESCRIPTION = "A learned reflex for robots: train, export, run, record, replay."


def name_of(command: type[Command]) -> str:
    """The word that calls a command."""
    return command.__name__.lower()


def summary_of(command: type[Command]) -> str:
    """The first paragraph of what a command says of itself, on one line."""
    return description_of(command).partition("\n\n")[0].replace("\n", " ")


def description_of(command: type[Command]) -> str:
    """All that a command says of itself."""
    return cleandoc(command.__doc__ or "")


def overview() -> Group:
    """What `reflexarc --help` shows: the commands, group by group."""
    parts: list[Any] = ["usage: reflexarc COMMAND …", "", DESCRIPTION]
    width = max(len(name_of(command)) for command in COMMANDS)
    for title, commands in GROUPS.items():
        table = Table.grid(padding=(0, 2, 0, 0))
        table.add_column(style="bold", width=width)
        table.add_column()
        for command in commands:
            table.add_row(name_of(command), summary_of(command))
        parts += ["", f"{title}:", Padding(table, (0, 0, 0, 2))]
    return Group(*parts, "", "`reflexarc COMMAND --help` shows flags and examples.")
