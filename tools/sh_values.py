#!/usr/bin/env python3
"""Writes testdata/sh_values.json: 30-digit real spherical harmonics at chosen directions, by mpmath.

Usage: sh_values.py [--check]    (--check: compare with the file instead of writing it)

Each direction is three float32 numbers, exact in float32 and float64 alike and so not of unit length to the last
digit; the values belong to the direction they give, normalised. P_lm is summed from its explicit polynomial in
sin^2(theta/2), with 200 digits: no recurrence is shared with the code under test.
"""
import json
import struct
import sys
from pathlib import Path

import mpmath as mp

mp.mp.dps = 240
PATH = Path(__file__).resolve().parent.parent / "testdata" / "sh_values.json"


def as_float32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def directions():
    """(name, components, bands at which a sample of the coefficients is listed)."""
    named = [
        ("+z", (0, 0, 1)),
        ("-z", (0, 0, -1)),
        ("+x", (1, 0, 0)),
        ("-y", (0, -1, 0)),
        ("general", (0.36, 0.48, 0.8)),
        ("below the horizon", (-0.48, 0.64, -0.6)),
        ("near the horizon", (0.8, -0.6, 1e-4)),
        ("0.1 from the pole", (0.06, -0.08, 0.99498743)),
        ("0.01 from the pole", (-0.006, 0.008, 0.99995)),
        ("1e-3 from the south pole", (6e-4, 8e-4, -0.9999995)),
        ("1e-6 from the pole", (6e-7, -8e-7, 1)),
        ("denormal x", (1e-42, 0, 1)),
        ("length 3", (2, -1, 2)),
        ("length 1e-30", (-2e-30, 3e-30, 6e-30)),
        ("length 1e30", (2e30, 3e30, -6e30)),
    ]
    return [(name, tuple(as_float32(v) for v in d)) for name, d in named]


def degrees():
    """Degrees at which values are listed; every order up to l = 7, a spread of orders above."""
    for l in [0, 1, 2, 3, 4, 5, 6, 7]:
        yield l, range(-l, l + 1)
    for l in [11, 15, 31, 63, 100, 127, 181, 255]:
        orders = {0, 1, 2, 3, l // 4, l // 2, int(l * 0.7), l - 1, l}
        yield l, sorted(m for m in orders | {-m for m in orders})


def harmonic(l, m, direction):
    """Real orthonormal Y_lm with Condon-Shortley phase, m < 0 with sin(|m| phi)."""
    x, y, z = (mp.mpf(v) for v in direction)
    r = mp.sqrt(x * x + y * y + z * z)
    x, y, z = x / r, y / r, z / r
    k = abs(m)
    # P_l^k = sin^k (l+k)! / (2^k k! (l-k)!) * 2F1(k-l, l+k+1; k+1; (1-z)/2), a polynomial.
    half = (1 - z) / 2
    term = mp.mpf(1)
    total = mp.mpf(1)
    for j in range(l - k):
        term *= mp.mpf((k - l + j) * (l + k + 1 + j)) / ((k + 1 + j) * (j + 1)) * half
        total += term
    norm = mp.sqrt(mp.mpf(2 * l + 1) / (4 * mp.pi) * mp.factorial(l - k) / mp.factorial(l + k))
    norm *= mp.factorial(l + k) / (mp.mpf(2) ** k * mp.factorial(k) * mp.factorial(l - k))
    power = (mp.mpc(x, y)) ** k if k else mp.mpc(1)
    angle = power.imag if m < 0 else power.real
    scale = mp.sqrt(2) * (-1) ** k if k else 1
    return norm * scale * angle * total


def generate():
    items = []
    for name, direction in directions():
        values = []
        for l, orders in degrees():
            for m in orders:
                value = mp.nstr(harmonic(l, m, direction), 30, strip_zeros=True)
                values.append(f"[{l}, {m}, \"{value}\"]")
        lines = ",\n      ".join(", ".join(values[i : i + 2]) for i in range(0, len(values), 2))
        numbers = ", ".join(repr(v) for v in direction)
        items.append(
            f'    {{\n      "name": {json.dumps(name)},\n      "direction": [{numbers}],\n'
            f'      "values": [\n      {lines}\n      ]\n    }}'
        )
    head = (
        '{\n  "made_by": "tools/sh_values.py",\n'
        '  "convention": "real orthonormal, Condon-Shortley phase, z polar; directions are float32 numbers, normalised",\n'
        '  "rows": "l, m, Y_lm to 30 digits",\n  "directions": [\n'
    )
    return head + ",\n".join(items) + "\n  ]\n}\n"


def main():
    text = generate()
    json.loads(text)
    if sys.argv[1:] == ["--check"]:
        if PATH.read_text() != text:
            sys.exit(f"{PATH.name} differs from what this script makes; run it without --check")
    elif sys.argv[1:]:
        sys.exit(__doc__)
    else:
        PATH.write_text(text)


main()
