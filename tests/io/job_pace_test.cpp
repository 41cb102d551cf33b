// Share and time left of a job, from what its stages typically take and took.
#include "io/report/job_pace.h"

#include <catch2/catch.hpp>
#include <vector>

namespace orbweave {
namespace {

const std::vector<ExpectedStage> kStagesOfJob = {
    {"count", 1.0}, {"bin", 1.0}, {"reconstruct", 6.0}, {"holes", 2.0}};

TEST_CASE("NothingIsSaidOfTheJobBeforeItsStagesAreKnown") {
  JobPace pace(5.0);
  CHECK_FALSE(pace.is_known());
  pace.begin_stage("count", 5.0);
  CHECK_FALSE(pace.is_known());
  pace.expect(kStagesOfJob);
  CHECK(pace.is_known());
}

TEST_CASE("StagesThatTakeWhatTheyAreExpectedToGiveTheTimeThatIsLeft") {
  JobPace pace(100.0);
  pace.begin_stage("count", 100.0);
  pace.expect(kStagesOfJob);  // the present stage and those before it are passed over
  pace.end_stage(101.0);
  pace.begin_stage("bin", 101.0);
  pace.end_stage(102.0);
  const JobPace::Estimate before = pace.at(102.0, 0, 0);
  CHECK(before.elapsed == Approx(2.0));
  CHECK(before.seconds_left == Approx(8.0));
  CHECK(before.share() == Approx(0.2));
  CHECK(before.percent() == 20);
  pace.begin_stage("reconstruct", 102.0);
  CHECK(pace.at(105.0, 8, 16).seconds_left == Approx(5.0));
  pace.end_stage(108.0);
  pace.begin_stage("holes", 108.0);
  CHECK(pace.at(109.0, 0, 0).seconds_left == Approx(1.0));
  pace.end_stage(110.0);
  CHECK(pace.at(110.0, 0, 0).seconds_left == 0.0);
  CHECK(pace.at(110.0, 0, 0).percent() == 99);
}

TEST_CASE("AStageOwnRateCountsOnceItIsKnown") {
  JobPace pace;
  pace.expect(kStagesOfJob);
  pace.begin_stage("reconstruct", 0.0);
  CHECK(pace.at(30.0, 1, 4).seconds_left == Approx(90.0 + 2.0));
  CHECK(pace.at(30.0, 3, 4).seconds_left == Approx(10.0 + 2.0));
}

TEST_CASE("ASlowMachineIsSlowInTheStagesToComeToo") {
  JobPace pace;
  pace.expect(kStagesOfJob);
  pace.begin_stage("count", 0.0);
  pace.end_stage(10.0);
  pace.begin_stage("bin", 10.0);
  pace.end_stage(20.0);
  // Ten times as slow for a fifth of the work: the forecast is between both, and nearer to that.
  const double left = pace.at(20.0, 0, 0).seconds_left;
  CHECK(left > 8.0 * 4.0);
  CHECK(left < 80.0);
}

TEST_CASE("StagesThatDoNotRunAndStagesThatNobodyExpectedDoNoHarm") {
  JobPace pace;
  pace.expect(kStagesOfJob);
  pace.begin_stage("stitch", 0.0);
  CHECK(pace.at(0.5, 1, 2).seconds_left > 9.0);
  pace.end_stage(1.0);
  pace.begin_stage("holes", 1.0);  // count, bin and reconstruct are passed over
  CHECK(pace.at(1.0, 0, 0).seconds_left == Approx(2.0));
}

TEST_CASE("ANewForecastReplacesTheOld") {
  JobPace pace;
  pace.expect(kStagesOfJob);
  pace.begin_stage("reconstruct", 0.0);
  pace.end_stage(6.0);
  const std::vector<ExpectedStage> more = {{"reconstruct", 6.0}, {"holes", 20.0}};
  pace.expect(more);
  CHECK(pace.at(6.0, 0, 0).seconds_left == Approx(20.0));
}

}  // namespace
}  // namespace orbweave
