"""Links by their matrices as files: the same after writing and reading, and errors with file and key."""

import numpy as np
import pytest
from frame_links import Frame

import kinetostatics as ks
from kinetostatics.description import LinkMatrices


def frame_link():
    names, origins, matrices = Frame(seed=1).link(modal=True)
    return LinkMatrices(names, origins, **matrices)


def test_links_are_the_same_after_writing_and_reading(tmp_path):
    link = frame_link()
    ks.files.save_link(link, tmp_path / "arm.npz")
    again = ks.files.read_link(tmp_path / "arm.npz")
    assert again == link and again.names == ("joint_1", "joint_2", "joint_3") and again.gravity is None
    with pytest.raises(ks.ArgumentError, match=r"arm\.mat: the name of a link's matrices ends in \.npz"):
        ks.files.save_link(link, tmp_path / "arm.mat")
    with pytest.raises(ks.ArgumentError, match=r"arm\.npz cannot be written"):
        ks.files.save_link(link, tmp_path / "nowhere" / "arm.npz")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"stifness": np.eye(3)}, "the key 'stifness' is unknown; did you mean 'stiffness'"),
        ({"origins": None}, "the key 'origins' is missing; needed are names, origins, stiffness"),
        ({"names": np.array([1, 2, 3])}, "names is no one-dimensional array of strings"),
        ({"mass": np.array([{}])}, "the key 'mass' cannot be read: Object arrays"),
        ({"mass": np.eye(3)}, r"mass has the shape \(3, 3\); \(30, 30\) would be right"),
    ],
)
def test_wrong_files_are_refused_with_file_and_key(tmp_path, changes, said):
    link = frame_link()
    values = {"names": link.names, "origins": link.origins, "rotations": link.rotations, "stiffness": link.stiffness}
    values = {key: value for key, value in (values | changes).items() if value is not None}
    np.savez(tmp_path / "arm.npz", **values)
    with pytest.raises(ks.RobotFileError, match=rf"arm\.npz: {said}"):
        ks.files.read_link(tmp_path / "arm.npz")


def test_files_that_are_no_npz_are_refused(tmp_path):
    (tmp_path / "text.npz").write_text("stiffness")
    np.save(tmp_path / "one.npy", np.eye(3))
    for name, said in (("text.npz", "no .npz file with names"), ("one.npy", "no .npz file with names"), ("no.npz", "No such")):
        with pytest.raises(ks.RobotFileError, match=said):
            ks.files.read_link(tmp_path / name)
