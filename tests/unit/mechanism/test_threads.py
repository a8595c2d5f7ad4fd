"""Robots that several threads make at a time."""

import os
import time
from concurrent.futures import ThreadPoolExecutor

import package_robots

from kinetostatics.mechanism.mechanism import Mechanism


def test_standard_error_survives_threads_that_make_robots(monkeypatch):
    """Pinocchio's parser is silenced on the file descriptor, of which there is one in a process; others come in between."""
    description, dup2 = package_robots.robot("five_bar").description, os.dup2
    before = os.fstat(2)
    monkeypatch.setattr(os, "dup2", lambda *files: (dup2(*files), time.sleep(2e-3)))
    with ThreadPoolExecutor(4) as pool:
        made = [pool.submit(lambda: [Mechanism(description).model for _ in range(4)]) for _ in range(4)]
    assert all(len(item.result()) == 4 for item in made)
    after = os.fstat(2)
    assert (after.st_dev, after.st_ino) == (before.st_dev, before.st_ino)
