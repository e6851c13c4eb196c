"""Answers scrapes over HTTP, from one thread, whoever asks and however slowly.

At most 16 connections are open at once and each has 2 s, from its first byte to the last of its
answer; what comes beyond that is closed. Only `/metrics` is there. Prometheus' own server
(`prometheus_client.start_http_server`) starts a thread for every connection, without a bound and
without a limit of time.
"""

import asyncio
import socket
from collections.abc import Callable
from contextlib import suppress

from prometheus_client.exposition import choose_encoder
from prometheus_client.registry import CollectorRegistry

from reflexarc_runtime.fleet.views import FleetView
from reflexarc_runtime.metrics.families import FleetCollector

MOST_CONNECTIONS = 16
PATIENCE_S = 2.0
MOST_HEAD_BYTES = 8192
METHODS = ("GET", "HEAD")
PATH = "/metrics"
_WORDS = "text/plain; charset=utf-8"


class Scraping:
    """Answers on a socket that listens.

    Args:
        view: the fleet now.
        patience_s: what a connection may take.
    """

    def __init__(self, view: Callable[[], FleetView], patience_s: float = PATIENCE_S) -> None:
        self._registry = CollectorRegistry()
        self._registry.register(FleetCollector(view))
        self._patience_s = patience_s
        self._open = 0

    async def serve(self, listener: socket.socket) -> None:
        """Answer until cancelled."""
        server = await asyncio.start_server(self._answer, sock=listener, limit=MOST_HEAD_BYTES)
        async with server:
            await server.serve_forever()

    async def _answer(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self._open >= MOST_CONNECTIONS:
            writer.transport.abort()
            return
        self._open += 1
        try:
            with suppress(OSError, EOFError, TimeoutError, asyncio.LimitOverrunError):
                async with asyncio.timeout(self._patience_s):
                    head = await reader.readuntil(b"\r\n\r\n")
                    writer.write(self.answer_to(head))
                    await writer.drain()
                    writer.close()
                    await writer.wait_closed()
        finally:
            self._open -= 1
            writer.transport.abort()

    def answer_to(self, head: bytes) -> bytes:
        """The response to the head of a request."""
        method, path, accepts = _parts(head)
        if method not in METHODS:
            return _response("405 Method Not Allowed", _WORDS, b"only GET and HEAD\n")
        if path.partition("?")[0] != PATH:
            return _response("404 Not Found", _WORDS, b"the metrics are at /metrics\n")
        encode, kind = choose_encoder(accepts)
        return _response("200 OK", kind, encode(self._registry), only_head=method == "HEAD")


def _parts(head: bytes) -> tuple[str, str, str]:
    """Method, path, and what the client accepts."""
    first, *rest = head.decode("latin-1").split("\r\n")
    method, _, remainder = first.partition(" ")
    fields = (line.partition(":") for line in rest)
    accepts = [value.strip() for name, _, value in fields if name.strip().lower() == "accept"]
    return method, remainder.partition(" ")[0], ",".join(accepts)


def _response(status: str, kind: str, body: bytes, *, only_head: bool = False) -> bytes:
    head = (
        f"HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {len(body)}\r\n"
        "Cache-Control: no-store\r\nConnection: close\r\n\r\n"
    )
    return head.encode("latin-1") + (b"" if only_head else body)
