from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import Console

from reflexarc.terminal.log_description import describe_log
from reflexarc_logs.reading.summary import summarise
from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.messages.body_info import BodyInfo

GOLDEN = Path(__file__).parents[2] / "golden"
DRIVEN = BodyInfo("crossing", 'name = "crossing"', 7, 1, 0.02, BodyLimits(1.0, 0.5, 0.0))


def described(log: Path, body: BodyInfo | None) -> list[str]:
    """What a terminal of 80 columns shows, each line without runs of spaces."""
    console = Console(width=80, highlight=False, color_system=None)
    with console.capture() as capture:
        console.print(describe_log(log, replace(summarise(log), body=body)))
    return [" ".join(line.split()) for line in capture.get().splitlines()]


@pytest.mark.parametrize(
    ("body", "world", "limits"),
    [
        (
            DRIVEN,
            "world crossing, seed 7, robot number 1, steps of 0.02 s",
            "limits 1 m/s ahead, 0.5 m/s sideways, 0 rad/s",
        ),
        (
            BodyInfo(),
            "world none: the body is not simulated",
            "limits none of the body's own",
        ),
    ],
)
def test_a_person_reads_where_it_was_driven_and_how_fast_it_could(
    body: BodyInfo, world: str, limits: str
):
    said = described(GOLDEN / "nominal.mcap", body)
    assert world in said
    assert limits in said


def test_a_log_that_does_not_say_where_says_that():
    said = described(GOLDEN / "nominal.mcap", None)
    assert "world not recorded" in said
    assert "rules version 3 of the controller's" in said


def test_the_names_of_messages_are_whole_in_80_columns():
    said = described(GOLDEN / "museum" / "schema-2" / "drive.mcap", None)
    assert "/robot0/tf foxglove.FrameTransform 184 49.5 Hz 10.2 KiB" in said
    assert "rules version 1 of the controller's" in said
