// What is made of a job's finished mesh file by levels of detail: whether that can be done.
#pragma once

#include <string>

#include "io/job/job.h"

namespace orbweave {

/// What a job asks for, in the words of messages.
struct MadeOfMesh {
  std::string what;     ///< "a tileset"
  std::string key;      ///< of the job file
  std::string place;    ///< the path of it
  std::string command;  ///< that makes it of a mesh later
};

/// Throws Error (usage) where the job's mesh file cannot be read again from front to back, because
/// it is no uncompressed PLY file, and where the memory budget has no room for a node.
void check_mesh_for_levels(const Job& job, const MadeOfMesh& made);

}  // namespace orbweave
