"""Robots that cannot be analysed are drawn all the same."""

import numpy as np
import pytest
from browser_pages import packed_in

import kinetostatics as ks
from kinetostatics.cli import main as cli
from kinetostatics.viewer.scene import describe_scene
from kinetostatics.viewer.single_poses import UnloadedPose

CORNERS = [0.3 * np.array([np.cos(a), np.sin(a), 0]) for a in np.deg2rad([90, 210, 330])]


def planar(tmp_path, actuated=(1, 2, 3), corner=0.1, height=0.0):
    """A planar 3-RRR whose rods meet at the world's origin: with the motors locked the platform turns about it."""
    parts = ["<link name='base'/><link name='platform'/><platform link='platform'/>"]
    parts.append(
        "<joint name='pose' type='floating'><parent link='base'/><child link='platform'/><origin xyz='0.05 0.02 0'/></joint>"
    )
    for n, base in enumerate(CORNERS, 1):
        angle = np.arctan2(base[1], base[0])
        x, y = (
            0.4 * np.cos(angle + 0.5),
            0.4 * np.sin(angle + 0.5),
        )  # foot; the elbow stands above the corner, on the ray from the origin
        elbow = base - [x, y, 0]
        rod = (0.1 - 0.3) * base / 0.3
        tip = corner * base / 0.3 - [0.05, 0.02, 0]
        parts.append(f"""
        <link name='crank_{n}'/><link name='rod_{n}'/>
        <joint name='motor_{n}' type='revolute'><parent link='base'/><child link='crank_{n}'/><origin xyz='{x} {y} 0'/>
          <axis xyz='0 0 1'/><limit lower='-3' upper='3' effort='1' velocity='1'/></joint>
        <joint name='elbow_{n}' type='continuous'><parent link='crank_{n}'/><child link='rod_{n}'/>
          <origin xyz='{elbow[0]} {elbow[1]} 0'/><axis xyz='0 0 1'/></joint>
        <loop name='tip_{n}' type='continuous'>
          <predecessor link='rod_{n}'><origin xyz='{rod[0]} {rod[1]} 0'/></predecessor>
          <successor link='platform'><origin xyz='{tip[0]} {tip[1]} {height}'/></successor><axis xyz='0 0 1'/></loop>
        <beam link='rod_{n}' from='elbow_{n}' to='tip_{n}' youngs_modulus='70e9' poisson_ratio='0.3' density='2700'>
          <circle diameter='0.02'/></beam>""")
        if n in actuated:
            parts.append(f"<transmission name='t_{n}'><joint name='motor_{n}'/></transmission>")
    file = tmp_path / "planar.urdf"
    file.write_text(f"<robot name='planar'>{''.join(parts)}</robot>")
    return file


def test_drawn_free_motion_equals_that_of_the_statics(tmp_path):
    robot = ks.load_robot(planar(tmp_path))
    pose = robot.assemble()
    with pytest.raises(ks.exceptions.SingularPoseError) as caught:
        ks.analyze(pose)
    shown = UnloadedPose(pose)
    (twist,) = shown.platform_twist[0]
    free = caught.value.free_twists[:, 0]  # by the limbs' constraint wrenches
    np.testing.assert_allclose(twist / twist[5], free / free[5], atol=1e-8)
    for n, base in enumerate(CORNERS, 1):
        np.testing.assert_allclose(shown.twist_at(f"crank_{n}", base[None]), 0, atol=1e-9)  # its actuator is locked
        tip = base[None] / 3
        on_rod = shown.twist_at(f"rod_{n}", tip)[0, 0, :3]
        np.testing.assert_allclose(on_rod, np.cross(twist[3:], tip[0]), atol=1e-8)  # by hand: the platform turns about the origin
        np.testing.assert_allclose(shown.beam_twists(f"rod_{n}")[0, 0, -1, :3], on_rod, atol=1e-8)
        np.testing.assert_allclose(shown.beam_line(f"rod_{n}")[1][0, [0, -1]], [base, tip[0]], atol=1e-9)
    scene = describe_scene(shown)
    assert [(arrow.group, arrow.kind) for arrow in scene.arrows] == [("free motion", "force"), ("free motion", "moment")]
    assert "rotation" in scene.notes[0]


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--sweep", "x=0:1mm:3", "--platform", "y=0", "rz=0.1"], "singular"),
        (["--compare", "3rps"], "the platform of 'planar' can still move"),
    ],
)
def test_sweep_and_compare_of_singular_poses_are_errors(options, words, tmp_path, capsys):
    assert cli.main(["view", str(planar(tmp_path, actuated=(1, 2))), *options, "--html", str(tmp_path / "x.html")]) == 2
    assert words in capsys.readouterr().err and not (tmp_path / "x.html").exists()


@pytest.mark.parametrize(
    ("change", "motions", "words"),
    [({}, 1, "singular"), ({"actuated": ()}, 3, "no actuators"), ({"corner": 2.0, "height": 0.3}, 0, "cannot be closed")],
)
def test_view_command_draws_unanalysable_robots_with_a_note(change, motions, words, tmp_path, capsys):
    file = planar(tmp_path, **change)
    html = tmp_path / "page.html"
    assert cli.main(["view", str(file), "--html", str(html)]) == 0
    assert words in capsys.readouterr().err
    scene = packed_in(html.read_text(encoding="utf-8"))
    assert words in scene["notes"][0] and len(scene["contributions"]) == motions and len(scene["meshes"]) >= 10
