"""Which of the slow tests belong to which part, and which tests may be skipped where everything is installed."""

import os
import zlib

#: Reasons that concern a case itself, as they begin; the others say that a program or a module is missing.
OF_THE_CASE = (
    "its redundant actuators cannot be moved one by one",
    "its platform is rigidly fixed to the base",
    "OpenSees is accurate to",
    "no extra of the package installs",
    "the site, which is built with the linters, needs the extra docs",
    "a second browser, which only this test needs, is not installed",
)


def in_part(test, number, parts=40):
    """Whether a test, given by its node ID, is in part number mod ``parts``; new tests move no other into another part."""
    return zlib.crc32(test.encode()) % parts == number % parts


def without_skips(report):
    """Return a report that failed instead of one that was skipped for what is missing, if KINETOSTATICS_REQUIRE_ALL is set."""
    if report.skipped and not hasattr(report, "wasxfail") and os.environ.get("KINETOSTATICS_REQUIRE_ALL") == "1":
        reason = report.longrepr[2].removeprefix("Skipped: ")
        if not reason.startswith(OF_THE_CASE):
            report.outcome = "failed"
            report.longrepr = f"skipped, but KINETOSTATICS_REQUIRE_ALL is set: {reason}"
    return report
