"""Episodes of the scripted experts: acted out now, or recorded in a folder."""

from __future__ import annotations

from icd_envs.demonstrations.experts import TASKS, demonstrate, demonstrate_task, find_task
from icd_envs.demonstrations.reader import Demonstrations, RecordedEpisode, RecordedScene

__all__ = [
    "TASKS",
    "Demonstrations",
    "RecordedEpisode",
    "RecordedScene",
    "demonstrate",
    "demonstrate_task",
    "find_task",
]
