// The rows of NeedleContacts: where its points are on the needle, what holds at each of them, and the forces that
// follow.

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "core/needle/needle_contacts.hpp"

namespace finegauge {

std::span<const ContactRows> NeedleContacts::begin_step(const Needle& needle, const NeedleState& state,
                                                        const TissueView& tissue, const Eigen::Vector3d& advance,
                                                        const Eigen::Matrix3d& axes, double tau) {
  if (multiplier_tau_ != tau && multiplier_tau_ > 0.0)
    for (PathPoint& point : points_) point.lambda *= tau / multiplier_tau_;
  multiplier_tau_ = tau;
  if (state_ == TipState::outside) find_surface(needle, state, tissue, advance, tau);
  place_points(needle, state, tissue);
  build_rows(needle, state, tissue, axes);
  return rows_;
}

void NeedleContacts::copy_places(std::vector<SpreadPoint>& places) const {
  places.resize(rows_.size());
  for (std::size_t i = 0; i < rows_.size(); ++i) places[i] = points_[i].tissue;
}

/// Closest places on the needle of the active points, and the inserted length.
void NeedleContacts::place_points(const Needle& needle, const NeedleState& state, const TissueView& tissue) {
  inserted_length_ = 0.0;
  const double tip_length = arc_length(needle, needle_tip(needle));
  double last = 0.0;
  for (int i = 0; i < active_; ++i) {
    PathPoint& point = points_[i];
    const bool at_tip = i == active_ - 1 && (state_ == TipState::touch || state_ == TipState::stick);
    point.on_needle =
        at_tip
            ? needle_tip(needle)
            : closest_point(needle, state, spread_position(tissue.forest, tissue.mesh, tissue.u, point.tissue)).point;
    const double length = arc_length(needle, point.on_needle);
    if (!point.after_gap) inserted_length_ += length - last;
    last = length;
  }
  if (active_ > 0 && tip_in_tissue()) inserted_length_ += tip_length - last;
}

double NeedleContacts::entry_length(const Needle& needle) const {
  const bool held = active_ > 1 || (active_ == 1 && state_ != TipState::touch);
  return arc_length(needle, held || state_ == TipState::touch ? points_.front().on_needle : needle_tip(needle));
}

/// Points of the shaft that hold it across: the entries, the tip's point, and between them those at least half a cell
/// apart. Rows closer than that are nearly dependent in the mesh: their impulses alternate in sign, and friction, which
/// takes their sizes, would lock the shaft (a mesh twice as fine shows that it does not).
void NeedleContacts::choose_lateral(const Needle& needle, const TissueView& tissue) {
  const Mesh& mesh = tissue.mesh;
  const int third = mesh.shape == CellShape::hexahedron ? 4 : 3;  // corner along the third axis
  double last = std::numeric_limits<double>::infinity(), entry = 0.0;
  int entry_index = active_;
  for (int i = active_ - 1; i >= 0; --i) {
    PathPoint& point = points_[i];
    if (i < entry_index) {  // the entry of the stretch that this point is on
      for (entry_index = i; entry_index > 0 && !points_[entry_index].after_gap;) --entry_index;
      entry = arc_length(needle, points_[entry_index].on_needle);
    }
    const double here = arc_length(needle, point.on_needle);
    const auto& corners = mesh.cells[find_leaf(tissue.forest, mesh, point.tissue.centre).cell];
    double edge = 0.0;
    for (const int corner : {1, 2, third})
      edge = std::max(edge, (mesh.nodes.col(corners[corner]) - mesh.nodes.col(corners[0])).norm());
    const bool is_tip = i == active_ - 1 && tip_has_point();
    const bool is_entry = i == entry_index && last - here >= least_advance * rules_.cut_advance;
    point.holds_across = is_tip || is_entry || (last - here >= 0.5 * edge && here - entry >= 0.5 * edge);
    if (point.holds_across) last = here;
  }
}

/// Share of the inserted length that each shaft point stands for; they sum to it. Stored in the rows' clamp.
void NeedleContacts::build_rows(const Needle& needle, const NeedleState& state, const TissueView& tissue,
                                const Eigen::Matrix3d& axes) {
  rows_.resize(active_);
  choose_lateral(needle, tissue);
  const int shaft = tip_has_point() ? active_ - 1 : active_;
  const double tip_length = arc_length(needle, needle_tip(needle));
  for (int i = 0; i < active_; ++i) {
    PathPoint& point = points_[i];
    ContactRows& row = rows_[i];
    const bool is_tip = i >= shaft;
    const bool on_surface = is_tip && state_ == TipState::touch;
    find_reduced_weights(tissue.forest, tissue.mesh, tissue.hanging, point.tissue, row.tissue);
    const Eigen::Vector3d n = on_surface ? surface_normal_ : centreline_tangent(needle, state, point.on_needle);
    const Eigen::Matrix3d frame = frame_along(n, point.frame.col(1));
    point.frame = frame;
    row.frame = frame;
    row.element = point.on_needle.element;
    row.needle = centreline_velocity(needle, state, point.on_needle);
    for (int k = 0; k < 4; ++k) row.needle.middleCols<3>(3 * k) = (row.needle.middleCols<3>(3 * k) * axes).eval();
    row.gap = frame.transpose() * (centreline_position(needle, state, point.on_needle) -
                                   spread_position(tissue.forest, tissue.mesh, tissue.u, point.tissue));
    row.lambda = point.lambda;
    row.friction_in = rules_.friction_in;
    row.friction_out = rules_.friction_out;
    row.surface_friction = rules_.surface_friction;
    row.clamp = 0.0;
    row.lateral = on_surface ? LateralLaw::coulomb : point.holds_across ? LateralLaw::bilateral : LateralLaw::none;
    if (row.lateral == LateralLaw::none) row.lambda.tail<2>().setZero();
    if (is_tip) {
      row.axial = state_ == TipState::cut ? AxialLaw::none : AxialLaw::unilateral;
      // Inside, the tip sticks to where it stopped: it may go back, but not on.
      if (state_ == TipState::stick) row.gap.x() = 0.0;
      continue;
    }
    row.axial = AxialLaw::friction;
    const double here = arc_length(needle, point.on_needle);
    double tributary = 0.0;
    if (i > 0 && !point.after_gap) tributary += 0.5 * (here - arc_length(needle, points_[i - 1].on_needle));
    if (i + 1 < shaft && !points_[i + 1].after_gap)
      tributary += 0.5 * (arc_length(needle, points_[i + 1].on_needle) - here);
    // The last one stands for the needle up to its tip, where that is in the body.
    if (i + 1 == shaft && tip_in_tissue() && !(shaft < active_ && points_[shaft].after_gap))
      tributary += tip_length - here;
    row.clamp = rules_.clamping * std::max(tributary, 0.0);
  }
}

ContactForces NeedleContacts::forces(const Eigen::Vector3d& axis, double tau) const {
  ContactForces forces;
  const int rows = static_cast<int>(rows_.size());
  for (int i = 0; i < rows; ++i) {
    // On the surface friction acts across the normal, and has its share along a needle that is not on the normal.
    double along = solved_[i].x() * rows_[i].frame.col(0).dot(axis) / tau;
    const double across = (rows_[i].frame.rightCols<2>() * solved_[i].tail<2>()).dot(axis) / tau;
    (rows_[i].lateral == LateralLaw::coulomb ? along : forces.across) += across;
    (rows_[i].axial == AxialLaw::friction ? forces.shaft : forces.tip) += along;
    if (rows_[i].axial != AxialLaw::friction) forces.tip_lateral += solved_[i].tail<2>().norm() / tau;
  }
  return forces;
}

}  // namespace finegauge
