"""Write the symbols of docs/explanation/glossary.md that are quantities from the table of quantities.

python tests/support/glossary_table.py
"""

from __future__ import annotations

import re

from places import ROOT

from kinetostatics.quantities import QUANTITIES

PAGE = ROOT / "docs" / "explanation" / "glossary.md"
#: Where the formula of each is evaluated.
CODE = {
    "twist": "statics.platform_equilibrium.PlatformEquilibrium.solve",
    "stiffness": "statics.platform_equilibrium.PlatformEquilibrium",
    "compliance": "statics.platform_equilibrium.PlatformEquilibrium",
    "actuator_forces": "statics.joint_wrenches.actuator_forces_from",
    "platform_wrench": "statics.platform_equilibrium.PlatformEquilibrium._refine",
    "limbs.constraint_wrenches": "limbs.statics.limb_wrenches",
    "limbs.intensities": "statics.platform_equilibrium.PlatformEquilibrium._intensities",
    "limbs.attached_wrenches": "limbs.statics.limb_wrenches",
    "limbs.attached_intensities": "limbs.statics.limb_wrenches",
    "limbs.compliance": "limbs.compliance.compliance_and_sag",
    "limbs.stiffness": "results.parts.LimbResult.stiffness",
    "limbs.sag": "limbs.compliance.compliance_and_sag",
}


def rows() -> dict[str, str]:
    """Return the glossary's rows by symbol."""
    found = {}
    for path, entry in QUANTITIES.items():
        if entry.symbol:
            attribute = "result." + path.replace("limbs.", 'limbs["limb_1"].')
            cells = (entry.symbol, entry.words, entry.equation, f"`{attribute}`", f"`{CODE[path]}`", entry.units)
            found[entry.symbol] = f"| {' | '.join(cells)} |"
    return found


def main() -> None:
    """Write them."""
    text = PAGE.read_text(encoding="utf-8")
    for symbol, row in rows().items():
        text, count = re.subn(rf"^\| {symbol} \|.*$", lambda _: row, text, count=1, flags=re.MULTILINE)  # noqa: B023
        assert count, f"write a row for {symbol} where it is to stand"
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
