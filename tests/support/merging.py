"""Logs merged into one as other tools do: by time, all channels, metadata and attachments kept."""

from collections.abc import Callable, Sequence
from pathlib import Path

from mcap.reader import make_reader
from mcap.writer import Writer

Rename = Callable[[int, str], str]
"""(which of the logs, topic) → topic."""


def merge(
    logs: Sequence[Path],
    out: Path,
    *,
    rename: Rename = lambda number, topic: topic,
    with_heads: bool = True,
) -> Path:
    """Write all logs into one; `with_heads`: also what the later ones say about themselves."""
    rows = []
    with out.open("wb") as target:
        writer = Writer(target)
        writer.start(profile="", library="another tool")
        for number, log in enumerate(logs):
            with log.open("rb") as source:
                reader = make_reader(source)
                if not number or with_heads:
                    _copy_head(reader, writer, number, rename)
                rows += [
                    (message.log_time, number, schema, channel, message)
                    for schema, channel, message in reader.iter_messages()
                ]
        channels: dict[tuple[int, int], int] = {}
        for _, number, schema, channel, message in sorted(rows, key=lambda row: row[:2]):
            place = number, channel.id
            if place not in channels:
                registered = writer.register_schema(schema.name, schema.encoding, schema.data)
                topic = rename(number, channel.topic)
                channels[place] = writer.register_channel(
                    topic, channel.message_encoding, registered, channel.metadata
                )
            writer.add_message(
                channels[place],
                message.log_time,
                message.data,
                message.publish_time,
                message.sequence,
            )
        writer.finish()
    return out


def _copy_head(reader, writer, number: int, rename: Rename) -> None:  # type: ignore[no-untyped-def]
    """Metadata with the robot's name as the topics have it, and attachments."""
    for metadata in reader.iter_metadata():
        document = dict(metadata.metadata)
        if "robot" in document:
            document["robot"] = rename(number, f"/{document['robot']}/").strip("/")
        writer.add_metadata(metadata.name, document)
    for a in reader.iter_attachments():
        writer.add_attachment(a.log_time, a.create_time, a.name, a.media_type, a.data)
