from .link_files import read_link, save_link
from .reader import read_robot_file

__all__ = [
    "read_link",
    "read_robot_file",
    "save_link",
]
