// Makes result files durable and visible, in the background and many at a time.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <filesystem>
#include <mutex>
#include <shared_mutex>
#include <span>
#include <string>
#include <thread>
#include <unordered_map>

#include "io/store/chunk_store_file.h"
#include "io/system/file_descriptor.h"

namespace orbweave {

class OwnedFiles;

/// A queue of written files that wait to be flushed to the device and renamed. One thread works
/// it off in order of commit: it takes all waiting files at once, flushes them together, renames
/// them and flushes their directory once. So a thousand small results cost some dozens of device
/// flushes, not thousands.
class CommitQueue {
 public:
  CommitQueue() = default;
  /// Whose files are renamed and removed; before the first push.
  void use(OwnedFiles& record) { record_ = &record; }
  /// From when on files are flushed; before the first push. Sooner, they are renamed alone, and the
  /// first flush is one of all that was written by then.
  void set_first_flush(std::chrono::steady_clock::time_point when) { first_flush_ = when; }
  bool flushes() const { return std::chrono::steady_clock::now() >= first_flush_; }
  /// Finishes what is queued; errors are lost, their files are removed.
  ~CommitQueue();
  CommitQueue(const CommitQueue&) = delete;
  CommitQueue& operator=(const CommitQueue&) = delete;

  /// `part` is written and shall become `target`. Waits while kLimit files are queued. Rethrows
  /// what went wrong with earlier ones.
  void push(std::filesystem::path part, std::filesystem::path target, FileDescriptor file);
  /// Waits until everything queued is done; rethrows what went wrong.
  void finish();
  /// Files pushed so far, and how many of these, the first ones, are durable with their names.
  /// Stays where it is once something went wrong.
  std::uint64_t pushed() const;
  std::uint64_t settled() const;
  /// Waits until so many are; rethrows what went wrong. What is queued lingers no longer, even
  /// where there is nothing to wait for.
  void await_settled(std::uint64_t files);
  /// Waits until `target` is not in the queue.
  void await(const std::filesystem::path& target);
  /// Forgets what is queued; the part files stay for the caller to remove.
  void drop();

  /// Calls use(path) with the name that the target has at the moment, and keeps it that way for
  /// the time of the call.
  template <class Use>
  auto with_current_name(const std::filesystem::path& target, const Use& use) const {
    const std::shared_lock lock(names_);
    const auto found = unnamed_.find(target.native());
    return use(found == unnamed_.end() ? target : found->second);
  }

 private:
  static constexpr std::size_t kLimit = 256;
  static constexpr std::size_t kFlushTogether = 3;
  // How long a result waits for others to be flushed with, while no caller waits for the result.
  static constexpr std::chrono::milliseconds kLinger{100};
  struct Item {
    std::filesystem::path part, target;
    FileDescriptor file;
  };

  template <class Condition>
  void wait_until(std::unique_lock<std::mutex>& lock, const Condition& condition);
  void work();
  void settle(std::deque<Item>& batch);
  bool flush(const std::deque<Item>& batch);
  void rename_all(std::span<Item> durable, bool flushes);
  void forget(const Item& item);
  void remove(const std::filesystem::path& part);
  void fail(std::exception_ptr failure);
  void rethrow_failure(std::unique_lock<std::mutex>& lock);

  OwnedFiles* record_ = nullptr;
  std::chrono::steady_clock::time_point first_flush_{};
  bool owes_flush_ = false;  // files have been renamed that were not flushed
  // Lock order: mutex_ before names_.
  mutable std::shared_mutex names_;
  std::unordered_map<std::string, std::filesystem::path> unnamed_;  // target -> part

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> queue_;
  std::uint64_t pushed_ = 0;
  std::uint64_t settled_ = 0;
  bool failed_ = false;  // at any time
  bool busy_ = false;
  bool stop_ = false;
  int hurried_ = 0;       // callers that wait
  bool hurries_ = false;  // what is queued lingers no longer
  std::exception_ptr failure_;
  std::thread thread_;
};

/// Flushes a directory's entries to the device. Throws Error (resource).
void flush_names(const std::filesystem::path& directory);

}  // namespace orbweave
