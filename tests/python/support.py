"""Clouds, and the program beside the module."""
import os
import pathlib
import subprocess

import numpy


def sphere(points=2000, seed=0):
    """Points evenly apart on the unit sphere, in a random order; they are their normals, too."""
    i = numpy.arange(points)
    z = 1.0 - (2.0 * i + 1.0) / points
    radius, angle = numpy.sqrt(1.0 - z * z), 2.399963229728653 * i
    cloud = numpy.column_stack([radius * numpy.cos(angle), radius * numpy.sin(angle), z])
    return numpy.random.default_rng(seed).permutation(cloud)


def program(*arguments):
    """Runs orbweave in the current directory."""
    return subprocess.run([os.environ["ORBWEAVE_PROGRAM"], *map(str, arguments)], capture_output=True, text=True, check=True)


def bytes_of(path):
    return pathlib.Path(path).read_bytes()
