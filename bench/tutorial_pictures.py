#!/usr/bin/env python3
"""The pictures of docs/tutorials.md: runs the commands of the tutorials as they stand, takes every picture that they ask the
program for, and writes it to docs/images/tutorials at two fifths of its size and with 256 colours.

usage: bench/tutorial_pictures.py [--check] [PROGRAM_DIR]

--check runs nothing and ends with 1 where the page shows a picture that no command makes, where a command makes one that the page
does not show, or where a file is absent or above 60 kB. Drawing needs Debian's python3-pil."""
import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import interpreter

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "tutorials.md"
IMAGES = ROOT / "docs" / "images" / "tutorials"
SIZE = (480, 360)
COLORS = 256
MOST_BYTES = 60_000


def scripts():
    return re.findall(r"^```sh\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.M | re.S)


def made_by(script):
    """Names of the pictures that the commands ask for, by the option or by the job's key."""
    return re.findall(r"(?:--picture |output\.picture=)(\S+\.png)", script)


def run(script, folder, program_dir):
    environment = dict(os.environ, PATH=f"{program_dir}{os.pathsep}{os.environ['PATH']}")
    done = subprocess.run(["bash", "-euo", "pipefail", "-c", script], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"exit status {done.returncode} from\n{script}\n{done.stderr}")


def reduce(source, target):
    from PIL import Image
    with Image.open(source) as picture:
        small = picture.convert("RGB").resize(SIZE, Image.Resampling.BOX)
    # The same picture makes the same file: no dithering.
    small.quantize(COLORS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(target, optimize=True)


def draw(program_dir):
    IMAGES.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for script in scripts():
            run(script, folder, program_dir)
            for name in made_by(script):
                reduce(pathlib.Path(folder) / name, IMAGES / name)


def check():
    made = {name for script in scripts() for name in made_by(script)}
    shown = set(re.findall(r"!\[[^]]*\]\(images/tutorials/([^)]+)\)", PAGE.read_text(encoding="utf-8")))
    there = {path.name: path.stat().st_size for path in IMAGES.glob("*")}
    wrong = [f"{name}: not made, shown and there" for name in sorted(made | shown | set(there))
             if not (name in made and name in shown and name in there)]
    wrong += [f"{name}: {size:,} bytes" for name, size in there.items() if size > MOST_BYTES]
    if wrong or not made:
        sys.exit(f"tutorial pictures: {'; '.join(wrong)}; run bench/tutorial_pictures.py")
    print(f"tutorial pictures: {len(made)} are made, shown and small")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("program_dir", nargs="?", default=ROOT / "build/release/bin", type=pathlib.Path)
    options = parser.parse_args()
    if not options.check:
        interpreter.need("PIL")
        draw(options.program_dir.resolve())
    check()


if __name__ == "__main__":
    main()
