"""How long a job takes on a cluster, from the chunk times of one measured job: event-driven list scheduling.

Every worker has its share of half of the work by its number, then takes blocks of the longest tasks that are left from the
common counter (partition/task_shares.h); each of its threads takes the next task of the block, reads its bytes, computes,
writes its bytes, and takes another; a stage ends with its last task, when all know that none is left, and the next begins
when all have met. Transfers under way share the bandwidth of the storage evenly, each limited to its thread's share of its worker's. What the
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
    "bins of a team pass through the storage, though those of one process may stay in memory; how many bytes that is was "
    "counted where there is a report of a team (--team-report, --check), and follows from bench/models/stage_kinds.py otherwise",
    "longest first is exact; lengths by which blocks are cut are known to within a factor of two, and workers know how long "
    "a call of the counter takes",
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
    slowdown: float = 0.0             # of every thread of a machine, per further thread beside it
    cores: float = math.inf           # that all workers have together, where they share a machine
    by_blocks: bool = True            # False: the counter gives out task by task, as it did once
    by_tree: bool = True              # False: the leader alone merges what the workers have, as it did once

    def slots(self):
        return self.workers * self.threads

    def pace(self):
        """How much longer a task takes than with the machine to itself."""
        beside = self.threads if math.isinf(self.cores) else min(self.slots(), self.cores)
        return 1.0 + self.slowdown * (beside - 1)

    def merges(self):
        """How many follow each other until one worker has what all have."""
        return math.ceil(math.log2(self.workers)) if self.by_tree else self.workers if self.workers > 1 else 0


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


SHARES = 2     # of a worker in what is left, each a block: partition/task_shares.cpp
ROUNDS = 2.0  # of the counter serving all workers, that a block lasts at least


class TaskShares:
    """Which tasks a worker has by its number, and how many it takes by a call of the counter: partition/task_shares.h."""

    def __init__(self, lengths, workers, threads):
        self.workers = workers
        self.ends = [0]  # length of the tasks before each
        for length in lengths:
            self.ends.append(self.ends[-1] + max(length, 1))
        tasks, all_of_them = len(lengths), self.ends[-1]
        least = min(threads, -(-tasks // workers))
        self.begins = [0]  # of the tasks that a worker has by its number; behind them those of the counter
        for worker in range(workers):
            end = self.begins[-1]
            while end < tasks and self.ends[end + 1] * SHARES * workers <= (worker + 1) * all_of_them:
                end += 1
            self.begins.append(min(max(end, self.begins[-1] + least), tasks))

    def of_call(self, first, wanted, latest):
        """How many tasks a worker takes by a call, at least one: those of the wanted length, if that is between a worker's
        share and a block's of what is left. first: the first task that may be left, as far as the worker knows; latest:
        length of its latest block from the counter, as which the others have taken theirs since."""
        left = self.ends[-1] - self.ends[first]
        share = max(0.0, left - (self.workers - 1.0) * latest) / (SHARES * self.workers)
        target = max(share, min(wanted, left / self.workers))
        task = first + 1
        while task + 1 < len(self.ends) and self.ends[task + 1] - self.ends[first] <= target:
            task += 1
        return max(task - first, 1)


def known_lengths(tasks):
    """Powers of two."""
    most = max((task.seconds for task in tasks), default=0.0)
    return [1 << 30 >> min(30, int(-math.log2(task.seconds / most))) if task.seconds > 0.0 else 1 for task in tasks]


class _Counter:
    """Gives out tasks to workers, block by block."""

    def __init__(self, queue, cluster):
        self.tasks, self.workers = len(queue), cluster.workers
        self.counting = cluster.counter_seconds if cluster.workers > 1 else 0.0
        self.by_blocks = cluster.by_blocks and cluster.workers > 1
        self.free, self.calls = 0.0, 0
        self.given = 0                             # tasks that have been given out
        self.own = [(0, 0, 0.0)] * cluster.workers  # next task, end of the block, when the worker has the block
        self.seen = [(0, 0, 0)] * cluster.workers   # first task that may be left; length of all its blocks and the latest
        if not self.by_blocks:
            return
        self.shares = TaskShares(known_lengths(queue), cluster.workers, cluster.threads)
        begins, ends = self.shares.begins, self.shares.ends
        self.given = begins[-1]
        self.own = [(begins[worker], begins[worker + 1], 0.0) for worker in range(cluster.workers)]
        self.seen = [(self.given, ends[begins[worker + 1]] - ends[begins[worker]], 0) for worker in range(cluster.workers)]

    def take(self, worker, now):
        """The next task of a worker and when it begins; None where none is left."""
        task, end, since = self.own[worker]
        if task == end:
            if self.seen[worker][0] >= self.tasks:
                return None
            wanted = self._tasks_of_call(worker, now)
            self.calls += 1
            self.free = since = max(self.free, now) + self.counting
            task = self.given
            self.given = end = min(self.tasks, self.given + wanted)
            more = self.shares.ends[end] - self.shares.ends[task] if self.by_blocks else 0
            self.seen[worker] = (end, self.seen[worker][1] + more, more)
            if task == end:
                return None
        self.own[worker] = (task + 1, end, since)
        return task, max(now, since)

    def _tasks_of_call(self, worker, now):
        if not self.by_blocks:
            return 1
        seen, length, latest = self.seen[worker]
        # What the worker does, at its pace so far, while the counter serves all workers some times.
        wanted = length * ROUNDS * self.workers * self.counting / now if now > 0.0 else 0.0
        return self.shares.of_call(seen, wanted, latest)


def counter_calls(tasks, cluster):
    """Of all workers, with the one call by which a worker learns that no task is left."""
    if cluster.workers == 1:
        return 0
    return _schedule(tasks, cluster)[1]


def makespan(tasks, cluster):
    """Seconds until the last task of a shared stage ends, and all workers know."""
    return _schedule(tasks, cluster)[0]


def _schedule(tasks, cluster):
    """Seconds and calls of the counter."""
    queue = sorted(tasks, key=lambda task: task.seconds, reverse=True)
    counter = _Counter(queue, cluster)
    steps = [(task.bytes_read, task.seconds * cluster.pace(), task.bytes_written) for task in queue]
    wire = _Shared(cluster.storage_bandwidth, cluster.worker_bandwidth / cluster.threads)
    chips = _Shared(cluster.cores, 1.0)
    opening, step, now, worker_of = [], [0] * len(queue), 0.0, {}

    def begin(worker, now):
        taken = counter.take(worker, now)
        if taken:
            task, start = taken
            worker_of[task] = worker
            heapq.heappush(opening, (start + cluster.task_seconds, task))

    for _ in range(cluster.threads):
        for worker in range(cluster.workers):
            begin(worker, 0.0)
    while opening or wire.waiting or chips.waiting:
        ends = (opening[0][0] if opening else math.inf, wire.next_end(), chips.next_end())
        now = min(ends)
        wire.advance(now)
        chips.advance(now)
        rank = heapq.heappop((opening, wire.waiting, chips.waiting)[ends.index(now)])[1]
        if step[rank] < 3:
            (chips if step[rank] == 1 else wire).enter(steps[rank][step[rank]], rank)
            step[rank] += 1
        else:
            begin(worker_of[rank], now)
    return max(now, counter.free), counter.calls


@dataclasses.dataclass(frozen=True)
class Stage:
    name: str
    kind: stage_kinds.Kind
    seconds: float                # of one thread, without those of the chunks
    chunk_seconds: tuple = ()
    bytes_read: float = 0.0
    bytes_written: float = 0.0
    team_bytes: tuple = ()        # read and written by all workers of a team together, as counted; empty: not known
    worker_bytes: tuple = (0, 0)  # and by each of them besides, however many points there are

    def grown(self, factor):
        """Of a job of so many times the points."""
        if self.kind.grows == "constant":
            return self
        fixed = min(self.kind.fixed, self.seconds)
        return dataclasses.replace(
            self, seconds=fixed + (self.seconds - fixed) * factor, bytes_read=self.bytes_read * factor,
            bytes_written=self.bytes_written * factor, chunk_seconds=_more_of(self.chunk_seconds, factor),
            team_bytes=tuple(amount * factor for amount in self.team_bytes))


def _more_of(values, factor):
    """So many times as many values with the same spread: quantiles of theirs."""
    wanted = max(1, round(len(values) * factor)) if values else 0
    ordered = sorted(values)
    more = [ordered[int((i + 0.5) / wanted * len(ordered))] for i in range(wanted)]
    scale = sum(values) * factor / sum(more) if sum(more) > 0 else 1.0
    return tuple(value * scale for value in more)


def unhindered(report):
    """The report with CPU seconds for wall seconds: of a machine that was busy otherwise. Waiting for the disk is lost
    with it, and what threads of the background did beside the work."""
    stages = []
    for facts in report["stages"]:
        chunks = facts.get("chunk_cpu_seconds") or ()
        outside = (facts[name] - sum(facts.get(of_chunks) or ()) for name, of_chunks in
                   (("seconds", "chunk_seconds"), ("cpu_seconds", "chunk_cpu_seconds")))
        stages.append({**facts, "seconds": sum(chunks) + max(0.0, min(outside)), "chunk_seconds": chunks})
    return {**report, "stages": stages}


def with_team(stages, team):
    """The stages with the bytes that the report of a team of the same job counted, of all ranks. What every process
    does for itself is one process's. Where workers merge what they have, what a team moves beyond one process is a
    grid of limited memory for every worker."""
    counted = {facts["name"]: facts for facts in team["stages"]}
    together = []
    for stage in stages:
        facts = counted.get(stage.name)
        if facts:
            each = team["ranks"] if stage.kind.work == "redundant" else 1
            moved = (facts["bytes_read"] / each, facts["bytes_written"] / each)
            alone = (stage.bytes_read, stage.bytes_written)
            if stage.kind.merge > 0.0:
                grids = tuple((all_of_them - own) / team["ranks"] for all_of_them, own in zip(moved, alone))
                stage = dataclasses.replace(stage, team_bytes=alone, worker_bytes=grids)
            else:
                stage = dataclasses.replace(stage, team_bytes=moved)
        together.append(stage)
    return together


def stages_of(report, outside_seconds=0.0, constant_seconds=0.0, overrides=None, team=None):
    """The stages of a report that was made with one thread, and the wall time that no stage accounts for: what grows
    with the points, and what any job takes. team: the report of the same job by several ranks."""
    stages = []
    for facts in report["stages"]:
        of_tiles = facts["name"] == "export" and report["options"]["output"]["tiles"]
        kind = stage_kinds.kind_of("tiles" if of_tiles else facts["name"], facts, overrides)
        chunks = tuple(facts.get("chunk_seconds") or ()) if kind.work == "shared" else ()
        alone = max(0.0, facts["seconds"] - sum(chunks))
        stages.append(Stage(facts["name"], kind, alone, chunks, facts["bytes_read"], facts["bytes_written"]))
    stages = with_team(stages, team) if team else stages
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
    """Read and written."""
    if cluster.workers == 1:
        return stage.bytes_read, stage.bytes_written
    if stage.team_bytes:
        return tuple(all_of_them + each * cluster.workers
                     for all_of_them, each in zip(stage.team_bytes, stage.worker_bytes))
    return stage.bytes_read + (stage.bytes_read + stage.bytes_written) * stage.kind.team_io, stage.bytes_written


def bytes_moved(stages, cluster):
    """By all workers together."""
    return sum(sum(_bytes_moved(stage, cluster)) * (cluster.workers if stage.kind.work == "redundant" else 1)
               for stage in stages)


def transfer_seconds(stages, cluster):
    """Least that the storage takes for all bytes that a job moves: no number of workers is faster."""
    return bytes_moved(stages, cluster) / cluster.storage_bandwidth


def stage_seconds(stage, cluster):
    read, written = _bytes_moved(stage, cluster)
    moved = read + written
    once = cluster.stage_seconds + stage.kind.merge * cluster.merges()
    if stage.kind.work == "redundant":
        one = dataclasses.replace(cluster, storage_bandwidth=cluster.storage_bandwidth / cluster.workers)
        crowd = max(1.0, cluster.workers / cluster.cores)
        return once + _alone(stage, one, stage.seconds * crowd, moved)
    if stage.kind.work == "leader":
        return once + _alone(stage, dataclasses.replace(cluster, workers=1), stage.seconds, moved)
    if not stage.chunk_seconds:
        return once + _even_share(stage, cluster, moved)
    # What no chunk accounts for: every process does it, its threads as far as they help the stage.
    every = _alone(stage, dataclasses.replace(cluster, workers=1), stage.seconds, 0.0)
    return once + every + makespan(tasks_of(stage, cluster), cluster)


def tasks_of(stage, cluster):
    """The chunks of a stage."""
    read, written = _bytes_moved(stage, cluster)
    total = sum(stage.chunk_seconds)
    return [Task(s, read * s / total, written * s / total) for s in stage.chunk_seconds]


def calls_of(stages, cluster):
    """Of the counter, by all stages."""
    return sum(counter_calls(tasks_of(stage, cluster), cluster) for stage in stages
               if stage.kind.work == "shared" and stage.chunk_seconds)


def job_seconds(stages, cluster):
    """{stage: seconds}"""
    return {stage.name: stage_seconds(stage, cluster) for stage in stages}
