from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from icd_envs.scenes.cable import CableSpec
from icd_envs.scenes.cable_routing import CableRoutingScene, build_scene, draw_scene
from icd_envs.scenes.cable_routing_xml import scene_xml


def variants(seed: int) -> list[CableRoutingScene]:
    scene = draw_scene(np.random.default_rng(seed))
    return [
        scene,
        dataclasses.replace(scene, cable=CableSpec(links=6, stiffness=0.1)),
        dataclasses.replace(scene, clips=scene.clips[:1]),
        dataclasses.replace(scene, clips=(*scene.clips, *scene.clips[::-1])),
        dataclasses.replace(scene, anchor=np.array([0.1, -0.0, 0.05]), start_bearing=0.0),
    ]


@pytest.mark.parametrize("seed", range(3))
def test_text_is_that_of_the_built_scene(seed: int) -> None:
    for scene in variants(seed):
        assert scene_xml(scene) == build_scene(scene).to_xml_string()
