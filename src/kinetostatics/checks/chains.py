"""Chains of bodies and joints of a limb from base to platform, with parallel branches, and their text."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.layout.renderings import WIDTH


@dataclass(frozen=True)
class Body:
    """Links and beams that form one body between two joints, by name, in the direction from base to platform."""

    names: tuple[str, ...]


@dataclass(frozen=True)
class JointStep:
    """A joint between two bodies; revolutes with a common point form one universal or spherical joint.

    Attributes:
        name: name of the joint; for several revolutes, the common part of their names.
        joints: the joints' names.
        kind: URDF or loop type.
        driven, elastic: whether it is driven, and whether it or its actuator is elastic.
        follows: name of the joint that it mimics, or None.
    """

    name: str
    joints: tuple[str, ...]
    kind: str
    driven: bool = False
    elastic: bool = False
    follows: str | None = None


@dataclass(frozen=True)
class Run:
    """A chain between two branching bodies."""

    start: str
    end: str
    chain: Chain


@dataclass(frozen=True)
class Branches:
    """Runs between two bodies: parallel branches if all connect both bodies (``parallel``), otherwise a network."""

    start: str
    end: str
    runs: tuple[Run, ...]
    parallel: bool


Item: TypeAlias = Body | JointStep | Branches
Chain: TypeAlias = tuple[Item, ...]


@dataclass(frozen=True)
class Hanging:
    """A branch that starts at the body ``at``; ``is_ring``: it also ends there."""

    at: str
    chain: Chain
    is_ring: bool


@dataclass(frozen=True)
class Graph:
    """A limb as a chain from base to platform.

    Attributes:
        chain: chain without base and platform; empty for attached bodies.
        hanging: branches and rings on bodies.
        rings: number of independent rings.
    """

    chain: Chain
    hanging: tuple[Hanging, ...]
    rings: int


def joint_string(chain: Chain) -> str:
    """Return the joints of a chain as letters, such as ``R(driven) (S S | S S)``; networks in square brackets."""
    words = []
    for item in chain:
        if isinstance(item, JointStep):
            if item.elastic or not JOINT_TYPES[item.kind].is_fixed:
                words.append(JOINT_TYPES[item.kind].symbol + ("(driven)" if item.driven else ""))
        elif isinstance(item, Branches):
            parts = [joint_string(run.chain) for run in item.runs]
            network = f"[{' '.join(filter(None, parts)) or '–'}]"
            words.append(f"({' | '.join(part or '–' for part in parts)})" if item.parallel else network)
    return " ".join(words)


def _items(chain: Chain) -> Iterator[Item]:
    for item in chain:
        yield item
        for run in item.runs if isinstance(item, Branches) else ():
            yield from _items(run.chain)


def joints_of(chain: Chain) -> list[JointStep]:
    """Return all joints of a chain."""
    return [item for item in _items(chain) if isinstance(item, JointStep)]


def bodies_of(chain: Chain) -> list[str]:
    """Return the names of all bodies of a chain."""
    return [name for item in _items(chain) if isinstance(item, Body) for name in item.names]


# ---- text ------------------------------------------------------------------------------------------------------------


def joint_words(joint: JointStep) -> str:
    """Return a joint's name with remarks, such as ``universal_1_{x,y}`` or ``rail (driven, elastic)``."""
    name = joint.name
    if joint.joints != (name,):
        rests = [item[len(name) :].lstrip("_-. ") for item in joint.joints]
        together = all(item.startswith(name) for item in joint.joints) and all(rests)
        between = joint.joints[0][len(name) : len(joint.joints[0]) - len(rests[0])]
        name = f"{name}{between}{{{','.join(rests)}}}" if together else "+".join(joint.joints)
    notes = ["driven"] * joint.driven + ["elastic"] * joint.elastic + ["fixed"] * JOINT_TYPES[joint.kind].is_fixed
    if joint.follows is not None:
        notes.append(f"follows {joint.follows}")
    return name + (f" ({', '.join(notes)})" if notes else "")


def body_words(body: Body) -> str:
    """Return the names of up to four links and beams that move together."""
    names = body.names if len(body.names) <= 4 else (body.names[0], body.names[1], "…", body.names[-1])
    return " + ".join(names) + (f" ({len(body.names)} in all)" if len(body.names) > 4 else "")


def chain_lines(start: str, chain: Chain, end: str, indent: str = "") -> list[str]:
    """Return a chain as lines such as ``base —revolute_1→ rod_1 —spherical_1→ platform``, with branches on separate lines."""
    lines: list[str] = []
    words = [start] if start else []
    left: str | None = end
    for k, item in enumerate(chain):
        if isinstance(item, JointStep):
            words.append(f"—{joint_words(item)}→")
        elif isinstance(item, Body):
            name = body_words(item)
            if words and words[-1].endswith("→"):
                words[-1] += f" {name}"
            elif words and words[-1] != name:
                words[-1] += f" + {name}"
            elif not words:
                words.append(name)
        else:
            if words and words[-1].endswith("→"):
                words[-1] += f" {item.start}"
            what = f"{len(item.runs)} ways" if item.parallel else "a network"
            lines += _filled(words, f", then {what} to {item.end}:" if words else f"{what} to {item.end}:", indent)
            words = []
            for run in item.runs:
                ends = ("", "") if item.parallel else (run.start, run.end)
                inner = chain_lines(ends[0], run.chain, ends[1], indent + "    ")
                lines += [f"{indent}  - {inner[0].lstrip()}", *inner[1:]]
            if k == len(chain) - 1:
                left = None
            elif not isinstance(chain[k + 1], Body):
                words = [item.end]
    if left:
        if words and words[-1].endswith("→"):
            words[-1] += f" {left}"
        else:
            words.append(f"+ {left}" if words else left)
    return [*lines, *_filled(words, "", indent)]


def _filled(words: list[str], last: str, indent: str) -> list[str]:
    """Return words distributed over lines; continuation lines are indented further."""
    if not words and not last:
        return []
    words = [*words[:-1], words[-1] + last] if words else [last]
    lines = [indent + words[0]]
    for word in words[1:]:
        if len(lines[-1]) + 1 + len(word) > WIDTH:
            lines.append(indent + "    " + word)
        else:
            lines[-1] += f" {word}"
    return lines
