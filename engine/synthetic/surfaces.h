// The analytic surfaces behind `generate`, each as sheets with coordinates (u, v).
#pragma once

#include "engine/synthetic/portable_math.h"
#include "engine/synthetic/synthetic_options.h"

namespace orbweave::synthetic {

inline constexpr double kMajorRadius = 1.0;  ///< of the tori
inline constexpr double kTubeRadius = 0.4;
inline constexpr double kLargestTube = 0.4 * 1.21;  ///< no bump reaches higher
inline constexpr double kUpperRadius = 0.5;         ///< of the sphere above the torus
inline constexpr Vec3 kUpperCenter{0.0, 0.0, 1.2};
inline constexpr double kWallGap = 3.0;  ///< between the two walls, in spacings

struct SurfacePoint {
  Vec3 position;
  Vec3 normal;  ///< unit length, outward
};

/// u: turns around the axis; v: turns around the tube, 0 at the outer equator.
SurfacePoint torus_point(double u, portable::SineCosine v);
SurfacePoint bumpy_torus_point(double u, double v, portable::SineCosine around_tube);
/// |dX/du x dX/dv| of the bumpy torus, per radian squared.
double bumpy_torus_area_element(double u, double v);

/// Distance from the centre line of the tube less the tube's radius there, at any place off the
/// axis and the centre line: zero on the surface, positive outside.
struct TubeField {
  double value = 0.0;
  Vec3 gradient;
};
TubeField torus_field(Vec3 position);
TubeField bumpy_torus_field(Vec3 position);

/// A point of the unit sphere as one of the sphere above the torus.
SurfacePoint upper_sphere_point(SurfacePoint on_unit_sphere);

/// Normal of a point of the unit cube's surface, from the coordinates that are exactly 0 or 1.
Vec3 cube_normal(Vec3 position);

}  // namespace orbweave::synthetic
