"""Settings of a process that let a loop wake on time: asked of the kernel, and obtained."""

from reflexarc_runtime.loop.realtime.realtime import Realtime, prepare
from reflexarc_runtime.loop.realtime.realtime_settings import RealtimeSettings

__all__ = ["Realtime", "RealtimeSettings", "prepare"]
