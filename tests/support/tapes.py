"""A second way from a record to numbers: operation by operation with NumPy, without LLVM."""

import numpy as np

from kinetostatics.engine.record import arrays_of, sizes_of_applied

ARITHMETIC = {"add": np.add, "subtract": np.subtract, "multiply": np.multiply, "divide": np.divide, "negative": np.negative}
OTHERS = {"square_root": np.sqrt, "absolute": np.abs, "and": np.logical_and, "or": np.logical_or, "not": np.logical_not}
COMPARISONS = {">": np.greater, ">=": np.greater_equal, "<": np.less, "<=": np.less_equal, "==": np.equal, "!=": np.not_equal}
ANGLES = {"sine": np.sin, "cosine": np.cos, "angle": np.arctan2, "whole": np.rint}
FUNCTIONS = {**ARITHMETIC, **OTHERS, **COMPARISONS, **ANGLES, "choose": np.where}


def evaluate(tape, inputs, parameters, wanted):
    """Return the results (N,) of wanted operations for inputs, each (components, N)."""
    found = []
    N = inputs[0].shape[1]
    with np.errstate(all="ignore"):
        for name, *taken in tape.operations:
            if name == "input":
                found.append(inputs[taken[0]][taken[1]])
            elif name == "parameter":
                found.append(parameters[taken[0]])
            elif name == "constant":
                found.append(float.fromhex(taken[0]))
            elif name == "truth":
                found.append(taken[0])
            else:
                found.append(FUNCTIONS[name](*(found[k] for k in taken)))
    return np.array([np.broadcast_to(found[number], N) for number in wanted])


def differences(found, wanted, which=slice(None)):
    """Return by how much arrays of a solution differ at some poses, as parts of the largest entry of each.

    Truth values must be the same.
    """
    found, wanted = ({path: array[..., which] for path, array in arrays_of(one).items()} for one in (found, wanted))
    assert list(found) == list(wanted)
    result, alike = {}, sizes_of_applied(wanted)
    for path, array in wanted.items():
        assert array.shape == found[path].shape, path
        if array.dtype == bool:
            np.testing.assert_array_equal(found[path], array, err_msg=path)
        elif array.size and "unbalanced" not in path:  # which is rounding
            np.testing.assert_array_equal(np.isnan(found[path]), np.isnan(array), err_msg=path)
            size = max(np.nanmax(np.abs(array), initial=0.0), alike.get(path, 0.0))
            result[path] = np.nanmax(np.abs(found[path] - array), initial=0.0) / (size if size > 1e-25 else 1.0)
    return result
