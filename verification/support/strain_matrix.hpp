#pragma once

#include "core/elasticity/cell_geometry.hpp"

namespace finegauge {

using StrainMatrix = Eigen::Matrix<double, 6, 24>;

/// B of the textbook: Voigt xx yy zz xy yz zx with engineering shears.
inline StrainMatrix strain_matrix(const Gradients& g) {
  StrainMatrix B = StrainMatrix::Zero();
  for (int a = 0; a < 8; ++a)
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      B(i, 3 * a + i) = g(i, a);
      B(3 + i, 3 * a + i) = g(j, a);
      B(3 + i, 3 * a + j) = g(i, a);
    }
  return B;
}

/// D in the same order.
inline Eigen::Matrix<double, 6, 6> elasticity_matrix(const Material& material) {
  Eigen::Matrix<double, 6, 6> D = Eigen::Matrix<double, 6, 6>::Zero();
  D.topLeftCorner<3, 3>().setConstant(material.lambda());
  for (int i = 0; i < 3; ++i) {
    D(i, i) += 2.0 * material.mu();
    D(3 + i, 3 + i) = material.mu();
  }
  return D;
}

}  // namespace finegauge
