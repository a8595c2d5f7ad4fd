"""What ``kinetostatics check`` says of the robots in ``robots/`` and the odd ones of ``odd_robots.py``, and when two texts agree.

The texts lie in ``tests/golden/``. After a change that is meant, ``python tests/support/check_texts.py`` writes them anew; look
at what differs.
"""

import re
from functools import cache

import package_robots
from odd_robots import ODD
from places import ROOT, TESTS

GOLDEN = TESTS / "golden"
ROBOTS = package_robots.NAMES
NAMES = [*ROBOTS, *(make.__name__ for make in ODD)]
#: A number that is not part of a name.
NUMBER = re.compile(r"(?<![\w.])[-−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.]*\d)")


@cache
def robot(name):
    return package_robots.robot(name) if name in ROBOTS else next(make for make in ODD if make.__name__ == name)()


def report(name):
    return str(robot(name)).replace(f"{ROOT}/", "")


def words_and_numbers(line):
    """Return a line without its numbers, white space in one, and its numbers."""
    return " ".join(NUMBER.sub("#", line).split()), [found[0].replace("−", "-") for found in NUMBER.finditer(line)]


def same(number, other):
    """Whether two printed numbers agree to a thousandth, or but for the last digit."""
    mantissa, _, exponent = other.partition("e")
    last = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    return abs(float(number) - float(other)) <= max(1e-3 * abs(float(other)), 1.01 * last * ("." in mantissa))


if __name__ == "__main__":
    GOLDEN.mkdir(exist_ok=True)
    for old in GOLDEN.glob("*.txt"):
        if old.stem not in NAMES:
            old.unlink()
    for each in NAMES:
        (GOLDEN / f"{each}.txt").write_text(report(each) + "\n", encoding="utf-8")
