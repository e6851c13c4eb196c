"""The bus: Eclipse Zenoh sessions with explicit configuration. Nothing else imports zenoh.

The defaults are for one machine: no multicast; the body listens on a port of the loopback
interface; everyone else listens on a free port, connects to the body with endless retry, and finds
the others by gossip, in any order of starting. A client listens nowhere and knows nobody but a
router. Other machines, TLS and access control are Zenoh's own configuration, given as a file.
"""

import json
import uuid
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import zenoh

from reflexarc_runtime.bus_config import LOOPBACK, MAX_MESSAGE_BYTES, BusConfig
from reflexarc_runtime.doors.credentials import credentials_of
from reflexarc_runtime.doors.open_doors import (
    Setting,
    connections,
    host_and_port,
    open_doors,
)
from reflexarc_runtime.errors import BusError, NoRouterError
from reflexarc_runtime.messages.topics import Quality, Topic, alive_key, policy_key, swap_key
from reflexarc_runtime.messages.wire import (
    MAX_ATTACHMENT_BYTES,
    MAX_ENCODING_CHARACTERS,
    MAX_PAYLOAD_BYTES,
    NO_SENDER,
    TOO_LARGE,
    Message,
    Stamp,
    UndecodableError,
    pack_stamp,
    protobuf_encoding,
    unpack_stamp,
)

_MOST_OVERHEARD = 64
_MOST_ANSWERS = 16
"""To one query; a robot has one runtime, and few that wait."""
CONNECT_MS = 1000
"""How long a client looks for its router before it says that there is none."""
ANSWERED_S = 5.0
"""How long answers to a query are waited for."""

_RETRY = {"period_init_ms": 50, "period_max_ms": 500, "period_increase_factor": 2}
_SHARED_MEMORY = "transport/shared_memory/enabled"
"""On by default, and then no session opens where `/dev/shm` cannot be written."""
_NOBODY = "Unable to connect to any of"
"""How Zenoh begins when a client has found no router."""


@dataclass(frozen=True, slots=True)
class PolicyAnswer:
    """What somebody answered who was asked for the policy. Anybody can, and say any name."""

    sender: bytes
    """The identifier that its commands carry; `NO_SENDER` if it gave none."""
    data: bytes


class Publisher:
    """Sends the messages of one topic, numbered from 0."""

    def __init__(self, publisher: zenoh.Publisher, sender: bytes) -> None:
        self._publisher = publisher
        self.sender = sender
        self._sequence = 0
        self.failures = 0

    @property
    def has_listener(self) -> bool:
        """Whether a subscriber is known."""
        status = self._publisher.matching_status
        return bool(status.matching)  # type: ignore[attr-defined]  # the stub says bool

    @property
    def next_sequence(self) -> int:
        """Number of the message that is sent next."""
        return self._sequence

    def put(self, payload: bytes, time_ns: int) -> None:
        """Send a message. A failure of the bus is counted, not raised: it must not end a loop."""
        stamp = pack_stamp(Stamp(self._sequence, time_ns, self.sender))
        self._sequence += 1
        try:
            self._publisher.put(payload, attachment=stamp)
        except zenoh.ZError:
            self.failures += 1

    def put_raw(self, payload: bytes, attachment: bytes, encoding: str) -> None:
        """Send bytes as they are: for players of logs, and for injected faults."""
        self._publisher.put(payload, attachment=attachment, encoding=zenoh.Encoding(encoding))


class Announcement:
    """What tells the others that a node is alive, for as long as its session is open.

    Args:
        declare: declares a liveliness token.
    """

    def __init__(self, declare: Callable[[], zenoh.LivelinessToken]) -> None:
        self._declare = declare
        self._token: zenoh.LivelinessToken | None = declare()

    def withdraw(self) -> None:
        """Let the others see this node as gone; a second call does nothing."""
        token, self._token = self._token, None
        if token is not None:
            token.undeclare()  # type: ignore[no-untyped-call]  # the stub has no type

    def renew(self) -> None:
        """Let the others see it again."""
        if self._token is None:
            self._token = self._declare()


class Bus:
    """One node's session. A context manager; leaving it closes everything that it declared.

    Args:
        config: how to reach the others.
        now_ns: the clock of arrivals.
        sender: identifier that all its messages carry, 16 bytes; a new one by default.

    Raises:
        BusError: the port is taken, Zenoh refuses the configuration, or the configuration lets in
            strangers; or a router's certificate or ours is refused.
        NoRouterError: a client finds no router, so far.
    """

    def __init__(
        self, config: BusConfig, now_ns: Callable[[], int], sender: bytes | None = None
    ) -> None:
        self._config = config
        self._now_ns = now_ns
        self.sender = sender or uuid.uuid4().bytes
        self._kept: list[Any] = []
        self._announced: set[str] = set()
        chosen = _zenoh_config(config)
        self.is_client = chosen.get_json("mode") == json.dumps("client")
        self._session = _open(chosen, config)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._session.close()  # type: ignore[no-untyped-call]  # the stub has no type

    @property
    def robot(self) -> str:
        """First part of the keys of its topics."""
        return self._config.robot

    @property
    def loneliness(self) -> str:
        """What it means that nobody is connected, in words."""
        file, place = self._config.zenoh_file, f"tcp/{LOOPBACK}:{self._config.port}"
        if file is not None:
            return f"nobody is connected by {file} (is the router there? are they started?)"
        if self._config.listens:
            return f"nobody has joined at {place} (is it started? with another --port?)"
        return f"nobody answers at {place} (is the body started? another --port?)"

    @property
    def session_id(self) -> str:
        """Zenoh's identifier of this session, in hexadecimal."""
        return str(self._session.info.zid())

    def publisher(self, topic: Topic) -> Publisher:
        """A publisher with the topic's quality of service."""
        encoding = protobuf_encoding(topic.schema)
        return self.publisher_of_key(topic.key(self._config.robot), encoding, topic.quality)

    def publisher_of_key(self, key: str, encoding: str, quality: Quality) -> Publisher:
        """A publisher on a key that is not in our topic table."""
        urgent, control = quality is Quality.CONTROL, zenoh.CongestionControl
        publisher = self._session.declare_publisher(
            key,
            encoding=zenoh.Encoding(encoding),
            express=urgent,
            priority=zenoh.Priority.REAL_TIME if urgent else zenoh.Priority.DATA,
            congestion_control=control.BLOCK if self._config.waits else control.DROP,
        )
        return Publisher(publisher, self.sender)

    def send_unasked(self, topic: Topic, payload: bytes, time_ns: int) -> None:
        """Send one message whether anybody listens or not: a publisher is silent where nobody does.

        For whoever tries what is let through: somebody who means it sends so too.
        """
        key = topic.key(self._config.robot)
        stamp = pack_stamp(Stamp(0, time_ns, self.sender))
        encoding = zenoh.Encoding(protobuf_encoding(topic.schema))
        self._session.put(key, payload, encoding=encoding, attachment=stamp)

    def subscribe(self, topics: Iterable[Topic], deliver: Callable[[Message], None]) -> None:
        """Call `deliver` with every message of these topics, on a thread of Zenoh's."""
        for topic in topics:
            self.subscribe_to_key(topic.key(self._config.robot), deliver)

    def subscribe_to_key(self, key: str, deliver: Callable[[Message], None]) -> None:
        """The same for a key that is not in our topic table."""

        def on_sample(sample: zenoh.Sample) -> None:
            deliver(_message(sample, self._now_ns()))

        self._kept.append(self._session.declare_subscriber(key, on_sample))

    def overhear(self, expressions: Iterable[str], wait: Callable[[], object]) -> dict[str, int]:
        """Listen to whatever others send on key expressions: how often each key was heard.

        Of at most 64 keys; nothing of what they carry is looked at.

        Args:
            expressions: what to listen to.
            wait: returns when it was long enough.
        """
        heard: Counter[str] = Counter()

        def count(sample: zenoh.Sample) -> None:
            key = str(sample.key_expr)
            if key in heard or len(heard) < _MOST_OVERHEARD:
                heard[key] += 1

        remote = zenoh.Locality.REMOTE
        listening = [
            self._session.declare_subscriber(each, count, allowed_origin=remote)
            for each in expressions
        ]
        wait()
        for subscriber in listening:
            subscriber.undeclare()  # type: ignore[no-untyped-call]  # the stub has no type
        return dict(heard)

    def tokens(self, expression: str) -> list[str]:
        """The liveliness tokens of others that match a key expression, of at most 64 nodes."""
        replies = self._session.liveliness().get(expression, timeout=1.0)
        found = (str(reply.ok.key_expr) for reply in replies if reply.ok is not None)
        return [key for key in islice(found, _MOST_OVERHEARD) if key not in self._announced]

    def watch_tokens(self, expression: str, deliver: Callable[[str, bool], None]) -> None:
        """Call `deliver` with every liveliness token that is there, comes or goes: key, is there.

        On a thread of Zenoh's.
        """

        def on_sample(sample: zenoh.Sample) -> None:
            deliver(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)

        liveliness = self._session.liveliness()
        self._kept.append(liveliness.declare_subscriber(expression, on_sample, history=True))

    @property
    def neighbours(self) -> int:
        """How many others this session is connected to: routers, peers, and clients of a router."""
        info = self._session.info
        if hasattr(info, "transports"):  # younger than Zenoh 1.5, and counts clients as well
            return len(list(info.transports()))
        return len(list(info.routers_zid())) + len(list(info.peers_zid()))

    def ask(self, selector: str, deliver: Callable[[Message], None]) -> None:
        """Call `deliver` with every answer to a query, on a thread of Zenoh's; do not wait."""

        def on_reply(reply: zenoh.Reply) -> None:
            if reply.ok is not None:
                deliver(_message(reply.ok, self._now_ns()))

        self._session.get(selector, on_reply, timeout=ANSWERED_S)

    def announce(self, node: str) -> Announcement:
        """Declare that a node is alive, for as long as this session is open."""
        return self.announce_key(alive_key(self._config.robot, node))

    def announce_key(self, key: str) -> Announcement:
        """Declare a liveliness token under any key, for as long as this session is open."""
        self._announced.add(key)
        announcement = Announcement(lambda: self._session.liveliness().declare_token(key))
        self._kept.append(announcement)
        return announcement

    def is_alive(self, node: str) -> bool:
        """Whether a node has announced itself."""
        replies = self._session.liveliness().get(alive_key(self._config.robot, node), timeout=1.0)
        return any(reply.ok is not None for reply in replies)

    def offer_policy(self, policy: Callable[[], bytes]) -> None:
        """Answer queries for the policy with the bytes of its file, and with who answers."""
        key = policy_key(self._config.robot)

        def answer(query: zenoh.Query) -> None:
            stamp = pack_stamp(Stamp(0, self._now_ns(), self.sender))
            query.reply(key, policy(), attachment=stamp)

        self._kept.append(self._session.declare_queryable(key, answer))

    def take_requests(self, deal: Callable[[bytes, Callable[[bytes], None]], None]) -> None:
        """Take requests for another policy.

        Args:
            deal: is given each request, and what takes the answer, once, from any thread; it
                returns at once. What is too large is not copied: see `TOO_LARGE`.
        """
        key = swap_key(self._config.robot)

        def on_query(query: zenoh.Query) -> None:
            payload = query.payload
            is_small = payload is not None and len(payload) <= MAX_PAYLOAD_BYTES
            request = payload.to_bytes() if payload is not None and is_small else TOO_LARGE

            def answer(said: bytes) -> None:
                with suppress(zenoh.ZError):  # whoever asked may have gone
                    query.reply(key, said)
                query.drop()  # type: ignore[no-untyped-call]  # the stub has no type

            deal(b"" if payload is None else request, answer)

        self._kept.append(self._session.declare_queryable(key, on_query))

    def request_swap(self, request: bytes, timeout_s: float) -> list[bytes]:
        """Ask every runtime of the robot for another policy: what they answer, of at most 16."""
        replies = self._session.get(
            swap_key(self._config.robot),
            payload=request,
            target=zenoh.QueryTarget.ALL,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=timeout_s,
        )
        found = (reply.ok.payload for reply in replies if reply.ok is not None)
        return [said.to_bytes() for said in islice(found, _MOST_ANSWERS) if len(said) <= 1 << 16]

    def fetch_policy(self, timeout_s: float = 2.0) -> bytes | None:
        """Ask for the policy file; None if nobody answers."""
        return next((answer.data for answer in self.policy_answers(timeout_s)), None)

    def policy_answers(self, timeout_s: float) -> Iterator[PolicyAnswer]:
        """Ask everybody for the policy file: what comes within a time, of at most 16."""
        replies = self._session.get(
            policy_key(self._config.robot),
            target=zenoh.QueryTarget.ALL,
            consolidation=zenoh.ConsolidationMode.NONE,  # else one answer for each key
            timeout=timeout_s,
        )
        for reply in islice(replies, _MOST_ANSWERS):
            if reply.ok is not None:
                sample = reply.ok
                yield PolicyAnswer(_sender_of(sample.attachment), sample.payload.to_bytes())


def settings_of_file(path: Path, *, allow_open: bool = True) -> Setting:
    """What Zenoh makes of a configuration file, without joining.

    Raises:
        BusError: it cannot be read, or Zenoh refuses it; or it lets in strangers, who are not
            allowed.
    """
    config = BusConfig(zenoh_file=path, allow_open=allow_open)
    return _settings_of(_config_of_file(config, path))


def _sender_of(attachment: zenoh.ZBytes | None) -> bytes:
    try:
        return NO_SENDER if attachment is None else unpack_stamp(_head(attachment)).sender
    except UndecodableError:
        return NO_SENDER


def _message(sample: zenoh.Sample, now_ns: int) -> Message:
    """What came, as far as anybody will believe it: whatever is too large is not copied."""
    payload, attachment = sample.payload, sample.attachment
    return Message(
        key=str(sample.key_expr),
        payload=payload.to_bytes() if len(payload) <= MAX_PAYLOAD_BYTES else TOO_LARGE,
        encoding=str(sample.encoding)[:MAX_ENCODING_CHARACTERS],
        attachment=b"" if attachment is None else _head(attachment),
        received_ns=now_ns,
    )


def _head(attachment: zenoh.ZBytes) -> bytes:
    if len(attachment) <= MAX_ATTACHMENT_BYTES:
        return attachment.to_bytes()
    return bytes(MAX_ATTACHMENT_BYTES)


def _open(chosen: zenoh.Config, config: BusConfig) -> zenoh.Session:
    try:
        return zenoh.open(chosen)
    except zenoh.ZError as error:
        if str(error).startswith(_NOBODY):
            raise _absence(chosen, config, str(error)) from None
        raise BusError(_explain(config, str(error))) from None


def _zenoh_config(config: BusConfig) -> zenoh.Config:
    if config.zenoh_file is not None:
        return _config_of_file(config, config.zenoh_file)
    body = f"tcp/{LOOPBACK}:{config.port}"
    chosen = zenoh.Config()
    chosen.insert_json5(_SHARED_MEMORY, json.dumps(False))
    chosen.insert_json5("scouting/multicast/enabled", json.dumps(False))
    if config.client:
        chosen.insert_json5("mode", json.dumps("client"))
        chosen.insert_json5("connect/endpoints", json.dumps([body]))
        chosen.insert_json5("connect/retry", json.dumps(_RETRY))
        chosen.insert_json5("connect/timeout_ms", json.dumps(CONNECT_MS))
        return chosen
    chosen.insert_json5("mode", json.dumps("peer"))
    chosen.insert_json5("scouting/gossip/enabled", json.dumps(True))
    chosen.insert_json5("transport/link/rx/max_message_size", json.dumps(MAX_MESSAGE_BYTES))
    own = body if config.listens else f"tcp/{LOOPBACK}:0"
    chosen.insert_json5("listen/endpoints", json.dumps([own]))
    if not config.listens:
        chosen.insert_json5("connect/endpoints", json.dumps([body]))
        chosen.insert_json5("connect/retry", json.dumps(_RETRY))
    return chosen


def _config_of_file(config: BusConfig, path: Path) -> zenoh.Config:
    """What the file says; shared memory, which many containers lack, only if it says so."""
    try:
        speaks_of_it = b"shared_memory" in path.read_bytes()
    except OSError as error:
        raise BusError(f"--zenoh: {path}: {(error.strerror or '').lower()}") from None
    try:
        chosen = zenoh.Config.from_file(path)
    except zenoh.ZError as error:
        raise BusError(_explain(config, str(error))) from None
    if not speaks_of_it:
        chosen.insert_json5(_SHARED_MEMORY, json.dumps(False))
    doors = [] if config.allow_open else open_doors(_settings_of(chosen))
    if doors:
        raise BusError(_explain_open_doors(path, doors))
    return chosen


def _settings_of(chosen: zenoh.Config) -> Setting:
    return lambda path: json.loads(chosen.get_json(path))


def _explain_open_doors(path: Path, doors: list[str]) -> str:
    return (
        f"--zenoh: {path}: expected a bus that strangers cannot join; this one "
        f"{' and '.join(doors)}: `reflexarc secure init` makes one; --allow-open joins all the same"
    )


def _absence(chosen: zenoh.Config, config: BusConfig, reason: str) -> BusError:
    """Why a client has joined nobody: nobody is there, or a certificate is refused."""
    if config.zenoh_file is None:
        return NoRouterError(f"no Zenoh router on {LOOPBACK}:{config.port}")
    told = f"--zenoh: {config.zenoh_file}: "
    found = _refusals(chosen, config.zenoh_file)
    refused = [words for words, may_pass in found if not may_pass]
    if refused:
        return BusError(told + refused[0])
    if found:
        return NoRouterError(told + found[-1][0])
    return NoRouterError(told + _first_line(reason))


def _refusals(chosen: zenoh.Config, path: Path) -> list[tuple[str, bool]]:
    """What each TLS door says, in words, and whether waiting may mend it."""
    from reflexarc_runtime.doors.tls_refusal import why_refused  # loads OpenSSL

    setting = _settings_of(chosen)
    shown = credentials_of(path, setting)
    if shown is None:
        return []
    found = []
    for locator in connections(setting):
        host, port = host_and_port(locator)
        refusal = why_refused(host, port, shown) if locator.startswith("tls/") else None
        if refusal is not None:
            found.append((f"{locator}: {refusal.words}", refusal.may_pass))
    return found


def _first_line(reason: str) -> str:
    """What Zenoh said, without the place in its source where it said it."""
    return reason.splitlines()[0].partition(" at /")[0][:200]


def _explain(config: BusConfig, reason: str) -> str:
    if config.zenoh_file is not None:
        return f"--zenoh: {config.zenoh_file}: Zenoh refuses it: {reason.splitlines()[0][:200]}"
    if config.listens:
        return (
            f"port {config.port} of {LOOPBACK} cannot be listened on (in use?); "
            "stop the other body or choose another --port"
        )
    return f"the bus cannot be opened: {reason.splitlines()[0][:200]}"
