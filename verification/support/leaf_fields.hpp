#pragma once

#include <functional>

#include "core/adapt/frame_adaptivity.hpp"

namespace finegauge {

/// A box of cubes (or of the tetrahedra in them) with edges of 1 m.
BaseMesh box_of_cubes(std::array<int, 3> cells, CellShape shape = CellShape::hexahedron);

/// Error and stress of one leaf, as a solution would give them.
struct LeafField {
  double eta_squared, von_mises;
  Eigen::Vector3d direction = Eigen::Vector3d::Constant(1.0 / 3.0);
};

struct LeafFields {
  ErrorEstimate estimate;
  Eigen::VectorXd von_mises;
};
/// `energy` is ∫ ε:σ; all energies are scaled by `energy_scale` before η is the root, as a change of units would.
LeafFields leaf_fields(const Mesh& mesh, double energy, const std::function<LeafField(int)>& leaf,
                       double energy_scale = 1.0, double stress_scale = 1.0);

Eigen::Vector3d cell_centre(const Mesh& mesh, int cell);
/// Edges of a cell whose axes are those of space [m].
Eigen::Vector3d cell_size(const Mesh& mesh, int cell);

/// Whether the history has an entry for every handle of the forest, and an empty one for all but its leaves.
bool history_follows(const FrameAdaptHistory& history, const RefinementForest& forest);

bool same_marks(const FrameMarks& a, const FrameMarks& b);

/// The marks of a second frame on a forest in which every cell has a stress of 1 Pa from the first.
FrameMarks marks_after_one_frame(const RefinementForest& forest, const LeafFields& f, const FrameAdaptRules& rules,
                                 int dofs = 0);

}  // namespace finegauge
