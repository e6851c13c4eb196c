"""The rights of the roles, against a list by hand."""

from reflexarc_runtime.messages import access
from reflexarc_runtime.messages.topics import KEYFRAME, REJECTED, TOPICS

BY_HAND = {
    "body": "retina scan status pose tf odometry image scene log contact body lease",
    "runtime": "command tick status log stop release overrun",
    "operator": "stop reset arm hold_to_run release mark",
    "recorder": "",
    "viewer": "",
}


def test_a_role_says_at_least_what_it_says_today_and_shares_nothing_that_moves_a_robot():
    for role, names in BY_HAND.items():
        assert set(names.split()) <= {topic.name for topic in access.said_by(role)}
    for name, roles in {
        "command": {"runtime"},
        "retina": {"body"},
        "scan": {"body"},
        "lease": {"body"},
        "arm": {"operator"},
        "reset": {"operator"},
        "hold_to_run": {"operator"},
    }.items():
        assert {r for r in access.ROLES if name in [t.name for t in access.said_by(r)]} == roles


def test_whoever_only_listens_says_nothing():
    assert access.said_by("viewer") == access.said_by("recorder") == ()


def test_every_publisher_of_the_table_is_a_role():
    assert {who for topic in TOPICS for who in topic.publishers} <= set(access.ROLES)


def test_what_is_in_logs_alone_is_carried_by_no_bus():
    assert set(TOPICS) - set(access.CARRIED) == {KEYFRAME, REJECTED}


def test_keys_are_of_one_robot_alone():
    keys = [
        *access.heard_keys("r1"),
        *access.said_keys("body", "r1"),
        access.token_key("body", "r1"),
    ]
    assert all(key.startswith("r1/") and "*" not in key for key in keys)
    assert access.answered_keys("runtime", "r1") == ["r1/policy", "r1/swap_request"]
    assert [r for r in access.ROLES if access.answered_keys(r, "r1")] == ["runtime"]
    assert access.asked_keys("operator", "r1") == ["r1/swap_request"]
    assert [r for r in access.ROLES if access.asked_keys(r, "r1")] == ["operator"]


def test_names_of_certificates_differ_for_every_role_and_robot():
    robots = ("a", "a.body", "body")
    names = [access.common_name(role, robot) for role in access.ROLES for robot in robots]
    assert len(set(names)) == len(names)
