"""Results of suites, made up, whose scores can be worked out by hand."""

from collections.abc import Mapping, Sequence

from reflexarc_sim_bridge.evaluation.protocol.results import Agent, CellFacts, ResultRow, Results
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting

BLIND, ORACLE = "blind: as all", "oracle: as all"
METRES = 100.0


def agent(name: str, *, seed: int | None = None, group: str = "", turns: bool = False) -> Agent:
    return Agent(name, "", "", seed, "", "", "", "", 10.0, turns, "", group)


def row(name: str, cell: CellFacts, counts: Sequence[float]) -> ResultRow:
    """Contacts of each world, over 100 m in each."""
    worlds = len(counts)
    sums = {
        "agents": [1.0] * worlds,
        "contacts": [float(count) for count in counts],
        "progress_m": [METRES] * worlds,
        "time_s": [60.0] * worlds,
        "farthest_m": [float(count) for count in counts],
    }
    limits = {} if name in (BLIND, ORACLE) else {"blind": BLIND, "oracle": ORACLE}
    return ResultRow(name, Setting.FIELD, cell.family, cell.tier, sums, limits)


def results_of(
    contacts: Mapping[str, Mapping[str, Sequence[float]]],
    agents: Sequence[Agent],
    *,
    uncounted: Sequence[str] = (),
) -> Results:
    """Results.

    Args:
        contacts: by contender, among them `BLIND` and perhaps `ORACLE`, then by FAMILY/TIER: one
            value a world.
        agents: all others.
        uncounted: cells that do not count.
    """
    cells = {
        name: CellFacts(*name.split("/"), "", None, name not in uncounted)
        for name in contacts[BLIND]
    }
    rows = {
        who: [row(who, cells[name], counts) for name, counts in of.items()]
        for who, of in contacts.items()
    }
    return Results(
        suite="made-up-1",
        version="0",
        agents=list(agents),
        rows=[each for who in rows if who not in (BLIND, ORACLE) for each in rows[who]],
        limits=[*rows[BLIND], *rows.get(ORACLE, [])],
        cells=list(cells.values()),
    )
