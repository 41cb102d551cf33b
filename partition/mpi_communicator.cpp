#include "partition/mpi_communicator.h"

#include <mpi.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <numeric>
#include <string_view>
#include <thread>
#include <vector>

#include "io/error.h"
#include "partition/executor.h"

namespace orbweave {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// Words of the root's window. A word that is used in every turn is there twice, so that the word
/// of the next turn can be set while a process still reads that of this turn.
constexpr MPI_Aint kNext = 0;         ///< the counter; what the others have done lies behind it
constexpr MPI_Aint kDoneUnits = 1;    ///< behind kNext
constexpr MPI_Aint kDonePoints = 2;   ///< behind kNext
constexpr MPI_Aint kCountWords = 3;   ///< of one turn
constexpr MPI_Aint kLeadersWord = 6;  ///< what the leader tells everybody
constexpr MPI_Aint kFailures = 8;     ///< members that failed
constexpr MPI_Aint kSameFailure = 9;  ///< members that failed, by a hash of what they say
constexpr std::uint64_t kHashes = 61;
constexpr MPI_Aint kWords = kSameFailure + static_cast<MPI_Aint>(kHashes);

/// How often the leader looks after what comes in from outside.
constexpr milliseconds kProgressInterval{1};
/// A waiting process looks ever more rarely: the wait costs next to nothing, and is prolonged by
/// little more than its own length.
constexpr microseconds kShortestNap{50};
constexpr microseconds kLongestNap{2000};
constexpr int kNapsPerWait = 8;
/// How often a waiting process does something else, and a failed one asks for the others.
constexpr milliseconds kLookInterval{20};
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

/// How many cores member `position` gets where each is dealt to one of those who may run on it, in
/// turns. `all`: a byte per core, member by member.
int dealt_cores(const std::vector<unsigned char>& all, std::size_t cores, int position) {
  int dealt = 0;
  std::size_t turn = 0;
  for (std::size_t c = 0; c < cores; ++c) {
    std::vector<int> users;
    for (std::size_t m = 0; m * cores < all.size(); ++m)
      if (all[m * cores + c] != 0) users.push_back(static_cast<int>(m));
    if (!users.empty() && users[turn++ % users.size()] == position) ++dealt;
  }
  return dealt;
}

/// Collective: this member's share of the cores that it may run on.
int share_of_cores() {
  MPI_Comm machine;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  int members = 1;
  int position = 0;
  MPI_Comm_size(machine, &members);
  MPI_Comm_rank(machine, &position);
  const std::vector<unsigned char> own = own_cores();
  std::vector<unsigned char> all(own.size() * static_cast<std::size_t>(members));
  const int cores = static_cast<int>(own.size());
  MPI_Allgather(own.data(), cores, MPI_UNSIGNED_CHAR, all.data(), cores, MPI_UNSIGNED_CHAR,
                machine);
  MPI_Comm_free(&machine);
  return std::max(1, dealt_cores(all, own.size(), position));
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

struct MpiCommunicator::State {
  // One call at a time: they are few and short, and one-sided operations over messages
  // (Open MPI's osc/pt2pt) do not work in libraries that were asked for MPI_THREAD_MULTIPLE.
  std::mutex calls;
  int rank = 0;
  int size = 1;
  int threads = 1;
  MPI_Win window = MPI_WIN_NULL;
  Communicator::Done told;               // the leader's reader, of what the others did
  MPI_Aint words_told = 0;               // the leader's, so far
  MPI_Aint counts = 0;                   // times that counting began
  std::atomic<MPI_Aint> count_words{0};  // of this turn
  std::atomic<bool> owes{false};         // what it did may not be with the leader yet

  std::mutex end_mutex;
  std::condition_variable end_signal;
  bool ended = false;
  std::thread progress;

  /// Adds to a word of the leader's window; returns what it was.
  std::uint64_t add(MPI_Aint word, std::uint64_t amount);
  std::uint64_t look(MPI_Aint word);
  void set(MPI_Aint word, std::uint64_t value);
  void add_later(MPI_Aint first_word, std::array<std::uint64_t, 2> amounts);
  void settle();
  bool has_come(MPI_Request& request);
  void make_progress();
};

std::uint64_t MpiCommunicator::State::add(MPI_Aint word, std::uint64_t amount) {
  std::uint64_t before = 0;
  const std::scoped_lock lock(calls);
  MPI_Fetch_and_op(&amount, &before, MPI_UINT64_T, 0, word, MPI_SUM, window);
  MPI_Win_flush(0, window);
  return before;
}

std::uint64_t MpiCommunicator::State::look(MPI_Aint word) {
  std::uint64_t value = 0;
  const std::scoped_lock lock(calls);
  MPI_Fetch_and_op(nullptr, &value, MPI_UINT64_T, 0, word, MPI_NO_OP, window);
  MPI_Win_flush(0, window);
  return value;
}

/// No process may add to the word meanwhile: different operations at one time are not atomic.
void MpiCommunicator::State::set(MPI_Aint word, std::uint64_t value) {
  std::uint64_t before = 0;
  const std::scoped_lock lock(calls);
  MPI_Fetch_and_op(&value, &before, MPI_UINT64_T, 0, word, MPI_REPLACE, window);
  MPI_Win_flush(0, window);
}

/// Adds to two words, before settle() returns at the latest.
void MpiCommunicator::State::add_later(MPI_Aint first_word, std::array<std::uint64_t, 2> amounts) {
  const std::scoped_lock lock(calls);
  MPI_Accumulate(amounts.data(), 2, MPI_UINT64_T, 0, first_word, 2, MPI_UINT64_T, MPI_SUM, window);
  MPI_Win_flush_local(0, window);
  owes = true;
}

void MpiCommunicator::State::settle() {
  if (!owes.exchange(false)) return;
  const std::scoped_lock lock(calls);
  MPI_Win_flush(0, window);
}

bool MpiCommunicator::State::has_come(MPI_Request& request) {
  int done = 0;
  const std::scoped_lock lock(calls);
  MPI_Test(&request, &done, MPI_STATUS_IGNORE);
  return done != 0;
}

/// Where the network cannot reach into the leader's memory by itself (TCP), an operation on its
/// window is a message that the library answers only during a call. While the root's threads
/// compute there is no call, and all others would wait for the end of a chunk.
void MpiCommunicator::State::make_progress() {
  std::unique_lock lock(end_mutex);
  while (!end_signal.wait_for(lock, kProgressInterval, [this] { return ended; })) {
    int ignored = 0;
    const std::scoped_lock calling(calls);
    MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &ignored, MPI_STATUS_IGNORE);
  }
}

MpiCommunicator::MpiCommunicator() : state_(std::make_unique<State>()) {
  allow_one_sided_by_messages();
  int provided = MPI_THREAD_SINGLE;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
  if (provided < MPI_THREAD_SERIALIZED)
    throw_resource("the MPI library was built without threads",
                   {.expected = "one that offers MPI_THREAD_SERIALIZED"});
  MPI_Comm_rank(MPI_COMM_WORLD, &state_->rank);
  MPI_Comm_size(MPI_COMM_WORLD, &state_->size);
  state_->threads = share_of_cores();
  state_->window = make_window(is_root());
  if (is_root() && size() > 1)
    state_->progress = std::thread([state = state_.get()] { state->make_progress(); });
}

MpiCommunicator::~MpiCommunicator() {
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

int MpiCommunicator::rank() const { return state_->rank; }
int MpiCommunicator::size() const { return state_->size; }
int MpiCommunicator::threads() const { return state_->threads; }

void MpiCommunicator::barrier(const StopToken& stop, const std::function<void()>& while_waiting) {
  state_->settle();
  MPI_Request all_here = MPI_REQUEST_NULL;
  {
    const std::scoped_lock lock(state_->calls);
    MPI_Ibarrier(MPI_COMM_WORLD, &all_here);
  }
  const auto begin = steady_clock::now();
  auto next_look = begin;
  while (!state_->has_come(all_here)) {
    stop.check();
    const auto now = steady_clock::now();
    if (now >= next_look) {
      while_waiting();
      next_look = now + kLookInterval;
    }
    const auto waited = std::chrono::duration_cast<microseconds>(now - begin);
    std::this_thread::sleep_for(std::clamp(waited / kNapsPerWait, kShortestNap, kLongestNap));
  }
}

std::uint64_t MpiCommunicator::broadcast(std::uint64_t word, const StopToken& stop) {
  // A process that reaches the next barrier has seen this word: then its place is free for the one
  // after the next.
  const MPI_Aint place = kLeadersWord + state_->words_told++ % 2;
  if (is_root()) state_->set(place, word);
  barrier(stop);
  return state_->look(place);
}

std::vector<std::string> MpiCommunicator::gather(const std::string& text, const StopToken& stop) {
  barrier(stop);
  // All are here: what follows waits for messages alone.
  const std::scoped_lock lock(state_->calls);
  const auto own = static_cast<int>(text.size());
  std::vector<int> sizes(is_root() ? static_cast<std::size_t>(size()) : 0);
  MPI_Gather(&own, 1, MPI_INT, sizes.data(), 1, MPI_INT, 0, MPI_COMM_WORLD);
  std::vector<int> begins(sizes.size());
  std::exclusive_scan(sizes.begin(), sizes.end(), begins.begin(), 0);
  std::string all(sizes.empty() ? 0 : static_cast<std::size_t>(begins.back() + sizes.back()), ' ');
  MPI_Gatherv(text.data(), own, MPI_CHAR, all.data(), sizes.data(), begins.data(), MPI_CHAR, 0,
              MPI_COMM_WORLD);
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < sizes.size(); ++i)
    texts.push_back(
        all.substr(static_cast<std::size_t>(begins[i]), static_cast<std::size_t>(sizes[i])));
  return texts;
}

void MpiCommunicator::reset_counter(const StopToken& stop) {
  barrier(stop);
  const MPI_Aint place = state_->counts++ % 2;
  state_->count_words = kCountWords * place;
  if (!is_root()) return;
  // No process counts there before the next barrier, and none still does from the last turn.
  for (const MPI_Aint word : {kNext, kDoneUnits, kDonePoints})
    state_->set(kCountWords * (1 - place) + word, 0);
  state_->told = {};
}

std::uint64_t MpiCommunicator::count_up(std::uint64_t amount) {
  return state_->add(state_->count_words + kNext, amount);
}

void MpiCommunicator::add_done(std::uint64_t units, std::uint64_t points) {
  if (!is_root()) state_->add_later(state_->count_words + kDoneUnits, {units, points});
}

Communicator::Done MpiCommunicator::done_by_others() {
  const MPI_Aint words = state_->count_words;
  const Done done{state_->look(words + kDoneUnits), state_->look(words + kDonePoints)};
  const Done news{done.units - state_->told.units, done.points - state_->told.points};
  state_->told = done;
  return news;
}

void MpiCommunicator::fail(int exit_status, bool interrupted, const std::string& problem,
                           const std::function<void(const std::string&)>& print) {
  const MPI_Aint same = kSameFailure + static_cast<MPI_Aint>(hash_of(problem));
  const auto all = static_cast<std::uint64_t>(size());
  state_->add(same, 1);
  if (state_->add(kFailures, 1) > 0) {
    std::this_thread::sleep_for(kWaitForEnd);
    _exit(exit_status);
  }
  // Who interrupts a job does not wait long, and it does not matter which member he met.
  if (interrupted) print(problem);
  const auto give_up = steady_clock::now() + kFailureGrace;
  bool by_all = state_->look(same) == all;
  while (!by_all && steady_clock::now() < give_up) {
    std::this_thread::sleep_for(kLookInterval);
    by_all = state_->look(same) == all;
  }
  const std::string who = "rank " + std::to_string(rank()) + " (" + host_name() + "): ";
  if (!interrupted) print((by_all ? "" : who) + problem);
  MPI_Abort(MPI_COMM_WORLD, exit_status);
  _exit(exit_status);
}

}  // namespace orbweave
