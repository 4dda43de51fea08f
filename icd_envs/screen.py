"""What an environment's ``render`` returns or shows, in the mode that it was made with."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from gymnasium import logger
from numpy.typing import NDArray

from icd_envs.api import Float32Array, PlanView
from icd_envs.drawing import Overlay
from icd_envs.rendering import SceneRenderer
from icd_envs.scenes.arena import MAX_HEIGHT, MAX_WIDTH, SUBSTEPS, TIMESTEP
from icd_envs.tasks.checks import check_choice, check_integer
from icd_envs.window import Window

if TYPE_CHECKING:
    from icd_envs.physics.plant import Plant

RENDER_MODES: Final = ("human", "rgb_array", "depth_array")
CAMERAS: Final = ("overview", "side", "top")
CONTROL_PERIOD: Final = SUBSTEPS * TIMESTEP
"""[s] a person is given to look at a step."""


class Screen:
    """Pictures or a window of one scene at a time; opened when first needed.

    Attributes:
        plan: what an agent wants to be drawn into pictures of the present scene.
    """

    def __init__(self, mode: str | None, width: int, height: int, camera: str) -> None:
        """Choose; nothing is opened yet.

        Args:
            mode: None or one of ``RENDER_MODES``.
            width: [px] of pictures.
            height: [px] of pictures.
            camera: one of ``CAMERAS``.

        Raises:
            InvalidOptionError: on any other value.
        """
        if mode is not None:
            check_choice("render_mode", mode, RENDER_MODES)
        check_choice("camera", camera, CAMERAS)
        check_integer("width", width, 1, MAX_WIDTH)
        check_integer("height", height, 1, MAX_HEIGHT)
        self.plan: PlanView | None = None
        self._mode = mode
        self._size = (width, height)
        self._camera = camera
        self._renderer: SceneRenderer | None = None
        self._window: Window | None = None

    def render(self, plant: Plant, goal: Float32Array) -> NDArray[np.uint8] | Float32Array | None:
        """A picture, or None after showing one in the window.

        Args:
            plant: the scene and its state; the same scene until ``close``.
            goal: (N, 3) [m] cloud, drawn in red.

        Raises:
            RenderingUnavailableError: if there is no OpenGL, or no display for a window.
        """
        if self._mode is None:
            logger.warn("render() without a render_mode: pass render_mode='rgb_array' to make")
            return None
        overlay = Overlay(goal, self.plan)
        if self._mode == "human":
            if self._window is None:
                self._window = Window(plant.model, self._camera)
            self._window.draw(plant.data, overlay)
            return None
        if self._renderer is None:
            self._renderer = SceneRenderer(plant.model, *self._size, self._camera)
        if self._mode == "depth_array":
            return self._renderer.depth(plant.data)
        return self._renderer.rgb(plant.data, overlay)

    def follow(self, plant: Plant, goal: Float32Array) -> None:
        """After every reset and step: let a person see it, for as long as it would really take."""
        if self._mode == "human":
            self.render(plant, goal)
            threading.Event().wait(CONTROL_PERIOD)

    def __getstate__(self) -> dict[str, Any]:
        """All but what is open: a copy opens its own."""
        return {**self.__dict__, "_renderer": None, "_window": None}

    def close(self) -> None:
        """End with this scene: free OpenGL or the window, forget the plan."""
        for opened in (self._renderer, self._window):
            if opened is not None:
                opened.close()
        self._renderer = self._window = self.plan = None
