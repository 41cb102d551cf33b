#!/usr/bin/env python3
"""The schema of job files, held against the draft that it names by another program: every job file of configs/ and the
file of defaults fit it, and values that the program refuses do not. usage: job_schema_test.py PROGRAM SOURCE_DIR"""
import json
import pathlib
import subprocess
import sys

try:
    import tomllib
    import jsonschema
except ImportError as missing:
    print(f"SKIPPED: the Python module {missing.name}")
    sys.exit(0)

PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
WRONG = {"partition": {"memory": ["much", 1, True]}, "input": {"every": [0, "all"], "crop": [[1, 2, 3]]},
         "normals": {"neighbors": [2, 257, 3.5], "source": ["files"]}, "output": {"patch_color": ["blue"], "colors": [10],
                                                                                           "simplify": ["half", "ratio=", 0.5]},
         "reconstruct": {"ball_radii": [[], [0.0], "automatic"]}, "fill": {"enabled": [1], "max_edges": [-1]}}


def printed(what):
    return subprocess.run([PROGRAM, "config", what], capture_output=True, text=True, check=True).stdout


def refused_by_program(section, key, value):
    text = f"[{section}]\n{key} = {json.dumps(value)}\n"
    done = subprocess.run([PROGRAM, "plan", "/dev/stdin"], input=text, capture_output=True, text=True, check=False)
    return done.returncode == 2 and "names no scans" not in done.stderr


def main():
    schema = json.loads(printed("--schema"))
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    validator.validate(tomllib.loads(printed("--defaults")))
    for path in sorted((SOURCE / "configs").glob("*.toml")):
        validator.validate(tomllib.loads(path.read_text(encoding="utf-8")))
    for section, keys in WRONG.items():
        for key, values in keys.items():
            for value in values:
                assert not validator.is_valid({section: {key: value}}), (section, key, value)
                assert refused_by_program(section, key, value), (section, key, value)
    assert not validator.is_valid({"inputs": {}})
    assert not validator.is_valid({"cleaning": {}, "prepare": {}})
    assert validator.is_valid({"prepare": {"auto": True}})
    print("the schema holds")


if __name__ == "__main__":
    main()
