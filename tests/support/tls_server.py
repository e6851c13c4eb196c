"""A TLS 1.3 server of Python's own that asks for certificates, as a door does."""

import socket
import ssl
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from reflexarc.securing.authority import Identity


@contextmanager
def tls_server(own: Identity, known: bytes, folder: Path) -> Iterator[int]:
    """Accept connections one by one, and hold each for as long as it is shaken hands with."""
    file = folder / "server.pem"
    file.write_bytes(own.certificate + own.key)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_3
    context.verify_mode = ssl.CERT_REQUIRED
    context.load_verify_locations(cadata=known.decode())
    context.load_cert_chain(file)
    kept: list[ssl.SSLSocket] = []
    with socket.create_server(("127.0.0.1", 0)) as listener:
        listener.settimeout(0.1)
        ended = threading.Event()

        def serve() -> None:
            while not ended.is_set():
                try:
                    plain, _ = listener.accept()
                    plain.settimeout(2.0)
                    kept.append(context.wrap_socket(plain, server_side=True))
                except OSError:  # also TLS: refused
                    continue

        thread = threading.Thread(target=serve)
        thread.start()
        try:
            yield listener.getsockname()[1]
        finally:
            ended.set()
            thread.join()
            for each in kept:
                each.close()
