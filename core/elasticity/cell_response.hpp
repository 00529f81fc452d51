#pragma once

#include <Eigen/Core>
#include <array>

#include "core/elasticity/cell_geometry.hpp"

namespace finegauge {

/// Voigt order xx yy zz xy yz zx; strains carry engineering shears.
using Voigt = Eigen::Matrix<double, 6, 1>;

/// Rotation of a cell: of the deformation gradient at its centre, x = current corner positions [m]; identity for
/// Kinematics::linear.
Eigen::Matrix3d cell_rotation(const CellGeometry& geometry, const Material& material, const CellVectors& x);

/// Internal force at the corners [N]: R K (Rᵀ x - X), Felippa & Haugen 2005; with R = 1 it is K u.
/// X, x: rest and current corner positions.
CellVectors cell_force(const CellMatrix& stiffness, const Eigen::Matrix3d& R, const CellVectors& X,
                       const CellVectors& x);

/// Stress [Pa] in the one global frame, R σ Rᵀ, so that an estimate does not change under a superposed rotation.
/// `local` displacement is Rᵀ x - X. At the quadrature points, and at the centre.
Voigt centre_stress(CellShape shape, const CellGeometry& geometry, const Material& material, const Eigen::Matrix3d& R,
                    const CellVectors& local);
Eigen::Matrix<double, 6, 8> quadrature_stress(CellShape shape, const CellGeometry& geometry, const Material& material,
                                              const Eigen::Matrix3d& R, const CellVectors& local);

/// σ:C⁻¹:τ [Pa] = (1+nu)/E σ:τ - nu/E tr σ tr τ, twice the energy density when both are one stress.
double complementary_product(const Material& material, const Voigt& sigma, const Voigt& tau);
double von_mises(const Voigt& sigma);
/// The stress as a symmetric matrix [Pa].
Eigen::Matrix3d stress_tensor(const Voigt& sigma);
Voigt voigt(const Eigen::Matrix3d& sigma);  ///< its inverse, of a symmetric tensor
/// R σ Rᵀ.
Voigt rotate_stress(const Eigen::Matrix3d& R, const Voigt& sigma);

}  // namespace finegauge
