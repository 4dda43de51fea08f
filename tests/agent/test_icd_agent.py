"""ICD as a policy: composed of networks that fit, saved and read back to the same actions."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium.wrappers import TimeLimit
from stable_baselines3.common.evaluation import evaluate_policy

from baselines.global_ndf import make_global_ndf
from baselines.icd import make_icd, make_icd_local
from icd_agent.agent import ICDAgent
from icd_agent.checkpoints import read_about, save_checkpoint, weights_sha256
from icd_agent.diffusion.config import DiffusionConfig
from icd_agent.diffusion.denoiser import Denoiser
from icd_agent.latent.config import LatentConfig
from icd_agent.latent.model import LatentModel
from icd_agent.networks import Networks
from icd_agent.presets import PRESETS, best_preset
from icd_agent.scene_tokens import TOKENS
from icd_agent.training.initial import initialise
from icd_envs.api import Agent, FloatArray
from icd_envs.errors import (
    CheckpointError,
    EpisodeStateError,
    InvalidObservationError,
    InvalidOptionError,
)
from icd_envs.wrappers import FlattenPointCloud, NoisyObservations, SubsamplePointCloud
from tests.agent.field.small import SMALL, small_field
from tests.envs.making import CABLE

NOTEBOOK = "ICDNotebookFolding-v0"
FEATURES = SMALL.descriptor
LATENT = LatentConfig(FEATURES, FEATURES, 200, latent=8, groups=6, neighbours=4, width=16)
DENOISER = DiffusionConfig(8, FEATURES, 200, TOKENS, width=32, layers=1, heads=2)


def networks() -> Networks:
    """With random weights: whatever they say, the agent must act on it."""
    found = Networks(small_field(), LatentModel(LATENT).eval(), Denoiser(DENOISER).eval())
    for network in (found.latent, found.diffusion):
        initialise(network, torch.Generator().manual_seed(0))
    return found


def two_fields() -> Networks:
    """The same, but chains are followed in another field than they are encoded in."""
    found = networks()
    wider = replace(SMALL, descriptor=FEATURES + 3)
    return found._replace(field=small_field(1, wider), whole=found.field)


@pytest.fixture
def env() -> Iterator[gym.Env[Any, Any]]:
    env = gym.make(CABLE)
    yield env
    env.close()


def actions(agent: ICDAgent, env: gym.Env[Any, Any], steps: int = 2) -> np.ndarray:
    observation, _ = env.reset(seed=3)
    unwrapped: Any = env.unwrapped
    agent.reset(unwrapped.episode(simulator=True), seed=1)
    found = []
    for _ in range(steps):
        found.append(agent.act(observation))
        observation = env.step(found[-1])[0]
    return np.array(found)


@pytest.mark.parametrize("preset", PRESETS)
def test_it_is_an_agent_that_plans_along_a_chain(env: gym.Env[Any, Any], preset: str) -> None:
    agent = ICDAgent(networks(), preset)
    assert isinstance(agent, Agent)
    assert agent.needs_simulator
    found = actions(agent, env)
    assert found.shape == (2, 3)
    assert np.abs(found).max() <= 1
    assert agent.plan_info is not None
    assert agent.plan_info.chain_length >= 2
    assert agent.plan_view() is not None


@pytest.mark.parametrize("made", [networks, two_fields])
def test_saved_and_read_back_it_acts_the_same_to_the_bit(
    env: gym.Env[Any, Any], tmp_path: Path, made: Callable[[], Networks]
) -> None:
    agent = ICDAgent(made())
    agent.save_pretrained(tmp_path)
    before = actions(agent, env)
    for source in (tmp_path, str(tmp_path)):
        np.testing.assert_array_equal(actions(ICDAgent.from_pretrained(source), env), before)


@pytest.mark.parametrize("part", ["latent", "diffusion"])
@pytest.mark.parametrize("made", [networks, two_fields])
def test_networks_of_another_field_are_refused(
    tmp_path: Path, part: str, made: Callable[[], Networks]
) -> None:
    found = made()
    ICDAgent(found).save_pretrained(tmp_path / "one")
    other = found._replace(**{"field" if found.whole is None else "whole": small_field(1)})
    ICDAgent(other).save_pretrained(tmp_path / "other")
    shutil.copytree(tmp_path / "other" / part, tmp_path / "one" / part, dirs_exist_ok=True)
    with pytest.raises(CheckpointError, match=f"{part} was trained with the field"):
        ICDAgent.from_pretrained(tmp_path / "one")


def test_a_denoiser_of_other_latents_is_refused_unless_they_were_only_rounded(
    tmp_path: Path,
) -> None:
    found = networks()
    other = LatentModel(LATENT).eval()
    initialise(other, torch.Generator().manual_seed(1))
    for name, latent in (("one", found.latent), ("other", other)):
        ICDAgent(found._replace(latent=latent)).save_pretrained(tmp_path / name)
    trained = weights_sha256(tmp_path / "one" / "latent")
    shutil.copytree(tmp_path / "other/latent", tmp_path / "one/latent", dirs_exist_ok=True)
    with pytest.raises(CheckpointError, match="was trained with the latent"):
        ICDAgent.from_pretrained(tmp_path / "one")
    about = {"rounded_from": trained}
    save_checkpoint(tmp_path / "one" / "latent", "latent", found.latent, LATENT, about, half=True)
    ICDAgent.from_pretrained(tmp_path / "one")


def learned_in(*env_ids: str) -> Networks:
    """Networks that tell where the denoiser was trained, and then where the field was."""
    told = {"data": {"seed": 3}, "training": {"steps": 7}}
    parts = dict(zip(("diffusion", "field"), env_ids, strict=False))
    about = {part: {**told, "data": {"seed": 3, "env": env}} for part, env in parts.items()}
    return networks()._replace(about=about)


def test_networks_of_one_field_replace_those_of_two(tmp_path: Path) -> None:
    ICDAgent(two_fields()).save_pretrained(tmp_path)
    stale = tmp_path / "whole"
    shutil.copytree(stale, tmp_path / "kept")
    ICDAgent(networks(), "paper").save_pretrained(tmp_path)
    assert not stale.exists()
    shutil.copytree(tmp_path / "kept", stale)  # as if killed before it was removed
    assert ICDAgent.from_pretrained(tmp_path, "paper").networks.whole is None


@pytest.mark.parametrize("others", [0, 1, 2, 3])
def test_a_kill_while_networks_are_saved_leaves_some_that_load(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, others: int
) -> None:
    saved = []

    def save(folder: Path, *rest: Any) -> None:  # noqa: ANN401
        if len(saved) == others:
            raise KeyboardInterrupt
        saved.append(folder)
        save_checkpoint(folder, *rest)

    ICDAgent(networks()).save_pretrained(tmp_path)
    monkeypatch.setattr("icd_agent.networks.save_checkpoint", save)
    if others < 3:
        with pytest.raises(KeyboardInterrupt):
            ICDAgent(learned_in(NOTEBOOK)).save_pretrained(tmp_path)
    else:
        ICDAgent(learned_in(NOTEBOOK)).save_pretrained(tmp_path)
    expected = NOTEBOOK if others == 3 else None
    assert ICDAgent.from_pretrained(tmp_path).networks.env_id == expected


def test_saved_weights_tell_how_they_were_trained_and_keep_their_preset(tmp_path: Path) -> None:
    ICDAgent(learned_in(NOTEBOOK, NOTEBOOK), "paper").save_pretrained(tmp_path)
    about = read_about(tmp_path / "diffusion")
    made_with = {part: weights_sha256(tmp_path / part) for part in ("field", "latent")}
    assert about["data"] == {"seed": 3, "env": NOTEBOOK, **made_with}
    assert about["training"] == {"steps": 7}
    loaded = ICDAgent.from_pretrained(tmp_path)
    assert loaded.networks.env_id == NOTEBOOK
    assert loaded.preset == best_preset(NOTEBOOK) == "careful"
    whole = learned_in(NOTEBOOK, NOTEBOOK)._replace(
        field=small_field(0, replace(SMALL, scope="global"))
    )
    ICDAgent(whole).save_pretrained(tmp_path / "whole")
    for make, folder in (
        (make_icd, tmp_path),
        (make_icd_local, tmp_path),
        (make_global_ndf, tmp_path / "whole"),
    ):
        assert make("ICDNotebookFoldingAdaptation-v0", folder).preset == "careful"
        assert make("Another-v0", folder).preset == "careful"


def test_weights_of_another_task_are_refused_unless_it_is_not_ours(
    env: gym.Env[Any, Any], tmp_path: Path
) -> None:
    agent = ICDAgent(learned_in(NOTEBOOK))
    agent.save_pretrained(tmp_path)
    unwrapped: Any = env.unwrapped
    env.reset(seed=3)
    episode = unwrapped.episode(simulator=True)
    with pytest.raises(CheckpointError, match=f"{NOTEBOOK} cannot be used in {CABLE}"):
        agent.reset(episode, seed=1)
    with pytest.raises(CheckpointError, match="its own task"):
        ICDAgent.from_pretrained(tmp_path, env=env)
    with pytest.raises(CheckpointError, match="its own task"):
        make_icd(CABLE, tmp_path)
    agent.reset(replace(episode, env_id="Another-v0"), seed=1)
    ICDAgent(learned_in("Another-v0"), env=env).reset(episode, seed=1)
    ICDAgent(learned_in(NOTEBOOK, CABLE)).save_pretrained(tmp_path / "mixed")
    with pytest.raises(CheckpointError, match="its own task"):
        ICDAgent.from_pretrained(tmp_path / "mixed")


def test_chains_are_generated_in_one_field_and_followed_in_the_other(
    env: gym.Env[Any, Any],
) -> None:
    one, two = ICDAgent(networks()), ICDAgent(two_fields())
    apart = actions(one, env) != actions(two, env)
    assert apart.any()
    chains = []
    for agent in (one, two):
        view = agent.plan_view()
        assert view is not None
        assert view.subgoals is not None
        chains.append(view.subgoals)
    np.testing.assert_array_equal(*chains)


@pytest.mark.parametrize("made", [networks, two_fields])
@pytest.mark.parametrize("seen", ["partial", "noisy"])
def test_a_chain_ends_at_its_goal_however_the_scene_is_seen(
    seen: str, made: Callable[[], Networks]
) -> None:
    partial: gym.Env[Any, Any] = gym.make(CABLE, obs_mode="partial")
    env = partial if seen == "partial" else NoisyObservations(gym.make(CABLE), std=0.005)
    observation, _ = env.reset(seed=3)
    unwrapped: Any = env.unwrapped
    agent = ICDAgent(made())
    agent.reset(unwrapped.episode(simulator=True), seed=1)
    agent.act(observation)
    view = agent.plan_view()
    assert view is not None
    assert view.subgoals is not None
    np.testing.assert_array_equal(view.subgoals[-1], observation["desired_goal"])
    env.close()


def test_what_is_decoded_cannot_be_followed_in_another_field() -> None:
    with pytest.raises(CheckpointError, match="trained on one field"):
        ICDAgent(two_fields(), "paper")


@pytest.mark.parametrize("preset", PRESETS)
def test_the_package_has_weights_for_every_preset(preset: str) -> None:
    agent = ICDAgent.from_pretrained(CABLE, preset)
    assert (agent.networks.whole is None) == (preset == "paper")
    assert ICDAgent.from_pretrained("ICDNotebookFolding-v0", preset).networks.whole is None


def test_predict_is_the_policy_interface_of_stable_baselines(env: gym.Env[Any, Any]) -> None:
    observation, _ = env.reset(seed=3)
    agent = ICDAgent(networks(), env=env)
    action, state = agent.predict(observation)
    assert action.shape == (3,)
    assert state is None
    batched = {name: value[None] for name, value in observation.items()}
    again, _ = agent.predict(batched, episode_start=np.array([True]))
    np.testing.assert_array_equal(again, action[None])


def test_predict_begins_anew_after_every_reset(env: gym.Env[Any, Any]) -> None:
    def predicted(agent: ICDAgent, seed: int) -> FloatArray:
        observation, _ = env.reset(seed=seed)
        first, _ = agent.predict(observation)
        second, _ = agent.predict(env.step(first)[0])
        return np.array([first, second])

    agent = ICDAgent(networks(), env=env)
    predicted(agent, 3)
    np.testing.assert_array_equal(predicted(agent, 4), predicted(ICDAgent(networks(), env=env), 4))


def test_stable_baselines_evaluates_it(env: gym.Env[Any, Any]) -> None:
    short = TimeLimit(env, 2)
    agent = ICDAgent(networks(), env=short)
    returns, lengths = evaluate_policy(agent, short, 2, return_episode_rewards=True, warn=False)
    assert lengths == [2, 2]
    assert returns == [-2.0, -2.0]


def test_predict_says_what_is_missing(env: gym.Env[Any, Any]) -> None:
    observation, _ = env.reset(seed=3)
    with pytest.raises(EpisodeStateError, match="env="):
        ICDAgent(networks()).predict(observation)
    two = {name: np.stack([value, value]) for name, value in observation.items()}
    with pytest.raises(InvalidOptionError, match="2 environments"):
        ICDAgent(networks(), env=env).predict(two)


def test_predict_refuses_what_another_environment_observes(env: gym.Env[Any, Any]) -> None:
    other = gym.make(CABLE)
    mine, theirs = env.reset(seed=3)[0], other.reset(seed=4)[0]
    agent = ICDAgent(networks(), env=env)
    with pytest.raises(EpisodeStateError, match="another desired_goal"):
        agent.predict(theirs)
    agent.predict(mine)
    with pytest.raises(InvalidObservationError, match="FlattenPointCloud"):
        agent.predict(FlattenPointCloud(env).reset(seed=3)[0])  # type: ignore[arg-type]
    with pytest.raises(InvalidObservationError, match=r"achieved_goal has shape \(50, 3\)"):
        agent.predict(SubsamplePointCloud(env, 50, 100).reset(seed=3)[0])
    other.close()


def test_predict_takes_noise_and_partial_views() -> None:
    partial: gym.Env[Any, Any] = gym.make(CABLE, obs_mode="partial")
    env = NoisyObservations(partial, std=0.005)
    action, _ = ICDAgent(networks(), env=env).predict(env.reset(seed=3)[0])
    assert np.isfinite(action).all()
    env.close()


def test_unknown_preset_is_refused() -> None:
    with pytest.raises(InvalidOptionError, match="did you mean"):
        ICDAgent(networks(), "imporved")


def test_networks_that_do_not_fit_one_another_are_refused() -> None:
    fitting = networks()
    other = LatentConfig(FEATURES + 1, FEATURES, 200, latent=8)
    with pytest.raises(CheckpointError, match="9 features"):
        ICDAgent(fitting._replace(latent=LatentModel(other).eval()))
    wider = DiffusionConfig(16, FEATURES, 200, TOKENS, width=32, layers=1, heads=2)
    with pytest.raises(CheckpointError, match="latent=16 of the denoiser"):
        ICDAgent(fitting._replace(diffusion=Denoiser(wider).eval()))


def test_missing_weights_are_named(tmp_path: Path) -> None:
    with pytest.raises(CheckpointError, match=str(tmp_path)):
        ICDAgent.from_pretrained(tmp_path)


@pytest.mark.parametrize(
    ("source", "reason"),
    [
        ("ICDCableRoutng-v0", "did you mean 'ICDCableRouting-v0'"),
        ("./runs/icd", "no folder: name what save_pretrained"),
        ("runs/icd/best", "no folder: name what save_pretrained"),
        ("runs/icd", "no folder here, and as a repository .* OSError: not now"),
    ],
)
def test_a_source_that_is_not_there_is_answered_by_what_it_could_have_been(
    source: str, reason: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def download(source: str, **given: object) -> str:
        raise OSError("not now")

    monkeypatch.setattr("huggingface_hub.snapshot_download", download)
    with pytest.raises(CheckpointError, match=reason):
        ICDAgent.from_pretrained(source)


def test_a_repository_is_downloaded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ICDAgent(learned_in(NOTEBOOK)).save_pretrained(tmp_path)
    downloads = {"owner/name": str(tmp_path)}
    monkeypatch.setattr("huggingface_hub.snapshot_download", lambda name, **_: downloads[name])
    assert ICDAgent.from_pretrained("owner/name").networks.env_id == NOTEBOOK


def test_a_folder_named_like_an_environment_is_a_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(CheckpointError, match="cannot read"):
        ICDAgent.from_pretrained(Path(CABLE))
    ICDAgent(learned_in("Another-v0")).save_pretrained(CABLE)
    for source in (CABLE, Path(CABLE)):
        assert ICDAgent.from_pretrained(source).networks.env_id == "Another-v0"


def test_the_notebook_is_not_hurried() -> None:
    assert best_preset("ICDNotebookFolding-v0") == "careful"
    assert best_preset("ICDNotebookFoldingAdaptation-v0") == "careful"
    assert best_preset("ICDCableRouting-v0") == best_preset(None) == "improved"
