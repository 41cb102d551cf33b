// Scanners in a scene: tripods in a room, which sweep rays in equal steps of both angles, a depth
// camera in several places of it, and lines of flight over a house, with all that such scans bring
// along: places that no scanner sees, dense feet of tripods and sparse walls far away, panes
// without returns, pixels that mix two surfaces, a person who walks through two scans, leaves of
// trees with returns from below them.
//
// The same options give the same bits on every machine and for every batch size.
#pragma once

#include <cstdint>
#include <memory>

#include "engine/synthetic/range_scans.h"
#include "engine/synthetic/scene.h"
#include "io/scalar_types.h"

namespace orbweave {

struct SceneScannerOptions {
  SceneKind scene = SceneKind::kRoom;
  std::uint64_t points = 1'000'000;  ///< about, of all scans together (within 5 %); at least 1,000
  /// Standard deviation along the ray, in units of spacing(); >= 0. Nearly Gaussian.
  double noise = 0.0;
  /// The deviation grows with this power of the distance, 0 to 2; `noise` is that at the mean of
  /// the distances.
  int noise_growth = 0;
  /// Mixed pixels, a person who walks, leaves. False: every point lies on the truth but for noise.
  bool disturbances = true;
  /// Root mean square distance by which a scan's pose displaces its points, in units of spacing();
  /// >= 0. Lines of flight have no pose: the points are displaced.
  double misregistration = 0.0;
  std::uint64_t seed = 1;
  ScalarType precision = ScalarType::kFloat64;  ///< of positions; or kFloat32
};

/// Of a tripod's scan the scanner is at the origin of its own frame; scans from the air are in
/// world coordinates, and their scanner moves.
class SceneScanner : public RangeScans {
 public:
  /// Casts all rays once to count the points. Memory: O(rows of rays). Throws Error (usage) for
  /// options out of range.
  explicit SceneScanner(const SceneScannerOptions& options);
  ~SceneScanner() override;

  /// Square root of the truth's area per point, metres: the mean distance between neighbours.
  double spacing() const;
  const synthetic::Scene& scene() const;

 private:
  struct State;
  void cast_row(std::size_t scan, std::size_t row, Vec3* out) const override;

  std::unique_ptr<const State> state_;
};

}  // namespace orbweave
