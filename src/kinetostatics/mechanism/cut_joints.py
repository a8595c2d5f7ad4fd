"""Which edges of a limb carry the wrenches of its cut joints, see :mod:`kinetostatics.mechanism.limbs`."""

from __future__ import annotations

from collections.abc import Iterator

from kinetostatics.mechanism.body_graph import BodyEdge, DirectedEdge, RigidBody


def _path_to_root(body: RigidBody, reached_by: dict[RigidBody, DirectedEdge]) -> Iterator[DirectedEdge]:
    while (step := reached_by.get(body)) is not None:
        yield step
        body = step.inner


def cut_joints_carried(steps: list[DirectedEdge], reached_by: dict[RigidBody, DirectedEdge]) -> dict[BodyEdge, dict[int, int]]:
    """Return for each edge ``{number: sign}`` of the cut joints whose wrenches it carries, as in :class:`.limbs.Edge`.

    The wrench of a cut joint acts from its outer on its inner side. The sign is positive in the edges of the tree's path to the
    inner end of the cut joint, and negative in the edges of the path to its outer end.
    """
    carries: dict[BodyEdge, dict[int, int]] = {step.edge: {} for step in steps}
    for number, cut_joint in enumerate(step for step in steps if not step.in_tree):
        carries[cut_joint.edge][number] = 1
        for body, sign in ((cut_joint.inner, 1), (cut_joint.outer, -1)):
            for step in _path_to_root(body, reached_by):
                signs = carries[step.edge]
                signs[number] = signs.get(number, 0) + sign
                if signs[number] == 0:
                    del signs[number]
    return carries


def edges_towards_cut_joints(
    steps: list[DirectedEdge], reached_by: dict[RigidBody, DirectedEdge], carries: dict[BodyEdge, dict[int, int]]
) -> set[BodyEdge]:
    """Return the edges that carry a cut-joint wrench, and the edges inboard of these edges."""
    leading: set[BodyEdge] = set()
    for step in steps:
        if carries[step.edge]:
            leading.update([step.edge, *(inner_step.edge for inner_step in _path_to_root(step.inner, reached_by))])
    return leading
