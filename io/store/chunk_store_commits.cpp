#include "io/store/chunk_store_commits.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <exception>
#include <set>
#include <vector>

#include "io/system/directory.h"
#include "io/system/file_calls.h"
#include "io/system/file_descriptor.h"
#include "io/system/owned_files.h"
#include "io/system/work_directory_errors.h"

namespace orbweave {
namespace {

[[noreturn]] void throw_flush_error(const std::filesystem::path& path, int reason) {
  throw_refusal("cannot store a result", path, reason);
}

/// Flushes all files of a batch at once. False where there is no such call, or it failed.
bool flush_together([[maybe_unused]] const FileDescriptor& one_of_them) {
#ifdef __linux__
  return file_calls.syncfs(one_of_them.get()) == 0;
#else
  return false;
#endif
}

}  // namespace

void flush_names(const std::filesystem::path& directory) {
  if (const int error = flush_directory(directory); error != 0) throw_flush_error(directory, error);
}

CommitQueue::~CommitQueue() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

/// Waits in such a way that the queue does not linger.
template <class Condition>
void CommitQueue::wait_until(std::unique_lock<std::mutex>& lock, const Condition& condition) {
  if (condition()) return;
  ++hurried_;
  changed_.notify_all();
  changed_.wait(lock, condition);
  --hurried_;
}

void CommitQueue::push(std::filesystem::path part, std::filesystem::path target,
                       FileDescriptor file) {
  std::unique_lock lock(mutex_);
  if (!thread_.joinable()) thread_ = std::thread([this] { work(); });
  if (queue_.size() >= kLimit) wait_until(lock, [&] { return queue_.size() < kLimit || failure_; });
  {
    const std::scoped_lock names(names_);
    unnamed_[target.native()] = part;
  }
  queue_.push_back({std::move(part), std::move(target), std::move(file)});
  ++pushed_;
  changed_.notify_all();
  rethrow_failure(lock);
}

void CommitQueue::finish() {
  std::unique_lock lock(mutex_);
  wait_until(lock, [&] { return queue_.empty() && !busy_; });
  rethrow_failure(lock);
}

std::uint64_t CommitQueue::pushed() const {
  const std::scoped_lock lock(mutex_);
  return pushed_;
}

std::uint64_t CommitQueue::settled() const {
  const std::scoped_lock lock(mutex_);
  return settled_;
}

void CommitQueue::await_settled(std::uint64_t files) {
  std::unique_lock lock(mutex_);
  hurries_ = !queue_.empty();
  changed_.notify_all();
  wait_until(lock, [&] { return settled_ >= files || failed_; });
  rethrow_failure(lock);
}

void CommitQueue::await(const std::filesystem::path& target) {
  std::unique_lock lock(mutex_);
  wait_until(lock, [&] {
    const std::shared_lock names(names_);
    return !unnamed_.contains(target.native());
  });
}

void CommitQueue::drop() {
  std::unique_lock lock(mutex_);
  for (const Item& item : queue_) forget(item);
  queue_.clear();
  changed_.wait(lock, [&] { return !busy_; });
  failure_ = nullptr;
}

void CommitQueue::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return stop_ || !queue_.empty(); });
    if (queue_.empty()) return;
    changed_.wait_for(lock, kLinger,
                      [&] { return stop_ || hurries_ || hurried_ > 0 || queue_.size() >= kLimit; });
    hurries_ = false;
    if (queue_.empty()) continue;  // dropped meanwhile
    std::deque<Item> batch = std::exchange(queue_, {});
    const std::uint64_t pushed = pushed_;
    busy_ = true;
    changed_.notify_all();  // there is room in the queue
    lock.unlock();
    settle(batch);
    batch.clear();
    lock.lock();
    busy_ = false;
    if (!failed_) settled_ = pushed;
    changed_.notify_all();
  }
}

/// Every fdatasync costs a flush of the device's cache, some milliseconds; syncfs costs one for
/// all, those before included. False: the files are asked one by one which of them could not be
/// flushed.
bool CommitQueue::flush(const std::deque<Item>& batch) {
  if (!owes_flush_ && batch.size() < kFlushTogether) return false;
  if (!flush_together(batch.front().file)) return false;
  owes_flush_ = false;
  return true;
}

void CommitQueue::settle(std::deque<Item>& batch) {
  const bool flushes = this->flushes();
  owes_flush_ = owes_flush_ || !flushes;
  const bool all = !flushes || flush(batch);
  std::vector<Item> durable;
  for (Item& item : batch) {
    try {
      const bool done = all || (!owes_flush_ && file_calls.fdatasync(item.file.get()) == 0);
      if (!done) throw_flush_error(item.target, errno);
      durable.push_back(std::move(item));
    } catch (...) {
      fail(std::current_exception());
      remove(item.part);
      forget(item);
    }
  }
  rename_all(durable, flushes);
}

void CommitQueue::rename_all(std::span<Item> durable, bool flushes) {
  std::set<std::filesystem::path> directories;
  for (const Item& item : durable) {
    try {
      const std::scoped_lock names(names_);
      unnamed_.erase(item.target.native());
      if (!record_->rename(item.part, item.target)) throw_flush_error(item.target, errno);
      directories.insert(item.target.parent_path());
    } catch (...) {
      fail(std::current_exception());
      remove(item.part);
    }
  }
  if (!flushes) return;
  for (const std::filesystem::path& directory : directories) {
    try {
      flush_names(directory);
    } catch (...) {
      fail(std::current_exception());
    }
  }
}

void CommitQueue::remove(const std::filesystem::path& part) {
  try {
    record_->remove(part);
  } catch (const std::exception&) {
    // What failed before is told; the next run removes the part.
  }
}

void CommitQueue::forget(const Item& item) {
  const std::scoped_lock names(names_);
  unnamed_.erase(item.target.native());
}

void CommitQueue::fail(std::exception_ptr failure) {
  const std::scoped_lock lock(mutex_);
  failed_ = true;
  if (!failure_) failure_ = std::move(failure);
}

void CommitQueue::rethrow_failure(std::unique_lock<std::mutex>& lock) {
  if (!failure_) return;
  const std::exception_ptr failure = std::exchange(failure_, nullptr);
  lock.unlock();
  std::rethrow_exception(failure);
}

}  // namespace orbweave
