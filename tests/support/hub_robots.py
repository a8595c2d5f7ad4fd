"""Random robots for the tests: limbs with a link (*hub*) that three to five joints connect to base, platform, or a free mass."""

import numpy as np
from simple_machines import BEAM, joint, link, loop
from simple_machines import robot as robot_of


def _words(vector):
    return " ".join(f"{number:.17g}" for number in vector)


def _beam(of, start, end, name, diameter):
    ends = f'from="{start}" to="{end}"'
    return f'<beam name="{name}" link="{of}" {ends} density="7850" {BEAM}><circle diameter="{diameter}"/></beam>'


def hub_parts(seed, ports=None, kinds=("base", "platform", "end"), points=None):
    """Return elements of a robot file without the elasticity of the hub, names and points of its ports, and what is at each."""
    rng = np.random.default_rng(seed)
    ports = int(rng.integers(3, 6)) if ports is None else ports
    points = np.vstack([np.zeros(3), rng.uniform(-0.4, 0.4, (ports - 1, 3))]) if points is None else points
    targets = ["base", "platform", *(str(rng.choice(kinds)) for _ in range(ports - 2))]
    foot, step = rng.uniform(-0.5, 0.5, 3), rng.uniform(-0.3, 0.3, 3)
    hub_at, names = foot + step, ["head", *(f"port_{k}" for k in range(1, ports))]
    parts = [link("base"), link("hub"), link("platform", 3.0, "0.05 0.02 0.01"), link("leg_0")]
    parts += [joint("foot", "revolute", "base", "leg_0", _words(foot), _words(rng.normal(size=3)))]
    parts += [joint("head", "fixed", "leg_0", "hub", _words(step)), _beam("leg_0", "foot", "head", "leg_0", 0.05)]
    parts += ['<transmission name="t"><joint name="foot"/></transmission>']
    platform_at = np.zeros(3)
    for k in range(1, ports):
        target, leg, step, axis = targets[k], f"leg_{k}", rng.uniform(-0.3, 0.3, 3), _words(rng.normal(size=3))
        near, far = (str(rng.choice(some)) for some in (["fixed", "revolute", "spherical"], ["fixed", "revolute"]))
        there = hub_at + points[k] + step
        parts += [link(leg), _beam(leg, names[k], f"far_{k}", leg, 0.04)]
        if k == 1 or target == "end":
            end = "platform" if k == 1 else f"mass_{k}"
            parts += [] if k == 1 else [link(end, 2.0, "0.1 0.05 0")]
            parts += [joint(names[k], "fixed", "hub", leg, _words(points[k])), joint(f"far_{k}", "fixed", leg, end, _words(step))]
            platform_at = there if k == 1 else platform_at
            continue
        at = there - (0 if target == "base" else platform_at)
        if near == "spherical":
            parts.append(loop(names[k], near, "hub", leg, _words(points[k]), _words(-step)))
            parts.append(joint(f"far_{k}", far, target, leg, _words(at), axis))
        else:
            parts.append(joint(names[k], near, "hub", leg, _words(points[k]), axis))
            parts.append(loop(f"far_{k}", far, leg, target, _words(step), _words(at), axis if far == "revolute" else None))
    return parts, names, points, targets


def hub_robot(seed):
    """Return a robot whose hub is a ring of beams between its ports."""
    parts, names, _, targets = hub_parts(seed)
    order = [names[k] for k in np.random.default_rng(seed).permutation(len(names))]
    pairs = zip(order, [*order[1:], order[0]], strict=True)
    beams = [_beam("hub", first, second, f"hub_{k}", 0.03 + 0.01 * k) for k, (first, second) in enumerate(pairs)]
    return robot_of(*parts, *beams), targets
