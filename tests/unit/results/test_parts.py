"""What a limb shows where its wrenches are not those of its labels: NaN, of the same shapes as elsewhere."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinetostatics.results.parts import LimbResult
from kinetostatics.results.pose_arrays import Chunk

N_C, N_G, N = 2, 1, 3
SHAPES = {
    "constraint_wrenches": (6, N_C), "attached_wrenches": (6, N_G), "attached_intensities": (N_G,), "compliance": (N_C, N_C),
    "stiffness": (N_C, N_C), "sag": (N_C,), "intensities": (N_C,),
}  # fmt: skip


def limb(at_one_pose=False, degenerate=(False, True, False), rigid=0):
    """The second of two limbs at three poses."""
    random = np.random.default_rng(0)
    limbs = [
        SimpleNamespace(name=name, is_serial=True, edges=[SimpleNamespace(beam="rod"), SimpleNamespace(beam=None)],
                        platform_edges=[SimpleNamespace(joint="head"), SimpleNamespace(joint=None)])
        for name in ("limb_1", "limb_2")
    ]  # fmt: skip
    group = SimpleNamespace(
        limbs=limbs, labels=[("x", "y"), ("a", "b")], attached_labels=[("z",), ("c",)], at_one_pose=at_one_pose,
        rigid_directions=rigid,
    )  # fmt: skip
    C = np.zeros((N_C, N_C, 2, N)) + np.array([[2.0, 1.0], [1.0, 3.0]])[:, :, None, None]
    statics = SimpleNamespace(
        group=group, degenerate=np.array([[True] * N, degenerate]), J_c=random.random((6, N_C, 2, N)),
        J_g=random.random((6, N_G, 2, N)), W_g=random.random((N_G, 2, N)), C=C, gravity_displacement=random.random((N_C, 2, N)),
        R_g=random.random((6, 2, N)),
    )  # fmt: skip
    solution = SimpleNamespace(
        places={"limb_1": (0, 0), "limb_2": (0, 1)}, statics=[statics], o=np.zeros((3, N)), sources=("load", "weight"),
        intensities=[random.random((N_C, 2, 2, N))], undetermined=[np.zeros((N_C, 2, N), dtype=bool)],
    )  # fmt: skip
    batch = SimpleNamespace(
        public=lambda parts: np.moveaxis(np.concatenate(parts, axis=-1), -1, 0),
        by_source=lambda sources, parts: {name: np.moveaxis(parts[0][:, k], -1, 0) for k, name in enumerate(sources)},
    )
    chunk = Chunk(SimpleNamespace(statics=SimpleNamespace(groups=[group])), [solution])
    found = SimpleNamespace(_batch=batch, solutions=(solution,), sources=solution.sources, _of_chunks=lambda pick: [pick(chunk)])
    return LimbResult(found, group, 1, (slice(N_C, 2 * N_C), slice(N_G, 2 * N_G))), statics, solution


@pytest.mark.parametrize("name", SHAPES)
def test_numbers_are_of_the_limb_and_of_the_labels(name):
    found, statics, _ = limb()
    value = getattr(found, name)
    assert value.shape == (N, *SHAPES[name])
    assert np.isnan(value[1]).all() and np.isfinite(value[[0, 2]]).all()
    elsewhere = getattr(limb(at_one_pose=True)[0], name)
    assert elsewhere.shape == (N, *SHAPES[name]) and np.isnan(elsewhere).all()
    which = {
        "constraint_wrenches": "J_c",
        "attached_wrenches": "J_g",
        "attached_intensities": "W_g",
        "sag": "gravity_displacement",
        "compliance": "C",
    }
    if name in which:
        np.testing.assert_array_equal(value[2], getattr(statics, which[name])[..., 1, 2])


def test_sums_and_inverses():
    found, statics, solution = limb(degenerate=(False, False, False))
    assert (found.name, found.beams, found.platform_joints, found.labels) == ("limb_2", ("rod",), ("head",), ("a", "b"))
    np.testing.assert_allclose(found.stiffness[0] @ [[2.0, 1.0], [1.0, 3.0]], np.eye(2), atol=1e-12)
    assert np.isnan(limb(rigid=1)[0].stiffness).all()
    intensities = solution.intensities[0][:, :, 1]
    np.testing.assert_allclose(found.intensities, intensities.sum(axis=1).T)
    np.testing.assert_allclose(found.contributions["weight"], intensities[:, 1].T)
    expected = [statics.J_c[:, :, 1, k] @ intensities[:, :, k].sum(axis=1) + statics.R_g[:, 1, k] for k in range(N)]
    np.testing.assert_allclose(found.wrench, expected)
    solution.undetermined[0][1, 1, 2] = True
    found = LimbResult(found._found, statics.group, 1, found._rows)
    assert np.isnan(found.intensities).tolist() == [[False, False], [False, False], [False, True]]
    assert np.isnan(found.wrench).all(axis=1).tolist() == [False, False, True]
