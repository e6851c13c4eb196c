"""Each fault of a folder is a row that is not shut."""

import json
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

pytest.importorskip("cryptography")

from reflexarc.securing.door_row import DoorState
from reflexarc.securing.door_trial import try_doors
from reflexarc.securing.folder_doors import folder_rows
from reflexarc.securing.secured_robot import SecuredRobot
from reflexarc.securing.security_folder import SecurityFolder, make_folder
from reflexarc.securing.variants import settings_of
from reflexarc_runtime.errors import UsageError

ROBOT = SecuredRobot("robot0", (), 7447, "body", 100.0)


def bad(folder: SecurityFolder, in_days: float = 0.0) -> list[str]:
    when = datetime.now(UTC) + timedelta(days=in_days)
    return [f"{row.door}: {row.words}" for row in folder_rows(folder, when) if row.is_bad]


@pytest.fixture
def folder(tmp_path: Path) -> SecurityFolder:
    return make_folder(tmp_path / "keys", ROBOT)


def changed(folder: SecurityFolder, role: str, change: Callable[[dict], object]) -> None:  # type: ignore[type-arg]  # JSON
    lines = folder.file(role).read_text().splitlines()
    settings = json.loads("\n".join(line for line in lines if not line.startswith("//")))
    change(settings)
    folder.file(role).write_text(json.dumps(settings))


def test_what_init_makes_is_shut(folder: SecurityFolder):
    assert bad(folder) == []
    assert {row.state for row in folder_rows(folder)} == {DoorState.SHUT}


def test_certificates_expire_and_are_not_valid_before(folder: SecurityFolder):
    assert len([words for words in bad(folder, 101.0) if "has expired" in words]) == 5
    assert len([words for words in bad(folder, -1.0) if "only from" in words]) == 5
    soon = list(folder_rows(folder, datetime.now(UTC) + timedelta(days=90)))
    assert len([row for row in soon if "which is soon" in row.words]) == 5


def test_a_key_that_others_read(folder: SecurityFolder):
    folder.file("operator").chmod(0o604)
    assert "operator.json5 can be read by others" in bad(folder)[0]


def test_a_file_of_another_authority_and_one_of_another_role(
    folder: SecurityFolder, tmp_path: Path
):
    other = make_folder(tmp_path / "other", ROBOT)
    folder.file("viewer").write_text(other.file("viewer").read_text())
    folder.file("recorder").write_text(folder.file("operator").read_text())
    assert [words.partition(":")[0] for words in bad(folder)] == [
        "certificate of recorder",
        "certificate of viewer",
    ]


@pytest.mark.parametrize(
    ("path", "value", "door"),
    [
        (("listen", "endpoints"), ["tcp/0.0.0.0:7447"], "listeners, multicast"),
        (("scouting", "multicast", "enabled"), True, "listeners, multicast"),
        (("access_control", "default_permission"), "allow", "access control"),
        (("access_control", "enabled"), False, "access control"),
        (("transport", "link", "tls", "verify_name_on_connect"), False, "access control"),
        (("transport", "link", "protocols"), "none", "listeners, multicast"),
    ],
)
def test_a_setting_that_opens_a_door(
    path: tuple[str, ...], value: object, door: str, folder: SecurityFolder
):
    def change(settings: dict) -> None:  # type: ignore[type-arg]  # JSON
        for part in path[:-1]:
            settings = settings[part]
        settings[path[-1]] = value

    changed(folder, "body", change)
    assert [words.partition(":")[0] for words in bad(folder)] == [door]


SHAPES: dict[str, Callable[[str], str]] = {
    "a comment within a line": lambda text: text.replace('"mode"', '/* by hand */ "mode"'),
    "a comma at the end": lambda text: text.rstrip()[:-1] + ",}",
    "half of it": lambda text: text[: len(text) // 2],
    "nothing": lambda text: "",
    "a list": lambda text: "[]",
    "no TLS": lambda text: '{"mode": "client"}',
    "a list within": lambda text: '{"transport": []}',
    "a number within": lambda text: '{"transport": {"link": {"tls": 1}}}',
}


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
@pytest.mark.parametrize("role", ["viewer", "body"])
def test_a_file_of_another_shape_is_told_by_name(
    shape: Callable[[str], str], role: str, folder: SecurityFolder
):
    """Zenoh itself takes some of them; what is varied here must be understood here."""
    file = folder.file(role)
    file.write_text(shape(file.read_text()))
    assert f"certificate of {role}" in [row.door for row in folder_rows(folder) if row.is_bad]
    with pytest.raises(UsageError, match=rf"{role}\.json5: expected JSON"):
        list(try_doors(folder))


def test_lines_of_comment_may_stand_anywhere(folder: SecurityFolder):
    file = folder.file("body")
    before = settings_of(folder, "body")
    file.write_text(file.read_text().replace('"mode"', '  // by hand\n "mode"'))
    assert settings_of(folder, "body") == before
    assert bad(folder) == []


def test_bytes_that_are_no_text_and_no_certificate_are_told(folder: SecurityFolder):
    folder.file("viewer").write_bytes(b"\xff\xfe")
    changed(folder, "runtime", lambda s: s["transport"]["link"]["tls"].clear())
    folder.file("operator").unlink()
    folder.file("operator").mkdir()
    assert {"certificate of viewer", "certificate of runtime", "certificate of operator"} <= {
        row.door for row in folder_rows(folder) if row.is_bad
    }
    for role in ("viewer", "operator"):
        with pytest.raises(UsageError, match=rf"{role}\.json5"):
            settings_of(folder, role)
