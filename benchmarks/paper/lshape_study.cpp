#include "benchmarks/paper/lshape_study.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "benchmarks/paper/direct_comparison.hpp"
#include "benchmarks/paper/lshape_findings.hpp"
#include "benchmarks/paper/lshape_options.hpp"
#include "benchmarks/paper/lshape_reference.hpp"
#include "benchmarks/paper/lshape_table.hpp"
#include "benchmarks/program/mesh_picture.hpp"
#include "benchmarks/program/vtu_writer.hpp"
#include "core/elasticity/cell_response.hpp"

namespace finegauge {
namespace {

Json to_json(const LshapeSequences& study, const LshapeStep& s) {
  return {{"scheme", to_string(s.scheme)},
          {"step", s.step},
          {"cells", s.cells},
          {"nodes", s.nodes},
          {"hanging_nodes", s.hanging_nodes},
          {"dofs", s.dofs},
          {"eta", s.eta},
          {"true_error", study.true_error(s)},
          {"effectivity", study.effectivity(s)},
          {"strain_energy", 0.5 * s.energy},
          {"estimate_ms", s.estimate_ms},
          {"mark_ms", s.mark_ms},
          {"topology_ms", s.topology_ms},
          {"assemble_ms", s.assemble_ms},
          {"reduce_ms", s.reduce_ms},
          {"solve_ms", s.solve_ms},
          {"total_ms", s.total_ms()},
          {"iterations", s.iterations},
          {"converged", s.converged}};
}

StudyFile picture(const std::string& name, const std::string& title, const StaticSolution& solution) {
  const Eigen::Index nodes = solution.estimate.nodal_stress.cols();
  Eigen::VectorXd stress(nodes);
  for (Eigen::Index node = 0; node < nodes; ++node) stress[node] = von_mises(solution.estimate.nodal_stress.col(node));
  MeshPictureOptions options;
  options.title = title;
  options.unit = "";
  options.view = {1.0, -1.7, 1.1};
  return {name, mesh_picture_svg(solution.discretization.mesh, stress, Eigen::Matrix3Xd(3, 0), options)};
}

Plot convergence_plot(const LshapeSequences& study, const std::string& file, const std::string& title,
                      const std::string& label, const std::function<double(const LshapeStep&)>& error) {
  Plot plot{file, title, "degrees of freedom", label, true, true, {}};
  for (const auto& [scheme, steps] : study.sequences) {
    PlotSeries series{to_string(scheme), {}, {}, PlotLine::joined_with_slope};
    for (const LshapeStep& step : steps) {
      series.x.push_back(step.dofs);
      series.y.push_back(100.0 * error(step));
    }
    plot.series.push_back(series);
  }
  return plot;
}

/// Which part of the progress a stage takes.
struct ProgressSpan {
  double begin, end;
};

/// All passes over the three sequences, their medians into `study`, pictures and grids into `result`. False when the
/// user stopped it.
bool run_passes(const StudyContext& context, ProgressSpan span, LshapeSequences& study, StudyResult& result) {
  // Passes interleave the schemes, so that a slow minute of the machine does not fall on one of them alone.
  const int passes = context.quick ? 1 : 3;
  const int largest_uniform = context.quick ? 42483 : 316899;
  std::map<LshapeScheme, std::vector<std::vector<LshapeStep>>> runs;
  bool stopped = false;
  for (int pass = 0; pass < passes && !stopped; ++pass)
    for (const LshapeScheme scheme : lshape_schemes) {
      LshapeRunOptions options = study.options;
      options.enough_dofs = scheme == LshapeScheme::uniform ? largest_uniform : 40000;
      const auto steps = run_lshape(scheme, options, [&](const LshapeStep& step, const StaticSolution& solution) {
        const double done = std::min(1.0, std::log(step.dofs / 975.0 + 1e-9) / std::log(options.enough_dofs / 975.0));
        const double share = (3.0 * pass + static_cast<int>(scheme) + done) / (3.0 * passes);
        context.progress(span.begin + (span.end - span.begin) * share,
                         to_string(scheme) + " " + std::to_string(step.dofs) + " dofs, pass " +
                             std::to_string(pass + 1) + " of " + std::to_string(passes));
        // One picture of each adapted sequence, while single cells can still be seen.
        const std::string name = "mesh_" + to_string(scheme) + ".svg";
        const bool drawn = std::ranges::any_of(result.files, [&](const StudyFile& file) { return file.name == name; });
        if (scheme != LshapeScheme::uniform && step.dofs >= 3000 && !drawn)
          result.files.push_back(picture(name,
                                         to_string(scheme) + ": " + std::to_string(step.dofs) + " dofs, eta " +
                                             number_text("%.1f %%", 100.0 * step.eta),
                                         solution));
        if (pass == 0 && context.vtu_every > 0 && step.step % context.vtu_every == 0)
          result.files.push_back(
              {to_string(scheme) + "_" + std::to_string(step.step) + ".vtu",
               vtu_text(solution.discretization.mesh, solution.discretization.hanging,
                        vtu_fields(solution.discretization, solution.equilibrium.u, solution.estimate))});
        stopped = stopped || context.interrupted();
        return !stopped;
      });
      if (!steps.empty() && (pass == 0 || !stopped)) runs[scheme].push_back(steps);
      if (stopped) break;
    }
  for (const LshapeScheme scheme : lshape_schemes) {
    study.sequences[scheme];
    if (!runs[scheme].empty()) take_median_times(runs[scheme], study.sequences[scheme]);
  }
  return !stopped;
}

}  // namespace

StudyResult lshape_study(const StudyContext& context) {
  const auto [run_options, default_problem] = read_lshape_options(context);
  LshapeSequences study;
  study.options = run_options;
  StudyResult result;
  const std::filesystem::path data = std::filesystem::path(FINEGAUGE_SOURCE_DIR) / "reference_data";
  const PaperNumbers paper = paper_numbers("lshape");
  StoredReference reference = read_lshape_reference(data / "exact" / "lshape.json");
  std::string reference_method = "stored in reference_data/exact/lshape.json, recomputed by --full";
  // Where on the way from 0 to 1 each stage ends.
  const double reference_end = context.full && default_problem ? 0.5 : 0.0, sequences_end = 0.97;
  if (context.full && default_problem) {
    LshapeReferenceOptions options;
    options.progress = [&](double done, const std::string& doing) { context.progress(reference_end * done, doing); };
    const LshapeReferenceEnergy recomputed = lshape_reference_energy(options);
    result.checks.push_back(check("reference energy, recomputed", recomputed.value,
                                  reference.value - reference.uncertainty, reference.value + reference.uncertainty));
    reference = {recomputed.value, recomputed.uncertainty};
    reference_method = "recomputed in this run: graded conforming meshes, extrapolated";
  }
  if (default_problem) study.reference_energy = reference.value;

  const bool stopped = !run_passes(context, {reference_end, sequences_end}, study, result);

  bool converged = true;
  for (const LshapeScheme scheme : lshape_schemes)
    for (const LshapeStep& step : study.sequences[scheme]) {
      result.rows.push_back(to_json(study, step));
      if (!default_problem)
        result.rows.back()["true_error_reason"] = "the exact energy is known for the default problem only";
      converged = converged && step.converged;
    }
  if (stopped) {
    result.summary["interrupted"] = true;
    result.table = {"interrupted: " + std::to_string(result.rows.size()) + " meshes are kept"};
    return result;
  }

  const LshapeFindings findings = find_lshape_findings(study, paper);
  add_to_summary(findings, result.summary);
  // Stored energies, as `strain_energy` of the rows: half of ∫ ε:σ.
  result.summary["reference_energy"] = 0.5 * study.reference_energy;
  result.summary["reference_energy_uncertainty"] =
      default_problem ? 0.5 * reference.uncertainty : std::numeric_limits<double>::quiet_NaN();
  result.summary["reference_energy_method"] = reference_method;
  result.summary["true_error_targets"] = {{"equal_true_error", uniform_true_error(study, 42483)},
                                          {"equal_true_error_316899", uniform_true_error(study, 316899)}};

  const DirectComparison direct =
      compare_with_direct(study.options.problem, context.quick ? 1 : 3,
                          [&](double, const std::string& doing) { context.progress(sequences_end, doing); });
  result.summary["direct_comparison"] = to_json(direct);
  result.checks.push_back(check("all solves converged", converged ? 1.0 : 0.0, 1.0, 1.0));
  if (default_problem) add_lshape_checks(study, findings, context.quick, result.checks);

  std::vector<ComparisonRow> table = lshape_table(study, findings, direct, paper, reference.uncertainty, context.quick);
  const bool changed = !context.overrides.empty();
  if (changed)
    for (ComparisonRow& row : table) row.why = "another problem or parameter than the paper's (--set)";
  result.table = {
      "The paper's figure of the geometry is not available. Of the readings that were tried this one has the",
      "paper's slope of uniform refinement, so that row is an assumption and not a confirmation.",
      context.quick ? "Times: one pass, to be trusted within a factor of two."
                    : "Times: medians of three passes that interleave the schemes.",
      ""};
  add_comparison(table, result);
  result.scene = "built in: benchmarks/paper/lshape_problem.hpp, the same as reference_data/scenes/lshape.toml";
  result.plots = {convergence_plot(study, "convergence_eta.svg", "L-shape: estimated error", "eta [%]",
                                   [](const LshapeStep& step) { return step.eta; })};
  if (default_problem)
    result.plots.push_back(convergence_plot(study, "convergence_true_error.svg",
                                            "L-shape: true error in the energy norm", "true relative error [%]",
                                            [&](const LshapeStep& step) { return study.true_error(step); }));
  return result;
}

}  // namespace finegauge
