#include "io/ply/ply_left_out.h"

#include <algorithm>
#include <cstdint>
#include <optional>

#include "io/text/counted_noun.h"

namespace orbweave {
namespace {

bool is_real(ScalarType type) {
  return type == ScalarType::kFloat32 || type == ScalarType::kFloat64;
}

/// "face property quality", "face properties red, green"; nothing for no name.
void add_names(const char* one, const char* many, const std::vector<std::string>& names,
               std::vector<std::string>& all) {
  if (names.empty()) return;
  std::string text = std::string(names.size() == 1 ? one : many) + " ";
  for (std::size_t i = 0; i < names.size(); ++i) text += (i == 0 ? "" : ", ") + names[i];
  all.push_back(std::move(text));
}

std::vector<std::string> lists_of(const PlyElement& element) {
  std::vector<std::string> names;
  for (const PlyProperty& property : element.properties)
    if (property.is_list) names.push_back(property.name);
  return names;
}

/// Faces by their name, that name no vertices.
bool lacks_corners(const PlyElement& element) {
  return (element.name == "face" || are_strips(element)) && !find_corner_list(element);
}

/// All but the corners, the hole that a face fills, and how sure its patch is.
std::vector<std::string> unread_properties(const PlyElement& faces, std::size_t corners) {
  const auto is_hole = [](const PlyProperty& property) {
    return property.name == "hole" && !property.is_list && !is_real(property.type);
  };
  const bool has_hole = std::ranges::any_of(faces.properties, is_hole);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < faces.properties.size(); ++i) {
    const PlyProperty& property = faces.properties[i];
    const bool is_confidence =
        has_hole && property.name == "confidence" && !property.is_list && is_real(property.type);
    if (i != corners && !is_hole(property) && !is_confidence) names.push_back(property.name);
  }
  return names;
}

}  // namespace

std::vector<std::string> lost_values_of_ply(const PlyHeader& header) {
  std::vector<std::string> all;
  for (const PlyElement& element : header.elements)
    if (element.name == "vertex") add_names("vertex list", "vertex lists", lists_of(element), all);
  return all;
}

std::vector<std::string> left_out_of_ply(const PlyHeader& header, bool is_mesh) {
  std::vector<std::string> all = is_mesh ? lost_values_of_ply(header) : std::vector<std::string>{};
  for (const PlyElement& element : header.elements) {
    const auto corners = find_corner_list(element);
    if (element.name == "vertex") continue;
    if (corners && is_mesh)
      add_names("face property", "face properties", unread_properties(element, *corners), all);
    else if (!corners && element.count > 0)
      all.push_back("element " + element.name + " of " +
                    counted_noun(element.count, "row", "rows") +
                    (lacks_corners(element) ? " without a list vertex_indices" : ""));
  }
  return all;
}

std::vector<std::string> left_out_faces(std::uint64_t faces) {
  if (faces == 0) return {};
  return {counted_noun(faces, "face", "faces") + " with fewer than three corners"};
}

}  // namespace orbweave
