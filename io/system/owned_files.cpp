#include "io/system/owned_files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <optional>
#include <system_error>

#include "io/error.h"
#include "io/system/file_calls.h"
#include "io/system/file_descriptor.h"
#include "io/system/random_word.h"
#include "io/system/work_directory_errors.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kHeader = "orbweave record ";
constexpr std::string_view kRun = "run ";
constexpr std::string_view kCopied = "copied";
constexpr std::string_view kPart = ".part";
constexpr std::uint64_t kAnyInode = ~std::uint64_t{0};
constexpr mode_t kDirectoryMode = 0777;  // the process's umask applies
constexpr mode_t kFileMode = 0666;

std::uint64_t hash_of(std::uint64_t inode, const std::string& name) {
  return XXH3_64bits_withSeed(name.data(), name.size(), inode);
}

/// Names are one line each.
std::string escaped(const std::string& name) {
  std::string text;
  for (const char c : name) text += c == '\n' ? "%0A" : c == '%' ? "%25" : std::string(1, c);
  return text;
}

std::string unescaped(std::string_view text) {
  std::string name;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view code = text.substr(i, 3);
    const bool is_code = code == "%0A" || code == "%25";
    name += code == "%0A" ? '\n' : text[i];
    if (is_code) i += 2;
  }
  return name;
}

/// A result has its line from its beginning under the name that it gets in the end.
std::string without_part(const std::string& name) {
  const std::size_t begin = name.rfind('/') == std::string::npos ? 0 : name.rfind('/') + 1;
  if (!name.ends_with(".h5.part") || name[begin] != '.') return name;
  return name.substr(0, begin) + name.substr(begin + 1, name.size() - begin - 1 - kPart.size());
}

std::optional<struct stat> facts_of(const fs::path& path) {
  struct stat facts {};
  return ::lstat(path.c_str(), &facts) == 0 ? std::optional(facts) : std::nullopt;
}

struct RecordLine {
  std::string_view word;
  std::string_view rest;
};
RecordLine split(std::string_view line) {
  const std::size_t space = std::min(line.find(' '), line.size());
  return {line.substr(0, space), line.substr(std::min(space + 1, line.size()))};
}

std::optional<std::uint64_t> number(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string header_of(const std::string& store) {
  return std::string(kHeader) + std::to_string(kWorkLayoutVersion) + " " + store;
}

bool is_header(std::string_view line) {
  if (!line.starts_with(kHeader)) return false;
  const RecordLine parts = split(line.substr(kHeader.size()));
  return number(parts.word) && !parts.rest.empty();
}

/// Of a line that a run begins with; empty: it is none.
std::optional<std::uint64_t> inode_of_run(std::string_view line) {
  if (!line.starts_with(kRun)) return std::nullopt;
  const RecordLine parts = split(line.substr(kRun.size()));
  const bool is_word = parts.word.find_first_not_of("0123456789abcdef") == std::string_view::npos;
  return is_word && !parts.word.empty() ? number(parts.rest) : std::nullopt;
}

bool has_name_of_record(const fs::path& file) {
  const std::string name = file.filename().string();
  return name.starts_with(kRecordName) && number(std::string_view(name).substr(kRecordName.size()));
}

/// Whether the run that wrote last into a record did so in this very file.
bool was_copied(const fs::path& file) {
  std::ifstream stream(file);
  std::optional<std::uint64_t> written;
  for (std::string line; std::getline(stream, line);) {
    const std::optional<std::uint64_t> inode = inode_of_run(line);
    if (inode) written = inode;
  }
  const std::optional<struct stat> facts = facts_of(file);
  return written && facts && facts->st_ino != *written;
}

fs::path record_of(const fs::path& directory, int rank) {
  return directory / (std::string(kRecordName) + std::to_string(rank));
}

std::vector<fs::path> record_files(const fs::path& directory) {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, ignored))
    if (is_record(entry.path())) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

void throw_stranger(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::symlink_status(path, ignored);
  throw_usage("this program did not write what is there",
              {.file = path.string(),
               .found = fs::is_directory(status) ? "a directory that is not on its record"
                        : fs::is_symlink(status) ? "a link that is not on its record"
                                                 : "a file that is not on its record",
               .expected = "a file of the job's work, or nothing",
               .advice = "Move it away and repeat the command, which resumes; or name another "
                         "directory with run.work_dir or --work-dir"});
}

void check_record_place(const fs::path& directory, int rank) {
  const fs::path file = record_of(directory, rank);
  if (facts_of(file) && !is_record(file)) throw_stranger(file);
}

bool is_record(const fs::path& file) {
  if (!has_name_of_record(file)) return false;
  const std::optional<struct stat> facts = facts_of(file);
  if (!facts || !S_ISREG(facts->st_mode)) return false;
  std::ifstream stream(file);
  std::string line;
  // One damaged line does not make it another's.
  for (int lines = 0; lines < 4 && std::getline(stream, line); ++lines)
    if (is_header(line) || inode_of_run(line)) return true;
  return facts->st_size == 0;
}

bool is_record_of(const fs::path& file, const std::string& store) {
  if (!is_record(file)) return false;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);)
    if (line == header_of(store)) return true;
  return false;
}

std::pair<std::string, int> store_of_record(const fs::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::pair<std::string, int> found;
  while (std::getline(stream, line)) {
    if (!line.starts_with(kHeader)) continue;
    const RecordLine parts = split(std::string_view(line).substr(kHeader.size()));
    if (const auto version = number(parts.word))
      found = {std::string(parts.rest), static_cast<int>(*version)};
  }
  return found;
}

void HashSet::insert(std::uint64_t hash) {
  recent_.insert(hash);
  if (recent_.size() < kMostRecent) return;
  const auto middle = static_cast<std::ptrdiff_t>(sorted_.size());
  sorted_.insert(sorted_.end(), recent_.begin(), recent_.end());
  std::sort(sorted_.begin() + middle, sorted_.end());
  std::inplace_merge(sorted_.begin(), sorted_.begin() + middle, sorted_.end());
  sorted_.erase(std::unique(sorted_.begin(), sorted_.end()), sorted_.end());
  recent_.clear();
}

bool HashSet::contains(std::uint64_t hash) const {
  return recent_.contains(hash) || std::binary_search(sorted_.begin(), sorted_.end(), hash);
}

OwnedFiles::OwnedFiles(fs::path directory, std::string store, int rank)
    : directory_(std::move(directory)),
      store_(std::move(store)),
      file_(record_of(directory_, rank)) {
  check_record_place(directory_, rank);
  const bool copied = was_copied(file_);
  output_ = FileDescriptor(
      ::open(file_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, kFileMode));
  struct stat facts {};
  if (!output_.valid() || ::fstat(output_.get(), &facts) != 0) throw_write_error(file_, errno);
  char last = '\n';
  if (facts.st_size > 0 && ::pread(output_.get(), &last, 1, facts.st_size - 1) != 1) last = 0;
  torn_ = last != '\n';
  if (copied) append(std::string(kCopied));
  append(header_of(store_));
  append(std::string(kRun) + random_word() + " " + std::to_string(facts.st_ino));
  const std::scoped_lock lock(mutex_);
  for (const fs::path& file : record_files(directory_)) read(file);
}

OwnedFiles::OwnedFiles(fs::path directory, std::string store)
    : directory_(std::move(directory)), store_(std::move(store)) {
  for (const fs::path& file : record_files(directory_)) read(file);
}

/// From where it was read to before; other members go on writing theirs.
void OwnedFiles::read(const fs::path& file) const {
  Reading& reading = readings_[file];
  const bool copied = reading.offset == 0 && was_copied(file);
  std::vector<Line> lines;
  const auto settle = [&](bool by_name) {
    for (const Line& line : lines) take(line.first, line.second, by_name);
    lines.clear();
  };
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(reading.offset));
  for (std::string line; std::getline(stream, line) && !stream.eof();) {
    reading.offset += line.size() + 1;
    const RecordLine parts = split(line);
    if (line.starts_with(kHeader)) reading.is_this_store = line == header_of(store_);
    if (line == kCopied) settle(true);
    const std::optional<std::uint64_t> inode = number(parts.word);
    if (reading.is_this_store && inode && !parts.rest.empty())
      lines.emplace_back(*inode, unescaped(parts.rest));
  }
  settle(copied);
}

void OwnedFiles::refresh() const {
  const std::scoped_lock lock(mutex_);
  for (const fs::path& file : record_files(directory_))
    if (file != file_) read(file);
}

void OwnedFiles::take(std::uint64_t inode, const std::string& name, bool by_name) const {
  const bool outside = name.starts_with('/');
  // What lies outside of a copy is the original's, whose run may be at work.
  if (by_name && outside) return;
  known_.insert(hash_of(by_name ? kAnyInode : inode, name));
  if (outside && facts_of(name)) outside_.emplace_back(inode, name);
}

std::string OwnedFiles::name_of(const fs::path& path) const {
  const std::string& all = path.native();
  const std::string& front = directory_.native();
  if (all.starts_with(front) && all.size() > front.size()) {
    std::string_view rest = std::string_view(all).substr(front.size());
    if (front.ends_with('/') || rest.starts_with('/')) {
      rest.remove_prefix(std::min(rest.find_first_not_of('/'), rest.size()));
      return without_part(std::string(rest));
    }
  }
  std::error_code ignored;
  const fs::path whole = fs::absolute(path, ignored);
  return fs::weakly_canonical(whole.parent_path(), ignored) / whole.filename();
}

void OwnedFiles::close() {
  const std::scoped_lock lock(mutex_);
  output_ = FileDescriptor();
}

void OwnedFiles::append(const std::string& text) {
  if (!output_.valid()) return;
  const std::string line = (torn_ ? "\n" : "") + text + "\n";
  const ssize_t wrote = file_calls.write(output_.get(), line.data(), line.size());
  torn_ = wrote != static_cast<ssize_t>(line.size()) && (torn_ || wrote > 0);
  if (wrote != static_cast<ssize_t>(line.size()))
    throw_write_error(file_, wrote < 0 ? errno : ENOSPC);
}

void OwnedFiles::record(ino_t inode, const std::string& name) {
  const std::scoped_lock lock(mutex_);
  append(std::to_string(inode) + " " + escaped(name));
  known_.insert(hash_of(inode, name));
}

bool OwnedFiles::on_record(std::uint64_t inode, const std::string& name) const {
  const std::scoped_lock lock(mutex_);
  return known_.contains(hash_of(inode, name));
}

FileDescriptor OwnedFiles::try_create(const fs::path& path) {
  const std::string name = name_of(path);
  if (facts_of(path)) {
    errno = EEXIST;
    return FileDescriptor();
  }
  record(0, name);
  FileDescriptor file(
      ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, kFileMode));
  struct stat facts {};
  if (!file.valid() || ::fstat(file.get(), &facts) != 0) return FileDescriptor();
  try {
    record(facts.st_ino, name);
  } catch (...) {
    ::unlink(path.c_str());  // nothing was written to it
    throw;
  }
  return file;
}

FileDescriptor OwnedFiles::create(const fs::path& path) {
  constexpr int kTries = 3;
  for (int i = 0; i < kTries; ++i) {
    FileDescriptor file = try_create(path);
    if (file.valid()) return file;
    if (errno != EEXIST) throw_write_error(path, errno);
    remove_or_refuse(path);
  }
  throw_stranger(path);
}

bool OwnedFiles::make_directory(const fs::path& path) {
  const std::string name = name_of(path) + "/";
  if (facts_of(path)) {
    errno = EEXIST;
    return false;
  }
  record(0, name);
  if (::mkdir(path.c_str(), kDirectoryMode) != 0) return false;
  if (const auto facts = facts_of(path)) record(facts->st_ino, name);
  return true;
}

bool OwnedFiles::rename(const fs::path& from, const fs::path& to, bool replaces_any) {
  const std::optional<struct stat> facts = facts_of(from);
  if (!facts) return false;
  const bool taken = !replaces_any && facts_of(to).has_value();
  if (taken && !owns(to)) throw_stranger(to);
  const std::string name = name_of(to);
  if (name != name_of(from)) record(facts->st_ino, name);
  return file_calls.rename(from.c_str(), to.c_str()) == 0;
}

void OwnedFiles::remove_record(const fs::path& file) {
  if (is_record_of(file, store_)) ::unlink(file.c_str());
}

void remove_if_empty(const fs::path& directory) {
  if (::rmdir(directory.c_str()) == 0 || errno == ENOENT || errno == ENOTEMPTY || errno == EEXIST)
    return;
  if (errno == EBUSY) return;  // something is mounted there
  throw_resource("cannot remove the directory",
                 {.file = directory.string(), .found = std::strerror(errno), .advice = {}});
}

void OwnedFiles::announce(const fs::path& path) {
  if (!facts_of(path)) record(0, name_of(path));
}

void OwnedFiles::expect(const fs::path& to, const fs::path& from) {
  const std::optional<struct stat> facts = facts_of(from);
  if (facts) record(facts->st_ino, name_of(to) + (S_ISDIR(facts->st_mode) ? "/" : ""));
}

/// By the lines alone.
bool OwnedFiles::recorded(const fs::path& path) const {
  const std::optional<struct stat> facts = facts_of(path);
  if (!facts) return false;
  const std::string name = name_of(path) + (S_ISDIR(facts->st_mode) ? "/" : "");
  const bool is_plain = S_ISDIR(facts->st_mode) || S_ISREG(facts->st_mode);
  const bool is_empty = S_ISDIR(facts->st_mode) || facts->st_size == 0;
  return is_plain && (on_record(facts->st_ino, name) || on_record(kAnyInode, name) ||
                      (is_empty && on_record(0, name)));
}

bool OwnedFiles::owns(const fs::path& path) const {
  if (recorded(path)) return true;
  refresh();
  if (recorded(path)) return true;
  const std::optional<struct stat> facts = facts_of(path);
  return facts && S_ISREG(facts->st_mode) && proof_ && proof_(path, name_of(path));
}

OwnedFiles::Removal OwnedFiles::remove(const fs::path& path) {
  const std::optional<struct stat> facts = facts_of(path);
  if (!facts) return Removal::kAbsent;
  if (!owns(path)) return Removal::kStranger;
  const bool is_directory = S_ISDIR(facts->st_mode);
  if ((is_directory ? ::rmdir(path.c_str()) : ::unlink(path.c_str())) == 0)
    return Removal::kRemoved;
  if (errno == ENOENT) return Removal::kAbsent;
  if (is_directory && (errno == ENOTEMPTY || errno == EEXIST)) return Removal::kStranger;
  throw_resource("cannot remove what the program wrote",
                 {.file = path.string(), .found = std::strerror(errno), .advice = {}});
}

void OwnedFiles::remove_or_refuse(const fs::path& path) {
  if (remove(path) == Removal::kStranger) throw_stranger(path);
}

std::vector<OwnedFiles::Line> OwnedFiles::directories_outside() const {
  const std::scoped_lock lock(mutex_);
  std::vector<Line> directories;
  for (const auto& [inode, name] : outside_)
    if (name.ends_with('/') && inode != 0)
      directories.emplace_back(inode, name.substr(0, name.size() - 1));
  return directories;
}

void OwnedFiles::remove_abandoned() {
  const std::vector<Line> left = outside_;
  for (const auto& [inode, name] : left) {
    // Only what is on its way is announced: a finished output is on record, too, and stays.
    if (inode != 0) continue;
    const bool is_directory = name.ends_with('/');
    const fs::path path = is_directory ? name.substr(0, name.size() - 1) : name;
    try {
      std::error_code ignored;
      std::vector<fs::path> inside;
      if (is_directory && recorded(path))
        for (const auto& entry : fs::directory_iterator(path, ignored))
          inside.push_back(entry.path());
      for (const fs::path& file : inside) remove(file);
      remove(path);
    } catch (const Error&) {
      // What cannot be removed is no reason not to run.
    }
  }
}

// ------------------------------------------------------------------- the process's record

namespace {

struct Records {
  std::mutex mutex;
  std::vector<std::shared_ptr<OwnedFiles>> open;  // the last one counts
};

Records& records() {
  static Records all;
  return all;
}

}  // namespace

RecordScope::RecordScope(std::shared_ptr<OwnedFiles> record) : record_(std::move(record)) {
  const std::scoped_lock lock(records().mutex);
  records().open.push_back(record_);
}

RecordScope::~RecordScope() {
  const std::scoped_lock lock(records().mutex);
  std::vector<std::shared_ptr<OwnedFiles>>& open = records().open;
  open.erase(std::find(open.begin(), open.end(), record_));
}

std::shared_ptr<OwnedFiles> current_record() {
  const std::scoped_lock lock(records().mutex);
  return records().open.empty() ? nullptr : records().open.back();
}

}  // namespace orbweave
