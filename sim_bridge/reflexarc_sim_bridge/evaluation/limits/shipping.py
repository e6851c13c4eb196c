"""Writes the oracle's figures that ship, for `make limits`.

For a point that moves as the reference field says: the suite `lite` at 10 and at 50 Hz, so that it
takes a minute at first, too; `full` at 10 Hz. `full` at 50 Hz would take an hour more. What ships
is not asked, so that all is computed anew; what an earlier run of the same code kept on this
machine is. The work is a crew's, whose processes end with this one, however it ends.
"""

import json
import sys
from collections.abc import Iterator
from dataclasses import replace

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.crew.crew import Crew
from reflexarc_runtime.crew.worker_process import Failure, Task
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.files import write_atomically
from reflexarc_sim_bridge.evaluation.limits import kept
from reflexarc_sim_bridge.evaluation.limits.oracle import depends_on, oracle_sums
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell, suite_named
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy
from reflexarc_sim_bridge.native.cache import has_compiled
from reflexarc_sim_bridge.native.threads import thread_count
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

RATES_HZ = {"lite": (50.0, 10.0), "full": (10.0,)}

_WORKER = "reflexarc_sim_bridge.evaluation.limits.shipping_worker"

_Unit = tuple[SuiteCell, Suite, PolicyContract]


def main() -> None:
    """Compute all, on all processors, and write the file."""
    units, figures = len(units_to_ship()), dict[str, list[float]]()
    for key, found in computed([Task(str(n), {"unit": n}) for n in range(units)], thread_count()):
        figures[key] = found
        print(f"\r{len(figures)} of {units}", end="", file=sys.stderr, flush=True)
    lines = ",\n".join(f"{json.dumps(key)}: {json.dumps(figures[key])}" for key in sorted(figures))
    write_atomically(kept.SHIPPED, f"{{\n{lines}\n}}\n".encode())


def computed(tasks: list[Task], jobs: int) -> Iterator[tuple[str, list[float]]]:
    """Keys and figures of units, as they come; all of them, or an error.

    Raises:
        UsageError: a unit cannot be computed.
    """
    with Crew(_WORKER, tasks, jobs, first_alone=not has_compiled()) as crew:
        for outcome in crew.outcomes(lambda: False):
            if isinstance(outcome, Failure):
                raise UsageError(f"unit {outcome.task.key}: {outcome.reason}")
            yield outcome.answer["key"], outcome.answer["figures"]


def units_to_ship() -> list[_Unit]:
    """Cells of the shipped suites and contracts, the dear ones at the higher rate first."""
    return [
        (cell, suite_named(name), replace(reference_contract(), rate_hz=rate_hz))
        for name, rates_hz in RATES_HZ.items()
        for rate_hz in rates_hz
        for _, cell in suite_named(name).cells
    ]


def compute(unit: _Unit) -> tuple[str, list[float]]:
    """A unit's key and figures, one a world."""
    cell, suite, contract = unit
    body = Contender("point", BlindPolicy(len(contract.actions)), contract)
    sums = oracle_sums(body, cell, suite, Setting.ROBOT)
    key = kept.shipped_key(depends_on(body, cell, suite, Setting.ROBOT).text)
    return key, (sums["contacts"] / suite.lanes).tolist()


if __name__ == "__main__":
    main()
