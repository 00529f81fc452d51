#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/elasticity/material.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/point_location.hpp"
#include "core/mesh/refinement_forest.hpp"

namespace finegauge {

/// A solution's deformation gradients at places of the body: what other solutions, on any mesh of the same body, are
/// compared with in the energy norm.
struct StrainSamples {
  Eigen::Matrix3Xd places;                             ///< rest positions [m]
  Eigen::VectorXd volumes;                             ///< of the material that a place stands for [m³]
  Eigen::Matrix<double, 9, Eigen::Dynamic> gradients;  ///< F, column by column
};

/// One place in each cell: where its material has its centre. There the strain of a trilinear hexahedron is a power
/// of h more accurate than elsewhere (Barlow 1976).
StrainSamples sample_strains(const Mesh& mesh, const Eigen::Matrix3Xd& u);

/// The same places as points of another base mesh of the body; none for those that lie outside of its cells (where
/// cells end at the surface of an organ, another cell size ends elsewhere).
std::vector<std::optional<MaterialPoint>> locate_samples(const BaseMesh& base, const StrainSamples& samples);

/// F = 1 + du/dX at a point of a leaf.
Eigen::Matrix3d deformation_gradient(const Mesh& mesh, const Eigen::Matrix3Xd& u, const LeafPoint& point);

/// Squares of energy norms, twice an energy [J].
struct StrainDistance {
  double difference = 0.0;  ///< of a solution and the samples
  double size = 0.0;        ///< of the samples, over the places that were compared
  double left_out = 0.0;    ///< share of the volume that could not be compared
};
/// ∫ e:C:e with e = sym(Rᵀ (F - F_s)), R the rotation of the samples' F_s: the strain by which the solution is off,
/// however far the body has turned. `points`: of locate_samples for the forest's base.
StrainDistance strain_distance(const StrainSamples& samples, const std::vector<std::optional<MaterialPoint>>& points,
                               const RefinementForest& forest, const Mesh& mesh, const Eigen::Matrix3Xd& u,
                               const Material& material);

}  // namespace finegauge
