"""A role's file with new certificates and keys, and all else as it stands.

What somebody added by hand stays: rights, comments, whatever JSON5 allows. So the text is changed,
not written anew.
"""

import re
from typing import Any

from reflexarc_runtime.doors.credentials import parse_zenoh_file

_FIELD = re.compile(r"(connect|listen)_(certificate|private_key)_base64")
_VALUE = r"""(["']?\b{name}["']?\s*:\s*)(["'])[A-Za-z0-9+/=]*\2"""


def renewed(text: str, fresh: str) -> str:
    """The text of a file with the certificates and keys of another one of the same role.

    Args:
        text: the file as it stands.
        fresh: as `secure init` would write it now.

    Raises:
        ValueError: it does not hold each of them once, so they cannot be told apart.
    """
    tls: Any = parse_zenoh_file(fresh)["transport"]["link"]["tls"]
    for name in filter(_FIELD.fullmatch, tls):
        pattern = re.compile(_VALUE.format(name=name))
        found = len(pattern.findall(text))
        if found != 1:
            raise ValueError(f"expected {name} once, found it {found} times")
        text = pattern.sub(rf"\g<1>\g<2>{tls[name]}\g<2>", text)  # base64 has no backslash
    return text
