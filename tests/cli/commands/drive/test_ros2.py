import pytest

from reflexarc.main import main

SLOW = ["--max-linear", "0.5", "--max-lateral", "0", "--max-angular", "1"]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--topic", "a b"], "--topic"),
        (["--command", "~/x"], "--command"),
        (["--wire", "rmw", "--domain", "233"], "--domain"),
        (["--wire", "dds"], "--wire"),
        (["--rate", "nan"], "--rate"),
        (["--stamp", "arrival"], "--stamp"),
        (["--wire", "rmw", "--node", "1eye"], "--node"),
        (["--distribution", "foxy"], "--distribution"),
        (["--odometry", "a b"], "--odometry"),
        (["--tf", "robot0/tf"], "--robot"),
        (["--odometry", "robot0/pose"], "--robot"),
        (["--topic", "robot0/scan"], "--robot"),
        (["--command", "robot0/command"], "--robot"),
        ([*SLOW, "--zenoh", "none.json5"], "no such file"),
        ([], "--max-linear"),
        (SLOW[:4], "got no --max-angular"),
        ([*SLOW, "--max-linear", "nan"], "--max-linear"),
        ([*SLOW, "--max-lateral=-1"], "--max-lateral"),
        ([*SLOW, "--max-validity", "0"], "--max-validity"),
        (["--limits", "none.toml"], "none.toml: cannot be read"),
    ],
)
def test_what_cannot_work_is_said_in_one_line(
    words: list[str], expected: str, capsys: pytest.CaptureFixture[str]
):
    try:
        status = main(["ros2", *words])
    except SystemExit as end:
        status = end.code
    said = capsys.readouterr().err
    assert status == 2
    assert expected in said
    assert len(said.strip().splitlines()) == 1
