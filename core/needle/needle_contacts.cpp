#include "core/needle/needle_contacts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace finegauge {
namespace {

/// A cut that ends sooner than this share of d_c leaves no point of its own: two points so close would hold the needle
/// twice at one place.
constexpr double least_advance = 0.25;
/// Motion in one step, over d_c, below which the tip counts as neither advancing nor going back: the solver's tolerance
/// must not toggle states.
constexpr double least_motion = 1e-6;

CentrelinePoint tip_of(const Needle& needle) { return {needle.element_count() - 1, 1.0}; }

/// Right-handed frame with the first column n, the second as near to `like` as it can be.
Eigen::Matrix3d frame_along(const Eigen::Vector3d& n, const Eigen::Vector3d& like) {
  Eigen::Vector3d t = like - n * n.dot(like);
  if (!(t.squaredNorm() > 1e-6 * like.squaredNorm())) {
    int smallest;
    n.cwiseAbs().minCoeff(&smallest);
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(smallest);
    t = axis - n * n.dot(axis);
  }
  t.normalize();
  Eigen::Matrix3d frame;
  frame << n, t, n.cross(t);
  return frame;
}

}  // namespace

std::string_view to_string(TipState state) {
  switch (state) {
    case TipState::outside:
      return "outside";
    case TipState::touch:
      return "touch";
    case TipState::stick:
      return "stick";
    case TipState::cut:
      return "cut";
    case TipState::retract:
      return "retract";
  }
  return "";
}

std::string_view to_string(ContactEventKind kind) {
  switch (kind) {
    case ContactEventKind::touch:
      return "touch";
    case ContactEventKind::release:
      return "release";
    case ContactEventKind::puncture:
      return "puncture";
    case ContactEventKind::cut:
      return "cut";
    case ContactEventKind::stick:
      return "stick";
    case ContactEventKind::slip:
      return "slip";
    case ContactEventKind::retract:
      return "retract";
    case ContactEventKind::exit:
      return "exit";
  }
  return "";
}

void NeedleContacts::log(ContactEventKind kind, double time, double force) {
  events_.push_back({kind, time, inserted_length_, force});
}

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

/// A surface that the tip may reach in the coming step; seen a little early it does no harm, since its row holds
/// nothing while the gap is open. Looked for ahead, along the needle and along the base's motion; and behind only where
/// the tip is in the body already, or the far side of a wall just left would be taken for its near one.
void NeedleContacts::find_surface(const Needle& needle, const NeedleState& state, const TissueView& tissue,
                                  const Eigen::Vector3d& advance, double tau) {
  const CentrelinePoint tip = tip_of(needle);
  const Eigen::Vector3d x = centreline_position(needle, state, tip), n = centreline_tangent(needle, state, tip);
  const double tissue_way = tau * tissue.v.colwise().norm().maxCoeff();
  const double tip_way = tau * state.velocities.col(needle.node_count() - 1).norm();
  const double way = std::max(advance.norm(), tip_way) + tissue_way;
  if (!(way > 0.0)) return;
  std::optional<SurfaceHit> hit;
  if (advance.dot(n) + tissue_way > 0.0) hit = first_entry(tissue.mesh, tissue.u, x, x + way * n);
  if (!hit && advance.squaredNorm() > 0.0) hit = first_entry(tissue.mesh, tissue.u, x, x + way * advance.normalized());
  if (!hit && active_ == 0 && locate_deformed(tissue.mesh, tissue.u, x))
    hit = nearest_surface_point(tissue.mesh, tissue.u, x, 4.0 * way);
  if (!hit) return;
  PathPoint point;
  // The normal at rest is near enough to the current one to spread the force in the surface.
  point.tissue = spread_over_ring(tissue.forest.base(), hit->point, hit->inward, rules_.coupling_radius);
  point.frame = frame_along(hit->inward, Eigen::Vector3d::UnitX());
  point.on_needle = tip;
  point.after_gap = true;
  points_.resize(active_);
  points_.push_back(std::move(point));
  ++active_;
  surface_normal_ = hit->inward;
  touched_ = false;
  state_ = TipState::touch;
}

/// Closest places on the needle of the active points, and the inserted length.
void NeedleContacts::place_points(const Needle& needle, const NeedleState& state, const TissueView& tissue) {
  inserted_length_ = 0.0;
  const double tip_length = arc_length(needle, tip_of(needle));
  double last = 0.0;
  for (int i = 0; i < active_; ++i) {
    PathPoint& point = points_[i];
    const bool at_tip = i == active_ - 1 && (state_ == TipState::touch || state_ == TipState::stick);
    point.on_needle =
        at_tip
            ? tip_of(needle)
            : closest_point(needle, state, spread_position(tissue.forest, tissue.mesh, tissue.u, point.tissue)).point;
    const double length = arc_length(needle, point.on_needle);
    if (!point.after_gap) inserted_length_ += length - last;
    last = length;
  }
  if (active_ > 0 && tip_in_tissue()) inserted_length_ += tip_length - last;
}

/// Whether the needle past the last active point is in the body: not where the tip has left it, waits at a surface, or
/// has come back into the gap before the next body.
bool NeedleContacts::tip_in_tissue() const {
  if (state_ == TipState::outside || state_ == TipState::touch) return false;
  return active_ == static_cast<int>(points_.size()) || !points_[active_].after_gap;
}

double NeedleContacts::entry_length(const Needle& needle) const {
  const bool held = active_ > 1 || (active_ == 1 && state_ != TipState::touch);
  return arc_length(needle, held || state_ == TipState::touch ? points_.front().on_needle : tip_of(needle));
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
    const bool is_entry = i == entry_index && (here < last || is_tip);
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
  const double tip_length = arc_length(needle, tip_of(needle));
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

/// A place on the needle's axis as a new deepest point.
void NeedleContacts::add_path_point(const Needle& needle, const NeedleState& state, const TissueView& tissue,
                                    const CentrelinePoint& on_needle, const MaterialPoint& place) {
  const BaseMesh& base = tissue.forest.base();
  const PathPoint& last = points_[active_ - 1];
  Eigen::Vector3d along = centreline_tangent(needle, state, on_needle);
  const Eigen::Vector3d step = rest_position(base, place) - rest_position(base, last.tissue.centre);
  PathPoint point;
  point.frame = frame_along(along, last.frame.col(1));
  if (step.squaredNorm() > 0.0) along = step.normalized();
  point.tissue = spread_over_ring(base, place, along, rules_.coupling_radius);
  point.on_needle = on_needle;
  points_.resize(active_);
  points_.push_back(std::move(point));
  ++active_;
}

/// The path that the tip has cut since its last point: a point at every d_c, however far it went in the step, and one
/// at the tip.
void NeedleContacts::extend_path(const Needle& needle, const NeedleState& state, const TissueView& tissue, double from,
                                 const MaterialPoint& tip_place) {
  const double tip = arc_length(needle, tip_of(needle));
  // A rest shorter than half of d_c is left to the last stretch.
  const int between = static_cast<int>((tip - from) / rules_.cut_advance - 0.5);
  for (int k = 1; k <= between; ++k) {
    const CentrelinePoint at = at_arc_length(needle, from + k * rules_.cut_advance);
    if (const auto place = locate_deformed(tissue.mesh, tissue.u, centreline_position(needle, state, at)))
      add_path_point(needle, state, tissue, at, *place);
  }
  add_path_point(needle, state, tissue, tip_of(needle), tip_place);
}

void NeedleContacts::end_step(const Needle& needle, const NeedleState& state, const TissueView& tissue,
                              std::span<const ContactOutcome> outcomes, double time, double tau) {
  events_.clear();
  dissipated_ = 0.0;
  int sliding = 0;
  const int shaft = tip_has_point() ? active_ - 1 : active_;
  double total = 0.0;
  solved_.resize(active_);
  for (int i = 0; i < active_; ++i) {
    points_[i].lambda = outcomes[i].lambda;
    points_[i].slip = outcomes[i].axial_slip;
    solved_[i] = outcomes[i].lambda;
    dissipated_ += outcomes[i].lambda.dot(outcomes[i].velocity);
    total += outcomes[i].lambda.x() / tau;
    if (i < shaft && outcomes[i].axial_slip != 0) ++sliding;
  }
  place_points(needle, state, tissue);
  const bool slides = shaft > 0 && sliding == shaft;
  if (slides && !shaft_slides_) log(ContactEventKind::slip, time, total);
  shaft_slides_ = slides;

  switch (state_) {
    case TipState::outside:
      leave_through(needle, state, tissue, time, total);
      break;
    case TipState::touch:
      end_touch(needle, state, tissue, outcomes.back(), time, tau);
      break;
    case TipState::stick:
      end_stick(outcomes.back(), time, tau);
      break;
    case TipState::cut:
      end_cut(needle, state, tissue, outcomes.back(), time, total);
      break;
    case TipState::retract:
      end_retract(needle, state, tissue, tau * outcomes.back().velocity.x(), time, total);
      break;
  }
}

void NeedleContacts::end_touch(const Needle& needle, const NeedleState& state, const TissueView& tissue,
                               const ContactOutcome& tip, double time, double tau) {
  const double pressed = tip.lambda.x();
  if (pressed > 0.0 && !touched_) {
    touched_ = true;
    log(ContactEventKind::touch, time, pressed / tau);
  }
  if (pressed > rules_.puncture_strength * tau) {
    log(ContactEventKind::puncture, time, pressed / tau);
    // The entry joins the shaft, and the tip starts from there.
    PathPoint tip_point = points_[active_ - 1];
    points_[active_ - 1].lambda.setZero();
    tip_point.after_gap = false;
    points_.push_back(std::move(tip_point));
    ++active_;
    state_ = TipState::stick;
    return;
  }
  if (!(pressed > 0.0) && tip.velocity.x() <= 0.0) {  // opening: looked for anew when it closes again
    if (touched_) log(ContactEventKind::release, time, 0.0);
    points_.resize(--active_);
    state_ = TipState::outside;
    return;
  }
  if (!tip.lateral_slip) return;
  // The tip has slid: what it presses on now is the surface under it.
  PathPoint& point = points_[active_ - 1];
  const Eigen::Vector3d x = centreline_position(needle, state, tip_of(needle));
  const double reach =
      2.0 * (x - spread_position(tissue.forest, tissue.mesh, tissue.u, point.tissue)).norm() + rules_.coupling_radius;
  if (const auto hit = nearest_surface_point(tissue.mesh, tissue.u, x, reach)) {
    point.tissue = spread_over_ring(tissue.forest.base(), hit->point, hit->inward, rules_.coupling_radius);
    surface_normal_ = hit->inward;
  }
}

void NeedleContacts::end_stick(const ContactOutcome& tip, double time, double tau) {
  const double axial = tip.lambda.x(), lateral = tip.lambda.tail<2>().norm();
  if (axial > 0.0 && axial >= rules_.friction_in * lateral + rules_.cut_strength * tau) {
    log(ContactEventKind::cut, time, axial / tau);
    state_ = TipState::cut;
    points_[active_ - 1].lambda.x() = 0.0;
  } else if (!(axial > 0.0) && tip.velocity.x() * tau < -least_motion * rules_.cut_advance) {
    log(ContactEventKind::retract, time, 0.0);
    state_ = TipState::retract;
  }
}

void NeedleContacts::end_cut(const Needle& needle, const NeedleState& state, const TissueView& tissue,
                             const ContactOutcome& tip, double time, double total) {
  const double from = arc_length(needle, points_[active_ - 1].on_needle);
  const double advance = arc_length(needle, tip_of(needle)) - from;
  const bool stopped = !(tip.velocity.x() > 0.0);
  const auto tip_place = locate_deformed(tissue.mesh, tissue.u, centreline_position(needle, state, tip_of(needle)));
  if (!tip_place) {
    log(ContactEventKind::exit, time, total);
    state_ = TipState::outside;
    place_points(needle, state, tissue);
    return;
  }
  if (advance < rules_.cut_advance && !stopped) return;
  if (advance >= least_advance * rules_.cut_advance) {
    extend_path(needle, state, tissue, from, *tip_place);
    place_points(needle, state, tissue);
  }
  log(ContactEventKind::stick, time, 0.0);
  state_ = TipState::stick;
}

/// Points that the tip has passed on its way back wait; those that it reaches again hold again.
void NeedleContacts::follow_tip(const Needle& needle, const NeedleState& state, const TissueView& tissue) {
  const auto past_tip = [&](int i) {
    return closest_point(needle, state, spread_position(tissue.forest, tissue.mesh, tissue.u, points_[i].tissue))
        .distance_past_tip;
  };
  while (active_ > 0 && past_tip(active_ - 1) > 0.0) --active_;
  while (active_ < static_cast<int>(points_.size()) && !(past_tip(active_) > 0.0)) {
    points_[active_].lambda.setZero();
    points_[active_].slip = 0;
    ++active_;
  }
  place_points(needle, state, tissue);
}

void NeedleContacts::end_retract(const Needle& needle, const NeedleState& state, const TissueView& tissue,
                                 double motion, double time, double total) {
  const int before = active_;
  follow_tip(needle, state, tissue);
  if (active_ == 0) {
    log(ContactEventKind::exit, time, total);
    points_.clear();
    state_ = TipState::outside;
    shaft_slides_ = false;
  } else if (active_ == static_cast<int>(points_.size()) &&
             (active_ > before || motion > least_motion * rules_.cut_advance)) {
    log(ContactEventKind::stick, time, 0.0);
    state_ = TipState::stick;  // at the bottom of its own channel
  }
}

/// The tip has come out on another side; when it is drawn back in, the channel is there.
void NeedleContacts::leave_through(const Needle& needle, const NeedleState& state, const TissueView& tissue,
                                   double time, double total) {
  if (active_ == 0) return;
  const int before = active_;
  follow_tip(needle, state, tissue);
  if (active_ == before) return;
  log(ContactEventKind::retract, time, total);
  state_ = TipState::retract;
  end_retract(needle, state, tissue, 0.0, time, total);
}

ContactForces NeedleContacts::forces(const Eigen::Vector3d& axis, double tau) const {
  ContactForces forces;
  const int rows = static_cast<int>(rows_.size());
  for (int i = 0; i < rows; ++i) {
    // On the surface friction acts across the normal, and has its share along a needle that is not on the normal.
    const double force = (rows_[i].lateral == LateralLaw::coulomb ? (rows_[i].frame * solved_[i]).dot(axis)
                                                                  : solved_[i].x() * rows_[i].frame.col(0).dot(axis)) /
                         tau;
    (rows_[i].axial == AxialLaw::friction ? forces.shaft : forces.tip) += force;
    if (rows_[i].axial != AxialLaw::friction) forces.tip_lateral += solved_[i].tail<2>().norm() / tau;
  }
  return forces;
}

void NeedleContacts::append_state(std::vector<double>& values) const {
  values.push_back(static_cast<double>(static_cast<int>(state_)));
  values.push_back(static_cast<double>(active_));
  for (const PathPoint& point : points_) {
    values.push_back(point.tissue.centre.base_cell);
    for (int k = 0; k < 3; ++k) values.push_back(point.tissue.centre.xi[k]);
    for (int k = 0; k < 3; ++k) values.push_back(point.lambda[k]);
    values.insert(values.end(), point.frame.reshaped().begin(), point.frame.reshaped().end());
    values.push_back(point.slip);
    values.push_back(point.after_gap);
  }
  values.insert(values.end(), surface_normal_.begin(), surface_normal_.end());
  values.push_back(touched_);
  values.push_back(shaft_slides_);
}

}  // namespace finegauge
