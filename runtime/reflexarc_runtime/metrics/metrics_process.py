"""The process that answers scrapes for a loop: see `feed`.

    python -m reflexarc_runtime.metrics.metrics_process SOCKET LISTENER

It ends when the loop's end of the socket is closed, and with the process that started it.
"""

import asyncio
import socket
import sys
import time
from contextlib import suppress

from reflexarc_runtime.fleet.fleet import Fleet
from reflexarc_runtime.loop.side_process import serve_the_loop
from reflexarc_runtime.metrics.feed import MOST_WORD_BYTES, unpack_word
from reflexarc_runtime.metrics.scraping import Scraping


async def main(link: socket.socket, listener: socket.socket) -> None:
    """Answer until the loop has ended."""
    fleet = Fleet()
    serving = asyncio.create_task(Scraping(lambda: fleet.view(time.monotonic_ns())).serve(listener))
    while word := await asyncio.get_running_loop().sock_recv(link, MOST_WORD_BYTES):
        with suppress(ValueError):  # of somebody else on the bus; it ends nothing
            fleet.hear(unpack_word(word, time.monotonic_ns()))
    serving.cancel()


if __name__ == "__main__":
    serve_the_loop()
    own, port = (socket.socket(fileno=int(number)) for number in sys.argv[1:3])
    own.setblocking(False)
    with own, port, suppress(ConnectionError):
        asyncio.run(main(own, port))
