#!/usr/bin/env python3
"""Writes gensky.json: sky luminances of Radiance's gensky, relative to the zenith.

Needs `pip install pyradiance`, which is large, so `make test` does not run this; --check compares with the file.
gensky places the sun and scales the sky; rcalc evaluates the formulas of its skybright.cal above the horizon, before they
are mixed with the ground. Radiance's axes are x east, y north, z up; ylm's are x, z, −y of them.
"""

import json
import math
import pathlib
import subprocess
import sys

import pyradiance

ROOT = pathlib.Path(pyradiance.__file__).parent
OUT = pathlib.Path(__file__).parent / "gensky.json"
SKIES = {"clear": ("-s", "sunnysky"), "overcast": ("-c", "cloudysky"), "cie5": ("-u", "unifsky"), "intermediate": ("-i", "intersky")}
# What rayinit.cal defines for cal files.
ACOS = "PI:3.14159265358979323846;Acos(x):if(x-1,0,if(-1-x,PI,acos(x)))"


def directions():
    for elevation in (3, 10, 20, 35, 50, 65, 80, 90):
        for azimuth in range(0, 360, 30 if elevation < 90 else 360):
            e, a = math.radians(elevation), math.radians(azimuth)
            yield (math.cos(e) * math.sin(a), math.cos(e) * math.cos(a), math.sin(e))


def sky(name, altitude, azimuth):
    option, function = SKIES[name]
    command = [ROOT / "bin/gensky", "-ang", str(altitude), str(azimuth), option, "-g", "0.2"]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split("skybright.cal")[1]
    numbers = [float(word) for word in lines.split()[2:]]
    arguments = ";".join(f"A{i + 1}:{value}" for i, value in enumerate(numbers))
    points = list(directions())
    text = "\n".join(" ".join(map(repr, point)) for point in points)
    program = f"Dx=$1;Dy=$2;Dz=$3;$1={function}"
    command = [ROOT / "bin/rcalc", "-e", f"{ACOS};{arguments}", "-f", ROOT / "lib/skybright.cal", "-e", program]
    values = subprocess.run(command, check=True, capture_output=True, text=True, input=text).stdout.split()
    luminances = [float(value) for value in values]
    assert len(luminances) == len(points)
    zenith = luminances[-1]
    ours = [[round(x, 9), round(z, 9), round(-y, 9)] for x, y, z in points]
    sun = numbers[4:7]
    return {
        "sky": name,
        "sun": [sun[0], sun[2], -sun[1]] if sun else None,
        "ground_over_zenith": numbers[2] / numbers[1],
        "directions": ours,
        "over_zenith": [round(luminance / zenith, 6) for luminance in luminances],
    }


def main():
    suns = [(10, -60), (35, 30), (62, 100), (85, 0)]
    skies = [sky(name, *sun) for name in ("clear", "intermediate") for sun in suns]
    skies += [sky("overcast", 35, 30), sky("cie5", 35, 30)]
    text = json.dumps({"source": "gensky and skybright.cal of pyradiance, by gensky_values.py", "skies": skies}) + "\n"
    if "--check" in sys.argv:
        sys.exit(0 if OUT.read_text() == text else f"{OUT} is not what this writes")
    OUT.write_text(text)


main()
