"""Metrics of one loop, answered by a process of its own.

The loop hands over its status when it has sent it: one call to the system a second, which never
waits. Whatever is done to the port (a flood of scrapes, connections that never end) happens to
another process, of lower priority: a thread that shared the interpreter would hold up the loop.
"""

import socket
import struct
import subprocess
import sys
from contextlib import suppress
from itertools import accumulate, pairwise
from types import TracebackType
from typing import Self

from reflexarc_runtime.loop.outlets import Outlet
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp

MOST_WORD_BYTES = 1 << 16
_PROCESS = "reflexarc_runtime.metrics.metrics_process"
_LENGTHS = struct.Struct("<III")
"""Of key, encoding and attachment, in bytes: whoever sent them may have put anything into them."""


class MetricsFeed:
    """Feeds the process that answers scrapes. A context manager: inside, it runs.

    Args:
        listener: where it answers; closed here.
    """

    def __init__(self, listener: socket.socket) -> None:
        self._listener = listener

    def __enter__(self) -> Self:
        self._link, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        nowhere = subprocess.DEVNULL
        with theirs, self._listener:
            descriptors = [theirs.fileno(), self._listener.fileno()]
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", _PROCESS, *map(str, descriptors)],
                stdin=nowhere,
                stdout=nowhere,
                stderr=nowhere,
                pass_fds=descriptors,
            )
        self._link.setblocking(False)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._link.close()
        self._process.kill()
        self._process.wait()

    @property
    def pid(self) -> int:
        """Of its process."""
        return self._process.pid

    def hear(self, message: Message) -> None:
        """Hand over one message; from any thread, never waits."""
        with suppress(OSError):  # it is behind, or has ended: a second of it is missing
            self._link.send(pack_word(message))


class Overheard:
    """An outlet that also tells the metrics what it sends.

    Args:
        outlet: where it goes.
        key: of the topic.
        encoding: of the topic.
        sender: the identifier of the loop.
        feed: of the metrics.
    """

    def __init__(
        self, outlet: Outlet, key: str, encoding: str, sender: bytes, feed: MetricsFeed
    ) -> None:
        self._outlet, self._key, self._encoding = outlet, key, encoding
        self._sender, self._feed = sender, feed

    def put(self, payload: bytes, time_ns: int) -> None:
        """See `Outlet.put`."""
        self._outlet.put(payload, time_ns)
        stamp = pack_stamp(Stamp(0, time_ns, self._sender))
        self._feed.hear(Message(self._key, payload, self._encoding, stamp, time_ns))


def pack_word(message: Message) -> bytes:
    """A message as it goes to the other process, which has a clock of its own."""
    head = message.key.encode(), message.encoding.encode(), message.attachment
    return b"".join((_LENGTHS.pack(*map(len, head)), *head, message.payload))


def unpack_word(word: bytes, received_ns: int) -> Message:
    """The message, as if it had arrived just now.

    Raises:
        ValueError: it is none; of a word that is too long the end is missing.
    """
    if len(word) < _LENGTHS.size:
        raise ValueError("expected a word of a loop")
    ends = list(accumulate(_LENGTHS.unpack_from(word), initial=_LENGTHS.size))
    key, encoding, attachment = (word[begin:end] for begin, end in pairwise(ends))
    return Message(key.decode(), word[ends[-1] :], encoding.decode(), attachment, received_ns)
