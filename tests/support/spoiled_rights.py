"""The rules of a door, as `access_control` has them, with one too many or too few."""

from typing import Any

Rights = dict[str, Any]


def granted(role: str, rule: str, rights: Rights) -> None:
    """One role has a rule more."""
    [policy] = [each for each in rights["policies"] if each["subjects"] == [role]]
    policy["rules"].append(rule)


def revoked(rule: str, rights: Rights) -> None:
    """Nobody has a rule."""
    rights["rules"] = [each for each in rights["rules"] if each["id"] != rule]
    for policy in rights["policies"]:
        policy["rules"] = [each for each in policy["rules"] if each != rule]


def widened(rule: str, key: str, rights: Rights) -> None:
    """A rule has a key more."""
    [found] = [each for each in rights["rules"] if each["id"] == rule]
    found["key_exprs"].append(key)


def narrowed(rule: str, key: str, rights: Rights) -> None:
    """A rule has a key less."""
    [found] = [each for each in rights["rules"] if each["id"] == rule]
    found["key_exprs"].remove(key)


def named(rules: list[str], rights: Rights) -> None:
    """A certificate of no role has rules."""
    subject = {"id": "nobody", "cert_common_names": ["nobody.robot0"], "link_protocols": ["tls"]}
    rights["subjects"].append(subject)
    rights["policies"].append({"rules": rules, "subjects": ["nobody"]})
