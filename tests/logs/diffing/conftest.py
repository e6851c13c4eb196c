"""Logs of JSON messages."""

from collections.abc import Callable
from pathlib import Path

import pytest

from support.foreign_logs import json_log


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """Writes a log of JSON messages: a name, and rows by topic."""
    return lambda name, **topics: json_log(tmp_path / f"{name}.mcap", **topics)
