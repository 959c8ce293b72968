"""A stream that is cut, exchanged, doubled, garbled, interrupted and lost: no measurement is wrong, none crashes.

What the format cannot tell, a line that is well formed with another digit in it, is told apart by a grammar of its own,
counted, and measured in units of photon noise.
"""

import re

import numpy as np
import pytest

from recordings.importers.tmf882x.assemble import Assembler

BYTE = rb"(?:25[0-5]|2[0-4]\d|1\d\d|[1-9]?\d)"
DATA = re.compile(rb"(?:#Raw,%b,%b(?:,%b){128}|#Obj,%b,%b,%b,%b,-?\d{1,10}(?:,\d{1,5},%b){36}|#Obj)\r?" % ((BYTE,) * 8))
FOREIGN = [
    b"#Conf,Period=16ms,KIter=10000 SPAD=6 Pers=0",
    b"#Err,timeout 8 reg=0x8 exp=0x0 0xFF",
    b"TMF882x state=measure",
    b"#Cal," + b"0," * 130,
    b"#Raw",
    b"#Obj,65",
    b"#HLONG01,2,3",
    b"\xff\x00\xfe",
    b"hello",
    b"",
]
POOL = 64


class Fuzz:
    """Damages lines; `silent` are frames with a line that was changed and is well formed none the less."""

    def __init__(self, rng, digits_only=False):
        self.rng, self.digits_only = rng, digits_only
        self.silent = set()

    def changed(self, frame, old, new):
        if new != old and DATA.fullmatch(new):
            self.silent.add(frame)
        return new

    def garbled(self, line):
        if self.digits_only:
            at = [i for i, byte in enumerate(line) if byte in b"0123456789"]
            there = self.rng.choice(at)
            return line[:there] + b"%d" % self.rng.integers(10) + line[there + 1 :]
        new = bytearray(line)
        likely = np.frombuffer(b"0123456789,#-\n\r", np.uint8)
        for at in self.rng.integers(0, len(line), self.rng.integers(1, 6)):
            new[at] = self.rng.choice(likely) if self.rng.random() < 0.5 else self.rng.integers(256)
        return bytes(new)

    def damage(self, lines, share):
        """[(frame, line with its newline)] in, the same damaged, out."""
        rng, out, skip = self.rng, list(lines), 0
        for i in np.flatnonzero(rng.random(len(lines)) < share):
            frame, line = out[i]
            kind = 9 if self.digits_only else rng.integers(9)
            if not line or i < skip:
                continue
            body = line[:-1]
            if kind == 0:  # cut, with its newline
                out[i] = frame, self.changed(frame, body, body[: rng.integers(len(body))]) + b"\n"
            elif kind == 1:  # cut without, so the next one follows on it
                out[i] = frame, body[: rng.integers(len(body))]
            elif kind == 2 and i + 10 < len(out):  # exchanged
                j = i + rng.integers(1, 10)
                out[i], out[j] = out[j], out[i]
            elif kind == 3:  # twice
                out[i] = frame, line + line
            elif kind in (4, 9):  # garbled
                out[i] = frame, self.changed(frame, body, self.garbled(body)) + b"\n"
            elif kind == 5:  # a line of others
                out[i] = frame, line + FOREIGN[rng.integers(len(FOREIGN))] + b"\n"
            elif kind == 6:  # lost
                out[i] = frame, b""
            elif kind == 7 and rng.random() < 0.2:  # many lost
                skip = i + rng.integers(1, 100)
                out[i:skip] = [(f, b"") for f, _ in out[i:skip]]
            elif kind == 8 and i + 1 < len(out):  # bytes lost, over the end of the line or within it
                after = (line + out[i + 1][1]).rstrip(b"\n")
                start = rng.integers(len(body))
                new = after[:start] + after[start + rng.integers(1, 500) :]
                for piece in new.split(b"\n"):
                    if piece not in (body, out[i + 1][1][:-1]):
                        self.changed(frame, body, piece)
                out[i], out[i + 1] = (frame, new + b"\n"), (out[i + 1][0], b"")
        return out


def run(firmware, seed, frames, share, digits_only=False, mode="3x3"):
    """What the tally says, how far measurements are off that are wrong, and which were changed unseen."""
    rng = np.random.default_rng(seed)
    zones, bursts, captures = {"3x3": (9, 1, 1), "4x4": (16, 2, 1), "8x8": (64, 8, 4)}[mode]
    counts, reference = np.split(firmware.scene(rng, POOL, zones + bursts), [zones], axis=1)
    pool = [firmware.measurement(mode, *one, 0) for one in zip(counts, reference, strict=True)]
    fuzz, assembler = Fuzz(rng, digits_only), Assembler(mode, 4000)
    wrong, left = {}, b""
    for start in range(0, frames, 500):
        lines = []
        for k in range(start, min(start + 500, frames)):
            results = (firmware.result_line(captures * k + part, tick=2 * k + 1) for part in range(captures))
            told = (next(results) if line.startswith(b"#Obj") else line for line in pool[k % POOL])
            lines += [(k, line + b"\n") for line in told]
        for frame, piece in fuzz.damage(lines, share):
            *whole, left = (left + piece).split(b"\n")
            for line in whole:
                got = assembler.push(line, float(frame))
                if got is None:
                    continue
                # A tick whose last digit changed says that it is not valid.
                ticked = np.isfinite(got.tick_s)
                claimed = (round(got.tick_s / 200e-9) - 1) // 2 if ticked else int(got.host_s)
                true = np.vstack([reference[claimed % POOL], counts[claimed % POOL]])
                off = np.abs(np.vstack([got.reference, got.counts]).astype(float) - true)
                if off.any():
                    wrong[claimed, int(got.host_s)] = (off / np.sqrt(true + 1)).max()
    return assembler.tally, wrong, fuzz.silent


def check(tally, wrong, silent):
    unexplained = {who: off for who, off in wrong.items() if not silent.intersection(who)}
    assert unexplained == {}
    off = np.array(sorted(wrong.values()))
    passed = {f"> {limit}": int((off > limit).sum()) for limit in (0, 1, 3, 8, 30, 100)}
    print(f"\n{tally.said()}\n{len(silent)} measurements with a well-formed change, passed by noise: {passed}")


def test_ten_thousand_lines(firmware):
    tally, wrong, silent = run(firmware, 1, 330, 0.01)
    check(tally, wrong, silent)
    assert tally.frames > 150
    assert tally.dropped > 30


def test_ten_thousand_lines_with_other_digits(firmware):
    tally, wrong, silent = run(firmware, 2, 330, 0.01, digits_only=True)
    check(tally, wrong, silent)
    assert len(wrong) < 0.8 * len(silent)


@pytest.mark.parametrize(("mode", "frames", "share"), [("4x4", 160, 0.004), ("8x8", 20, 0.0005)])
def test_ten_thousand_lines_of_other_modes(firmware, mode, frames, share):
    tally, wrong, silent = run(firmware, 5, frames, share, mode=mode)
    check(tally, wrong, silent)
    assert tally.frames > 0.5 * frames
    assert tally.dropped > 0


@pytest.mark.slow
def test_a_million_lines(firmware):
    tally, wrong, silent = run(firmware, 3, 32_300, 0.02)
    assert tally.lines > 950_000
    check(tally, wrong, silent)


@pytest.mark.slow
def test_a_million_lines_with_other_digits(firmware):
    tally, wrong, silent = run(firmware, 4, 32_300, 0.02, digits_only=True)
    check(tally, wrong, silent)
