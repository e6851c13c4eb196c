import re

import pytest
from rich.console import Console

from reflexarc.command_groups import COMMANDS, GROUPS, name_of, overview, summary_of
from reflexarc.main import main

NAMES = [name_of(command) for command in COMMANDS]


def test_help_shows_every_command_once_in_its_group_and_the_demo_first():
    console = Console(width=400, color_system=None)
    with console.capture() as capture:
        console.print(overview())
    sections = capture.get().split("\n\n")[2:-1]
    assert [section.partition(":\n")[0] for section in sections] == list(GROUPS)
    for section, commands in zip(sections, GROUPS.values(), strict=True):
        shown = [line.split(None, 1) for line in section.splitlines()[1:]]
        assert [(name, text.strip()) for name, text in shown] == [
            (name_of(command), summary_of(command)) for command in commands
        ]
    assert NAMES[0] == "demo"


def test_the_folders_of_the_commands_are_the_groups():
    for commands in GROUPS.values():
        folders = {re.sub(r"\.[^.]+$", "", command.__module__) for command in commands}
        assert len(folders) == 1


@pytest.mark.parametrize("command", NAMES)
def test_every_command_says_what_it_is_with_examples(
    command: str, capsys: pytest.CaptureFixture[str]
):
    with pytest.raises(SystemExit) as end:
        main([command, "--help"])
    said = capsys.readouterr().out
    assert end.value.code == 0
    assert "Examples:" in said
    assert f"reflexarc {command}" in said.partition("Examples:")[2]
