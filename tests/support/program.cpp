#include "tests/support/program.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

extern char** environ;

namespace orbweave::test {
namespace {

int unnamed_file() {
  std::string name = (std::filesystem::temp_directory_path() / "orbweave-output-XXXXXX").string();
  const int descriptor = mkostemp(name.data(), O_CLOEXEC);
  if (descriptor < 0) throw std::runtime_error("cannot create " + name);
  unlink(name.c_str());
  return descriptor;
}

std::string content_of(int descriptor) {
  std::string text;
  std::array<char, 65536> buffer{};
  lseek(descriptor, 0, SEEK_SET);
  for (ssize_t got = 0; (got = read(descriptor, buffer.data(), buffer.size())) > 0;)
    text.append(buffer.data(), static_cast<std::size_t>(got));
  return text;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (std::string& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

std::vector<std::string> environment_with(const std::vector<std::string>& more) {
  std::vector<std::string> all = more;
  for (char** variable = environ; *variable != nullptr; ++variable) all.emplace_back(*variable);
  return all;
}

/// The program listens to no signal that is ignored when it begins, and a script that runs the
/// tests in the background has SIGINT ignored.
class SignalsByDefault {
 public:
  SignalsByDefault() {
    sigset_t signals;
    sigemptyset(&signals);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGXCPU, SIGUSR1, SIGUSR2})
      sigaddset(&signals, signal);
    posix_spawnattr_init(&attributes_);
    posix_spawnattr_setsigdefault(&attributes_, &signals);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGDEF);
  }
  ~SignalsByDefault() { posix_spawnattr_destroy(&attributes_); }
  SignalsByDefault(const SignalsByDefault&) = delete;
  SignalsByDefault& operator=(const SignalsByDefault&) = delete;

  const posix_spawnattr_t* get() const { return &attributes_; }

 private:
  posix_spawnattr_t attributes_{};
};

pid_t spawn(std::vector<std::string> arguments, const ProgramSetting& setting, int out, int err) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  if (setting.out_to.empty())
    posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
  else
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, setting.out_to.c_str(), O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, err, STDERR_FILENO);
  if (!setting.directory.empty())
    posix_spawn_file_actions_addchdir_np(&actions, setting.directory.c_str());
  const SignalsByDefault signals;
  std::vector<std::string> environment = environment_with(setting.environment);
  pid_t process = -1;
  const int failure = posix_spawn(&process, arguments[0].c_str(), &actions, signals.get(),
                                  pointers(arguments).data(), pointers(environment).data());
  posix_spawn_file_actions_destroy(&actions);
  if (failure != 0) throw std::runtime_error("cannot start " + arguments[0]);
  return process;
}

/// Processor time of all threads of a process; 0 where nobody tells.
std::chrono::nanoseconds own_time(pid_t process) {
  clockid_t clock = 0;
  timespec time{};
  if (clock_getcpuclockid(process, &clock) != 0 || clock_gettime(clock, &time) != 0) return {};
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

}  // namespace

RunningProgram::RunningProgram(const std::vector<std::string>& arguments,
                               const ProgramSetting& setting)
    : out_(unnamed_file()), err_(unnamed_file()) {
  const std::filesystem::path& program = setting.program;
  std::vector<std::string> all = {(program.empty() ? program_path() : program).string()};
  all.insert(all.end(), arguments.begin(), arguments.end());
  process_ = spawn(std::move(all), setting, out_, err_);
}

RunningProgram::~RunningProgram() {
  if (!ended_) {
    send(SIGKILL);
    collect(0);
  }
  close(out_);
  close(err_);
}

void RunningProgram::send(int signal) { kill(process_, signal); }

bool RunningProgram::running() {
  if (!ended_) collect(WNOHANG);
  return !ended_;
}

ProgramResult RunningProgram::wait() {
  if (!ended_) collect(0);
  return {status_, content_of(out_), content_of(err_)};
}

bool RunningProgram::hold() {
  if (!ended_ && !held_) {
    send(SIGSTOP);
    collect(WUNTRACED);
    held_ = !ended_;
  }
  return held_;
}

void RunningProgram::release() {
  if (!ended_) send(SIGCONT);
  held_ = false;
}

void RunningProgram::run_a_moment() {
  constexpr std::chrono::milliseconds kMoment{1};
  constexpr std::chrono::microseconds kLook{200};
  const auto begin = own_time(process_);
  // It may be waiting for a disk, or for its turn: on a busy machine that takes a while.
  const int looks = begin.count() > 0 ? 1000 : 5;
  release();
  for (int look = 0; look < looks && own_time(process_) - begin < kMoment; ++look)
    std::this_thread::sleep_for(kLook);
}

bool RunningProgram::hold_when(const std::function<bool()>& reached, int pause_ms) {
  while (hold()) {
    if (reached()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(pause_ms));
    run_a_moment();
  }
  return false;
}

void RunningProgram::collect(int options) {
  int state = 0;
  if (waitpid(process_, &state, options) != process_ || WIFSTOPPED(state)) return;
  ended_ = true;
  status_ = WIFEXITED(state) ? WEXITSTATUS(state) : 128 + WTERMSIG(state);
}

ProgramResult run_program(const std::vector<std::string>& arguments,
                          const ProgramSetting& setting) {
  return RunningProgram(arguments, setting).wait();
}

ProgramResult run_in(const ScratchDirectory& in, const std::vector<std::string>& arguments) {
  return run_program(arguments, {.directory = in.path()});
}

ProgramResult run_limited(const ScratchDirectory& in, const std::string& limit,
                          const std::vector<std::string>& arguments) {
  std::vector<std::string> all = {"-c", limit + " && exec \"$0\" \"$@\"", program_path().string()};
  all.insert(all.end(), arguments.begin(), arguments.end());
  return run_program(all, {.directory = in.path(), .program = "/bin/sh"});
}

std::vector<std::string> names_in(const ScratchDirectory& in) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(in.path()))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::string file_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) throw std::runtime_error("cannot write " + path.string());
}

}  // namespace orbweave::test
