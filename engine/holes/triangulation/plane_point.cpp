#include "engine/holes/triangulation/plane_point.h"

namespace orbweave {
namespace {

__extension__ typedef __int128 Wide;

struct Offset {
  std::int64_t x, y, square;
};

Offset offset(PlanePoint from, PlanePoint to) {
  const std::int64_t x = to.x - from.x;
  const std::int64_t y = to.y - from.y;
  return {x, y, x * x + y * y};
}

std::int64_t cross(const Offset& a, const Offset& b) { return a.x * b.y - a.y * b.x; }

}  // namespace

int side_of_circle(PlanePoint a, PlanePoint b, PlanePoint c, PlanePoint d) {
  const Offset p = offset(d, a);
  const Offset q = offset(d, b);
  const Offset r = offset(d, c);
  const Wide determinant =
      Wide{p.square} * cross(q, r) + Wide{q.square} * cross(r, p) + Wide{r.square} * cross(p, q);
  return determinant > 0 ? 1 : determinant < 0 ? -1 : 0;
}

}  // namespace orbweave
