import pytest

from reflexarc import main as front_door
from reflexarc.main import main


@pytest.mark.parametrize(
    ("module", "words", "extra"),
    [
        ("torch", ["train"], "train"),
        ("numba", ["train"], "train"),
        ("matplotlib", ["train"], "train"),
        ("matplotlib", ["render", "crossing", "-o", "x.png"], "pictures"),
        ("matplotlib.figure", ["worlds", "check", "crossing"], "pictures"),
        ("numba", ["worlds", "check", "crossing"], "sim"),
        ("rosbags.typesys", ["ros2"], "ros2"),
    ],
)
def test_a_missing_module_is_named_with_the_extra_that_brings_what_the_command_needs(
    module: str,
    words: list[str],
    extra: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def fail(_: object) -> None:
        raise ModuleNotFoundError(name=module)

    monkeypatch.setattr(front_door, "_parse", fail)
    assert main(words) == 2
    said = capsys.readouterr().err
    assert f"needs {module.partition('.')[0]}" in said
    assert f"pip install 'reflexarc[{extra}]'" in said
