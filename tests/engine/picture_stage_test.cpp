// The picture of a job: what its colours tell, whatever the job was cut into.
#include "engine/pipeline/output/picture_stage.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "tests/support/jobs.h"

namespace orbweave {
namespace {

using test::bytes_of;
using test::job_for;
using test::NamedCloud;
using test::run;
using test::ScratchDirectory;

/// Two tori beside each other, the second one with a gap that is filled.
NamedCloud two_tori(bool painted) {
  NamedCloud named = test::noisy_torus(1500, 0.0, 7);
  if (painted) test::paint(named.cloud);
  const PointCloud one = named.cloud;
  const double extent = one.bounds().extent().x, gap = 3.0 * named.ball_radius;
  const Vec3 corner = one.positions.front();
  PointCloud other;
  other.schema = one.schema;
  for (std::size_t i = 0; i < one.size(); ++i)
    if (norm(one.positions[i] - corner) > gap) other.append(one, i);
  for (Vec3& p : other.positions) p.x += 1.5 * extent;
  named.cloud.append(other);
  return named;
}

Job picture_job(const ScratchDirectory& scratch, const NamedCloud& named, PictureColors colors) {
  Job job = job_for(scratch, named);
  job.output.picture = (scratch / "mesh.png").string();
  job.output.picture_colors = colors;
  return job;
}

TEST_CASE("PicturesOfEveryColouringAreTheSameInAnyCut") {
  const NamedCloud named = two_tori(true);
  const PictureColors colors =
      GENERATE(PictureColors::kPatches, PictureColors::kPoints, PictureColors::kComponent);
  std::optional<std::string> first;
  for (const std::uint64_t chunk_points : {300u, 1'000'000u}) {
    const ScratchDirectory scratch;
    Job job = picture_job(scratch, named, colors);
    job.partition.chunk_points = chunk_points;
    const RunReport report = run(job);
    CHECK(report.mesh.components == 2);
    CHECK(report.holes.size() >= 1);
    const std::string bytes = bytes_of(job.output.picture);
    if (first) CHECK(bytes == *first);
    first = bytes;
  }
}

/// Half of a sphere, as a scanner on that side of it sees it: on that of the eye, or on the other.
NamedCloud half_sphere(bool is_before) {
  NamedCloud half = test::random_sphere(3000, 5);
  const double middle = half.cloud.bounds().center().z;
  PointCloud kept;
  kept.schema = half.cloud.schema;
  for (std::size_t i = 0; i < half.cloud.size(); ++i)
    if ((half.cloud.positions[i].z > middle) == is_before) kept.append(half.cloud, i);
  half.cloud = kept;
  return half;
}

TEST_CASE("WhatWasScannedFromTheOtherSideIsSeenFromThere") {
  const bool is_before = GENERATE(true, false);
  const NamedCloud named = half_sphere(is_before);
  std::optional<std::string> first;
  for (const std::uint64_t chunk_points : {300u, 1'000'000u}) {
    const ScratchDirectory scratch;
    Job job = picture_job(scratch, named, PictureColors::kPatches);
    job.output.picture_up = UpAxis::kY;
    job.partition.chunk_points = chunk_points;
    run(job);
    const std::string seen = bytes_of(job.output.picture);
    if (first) CHECK(seen == *first);
    first = seen;
    job.output.picture_backs = PictureBacks::kShown;  // always from the same side
    run(job);
    CHECK((bytes_of(job.output.picture) == seen) == is_before);
  }
}

/// One scan of a scanner at the origin, in one column.
void write_ptx(const std::filesystem::path& file, const PointCloud& cloud) {
  std::ofstream out(file);
  out << "1\n" << cloud.size() << "\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  out << "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  for (const Vec3& p : cloud.positions) out << p.x << ' ' << p.y << ' ' << p.z << " 0.5\n";
}

TEST_CASE("ScansThatAPatternNamesAreDrawnAsThoseOfTheirNames") {
  const ScratchDirectory scratch;
  const NamedCloud named = test::random_sphere(1500, 5);
  const std::filesystem::path site = scratch / "site";
  std::filesystem::create_directory(site);
  write_ptx(site / "scan.ptx", named.cloud);
  Job job = picture_job(scratch, named, PictureColors::kPatches);
  job.input.files = {(site / "scan.ptx").string()};
  run(job);
  const std::string by_name = bytes_of(job.output.picture);
  job.input.files = {(site / "*").string()};
  run(job);
  CHECK(bytes_of(job.output.picture) == by_name);
  job.output.picture_up = UpAxis::kY;  // as the shape alone would have it
  run(job);
  CHECK(bytes_of(job.output.picture) != by_name);
}

TEST_CASE("PointsThatNoTriangleUsesTakeNoRoomInThePicture") {
  NamedCloud named = test::noisy_torus(1500, 0.0, 7);
  const ScratchDirectory scratch;
  Job job = picture_job(scratch, named, PictureColors::kPatches);
  run(job);
  const std::string alone = bytes_of(job.output.picture);
  // Pairs of points make no triangle.
  const double extent = named.cloud.bounds().extent().x;
  for (const Vec3 far : {Vec3{20.0 * extent, 0.0, 0.0}, Vec3{0.0, -30.0 * extent, extent}}) {
    named.cloud.append(named.cloud, 0);
    named.cloud.positions.back() = named.cloud.positions.front() + far;
  }
  const ScratchDirectory other;
  Job with_strays = picture_job(other, named, PictureColors::kPatches);
  with_strays.input.keep_strays = true;
  const RunReport report = run(with_strays);
  CHECK(report.points_unused == 2);
  CHECK(bytes_of(with_strays.output.picture) == alone);
}

TEST_CASE("ColoursOfAScanThatHasNoneAreSaidToBeMissing") {
  const ScratchDirectory scratch;
  const NamedCloud named = two_tori(false);
  Job job = picture_job(scratch, named, PictureColors::kPoints);
  const RunReport report = run(job);
  const auto says_so = [](const std::string& note) {
    return note.find("neither colours nor an intensity") != std::string::npos;
  };
  CHECK(std::ranges::any_of(report.notes, says_so));
  const std::string bytes = bytes_of(job.output.picture);
  job.output.picture_colors = PictureColors::kPatches;
  run(job);
  CHECK(bytes_of(job.output.picture) == bytes);
}

}  // namespace
}  // namespace orbweave
