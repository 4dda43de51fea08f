"""The cable routing scene's MJCF text, without building it from scratch every time.

Building and printing the PyMJCF model takes 45-60 ms, as long as some 60 control steps. From scene
to scene only the poses of a few bodies differ, so they are written into the text of a scene that is
built once for each kind of cable and number of clips.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from icd_envs.scenes.cable import CableSpec
from icd_envs.scenes.cable_routing import ROUTED, CableRoutingScene, build_scene
from icd_envs.scenes.clip import Clip


def scene_xml(scene: CableRoutingScene) -> str:
    """The same text as ``build_scene(scene).to_xml_string()``."""
    anchor = (float(scene.anchor[0]), float(scene.anchor[1]), float(scene.anchor[2]))
    text = _template(len(scene.clips), anchor, scene.cable)
    for i, clip in enumerate(scene.clips):
        text = _placed(text, f"clip_{i}", clip.origin.tolist(), clip.yaw)
    return _placed(text, "link_0", anchor, scene.start_bearing)


@lru_cache(maxsize=16)
def _template(clips: int, anchor: tuple[float, float, float], cable: CableSpec) -> str:
    places = (Clip((0.0, 0.0), 0.0),) * clips
    scene = CableRoutingScene(places, ROUTED * clips, 0.0, np.array(anchor), cable)
    return str(build_scene(scene).to_xml_string())


def _placed(text: str, body: str, position: Sequence[float], yaw: float) -> str:
    pose = f'pos="{_numbers(position)}" quat="{_numbers((np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)))}"'
    return re.sub(rf'(<body name="{body}") pos="[^"]*" quat="[^"]*"', rf"\1 {pose}", text, count=1)


def _numbers(values: Sequence[float]) -> str:
    return " ".join(f"{value:.17g}" for value in values)
