"""Robots built by name: from the field's notation, such as ``3-R[P]S``, to a robot file that is ready to be edited."""
