// The job file (TOML): from text to a Job and back.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "io/job/job.h"
#include "io/job/job_keys.h"

namespace orbweave {

/// Reads a job file. Relative paths in it are relative to its own folder. Keys that it leaves
/// out keep their defaults; whether the job is complete is for the caller to say. Throws Error
/// (usage): where the file cannot be read; with file and line, for what is no TOML, for an unknown
/// section or key (with the nearest known one) and for an unsuitable value (with the range).
Job read_job_file(const std::filesystem::path& path);

/// The same from text; `name` is what messages call it, `base_directory` is what relative paths
/// are relative to (empty: they stay as they are).
Job parse_job(std::string_view text, const std::string& name,
              const std::filesystem::path& base_directory = {});

/// Sets one key, "section.key", from text: a TOML value, or a bare word where that is no TOML.
/// Lists need no brackets ("0.1,0.2"), texts no quotes. Relative paths stay as they are. Throws
/// Error (usage) as above; messages name the key instead of file and line.
void set_job_key(Job& job, std::string_view name, std::string_view text);

/// Likewise from the value of the key's option; messages name the option.
void set_job_option(Job& job, std::string_view name, std::string_view text);

/// Splits "section.key=value" at the first '=' and sets it; blanks on both sides of it, as lines of
/// job files have them, are none of the value's. Throws Error (usage).
void set_job_key(Job& job, std::string_view assignment);

/// Holds the numbers of a job that a program filled in to what job files accept. A crop is no such
/// number: its limits may be infinite. Throws Error (usage) with the key, what was found and the
/// range.
void check_job_numbers(const Job& job);

/// A job file with every key, which parse_job reads back as the same job where its texts are
/// UTF-8 (TOML knows no other).
std::string job_toml(const Job& job);

}  // namespace orbweave
