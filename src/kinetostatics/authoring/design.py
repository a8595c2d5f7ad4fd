"""All that a generated robot file is written from."""

from __future__ import annotations

from dataclasses import dataclass

from kinetostatics.authoring.arguments_of_file import FileArguments
from kinetostatics.authoring.limb_text import LimbOptions
from kinetostatics.authoring.materials import SectionText
from kinetostatics.authoring.notation import Architecture
from kinetostatics.authoring.placement import Place
from kinetostatics.authoring.skeleton import Skeleton


@dataclass(frozen=True)
class Design:
    """All that a generated file is written from.

    Attributes:
        name: of the robot.
        architecture: its limbs.
        skeletons, places: of each limb.
        options: of each limb's macro.
        sections: of each role, by what its arguments begin with.
        shared_material: whether all beams have the same material.
        arguments: of the file.
    """

    name: str
    architecture: Architecture
    skeletons: tuple[Skeleton, ...]
    places: tuple[Place, ...]
    options: tuple[LimbOptions, ...]
    sections: dict[str, SectionText]
    shared_material: bool
    arguments: FileArguments
