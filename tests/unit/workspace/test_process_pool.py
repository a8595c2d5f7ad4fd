"""Work that is shared out to other processes: what each does comes once, also where some of them die."""

from concurrent.futures import BrokenExecutor, Future
from functools import partial
from types import SimpleNamespace

import pytest

from kinetostatics.exceptions import KinetostaticsError
from kinetostatics.workspace.process_pool import ATTEMPTS, ProcessPool


class Executors:
    """Stands for loky's: each does so many pieces of work, one after the other, and then dies with all that is at hand."""

    def __init__(self, *lives):
        self.lives = list(lives)

    def start(self):
        self.left, self.most = self.lives.pop(0), 0
        return self

    def submit(self, work, task):
        future = Future()
        future.task = task
        return future

    def wait(self, futures, return_when):
        self.most, first = max(self.most, len(futures)), next(iter(futures))
        if self.left > 0:
            first.set_result(first.task())
        else:
            first.set_exception(BrokenExecutor())
        self.left -= 1
        return SimpleNamespace(done={first})

    def shutdown(self, kill_workers):
        assert kill_workers


@pytest.fixture
def numbers_done(monkeypatch):
    def perform(executors, count):
        monkeypatch.setattr(ProcessPool, "_start", lambda pool: executors.start())
        monkeypatch.setattr("kinetostatics.workspace.process_pool.wait", executors.wait)
        with ProcessPool(None, None, 2) as pool:
            found = list(pool.perform(partial(pow, k, 2) for k in range(count)))
        assert all(value == number**2 for number, value in found)
        return sorted(number for number, _ in found)

    return perform


def test_each_piece_of_work_is_done_once_and_few_are_at_hand(numbers_done):
    executors = Executors(100)
    assert numbers_done(executors, 20) == list(range(20))
    assert executors.most == 4  # one in work and one at hand for each process


def test_what_processes_lose_is_done_again_by_others(numbers_done):
    """Any number of processes may die after they have done something, and then all but the last attempt."""
    lives = [1] * (3 * ATTEMPTS) + [0] * (ATTEMPTS - 2) + [9]
    assert numbers_done(Executors(*lives), len(lives)) == list(range(len(lives)))


def test_processes_that_do_nothing_but_die_are_given_up(numbers_done):
    lives = [0] * (ATTEMPTS - 1)
    assert numbers_done(Executors(*lives, 5), 5) == list(range(5))
    with pytest.raises(KinetostaticsError, match=f"ended {ATTEMPTS} times without having done anything"):
        numbers_done(Executors(*lives, 0), 5)
