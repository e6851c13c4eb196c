"""Who may do what on the bus of one robot, role by role: the topic table, read as rights.

A certificate names a role and a robot. A role may say the topics whose publisher the table calls
it, announce itself, and hear everything of its robot; the runtime alone answers for the policy, and
the operator alone asks for another one.
"""

from reflexarc_runtime.messages.topics import (
    BODY_NODE,
    OPERATOR,
    RECORDER_NODE,
    RECORDERS_OWN,
    RUNTIME_NODE,
    TOPICS,
    Topic,
    alive_key,
    policy_key,
    swap_key,
)

VIEWER = "viewer"
ROUTER = "router"
"""Passes on what the others say, where it is not the body that does; says nothing itself."""
ROLES = (BODY_NODE, RUNTIME_NODE, RECORDER_NODE, OPERATOR, VIEWER)

CARRIED = tuple(topic for topic in TOPICS if topic not in RECORDERS_OWN)
"""The topics that are ever on a bus."""


def said_by(role: str) -> tuple[Topic, ...]:
    """The topics that a role may publish."""
    return tuple(topic for topic in CARRIED if role in topic.publishers)


def said_keys(role: str, robot: str) -> list[str]:
    """Keys that a role may publish on."""
    return [topic.key(robot) for topic in said_by(role)]


def heard_keys(robot: str) -> list[str]:
    """Keys that every role may hear."""
    return [topic.key(robot) for topic in CARRIED]


def answered_keys(role: str, robot: str) -> list[str]:
    """Keys of the queryables that a role may declare."""
    return [policy_key(robot), swap_key(robot)] if role == RUNTIME_NODE else []


def asked_keys(role: str, robot: str) -> list[str]:
    """Keys of the queryables that a role may ask, beside the policy, which all may see."""
    return [swap_key(robot)] if role == OPERATOR else []


def token_key(role: str, robot: str) -> str:
    """Key of the one liveliness token that a role may declare."""
    return alive_key(robot, role)


def common_name(role: str, robot: str) -> str:
    """What a certificate calls its bearer. No role has a dot, so it reads back in one way."""
    return f"{role}.{robot}"
