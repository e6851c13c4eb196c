"""One command by its name, without loading the others.

A command `recover` stands in a file `recover.py` of one of the folders of commands, as
`RecoverCommand`. Where a file is called otherwise, or holds several, nothing is found here, and all
of them are loaded.
"""

from importlib import import_module
from inspect import cleandoc
from pathlib import Path
from typing import Protocol

FOLDER = Path(__file__).parent / "commands"


class CliCommand(Protocol):
    """A command: a dataclass whose fields are its flags."""

    def run(self) -> int:
        """Run the command; return the exit status."""
        ...


def name_of(command: type[CliCommand]) -> str:
    """The word that starts a command."""
    return command.__name__.removesuffix("Command").lower()


def description_of(command: type[CliCommand]) -> str:
    """The description of a command, with its examples."""
    return cleandoc(command.__doc__ or "")


def found_by_name(name: str) -> type[CliCommand] | None:
    """The command of this name, if it stands in a file of this name; None if there is none."""
    if not (name.isidentifier() and name.isascii()):
        return None
    for file in (FOLDER / f"{name}.py", *FOLDER.glob(f"*/{name}.py")):
        if file.is_file():
            inner = file.relative_to(FOLDER).with_suffix("").parts
            module = import_module(".".join(["reflexarc.commands", *inner]))
            command: type[CliCommand] | None = getattr(module, f"{name.capitalize()}Command", None)
            return command
    return None
