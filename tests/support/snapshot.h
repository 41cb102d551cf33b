// Everything that can be seen of a directory from outside, to tell whether anything changed.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace orbweave::test {

/// Of every entry below `directory`, by name: kind, inode, permissions, size, time of the last
/// change, and content or where a link leads. Links are not followed.
std::map<std::string, std::string> snapshot(const std::filesystem::path& directory);

}  // namespace orbweave::test
