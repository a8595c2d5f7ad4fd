"""Commands for elastic links that are no beams: import-link, condense."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from kinetostatics.cli.commands import Command
from kinetostatics.cli.inputs import given_of, parse_items
from kinetostatics.cli.options import Argument
from kinetostatics.cli.output import check_files, print_warnings
from kinetostatics.exceptions import ArgumentError
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


def _condense(args: argparse.Namespace) -> int:
    check_files([args.out, *([args.picture] if args.picture else [])], ["npz", "png", "svg"])
    options = given_of(("material", "modes", "grip", "unit"), args)
    if args.within is not None:
        try:
            options["within"] = float(args.within.removesuffix("%")) / (100 if args.within.endswith("%") else 1)
        except ValueError:
            raise ArgumentError(f"--within: {args.within!r} is no number or percentage, such as 1%") from None
    with waiting("condensing the part"):
        result = CONDENSE.called()(args.path, parse_items("--interface", args.interfaces), **options)
        save_link(result.link, args.out)
        if args.picture:
            result.save_picture(args.picture)
    print(f"{args.out}: {_summary(result.link)}\n{result}")
    if result.change > options.get("within", 0.01):
        print_warnings(["the compliance still changes by more than --within; the mesh is as fine as this computation makes it."])
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
            "joints of the link, with their nodes, which move rigidly: a set or numbers; of Simscape the row of P",
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
import-link arm.mtx --interface shoulder=BORE wrist=FLANGE --unit mm --out arm.npz
import-link arm_mat_K.CSV --interface shoulder=697783 elbow=697784 --out arm.npz
import-link arm.mat --interface shoulder=1 elbow=2 --out arm.npz
""",
)


CONDENSE = Command(
    _condense,
    help="make a link's matrices from its CAD file (STEP, STL) by solid finite elements",
    description=(
        "Make the matrices of an elastic link from STEP, STL or a volume mesh, by solid finite elements (extra cad), refined\n"
        "until the compliance is accurate. Interfaces are gripped rigidly or evenly; how much this matters is printed."
    ),
    arguments=(),
    own_arguments={
        "path": Argument("text", "the part, in the link's axes: .step, .stl, .vol or .msh", "FILE", option="path"),
        "interfaces": Argument(
            "items",
            'joints of the link, with their surfaces: "cylinder d=20mm near X Y Z", "face near X Y Z", "face FACE", '
            '"sphere r=10mm at X Y Z"',
            "NAME=PLACE",
            option="--interface",
        ),
        "material": Argument("text", "steel, aluminium, titanium or carbon (default: steel)", "NAME"),
        "within": Argument("text", "largest change of the compliance by the last refinement (default: 0.01): 1%%", "FRACTION"),
        "modes": Argument("count", "number of fixed-interface modes (default: 6)", "N", least=0),
        "grip": Argument(
            "text", "rigid or even: interfaces are rigid (default), or follow in the mean", choices=("rigid", "even")
        ),
        "unit": Argument("text", "unit of STL or a mesh (default: mm if the part would be larger than 5 m)", choices=("m", "mm")),
        "picture": Argument("text", "picture of surface and interfaces, .png or .svg", "FILE"),
        "out": OUT,
    },
    function="condensation:condense",
    required=("path", "interfaces", "out"),
    usage="FILE --interface NAME=PLACE … --out FILE [options]",
    examples="""
condense arm.step --interface shoulder="cylinder d=20mm near 0 0 0" wrist="face near 0 0 400mm" --material steel --out arm.npz
condense bracket.stl --interface a="sphere r=15mm at 0 0 0" b="face near 0.2 0 0" --within 3% --picture it.png --out it.npz
""",
)
