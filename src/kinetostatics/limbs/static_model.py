"""Immutable data of a robot for limbs and statics, independent of poses and kinematics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.elements.beam import BeamModel, beams_of
from kinetostatics.elements.link import ElasticLink
from kinetostatics.elements.weights import Weights
from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.mechanism.limbs import Topology
from kinetostatics.mechanism.mechanism import Mechanism
from kinetostatics.mechanism.tree import Frames


@dataclass(frozen=True, eq=False, repr=False)
class StaticModel(ShortRepr):
    """Data of a robot for its statics.

    Attributes:
        mechanism: bodies and connections.
        topology: limbs, and the bodies attached to base and platform.
        elastic_links: beams and other elastic links, by name.
        zero_frames: frames of the closed zero pose, a batch of one.
        length: characteristic length [m], which makes forces and moments comparable.
        rank_tolerance: relative singular value below which a direction is taken as dependent.
        closing_error: residual of the closed loops due to rounding in the file [scaled m, rad].
    """

    NOT_RECORDED: ClassVar = ("zero_frames", "example")

    mechanism: Mechanism
    topology: Topology
    elastic_links: Mapping[str, ElasticLink]
    weights: Weights
    zero_frames: Frames
    length: float
    rank_tolerance: float
    closing_error: float

    @cached_property
    def beams(self) -> Mapping[str, BeamModel]:
        """All beams by name."""
        return beams_of(self.elastic_links)

    @cached_property
    def description(self) -> RobotDescription:
        return self.mechanism.description
