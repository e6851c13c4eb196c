"""What the front door says when a module is missing, against what the extras really bring."""

import re
import subprocess
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from reflexarc import main as front_door

PYPROJECT = Path(__file__).parents[2] / "pyproject.toml"
WITHOUT = """
import sys

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name == sys.argv[1]:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Missing())
from reflexarc.main import main
raise SystemExit(main(sys.argv[2:]))
"""


def refused_without(module: str, *words: str, cwd: Path) -> str:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT, module, *words], capture_output=True, text=True, cwd=cwd
    )
    assert (done.returncode, done.stdout) == (2, "")
    (line,) = done.stderr.strip().splitlines()
    assert line.startswith(f"reflexarc: {words[0]}: expected the module {module}, found none; ")
    return line


@pytest.mark.parametrize(
    ("module", "words", "extra"),
    [
        ("numba", "worlds check plane --seeds 2", "sim"),
        ("numba", "render plane -o x.png", "pictures"),
        ("numba", "train --steps 9", "train"),
        ("matplotlib", "worlds check plane --seeds 2 -o x.png", "pictures"),
        ("matplotlib", "render plane -o x.png", "pictures"),
        ("matplotlib", "train --steps 9", "train"),
        ("PIL", "render plane -o x.gif --seconds 1", "pictures"),
        ("torch", "train --steps 9", "train"),
        ("torch", "export x.npz -o x.onnx", "train"),
        ("torch", "study hidden", "train"),
        ("rosbags", "import ros2bag x -o y.mcap", "ros2"),
        ("rosbags", "export ros2bag x.mcap -o y", "ros2"),
        ("pyarrow", "export parquet x.mcap -o y.parquet", "parquet"),
        ("rerun", "view x.mcap", "view"),
        ("torch", "demo", "train"),
        ("rosbags", "ros2", "ros2"),
        ("cv2", "camera 0", "camera"),
    ],
)
def test_without_a_module_a_command_names_the_extra_to_install(
    tmp_path: Path, module: str, words: str, extra: str
):
    said = refused_without(module, *words.split(), cwd=tmp_path)
    assert said.endswith(f"install the extra: pip install 'reflexarc[{extra}]'")


def test_without_a_module_of_every_installation_no_extra_is_named(tmp_path: Path):
    said = refused_without("mcap", "replay", "x.mcap", cwd=tmp_path)
    assert said.endswith("install reflexarc again")


def brought_by(extra: str) -> set[str]:
    """The distributions that an extra names, those of the extras in it among them."""
    extras = tomllib.loads(PYPROJECT.read_text())["project"]["optional-dependencies"]
    found = set()
    for requirement in extras[extra]:
        inner = re.fullmatch(r"reflexarc\[(.*)\]", requirement)
        names = set().union(*map(brought_by, inner[1].split(","))) if inner else {requirement}
        found |= {re.split(r"[<>=]", name)[0].lower() for name in names}
    return found


@pytest.mark.parametrize("extra", front_door.EXTRAS)
def test_every_extra_brings_the_modules_that_it_is_named_for(extra: str):
    homes = packages_distributions()
    for module in front_door.EXTRAS[extra]:
        if module not in homes:
            pytest.skip(f"{module} is not installed here")  # `view` is large: dev leaves it out
        distributions = {name.lower() for name in homes[module]}
        through_matplotlib = {"pillow"} if "matplotlib" in brought_by(extra) else set()
        assert distributions & (brought_by(extra) | through_matplotlib), module


@pytest.mark.parametrize("word", ["--help", "-h", None])
def test_help_is_an_answer_and_no_error(word: str | None, capsys: pytest.CaptureFixture[str]):
    assert front_door.main([word] if word else []) == 0
    assert "usage: reflexarc COMMAND" in capsys.readouterr().out


def test_an_unknown_command_is_refused_in_one_line(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as end:
        front_door.main(["fly"])
    assert end.value.code == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert "fly" in line


HEAVY = """
import sys
from reflexarc.main import main
main(["--help"])
heavy = ("numpy", "numba", "torch", "zenoh", "matplotlib")
print(*[name for name in heavy if name in sys.modules])
"""


def test_help_loads_nothing_heavy():
    done = subprocess.run([sys.executable, "-c", HEAVY], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == ""
