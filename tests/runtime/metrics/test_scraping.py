"""Who asks for metrics: properly, slowly, too often, or for something else."""

import asyncio
import socket
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
from prometheus_client.parser import text_string_to_metric_families

from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.fleet.fleet import Fleet
from reflexarc_runtime.metrics.listener import address_of, listener_at
from reflexarc_runtime.metrics.scraping import MOST_CONNECTIONS, MOST_HEAD_BYTES, Scraping
from support.fleet_words import status

GET = b"GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n"
Talk = Callable[[int], Awaitable[Any]]


def served(talk: Talk, patience_s: float = 5.0) -> Any:
    """What somebody finds who talks to a server of one robot."""
    fleet = Fleet()
    fleet.hear(status("rover", verdicts={"OK": 5}))

    async def both() -> Any:
        listener = listener_at("127.0.0.1", 0)
        port = listener.getsockname()[1]
        server = asyncio.create_task(Scraping(lambda: fleet.view(0), patience_s).serve(listener))
        try:
            return await asyncio.wait_for(talk(port), 60.0)
        finally:
            server.cancel()
            await asyncio.gather(server, return_exceptions=True)

    return asyncio.run(both())


async def asked(port: int, request: bytes) -> bytes:
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(request)
    try:
        return await reader.read()
    except ConnectionResetError:
        return b""
    finally:
        writer.close()


def test_a_scrape_is_answered_as_http_and_ends_the_connection():
    answer = served(lambda port: asked(port, GET))
    head, _, body = answer.partition(b"\r\n\r\n")
    lines = head.decode().split("\r\n")
    assert lines[0] == "HTTP/1.1 200 OK"
    assert f"Content-Length: {len(body)}" in lines
    assert "Content-Type: text/plain; version=0.0.4; charset=utf-8" in lines
    families = {family.name for family in text_string_to_metric_families(body.decode())}
    assert "reflexarc_ticks" in families


def test_whoever_prefers_open_metrics_gets_it():
    request = GET[:-2] + b"aCCept: application/openmetrics-text; version=1.0.0,text/plain\r\n\r\n"
    answer = served(lambda port: asked(port, request))
    assert b"Content-Type: application/openmetrics-text; version=1.0.0" in answer
    assert answer.endswith(b"# EOF\n")


@pytest.mark.parametrize(
    ("request_head", "status_line"),
    [
        (b"GET / HTTP/1.1\r\n\r\n", b"HTTP/1.1 404 Not Found"),
        (b"GET /metrics/../etc HTTP/1.1\r\n\r\n", b"HTTP/1.1 404 Not Found"),
        (b"GET /metrics?name=x HTTP/1.0\r\n\r\n", b"HTTP/1.1 200 OK"),
        (b"HEAD /metrics HTTP/1.1\r\n\r\n", b"HTTP/1.1 200 OK"),
        (b"POST /metrics HTTP/1.1\r\n\r\n", b"HTTP/1.1 405 Method Not Allowed"),
        (b"\xff\xfe\x00\r\n\r\n", b"HTTP/1.1 405 Method Not Allowed"),
        (b"\r\n\r\n", b"HTTP/1.1 405 Method Not Allowed"),
        (b"GET /metrics " + b"x" * 2 * MOST_HEAD_BYTES + b"\r\n\r\n", b""),
    ],
)
def test_what_is_asked_for_is_answered_in_http_or_not_at_all(
    request_head: bytes, status_line: bytes
):
    answer = served(lambda port: asked(port, request_head))
    assert answer.split(b"\r\n")[0] == status_line


def test_whoever_asks_slowly_holds_up_nobody_and_is_closed():
    async def talk(port: int) -> tuple[bytes, bytes]:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        writer.write(GET[:9])
        meanwhile = await asked(port, GET)
        left = await reader.read()  # ends when the server's patience does
        writer.close()
        return meanwhile, left

    meanwhile, left = served(talk, patience_s=0.5)
    assert meanwhile.startswith(b"HTTP/1.1 200 OK")
    assert left == b""


def test_more_connections_than_it_holds_are_closed_and_it_answers_afterwards():
    async def talk(port: int) -> tuple[int, bytes]:
        idle = [await asyncio.open_connection("127.0.0.1", port) for _ in range(120)]
        early = 0
        for reader, _ in idle[MOST_CONNECTIONS:]:
            try:
                early += await asyncio.wait_for(reader.read(), 20.0) == b""
            except ConnectionResetError:
                early += 1
        for _, writer in idle:
            writer.close()
        await asyncio.sleep(0.2)
        return early, await asked(port, GET)

    early, answer = served(talk, patience_s=300.0)
    assert early == 120 - MOST_CONNECTIONS  # at once: its patience is five minutes
    assert answer.startswith(b"HTTP/1.1 200 OK")


def test_a_port_in_use_is_refused_in_one_line():
    with listener_at("127.0.0.1", 0) as taken:
        port = taken.getsockname()[1]
        expected = f"--metrics {port}: expected a free port of 127.0.0.1, got: Address already"
        with pytest.raises(UsageError, match=expected):
            listener_at("127.0.0.1", port)


def test_an_address_that_this_machine_has_not_is_refused():
    with pytest.raises(UsageError, match=r"--metrics 9464: expected a free port of 192.0.2.1"):
        listener_at("192.0.2.1", 9464)


def test_port_0_is_any_that_is_free_and_is_said():
    with listener_at("127.0.0.1", 0) as listener:
        assert address_of(listener) == f"http://127.0.0.1:{listener.getsockname()[1]}/metrics"
    if socket.has_ipv6:
        try:
            listener = listener_at("::1", 0)
        except UsageError:
            return
        with listener:
            assert address_of(listener).startswith("http://[::1]:")
