"""The policies that a log must hold that begins at some place of a run: whom its keyframe names.

Whoever takes over later comes with a swap, which holds its file. Whoever took over before is known
to the keyframe by its hash alone; its swap has passed.
"""

from collections.abc import Mapping

from reflexarc_logs.container.rejected import LogEntry
from reflexarc_runtime.messages_pb2 import Keyframe, Swap
from reflexarc_runtime.policy.model_file import policy_hash


class ServedFiles:
    """What has passed of them, of one loop's own messages; others may claim anything."""

    def __init__(self) -> None:
        self._files: dict[str, bytes] = {}

    @property
    def files(self) -> Mapping[str, bytes]:
        """By their hashes; behind a keyframe, those that it names beside the first one."""
        return self._files

    def pass_by(self, entry: LogEntry) -> None:
        """The place is behind this entry now."""
        if entry.kind is Swap:
            policy = Swap.FromString(entry.payload).policy
            self._files[policy_hash(policy)] = policy
        elif entry.kind is Keyframe and self._files:
            serving = Keyframe.FromString(entry.payload).serving
            named = serving.policy_hash, serving.former, serving.pending
            self._files = {name: self._files[name] for name in named if name in self._files}
