"""Links of the documentation lead somewhere, and the commands that it shows exist."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Any

import pytest
import typer

from benchmarks.cli import main

ROOT = Path(__file__).parents[2]
PAGES = [
    *(ROOT / f"{name}.md" for name in ("README", "CONTRIBUTING", "CHANGELOG")),
    *sorted((ROOT / "docs").rglob("*.md")),
]
ICD_BENCH: Any = typer.main.get_command(main)
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.M | re.S)


def name(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def text(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def links(page: Path) -> list[str]:
    """Where the page leads, but for other sites."""
    prose = re.sub(r"`[^`]*`", "", FENCE.sub("", text(page)))
    targets = re.findall(r"\]\(([^)\s]+)\)", prose)
    return [target for target in targets if not re.match(r"\w+:", target)]


def anchors(page: Path) -> set[str]:
    """Names that GitHub gives to the page's headings."""
    found: list[str] = []
    for heading in re.findall(r"^#+ (.+)$", FENCE.sub("", text(page)), re.M):
        shown = re.sub(r"\[(.*?)\]\(.*?\)", r"\1", heading).strip()
        slug = re.sub(r"[^\w\- ]", "", shown.lower()).replace(" ", "-")
        found.append(slug)
    counted = [(slug, found[:i].count(slug)) for i, slug in enumerate(found)]
    return {f"{slug}-{before}" if before else slug for slug, before in counted}


def shown(page: Path) -> list[list[str]]:
    """Arguments of every command in the page's shell blocks."""
    lines = [
        line
        for language, block in FENCE.findall(text(page))
        if language == "bash"
        for line in block.replace("\\\n", " ").splitlines()
    ]
    commands = [re.search(r"(?:^|; do )icd-bench (.*?)(?:; done)?$", line) for line in lines]
    return [
        shlex.split(command[1].replace("$seed", "1"), comments=True)
        for command in commands
        if command is not None
    ]


def mentioned(page: Path) -> list[str]:
    """Every command in the page's running text, often in part."""
    return re.findall(r"`icd-bench ([^`]+)`", FENCE.sub("", text(page)))


def unknown(mention: str) -> list[str]:
    """Commands and options that there are not; bars stand between alternatives."""
    group, command, missing = ICD_BENCH, ICD_BENCH, []
    for part in mention.split(" | "):
        words = part.split()
        if not words[0].startswith("--"):
            command = ICD_BENCH if words[0] in ICD_BENCH.commands else group
        while hasattr(command, "commands") and words and not words[0].startswith("--"):
            group, first = command, words.pop(0)
            if first not in group.commands:
                return [*missing, first]
            command = group.commands[first]
        known = {"--help"}.union(*(known.opts + known.secondary_opts for known in command.params))
        missing += [word for word in words if word.startswith("--") and word not in known]
    return missing


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_lead_to_files_and_headings(page: Path) -> None:
    for target in links(page):
        file, _, anchor = target.partition("#")
        there = (page.parent / file).resolve() if file else page
        assert there.exists(), f"{target}: no such file"
        assert not anchor or anchor in anchors(there), f"{target}: no such heading"


@pytest.mark.parametrize("page", [page for page in PAGES if shown(page)], ids=name)
def test_commands_that_are_shown_are_understood(page: Path) -> None:
    for words in shown(page):
        command = ICD_BENCH
        while hasattr(command, "commands"):
            assert words[0] in command.commands, words
            command, words = command.commands[words[0]], words[1:]
        command.make_context("icd-bench", words)


@pytest.mark.parametrize("page", [page for page in PAGES if mentioned(page)], ids=name)
def test_commands_that_are_mentioned_exist(page: Path) -> None:
    for mention in mentioned(page):
        assert unknown(mention) == [], mention


@pytest.mark.parametrize(
    ("mention", "missing"),
    [
        ("run --out runs/mine --env ID", []),
        ("rum", ["rum"]),
        ("run --outlook", ["--outlook"]),
        ("train field --out", []),
        ("train feld", ["feld"]),
        ("list | run | rum", ["rum"]),
        ("train latent | diffusion | train fields", ["fields"]),
        ("report --html | --csv | --cvs", ["--cvs"]),
        ("--help", []),
    ],
)
def test_what_is_missing_is_found(mention: str, missing: list[str]) -> None:
    assert unknown(mention) == missing


def test_there_is_something_to_look_at() -> None:
    assert sum(len(links(page)) for page in PAGES) > 100
    assert sum(len(shown(page)) for page in PAGES) > 50
    assert sum(len(mentioned(page)) for page in PAGES) > 30
