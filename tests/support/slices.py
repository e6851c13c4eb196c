"""Slices of a log as other tools make them: with the plain mcap library, in the order of time."""

from pathlib import Path

from mcap.reader import make_reader
from mcap.writer import Writer

from reflexarc_logs.reading.reader import read_log


def slice_by_time(log: Path, out: Path, first_ns: int, end_ns: int) -> Path:
    """The messages of a time span (log time), sorted by it, with all metadata and attachments."""
    with log.open("rb") as source, out.open("wb") as target:
        reader, writer = make_reader(source), Writer(target)
        writer.start(profile="", library="another tool")
        for metadata in reader.iter_metadata():
            writer.add_metadata(metadata.name, metadata.metadata)
        for a in reader.iter_attachments():
            writer.add_attachment(a.log_time, a.create_time, a.name, a.media_type, a.data)
        schemas: dict[int, int] = {}
        channels: dict[int, int] = {}
        for schema, channel, message in reader.iter_messages(
            starting_at=first_ns, ending_before=end_ns
        ):
            assert schema is not None
            if schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(
                    schema.name, schema.encoding, schema.data
                )
            if channel.id not in channels:
                channels[channel.id] = writer.register_channel(
                    channel.topic,
                    channel.message_encoding,
                    schemas[schema.id],
                    channel.metadata,
                )
            writer.add_message(
                channels[channel.id],
                message.log_time,
                message.data,
                message.publish_time,
                message.sequence,
            )
        writer.finish()
    return out


def times_ns(log: Path) -> tuple[int, int]:
    """Earliest and latest log time."""
    times = [record.log_ns for record in read_log(log).records()]
    return min(times), max(times)
