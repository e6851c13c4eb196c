from io import StringIO

from reflexarc.terminal.cadence_table import bars, cadence_table
from reflexarc.terminal.plain_console import PlainConsole
from reflexarc_runtime.messages.spread import Spread

LATE = Spread(1003, 61_000, 118_000, 900_000, 1_200_000, 16, (1000, 2, 0, 0, 0, 1))
"""Most between 33 and 66 µs."""
AGES = Spread(1, 3_000_000, 3_000_000, 3_000_000, 3_000_000, 22, (1,))


def printed(rows: dict[str, Spread], width: int = 100) -> list[str]:
    told = StringIO()
    PlainConsole(file=told, width=width).print(cadence_table(rows))
    return [line.rstrip() for line in told.getvalue().splitlines() if line.strip()]


def test_a_row_says_how_long_a_phase_took_and_how_often():
    heading, _, late, ages = printed({"lateness": LATE, "picture age": AGES})
    assert heading.endswith("33 µs to 4.2 ms")
    assert late.split()[:9] == ["lateness", "61", "µs", "118", "µs", "900", "µs", "1.2", "ms"]
    assert late.endswith("#:   .")
    assert ages.count("3.0 ms") == 4
    assert ages.rindex("#") == late.rindex("#") + 6


def test_what_happened_once_is_seen_beside_what_happened_always():
    assert bars(Spread(octaves=(1, 0, 10**9, 10**4), least_bits=13), 11) == "  . #="


def test_what_is_below_a_microsecond_shares_a_column():
    assert bars(Spread(octaves=(3, 0, 0, 5), least_bits=8), 10) == "+#"
    assert bars(Spread(octaves=(3,), least_bits=2), 10) == "#"
    assert bars(Spread(octaves=(1, 8), least_bits=9), 10) == "#"


def test_times_of_nothing_and_of_minutes_have_a_scale():
    both = {"a": Spread(1, 0, 0, 0, 0, 0, (1,)), "b": Spread(1, 1, 1, 1, 1, 40, (1,))}
    assert "512 ns to 1099.5 s" in printed(both)[0]


def test_it_fits_a_terminal_of_80_columns():
    rows = {"waking to command": Spread(9, 999_999, *[500 * 10**6] * 3, 1, (1,) * 30), "b": AGES}
    assert "…" not in "".join(printed(rows, width=80))
