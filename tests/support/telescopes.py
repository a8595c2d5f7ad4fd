"""A mast of two telescopes in series, both actuated, by their lengths at zero."""

import kinetostatics as ks
from kinetostatics.files.reader import parse_robot_text


def mast(scale: float = 1.0, names: str = "ab") -> ks.Robot:
    """Return the mast, or its lower telescope alone; they are 0.5 m long at zero, times ``scale``."""
    parts, parent = ['<robot name="mast"><link name="ground"/>'], "ground"
    for name in names:
        parts.append(
            f'<link name="sleeve_{name}"/><joint name="foot_{name}" type="fixed"><parent link="{parent}"/>'
            f'<child link="sleeve_{name}"/></joint><link name="rod_{name}"/><joint name="slide_{name}" type="prismatic">'
            f'<parent link="sleeve_{name}"/><child link="rod_{name}"/><origin xyz="0 0 {0.5 * scale!r}"/><axis xyz="0 0 1"/>'
            '<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>'
            f'<beam link="sleeve_{name}" name="beam_{name}" from="foot_{name}" to="head_{name}" youngs_modulus="210e9" '
            'poisson_ratio="0.3" density="7850"><circle diameter="0.02"/></beam>'
            f'<transmission name="drive_{name}"><joint name="slide_{name}"/></transmission>'
            f'<link name="end_{name}"/><joint name="head_{name}" type="fixed"><parent link="rod_{name}"/>'
            f'<child link="end_{name}"/></joint>'
        )
        parent = f"end_{name}"
    return ks.Robot(
        parse_robot_text("".join([*parts, '<base link="ground"/>', f'<platform link="{parent}"/></robot>']), "mast.urdf")
    )


#: A link without mass, and a beam's material.
_STEEL = 'youngs_modulus="210e9" poisson_ratio="0.3"'


def _link(name: str, mass: float = 0.0, center: str = "0 0 0") -> str:
    if not mass:
        return f'<link name="{name}"/>'
    inertia = '<inertia ixx="0.02" ixy="0.003" ixz="-0.002" iyy="0.03" iyz="0.001" izz="0.025"/>'
    return f'<link name="{name}"><inertial><origin xyz="{center}"/><mass value="{mass}"/>{inertia}</inertial></link>'


def _joint(name: str, kind: str, parent: str, child: str, axis: str = "0 0 1", xyz: str = "0 0 0") -> str:
    more = f'<axis xyz="{axis}"/><limit lower="-3" upper="3" effort="1" velocity="1"/>' if kind != "fixed" else ""
    actuated = f'<transmission name="drive_{name}"><joint name="{name}"/></transmission>' if kind != "fixed" else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}"/>{more}</joint>'
        + actuated
    )


def reaching_arm(beam_link: str = "rod", density: str = 'density="7850"', mass: float = 0.0, two_beams: bool = False) -> ks.Robot:
    """Return an arm that turns, nods and reaches: pan, nod, and a telescope of 0.4 m and the reach, with a mass at its tip.

    The telescope is one beam of the cylinder or of the rod, with a density or with the ``mass`` of its link; or, with
    ``two_beams``, a tube of 0.3 m and a rod of 0.4 m.
    """
    parts = [_link("ground"), _link("post"), _link("tip", 1.5, "0.03 0.02 -0.01")]
    parts += [_link(name, mass if name == beam_link else 0.0, "0.2 0.05 0.02") for name in ("cylinder", "rod")]
    parts += [_joint("pan", "revolute", "ground", "post"), _joint("nod", "revolute", "post", "cylinder", "0 1 0", "0.1 0 0.2")]
    if two_beams:
        parts += [_link("mouth"), _joint("weld", "fixed", "cylinder", "mouth", xyz="0.3 0 0")]
        parts += [f'<beam link="cylinder" {_STEEL} density="7850"><tube outer_diameter="0.05" inner_diameter="0.03"/></beam>']
        parts += [f'<beam link="rod" {_STEEL} density="7850"><circle diameter="0.03"/></beam>']
        parts += [_joint("reach", "prismatic", "mouth", "rod", "1 0 0", "-0.3 0 0")]
    else:
        parts += [
            f'<beam link="{beam_link}" from="nod" to="head" {_STEEL} {density}><circle diameter="0.03"/></beam>',
            _joint("reach", "prismatic", "cylinder", "rod", "1 0 0"),
        ]
    parts += [_joint("head", "fixed", "rod", "tip", xyz="0.4 0 0"), '<platform link="tip"/>']
    return ks.Robot(parse_robot_text(f'<robot name="arm">{"".join(parts)}</robot>', "arm.urdf"))
