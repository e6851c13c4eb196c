"""The layout that is shipped names only what our logs have; a viewer would show an empty panel."""

import importlib.util
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from google.protobuf.descriptor import Descriptor

from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.messages.topics import DEFAULT_ROBOT, TOPICS

ROOT = Path(__file__).parents[3]
LAYOUT = ROOT / "logs" / "foxglove-layout.json"
MESSAGES = {f"/{topic.key(DEFAULT_ROBOT)}": topic.message.DESCRIPTOR for topic in TOPICS}
SHOWN = ("retina", "scan", "pose", "scene", "tick", "command", "log")


def words(value: Any) -> Iterator[str]:
    """Every text of a document, names included."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for name, inner in value.items():
            yield from words(name)
            yield from words(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from words(inner)


def paths() -> list[str]:
    return [word for word in words(json.loads(LAYOUT.read_text())) if word.startswith("/")]


def test_every_topic_and_every_field_exists():
    assert paths()
    for path in paths():
        topic, *fields = re.sub(r"\[\d+\]", "", path).split(".")
        assert topic in MESSAGES, f"{path}: no such topic"
        message: Descriptor | None = MESSAGES[topic]
        for field in fields:
            assert message is not None, f"{path}: {field} is inside of no message"
            assert field in message.fields_by_name, f"{path}: no field {field}"
            message = message.fields_by_name[field].message_type


def test_what_matters_is_in_view():
    shown = {path.split(".")[0].rpartition("/")[2] for path in paths()}
    assert set(SHOWN) <= shown


def test_every_verdict_has_its_name():
    states = {state["value"]: state["label"] for state in _states(json.loads(LAYOUT.read_text()))}
    assert states == {str(int(verdict)): verdict.name for verdict in Verdict}


def _states(value: Any) -> Iterator[dict[str, str]]:
    if isinstance(value, dict):
        if value.get("type") == "discrete":
            yield from value["states"]
        for inner in value.values():
            yield from _states(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from _states(inner)


def test_foxglove_s_own_sdk_makes_the_file():
    pytest.importorskip("foxglove.layouts")
    script = ROOT / "docs" / "foxglove_layout.py"
    spec = importlib.util.spec_from_file_location("foxglove_layout", script)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.layout() == LAYOUT.read_text()
