"""Suites in real processes: the numbers are the same however the work is shared."""

import json
from pathlib import Path

import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.driving.drive import drive
from reflexarc_sim_bridge.evaluation.metrics.sums import sums_of
from reflexarc_sim_bridge.evaluation.protocol.entrant import Entrant
from reflexarc_sim_bridge.evaluation.protocol.results import Results
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, suite_named
from reflexarc_sim_bridge.evaluation.running.run_suite import ROWS, RunOptions, run_suite
from support.small_suite import write_small_suite


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("suite")
    write_small_suite(path)
    return path


@pytest.fixture(scope="module")
def suite(folder: Path) -> Suite:
    return suite_named(str(folder / "small.toml"))


def entrants(folder: Path, *names: str) -> list[Entrant]:
    return [Entrant(name, f"{folder / 'small_controllers.py'}:{name}") for name in names]


@pytest.fixture(scope="module")
def alone(folder: Path, suite: Suite) -> Results:
    """What one process finds out."""
    who = [*entrants(folder, "Mine", "Gambler", "Counter"), Entrant("random", "random")]
    return run_suite(suite, who, options=RunOptions(1, folder / "alone")).results


@pytest.mark.parametrize("jobs", [2, 3])
def test_more_processes_and_another_order_find_the_same_to_the_last_digit(
    jobs: int, folder: Path, suite: Suite, alone: Results
) -> None:
    who = [Entrant("random", "random"), *entrants(folder, "Counter", "Gambler", "Mine")]
    found = run_suite(suite, who, options=RunOptions(jobs)).results
    assert sorted(found.rows, key=lambda row: row.key) == sorted(
        alone.rows, key=lambda row: row.key
    )
    assert found.limits == alone.limits


def test_rows_are_what_a_drive_in_this_process_says(
    folder: Path, suite: Suite, alone: Results
) -> None:
    (mine,) = entrants(folder, "Mine")
    (_, cell), _ = suite.cells
    row = next(row for row in alone.rows if row.contender == "Mine")
    sums = sums_of(drive(mine.contender(), cell, suite, row.setting))
    assert row.sums == {name: values.tolist() for name, values in sums.items()}
    oracle, blind = (alone.limit(row, name) for name in ("oracle", "blind"))
    assert oracle is not None
    assert blind is not None
    assert oracle.array("contacts").sum() < blind.array("contacts").sum()


def test_objects_drive_here_as_entrants_do_elsewhere_and_are_not_worn_out(
    folder: Path, suite: Suite, alone: Results
) -> None:
    found = run_suite(suite, [entrants(folder, "Counter")[0].contender()]).results
    assert found.rows == [row for row in alone.rows if row.contender == "Counter"]


def test_a_run_goes_on_with_lines_that_still_hold_and_with_no_others(
    folder: Path, suite: Suite, alone: Results
) -> None:
    out, rows = folder / "resumed", (folder / "alone" / ROWS).read_bytes().split(b"\n")
    out.mkdir()
    # Of the lines: some are missing, one belongs to nobody, one is torn; one tells a lie.
    lie = json.loads(rows[0])
    lie["sums"]["contacts"] = [1e6, 0.0, 0.0]
    other = b'{"key": "of another version", "figures": []}'
    kept = [json.dumps(lie).encode(), *rows[1:4], other, rows[4][:50]]
    (out / ROWS).write_bytes(b"\n".join(kept))
    who = [*entrants(folder, "Mine", "Gambler", "Counter"), Entrant("random", "random")]
    told: list[tuple[float, float]] = []
    options = RunOptions(2, out, True, lambda done, total: told.append((done, total)))
    found = run_suite(suite, who, options=options).results
    both = [*found.rows, *found.limits], [*alone.rows, *alone.limits]
    differing = [mine for mine, theirs in zip(*both, strict=True) if mine != theirs]
    assert differing  # lines are believed: what they say is taken
    assert all(row.sums["contacts"][0] == 1e6 for row in differing)
    assert 0.0 < told[0][0] < told[0][1]  # four of them were there
    assert told[-1][0] == pytest.approx(told[-1][1])
    assert len(told) == len(rows) - 1 - 4 + 1

    anew = run_suite(suite, who, options=RunOptions(2, out)).results
    assert anew == alone


def test_another_rate_guard_or_text_of_a_contender_is_another_unit(
    folder: Path, suite: Suite
) -> None:
    source = folder / "other.py"
    source.write_text((folder / "small_controllers.py").read_text())
    one = suite.only(("rectangles",))
    done: list[float] = []

    def again(entrant: Entrant) -> int:
        """How many units were not there yet."""
        done.clear()
        options = RunOptions(1, folder / "keys", True, lambda now, _: done.append(now))
        run_suite(one, [entrant], options=options)
        return len(done) - 1

    mine = Entrant("mine", f"{source}:Mine")
    assert again(mine) == 6  # 50 Hz and 10 Hz, each with its two limits
    assert again(mine) == 0
    assert again(Entrant("by another name", mine.source)) == 0
    assert again(Entrant("mine", mine.source, rate_hz=20.0)) == 4  # 20 Hz, its limits, the field
    source.write_text(source.read_text() + "\n# changed\n")
    assert again(mine) == 2


@pytest.mark.parametrize(
    ("name", "said"),
    [("Broken", "it raised ValueError: no idea"), ("Deadly", "2 processes died doing it")],
)
def test_a_contender_that_fails_is_one_line_with_its_name_and_cell(
    name: str, said: str, folder: Path, suite: Suite
) -> None:
    with pytest.raises(UsageError, match=said) as caught:
        run_suite(suite.only(("senses",)), entrants(folder, name), [Setting.FIELD])
    assert str(caught.value).startswith(f"{name} in senses/noisy (field): ")
    assert "\n" not in str(caught.value)


def test_two_of_one_name_are_refused(folder: Path, suite: Suite) -> None:
    with pytest.raises(UsageError, match="distinct names, got twice: Mine"):
        run_suite(suite, entrants(folder, "Mine", "Mine"))
