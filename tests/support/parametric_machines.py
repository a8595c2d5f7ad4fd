"""Robot files with xacro arguments, of which closed forms are known."""

import textwrap

HEAD = '<robot name="{}" xmlns:xacro="http://www.ros.org/wiki/xacro">'
BEAM = 'youngs_modulus="$(arg E)" poisson_ratio="0.3" shear_coefficient="inf"'
INERTIA = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'


def cantilever(folder):
    """A round rod from the base along x, clamped; the platform is its tip."""
    text = f"""\
        {HEAD.format("cantilever")}
          <xacro:arg name="length" default="0.8"/><xacro:arg name="diameter" default="0.04"/>
          <xacro:arg name="E" default="2e11"/><xacro:arg name="density" default="7850"/>
          <xacro:arg name="tip_mass" default="5"/><xacro:arg name="colour" default="red"/><xacro:arg name="holes" default="0"/>
          <link name="base"/><link name="rod"/>
          <link name="tip"><inertial><mass value="$(arg tip_mass)"/>{INERTIA}</inertial></link>
          <joint name="clamp" type="fixed"><parent link="base"/><child link="rod"/></joint>
          <joint name="end" type="fixed"><parent link="rod"/><child link="tip"/><origin xyz="$(arg length) 0 0"/></joint>
          <beam link="rod" from="clamp" to="end" density="$(arg density)" {BEAM}><circle diameter="$(arg diameter)"/></beam>
          <platform link="tip"/>
        </robot>"""
    path = folder / "cantilever.urdf.xacro"
    path.write_text(textwrap.dedent(text), encoding="utf-8")
    return path
