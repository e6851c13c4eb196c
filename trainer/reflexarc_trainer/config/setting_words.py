"""Settings as they are written in a command line: `learner.gamma=0.8`.

The value is one of TOML: 0.3, true, [64, 64], "text". What is no such value is a text as it stands,
so that `learner.form=online` needs no quotation marks.
"""

import tomllib
from collections.abc import Iterable

from reflexarc_runtime.errors import UsageError

_KEY = "value"


def parse_settings(words: Iterable[str]) -> dict[str, object]:
    """Values by dotted name.

    Args:
        words: each NAME=VALUE.

    Raises:
        UsageError: something else, or a field twice.
    """
    settings: dict[str, object] = {}
    for word in words:
        name, equals, value = (part.strip() for part in word.partition("="))
        if not (name and equals):
            raise UsageError(f"expected FIELD=VALUE, as learner.gamma=0.8, got {word!r}")
        if name in settings:
            raise UsageError(f"{name}: set twice; leave one of them out")
        settings[name] = _parsed(value)
    return settings


def _parsed(text: str) -> object:
    try:
        document = tomllib.loads(f"{_KEY} = {text}")
    except tomllib.TOMLDecodeError:
        return text
    except (ValueError, RecursionError):  # a number of more digits than Python reads; depth
        return text
    return document[_KEY] if set(document) == {_KEY} else text
