from .reader import read_robot_file, validate

__all__ = [
    "read_robot_file",
    "validate",
]
