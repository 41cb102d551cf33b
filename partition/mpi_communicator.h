// The processes that mpirun started, as a team. Chunks are dealt out by a counter that lies in an
// MPI window of the leader and is counted up from outside (one-sided: the leader does not take
// part), so no process is a server. docs/cluster.md has the whole.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "partition/communicator.h"

namespace orbweave {

/// One object per process, alive as long as MPI is. Any thread may call any method. What goes
/// wrong inside MPI ends the job, as is MPI's own way.
class MpiCommunicator : public Communicator {
 public:
  /// Joins the others: returns when all are there. Throws Error (resource) where the MPI library
  /// was built without threads.
  MpiCommunicator();
  /// Leaves MPI. Every member has to get here, after leave().
  ~MpiCommunicator() override;

  int rank() const override;
  int size() const override;
  /// Cores that this process may run on, dealt out among the members that may run there too, so
  /// that no core is two members'; at least 1.
  int threads() const override;
  using Communicator::barrier;
  void barrier(const StopToken& stop, const std::function<void()>& while_waiting) override;
  std::uint64_t broadcast(std::uint64_t word, const StopToken& stop) override;
  std::vector<std::string> gather(const std::string& text, const StopToken& stop) override;
  void reset_counter(const StopToken& stop) override;
  void add_done(std::uint64_t units, std::uint64_t points) override;
  Done done_by_others() override;

  /// The end of a job in order: waits for all without using the processor.
  void leave(const StopToken& stop) { barrier(stop); }

  /// The end of a job that failed here: ends it everywhere with `exit_status`. One member of those
  /// that failed calls `print`: with `problem` where all members failed with the same or were
  /// interrupted, otherwise with "rank 3 (host): " before it.
  [[noreturn]] void fail(int exit_status, bool interrupted, const std::string& problem,
                         const std::function<void(const std::string&)>& print);

 protected:
  std::uint64_t count_up(std::uint64_t amount) override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace orbweave
