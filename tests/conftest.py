"""Hypothesis profiles, and whole files for each process where tests run in several."""

import gc
import os
import signal
import sys

# before NumPy is imported: the processes of the tests would only wait for each other's threads
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# every number the same whatever has been tested before; the tests of compiled code ask for it
os.environ.setdefault("KINETOSTATICS_ENGINE", "numpy")

import pytest
from hypothesis import HealthCheck, settings
from selection import in_part, without_skips

_SLOW = [HealthCheck.too_slow, HealthCheck.filter_too_much, HealthCheck.data_too_large]

# few examples, new ones every time, and the same ones where CI is set; many with HYPOTHESIS_PROFILE=thorough
settings.register_profile("default", deadline=None, max_examples=4, suppress_health_check=_SLOW)
settings.register_profile("ci", parent=settings.get_profile("default"), derandomize=True)
settings.register_profile("thorough", parent=settings.get_profile("default"), max_examples=400)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci" if os.environ.get("CI") == "true" else "default"))


os.environ.pop("FORCE_COLOR", None)  # texts are compared to the letter

# or each of the hundreds of processes that are started compiles all modules anew
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# a shell that starts the tests in the background lets their programs ignore Ctrl-C, which some tests send
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def by_numpy(monkeypatch):
    """Fix the engine, for what is about NumPy's own way; all else also passes where ``KINETOSTATICS_ENGINE=compiled`` is set."""
    monkeypatch.setenv("KINETOSTATICS_ENGINE", "numpy")


@pytest.fixture
def no_figures_left():
    """Close all figures of Matplotlib after a test."""
    from matplotlib import pyplot as plt

    yield
    plt.close("all")


# what importing and collecting makes stays to the end: to look through it again and again takes a fifth of the time of both
gc.disable()


def pytest_collection_finish():
    gc.freeze()
    gc.set_threshold(100_000, 20, 50)  # robots and XML are many small objects: by default 6 % of all time goes there
    gc.enable()


def pytest_addoption(parser):
    parser.addoption("--part", type=int, help="of the slow tests run the part with this number (mod 10, or as their mark says)")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """Put the short files of ``tests/unit`` last, so that no process waits long for another one's last file.

    Of the cases of a test that is marked ``few(n)`` all but n of the quick ones, evenly spread, are slow.
    """
    items.sort(key=lambda item: "unit" in item.path.parts)
    cases = {}
    for item in items:
        if item.get_closest_marker("few"):
            cases.setdefault(item.nodeid.partition("[")[0], []).append(item)
    for tests in cases.values():
        quick = [item for item in tests if not item.get_closest_marker("slow")]
        number = min(*tests[0].get_closest_marker("few").args, len(quick))
        kept = {quick[round(k * (len(quick) - 1) / max(number - 1, 1))] for k in range(number)}
        for item in quick:
            if item not in kept:
                item.add_marker("slow")
    number = config.getoption("part")
    if number is not None:
        slow = {item: item.get_closest_marker("parts") for item in items if item.get_closest_marker("slow")}
        others = [item for item, mark in slow.items() if not in_part(item.nodeid, number, *(mark.args if mark else ()))]
        config.hook.pytest_deselected(items=others)
        items[:] = [item for item in items if item not in set(others)]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport():
    return without_skips((yield))


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report():
    return without_skips((yield))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Give each process whole files, in the order of the folders: what the tests of a file share is made once."""
    from xdist.scheduler import LoadFileScheduling

    config.option.loadscopereorder = False
    return LoadFileScheduling(config, log)
