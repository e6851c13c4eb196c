"""A fleet in a terminal: what fits, what is said of whom, what a stranger's words can do."""

import io

import pytest

from reflexarc.terminal.fleet_table import COLUMNS, fleet_screen, totals_in_words
from reflexarc.terminal.plain_console import PlainConsole
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.fleet.fleet import Fleet
from reflexarc_runtime.messages.wire import Message
from support.fleet_words import BODY, FIRST, SECOND, SECOND_RUNTIME, lease, status


def said_of(robot: str, *, verdict: int = pb.OK) -> list[Message]:
    phases = [
        pb.PhaseTimes(phase="lateness", count=50, p99_ns=310_000),
        pb.PhaseTimes(phase="picture age", count=50, p50_ns=9_100_000, p99_ns=21_000_000),
    ]
    runtime = status(
        robot,
        verdict=verdict,  # type: ignore[arg-type]
        rate_hz=50.0,
        contract_rate_hz=50.0,
        phases=phases,
        action="left",
        policy="reflex-0/policy.onnx",
        guard="on",
        recording="on",
        watchdog="on, 50 ms",
        pace="rate",
        verdicts={"OK": 100},
    )
    return [runtime, lease(robot, holder=FIRST, armed=True)]


def shown(
    messages: list[Message],
    width: int,
    height: int | None = None,
    seconds: float = 0.5,
    *,
    colours: bool = False,
) -> list[str]:
    fleet = Fleet()
    for message in messages:
        fleet.hear(message)
    out = io.StringIO()
    console = PlainConsole(file=out, width=width, height=50, force_terminal=colours)
    view = fleet.view(round(seconds * SECOND))
    console.print(fleet_screen(view, width, height, "reflexarc top"))
    return out.getvalue().rstrip("\n").split("\n")


@pytest.mark.parametrize("width", [20, 40, 60, 80, 100, 120, 160, 200, 300])
def test_no_line_is_wider_than_the_terminal_and_no_cell_is_cut_for_want_of_room(width: int):
    lines = shown([*said_of("robot0"), *said_of("robot1")], width)
    assert max(map(len, lines[:-1])) <= width
    assert not any("…" in line for line in lines[1:4])
    assert lines[2].startswith("robot0")


def test_what_matters_most_is_there_in_80_columns_and_everything_in_200():
    narrow = shown(said_of("robot0"), 80)[1].split()
    for title in ("ROBOT", "HZ", "VERDICT", "ACTION", "LATE", "AGE", "ARMED"):
        assert title in narrow
    wide = shown(said_of("robot0"), 300)[1]
    assert [column.title for column in COLUMNS if column.title not in wide] == []


def test_a_line_says_what_the_robot_does():
    (line,) = (each for each in shown(said_of("robot0"), 120) if each.startswith("robot0"))
    for word in ("50.0", "OK", "left", "310 µs", "9.1 ms", "armed", "held", "on", "0.5 s"):
        assert word in line


def test_verdicts_have_colours_and_the_silent_have_none():
    lively = "\n".join(shown(said_of("r", verdict=pb.OVERRUN), 80, colours=True))
    assert "\x1b[1;31mOVERRUN" in lively
    grey = shown(said_of("r", verdict=pb.OVERRUN), 80, seconds=9.0, colours=True)
    assert "\x1b[90m" in grey[2]
    assert "31m" not in grey[2]
    assert "9.0 s" in grey[2]


def test_a_silent_runtime_is_grey_beside_its_body_that_is_not():
    late = lease("r", holder=FIRST, armed=True, at_s=8.0)
    line = shown([*said_of("r"), late], 80, seconds=9.0, colours=True)[2]
    assert "\x1b[90mOK" in line
    assert "\x1b[32marmed" in line
    assert "free" not in shown([*said_of("r"), late], 80, seconds=2.0)[2]


def test_two_runtimes_are_two_lines_and_one_of_them_is_not_obeyed():
    lines = shown([*said_of("r"), status("r", SECOND_RUNTIME, verdict=pb.OK)], 120)
    first, second = lines[2:4]
    assert first.startswith("r a1a1a1a1")
    assert " held " in first
    assert second.startswith("r b2b2b2b2")
    assert " of a1a1a1a1 " in second


def test_two_bodies_of_one_name_are_two_lines():
    lines = shown([*said_of("r"), lease("r", SECOND_RUNTIME, stopped="x")], 120)
    assert len(lines) == 5
    assert "stopped" in lines[2] + lines[3]


def test_a_body_alone_and_a_runtime_alone_say_so():
    body, runtime = shown([lease("a", BODY), status("b")], 120)[2:4]
    assert " free " in body
    assert "no body" in runtime


def test_of_more_robots_than_lines_the_first_are_shown_and_the_rest_counted():
    messages = [message for n in range(40) for message in said_of(f"robot{n}")]
    lines = shown(messages, 80, 24)
    assert len(lines) <= 24
    assert lines[-2] == f"… and {40 - (len(lines) - 4)} more: --once shows all"
    assert lines[-1].startswith("40 robots · 40 runtimes · 40 bodies · 40 armed · 2000 ticks/s")
    assert len(shown(messages, 80)) == 43


def test_strangers_words_move_no_column_and_obey_no_order():
    wild = "\x1b[31m[red]x\n" * 9
    messages = [
        status(f"a{wild}", policy=wild, action=wild, shadow=wild, recording=wild, watchdog=wild),
        lease(f"a{wild}", stopped=wild, state=wild),
    ]
    lines = shown(messages, 120)
    assert len(lines) == 4
    assert "\x1b" not in "".join(lines)
    assert max(map(len, lines)) <= 120


def test_what_could_not_be_read_or_kept_is_in_the_totals():
    fleet = Fleet()
    fleet.hear(status(node="toaster"))
    for number in range(300):
        fleet.hear(status(f"r{number}"))
    words = totals_in_words(fleet.view(0))
    assert "1 messages unreadable" in words
    assert "44 left out (room for 256 robots)" in words
