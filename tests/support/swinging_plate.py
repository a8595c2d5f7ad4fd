"""A parallelogram made in Python, whose plate swings on two rods."""

from kinetostatics.description import Beam, Joint, Link, Loop, Material, Origin, RobotDescription
from kinetostatics.sections import Tube

STEEL = Material(youngs_modulus=210e9, poisson_ratio=0.3, density=7850)
Y = (0.0, 1.0, 0.0)


def parallelogram(lean=0.0, plate=3.0):
    """Two rods of 0.3 m, the left one actuated, lean by an angle at zero and carry a level plate of 0.4 m."""
    down, up = Origin(rpy=(0.0, lean, 0.0)), Origin((0.0, 0.0, 0.3), (0.0, -lean, 0.0))
    return RobotDescription.of(
        "parallelogram",
        links=[Link("ground"), Link("left"), Link("right"), Link("plate", plate, (0.2 * (plate > 0), 0, 0))],
        joints=[
            Joint("a", "revolute", "ground", "left", down, axis=Y, lower=-1, upper=1),
            Joint("b", "continuous", "left", "plate", up, axis=Y),
            Joint("d", "continuous", "ground", "right", Origin((0.4, 0, 0), (0.0, lean, 0.0)), axis=Y),
        ],
        loops=[Loop("c", "continuous", "right", "plate", up, Origin((0.4, 0, 0)), axis=Y)],
        platform="plate",
        platform_origin=Origin((0.2, 0, 0)),
        beams=[Beam("left", Tube.of(0.02), STEEL), Beam("right", Tube.of(0.03, 0.02), STEEL)],
        actuated=["a"],
    )
