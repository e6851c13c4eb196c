"""Logs of other systems, written with the MCAP library alone."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from mcap.writer import Writer

Rows = Iterable[tuple[int, int, Any]]
"""Sequence, time of sending, content."""


def json_log(path: Path, **topics: Rows) -> Path:
    """A log of JSON messages: topic → rows; they arrive in the order of their times."""
    rows = [(sent, seq, topic, what) for topic in topics for seq, sent, what in topics[topic]]
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channels = {t: writer.register_channel(f"/{t}", "json", 0) for t in topics}
        for sent, seq, topic, what in sorted(rows, key=lambda row: row[0]):
            data = what if isinstance(what, bytes) else json.dumps(what).encode()
            writer.add_message(channels[topic], sent + 7, data, sent, seq)
        writer.finish()
    return path


def one_message(path: Path, encoding: str, payload: bytes, schema: tuple[str, str, bytes]) -> Path:
    """A log of one message on `/p`; the schema is a name, an encoding and a text, or empty."""
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        number = writer.register_schema(*schema) if schema[0] else 0
        writer.add_message(writer.register_channel("/p", encoding, number), 1, payload, 1)
        writer.finish()
    return path
