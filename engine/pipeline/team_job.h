// The processes of a team are started with a job each. Here they see that it is the same one.
#pragma once

#include "io/job/job.h"
#include "partition/communicator.h"

namespace orbweave {

/// Throws where the processes were given different jobs, at the root alone, which ends the others;
/// budget and threads are every process's own. Every process calls it, before the work directory
/// is made. O(processes) texts of some kilobytes.
void require_same_job(const Job& job, Communicator& communicator, const StopToken& stop);

}  // namespace orbweave
