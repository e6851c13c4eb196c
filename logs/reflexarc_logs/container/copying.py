"""Copies messages from one log to another as they are: topic, schema, sender, times and bytes."""

from mcap.records import Channel, McapRecord, Message, Schema

from reflexarc_logs.container.writing import LogWriter


class MessageCopier:
    """Copies the messages of one file into another.

    Args:
        file: where they go.
    """

    def __init__(self, file: LogWriter) -> None:
        self._file = file
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}

    def learn(self, record: McapRecord) -> None:
        """Take a record that may say what messages are."""
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Channel):
            self._channels[record.id] = record

    def topic(self, message: Message) -> str:
        """The topic of a message; empty if its channel is unknown."""
        channel = self._channels.get(message.channel_id)
        return "" if channel is None else channel.topic

    def copy(self, message: Message) -> bool:
        """Copy a message; False if its channel or schema stood in a part that was lost."""
        channel = self._channels.get(message.channel_id)
        schema = None if channel is None else self._schemas.get(channel.schema_id)
        if channel is None or (schema is None and channel.schema_id):
            return False
        target = self._file.raw_channel(
            channel.topic, channel.message_encoding, schema, channel.metadata
        )
        self._file.add(
            target,
            message.data,
            sequence=message.sequence,
            publish_ns=message.publish_time,
            log_ns=message.log_time,
        )
        return True
