"""Why a body does not do what it was told, in words."""

from enum import StrEnum


class Refusal(StrEnum):
    """Why a message was not obeyed as it came, in the words of `<robot>/lease`."""

    ENCODING = "another encoding, or too long"
    UNSIGNED = "no attachment that names a sender"
    UNREADABLE = "unreadable, or speeds that are not finite"
    OTHER_BODY = "meant for another body"
    FUTURE = "of a time to come"
    OLD = "no longer valid"
    OTHER_SENDER = "another one holds the lease"
    RELEASED = "it has just given the lease back"
    STOPPED = "the body is stopped"
    DISARMED = "the body is not armed"
    TOO_FAST = "too fast: slowed down"
    OTHER_HOLDER = "another one holds the button"
    PRESSED_BEFORE = "the button must be pressed anew"
    NEEDS_BUTTON = "only a held button arms this body"
