// The states of NeedleContacts: what the tip meets, when it goes from one state to the next, and the path that it
// leaves.

#include "core/needle/needle_contacts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "core/mesh/body_location.hpp"

namespace finegauge {
namespace {

/// Motion in one step, over d_c, below which the tip counts as neither advancing nor going back: the solver's tolerance
/// must not toggle states.
constexpr double least_motion = 1e-6;

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

/// A surface that the tip may reach in the coming step; seen a little early it does no harm, since its row holds
/// nothing while the gap is open. Looked for ahead, along the needle and along the base's motion; and behind only where
/// the tip is in the body already, or the far side of a wall just left would be taken for its near one. A needle that
/// is through the body and drawn back comes through its own channel, which is no surface (leave_through).
void NeedleContacts::find_surface(const Needle& needle, const NeedleState& state, const TissueView& tissue,
                                  const Eigen::Vector3d& advance, double tau) {
  const CentrelinePoint tip = needle_tip(needle);
  const Eigen::Vector3d x = centreline_position(needle, state, tip), n = centreline_tangent(needle, state, tip);
  const double tissue_way = tau * tissue.v.colwise().norm().maxCoeff();
  const double tip_way = tau * state.velocities.col(needle.node_count() - 1).norm();
  const double way = std::max(advance.norm(), tip_way) + tissue_way;
  if (!(way > 0.0)) return;
  const BaseMesh& base = tissue.forest.base();
  const auto entry = [&](const Eigen::Vector3d& to) { return first_body_entry(base, tissue.mesh, tissue.u, x, to); };
  std::optional<SurfaceHit> hit;
  if (advance.dot(n) + tissue_way > 0.0) hit = entry(x + way * n);
  const bool through_channel = active_ > 0 && advance.dot(n) < 0.0;
  if (!hit && !through_channel && advance.squaredNorm() > 0.0) hit = entry(x + way * advance.normalized());
  if (!hit && active_ == 0 && locate_in_body(base, tissue.mesh, tissue.u, x))
    hit = nearest_body_surface(base, tissue.mesh, tissue.u, x, 4.0 * way);
  if (!hit) return;
  PathPoint point;
  // The normal at rest is near enough to the current one to spread the force in the surface.
  point.tissue = spread_over_ring(base, hit->point, hit->inward, rules_.coupling_radius);
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

/// Whether the needle past the last active point is in the body: not where the tip has left it, waits at a surface, or
/// has come back into the gap before the next body.
bool NeedleContacts::tip_in_tissue() const {
  if (state_ == TipState::outside || state_ == TipState::touch) return false;
  return active_ == static_cast<int>(points_.size()) || !points_[active_].after_gap;
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
  const BaseMesh& base = tissue.forest.base();
  const double tip = arc_length(needle, needle_tip(needle));
  // A rest shorter than half of d_c is left to the last stretch.
  const int between = static_cast<int>((tip - from) / rules_.cut_advance - 0.5);
  for (int k = 1; k <= between; ++k) {
    const CentrelinePoint at = at_arc_length(needle, from + k * rules_.cut_advance);
    if (const auto place = locate_in_body(base, tissue.mesh, tissue.u, centreline_position(needle, state, at)))
      add_path_point(needle, state, tissue, at, *place);
  }
  add_path_point(needle, state, tissue, needle_tip(needle), tip_place);
}

void NeedleContacts::end_step(const Needle& needle, const NeedleState& state, const TissueView& tissue,
                              std::span<const ContactOutcome> outcomes, double time, double tau, double least_speed) {
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
      end_cut(needle, state, tissue, outcomes.back().velocity.x(), least_speed, time, total);
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
  const Eigen::Vector3d x = centreline_position(needle, state, needle_tip(needle));
  const double reach =
      2.0 * (x - spread_position(tissue.forest, tissue.mesh, tissue.u, point.tissue)).norm() + rules_.coupling_radius;
  const BaseMesh& base = tissue.forest.base();
  if (const auto hit = nearest_body_surface(base, tissue.mesh, tissue.u, x, reach)) {
    point.tissue = spread_over_ring(base, hit->point, hit->inward, rules_.coupling_radius);
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

void NeedleContacts::end_cut(const Needle& needle, const NeedleState& state, const TissueView& tissue, double speed,
                             double least_speed, double time, double total) {
  const double from = arc_length(needle, points_[active_ - 1].on_needle);
  const double advance = arc_length(needle, needle_tip(needle)) - from;
  // Not "no longer positive": of a tip that stands only round-off would tell when the cut ends.
  const bool stopped = !(speed > least_speed);
  const auto tip_place = locate_in_body(tissue.forest.base(), tissue.mesh, tissue.u,
                                        centreline_position(needle, state, needle_tip(needle)));
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
