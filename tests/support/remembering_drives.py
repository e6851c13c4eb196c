"""Drives of a policy with a memory."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.wire import Message
from support.recordings import MS, drive, retina_at, smooth_retinas
from support.remembering import REMEMBERING, remembering_policy


def drive_remembering(path: Path, seed: int, ticks: int = 200) -> Path:
    """The same retinas for every seed; what is remembered and decided is the policy's."""
    retinas = smooth_retinas(ticks, spec=REMEMBERING.retina)
    schedule = {slot: [_seen(slot, retinas[slot - 1])] for slot in range(1, ticks + 1)}
    drive(path, remembering_policy(seed), schedule, ticks)
    return path


def _seen(slot: int, retina: np.ndarray) -> Message:
    sent = retina_at(slot, np.zeros((1, 16, 1), np.uint8))
    payload = encode_retina(retina, REMEMBERING.retina, sent.received_ns - MS)
    return replace(sent, payload=payload)
