"""Whether everybody at a door is seen to live as itself, and as nobody else."""

import time

from reflexarc.securing.door_row import DoorRow, judged
from reflexarc.securing.gathering import NOBODY, SETTLES_S, Gathering
from reflexarc.securing.speaking import named
from reflexarc_runtime.messages.topics import BODY_NODE, alive_key

_DOOR = "door"
_EVERYBODY = "*/alive/*"


def living_row(all_here: Gathering) -> DoorRow:
    """Each announces all others, which nobody shall see; then itself, which all roles shall."""
    false = _seen_of_impostors(all_here)
    honest = _seen_of_themselves(all_here)
    opened = [f"others pass for {named(false)}"] if false else []
    all_here.host.announce(_DOOR)
    time.sleep(SETTLES_S)
    seeing = {role for role, bus in all_here.guests.items() if bus.is_alive(_DOOR)}
    opened += [f"{NOBODY} sees who lives"] * (NOBODY in seeing)
    lacking = [f"{role} is not seen to live" for role in all_here.roles if role not in honest]
    lacking += [f"{role} does not see who lives" for role in all_here.roles if role not in seeing]
    return judged("who lives", opened, lacking, "each role is seen as itself, and passes for none")


def _seen_of_impostors(all_here: Gathering) -> set[str]:
    """Of a role that is not here, too: the body's, where it is the body that keeps the door."""
    nodes = {*all_here.guests, BODY_NODE}
    false = [
        bus.announce(node)
        for role, bus in all_here.guests.items()
        for node in nodes
        if node != role or role == NOBODY
    ]
    time.sleep(SETTLES_S)
    seen = _seen(all_here) & {alive_key(all_here.robot, node): node for node in nodes}.keys()
    for each in false:
        each.withdraw()
    time.sleep(SETTLES_S)
    return {key.rpartition("/")[2] for key in seen}


def _seen_of_themselves(all_here: Gathering) -> set[str]:
    for role in all_here.roles:
        all_here.guests[role].announce(role)
    time.sleep(SETTLES_S)
    return {key.rpartition("/")[2] for key in _seen(all_here)}


def _seen(all_here: Gathering) -> set[str]:
    return set(all_here.host.tokens(_EVERYBODY))
