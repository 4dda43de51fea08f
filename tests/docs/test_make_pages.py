from __future__ import annotations

import re
from typing import Any

import gymnasium as gym
import pytest
from PIL import Image

from docs.tasks import docstrings, make_pages
from docs.tasks.filming import FOLDER
from icd_envs import ENV_IDS
from icd_envs.api import CommonInfo, Observation, PartialObservation

CABLE = "ICDCableRouting-v0"
MOST_BYTES = 400_000
"""Of a GIF: what a reader waits for on a slow line."""


@pytest.fixture(params=ENV_IDS)
def env_id(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture
def page(env_id: str) -> str:
    return make_pages.page_path(env_id).read_text(encoding="utf-8")


def test_page_says_what_the_code_says(env_id: str, page: str) -> None:
    assert page == make_pages.make_page(env_id, page), "run: python -m docs.tasks.make_pages"


def test_page_has_its_pictures(env_id: str, page: str) -> None:
    shown = re.findall(r"\]\((img/[^)]+)\)", page)
    for kind in ("expert.gif", "expert.png", "start-and-goal.png", "success.png"):
        assert f"img/{make_pages.slug(env_id)}-{kind}" in shown
    for name in shown:
        assert (FOLDER.parent / name).exists(), f"run: python -m docs.tasks.render --env {env_id}"


def test_gif_is_small_and_moves(env_id: str) -> None:
    path = FOLDER / f"{make_pages.slug(env_id)}-expert.gif"
    assert path.stat().st_size < MOST_BYTES
    with Image.open(path) as gif:
        assert gif.size == (320, 240)
        assert gif.n_frames > 30  # type: ignore[attr-defined]


def test_numbers_in_the_docstring_are_those_of_the_task(env_id: str) -> None:
    env: Any = gym.make(env_id).unwrapped
    said = docstrings.sections(type(env))
    env.reset(seed=0)
    episode = env.episode()
    assert (
        f"{episode.action_scale} m per control step of {episode.control_period} s"
        in (said["Action"])
    )
    assert f"truncated after {episode.max_steps} steps" in said["End of episode"]
    env.close()


def test_shapes_in_the_docstring_are_those_of_the_space(env_id: str) -> None:
    env = gym.make(env_id, obs_mode="partial")
    assert isinstance(env.observation_space, gym.spaces.Dict)
    said = docstrings.entries(Observation) | docstrings.entries(PartialObservation)
    assert said.keys() == env.observation_space.keys()
    for name, space in env.observation_space.items():
        assert said[name].startswith(f"{space.shape} "), name
    env.close()


def test_common_info_is_what_every_environment_tells(env_id: str) -> None:
    env: Any = gym.make(env_id).unwrapped
    _, info = env.reset(seed=0)
    own = {prefix + name for name in env.task.parameter_names for prefix in ("", "goal_")}
    assert info.keys() == CommonInfo.__annotations__.keys() | own
    assert docstrings.entries(CommonInfo).keys() == CommonInfo.__annotations__.keys()
    assert docstrings.named(type(env.task).parameters).keys() == set(env.task.parameter_names)
    env.close()


def test_new_page_has_everything_and_stays_as_it_is(env_id: str) -> None:
    new = make_pages.make_page(env_id, None)
    assert new.startswith("# ")
    for part in (f"`{env_id}`", "### Observation", "### Info", "### Arguments", "`is_success`"):
        assert part in new
    assert make_pages.make_page(env_id, new) == new


def test_only_what_is_between_the_markers_is_written() -> None:
    page = f"before\n{make_pages.BEGIN}\nold\n{make_pages.END}\nafter\n"
    made = make_pages.make_page(CABLE, page)
    assert made.startswith(f"before\n{make_pages.BEGIN}\n")
    assert made.endswith(f"{make_pages.END}\nafter\n")
    assert "old\n" not in made
    assert "`num_fixtures` | `int` | `2` |" in made


@pytest.mark.parametrize(
    "page",
    [
        "no markers",
        make_pages.BEGIN,
        f"{make_pages.END}{make_pages.BEGIN}",
        f"{make_pages.BEGIN}{make_pages.END}" * 2,
    ],
)
def test_page_without_one_pair_of_markers_is_refused(page: str) -> None:
    with pytest.raises(ValueError, match="must hold once each"):
        make_pages.make_page(CABLE, page)


@pytest.mark.parametrize(
    ("forget", "message"),
    [("entries", "what 'observation' is"), ("named", "what 'clips' is.*CableRouting.parameters")],
)
def test_what_no_docstring_describes_is_refused(
    monkeypatch: pytest.MonkeyPatch, forget: str, message: str
) -> None:
    page = f"{make_pages.BEGIN}{make_pages.END}"
    monkeypatch.setattr(docstrings, forget, lambda thing: {})
    with pytest.raises(ValueError, match=message):
        make_pages.make_page(CABLE, page)


def test_files_are_named_after_the_task() -> None:
    assert make_pages.slug("ICDCableRoutingAdaptation-v0") == "cable-routing-adaptation"
