// The making and the removal of a work directory. Each is one renaming: a directory that the
// program makes has its identity from its first moment under its name, and one that goes has it to
// the last. So an empty directory of that name is always the user's.
#pragma once

#include <filesystem>
#include <vector>

#include "io/store/store_identity.h"

namespace orbweave {

/// Makes the work directory where it is not there, with a new identity in it, and the folders above
/// it; returns what was made. A link is followed. Throws Error (resource).
std::vector<MadeDirectory> make_work_directory(const std::filesystem::path& directory);

/// Whether the directory was made for the job. A copy in its place counts as that.
bool is_made(const std::filesystem::path& directory, const std::vector<MadeDirectory>& made);

/// Gives the directory a name beside its place, which tells the next run that makes a directory
/// there what it is. Empty: that is impossible.
std::filesystem::path put_aside(const std::filesystem::path& directory);

/// Removes a directory that was put aside, with the files that mark a work directory. A directory
/// that holds anything else stays.
void remove_aside(const std::filesystem::path& aside);

/// Gives a directory that remove_aside has left, because it holds something else, its name back;
/// false where it is gone, or where its name is taken by now.
bool take_back(const std::filesystem::path& aside, const std::filesystem::path& directory);

/// Removes directories that were made for the job, the innermost first, where they are empty. By
/// now another job may have begun there.
void remove_made(const std::filesystem::path& directory, const std::vector<MadeDirectory>& made);

}  // namespace orbweave
