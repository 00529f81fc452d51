#include "benchmarks/audit/audit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/scene/scene_error.hpp"
#include "core/scene/scene_reader.hpp"
#include "verification/support/run_apart.hpp"

namespace finegauge {
namespace {

ApartResult run_comparison(const AuditOptions& options, const Scene& scene, const Scene& changed) {
  return run_apart([&] { return to_json(compare_scenes(scene, changed, options.seed)).dump(); },
                   std::numeric_limits<double>::infinity(), options.interrupted);
}

SceneComparison told(const ApartResult& result) {
  if (result.end == ApartResult::End::done) return scene_comparison(Json::parse(result.bytes));
  SceneComparison failed;
  failed.why_incomplete = (result.end == ApartResult::End::refused ? "refused: " : "") + result.why;
  return failed;
}

SceneComparison compare_apart(const AuditOptions& options, const Scene& scene,
                              const std::vector<std::string>& overrides) {
  std::vector<std::string> set = options.set;
  set.insert(set.end(), overrides.begin(), overrides.end());
  std::optional<Scene> changed;
  try {
    changed = read_scene(options.scene, set);
  } catch (const SceneError& error) {
    SceneComparison failed;
    failed.why_incomplete = std::string("refused: ") + error.what();
    return failed;
  }
  return told(run_comparison(options, scene, *changed));
}

/// False when interrupted.
bool find_cheapest(const AuditOptions& options, const Scene& scene, Audit& audit) {
  for (std::vector<const AuditedIngredient*> out = savings(audit);; out.pop_back()) {
    CheapestScene cheapest;
    std::string words;
    for (const AuditedIngredient* one : out) {
      cheapest.left_out.push_back(one->ingredient.name);
      words += (words.empty() ? "" : ", ") + one->ingredient.name;
      cheapest.overrides.insert(cheapest.overrides.end(), one->ingredient.overrides.begin(),
                                one->ingredient.overrides.end());
    }
    if (out.empty()) {
      cheapest.comparison = audit.with_itself;
      audit.cheapest = cheapest;
      return true;
    }
    options.progress(0.95, "the cheapest scene, without " + words);
    cheapest.comparison = compare_apart(options, scene, cheapest.overrides);
    if (options.interrupted()) return false;
    if (judge(cheapest.comparison, options.tolerance) == Verdict::spare) {
      audit.cheapest = cheapest;
      return true;
    }
  }
}

}  // namespace

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::needed:
      return "needed";
    case Verdict::spare:
      return "spare";
    case Verdict::undecided:
      break;
  }
  return "undecided";
}

Verdict judge(const SceneComparison& comparison, double tolerance) {
  if (!comparison.complete || comparison.changed_unconverged > comparison.unconverged) return Verdict::undecided;
  const double change = comparison.largest_change();
  if (!std::isfinite(change)) return Verdict::undecided;
  return change <= tolerance ? Verdict::spare : Verdict::needed;
}

std::vector<const AuditedIngredient*> savings(const Audit& audit) {
  const double least = std::max(0.01, 3.0 * std::abs(audit.with_itself.time_change()));
  std::vector<const AuditedIngredient*> list;
  for (const AuditedIngredient& one : audit.ingredients)
    if (one.ingredient.present && one.verdict == Verdict::spare && one.comparison.time_change() < -least)
      list.push_back(&one);
  std::ranges::stable_sort(list, {}, [](const AuditedIngredient* one) { return one->comparison.time_change(); });
  return list;
}

Audit run_audit(const AuditOptions& options) {
  const Scene scene = read_scene(options.scene, options.set);
  const std::vector<Ingredient> ingredients = scene_ingredients(scene);
  Audit audit;
  const double steps = static_cast<double>(ingredients.size()) + 2.0;
  options.progress(0.0, "the scene beside itself, for the noise");
  const ApartResult itself = run_comparison(options, scene, scene);
  if (itself.end == ApartResult::End::refused) throw SceneError(itself.why);
  audit.with_itself = told(itself);
  if (options.interrupted()) return audit;
  if (!audit.with_itself.complete) throw std::runtime_error("the scene as it is: " + audit.with_itself.why_incomplete);
  for (const Ingredient& ingredient : ingredients) {
    if (options.interrupted()) return audit;
    options.progress((1.0 + static_cast<double>(audit.ingredients.size())) / steps,
                     (ingredient.present ? "without " : "with ") + ingredient.name);
    AuditedIngredient one{ingredient, compare_apart(options, scene, ingredient.overrides), Verdict::undecided};
    if (options.interrupted()) return audit;
    one.verdict = judge(one.comparison, options.tolerance);
    audit.ingredients.push_back(std::move(one));
  }
  audit.finished = find_cheapest(options, scene, audit);
  return audit;
}

}  // namespace finegauge
