"""The lines with which the guide makes a foreign body's messages are what the runtime reads."""

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec
from reflexarc_runtime.messages.wire import Message, protobuf_encoding
from reflexarc_runtime.sensing.senses import RetinaSense

PAGE = (Path(__file__).parents[2] / "docs" / "senses.md").read_text()
EYE = RetinaSpec(beams=BeamRule.SECTOR_MINIMUM)
VALUES, BODY = bytes(range(0, 240, 15)), b"a body of sixtee"

MAIN = """
#include <stdint.h>
#include <stdio.h>
#include <string.h>
{functions}
int main(void) {{
    unsigned char out[1024], stamp[33], values[16];
    for (int i = 0; i < 16; i++) values[i] = 15 * i;
    size_t size = retina(out, "{eye}", values, 16);
    attachment(stamp, 7, 123456789, "a body of sixtee");
    fwrite(stamp, 1, sizeof stamp, stdout);
    fwrite(out, 1, size, stdout);
    return 0;
}}
"""


def code(language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    assert found is not None
    return found[1]


def check(payload: bytes, attachment: bytes) -> None:
    encoding = protobuf_encoding("foxglove.RawImage")
    sensed = RetinaSense(EYE).decode(Message("robot0/retina", payload, encoding, attachment, 5))
    assert np.array_equal(sensed.retina.ravel(), list(VALUES))
    assert (sensed.stamp.sequence, sensed.stamp.sender) == (7, BODY)


def test_the_lines_of_python_make_what_the_runtime_reads() -> None:
    names: dict[str, Any] = {}
    exec(code("python"), names)
    check(names["retina"](VALUES), names["attachment"](7, BODY))


def test_the_lines_of_c_make_what_the_runtime_reads(tmp_path: Path) -> None:
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler (cc)")
    names: dict[str, Any] = {}
    exec(code("python"), names)
    source, program = tmp_path / "body.c", tmp_path / "body"
    source.write_text(MAIN.format(functions=code("c"), eye=names["EYE"]))
    words = [compiler, "-Wall", "-Werror", "-o", str(program), str(source)]
    subprocess.run(words, check=True)
    said = subprocess.run([str(program)], check=True, capture_output=True).stdout
    check(said[33:], said[:33])
