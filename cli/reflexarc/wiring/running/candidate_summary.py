"""What became of the policies beside the one that a run began with, at the end of the run."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from reflexarc_runtime.loop.candidates.shadow import ShadowAccount
    from reflexarc_runtime.loop.candidates.swap_desk import ServedSince

SHOWN = 12
"""Characters of a hash that people are shown."""


def candidates_as_dict(
    shadow: "ShadowAccount | None", served: "Sequence[ServedSince]"
) -> dict[str, object]:
    """All of it, for `--json`."""
    return {
        "shadow": None if shadow is None else asdict(shadow),
        "swaps": [{"policy_hash": one.policy_hash, "tick": one.tick} for one in served],
    }


def candidates_in_words(
    shadow: "ShadowAccount | None", served: "Sequence[ServedSince]"
) -> dict[str, object]:
    """What the table at the end says; nothing of what there was not."""
    said: dict[str, object] = {}
    if served:
        last = [f"{one.policy_hash[:SHOWN]} since tick {one.tick}" for one in served[-3:]]
        said["swaps"] = f"{len(served)}, the last: {'; '.join(last)}"
    if shadow is not None:
        said["shadow"] = shadow.words
    return said
