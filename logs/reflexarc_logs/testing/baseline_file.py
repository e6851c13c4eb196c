"""Writes a log anew: what came to the loop byte for byte, and the decisions of now."""

import json
from dataclasses import replace
from pathlib import Path

from google.protobuf.message import Message as ProtobufMessage
from mcap.records import Channel, Message

from reflexarc_logs.container.copying import MessageCopier
from reflexarc_logs.container.packing.schemas import PROTOBUF, schema_of
from reflexarc_logs.container.run_info import RUN, installed_versions
from reflexarc_logs.container.writing import (
    CONFIG_ATTACHMENT,
    POLICY_ATTACHMENT,
    LogWriter,
    media_type_of,
)
from reflexarc_logs.reading.reader import Log
from reflexarc_logs.testing.decided_anew import DecidedAnew
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.topics import COMMAND, KEYFRAME, TICK
from reflexarc_runtime.policy.policy import LoadedPolicy

BASELINE = "reflexarc.baseline"
"""Metadata of a log that was accepted: in the place of which one, and what was different."""


def write_baseline(
    log: Log, policy: LoadedPolicy, anew: DecidedAnew, path: Path, said: dict[str, str]
) -> None:
    """Write a log in which the decisions of now stand in the place of the recorded ones.

    Args:
        log: the old one.
        policy: whose decisions they are.
        anew: the decisions.
        path: the new one.
        said: what it says about itself: see `BASELINE`.

    Raises:
        LogError: `log` holds a tick or keyframe that was not decided anew.
        OSError: `path` cannot be written.
    """
    file = LogWriter(path)
    try:
        _write_head(file, log, policy, said)
        _Rewriting(file, log, anew).run()
        file.finish()
    except BaseException:
        file.discard()
        raise


def _write_head(file: LogWriter, log: Log, policy: LoadedPolicy, said: dict[str, str]) -> None:
    run = replace(log.run, versions=installed_versions(), backend=policy.backend.value)
    provenance = policy.contract.provenance
    if policy.policy_hash != run.policy_hash:
        identity = policy.policy_hash
        run = replace(run, policy_hash=identity, policy_seed=provenance.seed)
        run = replace(run, commit=provenance.commit)
    heads = {RUN: {**log.metadata[RUN], **run.to_metadata()}, BASELINE: said}
    for name, document in {**log.metadata, **heads}.items():
        file.describe(name, document)
    ours = {POLICY_ATTACHMENT: policy.data}
    if log.config is not None:
        ours[CONFIG_ATTACHMENT] = _config(log.config, policy)
    for name, data in {**log.attachments, **ours}.items():
        file.attach(name, media_type_of(name), data)


def _config(config: bytes, policy: LoadedPolicy) -> bytes:
    """The configuration with the contract of the policy, if it has one."""
    try:
        document = json.loads(config)
    except (ValueError, RecursionError):
        return config
    if not isinstance(document, dict) or "contract" not in document:
        return config
    return json.dumps({**document, "contract": json.loads(policy.contract.to_json())}).encode()


class _Rewriting:
    """The messages of a log on their way into the new one."""

    def __init__(self, file: LogWriter, log: Log, anew: DecidedAnew) -> None:
        self._file, self._log, self._anew = file, log, anew
        self._copier = MessageCopier(file)
        self._channels: dict[int, Channel] = {}
        self._ticks, self._keyframes = iter(anew.ticks), iter(anew.keyframes)

    def run(self) -> None:
        """Write all messages.

        Raises:
            LogError: there is a tick or keyframe that was not decided anew.
        """
        for record in self._log.mcap_records():
            if isinstance(record, Message):
                self._put(record)
            else:
                self._copier.learn(record)
                if isinstance(record, Channel):
                    self._channels[record.id] = record

    def _put(self, message: Message) -> None:
        topic = self._copier.topic(message)
        payload: bytes | None
        if topic == self._log.topic(TICK.name):
            payload = next(self._ticks, None)
            self._add(message, TICK.message, payload)
        elif topic == self._log.topic(KEYFRAME.name):
            payload = next(self._keyframes, None)
            self._add(message, KEYFRAME.message, payload)
        elif topic == self._log.topic(COMMAND.name) and message.data in self._anew.commands:
            self._add(message, COMMAND.message, self._anew.commands[message.data])
        else:
            self._copier.copy(message)

    def _add(self, message: Message, kind: type[ProtobufMessage], payload: bytes | None) -> None:
        """Write what is decided now where the old message stood."""
        if payload is None:
            raise LogError(
                f"{self._log.path}: it tells more ticks or keyframes than one loop: it cannot be "
                "decided anew; record it again"
            )
        channel = self._channels[message.channel_id]
        target = self._file.raw_channel(channel.topic, PROTOBUF, schema_of(kind), channel.metadata)
        self._file.add(
            target,
            payload,
            sequence=message.sequence,
            publish_ns=message.publish_time,
            log_ns=message.log_time,
        )
