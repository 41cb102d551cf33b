#include "io/report/progress.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "io/report/progress_display.h"

namespace orbweave {
namespace {

/// A display on a string, with a clock that the test turns.
struct Fixture {
  explicit Fixture(bool moving_line, int columns = 200, bool colour = false)
      : display(std::make_unique<ProgressDisplay>(out, options(moving_line, columns, colour))) {}

  ProgressDisplayOptions options(bool moving_line, int columns, bool colour) {
    ProgressDisplayOptions result;
    result.moving_line = moving_line;
    result.columns = columns;
    result.colour = colour;
    result.clock = [this] { return seconds; };
    return result;
  }
  std::vector<std::string> lines() const {
    std::vector<std::string> result;
    std::istringstream text(out.str());
    for (std::string line; std::getline(text, line);) result.push_back(line);
    return result;
  }
  /// What a terminal shows in the end: lines whole, the last one as far as it was drawn.
  std::vector<std::string> screen() const {
    std::vector<std::string> result(1);
    const std::string text = out.str();
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text.compare(i, 4, "\r\033[K") == 0) {
        result.back().clear();
        i += 3;
      } else if (text[i] == '\n') {
        result.emplace_back();
      } else {
        result.back() += text[i];
      }
    }
    return result;
  }

  double seconds = 100.0;
  std::ostringstream out;
  std::unique_ptr<ProgressDisplay> display;
};

using Catch::Contains;
using Catch::StartsWith;

TEST_CASE("PlainProgressHasALinePerStageBeginTenthAndEnd") {
  Fixture f(false);
  f.display->begin_stage("bin", 1000, "points");
  for (int i = 0; i < 100; ++i) {
    f.seconds += 0.1;
    f.display->advance(10);
  }
  f.display->end_stage();
  const auto lines = f.lines();
  REQUIRE(lines.size() == 11);
  CHECK(lines[0] == "bin: begins, 1,000 points");
  CHECK_THAT(lines[1], StartsWith("bin: 100 / 1,000 points (10 %), 100 points/s, "));
  CHECK_THAT(lines[2], Contains(" MiB, 8.0 s left"));
  CHECK_THAT(lines[9], StartsWith("bin: 900 / 1,000 points (90 %), "));
  CHECK_THAT(lines[10], StartsWith("bin: done in 10 s, 1,000 points, 100 points/s, "));
}

TEST_CASE("PlainProgressSkipsTenthsThatPassAtOnce") {
  Fixture f(false);
  f.display->begin_stage("reconstruct", 3, "chunks");
  f.seconds += 2.0;
  f.display->add_points(5'000'000);
  f.display->advance(2);
  f.display->advance(1);
  f.display->end_stage();
  const auto lines = f.lines();
  REQUIRE(lines.size() == 3);
  CHECK(lines[0] == "reconstruct: begins, 3 chunks");
  CHECK_THAT(lines[1], StartsWith("reconstruct: 2 / 3 chunks (66 %), 2.50M points/s, "));
  CHECK_THAT(lines[2], StartsWith("reconstruct: done in 2.0 s, 3 chunks, 2.50M points/s, "));
}

TEST_CASE("PlainProgressOfUnknownLengthSpeaksNowAndThen") {
  Fixture f(false);
  f.display->begin_stage("count", 0, "points");
  for (int i = 0; i < 25; ++i) {
    f.seconds += 1.0;
    f.display->advance(1000);
  }
  f.display->end_stage();
  const auto lines = f.lines();
  REQUIRE(lines.size() == 4);
  CHECK(lines[0] == "count: begins");
  CHECK_THAT(lines[1], StartsWith("count: 10,000 points, 1.00k points/s, "));
  CHECK_THAT(lines[2], StartsWith("count: 20,000 points, "));
}

TEST_CASE("AStageThatAnErrorEndsIsNotDone") {
  Fixture f(false);
  struct Stage {
    explicit Stage(ProgressDisplay& shown) : display(shown) {
      display.begin_stage("picture", 4, "chunks");
    }
    ~Stage() { display.end_stage(); }
    ProgressDisplay& display;
  };
  const auto draw = [&] {
    const Stage stage(*f.display);
    f.display->advance(1);
    f.seconds += 2.0;
    throw std::runtime_error("interrupted");
  };
  CHECK_THROWS_AS(draw(), std::runtime_error);
  CHECK_THAT(f.lines().back(), StartsWith("picture: stopped after 2.0 s, 1 chunk, "));
}

TEST_CASE("ASecondStageEndsTheFirst") {
  Fixture f(false);
  f.display->begin_stage("a", 0, "chunks");
  f.display->begin_stage("b", 0, "chunks");
  f.display->end_stage();
  f.display->end_stage();
  REQUIRE(f.lines().size() == 4);
  CHECK_THAT(f.lines()[1], StartsWith("a: done in "));
  CHECK(f.lines()[2] == "b: begins");
}

TEST_CASE("TheMovingLineShowsStageAmountRateMemoryAndTimeLeft") {
  Fixture f(true);
  f.display->begin_stage("reconstruct", 64, "chunks");
  f.seconds += 10.0;
  f.display->add_points(12'300'000);
  f.display->advance(16);
  f.seconds += 1.0;
  f.display->advance(0);
  CHECK_THAT(f.screen().back(),
             StartsWith("0:11  reconstruct: 16 / 64 chunks (25 %), 1.12M points/s, ") &&
                 Contains("iB, 33 s left"));
  CHECK(f.screen().size() == 1);
}

TEST_CASE("TheMovingLineShowsShareAndTimeLeftOfTheJobOnceItsStagesAreKnown") {
  Fixture f(true);
  const std::vector<ExpectedStage> stages = {
      {"count", 10.0}, {"reconstruct", 20.0}, {"holes", 10.0}};
  f.display->begin_stage("count", 64, "points");
  f.display->expect(stages);
  f.seconds += 10.0;
  f.display->end_stage();
  f.display->begin_stage("reconstruct", 64, "chunks");
  f.seconds += 10.0;
  f.display->advance(32);
  CHECK_THAT(f.screen().back(),
             StartsWith("0:20  job 50 %, 20 s left  reconstruct: 32 / 64 chunks (50 %), "));
}

TEST_CASE("NothingIsSaidOfTheJobInItsFirstSecond") {
  Fixture f(true);
  f.display->expect(std::vector<ExpectedStage>{{"count", 0.1}, {"reconstruct", 0.1}});
  f.display->begin_stage("count", 64, "points");
  f.seconds += 0.5;
  f.display->advance(32);
  CHECK_THAT(f.screen().back(), StartsWith("0:00  count: 32 / 64 points"));
  f.seconds += 1.0;
  f.display->advance(1);
  CHECK_THAT(f.screen().back(), StartsWith("0:01  job "));
}

TEST_CASE("PlainLinesEndWithShareAndTimeLeftOfTheJob") {
  Fixture f(false);
  const std::vector<ExpectedStage> stages = {{"reconstruct", 20.0}, {"holes", 10.0}};
  f.display->expect(stages);
  f.display->begin_stage("reconstruct", 64, "chunks");
  f.seconds += 10.0;
  f.display->advance(32);
  CHECK_THAT(f.lines().back(), Contains("iB, job 33 %, 20 s left"));
}

TEST_CASE("TheMovingLineIsRedrawnTenTimesASecondAtMost") {
  Fixture f(true);
  f.display->begin_stage("bin", 1'000'000, "points");
  for (int i = 0; i < 1'000'000; ++i) {
    f.seconds += 1e-6;
    f.display->advance(1);
  }
  const std::string text = f.out.str();
  int drawn = 0;
  for (std::size_t at = text.find("bin:"); at != std::string::npos; at = text.find("bin:", at + 1))
    ++drawn;
  CHECK(drawn >= 9);
  CHECK(drawn <= 11);
}

TEST_CASE("TheMovingLineShowsMinutesSinceTheStartAndNotSinceTheStage") {
  Fixture f(true);
  f.seconds += 125.0;
  f.display->begin_stage("sort", 4, "chunks");
  f.seconds += 3600.0;
  f.display->advance(1);
  CHECK_THAT(f.screen().back(), StartsWith("62:05  sort: 1 / 4 chunks (25 %)"));
}

TEST_CASE("TheMovingLineMovesWithoutProgress") {
  std::ostringstream out;
  ProgressDisplayOptions options;
  options.moving_line = true;
  options.columns = 200;
  options.still_seconds = 0.01;
  options.redraw_seconds = 0.0;
  {
    ProgressDisplay display(out, options);
    display.begin_stage("reconstruct", 1, "chunks");
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    display.end_stage();
  }
  const std::string text = out.str();
  CHECK_THAT(text, Contains("reconstruct: 0 / 1 chunk (0 %)"));
  CHECK(text.find("0:00  reconstruct") != text.rfind("0:00  reconstruct"));
}

TEST_CASE("NotesAndWarningsStandOnLinesOfTheirOwnAboveTheMovingLine") {
  Fixture f(true);
  f.display->begin_stage("bin", 100, "points");
  f.seconds += 1.0;
  f.display->advance(50);
  f.display->note("radius 0.0015: 1.3 spacings");
  f.display->warn("3 points dropped");
  const auto screen = f.screen();
  REQUIRE(screen.size() == 3);
  CHECK(screen[0] == "radius 0.0015: 1.3 spacings");
  CHECK(screen[1] == "orbweave: warning: 3 points dropped");
  CHECK_THAT(screen[2], StartsWith("0:01  bin: 50 / 100 points (50 %)"));
  f.display->end_stage();
  CHECK(f.screen().back().empty());
}

TEST_CASE("TheMovingLineStaysWithinTheTerminalAndLeavesNothingBehind") {
  Fixture f(true, 20);
  f.display->begin_stage("a stage with a long name", 100, "points");
  f.seconds += 1.0;
  f.display->advance(50);
  CHECK(f.screen().back() == "0:01  a stage with ");
  f.display.reset();
  CHECK(f.screen() == std::vector<std::string>{""});
}

TEST_CASE("ColourOnlyWhereItIsAskedFor") {
  Fixture plain(false), colour(false, 200, true);
  plain.display->warn("w");
  colour.display->warn("w");
  CHECK(plain.out.str() == "orbweave: warning: w\n");
  CHECK(colour.out.str() == "orbweave: \033[1;33mwarning: \033[0mw\n");
}

TEST_CASE("ProgressFromManyThreadsAddsUp") {
  std::ostringstream out;
  {
    ProgressDisplay display(out, {});
    display.begin_stage("work", 40'000, "chunks");
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&] {
        for (int i = 0; i < 10'000; ++i) {
          display.advance(1);
          if (i % 5000 == 0) display.note("note");
        }
      });
    for (std::thread& thread : threads) thread.join();
    display.end_stage();
  }
  std::istringstream text(out.str());
  int notes = 0, tenths = 0;
  std::string last;
  for (std::string line; std::getline(text, line); last = line) {
    notes += line == "note";
    tenths += line.find(" / 40,000 chunks (") != std::string::npos;
  }
  CHECK(notes == 8);
  CHECK(tenths >= 1);
  CHECK(tenths <= 9);
  CHECK_THAT(last, StartsWith("work: done in ") && Contains(", 40,000 chunks, "));
}

TEST_CASE("EveryStyleMakesADisplay") {
  for (const ProgressStyle style :
       {ProgressStyle::kAuto, ProgressStyle::kPlain, ProgressStyle::kNone, ProgressStyle::kSilent})
    CHECK(make_progress(style) != nullptr);
}

TEST_CASE("WithoutProgressWarningsAreSeenAndNothingElse") {
  const ProgressStyle style = GENERATE(ProgressStyle::kNone, ProgressStyle::kSilent);
  std::ostringstream seen;
  std::streambuf* const before = std::cerr.rdbuf(seen.rdbuf());
  const auto progress = make_progress(style);
  progress->begin_stage("a", 1, "points");
  progress->advance(1);
  progress->note("must not be seen");
  progress->warn("work stays");
  progress->end_stage();
  std::cerr.rdbuf(before);
  CHECK(seen.str() == (style == ProgressStyle::kNone ? "orbweave: warning: work stays\n" : ""));
}

}  // namespace
}  // namespace orbweave
