import os
from typing import Any, Callable, Iterable, Literal, Mapping, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from ._errors import BadInputError as BadInputError
from ._errors import DefectError as DefectError
from ._errors import Interrupted as Interrupted
from ._errors import OrbweaveError as OrbweaveError
from ._errors import OrbweaveWarning as OrbweaveWarning
from ._errors import ResourceError as ResourceError
from ._errors import UsageError as UsageError
from ._orbweave import Hole as Hole
from ._orbweave import Mesh as Mesh
from ._orbweave import PointCloud as PointCloud

__all__ = ["BadInputError", "DefectError", "Hole", "Interrupted", "Mesh", "OrbweaveError", "OrbweaveWarning",
           "PointCloud", "ResourceError", "UsageError", "__version__", "inspect", "job_defaults", "plan", "read_mesh",
           "read_points", "reconstruct", "run", "write_mesh", "write_points"]
__version__: str

_Path = Union[str, bytes, os.PathLike]
_Progress = Callable[[str, float], Any]
_Numbers = Union[Sequence[float], npt.NDArray[Any]]
_Origin = Iterable[float]

def reconstruct(
    points: Union[npt.ArrayLike, PointCloud],
    normals: Optional[npt.ArrayLike] = None,
    *,
    attributes: Optional[Mapping[str, npt.ArrayLike]] = None,
    scanners: Optional[npt.ArrayLike] = None,
    ball_radii: Union[None, Literal["auto"], float, _Numbers] = None,
    levels: Union[None, Literal["auto"], int] = None,
    source: Optional[Literal["auto", "file", "estimate"]] = None,
    neighbors: Optional[int] = None,
    orientation: Optional[Literal["auto", "scanner", "viewpoint", "up", "propagate", "ground", "inward", "none"]] = None,
    viewpoint: Optional[_Numbers] = None,
    up: Optional[_Numbers] = None,
    fill: Optional[bool] = None,
    kernel: Optional[Literal["biharmonic", "triharmonic"]] = None,
    neighborhood: Optional[float] = None,
    max_diameter: Union[None, Literal["auto"], float] = None,
    max_perimeter: Optional[float] = None,
    max_edges: Optional[int] = None,
    keep_outer_border: Optional[bool] = None,
    allow_intersections: Optional[bool] = None,
    graded: Optional[bool] = None,
    min_triangles: Union[None, Literal["auto"], int] = None,
    keep_strays: Optional[bool] = None,
    threads: Optional[int] = None,
    progress: Optional[_Progress] = None,
) -> Mesh: ...
def run(
    job: Union[_Path, Mapping[str, Mapping[str, Any]]],
    *,
    settings: Optional[Mapping[str, Any]] = None,
    fresh: bool = False,
    progress: Optional[_Progress] = None,
) -> dict[str, Any]: ...
def plan(
    job: Union[_Path, Mapping[str, Mapping[str, Any]]],
    *,
    settings: Optional[Mapping[str, Any]] = None,
    progress: Optional[_Progress] = None,
) -> dict[str, Any]: ...
def read_points(path: _Path) -> PointCloud: ...
def read_mesh(path: _Path) -> Mesh: ...
def write_mesh(
    path: _Path, mesh: Mesh, *, binary: bool = True, float_positions: bool = False, origin: _Origin = (0.0, 0.0, 0.0)
) -> None: ...
def write_points(
    path: _Path, cloud: PointCloud, *, binary: bool = True, float_positions: bool = False, origin: _Origin = (0.0, 0.0, 0.0)
) -> None: ...
def inspect(mesh: Mesh) -> dict[str, Any]: ...
def job_defaults() -> str: ...
