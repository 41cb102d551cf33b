"""How long a job takes on a cluster, from the chunk times of one measured job: event-driven list scheduling.

Every thread of every worker takes the longest task that is left from the common counter, reads its bytes, computes,
writes its bytes, and takes the next; a stage ends with its last task, the next begins when all have met. Transfers
under way share the bandwidth of the storage evenly, each limited to its thread's share of its worker's. What the
leader does alone, everybody waits for. The bound of such a schedule: Graham, 1969, Bounds on Multiprocessing Timing
Anomalies, section 2 (longest first: at most 4/3 of the best)."""
import dataclasses
import heapq
import math

import stage_kinds

ASSUMPTIONS = (
    "chunk times are those of one thread with the machine to itself, input and store in the page cache: what they "
    "contain of reading and writing counts as computing, and the transfer from the storage comes on top",
    "a thread does not compute while it transfers; the other threads do; a chunk's share of its stage's bytes is its "
    "share of the stage's seconds",
    "transfers under way share the storage's bandwidth evenly, each at most its worker's bandwidth over its threads; "
    "reading again what another worker has just read costs the same as the first time",
    "a job of more points has more chunks of the same size with the same spread of times; a stage's seconds and bytes "
    "grow with the points, or not at all, as bench/models/stage_kinds.py says",
    "what is shared without chunks is cut into equal parts, one a worker, whose threads help as far as "
    "bench/models/stage_kinds.py says; the input is of a format whose rows can be shared (not text, not compressed)",
    "bins of a team pass through the storage, though those of one process may stay in memory",
    "longest first is exact: the program orders chunks by their points, to within a factor of two",
    "all workers are alike and live to the end; one process alone needs no counter",
    "memory does not limit how many threads of a worker are at work",
)


@dataclasses.dataclass(frozen=True)
class Cluster:
    workers: int
    threads: int = 1                  # of a worker
    storage_bandwidth: float = math.inf  # bytes per second, of all together
    worker_bandwidth: float = math.inf   # bytes per second, of one
    task_seconds: float = 0.002       # opening files, per task
    counter_seconds: float = 0.0      # that the common counter is busy with giving out one
    stage_seconds: float = 0.02       # meeting, per stage
    slowdown: float = 0.0             # of every thread of a worker, per further thread beside it
    cores: float = math.inf           # that all workers have together, where they share a machine

    def slots(self):
        return self.workers * self.threads

    def pace(self):
        """How much longer a task takes than with the machine to itself."""
        return 1.0 + self.slowdown * (self.threads - 1)


class _Shared:
    """What all that are in it get an even share of: `capacity` a second, each at most `most`."""

    def __init__(self, capacity, most):
        self.capacity, self.most = capacity, most
        self.served, self.now, self.waiting = 0.0, 0.0, []  # served: to each that has been in it all along

    def rate(self):
        return min(self.most, self.capacity / len(self.waiting))

    def advance(self, now):
        if self.waiting and not math.isinf(self.rate()):
            self.served += (now - self.now) * self.rate()
        self.now = now

    def enter(self, amount, task):
        heapq.heappush(self.waiting, (self.served + amount, task))

    def next_end(self):
        if not self.waiting:
            return math.inf
        return self.now + max(0.0, (self.waiting[0][0] - self.served) / self.rate())


@dataclasses.dataclass(frozen=True)
class Task:
    seconds: float
    bytes_read: float
    bytes_written: float


def makespan(tasks, cluster):
    """Seconds until the last task of a shared stage ends."""
    queue = sorted(tasks, key=lambda task: task.seconds, reverse=True)
    counting = cluster.counter_seconds if cluster.workers > 1 else 0.0
    steps = [(task.bytes_read, task.seconds * cluster.pace(), task.bytes_written) for task in queue]
    wire = _Shared(cluster.storage_bandwidth, cluster.worker_bandwidth / cluster.threads)
    chips = _Shared(cluster.cores, 1.0)
    opening, step, now = [], [0] * len(queue), 0.0
    counter_free, taken = 0.0, min(len(queue), cluster.slots())
    for rank in range(taken):
        counter_free += counting
        heapq.heappush(opening, (counter_free + cluster.task_seconds, rank))
    while opening or wire.waiting or chips.waiting:
        ends = (opening[0][0] if opening else math.inf, wire.next_end(), chips.next_end())
        now = min(ends)
        wire.advance(now)
        chips.advance(now)
        rank = heapq.heappop((opening, wire.waiting, chips.waiting)[ends.index(now)])[1]
        if step[rank] < 3:
            (chips if step[rank] == 1 else wire).enter(steps[rank][step[rank]], rank)
            step[rank] += 1
        elif taken < len(queue):
            counter_free = max(counter_free, now) + counting
            heapq.heappush(opening, (counter_free + cluster.task_seconds, taken))
            taken += 1
    return now


@dataclasses.dataclass(frozen=True)
class Stage:
    name: str
    kind: stage_kinds.Kind
    seconds: float                # of one thread, without those of the chunks
    chunk_seconds: tuple = ()
    bytes_read: float = 0.0
    bytes_written: float = 0.0

    def grown(self, factor):
        """Of a job of so many times the points."""
        if self.kind.grows == "constant":
            return self
        return dataclasses.replace(
            self, seconds=self.seconds * factor, bytes_read=self.bytes_read * factor,
            bytes_written=self.bytes_written * factor, chunk_seconds=_more_of(self.chunk_seconds, factor))


def _more_of(values, factor):
    """So many times as many values with the same spread: quantiles of theirs."""
    wanted = max(1, round(len(values) * factor)) if values else 0
    ordered = sorted(values)
    more = [ordered[int((i + 0.5) / wanted * len(ordered))] for i in range(wanted)]
    scale = sum(values) * factor / sum(more) if sum(more) > 0 else 1.0
    return tuple(value * scale for value in more)


def unhindered(report):
    """The report with CPU seconds for wall seconds, chunks in proportion: of a machine that was busy otherwise.
    Waiting for the disk is lost with it."""
    stages = []
    for facts in report["stages"]:
        scale = facts["cpu_seconds"] / facts["seconds"] if facts["seconds"] > 0.0 else 1.0
        stages.append({**facts, "seconds": facts["cpu_seconds"],
                       "chunk_seconds": [seconds * scale for seconds in facts.get("chunk_seconds") or ()]})
    return {**report, "stages": stages}


def stages_of(report, outside_seconds=0.0, constant_seconds=0.0, overrides=None):
    """The stages of a report that was made with one thread, and the wall time that no stage accounts for: what grows
    with the points, and what any job takes."""
    stages = []
    for facts in report["stages"]:
        kind = stage_kinds.kind_of(facts["name"], facts, overrides)
        chunks = tuple(facts.get("chunk_seconds") or ()) if kind.work == "shared" else ()
        alone = max(0.0, facts["seconds"] - sum(chunks))
        stages.append(Stage(facts["name"], kind, alone, chunks, facts["bytes_read"], facts["bytes_written"]))
    return stages + [Stage(stage_kinds.OUTSIDE, stage_kinds.UNKNOWN, max(0.0, outside_seconds)),
                     Stage(stage_kinds.ANY_JOB, stage_kinds.Kind("leader", grows="constant"), max(0.0, constant_seconds))]


def _alone(stage, cluster, seconds, bytes_moved):
    """What one process does, with its threads as far as they help it."""
    threads = max(1.0, min(cluster.threads, cluster.cores / cluster.workers))
    divided = seconds * (1.0 - stage.kind.threads + stage.kind.threads / threads)
    return divided * cluster.pace() + bytes_moved / min(cluster.worker_bandwidth, cluster.storage_bandwidth)


def _even_share(stage, cluster, bytes_moved):
    """Of a stage that all processes share without chunks, each an equal part; but no sooner than the leader, who does
    its own part first."""
    one = dataclasses.replace(cluster, storage_bandwidth=cluster.storage_bandwidth / cluster.workers)
    even = _alone(stage, one, stage.seconds / min(cluster.workers, cluster.cores), bytes_moved / cluster.workers)
    leader = dataclasses.replace(cluster, workers=1)
    return max(even, _alone(stage, leader, stage.seconds * stage.kind.leader, stage.bytes_read * stage.kind.leader))


def _bytes_moved(stage, cluster):
    moved = stage.bytes_read + stage.bytes_written
    return moved * (1.0 + stage.kind.team_io) if cluster.workers > 1 else moved


def transfer_seconds(stages, cluster):
    """Least that the storage takes for all bytes that a job moves: no number of workers is faster."""
    moved = sum(_bytes_moved(stage, cluster) * (cluster.workers if stage.kind.work == "redundant" else 1)
                for stage in stages)
    return moved / cluster.storage_bandwidth


def stage_seconds(stage, cluster):
    moved = _bytes_moved(stage, cluster)
    once = cluster.stage_seconds + (stage.kind.per_worker * cluster.workers if cluster.workers > 1 else 0.0)
    if stage.kind.work == "redundant":
        one = dataclasses.replace(cluster, storage_bandwidth=cluster.storage_bandwidth / cluster.workers)
        crowd = max(1.0, cluster.workers / cluster.cores)
        return once + _alone(stage, one, stage.seconds * crowd, moved)
    if stage.kind.work == "leader":
        return once + _alone(stage, dataclasses.replace(cluster, workers=1), stage.seconds, moved)
    if not stage.chunk_seconds:
        return once + _even_share(stage, cluster, moved)
    total = sum(stage.chunk_seconds)
    written = stage.bytes_written
    tasks = [Task(s, (moved - written) * s / total, written * s / total) for s in stage.chunk_seconds]
    return once + stage.seconds + makespan(tasks, cluster)


def job_seconds(stages, cluster):
    """{stage: seconds}"""
    return {stage.name: stage_seconds(stage, cluster) for stage in stages}
