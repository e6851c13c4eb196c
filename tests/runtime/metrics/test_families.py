"""Metrics of a fleet, read back by Prometheus' own parsers."""

from collections.abc import Callable

import pytest
from prometheus_client import openmetrics
from prometheus_client.exposition import generate_latest
from prometheus_client.openmetrics.exposition import generate_latest as generate_openmetrics
from prometheus_client.openmetrics.parser import text_string_to_metric_families as read_openmetrics
from prometheus_client.parser import text_string_to_metric_families
from prometheus_client.registry import CollectorRegistry

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.fleet.fleet import Fleet
from reflexarc_runtime.loop.cadence.histogram import Histogram, add_each
from reflexarc_runtime.messages.spread import spread_to_protobuf
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.metrics.families import PHASES, FleetCollector
from support.fleet_words import FIRST, SECOND, SECOND_RUNTIME, lease, status

Samples = dict[tuple[str, tuple[tuple[str, str], ...]], float]


def text_of(fleet: Fleet, seconds: float, generate: Callable[..., bytes] = generate_latest) -> str:
    registry = CollectorRegistry()
    registry.register(FleetCollector(lambda: fleet.view(round(seconds * SECOND))))
    return generate(registry).decode()


def samples(text: str) -> Samples:
    found: Samples = {}
    for family in text_string_to_metric_families(text):
        for sample in family.samples:
            key = (sample.name, tuple(sorted(sample.labels.items())))
            assert key not in found, key
            found[key] = sample.value
    return found


def of(found: Samples, name: str, **labels: str) -> float | None:
    return found.get((f"reflexarc_{name}", tuple(sorted(labels.items()))))


def phase(name: str, times_ns: list[int]) -> pb.PhaseTimes:
    histogram = Histogram()
    for time_ns in times_ns:
        add_each((time_ns,), (histogram,))
    return spread_to_protobuf(name, histogram.spread())


def heard(*messages: Message) -> Fleet:
    fleet = Fleet()
    for message in messages:
        fleet.hear(message)
    return fleet


def test_counters_gauges_and_labels_are_what_the_robots_said():
    fleet = heard(
        status("a", rate_hz=49.5, contract_rate_hz=50.0, verdicts={"OK": 90, "STUCK": 2}),
        status("b", skipped_slots=7, recording="on", guard="on: no ranges", policy="p.onnx"),
        lease("a", holder=FIRST, armed=True, epoch=3, refused={"too old": 4, "of another": 1}),
        lease("b", stopped="someone in the hall"),
    )
    found = samples(text_of(fleet, 0.5))
    assert of(found, "ticks_total", robot="a", verdict="OK") == 90
    assert of(found, "ticks_total", robot="a", verdict="STUCK") == 2
    assert of(found, "tick_rate_hertz", robot="a") == 49.5
    assert of(found, "contract_rate_hertz", robot="a") == 50.0
    assert of(found, "contract_rate_hertz", robot="b") is None
    assert of(found, "skipped_slots_total", robot="b") == 7
    assert [of(found, "recording", robot=name) for name in "ab"] == [0, 1]
    assert of(found, "guard", robot="b") == 0  # it has no ranges to work on
    assert [of(found, "armed", robot=name) for name in "ab"] == [1, 0]
    assert [of(found, "stopped", robot=name) for name in "ab"] == [0, 1]
    assert of(found, "refused_commands_total", robot="a") == 5
    assert of(found, "lease_epoch", robot="a") == 3
    assert of(found, "status_age_seconds", robot="a") == 0.5
    assert of(found, "policy_info", robot="b", file="p.onnx", hash="", pace="") == 1


def test_a_histogram_holds_all_times_since_the_listening_began():
    periods = [[20_000] * 40 + [3_000_000], [700_000] * 9, [5_000_000_000]]
    fleet = Fleet()
    for second, times_ns in enumerate(periods):
        fleet.hear(status(at_s=second, phases=[phase("lateness", times_ns)]))
    found = samples(text_of(fleet, 2))
    everything = [time_ns * 1e-9 for times_ns in periods for time_ns in times_ns]
    bounds = {
        dict(labels)["le"]: value
        for (name, labels), value in found.items()
        if name == "reflexarc_lateness_seconds_bucket"
    }
    assert bounds["+Inf"] == of(found, "lateness_seconds_count", robot="robot0") == 51
    assert len(bounds) == 21
    for bound, count in bounds.items():
        assert count == sum(time_s <= float(bound) for time_s in everything), bound
    total_s = of(found, "lateness_seconds_sum", robot="robot0")
    assert total_s == pytest.approx(sum(everything), rel=1 / 64)


def test_two_runtimes_of_one_robot_are_one_series_and_counted():
    fleet = heard(
        status(ticks=1, verdicts={"OK": 1}),
        status(sender=SECOND_RUNTIME, verdicts={"OK": 9}),
        lease(holder=SECOND_RUNTIME),
    )
    found = samples(text_of(fleet, 0))
    assert of(found, "runtimes", robot="robot0") == 2
    assert of(found, "ticks_total", robot="robot0", verdict="OK") == 9


def test_of_who_fell_silent_the_counters_stay_and_the_moment_goes():
    fleet = heard(status(rate_hz=50.0, verdicts={"OK": 9}), lease(armed=True))
    found = samples(text_of(fleet, 5.0))
    assert of(found, "ticks_total", robot="robot0", verdict="OK") == 9
    assert of(found, "runtimes", robot="robot0") == of(found, "bodies", robot="robot0") == 0
    assert of(found, "tick_rate_hertz", robot="robot0") is None
    assert of(found, "armed", robot="robot0") is None
    assert of(found, "status_age_seconds", robot="robot0") == 5.0


def test_names_and_texts_from_outside_stay_within_their_quotes():
    wild = '"} 1\nevil{x="\\'
    fleet = heard(
        status(f"a{wild}", policy=wild, verdicts={wild: 3}),
        lease(f"a{wild}", refused={wild: 2}),
    )
    found = samples(text_of(fleet, 0))
    assert not [name for name, _ in found if "evil" in name]
    (robot,) = {dict(labels)["robot"] for _, labels in found if labels}
    assert robot == 'a"} 1\\nevil{x="\\'
    assert of(found, "ticks_total", robot=robot, verdict="OTHER") == 3


def test_the_open_metrics_form_is_read_by_its_own_parser_which_is_strict():
    phases = [phase(name, [100_000, 2_000_000]) for name in PHASES]
    fleet = heard(status(verdicts={"OK": 2}, phases=phases, policy="p"), lease(holder=FIRST))
    text = text_of(fleet, 0, generate_openmetrics)
    families = {family.name: family for family in read_openmetrics(text)}
    assert families["reflexarc_ticks"].type == "counter"
    assert families["reflexarc_policy"].type == "info"
    assert families["reflexarc_picture_age_seconds"].type == "histogram"
    assert openmetrics.exposition.CONTENT_TYPE_LATEST.startswith("application/openmetrics-text")


def test_no_names_but_ours_can_become_labels_or_families():
    """Whatever a stranger sends: the verdicts and phases that there are, and no more."""
    many = {f"V{n}": 1 for n in range(300)}
    phases = [phase(f"p{n}", [5]) for n in range(300)]
    calm = text_of(heard(status(verdicts={"OK": 1, "OTHER": 1})), 0)
    wild = text_of(heard(status(verdicts={"OK": 1, **many}, phases=phases)), 0)
    assert set(samples(wild)) == set(samples(calm))


def test_a_fleet_of_nobody_is_a_proper_text():
    assert of(samples(text_of(Fleet(), 0)), "unreadable_messages_total") == 0
