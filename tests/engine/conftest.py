"""Tests of compiled code, which store it in a temporary folder."""

import pytest


@pytest.fixture(autouse=True)
def cache(tmp_path_factory, monkeypatch):
    folder = tmp_path_factory.getbasetemp() / "code"
    monkeypatch.setenv("KINETOSTATICS_CACHE", str(folder))
    monkeypatch.delenv("KINETOSTATICS_ENGINE", raising=False)
    return folder
