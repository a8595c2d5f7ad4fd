"""Ladders of many closed loops and long chains: time of their analysis, and results that do not depend on names and order."""

import time

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

import kinetostatics as ks
from kinetostatics.files.reader import parse_robot_text

ELASTIC = 'youngs_modulus="70e9" poisson_ratio="0.3" density="2700"><circle diameter="0.03"/></beam>'


def joint(name, kind, parent, child, xyz="0 0 0", inside=""):
    ends = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{inside}</joint>'


def chain(links):
    """Links with one actuator each, about axes at right angles."""
    parts = ['<link name="l0"/>']
    for k in range(1, links + 1):
        inside = f'<axis xyz="{"0 0 1" if k % 2 else "0 1 0"}"/><limit lower="-3" upper="3" effort="0" velocity="0"/>'
        parts += [f'<link name="l{k}"/><link name="e{k}"/>', joint(f"w{k}", "fixed", f"l{k}", f"e{k}", "0.1 0 0.02")]
        parts += [joint(f"j{k}", "revolute", f"e{k - 1}" if k > 1 else "l0", f"l{k}", inside=inside)]
        parts += [
            f'<beam link="l{k}" from="j{k}" to="w{k}" {ELASTIC}<transmission name="t{k}"><joint name="j{k}"/></transmission>'
        ]
        parts += [f'<joint_stiffness joint="j{k}" drive="1e5"/>']
    return f'<robot name="chain">{"".join(parts)}<platform link="e{links}"/></robot>'


def ladder(rungs, random=None):
    """Two rails that are fixed to the base, and rungs welded to both; with ``random``, other names and another order."""
    links, others = ["a0", "b0"], [joint("fa", "fixed", "base", "a0"), joint("fb", "fixed", "base", "b0", "0.2 0 0")]
    for k in range(1, rungs + 1):
        for s in "ab":
            links += [f"r{s}{k}", f"{s}{k}"]
            others += [
                joint(f"s{s}{k}", "fixed", f"{s}{k - 1}", f"r{s}{k}"),
                joint(f"q{s}{k}", "fixed", f"r{s}{k}", f"{s}{k}", "0 0 0.2"),
            ]
            others += [f'<beam link="r{s}{k}" from="s{s}{k}" to="q{s}{k}" {ELASTIC}']
        links += [f"g{k}"]
        others += [joint(f"u{k}", "fixed", f"a{k}", f"g{k}"), f'<beam link="g{k}" from="u{k}" to="v{k}" {ELASTIC}']
        ends = f'<predecessor link="g{k}"><origin xyz="0.2 0 0"/></predecessor><successor link="b{k}"/>'
        others += [f'<loop name="v{k}" type="fixed">{ends}</loop>']
    parts = [f'<link name="{name}"/>' for name in ["base", *links]] + others
    if random is not None:
        parts = [parts[k] for k in random.permutation(len(parts))]
    text = f'<robot name="ladder">{"".join(parts)}<base link="base"/><platform link="a{rungs}"/></robot>'
    if random is not None:
        for number, name in zip(random.permutation(len(links)), links, strict=True):
            text = text.replace(f'"{name}"', f'"x{number}"')
    return text


def seconds(compute):
    begin = time.process_time()
    value = compute()
    return value, time.process_time() - begin


def test_a_ladder_of_forty_loops_loads_in_two_seconds():
    ks.load_robot("3rps")  # imports
    _, taken = seconds(lambda: ks.Robot(parse_robot_text(ladder(40))).topology)
    assert taken < 2


def test_a_ladder_is_the_same_in_every_order():
    load = [3, -5, 2, 0.1, 0.2, 0.3]
    twist = ks.analyze(ks.Robot(parse_robot_text(ladder(12))).assemble(), load).twist
    for seed in range(4):
        robot = ks.Robot(parse_robot_text(ladder(12, np.random.default_rng(seed))))
        np.testing.assert_allclose(ks.analyze(robot.assemble(), load).twist, twist, rtol=1e-9, atol=1e-15)
    assert np.linalg.norm(twist[:3]) > 1e-7


@pytest.mark.usefixtures("by_numpy")
def test_numbers_and_warnings_of_a_chain_of_sixty_links_take_seconds():
    """At most twelve times what the eigenvalues of a matrix of 1,500 rows take: 5 s where those take 0.4 s."""
    ks.load_robot("3rps")
    pose = ks.Robot(parse_robot_text(chain(60))).assemble()
    matrix = np.random.default_rng(0).standard_normal((1500, 1500))

    def numbers():
        result = ks.analyze(pose, load=[0, 0, -10, 0, 0, 0])
        return result.twist, result.actuator_forces, result.warnings

    with threadpool_limits(1, "blas"):  # waiting threads would count
        _, unit = seconds(lambda: np.linalg.eigh(matrix + matrix.T))
        _, taken = seconds(numbers)
    assert taken < 12 * unit
