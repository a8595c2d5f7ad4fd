"""Links by their matrices in NumPy's ``.npz``: one array for each field of :class:`kinetostatics.description.LinkMatrices`."""

from __future__ import annotations

import os
import zipfile
from dataclasses import fields

import numpy as np

from kinetostatics.description.link_matrices import LinkMatrices
from kinetostatics.exceptions import ArgumentError, RobotFileError, near_names
from kinetostatics.output_files import replacing

KEYS = tuple(field.name for field in fields(LinkMatrices))
NEEDED = ("names", "origins", "stiffness")


def read_link(path: str | os.PathLike[str]) -> LinkMatrices:
    """Read a link by its matrices.

    Args:
        path: an ``.npz`` file of fields of :class:`kinetostatics.description.LinkMatrices`: the three without default, or more.

    Raises:
        RobotFileError: the file cannot be read, or its contents are invalid; the message names file and key.
    """
    name = os.fspath(path)
    try:
        with np.load(name, allow_pickle=False) as stored:
            if unknown := [key for key in stored if key not in KEYS]:
                raise RobotFileError(f"the key {unknown[0]!r} is unknown; {near_names(unknown[0], KEYS)}", name)
            if missing := [key for key in NEEDED if key not in stored]:
                raise RobotFileError(f"the key {missing[0]!r} is missing; needed are {', '.join(NEEDED)}", name)
            arrays = {}
            for key in stored:
                try:
                    arrays[key] = stored[key]
                except ValueError as error:  # objects, or a damaged array
                    raise RobotFileError(f"the key {key!r} cannot be read: {error}", name) from None
    except (OSError, TypeError, ValueError, zipfile.BadZipFile) as error:
        reason = getattr(error, "strerror", None) or f"it is no .npz file with {', '.join(NEEDED)}"
        raise RobotFileError(f"not readable: {reason}", name) from None
    if arrays["names"].ndim != 1 or arrays["names"].dtype.kind != "U":
        raise RobotFileError("names is no one-dimensional array of strings", name)
    try:
        return LinkMatrices(**{**arrays, "names": tuple(arrays["names"].tolist())})
    except ArgumentError as error:
        raise RobotFileError(str(error), name) from None


def save_link(link: LinkMatrices, path: str | os.PathLike[str]) -> None:
    """Write a link by its matrices as an ``.npz`` file for :func:`read_link`.

    Raises:
        ArgumentError: the file's name does not end in ``.npz``, or it cannot be written.
    """
    name = os.fspath(path)
    if not name.endswith(".npz"):
        raise ArgumentError(f"{name}: the name of a link's matrices ends in .npz")
    values = {key: getattr(link, key) for key in KEYS}
    with replacing(name) as partial, open(partial, "wb") as file:
        np.savez_compressed(file, allow_pickle=False, **{key: value for key, value in values.items() if value is not None})
