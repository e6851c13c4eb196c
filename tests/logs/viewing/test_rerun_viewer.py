import socket
import time
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest

from reflexarc_logs.viewing.rerun_viewer import HERE, end, page_of, serve_page, source_of
from reflexarc_runtime.errors import UsageError


def test_the_page_takes_its_data_from_this_machine():
    address = urlsplit(page_of(9876, 9090))
    assert (address.hostname, address.port) == ("127.0.0.1", 9090)
    assert parse_qs(address.query) == {"url": [source_of(9876)]}
    assert source_of(9876) == "rerun+http://127.0.0.1:9876/proxy"


def test_a_port_that_is_taken_is_named():
    with socket.socket() as other:
        other.bind((HERE, 0))
        other.listen()
        taken = other.getsockname()[1]
        with pytest.raises(UsageError, match=f"port {taken} is taken"):
            serve_page(taken, taken)


@pytest.mark.long
def test_the_page_is_served_on_this_machine_only_and_ends_with_all_that_it_started():
    pytest.importorskip("rerun")
    with socket.socket() as one, socket.socket() as other:
        one.bind((HERE, 0))
        other.bind((HERE, 0))
        ports = one.getsockname()[1], other.getsockname()[1]
    page = serve_page(*ports)
    try:
        assert all(answers(port) for port in ports)
        assert listening_on(ports[0]) == {"127.0.0.1"}
    finally:
        end(page)
    until_s = time.monotonic() + 10.0
    while answers(ports[0]) and time.monotonic() < until_s:
        time.sleep(0.1)
    assert not answers(ports[0])


def answers(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex((HERE, port)) == 0


def listening_on(port: int) -> set[str]:
    """The IPv4 addresses of this machine on which somebody listens at that port."""
    found = set()
    for line in Path("/proc/net/tcp").read_text().splitlines()[1:]:
        _, local, _, state, *_ = line.split()
        address, at = local.split(":")
        if state == "0A" and int(at, 16) == port:
            found.add(socket.inet_ntoa(bytes.fromhex(address)[::-1]))
    return found
