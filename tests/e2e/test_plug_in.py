"""What docs/plug-in.md shows, done from a shell: other people's packages and models."""

from __future__ import annotations

import base64
import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from icd_envs import ENV_IDS
from tests.bench.packages import install

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "pull-agent"
DOCS = (ROOT / "docs" / "plug-in.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example, installed with pip, and a broken package beside it."""
    folder = tmp_path_factory.mktemp("site packages")
    source = shutil.copytree(EXAMPLE, tmp_path_factory.mktemp("source") / "pull-agent")
    options = ["--no-deps", "--no-build-isolation", "--no-index", "--quiet", "--target"]
    pip = [sys.executable, "-m", "pip", "install", "--disable-pip-version-check", *options]
    done = subprocess.run([*pip, folder, source], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    install(folder, "toy_rotten", "import os\nos._exit(9)", rotten="toy_rotten:Agent")
    return folder


def icd_bench(site: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(site), str(ROOT), os.environ.get("PYTHONPATH", "")])
    return subprocess.run(
        [sys.executable, "-m", "benchmarks", *map(str, arguments)],
        capture_output=True, text=True, check=False, timeout=280,
        env={**os.environ, "PYTHONPATH": path, "COLUMNS": "200"}, cwd=site,
    )  # fmt: skip


def test_docs_show_the_package_as_it_is() -> None:
    for file in ("pull_agent.py", "pyproject.toml"):
        (block,) = re.findall(rf"```\w+\n# {file}\n(.*?)```", DOCS, re.S)
        assert block.strip() in (EXAMPLE / file).read_text(encoding="utf-8")
    assert len((EXAMPLE / "pull_agent.py").read_text().splitlines()) <= 25


def test_docs_name_only_options_that_exist() -> None:
    commands = re.findall(r"icd-bench (\S+) (--?[^`\n#]*|[^`\n#]* --[^`\n#]*)", DOCS)
    assert len(commands) >= 3
    for verb, words in commands:
        shown = icd_bench(ROOT, verb, "--help").stdout
        assert all(word in shown for word in words.split() if word.startswith("--"))


def test_list_shows_the_plugin_and_the_broken_one(site: Path) -> None:
    listed = icd_bench(site, "list")
    assert listed.returncode == 0, listed.stderr
    text = " ".join(re.sub("[│┃]", " ", listed.stdout).split())
    assert "pull plug-in of pull-agent 1.0.0: pull_agent:PullAgent; works" in text
    assert "rotten plug-in of toy_rotten 1.0: toy_rotten:Agent; BROKEN" in text
    assert "exit status 9" in text
    assert "pc-mppi" in text


def test_plugin_gets_a_row_in_the_table_and_its_version_in_the_manifest(
    site: Path, tmp_path: Path
) -> None:
    task = ("--env", ENV_IDS[0], "--episodes", 1, "--out", tmp_path / "out", "--json")
    ran = icd_bench(site, "run", "--agent", "pull", "--agent", "random", *task)
    assert ran.returncode == 0, ran.stderr
    pull, random = json.loads(ran.stdout)
    assert (pull["agent"], pull["episodes"], pull["errors"]) == ("pull", 1, 0)
    assert random["agent"] == "random"
    settings = json.loads((tmp_path / "out" / "manifest.json").read_text())["settings"]
    assert re.match(r"pull-agent 1\.0\.0, .* sha256:[0-9a-f]{64}$", settings["agent pull"])


def test_broken_plugin_is_refused_before_anything_runs(site: Path, tmp_path: Path) -> None:
    task = ("--env", ENV_IDS[0], "--out", tmp_path / "out")
    ran = icd_bench(site, "run", "--agent", "random", "--agent", "rotten", *task)
    assert (ran.returncode, ran.stdout) == (2, "")
    assert "'rotten'" in ran.stderr
    assert not (tmp_path / "out").exists()


def test_example_keeps_the_contract_and_a_liar_does_not(site: Path, tmp_path: Path) -> None:
    sound = icd_bench(site, "check-agent", "pull", "--json")
    assert sound.returncode == 0, sound.stdout
    assert set(json.loads(sound.stdout).values()) == {""}
    (tmp_path / "liar.py").write_text("def act(observation): return [0.0, 9.0, 0.0]")
    wrong = icd_bench(site, "check-agent", f"fn:{tmp_path / 'liar.py'}:act")
    assert wrong.returncode == 1
    assert "WRONG: [0.0, 9.0, 0.0] would be clipped" in wrong.stdout


def test_payload_of_an_untrusted_model_is_never_run(site: Path, tmp_path: Path) -> None:
    payload = f"cbuiltins\nopen\n(S'{tmp_path / 'owned'}'\nS'w'\ntR.".encode()
    data = {"policy_class": {":type:": "x", ":serialized:": base64.b64encode(payload).decode()}}
    with zipfile.ZipFile(tmp_path / "model.zip", "w") as archive:
        archive.writestr("data", json.dumps({"target_entropy": -3.0, **data}))
    spec = f"sb3:{tmp_path / 'model.zip'}"
    refused = icd_bench(site, "run", "--agent", spec, "--out", tmp_path / "out")
    assert (refused.returncode, refused.stdout) == (2, "")
    assert "--trust-pickle" in refused.stderr
    assert not (tmp_path / "owned").exists()
    icd_bench(site, "check-agent", spec, "--trust-pickle")
    assert (tmp_path / "owned").exists(), "the payload must be one that works"
