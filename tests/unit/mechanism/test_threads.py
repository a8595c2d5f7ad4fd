"""Robots that several threads make at a time."""

import os
from concurrent.futures import ThreadPoolExecutor

import package_robots

from kinetostatics.mechanism.mechanism import Mechanism


def test_standard_error_survives_threads_that_make_robots():
    """Pinocchio's parser is silenced on the file descriptor, of which there is one in a process."""
    description = package_robots.robot("five_bar").description
    before = os.fstat(2)
    with ThreadPoolExecutor(4) as pool:
        made = [pool.submit(lambda: [Mechanism(description).model for _ in range(25)]) for _ in range(4)]
    assert all(len(item.result()) == 25 for item in made)
    after = os.fstat(2)
    assert (after.st_dev, after.st_ino) == (before.st_dev, before.st_ino)
