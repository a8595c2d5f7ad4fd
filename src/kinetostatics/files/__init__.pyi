from .reader import read_robot_file
from .writer import validate

__all__ = [
    "read_robot_file",
    "validate",
]
