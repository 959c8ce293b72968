"""The impulse response of laser and detector, from frames whose geometry is known."""

from calibrate.impulse.estimate import ImpulseEstimate, fit_impulse

__all__ = ["ImpulseEstimate", "fit_impulse"]
