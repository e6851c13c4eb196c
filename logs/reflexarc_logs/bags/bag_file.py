"""A bag of ROS 2: a folder with `metadata.yaml`, or one of its files (`.mcap`, `.db3`)."""

from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Self

from rosbags.rosbag2 import Reader, ReaderError

from reflexarc_logs.container.frames import MAGIC
from reflexarc_logs.container.remedy import recovery
from reflexarc_runtime.errors import LogError

_FILES = (".mcap", ".db3")


class BagTopic(NamedTuple):
    """A topic of a bag."""

    name: str
    type_name: str
    """As `ros2 interface` spells it: `sensor_msgs/msg/LaserScan`."""
    messages: int


class BagMessage(NamedTuple):
    """One message of a bag."""

    topic: BagTopic
    time_ns: int
    """When the bag's recorder took it, by its wall clock."""
    payload: bytes


class BagFile:
    """A bag that is open for reading; its messages may be read as often as they are wanted.

    Args:
        path: a folder or a file.

    Raises:
        LogError: it is missing, damaged, of ROS 1, or no bag.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        _check_kind(path)
        try:
            self._reader = Reader(path)
            self._reader.open()
        except Exception as error:  # its parsers raise whatever a damaged file makes them
            raise self._unreadable(error) from None
        self._topics = {c.id: BagTopic(c.topic, c.msgtype, c.msgcount) for c in self._open}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._reader.close()

    @property
    def topics(self) -> tuple[BagTopic, ...]:
        """What the bag holds; those that speak of one topic with two types are two."""
        return tuple(self._topics.values())

    @property
    def ros_distro(self) -> str:
        """The distribution that wrote it; empty where it does not say."""
        return self._reader.ros_distro or ""

    def messages(self, topics: Collection[BagTopic]) -> Iterator[BagMessage]:
        """The messages of some topics, by their times.

        Raises:
            LogError: the bag is damaged.
        """
        wanted = [c for c in self._open if self._topics[c.id] in topics]
        if not wanted:
            return
        try:
            for connection, time_ns, payload in self._reader.messages(wanted):
                yield BagMessage(self._topics[connection.id], time_ns, bytes(payload))
        except GeneratorExit:
            raise
        except Exception as error:  # see above
            raise self._unreadable(error) from None

    @property
    def _open(self) -> Sequence[Any]:
        return self._reader.connections

    def _unreadable(self, error: Exception) -> LogError:
        reason = error.strerror if isinstance(error, OSError) else None
        words = " ".join(str(reason or error).split())[:160] or type(error).__name__
        advice = "" if isinstance(error, ReaderError | OSError) else "; is it damaged?"
        if _begins_as_mcap(self.path):
            advice = f"; {recovery(self.path)} saves what is intact"
        return LogError(f"{self.path}: expected a bag of ROS 2, cannot read it: {words}{advice}")


def _begins_as_mcap(path: Path) -> bool:
    """Whether there is anything in it that could be saved."""
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(len(MAGIC)) == MAGIC


def _check_kind(path: Path) -> None:
    if not path.exists():
        raise LogError(f"{path}: expected a bag of ROS 2, found nothing there")
    if path.is_dir():
        if not (path / "metadata.yaml").is_file():
            raise LogError(
                f"{path}: expected a bag of ROS 2, found no metadata.yaml in it; give one of its "
                "files, or `ros2 bag reindex` it"
            )
    elif path.suffix == ".bag":
        raise LogError(f"{path}: it is a bag of ROS 1; `rosbags-convert` makes one of ROS 2 of it")
    elif path.suffix not in _FILES:
        raise LogError(f"{path}: expected a bag: a folder, .mcap or .db3")
