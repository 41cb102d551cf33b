#include "engine/synthetic/surfaces.h"

namespace orbweave::synthetic {
namespace {

using portable::sine_cosine;
using portable::SineCosine;

/// amplitude * sin(2 pi (m u + n v + phase)), relative to the tube's radius.
struct Bump {
  double amplitude, m, n, phase;
};
constexpr Bump kBumps[] = {{0.10, 5, 0, 0.0}, {0.06, 0, 4, 0.1}, {0.05, 8, 3, 0.3}};

/// The tube's radius and its derivatives per radian.
struct Tube {
  double radius = kTubeRadius, by_u = 0.0, by_v = 0.0;
};

Tube bumpy_tube(double u, double v) {
  Tube tube;
  for (const Bump& bump : kBumps) {
    const SineCosine wave = sine_cosine(bump.m * u + bump.n * v + bump.phase);
    tube.radius += kTubeRadius * bump.amplitude * wave.sine;
    tube.by_u += kTubeRadius * bump.amplitude * bump.m * wave.cosine;
    tube.by_v += kTubeRadius * bump.amplitude * bump.n * wave.cosine;
  }
  return tube;
}

/// Position and unnormalised normal dX/du x dX/dv. With the orthonormal frame e_r (out of the
/// tube), e_u (along the ring), e_v (around the tube) the derivatives are
/// by_u e_r + W e_u and by_v e_r + radius e_v, where W is the distance from the axis.
SurfacePoint tube_point(SineCosine a, SineCosine b, const Tube& tube) {
  const Vec3 out{b.cosine * a.cosine, b.cosine * a.sine, b.sine};
  const Vec3 along{-a.sine, a.cosine, 0.0};
  const Vec3 around{-b.sine * a.cosine, -b.sine * a.sine, b.cosine};
  const double from_axis = kMajorRadius + tube.radius * b.cosine;
  SurfacePoint point;
  point.position = {from_axis * a.cosine, from_axis * a.sine, tube.radius * b.sine};
  point.normal = from_axis * tube.radius * out - from_axis * tube.by_v * around -
                 tube.radius * tube.by_u * along;
  return point;
}

/// A place in the coordinates of the tube, angles as their sines and cosines.
struct TubePlace {
  double from_axis, from_center;  ///< the latter from the centre line of the tube
  SineCosine u, v;
  Vec3 out;  ///< away from the centre line
};

TubePlace tube_place(Vec3 p) {
  TubePlace place;
  place.from_axis = std::sqrt(p.x * p.x + p.y * p.y);
  const double across = place.from_axis - kMajorRadius;
  place.from_center = std::sqrt(across * across + p.z * p.z);
  place.u = {p.y / place.from_axis, p.x / place.from_axis};
  place.v = {p.z / place.from_center, across / place.from_center};
  place.out = {place.v.cosine * place.u.cosine, place.v.cosine * place.u.sine, place.v.sine};
  return place;
}

SineCosine sum_of_angles(SineCosine a, SineCosine b) {
  return {a.sine * b.cosine + a.cosine * b.sine, a.cosine * b.cosine - a.sine * b.sine};
}

/// The wave of a bump without its angles: multiples of an angle follow from its sine and cosine.
SineCosine wave_at(const Bump& bump, const TubePlace& place) {
  SineCosine wave = sine_cosine(bump.phase);
  for (int k = 0; k < static_cast<int>(bump.m); ++k) wave = sum_of_angles(wave, place.u);
  for (int k = 0; k < static_cast<int>(bump.n); ++k) wave = sum_of_angles(wave, place.v);
  return wave;
}

}  // namespace

TubeField torus_field(Vec3 position) {
  const TubePlace place = tube_place(position);
  return {place.from_center - kTubeRadius, place.out};
}

TubeField bumpy_torus_field(Vec3 position) {
  const TubePlace place = tube_place(position);
  const Vec3 by_u = Vec3{-place.u.sine, place.u.cosine, 0.0} / place.from_axis;
  const Vec3 by_v =
      Vec3{-place.v.sine * place.u.cosine, -place.v.sine * place.u.sine, place.v.cosine} /
      place.from_center;
  TubeField field{place.from_center - kTubeRadius, place.out};
  for (const Bump& bump : kBumps) {
    const SineCosine wave = wave_at(bump, place);
    field.value -= kTubeRadius * bump.amplitude * wave.sine;
    field.gradient = field.gradient -
                     kTubeRadius * bump.amplitude * wave.cosine * (bump.m * by_u + bump.n * by_v);
  }
  return field;
}

SurfacePoint torus_point(double u, SineCosine v) {
  const SineCosine a = sine_cosine(u);
  const double from_axis = kMajorRadius + kTubeRadius * v.cosine;
  return {{from_axis * a.cosine, from_axis * a.sine, kTubeRadius * v.sine},
          {v.cosine * a.cosine, v.cosine * a.sine, v.sine}};
}

SurfacePoint bumpy_torus_point(double u, double v, SineCosine around_tube) {
  SurfacePoint point = tube_point(sine_cosine(u), around_tube, bumpy_tube(u, v));
  point.normal = normalized(point.normal);
  return point;
}

double bumpy_torus_area_element(double u, double v) {
  return norm(tube_point(sine_cosine(u), sine_cosine(v), bumpy_tube(u, v)).normal);
}

SurfacePoint upper_sphere_point(SurfacePoint on_unit_sphere) {
  return {kUpperCenter + kUpperRadius * on_unit_sphere.position, on_unit_sphere.normal};
}

Vec3 cube_normal(Vec3 position) {
  Vec3 normal;
  for (int axis = 0; axis < 3; ++axis)
    normal[axis] = position[axis] == 0.0 ? -1.0 : position[axis] == 1.0 ? 1.0 : 0.0;
  return normalized(normal);
}

}  // namespace orbweave::synthetic
