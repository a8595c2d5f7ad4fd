"""Reports of a robot whose numbers are all off by rounding have the same words: ``cos(pi/2)`` in a file is 6e-17, not 0."""

import dataclasses
import inspect
from collections.abc import Mapping

import numpy as np
import pytest
from check_texts import NAMES, robot, words_and_numbers
from same_everywhere import texts_of

import kinetostatics as ks
from kinetostatics.description.elements import Inertia
from kinetostatics.description.joints import Joint, Loop
from kinetostatics.sections import Section

ROUNDING = 1e-13


def rounded(item, random):
    """Return a description, or a part of one, with every number off by rounding; the zeros of a vector by that of the others."""
    if isinstance(item, float) and np.isfinite(item):
        return item * (1 + ROUNDING * random.choice([-1.0, 1.0]).item())
    if isinstance(item, tuple) and item and all(isinstance(part, float) for part in item):
        size = max(abs(part) for part in item if np.isfinite(part)) if np.any(np.isfinite(item)) else 1.0
        return tuple(part + ROUNDING * size * random.choice([-1.0, 1.0]).item() if np.isfinite(part) else part for part in item)
    if isinstance(item, tuple):
        return tuple(rounded(part, random) for part in item)
    if isinstance(item, Mapping):
        return {key: rounded(part, random) for key, part in item.items()}
    if isinstance(item, Section) and type(item) is not Section:  # its other numbers follow from its sizes
        sizes = inspect.signature(type(item).of).parameters
        return type(item).of(*(rounded(getattr(item, size), random) for size in sizes if hasattr(item, size)))
    if isinstance(item, Inertia):  # must not become negative; statics does not use it
        return item
    if dataclasses.is_dataclass(item):
        known = [field for field in dataclasses.fields(item) if field.init]
        if isinstance(item, (Joint, Loop)):  # fields for joints of other types must stay at their defaults
            known = [field for field in known if getattr(item, field.name) != field.default]
        fields = {field.name: getattr(item, field.name) for field in known}
        new = {name: rounded(value, random) for name, value in fields.items()}
        return dataclasses.replace(item, **{name: value for name, value in new.items() if value is not fields[name]})
    return item


def words(text):
    """Return the words of the lines, without numbers and without the line breaks and alignment that depend on them."""
    return " ".join(words_and_numbers(line)[0] for line in text.splitlines()).split()


@pytest.mark.few(1)
@pytest.mark.parametrize("name", NAMES[::6])
def test_rounding_does_not_change_words_of_reports(name):
    description = robot(name).description
    other = ks.Robot(rounded(description, np.random.default_rng(NAMES.index(name))))
    assert other.description != description
    for mine, theirs in zip(texts_of(other), texts_of(robot(name)), strict=True):
        assert words(mine) == words(theirs)
