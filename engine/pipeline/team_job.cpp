#include "engine/pipeline/team_job.h"

#include <string>
#include <vector>

#include "engine/pipeline/stage/stage_keys.h"
#include "io/error.h"

namespace orbweave {

void require_same_job(const Job& job, Communicator& communicator, const StopToken& stop) {
  if (communicator.size() == 1) return;
  const std::string own = key_line("version of the program", ORBWEAVE_VERSION) + team_key(job);
  const std::vector<std::string> all = communicator.gather(own, stop);
  for (std::size_t rank = 1; rank < all.size(); ++rank)
    if (all[rank] != own)
      throw_usage("the ranks were given different jobs",
                  {.found = "from rank 0 to rank " + std::to_string(rank) + ", " +
                            key_changes(own, all[rank]),
                   .expected = "one job, but for partition.memory and [run]",
                   .advice = "Start all ranks with the same options, the same job file and the "
                             "same build of the program"});
}

}  // namespace orbweave
