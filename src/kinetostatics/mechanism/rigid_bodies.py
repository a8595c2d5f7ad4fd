"""The graph of a robot: rigid pieces joined by joints, loops and beams.

A *piece* moves as a rigid body: a link without beams, or one end of a beam's link. Joints, loops and beams are the *edges*
between pieces. No name and no cut of the file plays a part.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinetostatics.description.elements import Beam
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.beam_geometry import SAME_POINT, BeamSpan, SpanFinder, beam_error
from kinetostatics.mechanism.mechanism import Connection, Mechanism


@dataclass(eq=False)
class Piece:
    """A rigid piece; ``point`` tells the pieces of one beam link apart, ``weights`` names the rigid links that weigh on it."""

    link: str
    point: Array | None = None
    weights: list[str] = field(default_factory=list)
    merged: Piece | None = None

    def find(self) -> Piece:
        """Return the piece that this one has been made part of."""
        piece = self
        while piece.merged is not None:
            piece = piece.merged
        return piece


@dataclass(eq=False)
class PieceEdge:
    """A joint or a beam between two pieces: predecessor and successor, or the beam's start and end."""

    inner: Piece
    outer: Piece
    connection: Connection | None = None
    beam: BeamSpan | None = None

    def other(self, piece: Piece) -> Piece:
        """Return the piece on the other side."""
        return self.outer.find() if self.inner.find() is piece else self.inner.find()


class PieceGraph:
    """Pieces and edges of a mechanism.

    Attributes:
        base, platform: the pieces that base and platform belong to.
        base_links, platform_links: links that are rigidly part of them.
        spans: all beams, from start to end as in the file.
        edges: all edges between different pieces: beams in the order of the file, joints in that of their links.
        misplaced: edges that are attached to a beam elsewhere than at its ends, with the joint and the beam's link.
        warnings: what is suspicious, in full sentences.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.description = mechanism.description
        self.beams_of: dict[str, list[Beam]] = {}
        for beam in self.description.beams.values():
            self.beams_of.setdefault(beam.link, []).append(beam)
        finder = SpanFinder(mechanism)
        self.base_links, self.platform_links = finder.base_links, finder.platform_links
        self.spans = finder.spans()
        self.warnings = list(finder.warnings)
        self._pieces: dict[str, list[Piece]] = {}
        self.misplaced: list[tuple[PieceEdge, Connection, str]] = []
        self._make_pieces()
        edges = self._make_edges()
        self.base, self.platform = self._merge(self.base_links), self._merge(self.platform_links)
        self.edges = self._in_order([edge for edge in edges if edge.inner.find() is not edge.outer.find()])
        for edge in edges:
            if edge.beam is not None and edge.inner.find() is edge.outer.find():
                raise beam_error(edge.beam.beam, "its two ends are fixed to the same rigid piece")
        self._links_of: dict[Piece, list[str]] = {}
        self._weights_of: dict[Piece, list[str]] = {}
        self._rigid_links_of: dict[Piece, list[str]] = {}
        for link, pieces in self._pieces.items():
            for piece in pieces:
                whole = piece.find()
                self._links_of.setdefault(whole, []).append(link)
                self._weights_of.setdefault(whole, []).extend(piece.weights)
                if piece.point is None:
                    self._rigid_links_of.setdefault(whole, []).append(link)

    def pieces(self) -> list[Piece]:
        """Return all pieces, in the order of the file."""
        return list(dict.fromkeys(piece.find() for pieces in self._pieces.values() for piece in pieces))

    def weights_of(self, piece: Piece) -> list[str]:
        """Return the names of the rigid links that weigh on a piece."""
        return self._weights_of.get(piece, [])

    def rigid_links_of(self, piece: Piece) -> list[str]:
        """Return the links without beams that a piece consists of."""
        return self._rigid_links_of.get(piece, [])

    def links_of(self, pieces: list[Piece], edges: list[PieceEdge]) -> tuple[str, ...]:
        """Return the links of some pieces and beams, in the order of the file."""
        found = {link for piece in pieces for link in self._links_of.get(piece, [])}
        found.update(edge.beam.beam.link for edge in edges if edge.beam is not None)
        return tuple(link for link in self.description.links if link in found)

    def weighs(self, link: str) -> bool:
        """Whether a link is rigid and weighs something."""
        return link not in self.beams_of and self.description.links[link].mass > 0

    # ---- construction -----------------------------------------------------------------------------------------------

    def _piece_at(self, link: str, point: Array) -> Piece | None:
        """Return the piece of a link at a point, None if the link has beams and none of them ends there."""
        pieces = self._pieces[link]
        if pieces[0].point is None:
            return pieces[0].find()
        for piece in pieces:
            if piece.point is not None and float(np.linalg.norm(piece.point - point)) < SAME_POINT:
                return piece.find()
        return None

    def _make_pieces(self) -> None:
        for link, data in self.description.links.items():
            if link not in self.beams_of:
                self._pieces[link] = [Piece(link, weights=[link] if data.mass > 0 else [])]
                continue
            self._pieces[link] = []
            for beam in self.beams_of[link]:
                span = self.spans[beam.name]
                for owner, point in ((span.start_link, span.start), (span.end_link, span.end)):
                    if owner == link and (not self._pieces[link] or self._piece_at(link, point) is None):
                        self._pieces[link].append(Piece(link, point))
            if not self._pieces[link]:
                self._pieces[link] = [Piece(link)]

    def _make_edges(self) -> list[PieceEdge]:
        edges: list[PieceEdge] = []
        inside: set[str] = set()
        for beam in self.description.beams.values():
            span = self.spans[beam.name]
            start, end = self._piece_at(span.start_link, span.start), self._piece_at(span.end_link, span.end)
            if start is None or end is None:
                raise beam_error(beam, "it ends in the middle of another beam; split that beam with a fixed joint")
            inside.update(item.name for item in (*span.inward, *span.outward))
            for path, piece in ((span.inward, start), (span.outward, end)):
                link = beam.link
                for item in path[:-1]:  # links in mid-span go with the end on their side
                    link = item.other(link)
                    for other in self._pieces[link]:
                        if other.find() is not piece.find():
                            other.find().merged = piece.find()
            if self._pieces[beam.link][0].point is None and self._pieces[beam.link][0].find() not in (start, end):
                self._pieces[beam.link][0].find().merged = start.find()
            edges.append(PieceEdge(start, end, beam=span))
        for connection in self.mechanism.connections.values():
            if connection.name in inside:
                continue
            ends: list[Piece] = []
            missing: list[str] = []
            for link in (connection.predecessor, connection.successor):
                found = self._piece_at(link, connection.centre_on(link))
                if found is None:
                    missing.append(link)
                ends.append(found or self._nearest_piece(link, connection.centre_on(link)))
            edge = PieceEdge(ends[0], ends[1], connection=connection)
            edges.append(edge)
            self.misplaced.extend((edge, connection, link) for link in missing)
        return edges

    def _in_order(self, edges: list[PieceEdge]) -> list[PieceEdge]:
        """Sort joints by the places of their links in the file, be they joints of its tree or loops; beams stay first."""
        order: dict[Piece, int] = {}
        for number, pieces in enumerate(self._pieces.values()):
            for piece in pieces:
                order.setdefault(piece.find(), number)

        def place(edge: PieceEdge) -> list[int]:
            return [] if edge.beam is not None else sorted((order[edge.inner.find()], order[edge.outer.find()]))

        return sorted(edges, key=place)

    def _nearest_piece(self, link: str, point: Array) -> Piece:
        def distance(piece: Piece) -> float:
            return float(np.linalg.norm(point - piece.point)) if piece.point is not None else 0.0

        return min(self._pieces[link], key=distance).find()

    def _merge(self, links: set[str]) -> Piece:
        pieces = [self._pieces[link][0].find() for link in self.description.links if link in links]
        for piece in pieces[1:]:
            if piece is not pieces[0]:
                piece.merged = pieces[0]
        return pieces[0]
