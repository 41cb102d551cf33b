"""Changes to the bytes of a file that a reader should survive."""
import re
import struct

NUMBERS = [b"0", b"-1", b"1", b"255", b"65536", b"2147483647", b"2147483648", b"4294967296",
           b"9223372036854775807", b"9223372036854775808", b"18446744073709551616", b"nan", b"-inf", b"1e308",
           b"-1e308", b"1e-308", b"1e999", b"0x10", b"007", b"1,5", b"", b"99999999999999999999999999"]
INTEGERS = [0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x7FFFFFFFFFFFFFFF,
            0x8000000000000000, 0xFFFFFFFFFFFFFFFF]
DOUBLES = [float("nan"), float("inf"), -float("inf"), 1e308, -1e308, 1e-308, 1e18, -3.4028234663852886e38, 1e160,
           1e-162, 5e-324, 0.0, -0.0]
NUMBER = re.compile(rb"(?<![\w.])-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
HEADER = 1500  # where most of what a reader believes is written


def _place(data, rng):
    """A place in the file, half of the time in its header."""
    return rng.randrange(min(len(data), HEADER) if rng.random() < 0.5 else len(data))


def _block(data, rng):
    begin = _place(data, rng)
    return begin, min(len(data), begin + rng.choice([1, 2, 4, 8, 30, 100, 1000]))


def flip(data, rng, _):
    at = _place(data, rng)
    data[at] ^= 1 << rng.randrange(8)


def set_byte(data, rng, _):
    data[_place(data, rng)] = rng.choice([0, 1, 0x0A, 0x0D, 0x20, 0x2D, 0x30, 0x7F, 0x80, 0xC3, 0xFF,
                                      rng.randrange(256)])


def truncate(data, rng, _):
    del data[_place(data, rng):]


def insert(data, rng, _):
    at = _place(data, rng)
    data[at:at] = rng.randbytes(rng.choice([1, 2, 4, 16, 300]))


def delete(data, rng, _):
    begin, end = _block(data, rng)
    del data[begin:end]


def copy_block(data, rng, _):
    begin, end = _block(data, rng)
    block, at = bytes(data[begin:end]), _place(data, rng)
    if rng.random() < 0.5:
        data[at:at] = block
    else:
        data[at:at + len(block)] = block


def edit_number(data, rng, _):
    """A number in text, in the header more often than in the rows."""
    found = list(NUMBER.finditer(data, 0, HEADER if rng.random() < 0.7 else min(len(data), 100_000)))
    if not found:
        return edit_binary_number(data, rng, None)
    match = rng.choice(found)
    data[match.start():match.end()] = rng.choice(NUMBERS)


def edit_binary_number(data, rng, _):
    width = rng.choice("HIQfd")
    value = rng.choice(DOUBLES) if width in "fd" else rng.choice(INTEGERS) & ((1 << 8 * struct.calcsize(width)) - 1)
    if width == "f" and abs(value) > 3.4e38 and value not in (float("inf"), -float("inf")):
        value = -3.4028234663852886e38
    packed = struct.pack(rng.choice("<>") + width, value)
    at = _place(data, rng)
    data[at:at + len(packed)] = packed


def splice(data, rng, other):
    """The beginning of this file and the end of another, each cut at random."""
    if other:
        data[_place(data, rng):] = other[rng.randrange(len(other)):]


def not_utf8(data, rng, _):
    """Bytes that are not UTF-8 in a word."""
    words = [match for match in re.finditer(rb"[A-Za-z]{2,}", data[:HEADER])]
    if words:
        match = rng.choice(words)
        data[match.start() + 1:match.end()] = rng.choice([b"\xff", b"\xc3\x28", b"\xed\xa0\x80", b"\xe9t\xe9"])


def line_ends(data, rng, _):
    data[:] = bytes(data).replace(b"\n", rng.choice([b"\r", b"\r\n", b"\n\n", b" \n", b"\x00"]))


KINDS = [flip, flip, set_byte, set_byte, truncate, insert, delete, copy_block, edit_number, edit_number,
         edit_number, edit_binary_number, splice, not_utf8, line_ends]


def mutated(data, rng, other=b""):
    """The bytes after one to four changes. other: of another file, for splices."""
    changed = bytearray(data)
    for _ in range(rng.choice([1, 1, 1, 2, 3, 4])):
        if changed:
            rng.choice(KINDS)(changed, rng, other)
    return bytes(changed)
