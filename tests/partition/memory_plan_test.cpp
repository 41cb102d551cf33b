// How the memory budget becomes a chunk size.
#include "partition/memory_plan.h"

#include <catch2/catch.hpp>

#include "io/error.h"

namespace orbweave {
namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
constexpr std::uint64_t kGiB = std::uint64_t{1} << 30;

PointSchema oriented() {
  PointSchema schema;
  schema.has_normals = true;
  return schema;
}

}  // namespace

TEST_CASE("ChunksInFlightFitTheBudget") {
  for (const std::uint64_t budget : {kGiB / 4, kGiB, 4 * kGiB}) {
    for (const int threads : {1, 2, 16}) {
      const MemoryPlan plan = plan_memory(budget, 1'000'000'000, threads, 0, oriented());
      INFO(budget << " bytes, " << threads << " threads");
      REQUIRE(plan.chunks_in_flight_bytes + MemoryCosts::kBaseBytes <= budget);
      REQUIRE(plan.bin_buffer_bytes + MemoryCosts::kBaseBytes <= budget);
      if (plan.chunk_points == 20'000) continue;  // never smaller; then fewer are in flight
      REQUIRE(plan.chunk_points * MemoryCosts::kReconstructBytes *
                  static_cast<std::uint64_t>(threads) <=
              plan.chunks_in_flight_bytes);
    }
  }
}

TEST_CASE("WideHalosMakeLargerChunksAsFarAsTheBudgetAllows") {
  const auto chunk_points = [](std::uint64_t budget, std::uint64_t worthwhile) {
    return plan_memory(budget, 400'000, 2, 0, oriented(), worthwhile).chunk_points;
  };
  REQUIRE(chunk_points(4 * kGiB, 0) == 50'001);
  REQUIRE(chunk_points(4 * kGiB, 300'000) == 300'000);
  REQUIRE(chunk_points(kGiB / 4, 300'000) < 300'000);
}

TEST_CASE("ATileWithWideHalosIsOneChunkAndNoChunkIsLargerThanFourMillionPoints") {
  const auto chunk_points = [](std::uint64_t points, std::uint64_t worthwhile) {
    return plan_memory(16 * kGiB, points, 2, 0, oriented(), worthwhile).chunk_points;
  };
  CHECK(chunk_points(1'050'000, 1'050'000) == 1'050'000);
  CHECK(chunk_points(100'000'000, 70'000) == 1'000'000);
  CHECK(chunk_points(100'000'000, 50'000'000) == 4'000'000);
}

TEST_CASE("AGivenChunkSizeIsTaken") {
  REQUIRE(plan_memory(kGiB, 1'000'000, 2, 1234, oriented(), 500'000).chunk_points == 1234);
}

TEST_CASE("CornersOfTheLargestChunkThatCanBeGivenAreNumberedWith32Bits") {
  const std::uint64_t most =
      plan_memory(1'000 * kGiB, 4'000'000'000, 2, 3'000'000'000, oriented()).chunk_points;
  CHECK(most == std::uint64_t{1} << 28);
  CHECK(3 * 2 * most < UINT32_MAX);
}

TEST_CASE("AGivenChunkSizeIsCappedWhereTheBudgetHasNoRoomForOneChunk") {
  const MemoryPlan plan = plan_memory(kGiB / 4, 1'000'000'000, 2, 1'000'000'000, oriented());
  REQUIRE(plan.chunk_points > 20'000);
  REQUIRE(plan.chunk_points * MemoryCosts::kReconstructBytes <= plan.chunks_in_flight_bytes);
  REQUIRE(plan.chunk_points * MemoryCosts::sort_bytes(oriented()) <=
          plan.chunks_in_flight_bytes / 2);
}

TEST_CASE("TheLeastBudgetIsTakenAndOneByteLessIsNot") {
  PointSchema wide = oriented();
  for (int i = 0; i < 40; ++i) wide.attributes.push_back({"a", ScalarType::kFloat64});
  for (const PointSchema& schema : {oriented(), wide}) {
    for (const int threads : {1, 2, 64}) {
      const std::uint64_t least = least_budget_bytes(schema, threads);
      CHECK_NOTHROW(plan_memory(least, 1'000'000, threads, 0, schema));
      CHECK_THROWS_AS(plan_memory(least - 1, 1'000'000, threads, 0, schema), Error);
    }
  }
  CHECK(least_budget_bytes(oriented(), 64) > least_budget_bytes(oriented(), 1));
  CHECK(least_budget_bytes(wide, 2) > least_budget_bytes(oriented(), 2));
}

TEST_CASE("ABudgetBelowWhatTheProgramNeedsSaysHowMuchThatIs") {
  try {
    plan_memory(kGiB / 16, 1000, 1, 0, oriented());
    FAIL("no error");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kResource);
    const std::uint64_t least = least_budget_bytes(oriented(), 1);
    const std::string expected = "at least " + std::to_string((least + kMiB - 1) / kMiB) + " MiB";
    CHECK(std::string(error.what()).find(expected) != std::string::npos);
  }
}

}  // namespace orbweave
