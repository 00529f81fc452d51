#pragma once

#include <Eigen/Core>
#include <array>

namespace finegauge {

/// A function of the rest position at a point, with its gradient: forward automatic differentiation to first order, for
/// stresses, which hold first derivatives of the motion already.
struct Slope {
  double value = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};
inline Slope operator+(const Slope& a, const Slope& b) { return {a.value + b.value, a.gradient + b.gradient}; }
inline Slope operator-(const Slope& a, const Slope& b) { return {a.value - b.value, a.gradient - b.gradient}; }
inline Slope operator*(const Slope& a, const Slope& b) {
  return {a.value * b.value, a.value * b.gradient + b.value * a.gradient};
}
inline Slope operator/(const Slope& a, const Slope& b) {
  const double value = a.value / b.value;
  return {value, (a.gradient - value * b.gradient) / b.value};
}

using SlopeMatrix = std::array<std::array<Slope, 3>, 3>;  // [row][column]

template <class Entry>
SlopeMatrix filled(const Entry& entry) {
  SlopeMatrix A;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) A[i][j] = entry(i, j);
  return A;
}
inline SlopeMatrix identity() {
  return filled([](int i, int j) { return Slope{i == j ? 1.0 : 0.0}; });
}
inline SlopeMatrix operator+(const SlopeMatrix& A, const SlopeMatrix& B) {
  return filled([&](int i, int j) { return A[i][j] + B[i][j]; });
}
inline SlopeMatrix operator-(const SlopeMatrix& A, const SlopeMatrix& B) {
  return filled([&](int i, int j) { return A[i][j] - B[i][j]; });
}
inline SlopeMatrix operator*(const SlopeMatrix& A, const SlopeMatrix& B) {
  return filled([&](int i, int j) { return A[i][0] * B[0][j] + A[i][1] * B[1][j] + A[i][2] * B[2][j]; });
}
inline SlopeMatrix operator*(const Slope& a, const SlopeMatrix& B) {
  return filled([&](int i, int j) { return a * B[i][j]; });
}
inline SlopeMatrix transposed(const SlopeMatrix& A) {
  return filled([&](int i, int j) { return A[j][i]; });
}
inline Slope trace(const SlopeMatrix& A) { return A[0][0] + A[1][1] + A[2][2]; }

/// A⁻ᵀ, by cofactors.
inline SlopeMatrix inverse_transposed(const SlopeMatrix& A) {
  const SlopeMatrix C = filled([&](int i, int j) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    return A[i1][j1] * A[i2][j2] - A[i1][j2] * A[i2][j1];
  });
  const Slope det = A[0][0] * C[0][0] + A[0][1] * C[0][1] + A[0][2] * C[0][2];
  return filled([&](int i, int j) { return C[i][j] / det; });
}

}  // namespace finegauge
