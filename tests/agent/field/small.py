"""A small field and a few scenes, quick enough for tests."""

from __future__ import annotations

import numpy as np
import torch

from icd_agent.field.config import FieldConfig
from icd_agent.field.data import FieldData, FieldScene
from icd_agent.field.field import SceneField
from icd_agent.training.initial import initialise
from icd_envs.geometry.point_cloud import sample_scene
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.tasks.cable_routing import CableRouting

SMALL = FieldConfig(
    anchors=32, channels=4, code_channels=16, code_blocks=2, edge_width=8, width=16, descriptor=8
)


def small_field(seed: int = 0, config: FieldConfig = SMALL) -> SceneField:
    """With random weights."""
    field = SceneField(config)
    initialise(field, torch.Generator().manual_seed(seed))
    return field.eval()


def scene(seed: int) -> FieldScene:
    """A random cable scene whose object has been at a few places above the floor."""
    rng = np.random.default_rng(seed)
    task = CableRouting()
    boxes = task.boxes(task.draw_scenes(rng).scene)
    places = rng.uniform((0.0, -0.3, 0.0), (0.6, 0.3, 0.1), (20, 3)).astype(np.float32)
    return FieldScene(sample_scene(boxes, 300, 60, rng), places, BoxUnion(boxes))


def small_data() -> FieldData:
    """Three scenes."""
    return FieldData([scene(seed) for seed in range(3)])
