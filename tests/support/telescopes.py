"""A mast of two telescopes in series, both driven, by their lengths at zero."""

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
