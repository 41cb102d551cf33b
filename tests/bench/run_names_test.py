#!/usr/bin/env python3
"""Every benchmark that bench/run.sh names is a script that can be run."""
import os
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
LISTS = ("of_scans", "of_scale", "others")


class RunNames(unittest.TestCase):
    def test_scripts_of_all_names_can_be_run(self):
        text = (ROOT / "bench/run.sh").read_text(encoding="utf-8")
        for name in LISTS:
            words = re.search(rf"^{name}=\(([^)]*)\)", text, re.MULTILINE).group(1).split()
            self.assertGreater(len(words), 3, name)
            for word in words:
                script = ROOT / ("tests/soak/scans_same_bytes.py" if word == "same_bytes" else f"bench/{word}.py")
                self.assertTrue(os.access(script, os.X_OK), f"bench/run.sh names {word}, but {script} cannot be run")


if __name__ == "__main__":
    unittest.main()
