"""Every picture that a page shows has the command that draws it, and no other picture is kept.

Nothing is drawn here.
"""

import re
from collections.abc import Iterator
from fnmatch import fnmatch
from pathlib import Path

import pytest

from reflexarc.command_groups import COMMANDS, name_of

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
MAKEFILE = (ROOT / "Makefile").read_text()
ROW = re.compile(r"^\| `(?P<pattern>[^`]+\.(?:png|gif))` \| (?P<words>.*) \|$", re.MULTILINE)
COMMANDS_OF = {
    row["pattern"]: re.findall(r"`([^`]+)`", row["words"])
    for row in ROW.finditer((DOCS / "figures.md").read_text())
}


def shown() -> Iterator[Path]:
    """The pictures of all pages, relative to `docs`."""
    for page in (ROOT / "README.md", *DOCS.rglob("*.md")):
        for place in re.findall(r"!\[[^]]*\]\(([^)#]+)\)", page.read_text()):
            if "://" not in place:
                yield (page.parent / place).resolve().relative_to(DOCS)


SHOWN = sorted(set(shown()))


def targets() -> set[str]:
    return set(re.findall(r"^([a-z-]+):", MAKEFILE, re.MULTILINE))


@pytest.mark.parametrize("picture", SHOWN, ids=str)
def test_a_picture_that_is_shown_is_there_and_has_one_command(picture: Path) -> None:
    assert (DOCS / picture).is_file()
    named = [pattern for pattern in COMMANDS_OF if fnmatch(str(picture), pattern)]
    assert len(named) == 1, f"docs/figures.md: expected a row for {picture}, got {named}"


def test_no_picture_is_kept_that_no_page_shows() -> None:
    kept = {path.relative_to(DOCS) for kind in ("png", "gif") for path in DOCS.rglob(f"*.{kind}")}
    assert kept == set(SHOWN)


@pytest.mark.parametrize("pattern", COMMANDS_OF)
def test_its_commands_exist(pattern: str) -> None:
    assert any(fnmatch(str(picture), pattern) for picture in SHOWN)
    assert COMMANDS_OF[pattern]
    for command in COMMANDS_OF[pattern]:
        program, first, *_ = command.split()
        if program == "make":
            assert first in targets()
        elif program == "python":
            assert (ROOT / first).is_file()
        else:
            assert (program, first) in {("reflexarc", name_of(each)) for each in COMMANDS}


def test_make_figures_runs_the_very_commands_and_draws_to_the_pictures() -> None:
    recipe = MAKEFILE.partition("\nfigures:")[2].partition("\n\n")[0].replace("$(BIN)/", "")
    for pattern, (first, *commands) in COMMANDS_OF.items():
        if first == "make figures":
            (command,) = commands
            assert f"\t{command}\n" in f"{recipe}\n"
            script = command.split()[1]
            drawn_by = (ROOT / script).read_text() if script.endswith(".py") else command
            assert f"docs/{pattern}" in drawn_by


def test_the_page_of_the_environments_shows_the_script_that_draws_its_picture() -> None:
    script = (DOCS / "environment_picture.py").read_text().partition("\n\n")[2]
    assert f"```python\n{script}```" in (DOCS / "environments.md").read_text()
