"""The emulated firmware prints what the protocol says: transcribed here by hand, it shares nothing with the source."""

import struct

import numpy as np
import pytest

from devices.emulated.tmf882x.chip import ANY_CHIP, Chip
from devices.emulated.tmf882x.firmware import Firmware

COMMANDS = "acdeEfhilmoOprstwxz+-#"
DISABLED_882X = "TMF882x state=disabled\n"
STOPPED_882X, STOPPED_8828 = "TMF882x state=stopped\n", "TMF8828 state=stopped\n"
CONF_3X3 = "#Conf,Period=16ms,KIter=10000 SPAD=6 Pers=0\n"
CONF_4X4 = "#Conf,Period=8ms,KIter=2500 SPAD=7 Pers=0\n"
CONF_8X8 = "#Conf,Period=132ms,KIter=10 SPAD=15 Pers=0\n"
CONF_8X8_MORE = "#Conf,Period=264ms,KIter=2500 SPAD=15 Pers=0\n"


def ramp(setting):
    """Counts whose every byte differs from its neighbours'."""
    cells = np.arange(setting.sets * 10 * 128, dtype=np.uint64)
    return (cells * 2654435761 % 2**24).astype(np.uint32).reshape(setting.sets, 10, 128)


class Bench:
    """A firmware and its clock."""

    def __init__(self, source=None, chip=ANY_CHIP, seed=0):
        self.firmware = Firmware(source, np.random.default_rng(seed), chip)
        self.now = 0.0

    def until_quiet(self, at_most_s=60.0):
        """All that comes by itself."""
        heard, end = "", self.now + at_most_s
        while (due := self.firmware.next_due) is not None and due <= end:
            self.now = max(self.now, due)
            heard += b"".join(self.firmware.take(self.now)).decode("latin-1")
        if due is not None:
            self.now = max(self.now, end)
        return heard

    def say(self, commands):
        """The answer to characters."""
        heard = self.until_quiet(0.0)
        self.firmware.write(commands.encode("latin-1"), self.now)
        return heard + self.until_quiet()


@pytest.fixture
def bench():
    bench = Bench()
    bench.boot = bench.until_quiet()
    return bench


@pytest.fixture
def stopped(bench):
    bench.say("E")
    return bench


def test_boot_prints_24_lines_of_help(bench):
    lines = bench.boot.split("\n")
    assert lines.pop() == ""
    assert len(lines) == 24
    assert lines[1] == "UART commands"
    assert [line[:6] for line in lines[2:]] == [f"{command} ... " for command in COMMANDS]


def test_the_start_of_the_reference_driver(bench):
    assert bench.say("h") == bench.boot + "TMF8828 state=disabled\n"
    assert bench.say("d") == "TMF8828 state=disabled\n"
    timeout, *rest = bench.say("o").splitlines(keepends=True)
    assert timeout.startswith("#Err,timeout ")
    assert timeout.endswith(" reg=0x8 exp=0x0 0xFF\n")
    assert rest == ["#Err,mode switch to,0\n", DISABLED_882X]
    answer = bench.say("E")
    assert answer.startswith(f" DWNL\n#Err,mode switch to,1\n{CONF_3X3}{bench.boot}Driver 1.14 FW ")
    assert answer[-22:] == STOPPED_882X
    assert bench.say("z") == f"{CONF_3X3}Histogram is 1\n{STOPPED_882X}"


def test_the_larger_sensor_with_its_image(bench):
    answer = bench.say("e")
    assert answer.startswith(f" DWNL\n{CONF_8X8}")
    assert answer.endswith(STOPPED_8828)
    assert bench.say("c") == CONF_8X8_MORE + STOPPED_8828
    assert bench.say("o") == STOPPED_882X
    assert bench.say("o") == STOPPED_8828


def test_a_smaller_sensor_has_no_8x8():
    bench = Bench(chip=Chip(has_8x8=False))
    assert "#Err,mode switch to,1\n" in bench.say("e")
    assert bench.say("o") == f"#Err,mode switch to,1\n{STOPPED_882X}"


def test_the_device_line():
    bench = Bench(chip=Chip(serial=0xBEEF, firmware=(3, 1, 2, 0), chip=(34, 1)))
    bench.say("E")
    assert bench.say("e") == f"Driver 1.14 FW 3.1.2.0. Chip 34.1 Serial 0xBEEF\n{STOPPED_882X}"


def test_configurations_run_past_the_end_of_the_table(stopped):
    assert stopped.say("c") == CONF_4X4 + STOPPED_882X
    # In memory the next row is the first of the other sensor's.
    assert stopped.say("c") == CONF_8X8 + STOPPED_882X
    assert stopped.say("c") == CONF_3X3 + STOPPED_882X


def test_garbage_past_the_end_of_both_tables():
    answers = set()
    for seed in range(5):
        bench = Bench(seed=seed)
        bench.say("ec")
        answer = bench.say("c")
        assert answer.startswith("#Conf,Period=")
        answers.add(answer)
    assert len(answers) > 1


def test_settings_one_after_another(stopped):
    assert [stopped.say("z").split("\n")[1] for _ in range(4)] == [f"Histogram is {n}" for n in (1, 2, 3, 0)]
    assert [stopped.say("t")[-24 - len(STOPPED_882X) :].split("Pers=")[1][0] for _ in range(3)] == ["1", "3", "0"]
    assert stopped.say("O") == CONF_3X3 + STOPPED_882X
    assert stopped.say("x") == f"Clk corr is 0\n{STOPPED_882X}"
    assert stopped.say("x") == f"Clk corr is 1\n{STOPPED_882X}"
    assert stopped.say("i") == f"I2C Addr=66\n{STOPPED_882X}"
    assert stopped.say("i") == f"I2C Addr=65\n{STOPPED_882X}"
    assert stopped.say("-").startswith("Log=0\n")
    assert stopped.say("#") == f"Reset TMF8828\n{STOPPED_882X}"
    assert stopped.say("p") == "TMF882x state=standby\n"
    assert stopped.say("m") == "TMF882x state=standby\n"
    assert stopped.say("w") == STOPPED_882X


def test_characters_that_are_no_commands(stopped):
    assert stopped.say("Q") == f"#Err,Cmd Q\n{STOPPED_882X}"
    assert stopped.say("q") == ""
    assert stopped.say(" \n\r~\x7f\xff") == ""


@pytest.mark.parametrize("command", "cztflrsmpw")
def test_nothing_happens_to_a_disabled_sensor(bench, command):
    assert bench.say(command) == "TMF8828 state=disabled\n"


def test_registers(stopped):
    lines = stopped.say("Oa").split("\n")[2:-2]
    assert len(lines) == 32
    values = [line.split(": ") for line in lines]
    assert [int(address, 16) for address, _ in values] == list(range(0, 256, 8))
    registers = [int(one, 16) for _, rest in values for one in rest.split()]
    assert len(registers) == 256
    assert registers[0x19] == 0x6E
    assert lines[3].startswith("0x18:  0x0  0x6E ")


@pytest.mark.parametrize(
    ("start", "name", "pages"), [("E", "tmf882x_calib_long_", 1), ("eO", "tmf8828_calib_short_", 4)]
)
def test_pages_of_factory_calibration(start, name, pages):
    bench = Bench()
    bench.say(start)
    answer = bench.say("f")
    assert answer.startswith("Fact Cal\n#Conf,")
    lines = bench.say("l").split("\n")[:-2]
    assert len(lines) == 26 * pages
    for number in range(pages):
        head, *rows, tail = lines[26 * number : 26 * (number + 1)]
        assert (head, tail) == (f"const PROGMEM uint8_t {name}{number}[] = {{", "};")
        assert all(row.startswith(" 0x") and row.endswith(",") for row in rows)
        page = bytes(int(one, 16) for row in rows for one in row.strip(", ").split(","))
        assert len(page) == 192
        assert (page[0], page[2]) == (0x19, 0xBC)
        (kilo,) = struct.unpack_from("<H", page, 4 + 0x06)
        assert kilo == 4000
        positions = np.array(struct.unpack_from("<10I", page, 4 + 0x10)) / 32768
        assert np.all(np.abs(positions - 15) < 1.5)
        assert page[4 + 0xB8] == 0
    assert bench.say("r").startswith("Set fact cal\n")


def frames(text):
    """(index, values) of `#Raw` lines and the fields of `#Obj` lines, in order."""
    out = []
    for line in text.split("\n"):
        kind, *fields = line.split(",")
        if kind in ("#Raw", "#Cal", "#Obj"):
            out.append((kind, [int(field) for field in fields]))
    return out


@pytest.mark.parametrize(("commands", "captures", "sets"), [("Ezm", 1, 1), ("Eczm", 1, 2), ("ezm", 4, 2)])
def test_a_measurement(commands, captures, sets):
    seen = []

    def source(setting):
        seen.append(ramp(setting))
        return seen[-1]

    bench = Bench(source, Chip(temperature_c=-5))
    bench.say(commands[:-1])
    bench.firmware.write(b"m", bench.now)
    text = ""
    while text.count("#Obj") < captures:
        text += bench.until_quiet(0.1)
    lines = frames(text)[: captures * (30 * sets + 1)]
    for capture in range(captures):
        part = lines[capture * (30 * sets + 1) :][: 30 * sets + 1]
        assert [kind for kind, _ in part] == ["#Raw"] * (30 * sets) + ["#Obj"]
        assert [fields[1] for _, fields in part[:-1]] == list(range(30)) * sets
        for number in range(sets):
            rows = [fields[2:] for _, fields in part[30 * number : 30 * (number + 1)]]
            for channel in range(10):
                low, mid, high = (rows[plane * 10 + channel] for plane in range(3))
                counts = [a + 256 * b + 65536 * c for a, b, c in zip(low, mid, high, strict=True)]
                assert counts == seen[0][capture * sets + number, channel].tolist()
        result = part[-1][1]
        assert len(result) == 77
        assert result[:3] == [65, capture, 251]


def test_numbers_and_ticks_wrap():
    bench = Bench(chip=Chip(started_ticks=2**31 - 10_000_000))
    bench.say("E")
    bench.firmware.write(b"m", bench.now)
    text = ""
    while text.count("#Obj") < 300:
        text += bench.until_quiet(10.0)
    results = [fields for kind, fields in frames(text) if kind == "#Obj"]
    assert [fields[1] for fields in results] == [n % 256 for n in range(len(results))]
    ticks = [fields[4] for fields in results]
    assert max(ticks) > 0 > min(ticks)
    assert all(-(2**31) <= tick < 2**31 and tick % 2 for tick in ticks)


def test_a_stop_cuts_after_a_whole_line(stopped):
    stopped.say("z")
    stopped.firmware.write(b"m", stopped.now)
    text = ""
    while text.count("#Raw") < 12:
        text += stopped.until_quiet(0.01)
    rest = stopped.say("s")
    lines = (text + rest).split("\n")
    assert lines[-2:] == [STOPPED_882X[:-1], ""]
    assert all(len(line.split(",")) == 131 for line in lines if line.startswith("#Raw"))
    assert (text + rest).count("#Raw") < 30
    assert stopped.until_quiet() == ""
    again = stopped.say("h")
    assert again.endswith(STOPPED_882X)


def test_no_faster_than_line_and_laser(stopped):
    """At 2 Mbaud, ten bits a byte; a burst of N shots at 17.77 MHz comes before its lines."""
    stopped.say("z")
    began = stopped.now
    stopped.firmware.write(b"m", stopped.now)
    sent, first, measurements = 0, None, 0
    while measurements < 3:
        stopped.now = stopped.firmware.next_due
        data = b"".join(stopped.firmware.take(stopped.now))
        sent += len(data)
        measurements += data.count(b"#Obj")
        if first is None and b"#Raw" in data:
            first = stopped.now
        assert sent <= (stopped.now - began) * 200_000 + 1
    burst = 10000 * 1024 / 17.77e6
    assert first - began >= burst
    assert stopped.now - began >= 3 * burst


def test_histograms_of_the_electrical_calibration(stopped):
    stopped.say("zzz")
    stopped.firmware.write(b"m", stopped.now)
    text = ""
    while "#Obj" not in text:
        text += stopped.until_quiet(0.1)
    kinds = [kind for kind, _ in frames(text)]
    assert (kinds.count("#Raw"), kinds.count("#Cal")) == (30, 30)


def test_without_histograms_there_are_results_alone(stopped):
    stopped.firmware.write(b"m", stopped.now)
    text = stopped.until_quiet(2.0)
    assert "#Raw" not in text
    assert text.count("#Obj") >= 2


def test_what_the_chip_finds_is_where_the_wall_is():
    bench = Bench()  # the wall is 0.8 m away
    bench.say("Ez")
    bench.firmware.write(b"m", bench.now)
    text = ""
    while "#Obj" not in text:
        text += bench.until_quiet(0.1)
    fields = next(fields for kind, fields in frames(text) if kind == "#Obj")
    distances, confidences = np.array(fields[5::2]), np.array(fields[6::2])
    assert np.all(np.abs(distances[:9] - 800) < 30)
    assert np.all(confidences[:9] >= 6)
    assert not distances[9:18].any()
    assert not distances[27:].any()
