#include "benchmarks/paper/phantom_study.hpp"

#include <array>
#include <cmath>
#include <optional>

#include "benchmarks/paper/phantom_comparison.hpp"
#include "benchmarks/paper/phantom_table.hpp"
#include "benchmarks/program/sha256.hpp"
#include "core/scene/scene_reader.hpp"

namespace finegauge {
namespace {

constexpr std::array phantom_meshes = {"coarse", "fine", "nested", "adaptive"};
constexpr int quick_phantom_frames = 250;
// Puncture and some cuts: the plain solver is slow, and its rate hardly changes with depth.
constexpr int plain_frames = 150;
constexpr int rate_passes = 3;

Scene phantom_scene(const PhantomSetting& setting, const std::string& mesh, StepMethod method,
                    const StudyContext& context) {
  std::vector<std::string> overrides;
  const auto set = [&](const std::string& key, const std::string& value) {
    overrides.push_back(std::string(key).append("=").append(value));
  };
  for (const auto& [key, value] : context.overrides) set(key, value);
  set("contact.puncture_strength", std::to_string(setting.puncture));
  set("contact.friction", std::to_string(setting.friction));
  if (mesh == "fine") set("box.cells", "[19, 9, 9]");
  if (mesh == "nested") set("box.cells", "[18, 8, 8]");
  Scene scene = read_scene(scene_file("phantom"), overrides);
  if (mesh != "adaptive") scene.dynamics->adapt.reset();
  scene.dynamics->solver.method = method;
  return scene;
}

void add_checks(const PhantomComparison& c, StudyResult& result) {
  const std::string name = to_string(c.setting);
  constexpr double no_limit = 1e6;  // two curves that are the same would be past it
  for (const auto& [mesh, one] : c.cases) {
    int unconverged = 0;
    for (const MotionFrame& frame : one.run.frames) unconverged += !frame.report.frame.converged;
    result.checks.push_back(
        check(std::string("unconverged_frames.").append(name).append(".").append(mesh), unconverged, 0.0, 0.0));
  }
  const NeedleCase &adaptive = c.cases.at("adaptive"), &nested = c.cases.at("nested");
  result.checks.push_back(check("mean_dofs_over_nested." + name, adaptive.mean_dofs / nested.mean_dofs,
                                1.05 * c.cases.at("coarse").mean_dofs / nested.mean_dofs, 0.5));
  if (c.setting.puncture <= 0.0) return;
  const double exact = c.stiffness("nested");
  result.checks.push_back(check("stiffness_gain." + name,
                                std::abs(c.stiffness("coarse") - exact) / std::abs(c.stiffness("adaptive") - exact),
                                2.0, no_limit));
  result.checks.push_back(check("envelope_gain." + name, c.envelope("coarse") / c.envelope("adaptive"), 2.0, no_limit));
}

void add_rows(const PhantomComparison& c, const std::string& solver, StudyResult& result) {
  for (const auto& [mesh, one] : c.cases) {
    Json row = {{"puncture_strength", c.setting.puncture},
                {"friction", c.setting.friction},
                {"mesh", mesh},
                {"solver", solver}};
    row["stiffness_before_puncture"] = c.stiffness(mesh);
    if (c.setting.puncture <= 0.0)
      row["stiffness_before_puncture_reason"] = "a surface without strength gives way at once";
    row["envelope_distance"] = c.envelope(mesh);
    row["rms_distance"] = c.rms(mesh);
    row.update(case_row(one, result.files));
    result.rows.push_back(std::move(row));
  }
}

void add_to_summary(const std::vector<PhantomComparison>& comparisons, Json& summary) {
  for (const PhantomComparison& c : comparisons)
    summary["cases"][to_string(c.setting)] = {
        {"stiffness",
         {{"coarse", c.stiffness("coarse")}, {"adaptive", c.stiffness("adaptive")}, {"nested", c.stiffness("nested")}}},
        {"envelope_distance", {{"coarse", c.envelope("coarse")}, {"adaptive", c.envelope("adaptive")}}},
        {"rms_distance", {{"coarse", c.rms("coarse")}, {"adaptive", c.rms("adaptive")}}},
        {"mean_dofs", {{"adaptive", c.cases.at("adaptive").mean_dofs}, {"nested", c.cases.at("nested").mean_dofs}}}};
}

Json to_json(const PhantomRates& rates) {
  return {{"adaptive", rates.adaptive},
          {"nested", rates.nested},
          {"ratio", rates.ratio()},
          {"dofs_ratio", rates.dofs_ratio}};
}

/// Runs comparisons one after the other and tells how far all of them are.
struct ComparisonRuns {
  const StudyContext& context;
  double parts;  ///< of equal weight, in all
  double done = 0.0;

  /// None when interrupted.
  std::optional<PhantomComparison> operator()(const PhantomSetting& setting, StepMethod method,
                                              std::span<const char* const> of, int frames, double weight) {
    PhantomComparison made{setting, {}};
    std::vector<NeedleCase*> cases;
    for (const char* mesh : of) {
      const std::string name = to_string(setting) + "_" + mesh + (method == StepMethod::plain ? "_plain" : "");
      NeedleCase one = needle_case(name, phantom_scene(setting, mesh, method, context), frames);
      cases.push_back(&made.cases.emplace(mesh, std::move(one)).first->second);
    }
    const bool finished = run_side_by_side(
        cases, context, [&](double share) { context.progress((done + weight * share) / parts, to_string(setting)); });
    done += weight;
    if (!finished) return std::nullopt;
    return made;
  }
};

}  // namespace

StudyResult phantom_study(const StudyContext& context) {
  StudyResult result;
  const PaperNumbers paper = paper_numbers("phantom");
  const std::filesystem::path file = scene_file("phantom");
  result.scene = file.string();
  result.sha256 = sha256_of_file(file.string());
  const PhantomSettings of_paper = phantom_settings(paper);
  const std::vector<PhantomSetting> settings = context.quick ? std::vector{of_paper.middle} : of_paper.all;
  constexpr std::array without_fine = {"coarse", "nested", "adaptive"};
  constexpr std::array rated = {"nested", "adaptive"};
  constexpr double rated_weight = 0.4, plain_weight = 2.0;  // of a comparison of all four meshes
  ComparisonRuns run{context, static_cast<double>(settings.size()) +
                                  (context.quick ? 0.0 : rated_weight * (rate_passes - 1) + plain_weight)};

  std::vector<PhantomComparison> comparisons;
  std::vector<PhantomRates> passes;
  for (const PhantomSetting& setting : settings) {
    auto made = context.quick ? run(setting, StepMethod::kept, without_fine, quick_phantom_frames, 1.0)
                              : run(setting, StepMethod::kept, phantom_meshes, 0, 1.0);
    if (!made) break;
    add_rows(*made, "best", result);
    add_checks(*made, result);
    result.plots.push_back(phantom_force_plot(*made));
    result.files.push_back(
        case_picture(made->cases.at("adaptive"), "adaptive mesh, puncture strength " + short_number(setting.puncture) +
                                                     " N, friction " + short_number(setting.friction)));
    for (StudyFile& section : case_sections(made->cases.at("adaptive"))) result.files.push_back(std::move(section));
    if (setting == of_paper.middle) passes.push_back(rates(*made));
    comparisons.push_back(std::move(*made));
  }
  if (passes.empty()) return result;  // interrupted
  // Again, the two meshes that are rated alone: frames take turns within a pass, and a minute that was slow for one of
  // the two after all does not decide.
  bool finished = comparisons.size() == settings.size();
  for (int pass = 1; finished && !context.quick && pass < rate_passes; ++pass) {
    const auto made = run(of_paper.middle, StepMethod::kept, rated, 0, rated_weight);
    finished = made.has_value();
    if (made) passes.push_back(rates(*made));
  }
  const PhantomRates best = median_rates(passes);
  if (finished && !context.quick) result.checks.push_back(rate_check(best));
  std::optional<PhantomRates> plain;
  if (finished && !context.quick)
    if (const auto made = run(of_paper.middle, StepMethod::plain, without_fine, plain_frames, plain_weight)) {
      add_rows(*made, "plain", result);
      plain = rates(*made);
    }
  add_to_summary(comparisons, result.summary);
  result.summary["frame_rate"]["best"] = to_json(best);
  for (const PhantomRates& pass : passes) result.summary["frame_rate"]["best"]["ratios"].push_back(pass.ratio());
  if (plain) result.summary["frame_rate"]["plain"] = to_json(*plain);
  result.plots.push_back(phantom_dofs_plot(comparisons));
  add_comparison(phantom_table(comparisons, best, plain, paper), result);
  return result;
}

}  // namespace finegauge
