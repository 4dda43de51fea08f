from __future__ import annotations

from docs.tasks import docstrings


class Base:
    """What it is.

    More of it, with ``code``.

    Reward: ``sparse``: 0 on success,
    else -1.

    End of episode: never.

    Version history:
        v0: first.
    """

    def __init__(self, size: int, name: str) -> None:
        """Make it.

        Args:
            size: [m] how
                large: about so.
            name: ``a`` or ``b``.

        Raises:
            ValueError: on something else.
        """

    def parameters(self) -> None:
        """``table``: (6,) its pose,
        and height [m].
        ``clips``: (F, 3) poses.
        """


class Derived(Base):
    """Something else.

    Version history:
        v0: another.
    """

    def parameters(self) -> None:
        pass


# The docstrings of other packages, of a library's base class say, are not ours to show.
Base.__module__ = Derived.__module__ = "icd_envs.toy"


class Foreign(Derived):
    """From elsewhere.

    Reward: none.
    """


def test_summary_is_what_comes_under_no_title() -> None:
    assert docstrings.summary(Base) == "What it is.\n\nMore of it, with `code`."
    assert docstrings.summary(Derived) == "Something else."


def test_sections_are_inherited_and_overridden_in_order() -> None:
    expected = {
        "Reward": "`sparse`: 0 on success, else -1.",
        "End of episode": "never.",
        "Version history": "v0: first.",
    }
    assert list(docstrings.sections(Base).items()) == list(expected.items())
    assert docstrings.sections(Derived) == expected | {"Version history": "v0: another."}
    assert docstrings.sections(Foreign) == docstrings.sections(Derived)


def test_entries_are_arguments_by_name_and_nothing_else() -> None:
    said = {"size": "[m] how large: about so.", "name": "`a` or `b`."}
    assert docstrings.entries(Base.__init__) == said


def test_named_are_texts_of_names_also_inherited() -> None:
    said = {"table": "(6,) its pose, and height [m].", "clips": "(F, 3) poses."}
    assert docstrings.named(Base.parameters) == said
    assert docstrings.named(Derived.parameters) == said
