"""The page of all studies, from what was run and what was run before."""

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

from reflexarc_trainer.study.shipped import study_named
from reflexarc_trainer.study.study import PAGE, PICTURE

SCRIPT = Path(__file__).parents[2] / "docs" / "studies_page.py"


@pytest.fixture
def script(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    spec = importlib.util.spec_from_file_location("studies_page", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "PAGES", tmp_path / "studies")
    monkeypatch.setattr(module, "study_names", lambda: ("alpha", "edge", "gamma"))
    return module


def run_of(runs: Path, name: str, done: int | None = None) -> None:
    study, folder = study_named(name), runs / f"study-{name}"
    units = len(study.cells) * len(study.seeds)
    folder.mkdir(parents=True)
    done = units if done is None else done
    origin = f"## Where it comes from\n\n| runs | {done} of {units} |\n"
    text = f"# Of {name}\n\nNew.\n\n![T]({PICTURE})\n\n{origin}"
    (folder / PAGE).write_text(text)
    (folder / PICTURE).write_bytes(b"png")


def test_a_study_that_was_not_run_here_keeps_its_page(script: ModuleType, tmp_path: Path) -> None:
    run_of(tmp_path / "runs", "alpha")
    run_of(tmp_path / "runs", "edge", done=1)
    pages = tmp_path / "studies"
    pages.mkdir()
    (pages / "edge.md").write_text("# Of edge\n\nOld.\n\n## Where it comes from\n\nThen.\n")
    assert script.main(tmp_path / "runs") == 1
    page = (pages / "README.md").read_text()
    assert "## Of alpha\n\nNew.\n\n![T](alpha.png)" in page
    assert "## Of edge\n\nOld." in page
    assert "Then." not in page
    assert "Not run to their end yet: gamma." in page
    assert (pages / "edge.md").read_text().endswith("Then.\n")
    assert (pages / "alpha.png").read_bytes() == b"png"
