"""Code and data with which a page computes: it moves the robot, solves the equilibrium, and draws the result."""

from __future__ import annotations

import hashlib
import json
import pickle
from collections.abc import Mapping, Sequence

import numpy as np

from kinetostatics.engine.code import code_key, read_stored, store
from kinetostatics.engine.scalars import NotRecordedError
from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.alternatives import measured_choices
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.solver import MOST_CORRECTIONS, SHRINKING
from kinetostatics.results.result import Result
from kinetostatics.statics.inertia import INERTIA
from kinetostatics.viewer.packing import packed_code
from kinetostatics.viewer.page_programs import PageRobot
from kinetostatics.viewer.variations import Variations, vary_result

#: Least measure of well-conditioned coordinates, as a part of the largest one.
WELL = 0.1


def computing_page(result: Result, by_mechanism: bool = False, vary: Mapping[str, object] | None = None) -> dict[str, object]:
    """Return code and data with which a page computes results like ``result``, a single pose.

    Args:
        by_mechanism: whether the weight of each limb has two contributions, see :attr:`Result.by_mechanism`.
        vary: see :func:`kinetostatics.show`.

    Raises:
        NotRecordedError: loops, statics or loads cannot be recorded; the message gives the reason.
        ArgumentError: ``vary`` is invalid, or changes the robot in another way than by numbers.
    """
    robot, configuration = result.robot, result.configuration
    solution = result.solutions[0]
    if solution.assembly_errors is not None or INERTIA in solution.contributions:
        raise NotRecordedError("the result has assembly errors or a motion")
    carrier, mechanism = None if result.payload is None else result.payload.link, "by mechanism" * by_mechanism
    coordinates = configuration.prescribed or determining_coordinates(configuration)
    digest = hashlib.sha256(pickle.dumps((robot.description, configuration.orientation, result.loads)))
    key = code_key(f"page {digest.hexdigest()} {coordinates} {carrier} {mechanism}")
    stored = read_stored(key) if vary is None else None
    if stored is None:
        variations = Variations((), (result,), 0) if vary is None else vary_result(result, vary)
        stored = json.dumps(_recorded(variations, coordinates, by_mechanism)).encode()
        if vary is None:
            store(key, stored)
    return {
        **json.loads(stored),
        "x": configuration.poses.x[:, 0].tolist(),
        "c": configuration.poses.c[:, 0].tolist(),
        "load": result.load.tolist(),
        "gravity": result.gravity.tolist(),
        "payload": _payload_of(result),
        "carrier": carrier,
        "mass": float(robot.weights.masses(configuration.frames).sum()),
    }


def _recorded(variations: Variations, coordinates: Sequence[str], by_mechanism: bool) -> dict[str, object]:
    """Return the code, and the data that depend neither on pose nor on loads."""
    robots = [None if result is None else PageRobot(result, coordinates) for result in variations.results]
    given = robots[variations.given]
    assert given is not None
    alike = [robot for robot in robots if robot is not None and (robot is given or robot.is_like(given))]
    names = " and ".join(name for slider in variations.sliders for name in slider.names)
    varying = {kind: np.ptp([robot.structures[kind].values for robot in alike], axis=0) > 0 for kind in given.structures}
    size = given.size if variations.sliders else None
    programs, modules = given.programs(varying, size, by_mechanism)

    def differ(some: set[PageRobot]) -> set[PageRobot]:
        return {robot for robot in some if robot is not given and robot.programs(varying, size, by_mechanism)[1] != modules}

    ends = {alike[0], alike[-1]}
    if others := differ(ends):  # for instance with a mass of zero
        alike = [robot for robot in alike if robot not in others]
        if differ({alike[0], alike[-1]} - ends):
            raise ArgumentError(f"vary: with some values of {names} other formulas apply, which a page cannot follow")
    if len(robots) > 1 and alike == [given]:
        raise ArgumentError(
            f"vary: with all other values of {names} the robot cannot be assembled at this pose, or other formulas apply, which "
            "a page cannot follow"
        )
    changing = [k for k, mesh in enumerate(given.meshes) if any(robot.meshes[k] != mesh for robot in alike)] if alike[1:] else []
    shapes = list(dict.fromkeys(robot.meshes[k][1] for robot in alike for k in changing))
    return {
        **programs,
        "meshes": [given.meshes[k][0] for k in changing],
        "shapes": list(map(json.loads, shapes)),
        "robots": [
            {**robot.numbers(varying), "shapes": [shapes.index(robot.meshes[k][1]) for k in changing]} if robot in alike else None
            for robot in robots
        ],
        "robot": variations.given,
        "sliders": [{"name": "+".join(slider.names), "texts": slider.texts, "at": slider.at} for slider in variations.sliders],
        "shrinking": SHRINKING,
        "most_corrections": MOST_CORRECTIONS,
        "code": packed_code(modules),
    }


def determining_coordinates(pose: Configuration) -> tuple[str, ...]:
    """Of the well-conditioned sets of platform coordinates that determine a pose, return the one with the most angles."""
    convention = pose.orientation
    measures = measured_choices(pose.robot, convention, pose.poses)
    least = WELL * max(measures.values(), default=0.0)
    good = [coordinates for coordinates, measure in measures.items() if measure >= least]
    coordinates = min(good, key=lambda coordinates: sum(name in "xyz" for name in coordinates), default=())
    return tuple(sorted(coordinates, key=convention.pose_names.index))


def _payload_of(result: Result) -> list[float]:
    if result.payload is None:
        return [0.0] * 4
    return [float(np.asarray(result.payload.mass)), *np.asarray(result.payload.center, dtype=float).tolist()]
