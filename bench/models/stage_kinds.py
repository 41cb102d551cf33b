"""What the stages of a job are, as scaling sees them: which stage all workers share, which the leader does alone, and
which every process does for itself. The kinds are those of the program's table of stages: bench/models/stages.json is what
`orbweave status --stages --json` prints, and a test compares the two. A stage whose report has `chunk_seconds` went
through the common counter and is shared, whatever the table says of it."""
import dataclasses
import json
import pathlib


@dataclasses.dataclass(frozen=True)
class Kind:
    work: str                # "shared": dealt out to all workers; "leader": one process, the others wait; "redundant"
    threads: float = 0.0     # share of its seconds that the threads of one process divide among them
    grows: str = "points"    # its seconds grow with the points, or are "constant"
    fixed: float = 0.0       # seconds of one thread that do not grow with the points
    computes: bool = False   # the targets of threads hold for it
    leader: float = 0.0      # share of its seconds, of a shared one, that the leader does alone beside the others
    merge: float = 0.0       # seconds to add what one worker has to what another has; in pairs, log2(workers) in a row
    team_io: float = 0.0     # times its other bytes that only a team moves, through the storage; where none was counted


def read_kinds():
    """The kinds of all stages, by their names in the report. Two stages are called export: of a mesh file, the first,
    and of tiles, which is kept under its directory."""
    table = json.loads((pathlib.Path(__file__).parent / "stages.json").read_text(encoding="utf-8"))
    kinds = {}
    for row in table["stages"]:
        kinds[row["directory"] if row["name"] in kinds else row["name"]] = Kind(**row["scaling"])
    return kinds


KINDS = read_kinds()
UNKNOWN = Kind("leader")
OUTSIDE = "between the stages"  # keys, meetings, removal of the work directory
ANY_JOB = "any job"             # start and end, whatever the points


def kind_of(stage, facts=None, overrides=None):
    """Of a stage by its name in the report (stages that run several times have a number) and, where given, its facts.
    overrides: {stage: "shared" | "leader" | "redundant"}."""
    name = stage.rstrip("_0123456789")
    kind = KINDS.get(name, UNKNOWN)
    if overrides and name in overrides:
        return dataclasses.replace(kind, work=overrides[name])
    if facts and facts.get("chunk_seconds"):
        return dataclasses.replace(kind, work="shared", threads=1.0)
    return kind
