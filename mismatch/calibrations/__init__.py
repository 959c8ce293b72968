"""Two calibrations of one sensor that should agree: what makes them disagree."""

from mismatch.calibrations.explain import explain_calibrations
from mismatch.calibrations.verdict import CalibrationVerdict

__all__ = ["CalibrationVerdict", "explain_calibrations"]
