"""Draw the pictures that every task page has: python -m docs.tasks.render [--env ID].

One clean expert episode of a test scene: a GIF, twelve moments of it, the start with the goal in
red, and the end from every camera. Needs the extra [video]; about 20 s per environment.
"""

from __future__ import annotations

import argparse

from benchmarks.gif import contact_sheet, write_gif
from benchmarks.suites import episode_seed
from docs.tasks.filming import FOLDER, all_views, film_expert, save
from docs.tasks.make_pages import slug
from icd_envs import ENV_IDS


def draw(env_id: str, index: int) -> None:
    """All pictures of one environment.

    Args:
        env_id: which.
        index: of the test scene, as the benchmark counts them.

    Raises:
        RuntimeError: if the expert does not reach the goal.
    """
    seed = episode_seed(0, env_id, index)
    film = film_expert(env_id, seed)
    if not film.info["is_success"]:
        raise RuntimeError(f"{env_id}, index {index}: the expert failed, take another one")
    name = slug(env_id)
    write_gif(FOLDER / f"{name}-expert.gif", film.frames)
    save(f"{name}-expert", contact_sheet(film.frames))
    save(f"{name}-start-and-goal", film.frames[0])
    save(f"{name}-success", all_views(env_id, seed, film.end))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--env", choices=ENV_IDS, help="only this one")
    parser.add_argument("--index", type=int, default=3, help="of the test scene")
    options = parser.parse_args()
    for env_id in [options.env] if options.env else ENV_IDS:
        draw(env_id, options.index)
        print(env_id)
