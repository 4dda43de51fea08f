"""What docstrings say, by name: the words of the task pages."""

from __future__ import annotations

import inspect
import re

from docstring_parser import google


def summary(thing: type) -> str:
    """First paragraph and those after it, up to the first section."""
    paragraphs = _paragraphs(thing)
    kept = [text for text in paragraphs if _titled(text) is None]
    return "\n\n".join(markdown(text) for text in kept)


def sections(thing: type) -> dict[str, str]:
    """Paragraphs that begin with a title and a colon; those of a subclass come before its bases'.

    Args:
        thing: a class whose docstring holds paragraphs like ``Reward: 0 on success, else -1.``
    """
    found: dict[str, str] = {}
    for each in reversed(inspect.getmro(thing)):
        if each.__module__.partition(".")[0] == "icd_envs":
            titled = [_titled(text) for text in _paragraphs(each)]
            found |= {one["title"]: markdown(one["text"]) for one in titled if one is not None}
    return found


def entries(thing: object) -> dict[str, str]:
    """``Args:`` or ``Attributes:`` of a docstring, by name."""
    parsed = google.parse(inspect.getdoc(thing) or "")
    return {one.arg_name: markdown(one.description or "") for one in parsed.params}


def named(thing: object) -> dict[str, str]:
    """Names in double backquotes at the start of a line, each with the text after the colon."""
    text = inspect.getdoc(thing) or ""
    pairs = re.findall(r"^``(\w+)``: (.*?)(?=^``\w+``:|\Z)", text, re.M | re.S)
    return {name: markdown(words) for name, words in pairs}


def markdown(text: str) -> str:
    """One line, with code in single backquotes."""
    return " ".join(text.replace("``", "`").split())


def _paragraphs(thing: type) -> list[str]:
    return inspect.cleandoc(thing.__doc__ or "").split("\n\n")


def _titled(paragraph: str) -> re.Match[str] | None:
    return re.match(r"(?P<title>[A-Z][A-Za-z ]*):\s+(?P<text>.+)", paragraph, re.S)
