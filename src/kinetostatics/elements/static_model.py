"""The data of a robot for limbs and statics, independent of poses: elastic links made from its description, and weights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, cast

import numpy as np

from kinetostatics.description.flexible import Flexible
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.elements.beam import BeamModel, beams_of
from kinetostatics.elements.link import ElasticLink, PlacedLink
from kinetostatics.elements.matrix_link import matrix_links
from kinetostatics.elements.profile import profile_of
from kinetostatics.elements.weights import Weights
from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import axis_across
from kinetostatics.mechanism.beam_geometry import SAME_POINT, Span, attachment_of_end, beam_error
from kinetostatics.mechanism.limbs import Topology
from kinetostatics.mechanism.mechanism import Mechanism
from kinetostatics.mechanism.tree import Frames
from kinetostatics.sections.kinds import beam_compliance_coefficients
from kinetostatics.sections.tapered import Tapered


def make_elastic_links(mechanism: Mechanism, spans: Mapping[str, Span], zero: Frames) -> dict[str, ElasticLink]:
    """Return all elastic links; the closed pose ``zero`` determines the direction of telescopic beams.

    Raises:
        RobotFileError: an elastic link does not fit between its ends.
    """
    description = mechanism.description
    beams = make_beam_models(mechanism, spans, zero)
    others: dict[str, ElasticLink] = {}
    for name, part in description.flexible.items():
        if isinstance(part, Flexible):
            others |= matrix_links(part, mechanism, {key: span for key, span in spans.items() if span.part.name == name})
        else:
            others[name] = cast(PlacedLink, part).model(mechanism, spans[name], zero)
    return {name: beams[name] if name in beams else others[name] for name in spans}


def make_beam_models(mechanism: Mechanism, spans: Mapping[str, Span], zero: Frames) -> dict[str, BeamModel]:
    """Return the data of all beams; the closed pose ``zero`` determines the direction of telescopic beams.

    Raises:
        RobotFileError: a prismatic joint of a telescopic beam is not parallel to the beam, or a beam's ``y_axis`` is parallel
            to the beam.
    """
    models: dict[str, BeamModel] = {}
    middles: dict[str, tuple[float, Array]] = {}
    for name, beam in mechanism.description.beams.items():
        span = spans[name]
        start = zero.point(span.start_body, span.start)[:, 0]
        end = zero.point(span.end_body, span.end)[:, 0]
        direction = end - start
        for joint in span.spanned:
            connection = mechanism.connections[joint]
            axis = zero.direction(connection.predecessor_body, connection.axis_on(True))[:, 0]
            if float(np.linalg.norm(direction)) < SAME_POINT:
                direction = axis
            if float(np.linalg.norm(np.cross(axis, direction))) > 1e-5 * float(np.linalg.norm(direction)):
                raise beam_error(
                    span.part,
                    f"the axis of the prismatic joint {joint!r} inside its span does not lie along the beam; "
                    f"it is ({', '.join(f'{value:.4g}' for value in connection.axis)}) in the joint's frame (1 0 0 where <axis> "
                    "is left out): is it, or the joint's <parent> or <origin>, wrong?",
                )
            direction = axis if float(axis @ direction) > 0 else -axis
        R = zero.rotation[:, :, span.carrier, 0]
        x = R.T @ (direction / np.linalg.norm(direction))
        placement = mechanism.body_of[span.part.link][1]
        given = beam.y_axis
        hint = placement[:3, :3] @ (np.array(given) if given is not None else axis_across(placement[:3, :3].T @ x))
        beam.check_direction(placement[:3, :3].T @ x)
        y = hint - x * float(x @ hint)
        y /= np.linalg.norm(y)
        axes = np.column_stack([x, y, np.cross(x, y)])
        middles[name] = float(np.linalg.norm(end - start)), R.T @ ((start + end) / 2 - zero.position[:, span.carrier, 0])
        section, profile, centre = beam.section, None, None
        if isinstance(section, Tapered):
            if span.spanned:
                raise beam_error(
                    span.part, "its section varies; a telescopic beam has one section: give one, or each link its beam"
                )
            section = section if span.attachments[0] == attachment_of_end(name, 0) else section.reversed
            profile = profile_of(beam, section, middles[name][0])
            coefficients = profile.compliances.diagonal(axis1=1, axis2=2).max(axis=0)
            centre = R.T @ (start - zero.position[:, span.carrier, 0]) + axes @ profile.centre
        else:
            coefficients = beam_compliance_coefficients(section, beam.youngs_modulus, beam.shear_modulus, beam.shear_areas)
        per_length, expansion = None if beam.density is None else beam.density * section.area, beam.thermal_expansion
        models[name] = BeamModel(name, section, span, axes, coefficients, per_length, 0.0, centre, expansion, profile)
    return {name: _with_spread_mass(mechanism, model, models, middles) for name, model in models.items()}


def _with_spread_mass(
    mechanism: Mechanism, model: BeamModel, models: dict[str, BeamModel], middles: dict[str, tuple[float, Array]]
) -> BeamModel:
    """Return a beam with its mass. Without a density, the beams of a link share the link's mass in proportion to their lengths.

    The common centre of mass of these shares is the link's centre of mass. ``middles``: length [m] and middle (3,) [m] of every
    beam at the closed zero pose; the middle is in the carrier body.
    """
    if model.mass_per_length is not None:
        return model
    link = model.span.part.link
    siblings = [middles[name] for name, item in models.items() if item.span.part.link == link]
    whole = max(sum(length for length, _ in siblings), 1e-300)
    length, middle = middles[model.name]
    placement, own = mechanism.body_of[link][1], mechanism.description.links[link]
    centre = placement[:3, :3] @ np.array(own.center_of_mass) + placement[:3, 3]
    if len(siblings) == 1:
        return replace(model, mass=own.mass, centre=centre)
    mean = sum((length * at for length, at in siblings), np.zeros(3)) / whole
    return replace(model, mass=own.mass * length / whole, centre=centre + middle - mean)


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
