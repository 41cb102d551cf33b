// What a signal does to the process that asked for it.
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

#include "engine/cli/failure.h"
#include "engine/cli/signals.h"
#include "io/error.h"
#include "io/system/atomic_file.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

namespace {

/// Exit status of a child process that runs `body` and then exits with what it returned.
/// `ignored`: a signal that does nothing before; 0: all do what they do by default.
int status_of_child(const std::function<int(orbweave::StopToken&)>& body, int ignored = 0) {
  const pid_t child = fork();
  if (child == 0) {
    static orbweave::StopToken stop;
    for (const int signal : orbweave::kStopSignals)
      ::signal(signal, signal == ignored ? SIG_IGN : SIG_DFL);
    orbweave::handle_signals(stop);
    _exit(body(stop));
  }
  int state = 0;
  REQUIRE(waitpid(child, &state, 0) == child);
  return WIFEXITED(state) ? WEXITSTATUS(state) : -1;
}

void without_catching(const std::function<void()>& work) noexcept { work(); }

}  // namespace

TEST_CASE("FirstSignalOnlyAsksToStop") {
  const int signal = GENERATE(from_range(orbweave::kStopSignals));
  CHECK(status_of_child([signal](orbweave::StopToken& stop) {
          if (stop.requested()) return 1;
          raise(signal);
          return stop.requested() ? 0 : 2;
        }) == 0);
}

TEST_CASE("WhatNohupOrAScriptStartsInTheBackgroundGoesOnAfterASignalThatIsIgnored") {
  const int signal = GENERATE(from_range(orbweave::kStopSignals));
  CHECK(status_of_child(
            [signal](orbweave::StopToken& stop) {
              raise(signal);
              return stop.requested() ? 1 : 0;
            },
            signal) == 0);
}

TEST_CASE("OnlyCommandsThatResumeSaySo") {
  const auto said = [](bool resumes) {
    return status_of_child([resumes](orbweave::StopToken& stop) {
      if (resumes) orbweave::promise_to_resume();
      stop.request();
      try {
        stop.check();
      } catch (...) {
        const std::string what = orbweave::current_failure().what;
        const bool promises = what.find("the same command resumes") != std::string::npos;
        const bool tells = what == "interrupted; nothing was written";
        return promises == resumes && tells != resumes ? 0 : 2;
      }
      return 1;
    });
  };
  CHECK(said(false) == 0);
  CHECK(said(true) == 0);
}

TEST_CASE("SecondSignalEndsTheProcessAtOnce") {
  CHECK(status_of_child([](orbweave::StopToken&) {
          raise(SIGINT);
          raise(SIGINT);
          return 1;
        }) == 130);
}

TEST_CASE("WhatLeavesNothingBehindIsEndedByTheFirstSignal") {
  const int signal = GENERATE(from_range(orbweave::kStopSignals));
  CHECK(status_of_child([signal](orbweave::StopToken&) {
          const orbweave::EndAtOnceOnSignals scope;
          raise(signal);
          return 1;
        }) == 130);
  CHECK(status_of_child([signal](orbweave::StopToken&) {
          raise(signal);
          const orbweave::EndAtOnceOnSignals scope;
          return 1;
        }) == 130);
}

TEST_CASE("AfterThatTheFirstSignalOnlyAsksToStopAgain") {
  CHECK(status_of_child([](orbweave::StopToken& stop) {
          { const orbweave::EndAtOnceOnSignals scope; }
          raise(SIGINT);
          return stop.requested() ? 0 : 1;
        }) == 0);
}

TEST_CASE("ClosedPipeIsAnErrorOfTheWriteAndNoDeath") {
  CHECK(status_of_child([](orbweave::StopToken&) {
          int ends[2];
          if (pipe(ends) != 0) return 1;
          close(ends[0]);
          return write(ends[1], "x", 1) == -1 ? 0 : 2;
        }) == 0);
}

TEST_CASE("WorkThatGoesOnAfterASignalIsLeftBehind") {
  const int signal = GENERATE(from_range(orbweave::kStopSignals));
  const orbweave::test::ScratchDirectory in;
  CHECK(status_of_child([signal, &in](orbweave::StopToken&) {
          orbweave::AtomicFile file(in / "out.ply");
          file.write(std::string("half"));
          raise(signal);
          for (int i = 0; i < 300; ++i) usleep(100'000);
          return 1;
        }) == 130);
  CHECK(orbweave::test::names_in(in).empty());
}

namespace {

/// What a process says that leaves a second after a signal.
std::string last_word_of(const std::function<void()>& work) {
  const orbweave::test::ScratchDirectory in;
  CHECK(status_of_child([&](orbweave::StopToken&) {
          const int file = open((in / "said").c_str(), O_WRONLY | O_CREAT, 0600);
          dup2(file, STDERR_FILENO);
          work();
          raise(SIGTERM);
          for (int i = 0; i < 300; ++i) usleep(100'000);
          return 1;
        }) == 130);
  return orbweave::test::file_text(in / "said");
}

}  // namespace

TEST_CASE("TheLastWordSaysWhatWasWritten") {
  CHECK(last_word_of([] {}) == "orbweave: error: interrupted; nothing was written\n");
  CHECK(last_word_of([] {
          orbweave::note_written("truth.ply");
          orbweave::note_written("w\x1b[2J.ply");
        }) == "orbweave: error: interrupted; written so far: truth.ply, w\\x1b[2J.ply\n");
}

TEST_CASE("AnInterruptionSaysWhatWasWritten") {
  CHECK(status_of_child([](orbweave::StopToken& stop) {
          orbweave::note_written("truth.ply");
          raise(SIGINT);
          try {
            orbweave::check_interruption(stop);
          } catch (const orbweave::Error& error) {
            return std::string(error.what()) == "interrupted; written so far: truth.ply" ? 0 : 2;
          }
          return 1;
        }) == 0);
}

TEST_CASE("NoAlarmEndsAProcessWhoseWorkIsOver", "[slow]") {
  CHECK(status_of_child([](orbweave::StopToken&) {
          raise(SIGTERM);
          orbweave::end_interruptible_work();
          for (int i = 0; i < 15; ++i) usleep(100'000);
          return 0;
        }) == 0);
  CHECK(status_of_child([](orbweave::StopToken&) {
          orbweave::end_interruptible_work();
          raise(SIGTERM);
          for (int i = 0; i < 15; ++i) usleep(100'000);
          return 0;
        }) == 0);
}

TEST_CASE("AnUncaughtRefusalOfTheSystemNamesItsCause") {
  const auto said_of = [](const std::function<void()>& work) {
    const orbweave::test::ScratchDirectory in;
    CHECK(status_of_child([&](orbweave::StopToken&) {
            const int file = open((in / "said").c_str(), O_WRONLY | O_CREAT, 0600);
            dup2(file, STDERR_FILENO);
            orbweave::end_plainly_when_nothing_catches();
            without_catching(work);
            return 1;
          }) == 4);
    return orbweave::test::file_text(in / "said");
  };
  const auto busy = std::make_error_code(std::errc::resource_unavailable_try_again);
  CHECK(said_of([&] { throw std::system_error(busy); }).find("no more threads") !=
        std::string::npos);
  const std::string files =
      said_of([&] { throw std::filesystem::filesystem_error("cannot list", "/some/place", busy); });
  CHECK(files.find("/some/place") != std::string::npos);
  CHECK(files.find("threads") == std::string::npos);
  const auto full = std::make_error_code(std::errc::no_space_on_device);
  CHECK(said_of([&] { throw std::system_error(full); }).find("threads") == std::string::npos);
}

TEST_CASE("AnUncaughtLackOfMemoryEndsPlainly") {
  CHECK(status_of_child([](orbweave::StopToken&) {
          orbweave::end_plainly_when_nothing_catches();
          without_catching([] { throw std::bad_alloc(); });
          return 1;
        }) == 4);
  CHECK(status_of_child([](orbweave::StopToken&) {
          orbweave::end_plainly_when_nothing_catches();
          without_catching([] { throw std::logic_error("wrong"); });
          return 0;
        }) == 1);
}
