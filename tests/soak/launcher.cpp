// Starts the program over and over without loading its libraries every time, which takes longer
// than most trials of the attack suite: the process waits for requests, forks, and the child does
// what the program's main() does.
//
// A request on standard input: its length (4 bytes, this machine's order), then strings that each
// end with a zero byte: directory, file of standard output, file of standard error, user id or
// nothing, seconds until the child is killed, arguments. The answer on standard output: exit status
// or minus the signal (4 bytes), whether it was killed for its time (4), CPU seconds (8), peak of
// resident memory in KiB (8).
#include <fcntl.h>
#include <grp.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <vector>

#include "engine/cli/command_line.h"
#include "engine/cli/exit_status.h"
#include "engine/cli/failure.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "io/system/hdf5_exit.h"

namespace {

orbweave::StopToken stop;

struct Answer {
  std::int32_t status = 0;
  std::int32_t late = 0;
  double cpu_seconds = 0.0;
  std::int64_t peak_kib = 0;
};
static_assert(sizeof(Answer) == 24, "read by trial.py");

bool read_all(void* data, std::size_t bytes) {
  auto* at = static_cast<char*>(data);
  while (bytes > 0) {
    const ssize_t got = ::read(STDIN_FILENO, at, bytes);
    if (got <= 0) return false;
    at += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

bool read_request(std::vector<std::string>& strings) {
  std::uint32_t bytes = 0;
  if (!read_all(&bytes, sizeof bytes)) return false;
  std::string text(bytes, '\0');
  if (!read_all(text.data(), bytes)) return false;
  strings.clear();
  for (std::size_t at = 0; at < text.size(); at += strings.back().size() + 1)
    strings.emplace_back(text.c_str() + at);
  return true;
}

void put(int descriptor, const char* path, int flags) {
  const int opened = ::open(path, flags, 0666);
  if (opened < 0 || ::dup2(opened, descriptor) < 0) _exit(126);
  ::close(opened);
}

void become(const std::string& user) {
  if (user.empty()) return;
  const auto id = static_cast<uid_t>(std::strtoul(user.c_str(), nullptr, 10));
  if (::setgroups(0, nullptr) != 0 || ::setgid(id) != 0 || ::setuid(id) != 0) _exit(126);
}

/// What main() of the program does.
int run(const std::vector<std::string>& arguments) {
  try {
    orbweave::handle_signals(stop);
    orbweave::parse_command_line(arguments, stop)();
    orbweave::flush_output();
    return 0;
  } catch (...) {
    const orbweave::Failure failure = orbweave::current_failure();
    orbweave::print_error(failure.what);
    return static_cast<int>(orbweave::exit_status(failure.kind));
  }
}

[[noreturn]] void be_child(const std::vector<std::string>& request) {
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  put(STDIN_FILENO, "/dev/null", O_RDONLY);
  put(STDOUT_FILENO, request[1].c_str(), O_WRONLY | O_CREAT | O_TRUNC);
  put(STDERR_FILENO, request[2].c_str(), O_WRONLY | O_CREAT | O_TRUNC);
  if (::chdir(request[0].c_str()) != 0) _exit(126);
  become(request[3]);
  const int status = run({request.begin() + 5, request.end()});
  std::fflush(nullptr);
  _exit(status);  // threads of libraries, which their destructors would wait for, are the parent's
}

/// Waits for the child's end, or kills it when its time is over.
Answer await(pid_t child, long seconds) {
  sigset_t ended;
  sigemptyset(&ended);
  sigaddset(&ended, SIGCHLD);
  Answer answer;
  int status = 0;
  rusage usage{};
  const std::time_t end = std::time(nullptr) + seconds;
  while (::wait4(child, &status, WNOHANG, &usage) == 0) {
    if (answer.late == 0 && std::time(nullptr) > end) {
      answer.late = 1;
      ::kill(child, SIGKILL);
    }
    const timespec moment{1, 0};
    ::sigtimedwait(&ended, nullptr, &moment);
  }
  const auto seconds_of = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  answer.status = WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
  answer.cpu_seconds = seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
  answer.peak_kib = usage.ru_maxrss;
  return answer;
}

}  // namespace

int main() {
  orbweave::close_hdf5_at_exit();
  sigset_t ended;
  sigemptyset(&ended);
  sigaddset(&ended, SIGCHLD);
  sigprocmask(SIG_BLOCK, &ended, nullptr);
  std::vector<std::string> request;
  while (read_request(request)) {
    const pid_t child = ::fork();
    if (child < 0) return 1;
    if (child == 0) be_child(request);
    const Answer answer = await(child, std::strtol(request[4].c_str(), nullptr, 10));
    if (::write(STDOUT_FILENO, &answer, sizeof answer) != sizeof answer) return 1;
  }
  return 0;
}
