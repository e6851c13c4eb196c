"""The table of topics, and the lists that follow from it."""

from reflexarc_runtime.messages.topics import BODY_TOPICS, OVERHEARD, SENSORS, TOPICS, topic_of


def test_a_log_plays_what_only_a_body_says() -> None:
    beside = {"pose", "tf", "odometry", "image", "scene", "contact", "body"}
    assert {topic.name for topic in BODY_TOPICS} == {"retina", "scan"} | beside


def test_the_loop_records_what_others_say_beside_its_own_input_and_output() -> None:
    names = {topic.name for topic in OVERHEARD}
    of_body = {"pose", "tf", "odometry", "image", "scene", "contact", "status", "log", "body"}
    assert names == of_body | {"lease", "arm", "hold_to_run", "release", "mark"}


def test_every_recorded_stream_reaches_the_log_of_a_loop_in_exactly_one_way() -> None:
    own = {"command", "tick", "rejected", "keyframe", "stop", "reset", "overrun", "swap", "shadow"}
    own |= SENSORS.keys()
    overheard = {topic.name for topic in OVERHEARD}
    assert own.isdisjoint(overheard)
    assert own | overheard == {topic.name for topic in TOPICS if topic.recorded}


def test_a_key_names_its_topic_and_a_topic_its_message() -> None:
    for topic in TOPICS:
        assert topic_of(topic.key("robot7")) is topic
        package, _, name = topic.schema.partition(".")
        assert (package in ("foxglove", "reflexarc"), name) == (True, topic.message.__name__)
