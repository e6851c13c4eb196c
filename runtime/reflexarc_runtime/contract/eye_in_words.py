"""Which eye made a picture, in clear: a retina carries it, and the runtime compares.

    eye rays=16 fov_rad=3.14159265 range_m=5 shading=nearness eyes=1 baseline_m=0 channels=1 …

It stands in `frame_id` of `foxglove.RawImage`. How many retinas a policy sees at once (`frames`) is
not in it: that is the policy's affair.
"""

import math
from functools import lru_cache

from reflexarc_runtime.contract.eye import RetinaSpec

_WORD = "eye"
_FIELDS = (
    "rays",
    "fov_rad",
    "range_m",
    "shading",
    "eyes",
    "baseline_m",
    "channels",
    "samples",
    "beams",
)
_NEAR = 1e-6
"""What two numbers may differ by, relative to the larger of 1 and the expected one."""


@lru_cache(maxsize=16)
def eye_in_words(spec: RetinaSpec) -> str:
    """The eye as text: numbers with nine digits, in the order of the fields."""
    return " ".join([_WORD, *(f"{name}={_text(getattr(spec, name))}" for name in _FIELDS)])


def is_an_eye(words: str) -> bool:
    """Whether a text means to say which eye made a picture."""
    return words.startswith(f"{_WORD} ")


def differences(words: str, spec: RetinaSpec) -> list[str]:
    """How the eye that a text names differs from one: each field with what it should be."""
    got = dict(part.partition("=")[::2] for part in words.split()[1:])
    return [
        f"{name} {got.get(name, 'missing')[:20]} instead of {_text(getattr(spec, name))}"
        for name in _FIELDS
        if not _same(got.get(name, ""), getattr(spec, name))
    ]


def _same(text: str, expected: object) -> bool:
    if isinstance(expected, str):
        return text == str(expected)
    try:
        number = float(text)
    except ValueError:
        return False
    wanted = float(expected)  # type: ignore[arg-type]  # every other field is a number
    return math.isfinite(number) and abs(number - wanted) <= _NEAR * max(1.0, abs(wanted))


def _text(value: object) -> str:
    return f"{value:.9g}" if isinstance(value, float) else str(value)
