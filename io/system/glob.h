// Files from patterns.
#pragma once

#include <string>
#include <vector>

namespace orbweave {

/// True when the shell would take the text for a pattern: it has *, ? or [.
bool is_glob(const std::string& text);

/// The same text with every character that a pattern gives a meaning escaped.
std::string escape_glob(const std::string& path);

/// Each pattern's files (no directories, and nothing that tells of the scans beside it: .prj,
/// .shift.txt, .conf, .aln), sorted by bytes, in the patterns' order; a file that several
/// patterns match comes once. A text without *, ? and [ passes through, there or not, and so does
/// one that is itself the name of a file. Throws Error (usage) for a pattern that matches no file,
/// and for one with ** for folders at any depth.
std::vector<std::string> expand_globs(const std::vector<std::string>& patterns);

/// Files that match none of the patterns, but would if capital and small letters of ASCII were
/// alike, sorted by bytes: B.LAZ beside a.laz of "*.laz".
std::vector<std::string> files_in_other_case(const std::vector<std::string>& patterns);

}  // namespace orbweave
