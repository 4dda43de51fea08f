"""An agent that pulls the nearest end of the object towards where it belongs."""

import numpy as np


class PullAgent:
    """Greedy, and blind to clips: about what a first idea is worth."""

    def __init__(self, device="cpu"):
        self.device = device  # factories get env_id and device, if they declare them

    def reset(self, episode, seed):
        self.scale = episode.action_scale
        self.rng = np.random.default_rng(seed)

    def act(self, observation):
        gripper = observation["observation"][:3]
        distance = np.linalg.norm(observation["achieved_goal"] - gripper, axis=-1)
        held = distance.argmin()
        error = observation["desired_goal"][held] - observation["achieved_goal"][held]
        return np.clip(error / self.scale + self.rng.normal(0.0, 0.05, 3), -1.0, 1.0)
