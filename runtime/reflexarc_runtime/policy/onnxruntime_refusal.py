"""What onnxruntime means when it refuses: its messages begin with a place in its own source.

[ONNXRuntimeError] : 1 : FAIL : /onnxruntime_src/…/model.cc:256 onnxruntime::Model::Model(…)
Unsupported model IR version: 14, max supported IR version: 13
"""

import re

from reflexarc_runtime.errors import first_line

_HEAD = re.compile(r"\[ONNXRuntimeError\] : \d+ : \w+ : ")
_PLACE = re.compile(r"/onnxruntime_src/\S+:\d+ ")


def refusal(error: Exception) -> str:
    """The reason in an error of onnxruntime, at most one line of 200 characters."""
    text = _HEAD.sub("", str(error).strip(), count=1)
    place = _PLACE.search(text)
    if place:
        before, signature = text[: place.start()], text[place.end() :]
        text = before + _behind_parentheses(signature)
    line = first_line(ValueError(text)) if text else first_line(error)
    return "".join(character if character.isprintable() else "?" for character in line)


def _behind_parentheses(signature: str) -> str:
    """What follows the arguments of a C++ function; all of it, if it is none."""
    depth = 0
    for place, character in enumerate(signature):
        depth += (character == "(") - (character == ")")
        if character == ")" and depth <= 0:
            rest = signature[place + 1 :]
            if rest.startswith("("):  # operator()(…)
                return _behind_parentheses(rest)
            return re.sub(r"^( const| noexcept| \[with [^\]]*\]|\s)+", "", rest)
    return signature
