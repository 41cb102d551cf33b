"""What the stages of a job are, as scaling sees them: the one place that says which stage all workers share, which the
leader does alone, and which every process does for itself. A stage whose report has `chunk_seconds` went through the
common counter and is shared, whatever the table says of it."""
import dataclasses


@dataclasses.dataclass(frozen=True)
class Kind:
    work: str                # "shared": dealt out to all workers; "leader": one process, the others wait; "redundant"
    threads: float = 0.0     # share of its seconds that the threads of one process divide among them
    grows: str = "points"    # its seconds grow with the points, or are "constant"
    computes: bool = False   # the targets of threads hold for it
    leader: float = 0.0      # share of its seconds, of a shared one, that the leader does alone beside the others
    per_worker: float = 0.0  # seconds of the leader for every worker, to put together what they have
    team_io: float = 0.0     # times its other bytes that only a team moves, through the storage


KINDS = {
    "count": Kind("shared", threads=0.7, per_worker=0.02),  # grids of cells, put together
    "bin": Kind("shared", threads=0.6, team_io=1.0),        # bins of a team lie in files
    "measure": Kind("leader", threads=0.9, grows="constant"),
    "sort": Kind("shared", threads=0.95, team_io=1.0),
    "normals": Kind("shared", threads=1.0, computes=True),
    "outliers": Kind("shared", threads=1.0, computes=True),
    "smooth": Kind("shared", threads=1.0, computes=True),
    "orient": Kind("leader"),
    "reconstruct": Kind("shared", threads=1.0, computes=True),
    "stitch": Kind("leader"),
    "trace": Kind("redundant"),
    "holes": Kind("shared", threads=1.0),
    "export": Kind("shared", threads=0.5, leader=0.4),  # the checksum takes the mesh from front to back
    "picture": Kind("leader", threads=0.5, grows="constant"),
}
UNKNOWN = Kind("leader")
OUTSIDE = "between the stages"  # keys, meetings, removal of the work directory
ANY_JOB = "any job"             # start and end, whatever the points


def kind_of(stage, facts=None, overrides=None):
    """Of a stage by its name in the report (passes over raw scans have a prefix) and, where given, its facts.
    overrides: {stage: "shared" | "leader" | "redundant"}."""
    name = stage.removeprefix("raw_").rstrip("_0123456789")
    kind = KINDS.get(name, UNKNOWN)
    if overrides and name in overrides:
        return dataclasses.replace(kind, work=overrides[name])
    if facts and facts.get("chunk_seconds"):
        return dataclasses.replace(kind, work="shared", threads=1.0)
    return kind
