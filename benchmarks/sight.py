"""What being seen costs a loop: its status once a second, metrics, and hearing its body's lease.

    python benchmarks/sight.py [--times 2000]

In turns, one of each, on the real clock and with the real process of the metrics; the bus is left
out. `status` and what stands below it happen once a second in the loop's thread, behind a command;
the lease comes on a thread of the bus.
"""

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from reflexarc.wiring.rivals import Rivals
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.decision import Decision, Input, Timing, Verdict, safe_command
from reflexarc_runtime.fleet.fleet import Fleet
from reflexarc_runtime.loop.cadence.monitor import Monitor
from reflexarc_runtime.loop.outlets import NoOutlet
from reflexarc_runtime.messages.codec import Status, encode_status
from reflexarc_runtime.messages.topics import STATUS
from reflexarc_runtime.messages.wire import protobuf_encoding
from reflexarc_runtime.metrics.feed import MetricsFeed, Overheard
from reflexarc_runtime.metrics.listener import listener_at
from support.fleet_words import FIRST, lease, status

TICKS = 50
"""Of a second."""
PAUSE_S = 0.002
"""Before each measurement, as a loop's processor does something else in between."""


def decision() -> Decision:
    """A tick of a robot that stands."""
    safe = PolicyContract().safe_command
    used = Input(1, 0, 0, 4_000_000)
    command = safe_command(1, Verdict.OK, safe)
    return Decision(
        index=1,
        slot=1,
        now_ns=0,
        inputs=1,
        input=used,
        retina=b"",
        q_values=(),
        winner=-1,
        action=-1,
        verdict=Verdict.OK,
        reason="",
        command=command,
        policy_hash="hash",
    )


def main() -> int:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=2000)
    times = parser.parse_args().times
    with MetricsFeed(listener_at("127.0.0.1", 0)) as feed:
        time.sleep(1.0)  # it starts
        found = measured(parts(feed), times)
    print("| µs | p50 | p99 |\n|---|---|---|")
    for name, each in found.items():
        print(f"| {name} | {np.median(each) / 1e3:.1f} | {np.percentile(each, 99) / 1e3:.1f} |")
    return 0


def parts(feed: MetricsFeed) -> dict[str, Callable[[], object]]:
    """What is measured, by name."""
    monitor, tick, timing = Monitor(), decision(), Timing(0, 30_000, 5000, 70_000, 9000, 5000)
    said = status(verdicts={"OK": 900}, rate_hz=50.0).payload
    encoding = protobuf_encoding(STATUS.schema)
    overheard = Overheard(NoOutlet(), STATUS.key("r"), encoding, FIRST, feed)
    rivals, heard, words = Rivals(FIRST, print, "r"), lease(holder=FIRST, armed=True), Fleet()

    def report() -> bytes:
        period = monitor.period()
        verdicts, phases = tuple(period.verdicts.items()), tuple(period.phases.items())
        return encode_status(Status("runtime", "0" * 32, verdicts=verdicts, phases=phases))

    def second() -> None:
        for _ in range(TICKS):
            monitor.saw(tick, timing)

    return {
        f"counting {TICKS} ticks": second,
        "a status: percentiles, encoding": report,
        "handing it to the metrics": lambda: overheard.put(said, 0),
        "a message of the lease, heard": lambda: rivals.hear(heard),
        "a status, heard by `top`": lambda: words.hear(status()),
    }


def measured(calls: dict[str, Callable[[], object]], times: int) -> dict[str, list[int]]:
    """How long each call took, nanoseconds, in turns."""
    found: dict[str, list[int]] = {name: [] for name in calls}
    for _ in range(times):
        for name, call in calls.items():
            time.sleep(PAUSE_S)
            began_ns = time.perf_counter_ns()
            call()
            found[name].append(time.perf_counter_ns() - began_ns)
    return found


if __name__ == "__main__":
    raise SystemExit(main())
