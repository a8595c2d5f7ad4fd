"""Comparing workspace maps."""

import numpy as np
import xarray as xr


def same(found, wanted, but=("date", "history", "command_line")):
    """Assert that two maps are the same to the last digit, and say the same of themselves."""
    found, wanted = found.load().copy(), wanted.load().copy()
    for ds in (found, wanted):
        ds.attrs = {key: value for key, value in ds.attrs.items() if key not in but}
    xr.testing.assert_identical(found, wanted)


def near(found, wanted):
    """Assert that two maps are the same but for rounding, which depends on how poses are bundled."""
    assert set(found.variables) == set(wanted.variables)
    for name in found.variables:
        assert found[name].dims == wanted[name].dims and found[name].attrs.keys() == wanted[name].attrs.keys()
        if found[name].dtype.kind == "f":
            assert found[name].dtype == wanted[name].dtype
            scale = float(np.nanmax(np.abs(wanted[name].values), initial=1e-300))
            np.testing.assert_allclose(found[name].values, wanted[name].values, rtol=1e-9, atol=1e-12 * scale, err_msg=name)
        else:
            np.testing.assert_array_equal(found[name].values, wanted[name].values)
