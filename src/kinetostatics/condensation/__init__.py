"""A link from CAD: stiffness and mass at its interfaces, condensed from solid finite elements (extra ``cad``)."""

from kinetostatics.condensation.condensed_link import CondensedLink, condense

__all__ = ["CondensedLink", "condense"]
