"""Tests of compiled code, which store it in a temporary folder."""

import resource

import pytest

from kinetostatics.engine import llvm


@pytest.fixture(autouse=True)
def cache(tmp_path_factory, monkeypatch):
    folder = tmp_path_factory.getbasetemp() / "code"
    monkeypatch.setenv("KINETOSTATICS_CACHE", str(folder))
    monkeypatch.delenv("KINETOSTATICS_ENGINE", raising=False)
    return folder


@pytest.fixture
def compiling(cache, monkeypatch):
    """Return a function that lets robots be compiled at one level of optimization, into a folder of its own.

    Without optimization all results of operations are on the stack, which may become larger than by default.
    """
    compiled = llvm.compiled
    resource.setrlimit(resource.RLIMIT_STACK, (2**27, resource.getrlimit(resource.RLIMIT_STACK)[1]))

    def at(level):
        monkeypatch.setattr(llvm, "compiled", lambda text, _: compiled(text, level))
        monkeypatch.setenv("KINETOSTATICS_CACHE", str(cache / f"level_{level}"))

    return at
