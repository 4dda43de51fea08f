"""A checkout without changes, whose fingerprint takes no time."""

import pytest


@pytest.fixture(autouse=True)
def _clean_checkout(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("benchmarks.provenance.git_state", lambda: ("abc", False))
    monkeypatch.setattr("benchmarks.provenance.code_fingerprint", lambda: "sha256:abc")
