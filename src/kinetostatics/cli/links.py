"""Commands for elastic links that are no beams: import-link."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from kinetostatics.cli.commands import Command
from kinetostatics.cli.inputs import given_of, parse_items
from kinetostatics.cli.options import Argument
from kinetostatics.cli.output import check_files
from kinetostatics.files.link_files import save_link
from kinetostatics.progress import waiting

if TYPE_CHECKING:
    from kinetostatics.description.link_matrices import LinkMatrices

OUT = Argument("text", "the file of matrices to write, .npz", "FILE")


def _import_link(args: argparse.Namespace) -> int:
    check_files([args.out], ["npz"])
    with waiting("importing the link"):
        link = IMPORT_LINK.called()(args.path, parse_items("--interface", args.interfaces), **given_of(("nodes", "unit"), args))
        save_link(link, args.out)
    print(f"{args.out}: {_summary(link)}")
    return 0


def _summary(link: LinkMatrices) -> str:
    mass = "no mass matrix" if link.body is None else f"mass {link.body[0]:.6g} kg"
    return f"interfaces {', '.join(link.names)}; {link.internal} internal coordinates; {mass}"


IMPORT_LINK = Command(
    _import_link,
    help="make a link's matrices from files of CalculiX, Abaqus, ANSYS or Simscape",
    description=(
        "Make the matrices of an elastic link from .mtx of CalculiX or Abaqus (*SUBSTRUCTURE MATRIX OUTPUT), .csv of ANSYS\n"
        "(arm_mat_K.CSV, arm_mat_M.CSV), or .mat of Simscape Multibody (P, K, M)."
    ),
    arguments=(),
    own_arguments={
        "path": Argument("text", "the file with the stiffness matrix", "FILE", option="path"),
        "interfaces": Argument(
            "items",
            "joints of the link, or o, with their nodes, which move rigidly: a set or numbers; of Simscape the row of P",
            "NAME=NODES",
            option="--interface",
        ),
        "nodes": Argument(
            "text", "file with the nodes (default: the .inp beside the .mtx, arm_out_nodes_3D.txt beside arm_mat_K.CSV)", "FILE"
        ),
        "unit": Argument("text", "mm for models in mm, N, tonne (default: m)", choices=("m", "mm")),
        "out": OUT,
    },
    function="files.finite_elements:import_link",
    required=("path", "interfaces", "out"),
    usage="FILE --interface NAME=NODES … --out FILE [options]",
    examples="""
import-link arm.mtx --interface shoulder=BORE o=FLANGE --unit mm --out arm.npz
import-link arm_mat_K.CSV --interface shoulder=697783 elbow=697784 --out arm.npz
import-link arm.mat --interface shoulder=1 elbow=2 --out arm.npz
""",
)
