"""A fleet as Prometheus' metric families, one series a robot.

Names, units and types follow Prometheus' conventions (prometheus.io/docs/practices/naming). Labels
have few values: a robot's name, a verdict. Where a robot has several runtimes, the one that holds
the lease stands for it, and `reflexarc_runtimes` says how many there are. Of a node that has fallen
silent the counters stay, and what was true of a moment is left out.
"""

from collections.abc import Callable, Iterator, Sequence

from prometheus_client.core import (
    CounterMetricFamily,
    GaugeMetricFamily,
    HistogramMetricFamily,
    InfoMetricFamily,
)
from prometheus_client.metrics_core import Metric
from prometheus_client.registry import Collector
from prometheus_client.utils import floatToGoString

from reflexarc_runtime.fleet.tally import BOUNDS_S
from reflexarc_runtime.fleet.views import BodyView, FleetView, RobotView, RuntimeView

PREFIX = "reflexarc_"
PHASES = {
    "lateness": "How long after it was due a tick began.",
    "receive": "How long a tick took to take its messages.",
    "decide": "How long a tick took to decide.",
    "publish": "How long a tick took to send its command.",
    "record": "How long a tick took to hand over its record.",
    "waking to command": "How long after its beginning a tick's command was sent.",
    "picture age": "Age of the picture when the command that it led to was sent.",
}
"""The phases of a tick that have a histogram."""
_ROBOT = ("robot",)
_BOUNDS = (*map(floatToGoString, BOUNDS_S), "+Inf")

_OfRobot = Callable[[RobotView], float | None]
_OfRuntime = Callable[[RuntimeView], float | None]
_OfBody = Callable[[BodyView], float | None]


class FleetCollector(Collector):
    """Collects the metrics of a fleet at each scrape.

    Args:
        view: the fleet now.
    """

    def __init__(self, view: Callable[[], FleetView]) -> None:
        self._view = view

    def collect(self) -> Iterator[Metric]:
        """All families, from one moment."""
        return families(self._view())


def families(fleet: FleetView) -> Iterator[Metric]:
    """All metrics of a fleet."""
    yield from _counts(fleet)
    yield from _of_runtimes(fleet)
    yield from _of_bodies(fleet)
    for phase, words in PHASES.items():
        yield _histogram(fleet, phase, words)


def _counts(fleet: FleetView) -> Iterator[Metric]:
    yield _gauge("runtimes", "Runtimes that are heard.", fleet, lambda one: _heard(one.runtimes))
    yield _gauge("bodies", "Bodies that are heard.", fleet, lambda one: _heard(one.bodies))
    yield CounterMetricFamily(
        f"{PREFIX}unreadable_messages", "Messages that no node sends.", fleet.unreadable
    )
    yield CounterMetricFamily(
        f"{PREFIX}left_out_messages", "Messages of nodes that found no room.", fleet.left_out
    )


def _of_runtimes(fleet: FleetView) -> Iterator[Metric]:
    yield _ticks(fleet)
    yield _policies(fleet)
    for name, words, count in _RUNTIME_COUNTERS:
        counter = CounterMetricFamily(f"{PREFIX}{name}", words, labels=_ROBOT)
        for robot, runtime in _runtimes(fleet):
            counter.add_metric((robot,), count(runtime))
        yield counter
    for name, words, value in _RUNTIME_GAUGES:
        yield _gauge(name, words, fleet, _of_live_runtime(value))
    yield _gauge("status_age_seconds", "Time since the runtime's last status.", fleet, _age_s)


def _ticks(fleet: FleetView) -> Metric:
    ticks = CounterMetricFamily(
        f"{PREFIX}ticks", "Ticks since the runtime's start.", labels=("robot", "verdict")
    )
    for robot, runtime in _runtimes(fleet):
        for verdict, count in runtime.said.verdicts.items():
            ticks.add_metric((robot, verdict), count)
    return ticks


def _policies(fleet: FleetView) -> Metric:
    policy = InfoMetricFamily(
        f"{PREFIX}policy", "The policy that decides, and the loop's pace.", labels=_ROBOT
    )
    for robot, runtime in _runtimes(fleet):
        said = runtime.said
        named = {"file": said.policy, "hash": said.policy_hash, "pace": said.pace}
        policy.add_metric((robot,), named)
    return policy


def _of_bodies(fleet: FleetView) -> Iterator[Metric]:
    refused = CounterMetricFamily(
        f"{PREFIX}refused_commands", "Commands that the body did not obey.", labels=_ROBOT
    )
    for one in fleet.robots:
        if one.body is not None and one.body.lease is not None:
            refused.add_metric((one.robot,), sum(one.body.lease.refused.values()))
    yield refused
    for name, words, value in _BODY_GAUGES:
        yield _gauge(name, words, fleet, _of_live_body(value))


def _histogram(fleet: FleetView, phase: str, words: str) -> Metric:
    name = phase.replace(" ", "_")
    histogram = HistogramMetricFamily(f"{PREFIX}{name}_seconds", words, labels=_ROBOT)
    for robot, runtime in _runtimes(fleet):
        tally = runtime.tallies.get(phase)
        if tally is not None:
            buckets = list(zip(_BOUNDS, map(float, tally.cumulative), strict=True))
            histogram.add_metric((robot,), buckets, tally.sum_s)
    return histogram


def _gauge(name: str, words: str, fleet: FleetView, value: _OfRobot) -> Metric:
    gauge = GaugeMetricFamily(f"{PREFIX}{name}", words, labels=_ROBOT)
    for one in fleet.robots:
        found = value(one)
        if found is not None:
            gauge.add_metric((one.robot,), found)
    return gauge


def _runtimes(fleet: FleetView) -> Iterator[tuple[str, RuntimeView]]:
    for one in fleet.robots:
        if one.runtime is not None:
            yield one.robot, one.runtime


def _heard(nodes: Sequence[RuntimeView] | Sequence[BodyView]) -> float:
    return sum(not each.is_silent for each in nodes)


def _age_s(one: RobotView) -> float | None:
    return None if one.runtime is None else one.runtime.age_s


def _of_live_runtime(value: _OfRuntime) -> _OfRobot:
    def of(one: RobotView) -> float | None:
        return None if one.runtime is None or one.runtime.is_silent else value(one.runtime)

    return of


def _of_live_body(value: _OfBody) -> _OfRobot:
    def of(one: RobotView) -> float | None:
        return None if one.body is None or one.body.is_silent else value(one.body)

    return of


def _is_armed(body: BodyView) -> float | None:
    return None if body.lease is None else body.lease.armed


def _is_stopped(body: BodyView) -> float | None:
    return None if body.lease is None else bool(body.lease.stopped)


def _is_obeying(body: BodyView) -> float | None:
    return None if body.lease is None else bool(body.lease.holder)


def _epoch(body: BodyView) -> float | None:
    return None if body.lease is None else body.lease.epoch


_RUNTIME_COUNTERS: tuple[tuple[str, str, Callable[[RuntimeView], float]], ...] = (
    ("skipped_slots", "Deadlines that passed without a tick.", lambda r: r.said.skipped_slots),
    (
        "inbox_overflows",
        "Messages that found the loop's inbox full.",
        lambda r: r.said.inbox_overflows,
    ),
)
_RUNTIME_GAUGES: tuple[tuple[str, str, _OfRuntime], ...] = (
    ("tick_rate_hertz", "Ticks a second, over the last second.", lambda r: r.said.rate_hz),
    (
        "contract_rate_hertz",
        "Ticks a second that the policy was made for.",
        lambda r: r.said.contract_rate_hz,
    ),
    ("holds_lease", "Whether the body obeys the runtime.", lambda r: r.holds_lease),
    (
        "recording",
        "Whether the runtime records, without a failure.",
        lambda r: r.said.recording == "on",
    ),
    ("guard", "Whether a guard works between policy and body.", lambda r: r.said.guard == "on"),
)
_BODY_GAUGES: tuple[tuple[str, str, _OfBody], ...] = (
    ("armed", "Whether the body takes commands.", _is_armed),
    ("stopped", "Whether a stop holds.", _is_stopped),
    ("obeys", "Whether anybody holds the body's lease.", _is_obeying),
    ("lease_epoch", "Grows with every grant of the lease.", _epoch),
)
