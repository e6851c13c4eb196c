"""The documents name what there is: links, paths, commands and targets of every page."""

import contextlib
import io
import re
import shutil
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from reflexarc.main import main
from reflexarc_sim_bridge.evaluation.metrics.figures import FIGURES
from support.policies import SMALL, exported

ROOT = Path(__file__).parents[2]
FOLDERS = (
    "baselines",
    "benchmarks",
    "cli",
    "docs",
    "logs",
    "pictures",
    "runtime",
    "sim_bridge",
    "tests",
    "trainer",
)
PAGES = sorted([*ROOT.glob("*.md"), *(page for f in FOLDERS for page in (ROOT / f).rglob("*.md"))])
README_LINES = 150

CODE = re.compile(r"```.*?```|`[^`\n]+`", re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)
COMMAND = re.compile(r"\breflexarc ([a-z][a-z0-9]*)\b")
TARGET = re.compile(r"(?:^|`)make ([a-z][a-z-]*)", re.MULTILINE)
PYTHON = re.compile(r"```python\n(.*?)```", re.DOTALL)
WORD = re.compile(r"[\w./*…<>-]+")

each_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))


def test_the_readme_is_a_front_page() -> None:
    assert len(text_of(ROOT / "README.md").splitlines()) <= README_LINES


@each_page
def test_every_link_leads_somewhere(page: Path) -> None:
    for link in LINK.findall(CODE.sub("", text_of(page))):
        if link.startswith(("http:", "https:")):
            continue
        place, _, anchor = link.partition("#")
        target = (page.parent / place).resolve() if place else page
        assert target.exists(), f"{page}: expected a file at the end of {link}"
        assert not anchor or anchor in anchors(target), f"{page}: no such heading: {link}"


@each_page
def test_every_path_in_code_exists(page: Path) -> None:
    missing = [path for path in paths_in(page) if not exists(path)]
    assert not missing, f"{page}: expected paths of today, got {missing}"


@each_page
def test_every_command_and_target_in_code_is_one(page: Path) -> None:
    code = "\n".join(CODE.findall(text_of(page)))
    targets = set(re.findall(r"^([a-z-]+):", text_of(ROOT / "Makefile"), re.MULTILINE))
    assert not [word for word in set(COMMAND.findall(code)) if not is_command(word)]
    assert set(TARGET.findall(code)) <= targets


@pytest.mark.parametrize("page", ["README.md", "docs/tour.md"])
def test_the_first_lines_of_python_run(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    policy = tmp_path / "runs" / "reflex-0" / "policy.onnx"
    policy.parent.mkdir(parents=True)
    policy.write_bytes(exported(SMALL))
    shutil.copy(ROOT / "tests" / "golden" / "nominal.mcap", tmp_path / "runs" / "drive.mcap")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(PYTHON.findall(text_of(ROOT / page))[0], names)
    assert names["actions"].shape == (1,)
    assert names["report"].exit_status == 0


def test_the_rooms_are_described_as_their_contracts_say() -> None:
    said = text_of(ROOT / "CONTRIBUTING.md")
    missing = [row for row in contract_rows() if row not in said]
    assert not missing, f"CONTRIBUTING.md: expected the rows {missing}"


def text_of(page: Path) -> str:
    return page.read_text(encoding="utf-8")


@cache
def is_command(word: str) -> bool:
    """Whether `reflexarc` knows it."""
    with contextlib.redirect_stdout(io.StringIO()), pytest.raises(SystemExit) as end:
        main([word, "--help"])
    return end.value.code == 0


def contract_rows() -> Iterator[str]:
    """What may import what inside each package, as rows of a table, out of pyproject.toml."""
    project = tomllib.loads(text_of(ROOT / "pyproject.toml"))
    for contract in project["tool"]["importlinter"]["contracts"]:
        for package in contract.get("containers", ()):
            layers = [layer.replace(" | ", "` \\| `") for layer in contract["layers"]]
            yield f"| `{package}` | {' › '.join(f'`{layer}`' for layer in layers)} |"


def anchors(page: Path) -> set[str]:
    """Anchors of a page's headings, as GitHub makes them."""
    return {
        re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")
        for heading in HEADING.findall(text_of(page))
    }


def paths_in(page: Path) -> Iterator[str]:
    """Words in code that begin with a folder of ours, and names of Python files without one."""
    for code in CODE.findall(text_of(page)):
        for word in WORD.findall(code):
            is_ours = word.partition("/")[0] in FOLDERS and "/" in word
            is_module = word.endswith(".py") and "/" not in word
            if (is_ours or is_module) and "<" not in word:
                yield word.rstrip(".")


def exists(path: str) -> bool:
    """Whether a path is there; … stands for folders, and a name alone may be in any of them."""
    if "/" not in path:
        return any(next((ROOT / folder).rglob(path), None) for folder in FOLDERS)
    return next(ROOT.glob(path.replace("…", "**").rstrip("/")), None) is not None


def test_the_evaluation_page_lists_every_figure_as_the_table_of_figures_does() -> None:
    page = (ROOT / "docs" / "evaluation.md").read_text()
    for name, figure in FIGURES.items():
        assert f"| `{name}` | {figure.title} | {figure.unit or '1'} |" in page, name
