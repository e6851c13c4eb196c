"""Made-up results with everything that a page shows, of as many contenders as one likes."""

from collections.abc import Sequence

import numpy as np

from reflexarc_runtime.contract.eye_in_words import eye_in_words
from reflexarc_sim_bridge.evaluation.metrics.survival import BINS
from reflexarc_sim_bridge.evaluation.protocol.results import Agent, CellFacts, ResultRow, Results
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.worlds.reference_contract import reference_retina

CELLS = (
    CellFacts("discs", "0.10", "discs", 0.1, True),
    CellFacts("discs", "0.20", "discs", 0.2, True),
    CellFacts("motion", "crossing", "crossing", None, True),
    CellFacts("robustness", "none", "reference-1", 0.1, False),
    CellFacts("robustness", "noise 0.10", "reference-1", 0.1, False),
)
WORLDS = 4
BLIND_CONTACTS = 40.0
_METRES = 100.0
_EYE = f"{eye_in_words(reference_retina())} frames=1"


def page_results(
    names: Sequence[str],
    *,
    turns: Sequence[str] = (),
    settings: Sequence[Setting] = (Setting.ROBOT, Setting.FIELD),
    bare: bool = False,
    version: str = "1.2.3",
) -> Results:
    """Results.

    Args:
        names: of the contenders; each makes more contacts than the one before.
        turns: those whose bodies turn.
        settings: in which they are measured.
        bare: with the sums that scores need, and no others; without an oracle.
        version: of the software.
    """
    shares = np.linspace(0.05, 1.1, len(names)).tolist()
    limits = {"blind": "blind: all"} if bare else {"blind": "blind: all", "oracle": "oracle: all"}
    return Results(
        suite="made-up-1",
        version=version,
        agents=[_agent(name, name in turns) for name in names],
        rows=[
            ResultRow(name, setting, c.family, c.tier, _sums(k, share, bare), limits)
            for name, share in zip(names, shares, strict=True)
            for setting in settings
            for k, c in enumerate(CELLS)
        ],
        limits=[
            ResultRow(holder, Setting.ROBOT, c.family, c.tier, _sums(k, share, bare))
            for holder, share in (("blind: all", 1.0), ("oracle: all", 0.02))
            if not bare or holder.startswith("blind")
            for k, c in enumerate(CELLS)
        ],
        cells=list(CELLS),
    )


def _agent(name: str, turns: bool) -> Agent:
    return Agent(
        name=name,
        source=f"runs/{name}",
        hash="ab" * 32,
        seed=0,
        preset="p",
        eye=_EYE,
        motion="1 m/s ahead, 1 m/s aside",
        body="point",
        rate_hz=50.0,
        turns=turns,
        tuned="trained: p, 100 steps, seed 0",
    )


def _sums(cell: int, share: float, bare: bool) -> dict[str, list[float] | list[list[list[float]]]]:
    contacts = [round(BLIND_CONTACTS * share) + (cell + world) % 3 for world in range(WORLDS)]
    sums: dict[str, list[float] | list[list[list[float]]]] = {
        "agents": [2.0] * WORLDS,
        "contacts": [float(count) for count in contacts],
        "progress_m": [_METRES] * WORLDS,
        "time_s": [_METRES] * WORLDS,
        "farthest_m": [2.0 * (3.0 + 20.0 * (1.0 - share))] * WORLDS,
    }
    if bare:
        return sums
    reach = np.floor(1000.0 * np.exp(-share * 0.25 * np.arange(BINS + 1)))
    ends = np.append(-np.diff(reach), 0.0)
    return {
        **sums,
        "way_lives": [[reach.tolist(), ends.tolist()]] * WORLDS,
        "switches": [300.0 * (0.2 + share)] * WORLDS,
        "reversals": [30.0] * WORLDS,
        "edge_time_s": [_METRES * share] * WORLDS,
        "sided_time_s": [_METRES * 0.5] * WORLDS,
    }
