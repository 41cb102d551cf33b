#include "partition/mpi_team.h"

#include <mpi.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <string_view>
#include <thread>
#include <vector>

#include "io/error.h"
#include "partition/executor.h"

namespace orbweave {
namespace {

using std::chrono::milliseconds;

/// Words of the leader's window.
constexpr MPI_Aint kNext = 0;         ///< the counter
constexpr MPI_Aint kDoneUnits = 1;    ///< by the others
constexpr MPI_Aint kDonePoints = 2;   ///< by the others
constexpr MPI_Aint kLeadersWord = 3;  ///< what the leader tells everybody
constexpr MPI_Aint kFailures = 4;     ///< members that failed
constexpr MPI_Aint kSameFailure = 5;  ///< members that failed, by a hash of what they say
constexpr std::uint64_t kHashes = 61;
constexpr MPI_Aint kWords = kSameFailure + static_cast<MPI_Aint>(kHashes);

/// How often the leader looks after what comes in from outside.
constexpr milliseconds kProgressInterval{1};
/// Who waits for others looks ever more rarely, so that waiting costs nothing.
constexpr milliseconds kShortestNap{1};
constexpr milliseconds kLongestNap{20};
/// A member that failed waits so long for others to say the same, and for their last results to
/// become durable.
constexpr milliseconds kFailureGrace{1000};
/// A member that leaves the word to another one waits so long for the end.
constexpr milliseconds kWaitForEnd{20000};

/// FNV-1a (Fowler, Noll, Vo 1991): the same in every process.
std::uint64_t hash_of(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return hash % kHashes;
}

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown host";
}

/// Cores this process may run on, one byte each.
std::vector<unsigned char> own_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<unsigned char> cores(CPU_SETSIZE, 0);
  if (sched_getaffinity(0, sizeof(set), &set) != 0) return cores;
  for (int c = 0; c < CPU_SETSIZE; ++c) cores[c] = CPU_ISSET(c, &set) ? 1 : 0;
  return cores;
}

/// Collective: this member's share of the cores that it may run on.
int share_of_cores() {
  MPI_Comm machine;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  int members = 1;
  MPI_Comm_size(machine, &members);
  const std::vector<unsigned char> own = own_cores();
  std::vector<unsigned char> all(own.size() * static_cast<std::size_t>(members));
  const int cores = static_cast<int>(own.size());
  MPI_Allgather(own.data(), cores, MPI_UNSIGNED_CHAR, all.data(), cores, MPI_UNSIGNED_CHAR,
                machine);
  MPI_Comm_free(&machine);
  double share = 0.0;
  for (std::size_t c = 0; c < own.size(); ++c) {
    int users = 0;
    for (std::size_t m = c; m < all.size(); m += own.size()) users += all[m];
    if (own[c] != 0) share += 1.0 / users;
  }
  return std::max(1, static_cast<int>(share + 0.5));
}

/// Over TCP, Open MPI 4 has one-sided operations by its component pt2pt alone, which Debian's
/// configuration leaves out because it is slow. It is fast enough to count. A choice of the user's
/// goes before.
void allow_one_sided_by_messages() {
#if defined(OMPI_MAJOR_VERSION) && OMPI_MAJOR_VERSION < 5
  setenv("OMPI_MCA_osc", "^ucx", 0);
#endif
}

/// Collective: the leader's words, all 0, open to everybody.
MPI_Win make_window(bool leads) {
  constexpr auto kWord = static_cast<int>(sizeof(std::uint64_t));
  std::uint64_t* words = nullptr;
  MPI_Win window = MPI_WIN_NULL;
  MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
  if (MPI_Win_allocate(leads ? kWords * kWord : 0, kWord, MPI_INFO_NULL, MPI_COMM_WORLD, &words,
                       &window) != MPI_SUCCESS)
    throw_resource("MPI has no one-sided operations between these processes",
                   {.advice = "With Open MPI, leave the MCA parameter osc alone, or set it to "
                              "\"^ucx\""});
  MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_ARE_FATAL);
  MPI_Win_lock_all(MPI_MODE_NOCHECK, window);
  if (leads) std::fill(words, words + kWords, std::uint64_t{0});
  MPI_Win_sync(window);
  MPI_Barrier(MPI_COMM_WORLD);
  return window;
}

}  // namespace

struct MpiTeam::State {
  // One call at a time: they are few and short, and one-sided operations over messages
  // (Open MPI's osc/pt2pt) do not work in libraries that were asked for MPI_THREAD_MULTIPLE.
  std::mutex calls;
  int rank = 0;
  int size = 1;
  int threads = 1;
  MPI_Win window = MPI_WIN_NULL;
  Team::Done told;  // the leader's reader, of what the others did

  std::mutex end_mutex;
  std::condition_variable end_signal;
  bool ended = false;
  std::thread progress;

  /// Adds to a word of the leader's window; returns what it was.
  std::uint64_t add(MPI_Aint word, std::uint64_t amount);
  std::uint64_t look(MPI_Aint word);
  void set(MPI_Aint word, std::uint64_t value);
  bool has_come(MPI_Request& request);
  void make_progress();
};

std::uint64_t MpiTeam::State::add(MPI_Aint word, std::uint64_t amount) {
  std::uint64_t before = 0;
  const std::scoped_lock lock(calls);
  MPI_Fetch_and_op(&amount, &before, MPI_UINT64_T, 0, word, MPI_SUM, window);
  MPI_Win_flush(0, window);
  return before;
}

std::uint64_t MpiTeam::State::look(MPI_Aint word) {
  std::uint64_t value = 0;
  const std::scoped_lock lock(calls);
  MPI_Fetch_and_op(nullptr, &value, MPI_UINT64_T, 0, word, MPI_NO_OP, window);
  MPI_Win_flush(0, window);
  return value;
}

/// Nobody may add to the word meanwhile: different operations at one time are not atomic.
void MpiTeam::State::set(MPI_Aint word, std::uint64_t value) {
  std::uint64_t before = 0;
  const std::scoped_lock lock(calls);
  MPI_Fetch_and_op(&value, &before, MPI_UINT64_T, 0, word, MPI_REPLACE, window);
  MPI_Win_flush(0, window);
}

bool MpiTeam::State::has_come(MPI_Request& request) {
  int done = 0;
  const std::scoped_lock lock(calls);
  MPI_Test(&request, &done, MPI_STATUS_IGNORE);
  return done != 0;
}

/// Where the network cannot reach into the leader's memory by itself (TCP), an operation on its
/// window is a message that the library answers only while somebody calls it. While the leader's
/// threads compute nobody would, and all others would wait for the end of its chunk.
void MpiTeam::State::make_progress() {
  std::unique_lock lock(end_mutex);
  while (!end_signal.wait_for(lock, kProgressInterval, [this] { return ended; })) {
    int ignored = 0;
    const std::scoped_lock calling(calls);
    MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &ignored, MPI_STATUS_IGNORE);
  }
}

MpiTeam::MpiTeam() : state_(std::make_unique<State>()) {
  allow_one_sided_by_messages();
  int provided = MPI_THREAD_SINGLE;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
  if (provided < MPI_THREAD_SERIALIZED)
    throw_resource("the MPI library was built without threads",
                   {.expected = "one that offers MPI_THREAD_SERIALIZED"});
  MPI_Comm_rank(MPI_COMM_WORLD, &state_->rank);
  MPI_Comm_size(MPI_COMM_WORLD, &state_->size);
  state_->threads = share_of_cores();
  state_->window = make_window(leads());
  if (leads() && size() > 1)
    state_->progress = std::thread([state = state_.get()] { state->make_progress(); });
}

MpiTeam::~MpiTeam() {
  {
    const std::scoped_lock lock(state_->end_mutex);
    state_->ended = true;
  }
  state_->end_signal.notify_all();
  if (state_->progress.joinable()) state_->progress.join();
  MPI_Win_unlock_all(state_->window);
  MPI_Win_free(&state_->window);
  MPI_Finalize();
}

int MpiTeam::rank() const { return state_->rank; }
int MpiTeam::size() const { return state_->size; }
int MpiTeam::threads() const { return state_->threads; }

void MpiTeam::meet(const StopToken& stop, const std::function<void()>& while_waiting) {
  MPI_Request all_here = MPI_REQUEST_NULL;
  {
    const std::scoped_lock lock(state_->calls);
    MPI_Ibarrier(MPI_COMM_WORLD, &all_here);
  }
  for (milliseconds nap = kShortestNap; !state_->has_come(all_here);
       nap = std::min(2 * nap, kLongestNap)) {
    stop.check();
    while_waiting();
    std::this_thread::sleep_for(nap);
  }
}

std::uint64_t MpiTeam::leaders_word(std::uint64_t word, const StopToken& stop) {
  meet(stop);  // everybody knows the last one
  if (leads()) state_->set(kLeadersWord, word);
  meet(stop);
  return state_->look(kLeadersWord);
}

void MpiTeam::start_counting(const StopToken& stop) {
  meet(stop);
  if (leads()) {
    for (const MPI_Aint word : {kNext, kDoneUnits, kDonePoints}) state_->set(word, 0);
    state_->told = {};
  }
  meet(stop);
}

std::uint64_t MpiTeam::take_next() { return state_->add(kNext, 1); }

void MpiTeam::add_done(std::uint64_t units, std::uint64_t points) {
  if (leads()) return;
  state_->add(kDoneUnits, units);
  if (points > 0) state_->add(kDonePoints, points);
}

Team::Done MpiTeam::done_by_others() {
  const Done done{state_->look(kDoneUnits), state_->look(kDonePoints)};
  const Done news{done.units - state_->told.units, done.points - state_->told.points};
  state_->told = done;
  return news;
}

void MpiTeam::fail(ExitStatus status, const std::string& problem,
                   const std::function<void(const std::string&)>& print) {
  const MPI_Aint same = kSameFailure + static_cast<MPI_Aint>(hash_of(problem));
  const auto all = static_cast<std::uint64_t>(size());
  state_->add(same, 1);
  if (state_->add(kFailures, 1) > 0) {
    std::this_thread::sleep_for(kWaitForEnd);
    _exit(static_cast<int>(status));
  }
  // Who interrupts a job does not wait long, and it does not matter which member he met.
  const bool interrupted = status == ExitStatus::kInterrupted;
  if (interrupted) print(problem);
  const auto give_up = std::chrono::steady_clock::now() + kFailureGrace;
  bool by_all = state_->look(same) == all;
  while (!by_all && std::chrono::steady_clock::now() < give_up) {
    std::this_thread::sleep_for(kLongestNap);
    by_all = state_->look(same) == all;
  }
  const std::string who = "rank " + std::to_string(rank()) + " (" + host_name() + "): ";
  if (!interrupted) print((by_all ? "" : who) + problem);
  MPI_Abort(MPI_COMM_WORLD, static_cast<int>(status));
  _exit(static_cast<int>(status));
}

}  // namespace orbweave
