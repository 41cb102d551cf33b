// Balls and circles about a point, for one walk (Real is double) or for as many as there are lanes;
// the same operations in the same order, hence the same bits. Included by walk_kernel.inl.

/// A vector of one walk (Real is double), or of as many as there are lanes.
template <class Real>
struct DirectionOf {
  Real x, y, z;
};
using Direction = DirectionOf<double>;
template <class Real>
inline DirectionOf<Real> operator+(DirectionOf<Real> a, DirectionOf<Real> b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Real>
inline DirectionOf<Real> operator-(DirectionOf<Real> a, DirectionOf<Real> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Real>
inline DirectionOf<Real> scaled(Real s, DirectionOf<Real> a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class Real>
inline Real inner(DirectionOf<Real> a, DirectionOf<Real> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Real>
inline DirectionOf<Real> outer(DirectionOf<Real> a, DirectionOf<Real> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double constant(double value, double) { return value; }
inline Lanes constant(double value, Lanes) { return Lanes::all(value); }
inline double square_root(double a) { return std::sqrt(a); }
/// What is below zero is so by rounding alone.
inline double at_least_zero(double a) { return a > 0.0 ? a : 0.0; }
inline Lanes at_least_zero(Lanes a) { return larger(a, Lanes::all(0.0)); }

/// A circle of centres u(t) = middle + cos(t) a + sin(t) b of balls that touch p and neighbour i.
template <class Real>
struct CircleOf {
  DirectionOf<Real> middle, a, b;
};
using Circle = CircleOf<double>;

/// The same circle from another place on.
inline Circle turned(const Circle& c) {
  constexpr double kCosine = 0.7648421872844885, kSine = 0.644217687237691;
  return {c.middle, scaled(kCosine, c.a) + scaled(kSine, c.b),
          scaled(kCosine, c.b) - scaled(kSine, c.a)};
}

/// The circle of the neighbour at d, t = 0 at the point u of it.
template <class Real>
inline CircleOf<Real> circle_at(DirectionOf<Real> d, Real inverse_length, DirectionOf<Real> u) {
  const DirectionOf<Real> middle = scaled(constant(0.5, Real{}), d);
  const DirectionOf<Real> a = u - middle;
  return {middle, a, outer(a, scaled(inverse_length, d))};
}

/// Centre of the ball that touches p, i and j on the positive side of the triangle (p, i, j); hi
/// and hj are half the squares of di and dj.
template <class Real>
inline DirectionOf<Real> ball_at(DirectionOf<Real> di, Real hi, DirectionOf<Real> dj, Real hj) {
  const Real one = constant(1.0, Real{});
  const DirectionOf<Real> normal = outer(di, dj);
  const Real inverse = one / inner(normal, normal);
  const DirectionOf<Real> u1 = outer(dj, normal), u2 = outer(normal, di);
  const DirectionOf<Real> centre = {(hi * u1.x + hj * u2.x) * inverse,
                                    (hi * u1.y + hj * u2.y) * inverse,
                                    (hi * u1.z + hj * u2.z) * inverse};
  const Real rest = one - inner(centre, centre);
  return centre + scaled(square_root(at_least_zero(rest) * inverse), normal);
}
