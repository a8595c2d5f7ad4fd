from .finite_elements import import_link
from .link_files import read_link, save_link
from .reader import read_robot_file

__all__ = [
    "import_link",
    "read_link",
    "read_robot_file",
    "save_link",
]
