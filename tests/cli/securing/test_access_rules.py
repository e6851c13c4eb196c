"""Zenoh's rules, read by a plain judge of key expressions, against rights by hand."""

import re
from typing import Any

import pytest

pytest.importorskip("cryptography")

from reflexarc.securing.access_rules import access_control
from reflexarc_runtime.messages.access import ROLES
from reflexarc_runtime.messages.topics import TOPICS

GUESTS = tuple(role for role in ROLES if role != "body")
CONTROL = access_control("robot0", GUESTS)


def includes(expression: str, key: str) -> bool:
    """Whether a key expression without `**` includes another one."""
    pattern = "/".join(
        "[^/]+" if part == "*" else re.escape(part) for part in expression.split("/")
    )
    return re.fullmatch(pattern, key) is not None


def may(role: str, flow: str, message: str, key: str, control: Any = CONTROL) -> bool:
    """Whether default deny and the rules let a message through, as Zenoh documents them."""
    names = {
        subject["id"]
        for subject in control["subjects"]
        if f"{role}.robot0" in subject["cert_common_names"]
    }
    granted = {r for p in control["policies"] if names & {*p["subjects"]} for r in p["rules"]}
    return any(
        rule["id"] in granted
        and flow in rule["flows"]
        and message in rule["messages"]
        and any(includes(expression, key) for expression in rule["key_exprs"])
        for rule in control["rules"]
    )


def test_it_denies_by_default_and_every_rule_allows():
    assert (CONTROL["enabled"], CONTROL["default_permission"]) == (True, "deny")
    assert {rule["permission"] for rule in CONTROL["rules"]} == {"allow"}
    names = [rule["id"] for rule in CONTROL["rules"]]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.name)
@pytest.mark.parametrize("role", GUESTS)
def test_a_guest_puts_what_the_topic_table_says_and_nothing_else(role: str, topic: Any):
    assert may(role, "ingress", "put", f"robot0/{topic.name}") == (role in topic.publishers) or (
        topic.name in ("keyframe", "rejected") and role == "recorder"
    )
    assert not may(role, "ingress", "put", f"robot1/{topic.name}")
    assert not may(role, "ingress", "delete", f"robot0/{topic.name}")


def test_by_hand_who_moves_the_robot():
    assert may("runtime", "ingress", "put", "robot0/command")
    assert may("operator", "ingress", "put", "robot0/reset")
    for role in ("operator", "recorder", "viewer", "body", "nobody"):
        assert not may(role, "ingress", "put", "robot0/command")
    assert not may("runtime", "ingress", "put", "robot0/arm")


def test_all_hear_their_robot_and_no_other_one():
    for role in GUESTS:
        assert may(role, "egress", "put", "robot0/retina")
        assert may(role, "ingress", "declare_subscriber", "robot0/retina")
        assert may(role, "ingress", "declare_subscriber", "*/*")
        assert not may(role, "egress", "put", "robot1/retina")
        assert not may(role, "ingress", "declare_subscriber", "**")
    assert not may("nobody", "egress", "put", "robot0/retina")


def test_only_the_runtime_answers_for_the_policy_and_each_lives_as_itself():
    for role in GUESTS:
        is_runtime = role == "runtime"
        assert may(role, "ingress", "declare_queryable", "robot0/policy") == is_runtime
        assert may(role, "ingress", "reply", "robot0/policy") == is_runtime
        assert may(role, "ingress", "query", "robot0/policy")
        for other in ROLES:
            key = f"robot0/alive/{other}"
            assert may(role, "ingress", "liveliness_token", key) == (role == other)
    assert not may("viewer", "ingress", "query", "@/**")


def test_where_a_router_keeps_the_door_the_body_is_a_guest():
    control = access_control("robot0", ROLES)
    assert may("body", "ingress", "put", "robot0/retina", control)
    assert not may("body", "ingress", "put", "robot0/command", control)
