"""Cross-sections of beams: areas, moments, shear coefficients, stresses."""

from kinetostatics.sections.kinds import THINNEST, Rectangle, RectangularTube, Section, Tube, beam_compliance_coefficients

__all__ = ["THINNEST", "Rectangle", "RectangularTube", "Section", "Tube", "beam_compliance_coefficients"]
