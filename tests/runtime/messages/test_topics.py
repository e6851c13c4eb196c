"""The table of topics, and the lists that follow from it."""

from reflexarc_runtime.messages.topics import BODY_TOPICS, OVERHEARD, SENSORS, TOPICS, topic_of


def test_a_log_plays_what_only_a_body_says() -> None:
    names = {topic.name for topic in BODY_TOPICS}
    assert names == {"retina", "scan", "pose", "tf", "odometry", "scene", "contact", "body"}


def test_the_loop_records_what_others_say_beside_its_own_input_and_output() -> None:
    names = {topic.name for topic in OVERHEARD}
    assert names == {"pose", "tf", "odometry", "scene", "contact", "status", "log", "body"} | {
        "lease",
        "arm",
        "hold_to_run",
        "release",
        "mark",
    }


def test_every_recorded_stream_reaches_the_log_of_a_loop_in_exactly_one_way() -> None:
    own = {"command", "tick", "rejected", "keyframe", "stop", "reset", "overrun", *SENSORS}
    overheard = {topic.name for topic in OVERHEARD}
    assert own.isdisjoint(overheard)
    assert own | overheard == {topic.name for topic in TOPICS if topic.recorded}


def test_a_key_names_its_topic_and_a_topic_its_message() -> None:
    for topic in TOPICS:
        assert topic_of(topic.key("robot7")) is topic
        package, _, name = topic.schema.partition(".")
        assert (package in ("foxglove", "reflexarc"), name) == (True, topic.message.__name__)
