"""The flags of metrics for Prometheus, and who answers the scrapes that they ask for."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING

from reflexarc.terminal.output import aside
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    import socket

    from reflexarc_runtime.bus import Bus
    from reflexarc_runtime.fleet.views import FleetView
    from reflexarc_runtime.loop.outlets import Outlet
    from reflexarc_runtime.messages.wire import Message
    from reflexarc_runtime.metrics.feed import MetricsFeed

LOOPBACK = "127.0.0.1"
_LEASE_NS = 500_000_000


@dataclass(frozen=True)
class MetricsFlags:
    """Whether metrics are served, and where."""

    metrics: int | None = None
    """Serve metrics for Prometheus at http://127.0.0.1:PORT/metrics; 0 takes any free port, and
    says which."""
    metrics_host: str = LOOPBACK
    """Address to serve them at; beyond the loopback anybody who reaches it reads them."""

    def check(self) -> None:
        """Check the flags.

        Raises:
            UsageError: no such port, or a host and no port.
        """
        if self.metrics is not None and not 0 <= self.metrics <= 65535:
            raise UsageError(f"--metrics: expected a port, 0 to 65535, got {self.metrics}")
        if self.metrics is None and self.metrics_host != LOOPBACK:
            raise UsageError("--metrics-host: expected --metrics PORT beside it")

    @property
    def is_for_others(self) -> bool:
        """Whether other machines scrape."""
        from reflexarc_runtime.doors.open_doors import is_loopback

        return self.metrics is not None and not is_loopback(self.metrics_host)

    def feed(self, who: str) -> "AbstractContextManager[MetricsFeed | None]":
        """A process that answers for one loop, inside the context; None: nobody asked for it.

        Args:
            who: the name of the command, for its notices.
        """
        if self.metrics is None:
            return nullcontext()
        from reflexarc_runtime.metrics.feed import MetricsFeed

        return MetricsFeed(self._listener(who))

    def served(self, who: str, view: "Callable[[], FleetView]") -> AbstractContextManager[None]:
        """A thread that answers for a fleet, inside the context, if anybody asked for it."""
        return nullcontext() if self.metrics is None else _answering(self._listener(who), view)

    def _listener(self, who: str) -> "socket.socket":
        from ipaddress import ip_address

        import prometheus_client  # noqa: F401  # whoever lacks it shall be told before the start

        from reflexarc_runtime.metrics.listener import address_of, listener_at

        assert self.metrics is not None
        listener = listener_at(self.metrics_host, self.metrics)
        aside.print(f"{who}: metrics at {address_of(listener)}", soft_wrap=True)
        if not ip_address(listener.getsockname()[0]).is_loopback:
            aside.print(f"{who}: whoever reaches that address reads them", soft_wrap=True)
        return listener


def said_to_metrics(feed: "MetricsFeed | None", status: "Outlet", bus: "Bus") -> "Outlet":
    """The outlet of a loop's status, which the metrics hear as well, if there are any."""
    if feed is None:
        return status
    from reflexarc_runtime.messages.topics import STATUS
    from reflexarc_runtime.messages.wire import protobuf_encoding
    from reflexarc_runtime.metrics.feed import Overheard

    encoding = protobuf_encoding(STATUS.schema)
    return Overheard(status, STATUS.key(bus.robot), encoding, bus.sender, feed)


def hear_metrics(feed: "MetricsFeed | None", bus: "Bus") -> None:
    """Let the metrics hear twice a second whom the body obeys, if there are any."""
    if feed is None:
        return
    from reflexarc_runtime.loop.throttle import Throttle
    from reflexarc_runtime.messages.topics import LEASE
    from reflexarc_runtime.messages.wire import protobuf_encoding

    is_due, encoding = Throttle(_LEASE_NS).is_due, protobuf_encoding(LEASE.schema)

    def hear(message: "Message") -> None:
        if message.encoding == encoding and is_due(message.received_ns):
            feed.hear(message)

    bus.subscribe([LEASE], hear)


@contextmanager
def _answering(listener: "socket.socket", view: "Callable[[], FleetView]") -> Iterator[None]:
    import asyncio
    import threading

    from reflexarc_runtime.metrics.scraping import Scraping

    loop = asyncio.new_event_loop()
    serving = loop.create_task(Scraping(view).serve(listener))

    def serve() -> None:
        with listener:
            loop.run_until_complete(asyncio.gather(serving, return_exceptions=True))
        loop.close()

    thread = threading.Thread(target=serve, name="metrics", daemon=True)
    thread.start()
    try:
        yield
    finally:
        loop.call_soon_threadsafe(serving.cancel)
        thread.join()
