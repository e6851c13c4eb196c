"""All commands in groups, and the help that shows them so."""

from typing import Any

from rich.console import Group
from rich.padding import Padding
from rich.table import Table

from reflexarc.commands.demo import DemoCommand
from reflexarc.commands.drive.camera import CameraCommand
from reflexarc.commands.drive.operate import (
    ArmCommand,
    ReleaseCommand,
    ResetCommand,
    StopCommand,
)
from reflexarc.commands.drive.ros2 import Ros2Command
from reflexarc.commands.drive.run import RunCommand
from reflexarc.commands.drive.sim import SimCommand
from reflexarc.commands.learn.baselines import BaselinesCommand
from reflexarc.commands.learn.evaluate import EvaluateCommand
from reflexarc.commands.learn.export import ExportCommand
from reflexarc.commands.learn.study import StudyCommand
from reflexarc.commands.learn.train import TrainCommand
from reflexarc.commands.remember.check import CheckCommand
from reflexarc.commands.remember.cut import CutCommand
from reflexarc.commands.remember.decide import DecideCommand
from reflexarc.commands.remember.diff import DiffCommand
from reflexarc.commands.remember.import_log import ImportCommand
from reflexarc.commands.remember.incident import IncidentCommand
from reflexarc.commands.remember.info import InfoCommand
from reflexarc.commands.remember.join import JoinCommand
from reflexarc.commands.remember.mark import MarkCommand
from reflexarc.commands.remember.play import PlayCommand
from reflexarc.commands.remember.record import RecordCommand
from reflexarc.commands.remember.recover import RecoverCommand
from reflexarc.commands.remember.render import RenderCommand
from reflexarc.commands.remember.replay import ReplayCommand
from reflexarc.commands.remember.view import ViewCommand
from reflexarc.commands.service.doctor import DoctorCommand
from reflexarc.commands.service.secure import SecureCommand
from reflexarc.commands.service.service import ServiceCommand
from reflexarc.commands.service.swap import SwapCommand
from reflexarc.commands.service.top import TopCommand
from reflexarc.commands.worlds.worlds import WorldsCommand
from reflexarc.one_command import CliCommand, description_of, name_of

__all__ = ["COMMANDS", "DESCRIPTION", "GROUPS", "name_of", "overview", "summary_of"]


GROUPS: dict[str, tuple[type[CliCommand], ...]] = {
    "Everything in one go": (DemoCommand,),
    "Learn and measure": (
        TrainCommand,
        ExportCommand,
        EvaluateCommand,
        BaselinesCommand,
        StudyCommand,
    ),
    "Worlds": (WorldsCommand,),
    "Drive": (
        SimCommand,
        Ros2Command,
        CameraCommand,
        RunCommand,
        ArmCommand,
        StopCommand,
        ResetCommand,
        ReleaseCommand,
    ),
    "In service": (ServiceCommand, SecureCommand, SwapCommand, DoctorCommand, TopCommand),
    "Logs": (
        RecordCommand,
        MarkCommand,
        PlayCommand,
        ReplayCommand,
        RenderCommand,
        ViewCommand,
        ImportCommand,
        CutCommand,
        JoinCommand,
        IncidentCommand,
        DecideCommand,
        DiffCommand,
        CheckCommand,
        RecoverCommand,
        InfoCommand,
    ),
}
"""The title of each group → its commands, in the order in which the help shows them."""

COMMANDS = tuple(command for commands in GROUPS.values() for command in commands)

DESCRIPTION = "A learned reflex for robots: train, export, run, record, replay."


def summary_of(command: type[CliCommand]) -> str:
    """The first paragraph of a command's description, on one line."""
    return description_of(command).partition("\n\n")[0].replace("\n", " ")


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
