#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>
#include <vector>

#include "core/needle/centreline.hpp"
#include "core/needle/contact_rows.hpp"
#include "core/needle/interaction.hpp"
#include "core/needle/needle.hpp"

namespace finegauge {

/// What tissue and needle do to each other. Forces in newtons; the solve multiplies them by the time step.
struct ContactRules {
  double puncture_strength = 0.0;  ///< λ_n0: axial force at which the surface gives way [N]
  double cut_strength = 0.0;       ///< λ_cut: that at which the tip advances inside [N]
  double cut_advance = 1.0e-3;     ///< d_c: advance of the tip in one cut, and spacing of the points left behind [m]
  double friction_in = 0.0;        ///< μ of the shaft against advance; of the tip's cutting law, too
  double friction_out = 0.0;       ///< μ of the shaft against withdrawal
  double surface_friction = 0.0;   ///< μ of the tip on the surface before puncture
  double clamping = 0.0;           ///< p: force of the tissue on the shaft per length [N/m]
  double coupling_radius = 0.0;    ///< radius over which contact forces are spread [m]; 0: points
};

enum class TipState { outside, touch, stick, cut, retract };
std::string_view to_string(TipState state);

enum class ContactEventKind { touch, release, puncture, cut, stick, slip, retract, exit };
std::string_view to_string(ContactEventKind kind);

/// Logged in the frame in which it happened. `slip`: the whole shaft slides where part of it did not; `stick`: the tip
/// after a cut; `release`: the tip left the surface without puncture.
struct ContactEvent {
  ContactEventKind kind;
  double time;   ///< [s]
  double depth;  ///< inserted length of the needle [m]
  double force;  ///< axial force of the tip's row for touch, puncture, cut and stick, of all rows else [N]
};

/// Forces of one frame on the base axis [N], positive against insertion.
struct ContactForces {
  double tip = 0.0, shaft = 0.0;
  double across = 0.0;       ///< of what holds the needle across itself: its share where the needle is bent
  double tip_lateral = 0.0;  ///< |λ_t|/τ of the tip's rows: with friction it adds to the strength of the tissue
  double total() const { return tip + shaft + across; }
};

/// The tissue as the contact sees it in one frame.
struct TissueView {
  const RefinementForest& forest;
  const Mesh& mesh;
  const HangingNodes& hanging;
  const Eigen::Matrix3Xd& u;  ///< displacement [m]
  const Eigen::Matrix3Xd& v;  ///< velocity [m/s]
};

/// The needle's trajectory through the tissue and what holds along it.
///
/// Invariant: points are ordered from the entry to the deepest that was cut; the first `active` of them lie on the
/// needle, those past the tip wait for its return and are forgotten when the needle has left. In touch, stick and cut
/// the last active point is the tip's. Points are material points of the base mesh: refinement does not touch them.
///
///   outside --segment meets a face--> touch --λ_n > λ_n0--> stick --λ_n >= μ|λ_t| + λ_cut--> cut
///   cut --advanced d_c, or no longer advancing--> stick;   stick --tip moves back--> retract --none left--> outside
///   retract --advanced to the deepest point again--> stick;   touch --gap opens--> outside
/// Transitions take effect in the next frame.
class NeedleContacts {
 public:
  explicit NeedleContacts(const ContactRules& rules) : rules_(rules) {}

  /// Rows of the coming step, for needle velocities in components along `axes` (NeedleSystem). `advance`: displacement
  /// of the base in the step, to see a surface before it is crossed. The span is valid until the next call.
  std::span<const ContactRows> begin_step(const Needle& needle, const NeedleState& state, const TissueView& tissue,
                                          const Eigen::Vector3d& advance, const Eigen::Matrix3d& axes, double tau);

  /// Multipliers, transitions and events after the step, with tissue and needle where they are now. Speeds of at most
  /// `least_speed` [m/s] are none: what the solve of the step cannot tell from zero.
  void end_step(const Needle& needle, const NeedleState& state, const TissueView& tissue,
                std::span<const ContactOutcome> outcomes, double time, double tau, double least_speed);

  /// Where the rows of the last begin_step hold the tissue, one for one; to be called before end_step, which may move
  /// the points. `places` is overwritten; its storage is used again.
  void copy_places(std::vector<SpreadPoint>& places) const;

  TipState tip_state() const { return state_; }
  int active_points() const { return active_; }
  double inserted_length() const { return inserted_length_; }  ///< [m]
  /// Arc length of the needle at the first place where the tissue holds it; all of it while nothing does [m].
  double entry_length(const Needle& needle) const;
  /// Of the last step, on a unit axis.
  ContactForces forces(const Eigen::Vector3d& axis, double tau) const;
  /// ∑ λ·r [J]: energy that the contact took in the last step, by friction, cutting and the correction of gaps.
  double dissipated() const { return dissipated_; }
  std::span<const ContactEvent> events() const { return events_; }  ///< of the last step

  /// Bytes that decide the future, for state hashes.
  void append_state(std::vector<double>& values) const;

 private:
  struct PathPoint {
    SpreadPoint tissue;
    Eigen::Vector3d lambda = Eigen::Vector3d::Zero();  ///< in `frame` [N s]
    Eigen::Matrix3d frame = Eigen::Matrix3d::Identity();
    CentrelinePoint on_needle;
    int slip = 0;
    bool holds_across = true;  ///< has lateral rows
    bool after_gap = false;    ///< entered the body anew: the needle between this and the point before is outside
  };

  void find_surface(const Needle& needle, const NeedleState& state, const TissueView& tissue,
                    const Eigen::Vector3d& advance, double tau);
  void place_points(const Needle& needle, const NeedleState& state, const TissueView& tissue);
  void build_rows(const Needle& needle, const NeedleState& state, const TissueView& tissue,
                  const Eigen::Matrix3d& axes);
  void follow_tip(const Needle& needle, const NeedleState& state, const TissueView& tissue);
  void end_touch(const Needle& needle, const NeedleState& state, const TissueView& tissue, const ContactOutcome& tip,
                 double time, double tau);
  void end_stick(const ContactOutcome& tip, double time, double tau);
  void end_cut(const Needle& needle, const NeedleState& state, const TissueView& tissue, double speed,
               double least_speed, double time, double total);
  void end_retract(const Needle& needle, const NeedleState& state, const TissueView& tissue, double motion, double time,
                   double total);
  void leave_through(const Needle& needle, const NeedleState& state, const TissueView& tissue, double time,
                     double total);
  void add_path_point(const Needle& needle, const NeedleState& state, const TissueView& tissue,
                      const CentrelinePoint& on_needle, const MaterialPoint& place);
  void extend_path(const Needle& needle, const NeedleState& state, const TissueView& tissue, double from,
                   const MaterialPoint& tip_place);
  void choose_lateral(const Needle& needle, const TissueView& tissue);
  bool tip_in_tissue() const;
  void log(ContactEventKind kind, double time, double force);
  bool tip_has_point() const {
    return state_ == TipState::touch || state_ == TipState::stick || state_ == TipState::cut;
  }

  /// A cut that ends sooner than this share of d_c leaves no point of its own, and an entry nearer to the tip's point
  /// does not hold the needle across: two points so close would hold it twice at one place.
  static constexpr double least_advance = 0.25;

  ContactRules rules_;
  TipState state_ = TipState::outside;
  std::vector<PathPoint> points_;
  int active_ = 0;
  bool touched_ = false;                                      ///< the tip has pressed on the surface that it waits at
  bool shaft_slides_ = false;                                 ///< all shaft points slid in the last step
  Eigen::Vector3d surface_normal_ = Eigen::Vector3d::Zero();  ///< inward, of touch
  double inserted_length_ = 0.0, dissipated_ = 0.0;
  double multiplier_tau_ = 0.0;          ///< time step that the stored impulses belong to
  std::vector<ContactRows> rows_;        ///< of the last step
  std::vector<Eigen::Vector3d> solved_;  ///< their multipliers, in their frames
  std::vector<ContactEvent> events_;
};

}  // namespace finegauge
