#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "verification/support/evidence.hpp"

namespace finegauge {

/// Numerical extremes, an axis at a time: how far one quantity may go from its usual value, over decades, before the
/// simulation stops being right. Every value tried ends in one of three ways: an answer, which an independent truth
/// confirms; a refusal, which says so (bad input, or a solve that reports that it did not converge); or a failure: a
/// wrong answer, a number that is not finite, an exception that names no input. Only failures are unsound.

/// A file that a scene reads, under the name that the scene gives it.
struct AtlasFile {
  std::string name, content;
};

/// How one value ended.
struct AtlasPoint {
  double value = 0.0;
  bool ok = false;                    ///< an answer or a refusal
  double measure = 0.0;               ///< the number judged; NaN for a refusal that came before there was one
  std::string why = {};               ///< one line: what was judged, and by which bound
  std::string scene = {};             ///< TOML that `finegauge run` replays; empty where the point lies below a scene
  bool refused = false;               ///< ok, and no answer
  std::vector<AtlasFile> files = {};  ///< that the scene reads

  bool answered() const { return ok && !refused; }
};

/// An end of a range and all values between, both ends tried.
struct AtlasRange {
  double low = 0.0, high = 0.0;
};

struct AtlasAxis {
  std::string group;                ///< of axes: "material"
  std::string name, unit;           ///< name: words joined by underscores; unit empty: dimensionless
  std::string about;                ///< one line: what is varied in which problem
  std::string truth;                ///< what an answer is compared with
  double normal = 0.0;              ///< a usual value, one of `values`
  std::vector<double> values;       ///< ascending, not negative: what the tests try
  std::vector<double> more_values;  ///< that only a full sweep tries as well, ascending
  AtlasPoint (*at)(double value);
  AtlasRange safe;      ///< gated: the range without failures must reach so far
  AtlasRange answered;  ///< gated: and the range of answers so far
  std::string reason;   ///< of the limits
};

struct AtlasOptions {
  bool full = false;      ///< more_values too
  double seconds = 60.0;  ///< as in ApartOptions: a value that takes longer hangs, and fails
  std::function<void(double fraction, const std::string& doing)> progress = [](double, const std::string&) {};
  std::function<bool()> interrupted = [] { return false; };  ///< true: return what is finished
};

/// All values of an axis, ascending.
std::vector<double> atlas_values(const AtlasAxis& axis, bool full);

/// axis.at(value), or what point_or_refusal makes of it. An answer whose measure is not finite is a failure too.
AtlasPoint try_value(const AtlasAxis& axis, double value);

/// The same in a process of its own, so that a crash and a value that does not end are failures of that one point. None
/// where `interrupted` came first.
std::optional<AtlasPoint> try_value_apart(
    const AtlasAxis& axis, double value, double seconds,
    const std::function<bool()>& interrupted = [] { return false; });
/// What a point says before it computes, so that a crash leaves its scene behind.
void announce_scene(const std::string& scene, std::span<const AtlasFile> files);

/// What was found on one axis.
struct AtlasSweep {
  std::vector<AtlasPoint> points;         ///< ascending
  std::optional<AtlasRange> safe;         ///< without failures, around the normal value; none: that itself fails
  std::optional<AtlasRange> answered;     ///< with answers only
  std::vector<AtlasPoint> first_failing;  ///< on either side of the normal value the failure that is nearest to it
};
/// The ranges in which points of any order lie. Where the normal value was not tried its place is between the points
/// beside it.
AtlasSweep judge(const AtlasAxis& axis, std::vector<AtlasPoint> points);
/// Each value by try_value_apart.
AtlasSweep sweep(const AtlasAxis& axis, const AtlasOptions& options = {});

/// Whether a found range reaches as far as the one asked for.
bool covers(const std::optional<AtlasRange>& found, const AtlasRange& asked);

EvidenceTable atlas_table(const AtlasAxis& axis, const AtlasSweep& found);

/// The checks of one point, each with its bound.
class AtlasChecks {
 public:
  /// Holds when value <= bound; a NaN does not.
  void add(const std::string& what, double value, double bound);
  bool hold() const;
  /// Its measure is the value of the check that comes nearest to its bound, or exceeds it most.
  AtlasPoint point(double value) const;

 private:
  struct Check {
    std::string what;
    double value, bound;
  };
  std::vector<Check> checks_;
};

AtlasPoint refusal(double value, const std::string& why);
/// What `judged` returns; what it throws becomes a point too: bad input (SceneError, std::invalid_argument) a refusal,
/// all else a failure.
AtlasPoint point_or_refusal(double value, const std::function<AtlasPoint()>& judged);

/// worst <- value where that is larger. A NaN is larger than any number, and stays.
void keep_largest(double& worst, double value);
/// Largest magnitude; NaN where one of the entries is, and zero without any.
double largest_entry(const Eigen::Ref<const Eigen::MatrixXd>& matrix);

}  // namespace finegauge
