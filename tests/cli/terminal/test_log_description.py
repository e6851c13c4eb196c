from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from reflexarc.terminal.log_description import describe_log
from reflexarc.terminal.plain_console import PlainConsole
from reflexarc_logs.reading.summary import summarise
from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.contract.body_spec import Footprint
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.messages.body_info import BodyInfo

GOLDEN = Path(__file__).parents[2] / "golden"
DRIVEN = BodyInfo("crossing", 'name = "crossing"', 7, 1, 0.02, BodyLimits(1.0, 0.5, 0.0))


def described(log: Path, body: BodyInfo | None, **known: Any) -> list[str]:
    """What a terminal of 80 columns shows, each line without runs of spaces."""
    console = PlainConsole(width=80, color_system=None)
    with console.capture() as capture:
        console.print(describe_log(log, replace(summarise(log), body=body, **known)))
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
            replace(DRIVEN, limits=BodyLimits(1.0, 0.5, 0.0, 0.8, 0.1)),
            "world crossing, seed 7, robot number 1, steps of 0.02 s",
            "limits 1 m/s ahead, 0.5 m/s sideways, 0 rad/s, faster by at most 0.8 m/s²,",
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


def test_a_person_reads_what_looked_at_the_decisions_and_at_the_loop():
    guard = GuardSettings(0.07, Footprint(radius_m=0.2), 0.04, 2.5)
    log = GOLDEN / "nominal.mcap"
    said = " ".join(described(log, DRIVEN, guard=guard, watchdog="on, 50 ms"))
    for words in (
        "guard keeps 0.07 m, prefers what is free 0.3 s longer; slower or other actions; ",
        "for a circle of 0.2 m that obeys after 0.04 s and stops at 2.5 m/s²",
        "watchdog on, 50 ms",
    ):
        assert words in said
    without = described(log, DRIVEN)
    assert "guard none" in without
    assert "watchdog not recorded" in without


def test_a_person_reads_whether_a_tick_began_at_an_input():
    at_inputs = " ".join(described(GOLDEN / "nominal.mcap", None, pace="input"))
    assert "clock, a tick at an input" in at_inputs
    assert "at an input" not in " ".join(described(GOLDEN / "nominal.mcap", None, pace="rate"))


def test_a_log_that_does_not_say_where_says_that():
    said = described(GOLDEN / "nominal.mcap", None)
    assert "world not recorded" in said
    assert "rules version 5 of the controller's" in said


def test_the_names_of_messages_are_whole_in_80_columns():
    said = described(GOLDEN / "museum" / "schema-2" / "drive.mcap", None)
    assert "/robot0/tf foxglove.FrameTransform 184 49.5 Hz 10.2 KiB" in said
    assert "rules version 1 of the controller's" in said
