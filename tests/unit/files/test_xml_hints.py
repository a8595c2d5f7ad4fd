"""What is said of numbers and beams that are written as people think of them."""

import pytest
from simple_machines import joint, link

import kinetostatics as ks
from kinetostatics.files.reader import parse_robot_text


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("40mm", "without the unit: 0.04"),
        ("4 cm", "without the unit: 0.04"),
        ("30deg", "without the unit: 0.523598775598"),
        ("40 pounds", "is not a number$"),
        ("thick", "is not a number$"),
    ],
)
def test_units_in_a_file_are_told_in_si(written, said):
    weight = f'<link name="b"><inertial><mass value="{written}"/></inertial></link>'
    text = f'<robot name="r">{link("a")}{weight}{joint("j", "revolute", "a", "b")}<platform link="b"/></robot>'
    with pytest.raises(ks.RobotFileError, match=said):
        parse_robot_text(text)


def test_a_telescope_of_no_length_is_told_where_it_begins():
    text = f"""<robot name="r">{link("a")}{link("b")}{link("c")}{link("p", 1.0)}
<joint name="foot" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/></joint>
<joint name="slide" type="prismatic"><parent link="b"/><child link="c"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/>
<limit lower="0" upper="1" effort="1" velocity="1"/></joint>
<joint name="tip" type="fixed"><parent link="c"/><child link="p"/></joint><platform link="p"/>
<transmission name="d"><joint name="slide"/></transmission><transmission name="e"><joint name="foot"/></transmission>
<beam link="c" youngs_modulus="210e9" poisson_ratio="0.3" density="0"><circle diameter="0.04"/></beam></robot>"""
    with pytest.raises(
        ks.RobotFileError, match=r"its length is zero; of a telescope that is one beam, from= is the joint behind 'slide'"
    ):
        dict(ks.Robot(parse_robot_text(text)).beams)
    long = text.replace('<beam link="c"', '<beam link="c" from="foot"')
    assert ks.analyze(ks.Robot(parse_robot_text(long)).assemble()).beams["c"].length == pytest.approx(1.0)
