"""Sliders of a live page: their coordinates, and their reachable ranges.

The reachable range is the set of values that the robot reaches from the present pose when one coordinate changes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from kinetostatics.engine.programs import check_engine, compiled_loops
from kinetostatics.kinematics.alternatives import measured_choices
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.reach import End, find_ends
from kinetostatics.layout.report import Json
from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import orientation_named
from kinetostatics.math.screws import WRENCH_COMPONENTS
from kinetostatics.robot import robot_of
from kinetostatics.units import unit

#: Half the range of a slider whose reachable range is almost zero: as a part of the robot's size; as an angle [rad].
AROUND, TURN = 0.15, math.radians(30)
#: Extension of a slider's range beyond each end of the reachable range, as a part of that range.
BEYOND = 0.05
#: Part of the distance to a singular pose at which a slider stops; the singular pose itself cannot be analysed.
NEARLY = 0.999
#: Least measure of well-conditioned coordinates, as a part of the largest one.
WELL = 0.1
#: Units of sliders [m, rad].
MILLIMETRE, DEGREE = unit("mm").size, unit("deg").size


class Sliders:
    """The sliders of one robot: for actuators, for platform coordinates that determine the pose, and for a load.

    Attributes:
        coordinates: platform coordinates with sliders.
        factors: the unit of a slider in SI units, by kind ("platform", "actuators", "load") and coordinate.
    """

    def __init__(
        self, pose: Configuration, orientation: str | None, coordinates: Sequence[str], load: Array | None, size: float
    ) -> None:
        """Create the sliders at a pose; without ``coordinates``, :func:`determining_coordinates` chooses platform coordinates."""
        self.robot, self.orientation, self.size = robot_of(pose), orientation, size
        self.coordinates = tuple(coordinates) or determining_coordinates(pose, orientation)
        kinds = {"platform": self.coordinates, "actuators": tuple(self.robot.description.actuated)}
        self.factors = {(kind, name): self._factor(kind, name) for kind, names in kinds.items() for name in names}
        ends = self.reach(pose)
        self._controls = [self._slider(kind, name, ends, pose) for kind, name in self.factors]
        if load is not None:
            weight = 9.81 * float(self.robot.weights.masses(pose.frames).sum())
            self._controls += [self._load(k, name, load, weight) for k, name in enumerate(WRENCH_COMPONENTS)]
            self.factors |= {("load", name): 1.0 for name in WRENCH_COMPONENTS}

    def at(self, pose: Configuration, load: Array | None) -> list[dict[str, Json]]:
        """Return the data of all sliders, with the values of a pose and a load."""
        values = {("load", name): value for name, value in zip(WRENCH_COMPONENTS, () if load is None else load, strict=False)}
        for kind in ("platform", "actuators"):
            values |= {(kind, name): value for name, value in self.present(pose, kind).items()}
        keys = [(slider["kind"], slider["coordinate"]) for slider in self._controls]
        sliders = zip(self._controls, keys, strict=True)
        return [{**slider, "value": float(values[key]) / self.factors[key]} for slider, key in sliders]

    def present(self, pose: Configuration, kind: str) -> Mapping[str, Array]:
        """Return the platform coordinates or actuator positions of a pose [m, rad]."""
        return pose.platform_coordinates(self.orientation) if kind == "platform" else pose.actuators

    def reach(self, pose: Configuration, go_on: Callable[[], bool] = lambda: True) -> dict[str, dict[str, Json]]:
        """Return the two ends of each reachable range, in the slider's unit, and the reasons for them, by titles of sliders.

        The search stops, with an incomplete result, when ``go_on()`` returns false.
        """
        ranges: dict[str, dict[str, Json]] = {}
        for kind in ("platform", "actuators"):
            spans = self._spans(kind)
            lines = [(name, sign * span) for name, span in spans.items() for sign in (-1, 1)]
            displacements = {name: np.array([displacement * (name == moved) for moved, displacement in lines]) for name in spans}
            for (name, displacement), end in zip(lines, self.ends(pose, kind, displacements, go_on), strict=False):
                value = end.limit if end.joint == name else float(self.present(pose, kind)[name]) + end.part * displacement
                slider_range = ranges.setdefault(self._name(kind, name), {"reach": [], "ends": []})
                slider_range["reach"].append(value / self.factors[kind, name])
                slider_range["ends"].append(self.reason(end))
        return ranges

    def ends(
        self, pose: Configuration, kind: str, displacements: Mapping[str, Array], go_on: Callable[[], bool] = lambda: True
    ) -> list[End]:
        """Return :func:`.find_ends` from a pose; ends at singular poses, or where loops open, are moved back slightly."""
        chosen = compiled_loops(check_engine("auto"))
        ends = find_ends(pose, kind, displacements, self.orientation, chosen, go_on)
        return [end if end.reason in ("", "limit") else replace(end, part=NEARLY * end.part) for end in ends]

    def shortened(self, displacements: Mapping[str, Array], kind: str) -> dict[str, Array]:
        """Return displacements along lines, all divided by one number that brings them into the search range."""
        most = max(
            float(np.max(np.abs(displacement))) / span
            for displacement, span in zip(displacements.values(), self._spans(kind).values(), strict=True)
        )
        return {name: displacement / max(1.0, most) for name, displacement in displacements.items()}

    def _spans(self, kind: str) -> dict[str, float]:
        """Return the search range of each coordinate: the robot's size for a length, half a turn for an angle [m, rad]."""
        factors = {name: factor for (coordinate_kind, name), factor in self.factors.items() if coordinate_kind == kind}
        return {name: self.robot.size if factor == MILLIMETRE else math.pi for name, factor in factors.items()}

    def reason(self, end: End) -> str:
        if end.reason != "limit":
            return REASONS[end.reason]
        slides = self.robot.mechanism.connections[end.joint].type.is_slide
        return f"limit of {end.joint}, {written(end.limit, MILLIMETRE if slides else DEGREE)}"

    def _factor(self, kind: str, name: str) -> float:
        slides = name in "xyz" if kind == "platform" else self.robot.mechanism.connections[name].type.is_slide
        return MILLIMETRE if slides else DEGREE

    def _name(self, kind: str, name: str) -> str:
        word = "platform" if kind == "platform" else "actuator"
        return f"{word}: {name} [{'mm' if self.factors[kind, name] == MILLIMETRE else '°'}]"

    def _slider(self, kind: str, name: str, ends: Mapping[str, dict[str, Json]], pose: Configuration) -> dict[str, Json]:
        title, factor = self._name(kind, name), self.factors[kind, name]
        slider_range, step = ends[title], 0.1 if factor == MILLIMETRE else 0.01
        low, high = slider_range["reach"]
        beyond = [BEYOND * (high - low) * bool(why) for why in slider_range["ends"]]
        if high - low < 10 * step:
            beyond = [AROUND * self.size / factor if factor == MILLIMETRE else TURN / factor] * 2
        tick = 10.0 ** math.floor(math.log10(high - low + sum(beyond)) - 1)
        return {
            "kind": kind, "coordinate": name, "name": title, "step": step,
            "min": tick * math.floor((low - beyond[0]) / tick + 1e-6), "max": tick * math.ceil((high + beyond[1]) / tick - 1e-6),
            **slider_range,
        }  # fmt: skip

    def _load(self, k: int, name: str, load: Array, weight: float) -> dict[str, Json]:
        """Return the slider of load component ``k``; its range includes twice the load and, for forces, ``weight`` [N]."""
        force = max(2 * float(np.abs(load[:3]).max()), weight, 100.0)
        most = force if k < 3 else max(2 * float(np.abs(load[3:]).max()), 0.25 * force * self.size)
        step = 10.0 ** math.floor(math.log10(most) - 2)
        most = math.ceil(most / step) * step
        title = f"load: {name} [{'N' if k < 3 else 'N·m'}]"
        return {"kind": "load", "coordinate": name, "name": title, "step": step, "min": -most, "max": most}


def written(value: float, factor: float) -> str:
    """Return a value as text in mm or °; ``factor`` is the size of this unit [m, rad]."""
    unit = "\N{NO-BREAK SPACE}mm" if factor == MILLIMETRE else "°"
    return f"{round(value / factor, 1) + 0.0:.6g}{unit}".replace("-", "\N{MINUS SIGN}")


#: Reasons for the end of a slider besides joint limits.
REASONS = {
    "": "",  # no end
    "loops": "beyond that the robot cannot be assembled",
    "singular": "singular there: with the actuators locked the platform could move",
}


def determining_coordinates(pose: Configuration, orientation: str | None) -> tuple[str, ...]:
    """Of the well-conditioned sets of platform coordinates that determine a pose, return the one with the most angles."""
    convention = orientation_named(orientation)
    measures = measured_choices(robot_of(pose), convention, pose.poses)
    least = WELL * max(measures.values(), default=0.0)
    good = [coordinates for coordinates, measure in measures.items() if measure >= least]
    coordinates = min(good, key=lambda coordinates: sum(name in "xyz" for name in coordinates), default=())
    return tuple(sorted(coordinates, key=convention.pose_names.index))
