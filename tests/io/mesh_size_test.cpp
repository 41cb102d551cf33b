#include "io/mesh_size.h"

#include <catch2/catch.hpp>
#include <string>

#include "io/error.h"

namespace orbweave {

TEST_CASE("MeshesWhoseCornersExceed32BitsAreRefused") {
  const auto message_of = [](std::uint64_t vertices, std::uint64_t triangles) -> std::string {
    try {
      require_mesh_in_core("large.ply", vertices, triangles);
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::kResource);
      return error.what();
    }
    return {};
  };
  CHECK(message_of(4'294'967'295, 1'431'655'764).empty());
  CHECK(message_of(7, 1'431'655'765) ==
        "large.ply: the mesh is too large to be held in core; found 7 vertices and 1431655765 "
        "triangles, expected at most 4294967295 vertices and 1431655764 triangles. Use a part of "
        "it, or make it smaller ('orbweave simplify').");
  CHECK_FALSE(message_of(4'294'967'296, 12).empty());
  // A count that is cut to 32 bits would be small again.
  CHECK_FALSE(message_of(7, (std::uint64_t{1} << 32) + 1).empty());
}

}  // namespace orbweave
