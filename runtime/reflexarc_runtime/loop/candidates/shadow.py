"""A policy that watches a loop without acting, in a process of its own.

The loop hands over a tick when its command has been sent, and takes what the process has said by
then: two calls to the system that never wait. So whatever the shadow does (raise, hang, take a
second for each decision, end) costs the loop nothing but ticks of the shadow, which are counted. No
thread takes part: one that shared the interpreter with the loop would hold it up.
"""

import select
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from reflexarc_runtime.decision import Decision
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.loop.candidates.shadow_wire import (
    MOST_ANSWER_BYTES,
    READY,
    pack_tick,
    unpack_answer,
)
from reflexarc_runtime.loop.outlets import NoOutlet, Outlet
from reflexarc_runtime.loop.trials.trial import LOADING_S, STARTING_S
from reflexarc_runtime.messages.topics import SHADOW
from reflexarc_runtime.messages.wire import NO_SENDER, Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.policy.model_file import policy_hash
from reflexarc_runtime.serving.shadowing import ShadowTick
from reflexarc_runtime.serving.swapping import SHOWN

MOST_BEHIND = 8
"""Ticks that a shadow may be behind; what comes then it misses."""
MOST_AT_ONCE = 4
"""Answers that are taken at one tick."""
LAST_ANSWERS_S = 0.2
"""How long the last answers are waited for, when the loop has ended."""
_PROCESS = "reflexarc_runtime.loop.candidates.shadow_process"


@dataclass
class ShadowAccount:
    """What a shadow did."""

    policy_hash: str
    given: int = 0
    """Ticks that it was given."""
    compared: int = 0
    """Ticks at which it said something."""
    different: int = 0
    """Ticks at which it preferred another action than the policy that decided."""
    faults: int = 0
    lost: int = 0
    """Ticks that it missed, as it was too far behind, or had ended."""
    has_ended: bool = False

    @property
    def words(self) -> str:
        """All of it on one line."""
        said = f"{self.policy_hash[:SHOWN]}: {self.compared} ticks, {self.different} otherwise"
        said += f", {self.faults} faults" * bool(self.faults)
        said += f", {self.lost} missed" * bool(self.lost)
        return said + ", has ended" * self.has_ended


class Shadow:
    """A shadow of one loop. A context manager: inside, its process runs.

    Args:
        policy: the bytes of its file, which were tried.
        backend: what computes it.
        put: takes what it says, to be recorded.
        outlet: publishes what it says where it would have done something else.
        name: what errors call the policy.
        robot: the robot's name.
        sender: the identifier of the loop.
        patience_s: how long each answer is waited for, in lockstep; 0: not at all.
    """

    def __init__(
        self,
        policy: bytes,
        backend: str,
        put: Callable[[Message], None],
        outlet: Outlet | None = None,
        *,
        name: str = "policy",
        robot: str,
        sender: bytes = NO_SENDER,
        patience_s: float = 0.0,
    ) -> None:
        self.account = ShadowAccount(policy_hash(policy))
        self._policy, self._backend, self._name = policy, backend, name
        self._put, self._outlet = put, outlet or NoOutlet()
        self._key, self._encoding = SHADOW.key(robot), protobuf_encoding(SHADOW.schema)
        self._sender, self._patience_s = sender, patience_s
        self._begins, self._behind, self._said = True, 0, 0
        self._input, self._now_ns = (-1, -1), 0

    def __enter__(self) -> Self:
        self._link, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        words = [sys.executable, "-P", "-m", _PROCESS, str(theirs.fileno())]
        nowhere = subprocess.DEVNULL
        with theirs, tempfile.TemporaryFile() as given:  # a pipe would hold up whoever fills it
            given.write(self._policy)
            given.seek(0)
            self._process = subprocess.Popen(
                [*words, self._backend],
                stdin=given,
                stdout=nowhere,
                stderr=nowhere,
                pass_fds=[theirs.fileno()],
            )
        try:
            self._await_ready()
        except BaseException:
            self._end()
            raise
        self._link.setblocking(False)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        end_s = time.monotonic() + LAST_ANSWERS_S
        while self._behind and (left_s := end_s - time.monotonic()) > 0.0 and self._waited(left_s):
            self._take()
        self._end()

    @property
    def pid(self) -> int:
        """Of its process."""
        return self._process.pid

    @property
    def state(self) -> str:
        """What it did so far, for the status."""
        return self.account.words

    def saw(self, decision: Decision) -> None:
        """Give it a tick, and take what it has said; from the loop's thread, behind the command."""
        self._now_ns = decision.now_ns
        self._take()
        if not decision.retina:
            self._begins = True
            return
        used = decision.input
        came = (-1, -1) if used is None else (used.sequence, used.source_time_ns)
        is_newer, self._input = came != self._input, came
        tick = ShadowTick(
            decision.index,
            decision.slot,
            decision.retina,
            decision.winner,
            self._begins,
            is_newer,
        )
        is_given = self._give(pack_tick(tick))
        self._begins = not is_given
        if self._patience_s and is_given and self._waited(self._patience_s):
            self._take()

    def _give(self, tick: bytes) -> bool:
        if not self.account.has_ended and self._behind < MOST_BEHIND:
            try:
                self._link.send(tick)
            except BlockingIOError:
                pass
            except OSError:  # it has ended, or a tick is larger than any message may be
                self.account.has_ended = self._process.poll() is not None
            else:
                self._behind += 1
                self.account.given += 1
                return True
        self.account.lost += 1
        return False

    def _take(self) -> None:
        for _ in range(MOST_AT_ONCE if self._behind else 0):
            try:
                answer = self._link.recv(MOST_ANSWER_BYTES)
            except BlockingIOError:
                return
            except OSError:
                answer = b""
            if not answer:
                self.account.lost += self._behind
                self.account.has_ended, self._behind = True, 0
                return
            self._count(answer)

    def _count(self, answer: bytes) -> None:
        failed, differs, payload = unpack_answer(answer)
        account = self.account
        self._behind -= 1
        account.compared += 1
        account.faults += failed
        account.different += differs
        now_ns = self._now_ns
        stamp = pack_stamp(Stamp(self._said, now_ns, self._sender))
        self._said += 1
        self._put(Message(self._key, payload, self._encoding, stamp, now_ns))
        if failed or differs:
            self._outlet.put(payload, now_ns)

    def _waited(self, seconds: float) -> bool:
        """Whether something can be read within a time."""
        return bool(select.select([self._link], [], [], seconds)[0])

    def _await_ready(self) -> None:
        self._link.settimeout(STARTING_S + LOADING_S)
        try:
            said = self._link.recv(len(READY))
        except OSError:
            said = b""
        if said != READY:
            raise PolicyError(
                f"--shadow: {self._name}: expected a policy that loads, its process ended or hangs"
            )

    def _end(self) -> None:
        self._link.close()
        self._process.kill()
        self._process.wait()
