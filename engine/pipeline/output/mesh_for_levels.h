// What is made of a job's finished mesh file by levels of detail: whether that can be done.
#pragma once

#include <cstdint>
#include <functional>
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

/// What the mesh file is known by while levels of detail are made of it. Not its time, which
/// processes on other machines may see change.
struct MeshFileState {
  std::uint64_t inode = 0;
  std::string content;  ///< size and sample; empty: there is no file
};
MeshFileState state_of_mesh_file(const std::string& mesh);

/// Calls `make`, which reads the mesh file again. Throws Error (resource) where the file that is
/// read is not the one that the job wrote, or there is none: the job, run again, writes it again.
void make_of_mesh_file(const std::string& mesh, const MeshFileState& written,
                       const std::function<void()>& make);

}  // namespace orbweave
