"""Beams: data that do not depend on the pose, and the lengths and masses that do."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import axis_across, dot
from kinetostatics.mechanism.beam_geometry import SAME_POINT, BeamSpan, beam_error
from kinetostatics.mechanism.mechanism import Mechanism
from kinetostatics.mechanism.tree import Frames
from kinetostatics.sections.kinds import beam_compliance_coefficients

if TYPE_CHECKING:
    import pinocchio as pin

#: Length, relative to the coordinates of the beam's ends, that counts as zero.
ROUNDING = 1e-9


@dataclass(frozen=True, repr=False)
class BeamModel(ShortRepr):
    """Data of a beam, independent of the pose.

    Attributes:
        axes: (3, 3) beam axes x, y, z as columns, in the carrier body.
        compliances: (6,) section compliances.
        mass_per_length: mass per length [kg/m], or None if the total ``mass`` is given.
        mass: total mass [kg] if ``mass_per_length`` is None, distributed uniformly over the length at every pose; else 0.
        centre: (3,) centre of ``mass`` in the carrier body [m]. The mass, rigidly connected to the sections, is distributed along
            the line through this centre parallel to the beam. None: the mass is distributed along the beam.
    """

    name: str
    span: BeamSpan
    axes: Array
    compliances: Array
    mass_per_length: float | None
    mass: float
    centre: Array | None

    def length(self, frames: Frames) -> Array:
        """(N,) [m], the component of the vector from start to end along the beam's x axis."""
        start, end = self.ends(frames)
        return dot(frames.direction(self.span.carrier, self.axes[:, 0]), end - start)

    def ends(self, frames: Frames) -> tuple[Array, Array]:
        """Positions (3, N) [m] of start and end, world axes."""
        return frames.point(self.span.start_body, self.span.start), frames.point(self.span.end_body, self.span.end)

    def world_axes(self, frames: Frames) -> Array:
        """Beam axes x, y, z as columns (3, 3, N), world axes."""
        return frames.orientations(np.array([self.span.carrier]), self.axes[:, :, None])[:, :, 0]

    @property
    def telescopic(self) -> bool:
        return self.span.start_body != self.span.end_body

    def remaining_length(self, frames: Frames) -> Array:
        """The length (N,) [m], 0 if it is only rounding; negative if a telescopic beam is retracted beyond zero length."""
        length = self.length(frames)
        rounding = ROUNDING * np.max(np.abs(np.stack(self.ends(frames))), axis=(0, 1))
        return np.where(np.abs(length) <= rounding, 0.0, length)

    def mass_at(self, frames: Frames) -> Array:
        return self.mass_of(self.length(frames))

    def mass_of(self, length: Array) -> Array:
        """Mass [kg] of a beam of the given length (…) [m]; for a beam with a density, zero if the length is negative."""
        return np.full_like(length, self.mass) if self.mass_per_length is None else self.mass_per_length * np.maximum(length, 0)

    def line_density(self, length: Array) -> Array:
        """Mass per length [kg/m] of a beam of the given length (…) [m]; infinite for a given mass and zero length."""
        if self.mass_per_length is not None:
            return np.full_like(length, self.mass_per_length)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.mass / length)

    def lever(self, frames: Frames) -> Array:
        """Arm (3, N) [m] from the middle of the beam to its centre of mass, world axes."""
        start, end = self.ends(frames)
        return np.zeros_like(start) if self.centre is None else frames.point(self.span.carrier, self.centre) - (start + end) / 2

    def rod(self, frames: Frames) -> tuple[int, pin.Inertia]:
        """Return the beam as a rigid prism at one pose: the carrier body, and the prism's ``pin.Inertia`` in this body.

        About the prism's centre, the moments of inertia are m (I_y + I_z)/A along the axis and m (L²/12 + I/A) across.
        """
        import pinocchio as pin

        span, section = self.span, self.span.beam.section
        start, end = self.ends(frames)
        R, p = frames.rotation[:, :, span.carrier, 0], frames.position[:, span.carrier, 0]
        centre = ((start + end) / 2 + self.lever(frames))[:, 0]
        length, mass = float(self.length(frames)[0]), float(self.mass_at(frames)[0])
        about = np.array([section.I_y + section.I_z, section.I_y, section.I_z]) / section.area
        about[1:] += length**2 / 12
        own = mass * self.axes @ np.diag(about) @ self.axes.T
        return span.carrier, pin.Inertia(mass, R.T @ (centre - p), own)


def no_length_text(beams: Iterable[BeamModel], frames: Frames, pose: int) -> str | None:
    """Return an error message that names the telescopic beams without length at a pose; None if there is none."""
    short = {beam.name: float(beam.remaining_length(frames)[pose]) for beam in beams if beam.telescopic}
    named = ", ".join(f"{name!r} ({length:.3g} m from start to end)" for name, length in short.items() if length <= 0)
    return f"telescopic beams have no length at this pose: {named}" if named else None


def make_beam_models(mechanism: Mechanism, spans: dict[str, BeamSpan], zero: Frames) -> dict[str, BeamModel]:
    """Return the data of all beams; the closed pose ``zero`` determines the direction of telescopic beams.

    Raises:
        RobotFileError: a prismatic joint of a telescopic beam is not parallel to the beam, or a beam's ``y_axis`` is parallel
            to the beam.
    """
    models = {}
    middles: dict[str, tuple[float, Array]] = {}
    for name, span in spans.items():
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
                    span.beam,
                    f"the axis of the prismatic joint {joint!r} inside its span does not lie along the beam; "
                    f"it is ({', '.join(f'{value:.4g}' for value in connection.axis)}) in the joint's frame (1 0 0 where <axis> "
                    "is left out): is it, or the joint's <parent> or <origin>, wrong?",
                )
            direction = axis if float(axis @ direction) > 0 else -axis
        R = zero.rotation[:, :, span.carrier, 0]
        x = R.T @ (direction / np.linalg.norm(direction))
        placement = mechanism.body_of[span.beam.link][1]
        given = span.beam.y_axis
        hint = placement[:3, :3] @ (np.array(given) if given is not None else axis_across(placement[:3, :3].T @ x))
        y = hint - x * float(x @ hint)
        if float(np.linalg.norm(y)) < 1e-6 * float(np.linalg.norm(hint)):
            raise beam_error(span.beam, "its y_axis is parallel to the beam")
        y /= np.linalg.norm(y)
        beam, axes = span.beam, np.column_stack([x, y, np.cross(x, y)])
        coefficients = beam_compliance_coefficients(beam.section, beam.youngs_modulus, beam.shear_modulus, beam.shear_areas)
        middles[name] = float(np.linalg.norm(end - start)), R.T @ ((start + end) / 2 - zero.position[:, span.carrier, 0])
        per_length = None if beam.density is None else beam.density * beam.section.area
        models[name] = BeamModel(name, span, axes, coefficients, per_length, 0.0, None)
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
    link = model.span.beam.link
    siblings = [middles[name] for name, item in models.items() if item.span.beam.link == link]
    whole = max(sum(length for length, _ in siblings), 1e-300)
    length, middle = middles[model.name]
    placement, own = mechanism.body_of[link][1], mechanism.description.links[link]
    centre = placement[:3, :3] @ np.array(own.center_of_mass) + placement[:3, 3]
    if len(siblings) == 1:
        return replace(model, mass=own.mass, centre=centre)
    mean = sum((length * at for length, at in siblings), np.zeros(3)) / whole
    return replace(model, mass=own.mass * length / whole, centre=centre + middle - mean)
