// GLB files taken apart, for tests: by the specification, not by the writer.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "io/triangle_mesh.h"
#include "io/vec3.h"
#include "tests/io/reading.h"

namespace orbweave::test {

/// A GLB file of one mesh.
struct GlbFile {
  nlohmann::json json;
  std::string bin;

  explicit GlbFile(const std::filesystem::path& path) {
    const std::string bytes = read_file(path);
    const auto word = [&](std::size_t at) {
      std::uint32_t value = 0;
      std::memcpy(&value, bytes.substr(at, 4).data(), 4);
      return value;
    };
    if (bytes.size() < 28 || bytes.substr(0, 4) != "glTF" || word(4) != 2 ||
        word(8) != bytes.size() || word(12) % 4 != 0 || bytes.substr(16, 4) != "JSON")
      throw std::runtime_error(path.string() + " is no GLB file");
    json = nlohmann::json::parse(bytes.substr(20, word(12)));
    const std::size_t at = 20 + word(12);
    if (bytes.substr(at + 4, 4) != std::string("BIN\0", 4) || at + 8 + word(at) != bytes.size())
      throw std::runtime_error(path.string() + " has no binary part at its end");
    bin = bytes.substr(at + 8);
  }

  const nlohmann::json& primitive() const { return json.at("meshes").at(0).at("primitives").at(0); }
  const nlohmann::json& accessor(const std::string& attribute) const {
    const auto& of = attribute == "indices" ? primitive().at("indices")
                                            : primitive().at("attributes").at(attribute);
    return json.at("accessors").at(of.get<std::size_t>());
  }
  bool has(const std::string& attribute) const {
    return primitive().at("attributes").contains(attribute);
  }

  /// Element i of an accessor.
  template <class T, std::size_t kWidth>
  std::array<T, kWidth> element(const nlohmann::json& of, std::size_t i) const {
    const auto& view = json.at("bufferViews").at(of.at("bufferView").get<std::size_t>());
    const std::size_t stride = view.value("byteStride", sizeof(T) * kWidth);
    const std::size_t at = view.value("byteOffset", std::size_t{0}) +
                           of.value("byteOffset", std::size_t{0}) + i * stride;
    std::array<T, kWidth> values{};
    if (at + sizeof values > bin.size()) throw std::runtime_error("beyond the buffer");
    std::memcpy(values.data(), bin.data() + at, sizeof values);
    return values;
  }

  /// Where viewers see the vertices: through the node, y up.
  std::vector<Vec3> seen_positions() const {
    const auto m = json.at("nodes").at(0).at("matrix").get<std::vector<double>>();
    const auto& of = accessor("POSITION");
    std::vector<Vec3> seen(of.at("count").get<std::size_t>());
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const auto p = element<float, 3>(of, i);
      for (int row = 0; row < 3; ++row) {
        const auto r = static_cast<std::size_t>(row);
        seen[i][row] = m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r];
      }
    }
    return seen;
  }

  std::vector<Triangle> triangles() const {
    const auto& of = accessor("indices");
    std::vector<Triangle> all(of.at("count").get<std::size_t>() / 3);
    for (std::size_t i = 0; i < all.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) all[i][c] = element<std::uint32_t, 1>(of, 3 * i + c)[0];
    return all;
  }
};

}  // namespace orbweave::test
