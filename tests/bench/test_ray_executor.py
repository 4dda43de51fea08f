"""A real Ray cluster of several nodes on this machine."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest

from benchmarks import ray_executor
from benchmarks.collect import collect
from benchmarks.errors import IncompatibleResultsError
from benchmarks.executors import InProcess, Local, Work, make_executor
from benchmarks.pulse import Pulse
from benchmarks.ray_executor import Ray
from benchmarks.results import ROWS_NAME
from benchmarks.worker import Loss
from icd_envs.errors import InvalidOptionError
from tests.bench import toy
from tests.bench.making import LIMITS, run_toys
from tests.demonstrations.making import contents, make_header

if TYPE_CHECKING:
    from ray.cluster_utils import Cluster

pytest.importorskip("ray", reason="Ray is not installed: pip install -e '.[ray]'")
ROOT = Path(__file__).parents[2]
AGENTS = (toy.Drunk, toy.Gambler, toy.Raiser, toy.Killer)
NODES = 2
NODE = {"num_cpus": 1, "object_store_memory": 80 * 2**20}


@pytest.fixture(scope="module")
def cluster() -> Iterator[Cluster]:
    """A head that does nothing, and two nodes of one core."""
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    from ray.cluster_utils import Cluster

    before = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = str(ROOT)
    cluster = Cluster(initialize_head=True, head_node_args={**NODE, "num_cpus": 0})
    for _ in range(NODES):
        cluster.add_node(**NODE)
    yield cluster
    cluster.shutdown()
    os.environ["PYTHONPATH"] = before or ""


class Place(NamedTuple):
    """Where a job was done: process of the worker, and of Ray around it."""

    job: int
    worker: int
    ray: int


def who(job: int, pulse: Pulse) -> Place:
    return Place(job, os.getpid(), os.getppid())


def meet(job: int, pulse: Pulse, folder: Path) -> Place:
    """Waits until jobs have come to as many of Ray's processes as there are nodes."""
    place = who(job, pulse)
    (folder / str(place.ray)).touch()
    while len(list(folder.iterdir())) < NODES:
        time.sleep(0.01)
    return place


def lost(job: int, loss: Loss) -> Place:
    raise AssertionError(str(loss))


def test_rows_on_a_cluster_are_the_rows_of_one_worker(cluster: Cluster, tmp_path: Path) -> None:
    alone = run_toys(tmp_path / "alone", *AGENTS, executor=Local(1))
    limits = replace(LIMITS, act_seconds=5.0)
    ray = Ray(cluster.address)
    assert ray.threads == 1
    rows = run_toys(tmp_path / "ray", *AGENTS, executor=ray, limits=limits)
    assert [row.to_line() for row in rows] == [row.to_line() for row in alone]
    assert {row.message for row in rows} >= {"act, step 0: worker died (exit status 11)"}


def test_jobs_go_to_every_node_and_groups_keep_their_process(
    cluster: Cluster, tmp_path: Path
) -> None:
    work = Work(partial(meet, folder=tmp_path), lost, lambda job: str(job % 2), seconds=60.0)
    places = list(Ray(cluster.address).execute(work, range(12)))
    assert sorted(place.job for place in places) == list(range(12))
    assert len({place.ray for place in places}) == NODES
    groups = {(place.ray, place.job % 2) for place in places}
    workers = {(place.ray, place.job % 2, place.worker) for place in places}
    assert len(workers) == len(groups) == len({place.worker for place in places})


@pytest.mark.slow
def test_demonstrations_are_the_same_bytes(cluster: Cluster, tmp_path: Path) -> None:
    header = make_header(episodes=4)
    collect(header, tmp_path / "here", InProcess())
    collect(header, tmp_path / "ray", Ray(cluster.address))
    assert contents(tmp_path / "ray") == contents(tmp_path / "here")


@pytest.mark.slow
def test_node_that_dies_in_the_middle_costs_nothing(cluster: Cluster, tmp_path: Path) -> None:
    alone = run_toys(tmp_path / "alone", toy.Slow, n=12, executor=Local(1))
    doomed = cluster.add_node(**NODE)

    class Killer:
        """Kills the node after the fourth row."""

        def __init__(self, total: int, finished: object) -> None:
            self.seen = 0

        def __enter__(self) -> Killer:
            return self

        def __exit__(self, *error: object) -> None:
            assert self.seen == 12

        def __call__(self, row: object) -> None:
            self.seen += 1
            if self.seen == 4:
                cluster.remove_node(doomed, allow_graceful=False)

    rows = run_toys(tmp_path / "ray", toy.Slow, n=12, executor=Ray(cluster.address), watch=Killer)
    assert rows == alone
    assert (tmp_path / "ray" / ROWS_NAME).read_bytes().count(b"\n") == 12


def test_node_of_another_version_is_refused(
    cluster: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ray_executor, "code_fingerprint", lambda: "sha256:other")
    with pytest.raises(IncompatibleResultsError, match=r"code: 'sha256:other' where.*every node"):
        run_toys(tmp_path, toy.Straight, executor=Ray(cluster.address))


@pytest.mark.slow
def test_command_line_on_a_cluster(cluster: Cluster, tmp_path: Path) -> None:
    run = ["run", "--agent", toy.spec(toy.Chatty), "--env", toy.ENV, "--episodes", "3"]
    where = ["--executor", "ray", "--address", cluster.address, "--out", str(tmp_path / "a")]
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks", *run, *where, "--json"],
        capture_output=True, text=True, check=False, cwd=ROOT, timeout=240,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    (record,) = json.loads(done.stdout)
    assert (record["episodes"], record["errors"], record["success"]) == (3, 0, 1.0)


@pytest.mark.slow
def test_interrupt_on_a_cluster_prints_the_partial_table(cluster: Cluster, tmp_path: Path) -> None:
    agents = ["--agent", toy.spec(toy.Drunk), "--agent", toy.spec(toy.Sleeper)]
    run = ["run", *agents, "--env", toy.ENV, "--episodes", "3", "--out", str(tmp_path), "--json"]
    where = ["--executor", "ray", "--address", cluster.address]
    process = subprocess.Popen(
        [sys.executable, "-m", "benchmarks", *run, *where],
        cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    deadline = time.monotonic() + 200.0
    while not (tmp_path / ROWS_NAME).exists():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.05)
    begun = time.monotonic()
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 143, err
    assert time.monotonic() - begun < 5.0
    assert 1 <= sum(record["episodes"] for record in json.loads(out)) <= 3


@pytest.mark.parametrize(
    ("options", "message"),
    [({"workers": 0}, "--executor local"), ({"address": "127.0.0.1:1"}, "no Ray cluster")],
)
def test_what_ray_cannot_do_is_explained(options: dict[str, object], message: str) -> None:
    defaults = {"workers": None, "threads": None, "address": None}
    with pytest.raises(InvalidOptionError, match=message):
        list(make_executor("ray", **{**defaults, **options}).execute(Work(who, lost), [1]))


def test_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ray_executor, "find_spec", lambda name: None)
    with pytest.raises(InvalidOptionError, match=r"implicit-contact-diffuser\[ray\]"):
        Ray()
