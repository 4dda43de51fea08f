"""What ``icd-bench train sac-her`` does: Stable-Baselines3's SAC, kept without pickles."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import gymnasium as gym
import numpy as np
from stable_baselines3 import SAC, HerReplayBuffer
from stable_baselines3.common.callbacks import BaseCallback

import icd_envs  # noqa: F401  registers our ids
from baselines.point_net import PointNetExtractor
from baselines.sac_her import KIND, Actor, ActorConfig
from benchmarks.console import Values
from benchmarks.training_progress import training
from icd_agent.checkpoints import not_finite, save_checkpoint
from icd_agent.locking import alone
from icd_agent.training.device import check_device
from icd_agent.training.state import read_state, save_state
from icd_envs.errors import TrainingError
from icd_envs.registration import check_env_id
from icd_envs.wrappers import SubsamplePointCloud

if TYPE_CHECKING:
    from icd_agent.training.loop import Seen

STATE_NAME: Final = "training.pt"
CONFIG: Final = ActorConfig(
    object_points=32, scene_points=64, point_widths=(64, 128), widths=(256, 256)
)
SAVE_EVERY: Final = 2_000
"""Control steps between states that a killed run can go on from."""
BUFFER: Final = 100_000
TRAIN_EVERY: Final = 4
"""Control steps between gradient steps."""


def train(env_id: str, out: Path, *, device: str, steps: int, seed: int) -> Values:
    """Train in training scenes, or go on with a killed run, and save the actor in ``out``.

    What was replayed is not kept: a run that goes on fills its buffer again, with random actions
    for two episodes and then with its own, so that its weights are not those of an uninterrupted
    one. Scenes, actions and noise follow from the seed and from the step that it goes on at.

    Args:
        env_id: which environment.
        out: folder of the run's state and in the end the actor's checkpoint.
        device: where to train.
        steps: control steps in all.
        seed: of weights, scenes and actions.

    Returns:
        Names and values for the user.

    Raises:
        IcdError: unknown environment, unusable device, or ``out`` cannot be written, is in use, or
            has a state of another run or of more steps.
    """
    check_env_id(env_id)
    check_device(device)
    with alone(out):
        env = SubsamplePointCloud(
            gym.make(env_id, split="train", disable_env_checker=True),
            object_points=CONFIG.object_points,
            scene_points=CONFIG.scene_points,
        )
        try:
            return _train(env, env_id, out, device=device, steps=steps, seed=seed)
        finally:
            env.close()


def _train(
    env: gym.Env[Any, Any], env_id: str, out: Path, *, device: str, steps: int, seed: int
) -> Values:
    unwrapped: Any = env.unwrapped
    model = _make(env, 2 * unwrapped.task.max_steps, device, seed)
    done = _resume(out / STATE_NAME, model, {"env": env_id, "seed": seed})
    if done >= steps + TRAIN_EVERY:  # a run ends after a gradient step
        raise TrainingError(
            f"{out} has {done} steps, more than the {steps} wanted: give --steps {done} or "
            "more, or choose another --out"
        )
    if done:  # with the seed of the beginning it would meet the first scenes again
        model.set_random_seed(int(np.random.SeedSequence([seed, done]).generate_state(1)[0]))
    with training(f"sac-her of {env_id}", steps) as seen:
        if done < steps:
            saved = _Saved(out / STATE_NAME, {"env": env_id, "seed": seed}, seen)
            model.learn(steps - done, callback=saved, reset_num_timesteps=False)
    actor = actor_of(model)
    about = {
        "env": env_id,
        "seed": seed,
        "steps": model.num_timesteps,
        "gradient_steps": model._n_updates,
    }
    save_checkpoint(out, KIND, actor, CONFIG, {"training": about})
    parameters = sum(value.numel() for value in actor.parameters())
    return {"out": str(out), "steps": model.num_timesteps, "parameters": parameters}


def actor_of(model: SAC) -> Actor:
    """The deterministic part of a model's actor, with weights of its own."""
    actor, policy = Actor(CONFIG), model.actor
    extractor: Any = policy.features_extractor
    parts = (
        (actor.point_net, extractor._point_net),
        (actor.perceptron, policy.latent_pi),
        (actor.mean, policy.mu),
    )
    for ours, theirs in parts:
        ours.load_state_dict({name: x.cpu() for name, x in theirs.state_dict().items()})
    return actor.eval()


def _make(env: gym.Env[Any, Any], learning_starts: int, device: str, seed: int) -> SAC:
    return SAC(
        "MultiInputPolicy",
        env,
        policy_kwargs={
            "features_extractor_class": PointNetExtractor,
            "features_extractor_kwargs": {"widths": CONFIG.point_widths},
            "net_arch": list(CONFIG.widths),
        },
        replay_buffer_class=HerReplayBuffer,
        replay_buffer_kwargs={"copy_info_dict": True},
        learning_starts=learning_starts,
        buffer_size=BUFFER,
        batch_size=64,
        train_freq=TRAIN_EVERY,
        gamma=0.98,
        seed=seed,
        device=device,
    )


class _Saved(BaseCallback):
    """Writes the state every so many steps, and at the end."""

    def __init__(self, path: Path, run: dict[str, Any], seen: Seen) -> None:
        super().__init__()
        self._path, self._run, self._seen = path, run, seen

    def _on_step(self) -> bool:
        if self.num_timesteps % SAVE_EVERY == 0:
            self._save()
        return True

    def _on_training_end(self) -> None:
        self._save()

    def _save(self) -> None:
        model: Any = self.model
        if (bad := not_finite(model.policy.state_dict())) is not None:
            raise TrainingError(
                f"{bad} is not finite after {model.num_timesteps} steps: train with another --seed "
                f"and another --out; the last save in {self._path.parent} is good"
            )
        state = {
            "step": model.num_timesteps,
            "updates": model._n_updates,
            "parameters": model.get_parameters(),
            "log_ent_coef": model.log_ent_coef.detach(),
        }
        save_state(self._path, self._run, state)
        self._seen(model.num_timesteps, {})


def _resume(path: Path, model: SAC, run: dict[str, Any]) -> int:
    """Control steps done by a killed run, whose weights the model then has."""
    state = read_state(path, run)
    if state is None:
        return 0
    try:
        model.set_parameters(state["parameters"], device=model.device)
        coefficient: Any = model.log_ent_coef
        coefficient.data.copy_(state["log_ent_coef"])
        model.num_timesteps, model._n_updates = state["step"], state["updates"]
        model.learning_starts += state["step"]
        return int(state["step"])
    except Exception as error:  # names, shapes and types each fail in ways of their own
        raise TrainingError(
            f"{path} does not fit the model: {error}: delete it and train again"
        ) from error
