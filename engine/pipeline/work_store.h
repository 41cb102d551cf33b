// The work directory of a run: opened by the leader, joined by the other members of its team.
#pragma once

#include <memory>

#include "engine/pipeline/stage/resolved_job.h"
#include "io/report/progress.h"
#include "io/stop_token.h"
#include "io/store/chunk_store.h"
#include "partition/communicator.h"

namespace orbweave {

/// Opens the job's work directory; run.fresh drops what an earlier run left. Throws Error
/// (resource) where a member sees another directory than the leader.
std::unique_ptr<ChunkStore> open_work_store(const RunOptions& run, Communicator& communicator,
                                            const StopToken& stop);

/// Everything that `progress` is told also goes to this member's log in the work directory, and the
/// leader's steps to a document for `orbweave status`. A file that the program did not write is not
/// written to.
std::unique_ptr<Progress> open_log(Progress& progress, ChunkStore& store,
                                   const Communicator& communicator);

}  // namespace orbweave
