"""Chains: what is told of them, what is generated, and that it goes round the wall."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import torch

from icd_agent.checkpoints import save_checkpoint
from icd_agent.diffusion import train
from icd_agent.diffusion.chains import ChainData
from icd_agent.diffusion.code import SubgoalCode
from icd_agent.diffusion.config import LEVELS, LONGEST, ChainConfig, DiffusionConfig
from icd_agent.diffusion.denoiser import COARSE, GIVEN, UNKNOWN, Denoiser, KeyValue
from icd_agent.diffusion.generate import Generator, Task
from icd_agent.diffusion.retrieval import BankConfig, ChainBank, Retriever, load_bank, make_bank
from icd_agent.diffusion.train import encode_states, load_diffusion, train_diffusion
from icd_agent.latent.model import LatentModel
from icd_agent.latent.train import load_latent
from icd_agent.scene_tokens import Frame
from icd_agent.states import States
from icd_agent.training.config import TrainingConfig
from icd_agent.training.loop import Loss
from icd_agent.training.network import Network
from icd_envs.api import FloatArray
from icd_envs.errors import InvalidOptionError
from tests.agent.toy_states import CANONICAL, LATENT, bar_at, toy_states
from tests.killing import KilledError, kill_at

SMALL = DiffusionConfig(8, 4, 12, 2, places=4, width=48, layers=2, heads=2)


class Networks(NamedTuple):
    latent: LatentModel
    denoiser: Denoiser


@pytest.fixture(scope="module")
def networks(toy_latent: Path, tmp_path_factory: pytest.TempPathFactory) -> Networks:
    folder, latent = tmp_path_factory.mktemp("diffusion"), load_latent(toy_latent)
    config = TrainingConfig(steps=500, learning_rate=2e-3, warmup=20, log_every=50, ema=0.98)
    train_diffusion(toy_states(), latent, SMALL, config, folder, about={})
    return Networks(latent, load_diffusion(folder))


def task(networks: Networks, *, foreign: bool = False) -> Task:
    states = toy_states(1, seed=5)
    ends = bar_at(np.array([[-0.2, 0.1, 0.0], [0.2, 0.0, 0.0]]))
    with torch.no_grad():
        now, goal = networks.latent.encode(torch.from_numpy(ends), torch.from_numpy(CANONICAL))
    scene = torch.from_numpy(states.tokens.seen_from(ends[0].mean(axis=0), 0.2))[0]
    code, placed = networks.denoiser.code, torch.from_numpy(seen(ends)).float()
    return Task(
        code.join(now, placed[0]),
        code.join(goal, None if foreign else placed[1]),
        foreign,
        scene,
    )


def toy_frame() -> Frame:
    """Of a toy that is where ``task`` begins."""
    tokens = toy_states(1, seed=5).tokens
    frame = tokens.frame(bar_at(np.array([-0.2, 0.1, 0.0])).mean(axis=0))
    return Frame(frame.origin[0], frame.along[0])


def seen(clouds: FloatArray) -> FloatArray:
    return toy_frame().place(clouds)


def test_a_generated_chain_goes_round_the_wall_in_order(networks: Networks) -> None:
    generator = Generator(networks.denoiser, networks.latent, ChainConfig(reachable=None))
    found = generator.generate(task(networks), np.random.default_rng(0))
    assert found.latents.shape == (LONGEST, 8)
    with torch.no_grad():
        clouds = networks.latent.decode(found.latents, torch.from_numpy(CANONICAL)).numpy()
    places = (clouds - CANONICAL).mean(axis=1)
    assert places[:, 1].max() > 0.17  # over the wall: straight ahead it would only sink
    assert (np.diff(places[:, 0]) > -0.03).all()
    np.testing.assert_allclose(places[0], [-0.2, 0.1, 0.0], atol=0.04)
    np.testing.assert_allclose(places[-1], [0.2, 0.0, 0.0], atol=0.04)
    apart = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert apart.max() < 3 * np.median(apart)
    assert found.clouds is not None  # the toy's descriptors are its places: both tell the same
    np.testing.assert_allclose(toy_frame().back(found.clouds.numpy()), clouds, atol=0.05)


@pytest.mark.parametrize(("reachable", "length"), [(1e6, 3), (None, LONGEST)])
def test_chains_are_refined_until_every_pair_is_reachable(
    networks: Networks, reachable: float | None, length: int
) -> None:
    config = ChainConfig(chains=2, denoising_steps=2, reachable=reachable)
    found = Generator(networks.denoiser, networks.latent, config).generate(
        task(networks), np.random.default_rng(0)
    )
    assert len(found.latents) == length
    assert len(found.steps) == length - 1


@pytest.mark.parametrize(
    ("others", "farther", "length"), [(15.0, [], 3), (0.0, [0], LONGEST), (0.0, [-1], LONGEST)]
)
def test_one_pair_beyond_reach_is_enough_to_refine_a_chain_and_all_at_it_are_not(
    networks: Networks,
    monkeypatch: pytest.MonkeyPatch,
    others: float,
    farther: list[int],
    length: int,
) -> None:
    def steps(self: Generator, chains: torch.Tensor, scene: torch.Tensor) -> torch.Tensor:
        found = torch.full((len(chains), chains.shape[1] - 1), others)
        found[:, farther] = 15.5
        return found

    monkeypatch.setattr(Generator, "steps", steps)
    config = ChainConfig(chains=1, denoising_steps=1, reachable=15.0)
    found = Generator(networks.denoiser, networks.latent, config).generate(
        task(networks), np.random.default_rng(0)
    )
    assert len(found.latents) == length


def test_same_draws_same_bits_and_other_draws_other_chains(networks: Networks) -> None:
    generator = Generator(networks.denoiser, networks.latent, ChainConfig(chains=2))
    first, again, other = (
        generator.generate(task(networks), np.random.default_rng(seed)).latents
        for seed in (1, 1, 2)
    )
    assert torch.equal(first, again)
    assert not torch.equal(first[:3], other[:3])


def test_a_foreign_goal_is_generated_unless_in_painted(networks: Networks) -> None:
    wanted = task(networks, foreign=True)
    ends = {}
    for inpaint in (True, False):
        config = ChainConfig(chains=1, denoising_steps=4, inpaint_goal=inpaint)
        generator = Generator(networks.denoiser, networks.latent, config)
        ends[inpaint] = generator.generate(wanted, np.random.default_rng(0)).latents[-1]
    goal = networks.denoiser.code.latents(wanted.goal)
    torch.testing.assert_close(ends[True], goal, atol=1e-5, rtol=0.0)
    assert not torch.allclose(ends[False], goal, atol=1e-4)


@pytest.mark.parametrize("inpaint", [True, False])
def test_the_denoiser_is_told_of_foreign_goals_as_in_training(
    networks: Networks, monkeypatch: pytest.MonkeyPatch, inpaint: bool
) -> None:
    told = []

    def look(
        self: Denoiser, goal: torch.Tensor, foreign: torch.Tensor, scene: torch.Tensor
    ) -> list[KeyValue]:
        told.append(bool(foreign.any()))
        return seen(self, goal, foreign, scene)

    seen = Denoiser.look
    monkeypatch.setattr(Denoiser, "look", look)
    config = ChainConfig(chains=1, denoising_steps=1, inpaint_goal=inpaint)
    generator = Generator(networks.denoiser, networks.latent, config)
    for foreign in (True, False):
        generator.generate(task(networks, foreign=foreign), np.random.default_rng(0))
    assert told == [not inpaint, False]


def test_the_nearest_recorded_chain_is_found_at_every_length() -> None:
    rng = np.random.default_rng(0)
    kept = torch.from_numpy(rng.normal(size=(5, LONGEST, 3)).astype(np.float32))
    kept[..., 2] *= 1e3  # a number of large spread must not decide alone
    bank = ChainBank(BankConfig(5, 3), kept)
    for parts in (2, 4, 8, 16):
        every = (LONGEST - 1) // parts
        for chain in kept[:, ::every]:
            asked = chain + torch.tensor([0.01, -0.01, 10.0])
            assert torch.equal(bank.nearest(asked), chain)


def test_a_retrieved_chain_is_a_recorded_one_that_begins_now(networks: Networks) -> None:
    states = toy_states()
    latents = encode_states(states, networks.latent)
    bank = make_bank(states, latents, chains=7)
    assert bank.config == BankConfig(7, 8)
    generator = Generator(networks.denoiser, networks.latent, ChainConfig(chains=2))
    wanted, rng = task(networks), np.random.default_rng(0)
    found = Retriever(generator, bank).generate(wanted, rng)
    assert torch.equal(found.latents[0], networks.denoiser.code.latents(wanted.now))
    assert found.clouds is None
    rest = (latents[:, None] - found.latents[1:]).abs().amax(dim=2).amin(dim=0)
    assert float(rest.max()) == 0.0  # every other one is a state that was recorded
    assert len(found.steps) == len(found.latents) - 1


def test_a_bank_keeps_solved_episodes_only_and_is_saved(tmp_path: Path) -> None:
    states = toy_states(6)
    states = states._replace(success=np.array([False, True, False, False, True, True]))
    latents = torch.arange(len(states.step), dtype=torch.float32)[:, None]
    bank = make_bank(states, latents, chains=2)
    np.testing.assert_array_equal(bank.chains[:, 0, 0].numpy(), states.first[[1, 4]])
    np.testing.assert_array_equal(bank.chains[:, -1, 0].numpy(), states.first[[2, 5]] - 1)
    save_checkpoint(tmp_path, "chains", bank, bank.config, {})
    assert torch.equal(load_bank(tmp_path).chains, bank.chains)
    with pytest.raises(InvalidOptionError, match="no episode that solved"):
        make_bank(states._replace(success=np.zeros(6, bool)), latents, chains=2)


def numbered(states: States) -> ChainData:
    """Chain data whose latents are the rows of the states."""
    rows = torch.arange(len(states.step), dtype=torch.float32)
    return ChainData(states, rows[:, None].expand(-1, 8).contiguous(), SubgoalCode(SMALL), 0.2)


def test_chains_tell_ends_and_every_second_subgoal_and_nothing_else() -> None:
    states = toy_states()
    data = numbered(states)
    levels = set()
    for seed in range(30):
        clean, known = data.draw(16, np.random.default_rng(seed))
        rows = clean[..., 0].long().numpy()
        level = int(known.level[0])
        levels.add(level)
        assert rows.shape == (16, 2**level + 1)
        assert (states.episode[rows] == states.episode[rows[:, :1]]).all()
        assert (np.diff(rows, axis=1) >= 1).all()
        apart = np.diff(rows, axis=1)
        assert (apart.max(axis=1) - apart.min(axis=1) <= 1).all()  # equal, but for rounding
        assert (known.kinds[:, 0] == GIVEN).all()
        assert (known.kinds[:, 1::2] == UNKNOWN).all()
        assert (known.subgoals[known.kinds == UNKNOWN] == 0).all()
        assert (known.kinds[:, 2:-1:2] == COARSE).all()
        own = ~known.foreign
        assert (known.kinds[own, -1] == GIVEN).all()
        assert (known.kinds[known.foreign, -1] == (COARSE if level > 1 else UNKNOWN)).all()
        assert torch.equal(known.goal[own], clean[own, -1])
        torch.testing.assert_close(known.subgoals[:, 0], clean[:, 0])
    assert levels == set(range(1, LEVELS + 1))


def test_foreign_goals_have_the_same_parts_done() -> None:
    states = toy_states()
    done = states.solved.copy()
    done[states.first[1:] - 1, 0] = np.arange(len(states.first) - 1) % 2 == 0
    states = states._replace(solved=done)
    data = numbered(states)
    seen = 0
    for seed in range(20):
        clean, known = data.draw(32, np.random.default_rng(seed))
        own = clean[known.foreign, -1, 0].long().numpy()
        other = known.goal[known.foreign, 0].long().numpy()
        assert (done[own] == done[other]).all()
        seen += int((own != other).sum())
    assert seen > 50


def test_the_chain_most_like_the_others_is_kept() -> None:
    chains = torch.tensor([0.0, 10.0, 1.0, 2.0, -9.0])[:, None, None].expand(-1, 3, 2)
    assert torch.equal(Generator._most_alike(chains, torch.ones(2)), chains[2])
    unlike = torch.stack([chains[..., 0], chains[[1, 2, 0, 3, 4], :, 0]], dim=-1)
    for shares, kept in (((1.0, 0.0), 2), ((0.0, 1.0), 1)):
        assert torch.equal(Generator._most_alike(unlike, torch.tensor(shares)), unlike[kept])


def test_latents_are_those_of_the_states(networks: Networks) -> None:
    states = toy_states(3)
    latents = encode_states(states, networks.latent)
    features = torch.from_numpy(states.features[[4]].astype(np.float32))
    with torch.no_grad():
        one = networks.latent.encode(features, torch.from_numpy(CANONICAL))
    torch.testing.assert_close(latents[[4]], one, atol=1e-5, rtol=1e-5)


def test_a_killed_run_goes_on_to_the_same_weights(networks: Networks, tmp_path: Path) -> None:
    states, latent = toy_states(5), networks.latent
    config = TrainingConfig(steps=20, save_every=5, log_every=5)
    whole = train_diffusion(states, latent, SMALL, config, tmp_path / "a", about={}).model
    with pytest.raises(KilledError):
        train_diffusion(states, latent, SMALL, config, tmp_path / "b", about={}, seen=kill_at(10))
    again = train_diffusion(states, latent, SMALL, config, tmp_path / "b", about={}).model
    saved = [load_diffusion(tmp_path / run) for run in ("a", "b")]
    for one, other in ((whole, again), saved):
        kept = other.state_dict()
        assert all(torch.equal(value, kept[name]) for name, value in one.state_dict().items())


def test_a_network_that_moves_to_a_device_leaves_the_code_of_the_data(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    losses = []

    def one_batch(network: Network, loss: Loss, *args: object, **rest: object) -> None:
        network.make().to("meta")
        losses.append(loss(network.make(), np.random.default_rng(0))["loss"])

    monkeypatch.setattr(train, "train_network", one_batch)
    latent = LatentModel(LATENT).eval()
    train_diffusion(toy_states(5), latent, SMALL, TrainingConfig(steps=1), tmp_path, about={})
    assert float(losses[0].detach()) > 0


@pytest.mark.parametrize(
    ("config", "wrong"),
    [
        (ChainConfig, {"chains": 0}),
        (ChainConfig, {"reachable": 0.0}),
        (DiffusionConfig, {"width": 50}),
        (DiffusionConfig, {"layers": 0}),
        (DiffusionConfig, {"places": -1}),
    ],
)
def test_wrong_settings_are_refused(config: type, wrong: dict[str, float]) -> None:
    needed = {"latent": 8, "scene_features": 4, "points": 12, "scene_tokens": 2}
    sizes = needed if config is DiffusionConfig else {}
    with pytest.raises(InvalidOptionError, match=next(iter(wrong))):
        config(**{**sizes, **wrong})


def test_only_the_first_scene_tokens_are_read(networks: Networks) -> None:
    data = numbered(toy_states())
    chains = data.draw(4, np.random.default_rng(0))
    time = torch.zeros(4, dtype=torch.long)

    def answer(scene: torch.Tensor) -> torch.Tensor:
        with torch.no_grad():
            found: torch.Tensor = networks.denoiser(
                chains.clean, time, chains.known._replace(scene=scene)
            )
        return found

    scene = chains.known.scene
    more = torch.cat([scene, torch.full((4, 5, scene.shape[-1]), 3.0)], dim=1)
    assert torch.equal(answer(more), answer(scene))
    assert not torch.equal(answer(scene + 1.0), answer(scene))


def test_chains_may_have_no_places(networks: Networks, tmp_path: Path) -> None:
    states, config = toy_states(5), dataclasses.replace(SMALL, places=0)
    training = TrainingConfig(steps=3, log_every=1)
    trained = train_diffusion(states, networks.latent, config, training, tmp_path, about={})
    assert trained.terms["places"] == 0.0
    assert trained.terms["loss"] == trained.terms["latents"] > 0
    denoiser = load_diffusion(tmp_path)
    given = task(networks)
    wanted = given._replace(now=given.now[:8], goal=given.goal[:8])
    found = Generator(denoiser, networks.latent, ChainConfig(chains=2)).generate(
        wanted, np.random.default_rng(0)
    )
    assert found.clouds is None
    assert found.latents.shape == (LONGEST, 8)


def test_a_code_keeps_latents_and_places(networks: Networks) -> None:
    states = toy_states()
    code, latents = networks.denoiser.code, encode_states(states, networks.latent)
    first = states.first[states.episode]
    clouds = torch.from_numpy(states.frame(first).place(states.clouds)).float()
    vectors = code.join(latents, clouds)
    torch.testing.assert_close(code.latents(vectors), latents, atol=1e-4, rtol=1e-4)
    # A bar that only moves is two numbers; four components keep it whole.
    torch.testing.assert_close(code.clouds(vectors), clouds, atol=1e-3, rtol=0.0)
    torch.testing.assert_close(vectors.mean(dim=0), torch.zeros(12), atol=1e-3, rtol=0.0)
    unknown = code.join(latents, None)
    assert torch.equal(unknown[:, :8], vectors[:, :8])
    assert not unknown[:, 8:].any()
    assert float(code.shares[:8].sum()) == pytest.approx(1.0)
    assert float(code.shares[8:].sum()) == pytest.approx(1.0)
