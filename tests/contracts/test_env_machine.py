"""Any order of calls, against a model: what is seen depends on seed and actions alone."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from icd_envs.api import Observation, SimState
from icd_envs.errors import (
    EpisodeStateError,
    IncompatibleStateError,
    InvalidActionError,
    RenderingUnavailableError,
)
from icd_envs.tasks.env import ContactEnv
from tests.envs.making import VARIANTS, digest, make, random_actions, state_bits

History = tuple[Any, ...]
"""The seed of the last reset and the actions since, by number."""

ACTIONS = random_actions(11, 3)
SEEDS = st.sampled_from([0, 1])
CHOICES = st.integers(0, len(ACTIONS) - 1)
FEW = settings(
    max_examples=2,  # after the script, which has called every rule
    stateful_step_count=16,
    deadline=None,
    phases=[Phase.explicit, Phase.reuse, Phase.generate],  # to shrink a failure takes minutes
    suppress_health_check=list(HealthCheck),
)

SCRIPT: list[tuple[str, dict[str, Any]]] = [
    ("reset", {"seed": 0}),
    ("snapshot", {}),
    ("step", {"choices": [0, 1]}),
    ("snapshot", {}),
    ("roll_out", {"choice": 2}),
    ("render", {}),
    ("step", {"choices": [2]}),
    ("restore", {"number": 1}),
    ("step", {"choices": [2, 0]}),
    ("reset", {"seed": 1}),
    ("restore", {"number": 0}),  # of the other scene
    ("step", {"choices": [0]}),
    ("snapshot", {}),
    ("close", {}),
    ("begin_again", {}),
    ("reset", {"seed": 0}),
    ("restore", {"number": 1}),  # of the closed environment
    ("step", {"choices": [2, 0]}),
]
"""Every rule at least once, those for what is foreign and what is closed among them."""


class EnvMachine(RuleBasedStateMachine):
    """One environment, and what its history says about it."""

    variant: ClassVar[tuple[str, dict[str, Any]]]
    seen: ClassVar[dict[History, str]]
    """What any environment of this variant showed after each history."""

    def __init__(self) -> None:
        super().__init__()
        self.env = self.made()
        self.history: History | None = None
        self.snapshots: list[tuple[History, SimState]] = []
        self.closed = False
        self.pictures = 0

    def made(self) -> ContactEnv[Any]:
        env_id, options = self.variant
        return make(env_id, render_mode="rgb_array", width=32, height=24, **options)

    def arrive(self, history: History, observation: Observation) -> None:
        """The same history has always shown the same."""
        self.history = history
        assert self.env.observation_space.contains(observation)
        bits = digest([observation])
        assert self.seen.setdefault(history, bits) == bits

    # A reset right after a reset is rare: it costs as much as a hundred steps.
    @precondition(lambda self: not self.closed and len(self.history or "abc") > 2)
    @rule(seed=SEEDS)
    def reset(self, seed: int) -> None:
        observation, info = self.env.reset(seed=seed)
        assert not info["diverged"]
        self.arrive((seed,), observation)

    @precondition(lambda self: self.history and not self.closed)
    @rule(choices=st.lists(CHOICES, min_size=1, max_size=3))
    def step(self, choices: list[int]) -> None:
        for choice in choices:
            observation, reward, terminated, truncated, info = self.env.step(ACTIONS[choice])
            assert (terminated, truncated, info["diverged"]) == (False, False, False)
            assert reward in (-1.0, 0.0)
            assert self.history is not None
            self.arrive((*self.history, choice), observation)

    @precondition(lambda self: self.history and not self.closed)
    @rule()
    def snapshot(self) -> None:
        assert self.history is not None
        state = self.env.snapshot()
        assert state.steps == len(self.history) - 1
        self.snapshots.append((self.history, state))

    @precondition(lambda self: self.snapshots and self.history and not self.closed)
    @rule(number=st.integers(0, 99))
    def restore(self, number: int) -> None:
        history, state = self.snapshots[number % len(self.snapshots)]
        assert self.history is not None
        if history[0] != self.history[0]:
            with pytest.raises(IncompatibleStateError):
                self.env.restore(state)
        else:
            self.arrive(history, self.env.restore(state))

    @precondition(lambda self: self.history and not self.closed)
    @rule(choice=CHOICES)
    def roll_out(self, choice: int) -> None:
        with pytest.raises(InvalidActionError):
            self.env.step(np.full(3, np.nan))
        simulator = self.env.episode(simulator=True).simulator
        assert simulator is not None
        assert not simulator.rollout(self.env.snapshot(), ACTIONS[None, [choice]]).diverged.any()

    # Without a GPU a picture costs as much as a reset.
    @precondition(lambda self: self.history and not self.closed and self.pictures < 2)
    @rule()
    def render(self) -> None:
        self.pictures += 1
        before = state_bits(self.env)
        try:
            picture = self.env.render()
        except RenderingUnavailableError:
            pass  # no OpenGL here: all else must go on
        else:
            assert picture is not None
            assert picture.shape == (24, 32, 3)
        assert state_bits(self.env) == before

    @precondition(lambda self: not self.closed and len(self.snapshots) > 2)
    @rule()
    def close(self) -> None:
        self.env.close()
        self.closed = True

    @precondition(lambda self: self.closed)
    @rule()
    def begin_again(self) -> None:
        """A new environment takes the snapshots of the old one."""
        self.env, self.history, self.closed = self.made(), None, False

    @invariant()
    def calls_out_of_order_are_refused(self) -> None:
        if self.closed or self.history is None:
            env = self.env
            for call in (env.snapshot, env.episode, env.render, lambda: env.step(np.zeros(3))):
                with pytest.raises(EpisodeStateError):
                    call()
        if self.closed:
            self.env.close()
            with pytest.raises(EpisodeStateError):
                self.env.reset(seed=0)

    def teardown(self) -> None:
        self.env.close()


def run_script(machine: EnvMachine) -> None:
    """Call the rules as ``SCRIPT`` says, each where it may be called."""
    rules = {rule.function.__name__: rule for rule in machine.rules}
    assert {name for name, _ in SCRIPT} == set(rules)
    for name, arguments in SCRIPT:
        assert all(holds(machine) for holds in rules[name].preconditions), name
        getattr(machine, name)(**arguments)
        machine.calls_out_of_order_are_refused()


@pytest.mark.parametrize("variant", VARIANTS, ids=str)
def test_any_order_of_calls_agrees_with_the_model(variant: tuple[str, dict[str, Any]]) -> None:
    machine = type("Machine", (EnvMachine,), {"variant": variant, "seen": {}})
    run_script(machine())
    assert len(machine.seen) == 7
    run_state_machine_as_test(machine, settings=FEW)
