"""The flags of metrics, and a fleet's answered beside the command that shows it."""

import urllib.request
from dataclasses import replace

import pytest

from reflexarc.wiring.sight.metrics_flags import MetricsFlags, hear_metrics, said_to_metrics
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.fleet.fleet import Fleet
from reflexarc_runtime.messages.wire import Message
from support.fleet_words import lease, status
from support.spoken import FakeBus, Spoken


@pytest.mark.parametrize(
    ("flags", "expected"),
    [
        (MetricsFlags(-1), "--metrics: expected a port, 0 to 65535, got -1"),
        (MetricsFlags(65536), "--metrics: expected a port, 0 to 65535, got 65536"),
        (MetricsFlags(None, "0.0.0.0"), "--metrics-host: expected --metrics PORT beside it"),
    ],
)
def test_a_port_that_is_none_is_refused(flags: MetricsFlags, expected: str):
    with pytest.raises(UsageError, match=expected):
        flags.check()


@pytest.mark.parametrize("host", ["..", "rover..local", "r" * 64, "r" * 300 + ".local"])
def test_a_host_that_can_have_no_name_is_refused_in_one_line(host: str):
    with pytest.raises(UsageError) as refused:
        MetricsFlags(0, host).feed("reflexarc run")
    assert "--metrics" in str(refused.value)
    assert len(str(refused.value)) < 200


def test_who_asks_for_none_pays_for_none():
    flags, outlet, bus = MetricsFlags(), Spoken(), FakeBus()
    flags.check()
    with flags.feed("reflexarc run") as feed, flags.served("reflexarc top", Fleet):  # type: ignore[arg-type]
        assert feed is None
        assert said_to_metrics(feed, outlet, bus) is outlet  # type: ignore[arg-type]
        hear_metrics(feed, bus)  # type: ignore[arg-type]
    assert bus.heard == {}


def test_a_fleet_is_answered_for_as_long_as_it_is_shown(capsys: pytest.CaptureFixture[str]):
    fleet = Fleet()
    fleet.hear(status("rover", verdicts={"OK": 3}))
    with MetricsFlags(0).served("reflexarc top", lambda: fleet.view(0)):
        said = capsys.readouterr().err.strip()
        assert said.startswith("reflexarc top: metrics at http://127.0.0.1:")
        address = said.rpartition(" ")[2]
        with urllib.request.urlopen(address, timeout=30.0) as answer:
            assert b'robot="rover"' in answer.read()
    with pytest.raises(OSError, match="refused"):
        urllib.request.urlopen(address, timeout=30.0)


def test_an_address_beyond_the_loopback_is_said(capsys: pytest.CaptureFixture[str]):
    with MetricsFlags(0, "0.0.0.0").served("reflexarc top", lambda: Fleet().view(0)):
        pass
    assert "whoever reaches that address reads them" in capsys.readouterr().err


def test_of_the_lease_two_messages_a_second_are_handed_over():
    class Feed:
        def __init__(self) -> None:
            self.heard: list[Message] = []

        def hear(self, message: Message) -> None:
            self.heard.append(message)

    feed, bus = Feed(), FakeBus()
    hear_metrics(feed, bus)  # type: ignore[arg-type]
    for tenth in range(30):
        bus.heard["lease"](lease(at_s=tenth / 10))
    assert len(feed.heard) == 6
    for tenth in range(30, 60):  # what cannot be one takes nobody's place
        bus.heard["lease"](replace(lease(at_s=tenth / 10), encoding="a\0b"))
        bus.heard["lease"](lease(at_s=tenth / 10))
    assert len(feed.heard) == 12
    assert len({message.encoding for message in feed.heard}) == 1
