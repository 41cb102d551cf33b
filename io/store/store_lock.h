// Who works in a job's work directory: its owner, which is one process, and the members of the
// owner's team. Each holds a lock (flock) that ends with the process, however that ends.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "io/store/chunk_store_file.h"
#include "io/system/file_descriptor.h"

namespace orbweave {

/// The owner's file, and what marks the directory as that of one run for the owner's team.
inline constexpr const char* kOwnerLock = "lock";
inline constexpr const char* kTeamMark = "team";

/// mpirun kills what has not ended a second after it was told to.
inline constexpr std::chrono::milliseconds kDyingTime{5000};

/// Whether a file is the program's by the record of the work directory.
using IsOnRecord = std::function<bool(const std::filesystem::path&)>;

/// Takes the directory of the store `store` for this process. An earlier owner that leads a team
/// may be ending, and members may outlive it: waits `patience` for it and again for them, and as
/// the mark of their run goes none can join any more. Throws Error (resource) that names who works
/// there. `is_ours` tells what is the program's of files that do not look like it (they may be
/// damaged). Throws Error (usage) where a lock's place holds something else.
FileDescriptor lock_as_owner(const std::filesystem::path& directory, const std::string& store,
                             std::chrono::milliseconds patience = kDyingTime,
                             const IsOnRecord& is_ours = {});

std::filesystem::path member_lock(const std::filesystem::path& directory, int rank);
/// For a member, beside the owner's lock; `rank` tells it from others of its team. Waits `patience`
/// for a late member of an earlier run, which leaves when it finds that the mark is not its own.
FileDescriptor lock_as_member(const std::filesystem::path& directory, int rank,
                              const std::string& store,
                              std::chrono::milliseconds patience = kDyingTime,
                              const IsOnRecord& is_ours = {});

/// What such a file holds: a line, and whose it is.
std::string lock_text(const std::string& line, const std::string& store);
/// The line that lock_text() was given; empty: the file is no lock.
std::string line_of_lock(const std::filesystem::path& path);
/// Whether a file is the lock of an owner or a member, or a team's mark, by name and content. An
/// empty `store` stands for any.
bool is_lock_file(const std::filesystem::path& path, const std::string& store);

/// Whether a process has the directory, as its owner, at this moment. Changes nothing.
bool is_owned(const std::filesystem::path& directory);
/// Members that work in the directory at this moment: "rank 2 (process 4711 on node17)".
std::vector<std::string> members_at_work(const std::filesystem::path& directory);

}  // namespace orbweave
