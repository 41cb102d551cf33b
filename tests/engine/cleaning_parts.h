// Clouds cut into boxes with a halo, to compare what a part computes with what the whole does.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <vector>

#include "io/box.h"
#include "io/point_cloud.h"

namespace orbweave::test {

/// Points of one box in [begin, end), with what lies around it, in the order of the whole cloud.
struct CloudPart {
  std::vector<Vec3> positions, normals;
  std::uint32_t begin = 0, end = 0;
  std::uint32_t first = 0;  ///< of the whole cloud, the number of point `begin`
};

inline std::tuple<double, double, double> box_of(Vec3 p, double side) {
  return {std::floor(p.z / side), std::floor(p.y / side), std::floor(p.x / side)};
}

/// Sorts the cloud box by box, otherwise as it was.
inline void sort_by_boxes(PointCloud& cloud, double side) {
  std::vector<std::uint32_t> order(cloud.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return box_of(cloud.positions[a], side) < box_of(cloud.positions[b], side);
  });
  PointCloud sorted;
  sorted.schema = cloud.schema;
  for (const std::uint32_t i : order) sorted.append(cloud, i);
  cloud = std::move(sorted);
}

/// One part per box that holds points.
inline std::vector<CloudPart> cut_with_halo(const PointCloud& cloud, double side, double halo) {
  std::vector<CloudPart> parts;
  for (std::uint32_t i = 0; i < cloud.size();) {
    const auto key = box_of(cloud.positions[i], side);
    std::uint32_t last = i;
    Box own;
    while (last < cloud.size() && box_of(cloud.positions[last], side) == key)
      own.extend(cloud.positions[last++]);
    CloudPart part;
    part.first = i;
    for (std::uint32_t j = 0; j < cloud.size(); ++j) {
      if (j == i) part.begin = static_cast<std::uint32_t>(part.positions.size());
      if (j == last) part.end = static_cast<std::uint32_t>(part.positions.size());
      if (!own.grown(halo).contains(cloud.positions[j])) continue;
      part.positions.push_back(cloud.positions[j]);
      part.normals.push_back(cloud.normals[j]);
    }
    if (last == cloud.size()) part.end = static_cast<std::uint32_t>(part.positions.size());
    parts.push_back(std::move(part));
    i = last;
  }
  return parts;
}

/// Values of all parts' own points, in the order of the whole cloud. `compute(part)` gives one
/// value per own point.
template <class Compute>
auto in_parts(const PointCloud& cloud, double side, double halo, const Compute& compute) {
  decltype(compute(CloudPart{})) all;
  for (const CloudPart& part : cut_with_halo(cloud, side, halo)) {
    const auto values = compute(part);
    all.insert(all.end(), values.begin(), values.end());
  }
  return all;
}

template <class Compute>
auto in_one_part(const PointCloud& cloud, const Compute& compute) {
  CloudPart whole{cloud.positions, cloud.normals, 0, static_cast<std::uint32_t>(cloud.size()), 0};
  return compute(whole);
}

}  // namespace orbweave::test
