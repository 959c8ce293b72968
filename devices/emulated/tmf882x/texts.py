"""What the reference firmware prints that is neither a measurement nor a setting."""

HELP = [
    "TMF8828 Arduino Driver",
    "UART commands",
    "a ... dump registers",
    "c ... next configuration",
    "d ... disable device",
    "e ... enable device and download TMF8828 FW",
    "E ... enable device and download TMF8821 FW",
    "f ... do fact calib",
    "h ... help ",
    "i ... i2c addr. change",
    "l ... load fact calib",
    "m ... measure",
    "o ... toggle between TMF8828 and TMF882X",
    "O ... toggle between short range and long range accuracy modes",
    "p ... power down",
    "r ... restore fact calib from file",
    "s ... stop measure",
    "t ... next persistance set",
    "w ... wakeup",
    "x ... clock corr on/off",
    "z ... histogram",
    "+ ... log+",
    "- ... log-",
    "# ... reset",
]

DOWNLOADED = " DWNL"
NO_CHIP = "#Err,timeout {waited} reg=0x8 exp=0x0 0xFF"


def register_lines(registers: bytes) -> list[str]:
    """256 registers, eight a line."""
    rows = (registers[start : start + 8] for start in range(0, 256, 8))
    return [f"0x{8 * row:X}: " + "".join(f" 0x{byte:X} " for byte in eight) for row, eight in enumerate(rows)]
