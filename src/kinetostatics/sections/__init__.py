"""Cross-sections of beams: areas, moments, shear coefficients, stresses."""

from kinetostatics.sections.kinds import THINNEST, Rectangle, RectangularTube, Section, Tube, beam_compliance_coefficients
from kinetostatics.sections.tapered import Station, Tapered

__all__ = ["THINNEST", "Rectangle", "RectangularTube", "Section", "Station", "Tapered", "Tube", "beam_compliance_coefficients"]
