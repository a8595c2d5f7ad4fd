from .c_export import CExport
from .function import Function, Jacobian
from .inputs_outputs import Quantity, Values

__all__ = [
    "CExport",
    "Function",
    "Jacobian",
    "Quantity",
    "Values",
]
