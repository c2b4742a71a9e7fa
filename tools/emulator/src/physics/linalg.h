// Vectors, 3x3 matrices and unit quaternions: the little linear algebra that rigid bodies need.
#pragma once

#include <cmath>

namespace tfsat {
namespace emulator {

struct Vec3 {
  double x = 0.0, y = 0.0, z = 0.0;
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline Vec3& operator+=(Vec3& a, const Vec3& b) { return a = a + b; }
inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Row-major; a default Mat3 is zero.
struct Mat3 {
  double m[3][3] = {};
  static Mat3 identity() {
    Mat3 e;
    e.m[0][0] = e.m[1][1] = e.m[2][2] = 1.0;
    return e;
  }
};

inline Vec3 operator*(const Mat3& a, const Vec3& v) {
  return {a.m[0][0] * v.x + a.m[0][1] * v.y + a.m[0][2] * v.z,
          a.m[1][0] * v.x + a.m[1][1] * v.y + a.m[1][2] * v.z,
          a.m[2][0] * v.x + a.m[2][1] * v.y + a.m[2][2] * v.z};
}

inline Mat3 operator*(const Mat3& a, const Mat3& b) {
  Mat3 c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      c.m[i][j] = a.m[i][0] * b.m[0][j] + a.m[i][1] * b.m[1][j] + a.m[i][2] * b.m[2][j];
  return c;
}

inline Mat3& operator+=(Mat3& a, const Mat3& b) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) a.m[i][j] += b.m[i][j];
  return a;
}

inline Mat3 transpose(const Mat3& a) {
  Mat3 t;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) t.m[i][j] = a.m[j][i];
  return t;
}

// Inertia tensor of a point mass at r about the origin.
inline Mat3 point_inertia(double mass, const Vec3& r) {
  const double v[3] = {r.x, r.y, r.z};
  Mat3 j;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) j.m[i][k] = mass * ((i == k ? dot(r, r) : 0.0) - v[i] * v[k]);
  return j;
}

// Solves a x = b by cofactors. `a` must be regular (an inertia tensor is).
inline Vec3 solve(const Mat3& a, const Vec3& b) {
  const Vec3 r0{a.m[0][0], a.m[0][1], a.m[0][2]};
  const Vec3 r1{a.m[1][0], a.m[1][1], a.m[1][2]};
  const Vec3 r2{a.m[2][0], a.m[2][1], a.m[2][2]};
  const Vec3 c0 = cross(r1, r2), c1 = cross(r2, r0), c2 = cross(r0, r1);
  return (1.0 / dot(r0, c0)) * (b.x * c0 + b.y * c1 + b.z * c2);
}

// Unit quaternion in scipy's order (x, y, z, w); as an attitude it takes body components to world.
struct Quaternion {
  double x = 0.0, y = 0.0, z = 0.0, w = 1.0;
};

inline Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
          a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

inline Quaternion conjugate(const Quaternion& q) { return {-q.x, -q.y, -q.z, q.w}; }

inline Quaternion normalized(const Quaternion& q) {
  const double s = 1.0 / std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {s * q.x, s * q.y, s * q.z, s * q.w};
}

// Exponential map: rotation vector (rad) to quaternion.
inline Quaternion from_rotation_vector(const Vec3& u) {
  const double angle = norm(u);
  // sin(a/2)/a by its series where the quotient would lose digits
  const double s = angle < 1e-4 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  return {s * u.x, s * u.y, s * u.z, std::cos(0.5 * angle)};
}

// Logarithm: the shortest rotation vector (rad) of a unit quaternion.
inline Vec3 rotation_vector(const Quaternion& q) {
  const Vec3 v{q.x, q.y, q.z};
  const double s = norm(v), sign = q.w < 0.0 ? -1.0 : 1.0;
  if (s < 1e-12) return (2.0 * sign) * v;
  return (2.0 * sign * std::atan2(s, sign * q.w) / s) * v;
}

inline Mat3 to_matrix(const Quaternion& q) {
  Mat3 r;
  r.m[0][0] = 1.0 - 2.0 * (q.y * q.y + q.z * q.z);
  r.m[0][1] = 2.0 * (q.x * q.y - q.z * q.w);
  r.m[0][2] = 2.0 * (q.x * q.z + q.y * q.w);
  r.m[1][0] = 2.0 * (q.x * q.y + q.z * q.w);
  r.m[1][1] = 1.0 - 2.0 * (q.x * q.x + q.z * q.z);
  r.m[1][2] = 2.0 * (q.y * q.z - q.x * q.w);
  r.m[2][0] = 2.0 * (q.x * q.z - q.y * q.w);
  r.m[2][1] = 2.0 * (q.y * q.z + q.x * q.w);
  r.m[2][2] = 1.0 - 2.0 * (q.x * q.x + q.y * q.y);
  return r;
}

}  // namespace emulator
}  // namespace tfsat
