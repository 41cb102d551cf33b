// Shows what a reconstruction is at, and stops it: here after the normals are estimated. In a
// program with a window another thread would call stop.request().
#include <orbweave/reconstruct.h>

#include <cstdio>
#include <string_view>

namespace {

/// A sheet of points over the square from -1 to 1.
orbweave::PointCloud wavy_sheet(int side) {
  orbweave::PointCloud cloud;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const double x = 2.0 * i / side - 1.0, y = 2.0 * j / side - 1.0;
      cloud.positions.push_back({x, y, 0.2 * x * x - 0.1 * x * y});
    }
  }
  return cloud;
}

}  // namespace

int main() {
  orbweave::StopToken stop;
  orbweave::ReconstructionOptions options;
  options.stop = &stop;
  options.progress = [&](std::string_view stage, double done) {
    std::printf("%3.0f %% %.*s\n", 100.0 * done, static_cast<int>(stage.size()), stage.data());
    if (stage == "reconstruct") stop.request();
  };
  try {
    orbweave::reconstruct(wavy_sheet(60), options);
  } catch (const orbweave::Error& error) {
    std::printf("%s\n", error.what());
    return error.kind() == orbweave::ErrorKind::kInterrupted ? 0 : 1;
  }
  return 1;
}
