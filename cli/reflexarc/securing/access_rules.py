"""Zenoh's access control for the door of one robot: default deny, and the topic table as rights.

Zenoh checks each message that comes in from a subject (ingress) and each that goes out to it
(egress) by the common name of its certificate. What goes out to a publisher is who subscribes, or
it would send nothing. Source: Zenoh's DEFAULT_CONFIG.json5, `access_control`.
"""

from collections.abc import Sequence
from typing import Any

from reflexarc_runtime.messages.access import (
    answered_keys,
    asked_keys,
    common_name,
    heard_keys,
    said_keys,
    token_key,
)
from reflexarc_runtime.messages.topics import alive_key, policy_key

_ANY_TOPIC = "*/*"
"""What a command listens to that explains a silence. It hears of it what it may hear, no more."""
_ANY_TOKEN = "*/alive/*"

Rule = dict[str, Any]


def access_control(robot: str, roles: Sequence[str]) -> dict[str, Any]:
    """The settings below `access_control` of the door that these roles come to."""
    shared = _hearing(robot)
    own = {role: _saying(role, robot) for role in roles}
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": [*shared, *(rule for rules in own.values() for rule in rules)],
        "subjects": [
            {"id": role, "cert_common_names": [common_name(role, robot)], "link_protocols": ["tls"]}
            for role in roles
        ],
        "policies": [
            {"rules": [rule["id"] for rule in (*shared, *own[role])], "subjects": [role]}
            for role in roles
        ],
    }


def _hearing(robot: str) -> list[Rule]:
    """What every role may do: hear its robot, look who is there, ask for the policy."""
    tokens, policy = [alive_key(robot, "*")], [policy_key(robot)]
    return [
        _rule("subscribe", ["declare_subscriber"], "ingress", [_ANY_TOPIC]),
        _rule("hear", ["put"], "egress", heard_keys(robot)),
        _rule(
            "look", ["liveliness_query", "declare_liveliness_subscriber"], "ingress", [_ANY_TOKEN]
        ),
        _rule("see", ["liveliness_token"], "egress", tokens),
        _rule("ask", ["query"], "ingress", policy),
        _rule("learn", ["reply", "declare_queryable"], "egress", policy),
    ]


def _saying(role: str, robot: str) -> list[Rule]:
    """What one role alone may do."""
    rules = []
    said, answered = said_keys(role, robot), answered_keys(role, robot)
    if said:
        rules += [
            _rule(f"{role} says", ["put"], "ingress", said),
            _rule(f"{role} is heard", ["declare_subscriber"], "egress", [_ANY_TOPIC]),
        ]
    rules.append(_rule(f"{role} lives", ["liveliness_token"], "ingress", [token_key(role, robot)]))
    if answered:
        rules += [
            _rule(f"{role} answers", ["reply", "declare_queryable"], "ingress", answered),
            _rule(f"{role} is asked", ["query"], "egress", answered),
        ]
    asked = asked_keys(role, robot)
    if asked:
        rules += [
            _rule(f"{role} asks", ["query"], "ingress", asked),
            _rule(f"{role} learns", ["reply", "declare_queryable"], "egress", asked),
        ]
    return rules


def _rule(name: str, messages: list[str], flow: str, keys: list[str]) -> Rule:
    return {
        "id": name,
        "messages": messages,
        "flows": [flow],
        "permission": "allow",
        "key_exprs": keys,
    }
