// A program that uses the library finds its own settings as it left them.
#include <hdf5.h>
#include <signal.h>
#include <tbb/global_control.h>

#include <Eigen/Core>
#include <algorithm>
#include <catch2/catch.hpp>
#include <clocale>
#include <string>
#include <vector>

#include "engine/reconstruct.h"
#include "tests/support/jobs.h"

using namespace orbweave;
using namespace orbweave::test;

namespace {

struct EigenCaches {
  std::ptrdiff_t l1 = 0, l2 = 0, l3 = 0;
  friend bool operator==(const EigenCaches&, const EigenCaches&) = default;
};

EigenCaches eigen_caches() {
  EigenCaches caches;
  Eigen::internal::manage_caching_sizes(Eigen::GetAction, &caches.l1, &caches.l2, &caches.l3);
  return caches;
}

std::size_t tbb_limit() {
  return tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
}

/// A cloud with a hole that takes a linear system to close.
PointCloud holed_torus() {
  const PointCloud whole = noisy_torus(6000, 0.1, 3).cloud;
  PointCloud rest;
  rest.schema = whole.schema;
  for (std::size_t i = 0; i < whole.size(); ++i)
    if (norm(whole.positions[i] - Vec3{1.4, 0.0, 0.0}) > 0.3) rest.append(whole, i);
  return rest;
}

}  // namespace

TEST_CASE("TheCacheSizesOfTheHostsEigenStayAsTheyAre") {
  Eigen::setCpuCacheSizes(11 << 10, 222 << 10, 3333 << 10);
  const EigenCaches before = eigen_caches();
  const Reconstruction result = reconstruct(holed_torus());
  CHECK(std::any_of(result.holes.begin(), result.holes.end(),
                    [](const HoleFacts& hole) { return hole.sites > 0; }));
  CHECK(eigen_caches() == before);
}

TEST_CASE("TheThreadsOfTheHostsTbbStayAsTheyAre") {
  const std::size_t before = tbb_limit();
  std::size_t within = 0;
  ReconstructionOptions options;
  options.threads = 7;
  options.progress = [&](std::string_view, double) { within = std::max(within, tbb_limit()); };
  reconstruct(noisy_torus(2000, 0.1, 3).cloud, options);
  CHECK(within == before);
  ScratchDirectory scratch;
  Job job = job_for(scratch, noisy_torus(2000, 0.1, 3));
  job.run.threads = 7;
  RecordingProgress progress;
  progress.at_step = [&] { within = std::max(within, tbb_limit()); };
  run_job(job, {}, progress, StopToken());
  CHECK(within == before);
  CHECK(tbb_limit() == before);
}

namespace {

herr_t hosts_handler(hid_t, void*) { return 0; }

}  // namespace

TEST_CASE("TheErrorHandlerOfTheHostsHdf5StaysAsItIs") {
  H5E_auto2_t usual = nullptr;
  void* usual_data = nullptr;
  H5Eget_auto2(H5E_DEFAULT, &usual, &usual_data);
  int data = 0;
  H5Eset_auto2(H5E_DEFAULT, hosts_handler, &data);
  ScratchDirectory scratch;
  run(job_for(scratch, noisy_torus(2000, 0.1, 3)));
  H5E_auto2_t handler = nullptr;
  void* handler_data = nullptr;
  H5Eget_auto2(H5E_DEFAULT, &handler, &handler_data);
  CHECK(handler == hosts_handler);
  CHECK(handler_data == &data);
  H5Eset_auto2(H5E_DEFAULT, usual, usual_data);
}

TEST_CASE("TheSignalHandlersAndLocaleOfTheHostStayAsTheyAre") {
  const std::string locale = std::setlocale(LC_ALL, nullptr);
  std::vector<void (*)(int)> before;
  constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXFSZ, SIGABRT};
  const auto handler_of = [](int signal) {
    struct sigaction action {};
    sigaction(signal, nullptr, &action);
    return action.sa_handler;
  };
  for (const int signal : kSignals) before.push_back(handler_of(signal));
  ScratchDirectory scratch;
  RecordingProgress progress;
  std::size_t changed = 0;
  progress.at_step = [&] {
    for (std::size_t i = 0; i < before.size(); ++i)
      changed += handler_of(kSignals[i]) == before[i] ? 0 : 1;
  };
  run_job(job_for(scratch, noisy_torus(2000, 0.1, 3)), {}, progress, StopToken());
  reconstruct(noisy_torus(2000, 0.1, 3).cloud);
  progress.at_step();
  CHECK(changed == 0);
  CHECK(std::setlocale(LC_ALL, nullptr) == locale);
}
