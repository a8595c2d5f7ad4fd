from .c_export import CExport
from .function import Function, Jacobian
from .inputs_outputs import Quantity, Values
from .ros2 import export_ros2

__all__ = [
    "CExport",
    "Function",
    "Jacobian",
    "Quantity",
    "Values",
    "export_ros2",
]
