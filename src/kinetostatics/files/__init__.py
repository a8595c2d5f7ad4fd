"""URDF and xacro files, read and written; every mistake told with its file and line."""
