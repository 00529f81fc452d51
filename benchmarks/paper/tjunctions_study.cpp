#include "benchmarks/paper/tjunctions_study.hpp"

#include <algorithm>
#include <set>

#include "benchmarks/paper/lshape_reference.hpp"
#include "benchmarks/paper/needle_cases.hpp"
#include "benchmarks/paper/tjunctions_table.hpp"
#include "benchmarks/profile/processor_clock.hpp"
#include "benchmarks/profile/tjunction_overhead.hpp"
#include "benchmarks/program/command.hpp"
#include "core/scene/scene_reader.hpp"

namespace finegauge {
namespace {

constexpr int quick_turn_frames = 250;

/// False when the user stopped it.
bool run_cubes(const StudyContext& context, double begin, double end, TjunctionFindings& findings) {
  const std::vector<TjunctionCase> cases = tjunction_cases(context.quick  ? StudySize::quick
                                                           : context.full ? StudySize::full
                                                                          : StudySize::usual);
  const int repetitions = context.quick ? 3 : 5;
  for (std::size_t k = 0; k < cases.size(); ++k) {
    if (context.interrupted()) return false;
    const MarkedCube& cube = cases[k].cube;
    context.progress(begin + (end - begin) * static_cast<double>(k) / static_cast<double>(cases.size()),
                     to_string(cube.pattern) + ", " + std::to_string(cube.cells_per_edge) + " cells an edge, " +
                         std::to_string(std::lround(100.0 * cube.share)) + " % refined");
    findings.cases.push_back(run_case(cases[k], repetitions));
  }
  std::set<std::pair<int, std::array<std::uint8_t, 3>>> done;
  for (const TjunctionCase& one : cases) {
    if (one.counts_only || one.cube.levels > 1 || one.sweep == "mesh") continue;
    if (!done.emplace(one.cube.cells_per_edge, one.cube.refinement.divisions).second) continue;
    if (context.interrupted()) return false;
    findings.conforming.push_back(run_conforming(one.cube.cells_per_edge, one.cube.refinement, repetitions));
  }
  return true;
}

/// Passes interleave the schemes; medians. False when the user stopped it.
bool run_lshapes(const StudyContext& context, double begin, double end, TjunctionFindings& findings) {
  const int passes = context.quick ? 1 : 3;
  LshapeSequences study;
  study.reference_energy =
      read_lshape_reference(std::filesystem::path(FINEGAUGE_SOURCE_DIR) / "reference_data" / "exact" / "lshape.json")
          .value;
  std::map<LshapeScheme, std::vector<std::vector<LshapeStep>>> runs;
  const LshapeScheme schemes[] = {LshapeScheme::uniform, LshapeScheme::adaptive, LshapeScheme::directional};
  for (int pass = 0; pass < passes; ++pass)
    for (const LshapeScheme scheme : schemes) {
      context.progress(begin + (end - begin) * (pass + static_cast<int>(scheme) / 3.0) / passes,
                       "L-shape, " + to_string(scheme) + ", pass " + std::to_string(pass + 1));
      LshapeRunOptions options;
      options.enough_dofs =
          scheme == LshapeScheme::uniform ? (context.full ? 316899 : 42483) : (context.full ? 30000 : 6000);
      runs[scheme].push_back(run_lshape(
          scheme, options, [&](const LshapeStep&, const StaticSolution&) { return !context.interrupted(); }));
      if (context.interrupted()) return false;
    }
  for (const LshapeScheme scheme : schemes) take_median_times(runs[scheme], study.sequences[scheme]);
  for (const LshapeScheme scheme : {LshapeScheme::adaptive, LshapeScheme::directional}) {
    const std::vector<EqualError> meshes = equal_errors(study, scheme);
    findings.equal_error.insert(findings.equal_error.end(), meshes.begin(), meshes.end());
  }
  return true;
}

bool run_phantom(const StudyContext& context, double begin, double end, TjunctionFindings& findings) {
  const Scene scene = read_scene(scene_file("phantom"));
  TjunctionOverhead overhead(context.quick ? 5 : 9);
  run_motion(
      scene,
      [&](const MotionView& view) {
        overhead.observe(view);
        const int frame = view.frame.report.frame.frame;
        const int planned = context.quick ? std::min(quick_turn_frames, view.frames) : view.frames;
        if (frame % 50 == 0)
          context.progress(begin + (end - begin) * frame / planned, "phantom, frame " + std::to_string(frame));
        return frame < planned && !context.interrupted();
      },
      processor_clock());
  findings.phantom = overhead_summary(overhead);
  findings.phantom_share = overhead_share(overhead);
  return !context.interrupted();
}

}  // namespace

StudyResult tjunctions_study(const StudyContext& context) {
  if (!context.overrides.empty())
    throw UsageError("tjunctions: --set " + context.overrides.begin()->first + ": the study has no keys to set");
  if (context.vtu_every > 0) throw UsageError("tjunctions: --vtu: the study writes no VTU files");
  const PaperNumbers paper = paper_numbers("tjunctions");
  TjunctionFindings findings;
  StudyResult result;
  result.scene = "built in: cubes and the L-shape; reference_data/scenes/phantom.toml";
  const bool finished = run_cubes(context, 0.0, 0.6, findings) && run_phantom(context, 0.6, 0.75, findings) &&
                        run_lshapes(context, 0.75, 1.0, findings);
  for (const TjunctionCaseResult& one : findings.cases) result.rows.push_back(to_json(one));
  for (const EqualError& mesh : findings.equal_error) result.rows.push_back(to_json(mesh));
  if (!finished) {
    result.summary["interrupted"] = true;
    result.table = {"interrupted: " + std::to_string(result.rows.size()) + " meshes are kept"};
    return result;
  }
  result.summary = tjunctions_summary(findings);
  add_tjunctions_checks(findings, result.checks);
  result.table = {"Times are the processor's, medians of repetitions in which the handlings take turns, one thread.",
                  ""};
  add_comparison(tjunctions_table(findings, paper), result);
  result.plots = tjunctions_plots(findings, paper);
  return result;
}

}  // namespace finegauge
