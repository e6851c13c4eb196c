"""What a policy can be asked about at once: ticks one by one, or whole runs of them."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from reflexarc_logs.columns.tick_runs import TickRun
from reflexarc_logs.reading.reader import Log
from reflexarc_logs.replaying.comparison import Tally
from reflexarc_logs.replaying.recorded_holds import RecordedHolds
from reflexarc_logs.replaying.runs.run_comparison import AskedRun, batch_size
from reflexarc_runtime.choice import Hold
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages_pb2 import Decision, Tick

BATCH_TICKS = 256
"""Ticks that go through the policy at once, one by one: each is held, a few KiB."""


class Asked(NamedTuple):
    """A tick at which the policy was asked."""

    decision: Decision
    held: Hold | None
    """What was being done before."""
    is_hold_known: bool
    """Not at the beginning of a slice, until an action is done for a known time."""
    begins: bool
    """Whether the policy's memory began anew."""


class AskedTicks:
    """Counts ticks, and finds those at which the policy was asked.

    Args:
        log: the log.
        contract: of the policy.
        tally: counts them.
        begins: the tick at which the policy took over; None: it decided from the first one on.
    """

    def __init__(
        self, log: Log, contract: PolicyContract, tally: Tally, begins: int | None = None
    ) -> None:
        self._log, self._contract, self._tally = log, contract, tally
        holds = RecordedHolds(contract)
        self._holds = holds if begins is None else RecordedHolds.anew(contract, begins)
        self._begins = True

    def batches(self, ticks: Iterable[Tick | TickRun]) -> Iterator[list[Asked] | AskedRun]:
        """What the policy can be asked about at once, in order."""
        size, batch = batch_size(self._contract, BATCH_TICKS), list[Asked]()
        for found in ticks:
            run = self._run(found) if isinstance(found, TickRun) else None
            if run is not None:
                yield batch
                yield run
                batch = []
                continue
            for one in self._each(found):
                batch.append(one)
                if len(batch) >= size:
                    yield batch
                    batch = []
        yield batch

    def one_by_one(self, ticks: Iterable[Tick | TickRun]) -> Iterator[Asked]:
        """Every tick at which the policy was asked."""
        for found in ticks:
            yield from self._each(found)

    def _run(self, run: TickRun) -> AskedRun | None:
        """A run as a whole; None if it has to be taken tick by tick."""
        sizes = run.retinas.shape[1], run.q_values.shape[1]
        if sizes != expected_sizes(self._contract) or (held := self._holds.follow(run)) is None:
            return None
        self._tally.ticks += len(run)
        self._begins = False
        return AskedRun(run, held)

    def _each(self, found: Tick | TickRun) -> Iterator[Asked]:
        for tick in [found] if isinstance(found, Tick) else found.ticks():
            self._tally.ticks += 1
            decision = tick.decision
            if decision.q_values:
                _check_sizes(self._log, decision, self._contract)
                is_known = self._holds.are_known(decision)
                begins = self._begins or self._holds.misses
                yield Asked(decision, self._holds.held, is_known, begins)
            self._begins = not self._holds.saw(decision)


def expected_sizes(contract: PolicyContract) -> tuple[int, int]:
    """Bytes of retina, and Q-values, of a tick."""
    return contract.retina.frames * contract.retina.size, len(contract.actions)


def _check_sizes(log: Log, decision: Decision, contract: PolicyContract) -> None:
    expected = expected_sizes(contract)
    got = len(decision.retina), len(decision.q_values)
    if got != expected:
        raise LogError(
            f"{log.path}: tick {decision.index}: the policy takes and gives {expected} "
            f"(retina bytes, Q-values), the log holds {got}; give a policy that fits"
        )
