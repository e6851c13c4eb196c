"""Who shall be measured, by a text; and how it is told apart from what it was before."""

from pathlib import Path

import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.protocol.entrant import Entrant
from support.small_suite import write_small_suite

MUSEUM = Path(__file__).parents[3] / "golden" / "museum"
ROVER = str(MUSEUM / "schema-2" / "rover.onnx")


def test_file_is_told_apart_by_its_bytes() -> None:
    rover = Entrant("rover", ROVER)
    assert not rover.is_code
    assert rover.content_hash() == rover.contender().policy.policy_hash  # type: ignore[union-attr]  # a file's
    assert rover.contender().name == "rover"
    assert rover.contender().turns


def test_class_is_told_apart_by_the_text_of_its_file(tmp_path: Path) -> None:
    _, controllers = write_small_suite(tmp_path)
    mine = Entrant("mine", f"{controllers}:Mine")
    before = mine.content_hash()
    assert mine.is_code
    assert mine.content_hash() == before
    controllers.write_text(controllers.read_text() + "# more\n")
    assert mine.content_hash() != before


def test_class_of_a_package_is_told_apart_by_what_lies_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "told_apart_package"
    package.mkdir()
    (package / "__init__.py").write_text("")
    write_small_suite(package)
    (package / "weights.npy").write_bytes(b"1")
    monkeypatch.syspath_prepend(str(tmp_path))
    mine = Entrant("mine", "told_apart_package.small_controllers:Mine")
    before = mine.content_hash()
    (package / "weights.npy").write_bytes(b"2")
    assert mine.content_hash() != before


def test_rate_is_that_of_the_contender_and_not_of_its_file() -> None:
    assert Entrant("r", ROVER, rate_hz=7.0).contender().contract.rate_hz == 7.0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("class Mine: pass", "`contract` and `decide`"),
        ("raise RuntimeError('never\\nmind')", "got RuntimeError: never"),
        ("class Mine:\n    def __init__(self, x): pass", "got TypeError"),
        ("Mine = ", "got SyntaxError"),
        ("", "got AttributeError"),
    ],
)
def test_code_that_makes_no_policy_is_one_line(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "bad.py").write_text(text)
    with pytest.raises(UsageError, match=said) as caught:
        Entrant("bad", f"{tmp_path / 'bad.py'}:Mine").contender()
    assert "\n" not in str(caught.value)
