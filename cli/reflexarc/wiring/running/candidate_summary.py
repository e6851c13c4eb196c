"""What became of the policies beside the one that a run began with, at the end of the run."""

from dataclasses import asdict
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from reflexarc_runtime.loop.candidates.shadow import ShadowAccount
    from reflexarc_runtime.loop.candidates.take_overs import TakeOvers

SHOWN = 12
"""Characters of a hash that people are shown."""


def candidates_as_dict(shadow: "ShadowAccount | None", served: "TakeOvers") -> dict[str, object]:
    """All of it, for `--json`; of the swaps the last 100, and how many there were."""
    return {
        "shadow": None if shadow is None else asdict(shadow),
        "swaps_in_all": served.count,
        "swaps": [{"policy_hash": one.policy_hash, "tick": one.tick} for one in served.last],
    }


def candidates_in_words(shadow: "ShadowAccount | None", served: "TakeOvers") -> dict[str, object]:
    """What the table at the end says; nothing of what there was not."""
    said: dict[str, object] = {}
    if served.count:
        last = [f"{one.policy_hash[:SHOWN]} since tick {one.tick}" for one in served.last[-3:]]
        said["swaps"] = f"{served.count}, the last: {'; '.join(last)}"
    if shadow is not None:
        said["shadow"] = shadow.words
    return said
