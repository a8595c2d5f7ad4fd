"""Unknown names in mappings: the error lists the known names, and is a KeyError."""

from collections.abc import Mapping

import pytest

import kinetostatics as ks


@pytest.fixture(scope="module")
def result():
    return ks.analyze(ks.load_robot("five_bar").assemble())


def test_error_of_unknown_name_lists_known_or_similar_names(result):
    with pytest.raises(KeyError) as caught:
        result.beams["distal"]
    assert isinstance(caught.value, ks.exceptions.UnknownNameError) and isinstance(caught.value, ks.KinetostaticsError)
    assert str(caught.value) == "there is no 'distal' here; did you mean 'distal_2' or 'distal_1'?"
    assert caught.value.name == "distal" and caught.value.known == tuple(result.beams)
    with pytest.raises(ks.exceptions.UnknownNameError, match=r"there is no 'q' here; known: limb_1, limb_2$"):
        result.limbs["q"]


def test_all_mappings_of_results_and_descriptions_list_known_names(result):
    owners = (result, result.configuration, result.robot.description)
    mappings = [
        (name, value)
        for owner in owners
        for name in dir(owner)
        if not name.startswith("_") and isinstance(value := getattr(owner, name), Mapping)
    ]
    assert {"beams", "actuator_forces", "limbs", "joint_wrenches", "contributions", "actuators", "joints", "loops"} <= {
        name for name, _ in mappings
    }
    for name, mapping in mappings:
        with pytest.raises(
            ks.exceptions.UnknownNameError, match=r"there is no 'nothing of that name' here; (known: |there are none)"
        ):
            print(name, mapping["nothing of that name"])
        assert mapping.get("nothing of that name") is None and "nothing of that name" not in mapping
