import socket
from urllib.parse import parse_qs, urlsplit

import pytest

from reflexarc_logs.viewing.rerun_viewer import HERE, page_of, serve_page, source_of
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
