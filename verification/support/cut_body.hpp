#pragma once

#include <Eigen/Core>
#include <random>
#include <vector>

#include "core/mesh/base_mesh.hpp"
#include "core/mesh/mesh.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// Bodies that fill their cells in part, made from a mesh by hand: what an immersed surface leaves of it.

/// The part of space where normal · X <= offset.
struct HalfSpace {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();  ///< need not have length one
  double offset = 0.0;                                ///< [m] times the normal's length
};
/// Share of the volume of a box along the axes, given by its lower and upper corner [m]; exact to round-off.
double share_of_box(const HalfSpace& half_space, const Eigen::Vector3d& low, const Eigen::Vector3d& high);
/// The same per cell of a mesh whose cells are such boxes.
std::vector<double> shares_in(const HalfSpace& half_space, const Mesh& mesh);
/// Where in each cell the material lies, by the shares of 8 × 8 × 8 boxes in it: to a hundredth of a cell,
/// or a sixteenth where only a sliver is filled.
std::vector<MaterialMeans> means_in(const HalfSpace& half_space, const Mesh& mesh);

/// The cells of a hexahedral box that the half space reaches, with the box's surfaces as far as they remain; the new
/// boundary where cells are left out has no name.
BaseMesh reached_part(const HalfSpace& half_space, const BaseMesh& box);

/// Per cell 0, 1 or something between, a third of the cells each.
std::vector<double> random_shares(const Mesh& mesh, std::mt19937& generator);

/// Volume of the cells, and of the material in them [m³].
double material_volume(const Discretization& d);

/// Per node, 1 where no cell around it has any material.
std::vector<std::uint8_t> nodes_without_material(const Mesh& mesh);

/// Largest over smallest eigenvalue of D^-1/2 A D^-1/2, D the diagonal of A. Dense.
double scaled_condition(const BlockMatrix<double>& A);
/// The same without scaling.
double condition(const BlockMatrix<double>& A);

}  // namespace finegauge
