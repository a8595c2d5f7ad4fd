"""The blocks of docs/how_to/frameworks.md run with each framework that is installed; its derivatives are those of differences."""

import numpy as np
import pytest
from page_code import python_of

FRAMEWORKS = ("jax", "torch", "casadi", "pymoo")
HEAD, *BLOCKS = python_of("how_to/frameworks")
#: Poses z, rx, ry [m, rad].
POSES = np.array([[0.5, 0.1, 0.0], [0.6, -0.05, 0.2]])


def installed(framework):
    """Return the module of a framework, where somebody has installed it."""
    return pytest.importorskip(framework, reason=f"no extra of the package installs {framework}")


def names_of(framework):
    """Return the names that the page's blocks for a framework define."""
    installed(framework)
    names = {}
    for code in (HEAD, BLOCKS[FRAMEWORKS.index(framework)]):
        exec(compile(code, "frameworks.md", "exec"), names)  # the page's own text
    return names


@pytest.fixture(scope="module")
def gradient():
    """(2, 3) gradients of the linear sag at the poses, by differences of its values."""
    names, step = {}, 1e-5
    exec(compile(HEAD, "frameworks.md", "exec"), names)

    def sag(x):
        return np.linalg.norm(names["twist"](x)[..., :3], axis=-1)

    steps = step * np.eye(3)
    found = (sag(POSES[:, None] + steps) - sag(POSES[:, None] - steps)) / (2 * step)
    twists, rates = names["twist"](POSES)[:, :3], names["rates"](POSES)[:, :3]
    np.testing.assert_allclose(np.einsum("ni,nij->nj", twists, rates) / sag(POSES)[:, None], found, rtol=1e-6, atol=1e-12)
    return found


def test_page_has_a_block_for_each_framework(gradient):
    assert all(f"import {name}" in code or f"from {name}" in code for name, code in zip(FRAMEWORKS, BLOCKS, strict=True))


def test_jax(gradient):
    jax, sag = installed("jax"), names_of("jax")["sag"]
    np.testing.assert_allclose(jax.vmap(jax.grad(sag))(POSES), gradient, rtol=1e-6, atol=1e-12)
    forward = jax.jacfwd(sag)(POSES[1])
    np.testing.assert_allclose(forward, gradient[1], rtol=1e-6, atol=1e-12)


def test_torch(gradient):
    torch, Twist = installed("torch"), names_of("torch")["Twist"]
    x = torch.tensor(POSES, requires_grad=True)
    Twist.apply(x)[:, :3].norm(dim=1).sum().backward()
    np.testing.assert_allclose(x.grad, gradient, rtol=1e-6, atol=1e-12)
    assert torch.autograd.gradcheck(lambda pose: 1e6 * Twist.apply(pose), x, eps=1e-5, atol=1e-4)


def test_casadi(gradient):
    casadi, names = installed("casadi"), names_of("casadi")
    function = casadi.Function("gradient", [names["pose"]], [casadi.gradient(names["sag"], names["pose"])])
    for pose, wanted in zip(POSES, gradient, strict=True):
        np.testing.assert_allclose(np.array(function(pose)).ravel(), wanted, rtol=1e-6, atol=1e-12)


def test_pymoo():
    names = names_of("pymoo")
    best = names["best"]
    tilts, displacements = best.F[np.argsort(best.F[:, 0])].T
    assert len(tilts) > 20 and np.all(np.diff(displacements) < 0)  # less tilt, less displacement
    values = names["f"](**dict(zip(names["names"], best.X.T, strict=True)), load=names["load"])
    assert np.abs(values["actuator_forces"]).max() <= 600 and not np.any(np.isnan(values["twist"]))
