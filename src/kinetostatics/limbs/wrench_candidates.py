"""Candidates for wrench bases: forces through joint centres along limb, beam and joint axes, and couples along these axes.

The order of preference is that of the method page, sections 3 and 4; candidates for bent links and general joints follow.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from kinetostatics.description.joint_types import Axes
from kinetostatics.limbs.geometry import Candidate, LimbGeometry, foot, meeting_point
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.math.linalg import cross
from kinetostatics.mechanism.joints import CompoundJoint


def beam_candidates(group: LimbGroup) -> Iterator[Candidate]:
    """Yield forces along the beams of a limb with rings, outer ones first."""
    for number, element in reversed(list(enumerate(group.elastic))):
        if element.has_line:
            yield Candidate(("beam", number), None, f"force on the line of {element.names[0]}")


def as_component(candidate: Candidate) -> Candidate:
    """Return the candidate of a limb with rings; its label states that it is one component of the limb's wrench."""
    words = candidate.label.split(" ", 1)
    if words[0] not in ("force", "couple"):
        return candidate
    return replace(candidate, label=" component ".join(words))


def constraint_candidates(group: LimbGroup) -> Iterator[Candidate]:
    """Yield candidates of J_ic in the order of preference of the method page, section 3."""
    compounds, labels = group.compounds[0], [dof.label for dof in group.dofs[0]]
    outer, at = len(compounds), _platform_centre(compounds)
    where = [compound.label for compound in compounds] + ["its outer end"]
    axes = _candidate_axes(group)
    others = [k for k in range(len(compounds) - 1, -1, -1) if k != at and compounds[k].has_point]
    centres = [at, *others, *([outer] if at != outer else [])]
    yield Candidate(("limb", 2), at, f"force along limb axis at {where[at]}")
    for centre in centres:
        for f in axes:
            yield Candidate(("axis", f), centre, f"force ∥ {labels[f]} at {where[centre]}")
    for k in (1, 0):
        yield Candidate(("limb", k), at, f"force along limb {'xyz'[k]} at {where[at]}")
    pairs = [(f, h) for i, f in enumerate(axes) for h in axes[i + 1 :]]
    for f, h in sorted(pairs, key=lambda pair: group.compound_of[pair[0]] != group.compound_of[pair[1]]):
        first, second = (compounds[group.compound_of[dof]] for dof in (f, h))
        what = first.label if first is second else f"{labels[f]} and {labels[h]}"
        yield Candidate(("cross", f, h), None, f"couple ⟂ {what}")
    for k in (2, 0, 1):
        yield Candidate(("limb", k), None, f"couple along limb {'xyz'[k]}")
    for f in axes:
        yield Candidate(("cross_limb", f, 2), None, f"couple ⟂ {labels[f]} and limb axis")
        yield Candidate(("axis", f), None, f"couple ∥ {labels[f]}")
    for centre in centres:
        for f, h in pairs:
            yield Candidate(("cross", f, h), centre, f"force ⟂ {labels[f]} and {labels[h]} at {where[centre]}")
        for f in axes:
            for k in range(3):
                yield Candidate(("cross_limb", f, k), centre, f"force ⟂ {labels[f]} and limb {'xyz'[k]} at {where[centre]}")
        for k in range(3):
            yield Candidate(("limb", k), centre, f"force along limb {'xyz'[k]} at {where[centre]}")


def common_point(group: LimbGroup, geometry: LimbGeometry) -> tuple[int, int] | None:
    """Return two freedoms of different joints whose axes meet in the common point of all passive axes; None without one."""
    free = [int(f) for f in np.flatnonzero(group.passive)]
    if not group.is_serial or not all(group.rotates[f] for f in free):
        return None
    named = [f for f in free if group.compounds[0][group.compound_of[f]].has_axis(True)]
    for f, h in itertools.combinations(named[::-1], 2):
        if group.compound_of[f] == group.compound_of[h]:
            continue
        point = meeting_point(f, h, geometry)
        gaps = [cross(point - foot(k, geometry), geometry.axes[:, k]) for k in free]
        if all(float(np.max(np.abs(gap))) < 1e-8 * group.model.length for gap in gaps):
            return f, h
    return None


def central_candidates(group: LimbGroup, f: int, h: int) -> Iterator[Candidate]:
    """Yield forces through the point where the axes f and h meet, along both axes and normal to them, and a normal couple."""
    names = [group.dofs[0][k].label for k in (f, h)]
    yield Candidate(("axis", f), (f, h), f"force along the axis of {names[0]}")
    yield Candidate(("axis", h), (f, h), f"force along the axis of {names[1]}")
    yield Candidate(("cross", f, h), (f, h), f"force ⟂ {names[0]} and {names[1]} where they meet")
    yield Candidate(("cross", f, h), None, f"couple ⟂ {names[0]} and {names[1]}")


def further_candidates(group: LimbGroup) -> Iterator[Candidate]:
    """Yield candidates of J_ic for limbs with bent links and joints in general position."""
    compounds, labels = group.compounds[0], [dof.label for dof in group.dofs[0]]
    axes = _candidate_axes(group)
    for f in axes:
        for k in (0, 1):
            yield Candidate(("cross_limb", f, k), None, f"couple ⟂ {labels[f]} and limb {'xy'[k]}")
    for u, v in itertools.combinations([k for k, compound in enumerate(compounds) if compound.has_centre], 2):
        yield Candidate(("to", v), u, f"force along the line from {compounds[u].label} to {compounds[v].label}")
    if not group.is_serial:  # too many joints for further candidates
        return
    turning = [f for f in axes if group.rotates[f]]
    pairs = [(f, h) for f, h in itertools.combinations(turning, 2) if group.compound_of[f] != group.compound_of[h]]
    for f, h in pairs:
        for k in axes:
            if k not in (f, h):
                yield Candidate(("axis", k), (f, h), f"force ∥ {labels[k]} where {labels[f]} and {labels[h]} meet")
        yield Candidate(("cross", f, h), (f, h), f"force ⟂ {labels[f]} and {labels[h]} where they meet")
    for u in [k for k in range(len(compounds) - 1, -1, -1) if compounds[k].has_point]:
        for f, h in itertools.combinations(turning, 2):
            what = f"the axes of {labels[f]} and {labels[h]}"
            yield Candidate(("meets", f, h), u, f"force at {compounds[u].label} that meets {what}")


def attached_candidates(group: LimbGroup) -> Iterator[Candidate]:
    """Yield candidates of J_ig: forces through the platform joint's centre, then couples."""
    compounds, labels = group.compounds[0], [dof.label for dof in group.dofs[0]]
    at = _platform_centre(compounds)
    where = compounds[at].label if at < len(compounds) else "its outer end"
    for k in range(3):
        yield Candidate(("limb", k), at, f"force along limb {'xyz'[k]} at {where}")
    for k in range(3):
        yield Candidate(("limb", k), None, f"couple along limb {'xyz'[k]}")
    axes = _candidate_axes(group)
    for i, f in enumerate(axes):
        yield Candidate(("axis", f), at, f"force ∥ {labels[f]} at {where}")
        yield Candidate(("axis", f), None, f"couple ∥ {labels[f]}")
        for h in axes[i + 1 :]:
            yield Candidate(("cross", f, h), None, f"couple ⟂ {labels[f]} and {labels[h]}")
        for k in range(3):
            yield Candidate(("cross_limb", f, k), None, f"couple ⟂ {labels[f]} and limb {'xyz'[k]}")


def _platform_centre(compounds: Sequence[CompoundJoint]) -> int:
    """Return the joint whose centre is preferred for forces: the outermost rotating joint, if it and all outer ones are passive.

    Otherwise return the number of joints, which stands for the limb's outer end.
    """
    for k in range(len(compounds) - 1, -1, -1):
        if not compounds[k].passive:
            break
        if any(dof.rotates for dof in compounds[k].dofs):
            return k
    return len(compounds)


def _candidate_axes(group: LimbGroup) -> list[int]:
    """Return the passive freedoms whose axes are features of the limb, in the order of preference.

    Rotations of single-axis joints come first, then universal joints, then translations; in each set, outer joints come first.
    """
    rotates, joints = group.rotates, [group.compounds[0][k] for k in group.compound_of]
    free = [int(f) for f in np.flatnonzero(group.passive)[::-1] if joints[f].has_axis(bool(rotates[f]))]
    single = [f for f in free if joints[f].type.turns is not Axes.BOTH]
    return [f for f in single if rotates[f]] + [f for f in free if f not in single] + [f for f in single if not rotates[f]]
