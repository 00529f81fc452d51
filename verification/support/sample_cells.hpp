#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <random>

#include "core/elasticity/cell_geometry.hpp"

namespace finegauge {

/// A number in [-1, 1]; the generator's own bits, so that every standard library draws the same.
inline double random_number(std::mt19937& generator) { return 2.0 * (generator() / 4294967295.0) - 1.0; }

inline Eigen::Vector3d random_vector(std::mt19937& generator) {
  const double x = random_number(generator), y = random_number(generator), z = random_number(generator);
  return {x, y, z};
}

inline Eigen::Matrix3d random_matrix(std::mt19937& generator) {
  Eigen::Matrix3d A;
  for (int k = 0; k < 3; ++k) A.col(k) = random_vector(generator);
  return A;
}

/// An axis drawn evenly enough for tests; never zero.
inline Eigen::Matrix3d turn_about_random_axis(double angle, std::mt19937& generator) {
  Eigen::Vector3d axis = random_vector(generator);
  while (axis.norm() < 0.1) axis = random_vector(generator);
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

/// Corners of the reference cell, each moved by up to `distortion` along each axis. At 0.15 every cell is sound.
inline CellVectors sample_cell(CellShape shape, double distortion, std::mt19937& generator) {
  CellVectors corners = CellVectors::Zero();
  for (int c = 0; c < corner_count(shape); ++c) {
    if (shape == CellShape::hexahedron)
      corners.col(c) = Eigen::Vector3d(c & 1, (c >> 1) & 1, (c >> 2) & 1);
    else if (c > 0)
      corners(c - 1, c) = 1.0;
    corners.col(c) += distortion * random_vector(generator);
  }
  return corners;
}

/// Any vector per corner; zero at the unused ones.
inline CellVectors random_corner_vectors(CellShape shape, double size, std::mt19937& generator) {
  CellVectors u = CellVectors::Zero();
  for (int c = 0; c < corner_count(shape); ++c) u.col(c) = size * random_vector(generator);
  return u;
}

/// A x + b at every used corner.
inline CellVectors affine_image(CellShape shape, const Eigen::Matrix3d& A, const Eigen::Vector3d& b,
                                const CellVectors& X) {
  CellVectors image = CellVectors::Zero();
  for (int c = 0; c < corner_count(shape); ++c) image.col(c) = A * X.col(c) + b;
  return image;
}

}  // namespace finegauge
