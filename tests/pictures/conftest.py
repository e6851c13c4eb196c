from pathlib import Path

import pytest

from support.round_room import turning_log


@pytest.fixture
def turning(tmp_path: Path) -> Path:
    """A log of a robot that turns in a round room."""
    return turning_log(tmp_path / "turning.mcap")
