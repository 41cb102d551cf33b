// What a signal does to the process that asked for it.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <functional>

#include "engine/cli/signals.h"

namespace {

/// Exit status of a child process that runs `body` and then exits with what it returned.
int status_of_child(const std::function<int(orbweave::StopToken&)>& body) {
  const pid_t child = fork();
  if (child == 0) {
    static orbweave::StopToken stop;
    orbweave::handle_signals(stop);
    _exit(body(stop));
  }
  int state = 0;
  REQUIRE(waitpid(child, &state, 0) == child);
  return WIFEXITED(state) ? WEXITSTATUS(state) : -1;
}

}  // namespace

TEST_CASE("FirstSignalOnlyAsksToStop") {
  const int signal = GENERATE(SIGINT, SIGTERM);
  CHECK(status_of_child([signal](orbweave::StopToken& stop) {
          if (stop.requested()) return 1;
          raise(signal);
          return stop.requested() ? 0 : 2;
        }) == 0);
}

TEST_CASE("SecondSignalEndsTheProcessAtOnce") {
  CHECK(status_of_child([](orbweave::StopToken&) {
          raise(SIGINT);
          raise(SIGINT);
          return 1;
        }) == 130);
}

TEST_CASE("WhatLeavesNothingBehindIsEndedByTheFirstSignal") {
  const int signal = GENERATE(SIGINT, SIGTERM);
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
