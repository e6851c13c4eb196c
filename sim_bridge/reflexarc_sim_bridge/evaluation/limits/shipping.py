"""Writes the oracle's figures that ship, for `make limits`.

For a point that moves as the reference field says: the suite `lite` at 10 and at 50 Hz, so that it
takes a minute at first, too; `full` at 10 Hz. `full` at 50 Hz would take an hour more. What ships
is not asked, so that all is computed anew; what an earlier run of the same code kept on this
machine is.
"""

import json
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.files import write_atomically
from reflexarc_sim_bridge.evaluation.limits import kept
from reflexarc_sim_bridge.evaluation.limits.oracle import depends_on, oracle_sums
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell, suite_named
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy
from reflexarc_sim_bridge.native.threads import set_thread_count
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

RATES_HZ = {"lite": (50.0, 10.0), "full": (10.0,)}

_Unit = tuple[SuiteCell, Suite, PolicyContract]


def main() -> None:
    """Compute all, on all processors, and write the file."""
    units = list(units_to_ship())
    figures = dict[str, list[float]]()
    with ProcessPoolExecutor(mp_context=get_context("spawn"), initializer=_begin) as pool:
        for done, (key, found) in enumerate(pool.map(_compute, units), start=1):
            figures[key] = found
            print(f"\r{done} of {len(units)}", end="", file=sys.stderr, flush=True)
    lines = ",\n".join(f"{json.dumps(key)}: {json.dumps(figures[key])}" for key in sorted(figures))
    write_atomically(kept.SHIPPED, f"{{\n{lines}\n}}\n".encode())


def units_to_ship() -> list[_Unit]:
    """Cells of the shipped suites and contracts, the dear ones at the higher rate first."""
    return [
        (cell, suite_named(name), replace(reference_contract(), rate_hz=rate_hz))
        for name, rates_hz in RATES_HZ.items()
        for rate_hz in rates_hz
        for _, cell in suite_named(name).cells
    ]


def _begin() -> None:
    set_thread_count(1)  # there is one process per processor
    kept.shipped_figures = dict  # type: ignore[assignment]  # what ships is not asked


def _compute(unit: _Unit) -> tuple[str, list[float]]:
    cell, suite, contract = unit
    body = Contender("point", BlindPolicy(len(contract.actions)), contract)
    sums = oracle_sums(body, cell, suite, Setting.ROBOT)
    key = kept.shipped_key(depends_on(body, cell, suite, Setting.ROBOT).text)
    return key, (sums["contacts"] / suite.lanes).tolist()


if __name__ == "__main__":
    main()
