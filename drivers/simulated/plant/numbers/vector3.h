#pragma once
// Vectors and rotations in space, for the plant's own mechanics.

#include <array>
#include <cmath>

namespace driftwise::simulated {

struct Vec3 {
  double x = 0, y = 0, z = 0;
};
inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(double s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(Vec3 a) { return std::sqrt(dot(a, a)); }
inline Vec3 unit(Vec3 a) { return (1 / norm(a)) * a; }
inline std::array<double, 3> to_array(Vec3 a) { return {a.x, a.y, a.z}; }
inline Vec3 to_vec3(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }

// Columns are the images of the axes.
struct Rotation {
  Vec3 ex{1, 0, 0}, ey{0, 1, 0}, ez{0, 0, 1};
};
inline Vec3 operator*(const Rotation& r, Vec3 v) { return v.x * r.ex + v.y * r.ey + v.z * r.ez; }
inline Rotation operator*(const Rotation& a, const Rotation& b) {
  return {a * b.ex, a * b.ey, a * b.ez};
}
inline Rotation inverse(const Rotation& r) {
  return {{r.ex.x, r.ey.x, r.ez.x}, {r.ex.y, r.ey.y, r.ez.y}, {r.ex.z, r.ey.z, r.ez.z}};
}

// By angle |v| about v, exactly (Rodrigues).
inline Rotation rotation_by(Vec3 v) {
  const double angle = norm(v);
  // sin a / a and (1 - cos a) / a^2 without the loss of digits near 0.
  const double half = angle / 2;
  const double s = angle < 1e-4 ? 1 - angle * angle / 6 : std::sin(angle) / angle;
  const double h = half < 1e-4 ? 1 - half * half / 6 : std::sin(half) / half;
  const auto turned = [&](Vec3 e) {
    const Vec3 first = cross(v, e);
    return e + s * first + (h * h / 2) * cross(v, first);
  };
  return {turned({1, 0, 0}), turned({0, 1, 0}), turned({0, 0, 1})};
}

// The v of rotation_by, for rotations well below a right angle.
inline Vec3 rotation_vector(const Rotation& r) {
  const Vec3 twice_sine{r.ey.z - r.ez.y, r.ez.x - r.ex.z, r.ex.y - r.ey.x};
  const double sine = norm(twice_sine) / 2;
  const double scale = sine < 1e-6 ? 0.5 + sine * sine / 12 : std::asin(sine) / (2 * sine);
  return scale * twice_sine;
}

}  // namespace driftwise::simulated
