"""The sensor behind the microcontroller: who it is, and its clock."""

from dataclasses import dataclass

TICK_S = 200e-9


@dataclass(frozen=True)
class Chip:
    """serial: of this device. has_8x8: a TMF8828; the smaller ones refuse the mode of 8 x 8 zones.

    temperature_c: whole degrees Celsius. skew: the share by which its RC oscillator runs fast, at most 3 %.
    started_ticks: what its clock of 200 ns stands at when it begins, so that a wrap of 32 bits can be had at will.
    """

    serial: int = 0x8A4C21
    has_8x8: bool = True
    temperature_c: int = 31
    skew: float = 0.0
    started_ticks: int = 0
    driver: tuple[int, int] = (1, 14)
    firmware: tuple[int, int, int, int] = (3, 1, 88, 0)
    chip: tuple[int, int] = (34, 1)

    @property
    def device_line(self) -> str:
        """As the firmware prints it; the version of the firmware ends in a full stop."""
        driver, firmware, chip = (".".join(map(str, v)) for v in (self.driver, self.firmware, self.chip))
        return f"Driver {driver} FW {firmware}. Chip {chip} Serial 0x{self.serial:X}"

    def tick(self, now: float) -> int:
        """Its clock at `now` seconds, 32 bits; bit 0 is set, which says that the clock was read."""
        return (self.started_ticks + round(now * (1 + self.skew) / TICK_S)) % 2**32 | 1


ANY_CHIP = Chip()
