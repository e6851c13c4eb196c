"""A flag of a scanner that cannot be meant is refused by its own name, in the user's own units."""

import pytest

from reflexarc.commands.drive.run import RunCommand
from reflexarc.wiring.scan_flags import ScanFlags
from reflexarc.wiring.sense_flags import SenseFlags
from reflexarc_runtime.errors import UsageError

NAN = float("nan")


@pytest.mark.parametrize("edges", [(90.0, 10.0), (NAN, 10.0), (0.0, 361.0)])
def test_a_sector_that_is_none_is_refused_in_degrees(edges: tuple[float, float]):
    with pytest.raises(UsageError, match=f"--ignore-sector.*got {edges[0]:g} {edges[1]:g}"):
        _ = ScanFlags(ignore_sector=(edges,)).ignored


def test_a_place_that_is_none_is_refused_by_its_flag():
    with pytest.raises(UsageError, match="--mount: expected finite numbers, got nan 0 0"):
        _ = ScanFlags(mount=(NAN, 0.0, 0.0)).known_mount


def test_flags_of_a_scanner_beside_retinas_are_not_silently_ignored(tmp_path):
    sensing = SenseFlags(scanner=ScanFlags(upside_down=True))
    with pytest.raises(UsageError, match="--input scan"):
        RunCommand(tmp_path / "none.onnx", sensing=sensing).run()
