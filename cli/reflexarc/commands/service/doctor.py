"""`reflexarc doctor`: what this machine can promise a loop, and why."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import tyro

from reflexarc.terminal.output import console, plain, print_json
from reflexarc.wiring.bus_flags import Joining
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc.doctoring.check_row import CheckRow

USUAL_HZ = 50.0
PRIORITY = 80
LEAST_HZ, MOST_HZ, MOST_S = 1.0, 10_000.0, 600.0
"""Who keeps 1 Hz keeps what is slower; its ticks would be waited for for minutes."""


@dataclass(frozen=True)
class DoctorCommand:
    """Look at this machine: which rate it can promise a loop, why, and what is amiss.

    Nothing is changed, and nothing is left: rights are asked for and given back, the loop is tried
    in processes of its own, without a bus, under ordinary scheduling and, where it is granted,
    under SCHED_FIFO, in turns with `cyclictest` if that is installed. Without a policy the loop
    only wakes. Exit status: 1 if the rate cannot be promised, or anything is BAD; else 0.

    Examples:
      reflexarc doctor
      reflexarc doctor runs/reflex-0/policy.onnx --record runs
      reflexarc doctor --rate 1000 --seconds 20 --json
      reflexarc doctor runs/reflex-0/policy.onnx --zenoh keys/runtime.json5
    """

    policy: tyro.conf.Positional[Path | None] = None
    """The policy whose ticks and rate are tried."""
    backend: Literal["numpy", "onnxruntime"] = "numpy"
    """What computes it."""
    rate: float = 0.0
    """Try this rate, Hz; by default the contract's, without a policy 50."""
    seconds: float = 5.0
    """How long each trial takes, s."""
    record: Path = Path()
    """The folder of the logs: how quick is its disk?"""
    joining: Joining = field(default_factory=Joining)
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Look, tell, judge."""
        from reflexarc.doctoring.check_row import Health

        self.joining.config()
        rate_hz = self._rate_hz()
        rows = []
        for row in self._rows(rate_hz):
            rows.append(row)
            if not self.json:
                _print(row)
        is_well = not any(row.health is Health.BAD for row in rows)
        if self.json:
            said = [asdict(row) for row in rows]
            print_json({"rate_hz": rate_hz, "well": is_well, "rows": said})
        return 0 if is_well else 1

    def _rows(self, rate_hz: float) -> "Iterator[CheckRow]":
        from reflexarc.doctoring.bus_rows import check_bus
        from reflexarc.doctoring.certificates import check_certificates
        from reflexarc.doctoring.disk import check_disk
        from reflexarc.doctoring.kernel_and_clock import check_kernel_and_clock
        from reflexarc.doctoring.rights import check_rights

        joining = self.joining
        yield from check_kernel_and_clock()
        yield from check_rights(PRIORITY)
        yield from check_disk(self.record)
        yield from check_bus(
            lambda: joining.bus("doctor"), joining.robot, joining.port, joining.zenoh
        )
        if joining.zenoh is not None:
            yield from check_certificates(joining.zenoh)
        yield from self._timing(rate_hz)

    def _timing(self, rate_hz: float) -> "Iterator[CheckRow]":
        from reflexarc.doctoring.lateness_rows import lateness_rows
        from reflexarc.doctoring.lateness_trial import try_lateness
        from reflexarc.doctoring.processors import check_processors, stolen_share, stolen_ticks
        from reflexarc.doctoring.promise import judge_promise

        before, found = stolen_ticks(), []
        for fifo in (0, PRIORITY):
            tried_hz = max(LEAST_HZ, rate_hz)
            found.append(try_lateness(tried_hz, self.seconds, fifo, self.policy, self.backend))
            yield from lateness_rows(found[-1])
        yield from check_processors(stolen_share(before, stolen_ticks()))
        whose = "the rate" if self.policy is None or self.rate else "the contract's"
        yield judge_promise(found, rate_hz, whose)

    def _rate_hz(self) -> float:
        """The rate to try; a policy that cannot be used is refused here."""
        if not 0.5 <= self.seconds <= MOST_S:
            raise UsageError(f"--seconds: expected 0.5 to {MOST_S:g}, got {self.seconds:g}")
        if self.rate and not LEAST_HZ <= self.rate <= MOST_HZ:
            raise UsageError(f"--rate: expected {LEAST_HZ:g} to {MOST_HZ:g}, got {self.rate:g}")
        if self.policy is None:
            return self.rate or USUAL_HZ
        from reflexarc_runtime.loop.trials.trial import Trial
        from reflexarc_runtime.policy.policy import load_contract

        with Trial(self.policy, self.backend) as trial:
            trial.finding()
        return self.rate or load_contract(self.policy, bounds=None).rate_hz


def _print(row: "CheckRow") -> None:
    console.print(plain(f"{row.health:<7}  {row.name}: {row.found}"), soft_wrap=True)
    for sign, words in (("why", row.why), ("do", row.remedy)):
        if words:
            console.print(plain(f"{'':<9}{sign}: {words}"), soft_wrap=True)
