// Who works in a job's work directory: its owner, which is one process, and the members of the
// owner's team. Each holds a lock (flock) that ends with the process, however that ends.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "io/chunk_store_file.h"

namespace orbweave {

/// The owner's file, and what marks the directory as that of one run for the owner's team.
inline constexpr const char* kOwnerLock = "lock";
inline constexpr const char* kTeamMark = "team";

/// mpirun kills what has not ended a second after it was told to.
inline constexpr std::chrono::milliseconds kDyingTime{5000};

/// Takes the directory for this process. An earlier owner that leads a team may be ending, and
/// members may outlive it: waits `patience` for it and again for them, and as the mark of their run
/// goes none can join any more.
/// Throws Error (resource) that names who works there.
FileDescriptor lock_as_owner(const std::filesystem::path& directory,
                             std::chrono::milliseconds patience = kDyingTime);

/// For a member, beside the owner's lock; `rank` tells it from others of its team. Waits `patience`
/// for a late member of an earlier run, which leaves when it finds that the mark is not its own.
FileDescriptor lock_as_member(const std::filesystem::path& directory, int rank,
                              std::chrono::milliseconds patience = kDyingTime);

/// Whether a file in a work directory is the lock of an owner or a member.
bool is_lock_file(const std::filesystem::path& name);

/// Members that work in the directory at this moment: "rank 2 (process 4711 on node17)".
std::vector<std::string> members_at_work(const std::filesystem::path& directory);

}  // namespace orbweave
