#pragma once

#include <functional>
#include <string>

#include "core/static_step.hpp"
#include "verification/support/exact_field.hpp"

namespace finegauge {

/// What problems of known error are put together from, so that each takes a few lines.

SupportCondition clamped(const std::string& surface);
SupportCondition moved(const std::string& surface, const Eigen::Vector3d& by);
SupportCondition roller(const std::string& surface, int axis);
SurfaceLoad traction(const std::string& surface, const Eigen::Vector3d& value);

/// Plane strain: no displacement across z_min and z_max.
void hold_plane(StaticProblem& problem);
/// The exact displacement on these surfaces.
void hold_exactly(const ExactField& exact, const std::vector<std::string>& surfaces, StaticProblem& problem);
/// Named after the part of the boundary whose faces' centres are where `holds` says.
void name_surface(BaseMesh& mesh, const std::string& name, const std::function<bool(const Eigen::Vector3d&)>& holds);

BaseMesh block(const Eigen::Vector3d& size, std::array<int, 3> cells);
/// Without the lattice cells of `removed`.
BaseMesh block(const Eigen::Vector3d& size, std::array<int, 3> cells, const RemovedBlock& removed);
/// The square [-1, 1]² without its quadrant x > 0, y < 0, half as thick as a leg is long: 2n × 2m × layers cells.
BaseMesh notched_square(int n, int m, int layers);
Material with_poisson_ratio(double nu);

/// a u + b v of two fields of one material that are singular at the same line or not at all.
ExactField combined(double a, const ExactField& u, double b, const ExactField& v);

}  // namespace finegauge
