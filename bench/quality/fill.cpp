// Accuracy and cost of the hole pass, beside CGAL's hole filling; JSON lines out.
// bench/quality/fill.py drives it. One thread unless asked for more: the peer has one. usage:
// bench_fill discs|heights|cost MESH [OPTIONS]
#include <oneapi/tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "bench/quality/fill_workloads.h"
#include "io/error.h"

namespace {

namespace bench = orbweave::bench;

void add_discs(CLI::App& app, bench::DiscWorkload& work) {
  CLI::App& command = *app.add_subcommand("discs", "delete and refill, beside CGAL");
  command.add_option("MESH", work.mesh)->required();
  command.add_option("--radii", work.radii_spacings, "spacings")->delimiter(',');
  command.add_option("--count", work.count, "discs of each radius");
  command.add_option("--seed", work.seed);
  command.add_option("--centers", work.centers, "vertices, instead of random ones")->delimiter(',');
  command.add_option("--cases", work.cases, "directory for meshes of the holes");
  command.add_option("--kernel", work.kernel);
  command.add_option("--neighborhood", work.neighborhood, "times the hole's radius");
  command.add_option("--cgal-continuity", work.cgal_continuity, "of its fairing, 1");
  command.callback([&work] { bench::run_discs(work); });
}

void add_heights(CLI::App& app, bench::HeightWorkload& work) {
  CLI::App& command = *app.add_subcommand("heights", "height errors of removed points");
  command.add_option("MESH", work.mesh)->required();
  command.add_option("--places", work.places, "x,y,z of each hole")->delimiter(',')->required();
  command.add_option("--radius", work.radius, "of the hole, world units");
  command.add_option("--neighborhoods", work.neighborhood_radii, "world units")->delimiter(',');
  command.add_option("--kernel", work.kernel);
  command.callback([&work] { bench::run_heights(work); });
}

void add_cost(CLI::App& app, bench::CostWorkload& work) {
  CLI::App& command = *app.add_subcommand("cost", "seconds by number and size of holes");
  command.add_option("MESH", work.mesh)->required();
  command.add_option("--radius", work.radius_spacings, "of the discs, spacings");
  command.add_option("--count", work.count, "discs");
  command.add_option("--seed", work.seed);
  command.add_option("--repeats", work.repeats);
  command.callback([&work] { bench::run_cost(work); });
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Accuracy and cost of the hole pass");
  app.require_subcommand(1);
  bench::DiscWorkload discs;
  bench::HeightWorkload heights;
  bench::CostWorkload cost;
  std::size_t threads = 1;
  std::unique_ptr<tbb::global_control> limit;
  app.add_option("--threads", threads, "1");
  app.parse_complete_callback([&] {
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                  threads);
  });
  add_discs(app, discs);
  add_heights(app, heights);
  add_cost(app, cost);
  CLI11_PARSE(app, argc, argv);
  return 0;
} catch (const orbweave::Error& error) {
  std::fprintf(stderr, "bench_fill: %s\n", error.what());
  return static_cast<int>(error.kind());
}
