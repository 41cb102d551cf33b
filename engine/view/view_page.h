// A mesh as one page for a browser: no server, no other file, no network. Tiles of a mesh: what
// lies beside them in a folder for a web server.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "io/named_text.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// The largest page.
inline constexpr std::uint64_t kMostPageBytes = 20'000'000;

struct ViewPage {
  std::string name;                ///< of the mesh
  std::vector<std::string> facts;  ///< lines about it
  int up_axis = 2;                 ///< that is upright; 0: x, 1: y, 2: z
  std::string report;              ///< a report in JSON; empty: none
  std::vector<float> confidence;   ///< of each triangle's patch; empty: not known
};

/// Bytes of a page, within some thousand.
std::uint64_t view_page_bytes(std::uint64_t vertices, std::uint64_t triangles,
                              const PointSchema& schema);

/// The page: coordinates in 65,536 steps of the largest extent of the surface, colours where there
/// are red, green and blue, what vertices tell of their points (io/vertex_values.h) in 255 steps.
/// Its bytes depend on mesh and facts alone.
std::string view_page(const TriangleMesh& mesh, const ViewPage& page);

inline constexpr const char* kFolderPage = "index.html";
inline constexpr const char* kFolderScript = "viewer.js";

/// The files that make a browser show the tileset in whose folder they lie: the page, its script
/// and, where there is one, the report (JSON).
std::vector<NamedText> view_folder_files(const std::string& name, const std::string& report);

}  // namespace orbweave
