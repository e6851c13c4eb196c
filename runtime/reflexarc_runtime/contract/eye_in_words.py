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
MOST_CHARACTERS = 512
"""More are no eye: reading them would take a loop's time."""
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
    """How the eye that a text names differs from one: each field with what it should be.

    Each field stands in it once, and no other: a newer body may mean something by one more.
    """
    if len(words) > MOST_CHARACTERS:
        return [f"more than {MOST_CHARACTERS} characters to name it"]
    parts = [part.partition("=") for part in words.split()[1:]]
    if sorted(name for name, _, _ in parts) != sorted(_FIELDS):
        return [f"fields {', '.join(repr(name[:20]) for name, _, _ in parts)[:200]}"]
    got = {name: value for name, _, value in parts}
    return [
        f"{name} {_shown(got[name])} instead of {_text(getattr(spec, name))}"
        for name in _FIELDS
        if not _same(got[name], getattr(spec, name))
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


def _shown(text: str) -> str:
    """A sender's text, short and without control characters."""
    return text[:20] if text.isprintable() else repr(text[:20])


def _text(value: object) -> str:
    return f"{value:.9g}" if isinstance(value, float) else str(value)
