"""Limbs and attached bodies as data: the graph of rigid bodies, cut at base and platform.

Base and platform divide the graph into components. A component joined to both of them is a limb; a component joined to one of
them is an attached body (method page, section 2). A spanning tree, rooted at the base, reaches every body of a limb. The edges
outside the tree are the *cut joints* of the limb. By equilibrium, their wrenches determine those of all other edges. A serial
limb has one cut joint, its joint to the platform. An *open branch* carries no cut-joint wrench: only weights and loads.

A *weight* is a link without beams that has mass, or a beam. An *attachment* is a point at which loads may act: a link without
beams, or an end of a beam; the end of a telescopic beam is two attachments, one that moves with the beam's link and one that
moves with the body at this end. *Inboard* and *outboard* of an edge mean towards the root of the tree and away from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.mechanism.beam_geometry import Span
from kinetostatics.mechanism.body_graph import body_at_end


@dataclass(frozen=True)
class Edge:
    """A joint, beam or other elastic link, directed from the base to the platform (on an open branch: away from its root).

    Attributes:
        joint: name of the joint or loop; None for a beam or elastic link.
        span: name of the beam, or of the span of an elastic link; None for a joint.
        sign: +1 if the joint's predecessor, or the beam's start, is the inboard side, else −1.
        outboard: names of the weights and attachments outboard of the edge (for a beam, of its outer end): a link, ``beam:`` and
            a beam, ``start:`` or ``end:`` and a beam.
        excluded: names among ``outboard`` that a joint inside a telescopic beam does not carry: the beam's outer end, and
            links inboard of this joint that move with this end.
        parent: ``key`` of the next edge inboard; None if the next body inboard is the base (for bodies attached only to the
            platform: the platform).
        cut_joints: (number, sign) of cut joints: the wrench of the edge's outboard side on its inboard side is the sum of the cut
            joints' wrenches, with these signs, and of the weights outboard.
        both_ways: whether paths from base to platform pass the edge in both directions; results then refer to the direction in
            the file, from predecessor to successor or from start to end.
        limb_cuts: (limb, number, sign) of the limbs' cut joints whose wrenches an elastic base or platform carries there.
    """

    joint: str | None
    span: str | None
    sign: int
    outboard: tuple[str, ...]
    parent: str | None
    excluded: tuple[str, ...] = ()
    cut_joints: tuple[tuple[int, int], ...] = ()
    both_ways: bool = False
    limb_cuts: tuple[tuple[int, int, int], ...] = ()

    @property
    def key(self) -> str:
        """The name of the joint, or ``beam:`` and the name of the beam."""
        return self.joint if self.joint is not None else f"beam:{self.span}"


def carries(edge: Edge, name: str) -> int:
    """Return 1 if an edge carries the weight or attachment of this name, else 0."""
    return (name in edge.outboard) - (name in edge.excluded)


@dataclass(frozen=True)
class LimbSegment:
    """A part of a limb between two bodies through which all the limb's paths from base to platform pass.

    Attributes:
        keys: keys of the segment's edges, inboard ones first.
        start, end: name of a link of the body at the segment's inner end, and at its outer end.
        is_serial: whether the edges are a single chain.
    """

    keys: tuple[str, ...]
    start: str
    end: str
    is_serial: bool


@dataclass(frozen=True, repr=False)
class Limb(ShortRepr):
    """A limb: its edges from base to platform, its open branches and its weights.

    Attributes:
        name: ``limb_1``, …
        links: its links, in the order of the file.
        edges: joints and beams that carry cut-joint wrenches, inboard ones first; joints inside a telescopic beam are next to it.
        branches: joints and beams of open branches on the limb.
        weights, attachments: names of its weights and of its attachments.
        ends: for each edge, whether it is a cut joint, or its outboard body has a weight or a number of edges other than two.
        to_platform: for each cut joint, whether it ends at the platform.
        on_platform: whether the limb is attached only to the platform, which is then the root of its spanning tree.
        parts: segments in series from base to platform, divided at the bodies that all the limb's paths pass. Consecutive joints
            and beams in series form one segment.
        ports: for each cut joint, the key of the edge of an elastic platform that it loads, else None.
    """

    name: str
    links: tuple[str, ...]
    edges: tuple[Edge, ...]
    branches: tuple[Edge, ...]
    weights: tuple[str, ...]
    ends: tuple[bool, ...]
    to_platform: tuple[bool, ...]
    on_platform: bool = False
    parts: tuple[LimbSegment, ...] = ()
    attachments: tuple[str, ...] = ()
    ports: tuple[str | None, ...] = ()

    @property
    def is_serial(self) -> bool:
        """Whether the limb's edges are a single chain from base to platform."""
        return self.to_platform == (True,)

    @property
    def platform_edges(self) -> tuple[Edge, ...]:
        """The edges at the platform: joints, and beams welded to the platform."""
        cut_joints = [number for number, ends in enumerate(self.to_platform) if ends]
        return tuple([edge for edge in self.edges if number in dict(edge.cut_joints)][-1] for number in cut_joints)


@dataclass(frozen=True)
class AttachedBodies:
    """The base and the bodies attached only to the base, or the platform and the bodies attached only to the platform.

    ``edges`` are the edges of open branches. If base or platform is elastic, its own edges, the *plate*, come first; the next
    edges outboard have them as parents. ``root`` is the attachment on the body of the ground, or of o.
    """

    links: tuple[str, ...]
    edges: tuple[Edge, ...]
    weights: tuple[str, ...]
    attachments: tuple[str, ...]
    root: str
    plate: tuple[Edge, ...] = ()


@dataclass(frozen=True, repr=False)
class Topology(ShortRepr):
    """The robot's limbs, beams and attached bodies.

    Attributes:
        hanging: closed chains attached only to the base or only to the platform, as limbs.
        carried_by: for every attachment on a limb or open branch, the ``key`` of the edge with this attachment on its outer side.
        span_ends: the attachments at inner and outer end of each of the ``spans``.
        without_support: attachments at which no load can act, since a joint attaches them to a beam between the beam's ends; each
            with the name of this joint.
    """

    NOT_RECORDED: ClassVar = ("warnings",)

    limbs: tuple[Limb, ...]
    hanging: tuple[Limb, ...]
    base: AttachedBodies
    platform: AttachedBodies
    spans: dict[str, Span]
    carried_by: dict[str, str]
    warnings: tuple[str, ...]
    span_ends: dict[str, tuple[str, str]]
    without_support: dict[str, str]

    def interfaces(self, link: str) -> list[tuple[str, int, str]]:
        """Return for each end of an elastic link, the inner end first, a name in ``spans``, 0 (start) or 1 (end), an attachment.

        The attachment moves with the body at this end.
        """
        names = [name for name, span in self.spans.items() if span.part.name == link]
        ends = [(name, end, self.span_ends[name][end]) for name, end in ((names[0], 0), *((name, 1) for name in names))]
        return [(name, end, body_at_end(at) if self.spans[name].spanned else at) for name, end, at in ends]

    def part_of(self, edge: Edge) -> str:
        """Return the name of an edge's joint, beam or other elastic link."""
        return edge.joint if edge.joint is not None else self.spans[str(edge.span)].part.name

    def link_of(self, attachment: str) -> str:
        kind, _, beam = attachment.removeprefix(body_at_end("")).partition(":")
        return self.spans[beam].part.link if kind in ("start", "end") and beam in self.spans else attachment

    @property
    def plates(self) -> dict[str, tuple[Edge, ...]]:
        """The edges of ``base`` and ``platform``, where they are elastic."""
        return {name: part.plate for name, part in (("base", self.base), ("platform", self.platform)) if part.plate}

    @property
    def all_limbs(self) -> tuple[Limb, ...]:
        """The limbs, followed by the closed chains attached only to the base or only to the platform."""
        return (*self.limbs, *self.hanging)

    @property
    def branch_edges(self) -> tuple[Edge, ...]:
        """The edges of all open branches, on limbs, base and platform."""
        return (*(edge for limb in self.all_limbs for edge in limb.branches), *self.base.edges, *self.platform.edges)
