"""The flags that all commands on the bus have, and how they join it."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from reflexarc.terminal.output import aside

if TYPE_CHECKING:
    from reflexarc.wiring.asking import Asking, Wanted
    from reflexarc.wiring.waiting import Waiting
    from reflexarc_runtime.bus import Bus
    from reflexarc_runtime.bus_config import BusConfig
    from reflexarc_runtime.contract.bounds import Bounds
    from reflexarc_runtime.contract.contract import PolicyContract

ASK_AGAIN_S = 0.1


@dataclass(frozen=True)
class Joining:
    """Which robot's keys a command uses, and how it reaches the bus."""

    robot: str = "robot0"
    """First part of every key on the bus."""
    port: int = 7447
    """Port of 127.0.0.1 on which the body listens."""
    zenoh: Path | None = None
    """Zenoh configuration (JSON5) in place of the loopback: other machines, TLS, access. `reflexarc
    secure init` writes such files."""
    allow_open: bool = False
    """Join although --zenoh lets strangers in: a plain listener, or scouting by multicast."""

    def config(self, *, listens: bool = False, client: bool = False) -> "BusConfig":
        """The configuration of the bus session; `listens` is for the one body."""
        from reflexarc_runtime.bus_config import BusConfig

        return BusConfig(
            self.robot, self.port, listens, self.zenoh, client, allow_open=self.allow_open
        )

    def check(self) -> None:
        """Look at all that can be said before a session is opened.

        Raises:
            UsageError, BusError: no such name or port; or the Zenoh configuration cannot be read,
                or lets in strangers.
        """
        self.config()
        if self.zenoh is not None:
            from reflexarc_runtime.bus import settings_of_file

            settings_of_file(self.zenoh, allow_open=self.allow_open)

    def bus(
        self, node: str, *, listens: bool = False, lockstep: bool = False, client: bool = False
    ) -> "Bus":
        """A session on the bus; a context manager.

        Args:
            node: what the command is on the bus: runtime, body, recorder.
            listens: whether it is the one body.
            lockstep: whether the same run shall give the same messages, senders included.
            client: whether it reaches the others only through a router.
        """
        from reflexarc_runtime.bus import Bus
        from reflexarc_runtime.loop.clock import MonotonicClock
        from reflexarc_runtime.messages.wire import lockstep_sender

        sender = lockstep_sender(node) if lockstep else None
        config = replace(self.config(listens=listens, client=client), waits=lockstep)
        return Bus(config, MonotonicClock().now_ns, sender)

    def bus_in_time(
        self,
        node: str,
        stop: Callable[[], bool],
        who: str,
        *,
        listens: bool = False,
        lockstep: bool = False,
        quietly: bool = False,
        waiting: Callable[[str], None] = lambda words: None,
    ) -> "Bus":
        """The same, as soon as there is a router to join, for a client of one.

        Args:
            node: what the command is on the bus.
            stop: ends the waiting.
            who: the name of the waiting command, for its notice.
            listens: whether it is the one body.
            lockstep: whether the same run shall give the same messages.
            quietly: whether nothing is said of the waiting.
            waiting: is told what is waited for, again and again.

        Raises:
            NoRouterError: there was none before it was asked to stop.
            BusError: a certificate is refused, which waiting does not mend.
        """
        from reflexarc_runtime.errors import NoRouterError

        said = False
        while True:
            try:
                return self.bus(node, listens=listens, lockstep=lockstep)
            except NoRouterError as error:
                if stop():
                    raise
                waiting(str(error))
                if not (said or quietly):
                    aside.print(f"{who}: {error}: waiting for it …", soft_wrap=True)
                said = True
            time.sleep(ASK_AGAIN_S)

    def fleet(self, robots: int) -> "list[Joining]":
        """The flags of several robots, numbered from this one on: robot0, robot1, and so on."""
        stem = self.robot.rstrip("0123456789")
        first = int(self.robot[len(stem) :] or 0)
        names = (
            [f"{stem}{first + number}" for number in range(robots)] if robots > 1 else [self.robot]
        )
        return [replace(self, robot=name) for name in names]


def contract_of(
    policy: Path | None,
    bus: "Bus",
    stop: Callable[[], bool],
    who: str,
    bounds: "Bounds | None",
) -> "PolicyContract | None":
    """The contract that a body follows: of a policy file, or of the runtime on the bus.

    Args:
        policy: the file; None: ask the runtime, and wait for an answer.
        bus: where to ask.
        stop: ends the waiting.
        who: the name of the waiting command, for its notice.
        bounds: what the contract may ask for at most, wherever it comes from; None: anything.

    Returns:
        The contract, or None when asked to stop before anyone answered.

    Raises:
        ContractError: the file's asks for more than the bounds allow, or cannot be read. Such an
            answer on the bus is said, and waited on for another.
    """
    if policy is not None:
        from reflexarc_runtime.policy.policy import load_contract

        return load_contract(policy, bounds=bounds)
    wanted = first_wanted(asking_of(bus, who, bounds), stop, who)
    return None if wanted is None else wanted.contract


def asking_of(
    bus: "Bus",
    who: str,
    bounds: "Bounds | None",
    check: "Callable[[PolicyContract], object]" = lambda contract: None,
) -> "Asking":
    """Asks for policies in the name of a command: see `Asking`."""
    from reflexarc.wiring.asking import Asking

    def say(words: str) -> None:
        aside.print(f"{who}: {words}", soft_wrap=True)

    return Asking(bus, bounds, say, check)


def first_wanted(asking: "Asking", stop: Callable[[], bool], who: str) -> "Wanted | None":
    """Wait for a runtime's contract; None when asked to stop before one answered."""
    from reflexarc.wiring.waiting import Waiting, Wish
    from reflexarc_runtime.messages.topics import policy_key

    aside.print(f"{who}: waiting for a runtime to say what it wants to see …")
    bus = asking.bus
    wish = Wish(who, "a runtime", policy_key(bus.robot), ("*/tick",))
    found: Wanted | None = None
    with Waiting(bus, wish, lambda: asking.has_heard):
        while not stop() and found is None:
            found = asking.anybody()
            if found is None:
                time.sleep(ASK_AGAIN_S)  # without a runtime the query returns at once
    return found


def waiting_for_commands(bus: "Bus", who: str, has_come: Callable[[], bool]) -> "Waiting":
    """Explains, inside this context, why a body hears no command."""
    from reflexarc.wiring.waiting import Waiting, Wish
    from reflexarc_runtime.messages.topics import COMMAND

    wish = Wish(who, "commands", COMMAND.key(bus.robot), ("*/command", "*/tick"))
    return Waiting(bus, wish, has_come)
