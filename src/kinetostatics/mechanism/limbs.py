"""From links and joints to limbs: the graph of rigid pieces cut at base and platform.

With base and platform removed, every connected component that touches both is a limb; one that touches only one of them is
dead weight on it (``docs/method.md``, section 2). A spanning tree, rooted at the base, reaches every piece of a limb; the
edges that it leaves out are the limb's *chords*. With the wrenches of all chords known, equilibrium gives those of all other
edges; a serial limb has one chord, its joint to the platform.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace

from kinetostatics.exceptions import RobotFileError
from kinetostatics.mechanism.beam_geometry import BeamSpan
from kinetostatics.mechanism.edge_directions import Step, cut_pieces, steps_out
from kinetostatics.mechanism.mechanism import Connection, Mechanism
from kinetostatics.mechanism.rigid_bodies import Piece, PieceEdge, PieceGraph
from kinetostatics.printing.mappings import ShortRepr


@dataclass(frozen=True)
class Edge:
    """A joint or a beam as it lies on the way out from the base (or, on a dead branch, from what it hangs on).

    Attributes:
        joint: name of the joint or loop, or None for a beam.
        beam: name of the beam, or None for a joint.
        sign: +1 if the joint's predecessor is its inboard side, else −1.
        outboard: names of the weights outboard of it; for a beam, of its outer end. Weights are named after their link or,
            for distributed ones, ``beam:`` and the beam.
        excluded: names of weights that what lies outboard seems to carry but does not: of links inside a telescope that go with
            its outer end although they hang on the inner side of this joint.
        parent: ``key`` of the edge on its inboard side, None if that is the base (of dead weight on the platform: the platform).
        chords: ``{number: sign}`` of the chords whose wrenches it carries: what its outboard side puts on its inboard side is
            the signed sum of them and of the weights outboard.
        both_ways: whether some ways from base to platform pass it in one direction and others in the other, so that its
            direction is the file's: from predecessor to successor.
    """

    joint: str | None
    beam: str | None
    sign: int
    outboard: tuple[str, ...]
    parent: str | None
    excluded: tuple[str, ...] = ()
    chords: tuple[tuple[int, int], ...] = ()
    both_ways: bool = False

    @property
    def key(self) -> str:
        """The joint's name, or ``beam:`` and the beam's."""
        return self.joint if self.joint is not None else f"beam:{self.beam}"


@dataclass(frozen=True)
class Part:
    """A part of a limb between two pieces that everything passes through.

    Attributes:
        keys: of its edges, inboard ones first.
        start, end: names of a link of the piece at which it begins and ends.
        is_serial: whether it is a single way.
    """

    keys: tuple[str, ...]
    start: str
    end: str
    is_serial: bool


@dataclass(frozen=True, repr=False)
class Limb(ShortRepr):
    """A limb: its edges on the way out, and what hangs on it.

    Attributes:
        name: ``limb_1``, …
        links: its links, in the order of the file.
        edges: joints and beams that carry chords, inboard ones first. The joints inside a telescopic beam stand next to it.
        branches: joints and beams of dead branches on the limb.
        weights: names of its weights.
        ends: whether the k-th edge ends a way: a weight or more than the next edge lies directly outboard of it.
        to_platform: for each chord whether it ends at the platform.
        on_platform: whether it is dead weight on the platform: the spanning tree is rooted there.
        parts: its parts from base to platform, if it is split by pieces that everything passes through (a frame under the
            robot, a serial wrist); else one.
    """

    name: str
    links: tuple[str, ...]
    edges: tuple[Edge, ...]
    branches: tuple[Edge, ...]
    weights: tuple[str, ...]
    ends: tuple[bool, ...]
    to_platform: tuple[bool, ...]
    on_platform: bool = False
    parts: tuple[Part, ...] = ()

    @property
    def is_serial(self) -> bool:
        """Whether its edges are a single way from base to platform."""
        return self.to_platform == (True,)

    @property
    def platform_edges(self) -> tuple[Edge, ...]:
        """Its outermost edges on the ways to the platform: joints, and beams that are welded to the platform."""
        chords = [number for number, ends in enumerate(self.to_platform) if ends]
        return tuple([edge for edge in self.edges if number in dict(edge.chords)][-1] for number in chords)


@dataclass(frozen=True)
class DeadWeight:
    """What hangs on the base or on the platform alone, the rigid links of base or platform included.

    ``edges`` are those of open branches only.
    """

    links: tuple[str, ...]
    edges: tuple[Edge, ...]
    weights: tuple[str, ...]


@dataclass(frozen=True, repr=False)
class Topology(ShortRepr):
    """The robot's limbs, beams and dead weights.

    ``hanging`` holds dead weights with closed chains, as limbs that do not reach the platform. ``carried_by`` tells for every
    rigid link of a limb or dead branch the ``key`` of the edge that it is the outer side of.
    """

    limbs: tuple[Limb, ...]
    hanging: tuple[Limb, ...]
    base: DeadWeight
    platform: DeadWeight
    beams: dict[str, BeamSpan]
    carried_by: dict[str, str]
    warnings: tuple[str, ...]

    @property
    def all_limbs(self) -> tuple[Limb, ...]:
        """The limbs, and behind them the closed chains that hang on base or platform alone."""
        return (*self.limbs, *self.hanging)


def analyze_topology(mechanism: Mechanism) -> Topology:
    """Find limbs, beams and dead weights.

    Raises:
        RobotFileError: a beam's ends or what is attached along it make no sense.
    """
    return _Builder(mechanism).build()


class _Builder:
    def __init__(self, mechanism: Mechanism) -> None:
        self.graph = PieceGraph(mechanism)
        self.spans = dict(self.graph.spans)
        self.warnings = list(self.graph.warnings)
        self.carried_by: dict[str, str] = {}

    def build(self) -> Topology:
        graph = self.graph
        base, platform = graph.base, graph.platform
        at: dict[Piece, list[PieceEdge]] = {}
        direct: list[PieceEdge] = []
        for edge in graph.edges:
            ends = (edge.inner.find(), edge.outer.find())
            if set(ends) == {base, platform}:
                direct.append(edge)
                continue
            for end in ends:
                at.setdefault(end, []).append(edge)
        limbs: list[tuple[int, Limb]] = []
        hanging: list[Limb] = []
        dead: dict[Piece, list[Edge]] = {base: [], platform: []}
        dead_pieces: dict[Piece, list[Piece]] = {base: [], platform: []}
        dead_weights: dict[Piece, list[str]] = {root: list(graph.weights_of(root)) for root in (base, platform)}
        seen: set[Piece] = {base, platform}
        order = {link: number for number, link in enumerate(graph.description.links)}
        for piece in graph.pieces():
            if piece in seen:
                continue
            component, edges = self._component(piece, at, {base, platform})
            seen.update(component)
            limb = self._limb(component, edges)
            touched = {end for edge in edges for end in (edge.inner.find(), edge.outer.find())}
            if base in touched and platform in touched:
                limbs.append((min(order[link] for link in limb.links), limb))
                continue
            root = platform if limb.on_platform else base
            dead_pieces[root].extend(component)
            dead_weights[root].extend(limb.weights)
            if limb.to_platform:
                hanging.append(replace(limb, name="platform" if limb.on_platform else "base"))
            else:
                dead[root].extend(limb.branches)
        for edge in direct:
            floating = edge.connection is not None and edge.connection.type.is_free
            if floating and edge.connection is not None and not self._is_sprung(edge.connection):
                continue  # it transmits nothing
            limbs.append((len(order), self._limb([], [edge])))
        limbs.sort(key=lambda pair: pair[0])
        numbered = tuple(replace(limb, name=f"limb_{k}") for k, (_, limb) in enumerate(limbs, 1))
        self._check_misplaced((*numbered, *hanging), dead)
        return Topology(
            numbered,
            tuple(hanging),
            self._dead_weight(base, dead[base], dead_pieces[base], dead_weights[base]),
            self._dead_weight(platform, dead[platform], dead_pieces[platform], dead_weights[platform]),
            self.spans,
            self.carried_by,
            tuple(self.warnings),
        )

    def _is_sprung(self, connection: Connection) -> bool:
        return connection.name in self.graph.description.joint_stiffness

    def _component(
        self, start: Piece, at: dict[Piece, list[PieceEdge]], stops: set[Piece]
    ) -> tuple[list[Piece], list[PieceEdge]]:
        """Return the pieces and edges that hang together with ``start``, in the order of the file."""
        pieces, edges, queue = {start}, set[PieceEdge](), deque([start])
        while queue:
            piece = queue.popleft()
            for edge in at.get(piece, []):
                edges.add(edge)
                other = edge.other(piece)
                if other not in pieces and other not in stops:
                    pieces.add(other)
                    queue.append(other)
        return (
            [piece for piece in self.graph.pieces() if piece in pieces],
            [edge for edge in self.graph.edges if edge in edges],
        )

    # ---- limbs ------------------------------------------------------------------------------------------------------

    def _limb(self, pieces: list[Piece], edges: list[PieceEdge]) -> Limb:
        graph = self.graph
        steps = steps_out(pieces, edges, graph.base, graph.platform)
        on_platform = bool(pieces) and all(graph.base not in (edge.inner.find(), edge.outer.find()) for edge in edges)
        reached_by = {step.outer: step for step in steps if step.in_tree}
        below = self._weights_below(steps)
        carries = _chords_carried(steps, reached_by)
        chords = [step for step in steps if not step.in_tree]
        leading = _leads_to_ring(steps, reached_by, carries)
        degree: dict[Piece, int] = {}
        for edge in edges:
            for end in (edge.inner.find(), edge.outer.find()):
                degree[end] = degree.get(end, 0) + 1
        found: list[Edge] = []
        branches: list[Edge] = []
        ends: list[bool] = []
        last_key: dict[Piece, str] = {}
        keys: dict[PieceEdge, tuple[str, ...]] = {}
        for step in steps:
            passes = step.in_tree and degree[step.outer] == 2 and not graph.weights_of(step.outer)
            chain = self._directed(step, below.get(step.edge, []), last_key.get(step.inner), tuple(carries[step.edge].items()))
            keys[step.edge] = tuple(edge.key for edge in chain)
            if step.in_tree:
                last_key[step.outer] = chain[-1].key
                for link in graph.rigid_links_of(step.outer):
                    self.carried_by[link] = chain[-1].key
            if step.edge in leading:
                found.extend(chain)
                ends.extend([False] * (len(chain) - 1) + [not passes])
            else:
                branches.extend(chain)
        weights = [name for piece in pieces for name in graph.weights_of(piece)]
        weights += [f"beam:{edge.beam.beam.name}" for edge in edges if edge.beam is not None]
        return Limb(
            "",
            graph.links_of(pieces, edges),
            tuple(found),
            tuple(branches),
            tuple(weights),
            tuple(ends),
            tuple(step.outer is graph.platform and not on_platform for step in chords),
            on_platform,
            self._parts([step for step in steps if step.edge in leading], keys),
        )

    def _parts(self, steps: list[Step], keys: dict[PieceEdge, tuple[str, ...]]) -> tuple[Part, ...]:
        """Split a limb at the pieces that every way from base to platform passes, serial stretches in one."""
        graph = self.graph
        cuts = cut_pieces(steps, graph.base, graph.platform)
        if not cuts:
            return ()
        groups: list[tuple[list[Step], Piece, Piece]] = []
        for inner, outer, mine in cuts:
            if groups and len(mine) == 1 and len(groups[-1][0]) == self._stretch(groups[-1][0]):
                groups[-1] = (groups[-1][0] + mine, groups[-1][1], outer)
            else:
                groups.append((mine, inner, outer))
        return tuple(
            Part(
                tuple(key for step in mine for key in keys[step.edge]),
                self._name_of(start),
                self._name_of(end),
                len(mine) == self._stretch(mine),
            )
            for mine, start, end in groups
        )

    @staticmethod
    def _stretch(steps: list[Step]) -> int:
        """Return how many different pieces lie at the outer ends of some edges: as many as edges on a single way."""
        return len({step.outer for step in steps}) if len({step.inner for step in steps}) == len(steps) else 0

    def _name_of(self, piece: Piece) -> str:
        if piece is self.graph.base:
            return self.graph.description.base
        if piece is self.graph.platform:
            return self.graph.description.platform
        return self.graph.links_of([piece], [])[0]

    def _weights_below(self, steps: list[Step]) -> dict[PieceEdge, list[str]]:
        """Return the names of the weights that the tree carries beyond each of its edges."""
        hanging: dict[Piece, list[str]] = {}
        below: dict[PieceEdge, list[str]] = {}
        for step in reversed(steps):  # outer edges come after inner ones
            mine: list[str] = []
            if step.in_tree:
                mine = self.graph.weights_of(step.outer) + hanging.get(step.outer, [])
                below[step.edge] = mine
            own = [f"beam:{step.edge.beam.beam.name}"] if step.edge.beam is not None else []
            hanging[step.inner] = mine + own + hanging.get(step.inner, [])
        return below

    def _directed(self, step: Step, below: list[str], parent: str | None, chords: tuple[tuple[int, int], ...]) -> list[Edge]:
        """Return an edge, and the joints inside a telescopic beam, as seen on the way out."""
        edge = step.edge
        forward = edge.inner.find() is step.inner
        if edge.connection is not None:
            sign = 1 if forward else -1
            return [Edge(edge.connection.name, None, sign, tuple(below), parent, (), chords, step.both_ways)]
        assert edge.beam is not None
        name = edge.beam.beam.name
        if not forward and not step.both_ways and (edge.beam.beam.start or edge.beam.beam.end):
            place = edge.beam.beam.place
            self.warnings.append(
                f"{place.file}:{place.line}: beam {name!r} runs from its end towards the platform to the one towards the base; "
                "from= should name the joint towards the base"
            )
        span = edge.beam if forward else edge.beam.reversed
        self.spans[name] = span
        joints, before_carrier = [*span.inward[::-1], *span.outward], len(span.inward)
        links = [span.start_link]
        for item in joints:
            links.append(item.other(links[-1]))
        # Links in mid-span go with the end on their side; a joint in between carries those outboard of it all the same.
        near = [link for link in links[1:before_carrier] if self.graph.weighs(link)]
        far = [link for link in links[before_carrier + 1 : -1] if self.graph.weighs(link)]
        result: list[Edge] = []
        for number in range(len(joints) + 1):
            if number == before_carrier:
                result.append(Edge(None, name, 1 if forward else -1, tuple(below), parent, (), chords, step.both_ways))
                parent = result[-1].key
            if number < len(joints):
                item = joints[number]
                sign = 1 if item.predecessor == links[number] else -1
                inboard = set(links[: number + 1])
                weights = list(below)
                if number < before_carrier:
                    weights += [link for link in near if link not in inboard] + [f"beam:{name}"]
                excluded = tuple(link for link in far if link in inboard)
                result.append(Edge(item.name, None, sign, tuple(weights), parent, excluded, chords, step.both_ways))
                parent = result[-1].key
        return result

    # ---- the rest ---------------------------------------------------------------------------------------------------

    def _check_misplaced(self, limbs: tuple[Limb, ...], dead: dict[Piece, list[Edge]]) -> None:
        """Refuse what carries load somewhere along a beam instead of at its end."""
        carrying = {edge.joint for limb in limbs for edge in limb.edges}
        loaded = {edge.joint: edge.outboard for limb in limbs for edge in limb.branches}
        loaded.update({edge.joint: edge.outboard for edges in dead.values() for edge in edges})
        for _, connection, link in self.graph.misplaced:
            if connection.name in carrying or loaded.get(connection.name):
                beams = ", ".join(repr(beam.name) for beam in self.graph.beams_of[link])
                place = connection.place
                raise RobotFileError(
                    f"joint {connection.name!r} carries load at a point of link {link!r} that is not an end of its beam "
                    f"({beams}); split the beam there with a fixed joint, or let it end there",
                    place.file,
                    place.line,
                )

    def _dead_weight(self, root: Piece, edges: list[Edge], pieces: list[Piece], weights: list[str]) -> DeadWeight:
        return DeadWeight(self.graph.links_of([root, *pieces], []), tuple(edges), tuple(weights))


def _chords_carried(steps: list[Step], reached_by: dict[Piece, Step]) -> dict[PieceEdge, dict[int, int]]:
    """Return for each edge the signs of the chords' wrenches in what its outboard side puts on its inboard side.

    A chord's wrench is what its outer side puts on its inner side: it loads what lies beyond the edges on the way to its inner
    end, and unloads what lies beyond those on the way to its outer end.
    """
    carries: dict[PieceEdge, dict[int, int]] = {step.edge: {} for step in steps}
    number = 0
    for chord in steps:
        if chord.in_tree:
            continue
        carries[chord.edge][number] = 1
        for piece, sign in ((chord.inner, 1), (chord.outer, -1)):
            step = reached_by.get(piece)
            while step is not None:
                mine = carries[step.edge]
                mine[number] = mine.get(number, 0) + sign
                if mine[number] == 0:
                    del mine[number]
                step = reached_by.get(step.inner)
        number += 1
    return carries


def _leads_to_ring(steps: list[Step], reached_by: dict[Piece, Step], carries: dict[PieceEdge, dict[int, int]]) -> set[PieceEdge]:
    """Return the edges that carry a chord, or beyond which one that does lies."""
    found: set[PieceEdge] = set()
    for step in steps:
        if carries[step.edge]:
            here: Step | None = step
            while here is not None and here.edge not in found:
                found.add(here.edge)
                here = reached_by.get(here.inner)
    return found
