#pragma once

#include <map>
#include <string>
#include <vector>

#include "benchmarks/paper/needle_cases.hpp"
#include "benchmarks/paper/paper_numbers.hpp"

namespace finegauge {

/// Thresholds of one insertion into the phantom.
struct PhantomSetting {
  double puncture;  ///< strength [N]
  double friction;
  bool operator==(const PhantomSetting&) const = default;
};

/// The paper's two scenarios: puncture strengths at one friction, then frictions at one puncture strength; each setting
/// once, weaker and smoother first. `middle` is in both.
struct PhantomSettings {
  std::vector<PhantomSetting> all;
  PhantomSetting middle;
};
PhantomSettings phantom_settings(const PaperNumbers& paper);
/// As files and keys of the result are named.
std::string to_string(const PhantomSetting& setting);

/// Insertions with one setting on several meshes: coarse, nested (fine, its nodes among them the coarse mesh's),
/// adaptive, and perhaps fine (the paper's). Exact is what the nested mesh gives.
struct PhantomComparison {
  PhantomSetting setting;
  std::map<std::string, NeedleCase> cases;

  const ForceCurve& curve(const std::string& mesh) const { return cases.at(mesh).curve; }
  double stiffness(const std::string& mesh) const { return stiffness_before_puncture(curve(mesh)); }
  double envelope(const std::string& mesh) const { return envelope_distance(curve(mesh), curve("nested")); }
  double rms(const std::string& mesh) const { return rms_distance(curve(mesh), curve("nested")); }
};

/// Frames per second of two meshes whose frames took turns, and how often the nested mesh's mean dofs hold the adaptive
/// one's.
struct PhantomRates {
  double adaptive = 0.0, nested = 0.0, dofs_ratio = 0.0;
  double ratio() const { return adaptive / nested; }
};
PhantomRates rates(const PhantomComparison& comparison);
/// That of several passes whose ratio is in the middle; of an even number the lower one of the two.
PhantomRates median_rates(std::vector<PhantomRates> passes);
/// Fewer dofs must pay at least in proportion, whatever refinement itself costs, or it is not worth its while; and no
/// stage of a frame grows faster than with the square of the dofs, as the factorization does (George 1973, nested
/// dissection in three dimensions): a ratio beyond that compares something else.
Json rate_check(const PhantomRates& rates);

}  // namespace finegauge
