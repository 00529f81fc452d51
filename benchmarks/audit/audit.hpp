#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/audit/comparison.hpp"
#include "benchmarks/audit/ingredients.hpp"

namespace finegauge {

enum class Verdict {
  needed,    ///< its change is above the tolerance: it stays, or is missing
  spare,     ///< below
  undecided  ///< the changed scene does not run to its end, or there is nothing to compare
};
std::string_view to_string(Verdict verdict);
/// A change that leaves frames unconverged which did converge is none that can be judged.
Verdict judge(const SceneComparison& comparison, double tolerance);

struct AuditedIngredient {
  Ingredient ingredient;
  SceneComparison comparison;
  Verdict verdict = Verdict::undecided;
};

/// What a scene may do without, all at once.
struct CheapestScene {
  std::vector<std::string> left_out;   ///< names; empty: the scene as it is
  std::vector<std::string> overrides;  ///< of --set
  SceneComparison comparison;          ///< with the scene as it is, measured
};

struct Audit {
  SceneComparison with_itself;  ///< no change but the noise of the machine
  std::vector<AuditedIngredient> ingredients;
  std::optional<CheapestScene> cheapest;
  bool finished = false;  ///< false when interrupted
};

/// Present, spare and dear ones, by what they save, most first. Dear is what saves a hundredth of the time, and more
/// than noise does: three times what the scene beside itself differs by.
std::vector<const AuditedIngredient*> savings(const Audit& audit);

struct AuditOptions {
  std::string scene;
  std::vector<std::string> set;
  double tolerance = 0.02;
  std::uint64_t seed = 1;
  std::function<void(double fraction, const std::string& doing)> progress = [](double, const std::string&) {};
  std::function<bool()> interrupted = [] { return false; };
};

/// One ingredient at a time, each comparison in a process of its own. Then all that are spare and take time, more
/// than a hundredth and than noise does, are left out together; where the sum of the parts is more than the tolerance
/// the one that saves least comes back, until it is not. Throws SceneError for a scene that cannot start and
/// std::runtime_error for one that does not reach its end.
Audit run_audit(const AuditOptions& options);

}  // namespace finegauge
