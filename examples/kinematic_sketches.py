"""Draw kinematic sketches: joints as usual symbols, links as lines, the base hatched, actuators in red.

python examples/kinematic_sketches.py delta my_robot.urdf     # delta.svg and my_robot.svg in this folder
python examples/kinematic_sketches.py --docs                  # those of the gallery
"""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray

import kinetostatics as ks
from kinetostatics.description.joint_types import JOINT_TYPES

Array = NDArray[np.float64]

DOCS = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "sketches"
#: View: rotation about Z, then tilt downwards [rad].
TURNED, TILTED = np.radians(-52), np.radians(24)
INK, ACTUATOR, PLATFORM, BASE = "#26323f", "#c62828", "#2a9d8f", "#8a94a0"


@dataclass
class Symbol:
    """Joints at one point: numbers of rotations and translations, direction, and bodies."""

    point: Array
    axis: Array
    bodies: set[str]
    turns: int = 0
    slides: int = 0
    actuated: bool = False


def seen(points: Array) -> Array:
    """Return the projection (…, 2) of points (…, 3)."""
    c, s = np.cos(TURNED), np.sin(TURNED)
    right, depth = c * points[..., 0] - s * points[..., 1], s * points[..., 0] + c * points[..., 1]
    return np.stack([right, np.cos(TILTED) * points[..., 2] + np.sin(TILTED) * depth], axis=-1)


def bodies_of(robot: ks.Robot) -> dict[str, str]:
    """Return the first link of the rigid body that each link belongs to."""
    first = {link: link for link in robot.description.links}

    def find(link: str) -> str:
        return link if first[link] == link else find(first[link])

    for joint in robot.description.joints.values():
        if JOINT_TYPES[joint.type].is_fixed:
            first[find(joint.child)] = find(joint.parent)
    for loop in robot.description.loops.values():
        if JOINT_TYPES[loop.type].is_fixed:
            first[find(loop.successor)] = find(loop.predecessor)
    return {link: find(link) for link in first}


def symbols_of(robot: ks.Robot, pose: ks.Configuration) -> list[Symbol]:
    """Return the symbols, runs of joints at one point as one."""
    body = bodies_of(robot)
    size = float(np.max([np.abs(pose.frame(link)[:3, 3]) for link in body]))
    found: list[Symbol] = []
    joints = [(j.name, j.type, j.parent, j.child, j.origin, j.axis) for j in robot.description.joints.values()]
    loops = [(p.name, p.type, p.predecessor, p.successor, p.predecessor_origin, p.axis) for p in robot.description.loops.values()]
    for name, kind, near, far, origin, axis in (*joints, *loops):
        row = JOINT_TYPES[kind]
        if row.is_fixed or row.is_free:
            continue
        frame = pose.frame(near) @ origin.matrix
        direction = frame[:3, :3] @ np.array(axis if axis is not None else (0.0, 0.0, 1.0))
        # a tree joint that slides stands where its child is
        point = pose.frame(far)[:3, 3] if name in robot.description.joints else frame[:3, 3]
        new = Symbol(
            point, direction, {body[near], body[far]}, row.turns.count, row.slides.count, name in robot.description.actuated
        )
        for old in found:
            meets = np.linalg.norm(old.point - point) < 1e-6 * size and old.bodies & new.bodies
            if meets and not old.slides and not new.slides and old.turns + new.turns <= 3:
                old.turns, old.bodies, old.actuated = old.turns + new.turns, old.bodies ^ new.bodies, old.actuated or new.actuated
                break
        else:
            found.append(new)
    return found


def placed(symbols: list[Symbol], base: str) -> None:
    """Put telescopes' slides halfway between the joints beside them: in the file they may stand at an end."""
    at = defaultdict(list)
    for symbol in symbols:
        for name in symbol.bodies:
            at[name].append(symbol)
    for symbol in symbols:
        if symbol.slides and base not in symbol.bodies:
            sides = [
                np.mean([other.point for other in at[name] if other is not symbol] or [symbol.point], axis=0)
                for name in symbol.bodies
            ]
            symbol.point = np.mean(sides, axis=0)


def draw(robot: ks.Robot, ax: Axes) -> None:
    """Draw a robot at its zero pose."""
    pose = robot.assemble()
    symbols = symbols_of(robot, pose)
    body = bodies_of(robot)
    base, platform = body[robot.description.base], body[robot.description.platform]
    placed(symbols, base)
    o = pose.frame(robot.description.platform)[:3, 3]
    points = seen(np.array([symbol.point for symbol in symbols] + [o]))
    size = float(np.max(np.ptp(points, axis=0))) / 40
    members = defaultdict(list)
    for symbol in symbols:
        for name in symbol.bodies:
            members[name].append(symbol.point)
    for name, ends in members.items():
        flat = seen(np.array([*ends, o] if name == platform and len(ends) < 3 else ends))
        if name == base:
            continue
        if name == platform and len(flat) > 2:
            middle = flat - flat.mean(axis=0)
            order = np.argsort(np.arctan2(middle[:, 1], middle[:, 0]))
            ax.add_patch(Polygon(flat[order], closed=True, facecolor=PLATFORM, alpha=0.35, edgecolor=PLATFORM, lw=2, zorder=1))
        elif len(flat) == 2:
            ax.plot(*flat.T, color=PLATFORM if name == platform else INK, lw=2.2, solid_capstyle="round", zorder=2)
        else:
            for end in flat:
                ax.plot(*np.array([end, flat.mean(axis=0)]).T, color=INK, lw=2.2, solid_capstyle="round", zorder=2)
    for symbol in symbols:
        _draw_symbol(ax, symbol, size, symbol.bodies & {base})
    ax.plot(*seen(o), marker="+", color=PLATFORM, ms=9, mew=1.6, zorder=6)
    ax.set_aspect("equal")
    ax.margins(0.08)
    ax.set_axis_off()


def _draw_symbol(ax: Axes, symbol: Symbol, size: float, on_base: Collection[str]) -> None:
    x, y = seen(symbol.point)
    colour = ACTUATOR if symbol.actuated else INK
    along = seen(symbol.axis)
    angle = float(np.arctan2(along[1], along[0]))
    if on_base:  # a hatched foot below
        below = y - 1.6 * size
        ax.plot([x - 1.8 * size, x + 1.8 * size], [below, below], color=BASE, lw=1.6, zorder=1)
        ax.plot([x, x], [below, y], color=BASE, lw=1.6, zorder=1)
        for k in np.linspace(-1.5, 1.5, 5):
            ax.plot([x + k * size, x + (k - 0.7) * size], [below, below - 0.8 * size], color=BASE, lw=1, zorder=1)
    if symbol.slides:
        turned = Affine2D().rotate(angle).translate(x, y)
        box = turned.transform(np.array([[-1.6, -0.7], [1.6, -0.7], [1.6, 0.7], [-1.6, 0.7]]) * size)
        ax.add_patch(Polygon(box, closed=True, facecolor="white", edgecolor=colour, lw=2, zorder=4))
        ax.plot(*turned.transform(np.array([[-2.4, 0], [2.4, 0]]) * size).T, color=colour, lw=1, zorder=5)
    if symbol.turns == 1 and not symbol.slides:
        ax.plot(*(np.array([[x, y]]) + np.outer([-2.2, 2.2], along * size)).T, color=colour, lw=1.2, ls=(0, (4, 1.5)), zorder=4)
        ax.plot(x, y, marker="o", ms=8, mfc="white", mec=colour, mew=2, zorder=5)
    elif symbol.turns == 2:
        ax.plot(x, y, marker="o", ms=9, mfc="white", mec=colour, mew=1.8, zorder=5)
        ax.plot(x, y, marker="x", ms=6, color=colour, mew=1.8, zorder=6)
    elif symbol.turns >= 3:
        ax.plot(x, y, marker="o", ms=9, color=colour, zorder=5)


def save(robot: ks.Robot, path: Path) -> None:
    """Write the sketch of a robot."""
    with plt.rc_context({"svg.hashsalt": "kinetostatics", "svg.fonttype": "none"}):
        figure, ax = plt.subplots(figsize=(4.2, 3.6))
        draw(robot, ax)
        figure.savefig(path, bbox_inches="tight", transparent=True, metadata={"Date": None} if path.suffix == ".svg" else None)
        plt.close(figure)


def main() -> None:
    """Draw the requested robots."""
    if sys.argv[1:] == ["--docs"]:
        DOCS.mkdir(exist_ok=True)
        for name in ks.robots():
            save(ks.load_robot(name), DOCS / f"{name}.svg")
        return
    for name in sys.argv[1:]:
        path = Path(f"{Path(name).name.split('.')[0]}.svg")
        save(ks.load_robot(name), path)
        print(f"wrote {path}")


if __name__ == "__main__":
    main()
