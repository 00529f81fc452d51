#include "benchmarks/paper/liver_phantom_study.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "benchmarks/paper/needle_cases.hpp"
#include "benchmarks/paper/organ_cycles.hpp"
#include "benchmarks/paper/paper_numbers.hpp"
#include "benchmarks/paper/phantom_table.hpp"
#include "benchmarks/program/sha256.hpp"
#include "core/scene/scene_reader.hpp"

namespace finegauge {
namespace {

constexpr std::array liver_meshes = {"coarse", "fine", "adaptive-2x2x2", "adaptive-3x3x3"};

Scene phantom_scene(const std::string& mesh, const StudyContext& context) {
  std::vector<std::string> overrides;
  for (const auto& [key, value] : context.overrides) overrides.push_back(std::string(key).append("=").append(value));
  if (mesh == "adaptive-3x3x3") overrides.emplace_back("adapt.template=\"3x3x3\"");
  Scene scene = read_scene(scene_file("liver_phantom"), overrides);
  if (mesh == "coarse" || mesh == "fine") scene.dynamics->adapt.reset();
  if (mesh == "fine") {
    InitialRefinement everywhere;
    everywhere.refinement = {{2, 2, 2}};
    scene.refinements.push_back(everywhere);
  }
  return scene;
}

Plot loop_plot(const std::vector<NeedleCase*>& cases) {
  Plot plot;
  plot.file = "force_loop.svg";
  plot.title = "Force over travel of the tip, in and out";
  plot.x_label = "travel of the tip since first touch [mm]";
  plot.y_label = "needle-tissue force along the axis [N]";
  plot.log_x = plot.log_y = false;
  for (const NeedleCase* one : cases) {
    PlotSeries series{one->name, {}, {}};
    for (std::size_t k = 0; k < one->curve.travel.size(); ++k) {
      series.x.push_back(1e3 * one->curve.travel[k]);
      series.y.push_back(one->curve.force[k]);
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

/// What each mesh's envelope is off the fine one's, which the loops themselves do not show.
Plot envelope_plot(const std::vector<NeedleCase>& all, const NeedleCase& fine) {
  Plot plot;
  plot.file = "envelopes_off_fine.svg";
  plot.title = "Peaks of the force on the way in, less those of the fine mesh";
  plot.x_label = "travel of the tip since first touch [mm]";
  plot.y_label = "force off that of the fine mesh [N]";
  plot.log_x = plot.log_y = false;
  const Envelope exact = upper_envelope(fine.curve);
  for (const NeedleCase& one : all) {
    const Envelope here = upper_envelope(one.curve);
    if (&one == &fine || here.travel.size() < 2 || exact.travel.size() < 2) continue;
    const double first = std::max(here.travel.front(), exact.travel.front());
    const double last = std::min(here.travel.back(), exact.travel.back());
    constexpr int samples = 200;
    PlotSeries series{one.name, {}, {}};
    for (int k = 0; k <= samples; ++k) {
      const double x = first + (last - first) * k / samples;
      series.x.push_back(1e3 * x);
      series.y.push_back(here.at(x) - exact.at(x));
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

int most_dofs(const NeedleCase& one) {
  int most = 0;
  for (const MotionFrame& made : one.run.frames) most = std::max(most, made.report.frame.dofs);
  return most;
}

}  // namespace

StudyResult liver_phantom_study(const StudyContext& context) {
  StudyResult result;
  const std::filesystem::path file = scene_file("liver_phantom");
  result.scene = file.string();
  result.sha256 = sha256_of_file(file.string());
  const PaperNumbers paper = paper_numbers("liver_phantom");
  const double study_share = context.full ? 0.05 : 1.0;  // of the time; the rest are the cycles of --full

  std::vector<NeedleCase> all;
  all.reserve(liver_meshes.size());
  std::vector<NeedleCase*> cases;
  for (const char* mesh : liver_meshes) {
    all.push_back(needle_case(mesh, phantom_scene(mesh, context), 0, Strokes::all));
    cases.push_back(&all.back());
    if (context.quick) all.back().run.planned_frames = (all.back().run.planned_frames + 2) / 3;
  }
  if (!run_side_by_side(cases, context,
                        [&](double share) { context.progress(study_share * share, "four meshes side by side"); }))
    return result;

  const NeedleCase &coarse = all[0], &fine = all[1];
  const double coarse_off = envelope_distance(coarse.curve, fine.curve);
  const double coarse_off_in = force_difference(way_in(coarse.curve), way_in(fine.curve));
  const double coarse_off_out = force_difference(way_back(coarse.curve), way_back(fine.curve));
  for (const NeedleCase& one : all) {
    Json row = {{"mesh", one.name}};
    if (!context.quick) row["loop_area"] = loop_area(one.curve);
    row["envelope_distance"] = envelope_distance(one.curve, fine.curve);
    row["rms_distance"] = rms_distance(one.curve, fine.curve);
    if (!context.quick) row["rms_distance_out"] = rms_distance(way_back(one.curve), way_back(fine.curve));
    row.update(case_row(one, result.files));
    result.rows.push_back(std::move(row));
    result.files.push_back(case_picture(one, "liver phantom, " + one.name));
    int unconverged = 0;
    for (const MotionFrame& frame : one.run.frames) unconverged += !frame.report.frame.converged;
    result.checks.push_back(check("unconverged_frames." + one.name, unconverged, 0.0, 0.0));
    if (!context.quick) {
      result.checks.push_back(check("final_force." + one.name, one.curve.force.back(), 0.0, 0.0));
      result.checks.push_back(
          check("deepest_over_paper." + one.name,
                *std::max_element(one.curve.travel.begin(), one.curve.travel.end()) / paper.value("depth"), 0.9, 1.1));
    }
  }
  if (!context.quick)
    result.checks.push_back(check("coarse_off_in_over_out", coarse_off_in / coarse_off_out, 1.2, 10.0));
  result.checks.push_back(check("dofs_coarse_over_paper",
                                coarse.run.frames.front().report.frame.dofs / paper.value("dofs_coarse"), 0.9, 1.1));
  result.checks.push_back(
      check("dofs_fine_over_paper", fine.run.frames.front().report.frame.dofs / paper.value("dofs_fine"), 0.75, 1.25));
  for (std::size_t i = 2; i < all.size(); ++i) {
    constexpr double no_limit = 1e6;  // two curves that are the same would be past it
    result.checks.push_back(
        check("envelope_gain." + all[i].name, coarse_off / envelope_distance(all[i].curve, fine.curve), 2.0, no_limit));
    result.checks.push_back(check("dofs_max_over_fine." + all[i].name,
                                  most_dofs(all[i]) / static_cast<double>(fine.run.frames.front().report.frame.dofs),
                                  0.05, 1.0));
  }

  for (const NeedleCase& one : all)
    result.summary["cases"][one.name] = {{"dofs_max", most_dofs(one)},
                                         {"loop_area", context.quick ? Json() : Json(loop_area(one.curve))},
                                         {"envelope_distance", envelope_distance(one.curve, fine.curve)},
                                         {"frames_per_second", one.frames_per_second()}};
  result.plots.push_back(loop_plot(cases));
  if (Plot envelopes = envelope_plot(all, fine); !envelopes.series.empty())
    result.plots.push_back(std::move(envelopes));

  const auto percent = [](double value) { return short_number(100.0 * value) + " %"; };
  const auto of = [&](std::size_t i) { return percent(envelope_distance(all[i].curve, fine.curve)); };
  const auto times_nearer = [&](std::size_t i) {
    return short_number(coarse_off / envelope_distance(all[i].curve, fine.curve), "%.2g");
  };
  double last_force = 0.0;
  for (const NeedleCase& one : all) last_force = std::max(last_force, std::abs(one.curve.force.back()));
  add_comparison(
      {
          {"dofs, coarse", paper("dofs_coarse"), short_number(coarse.run.frames.front().report.frame.dofs, "%.0f"),
           "the paper's mesh is not published; cell size chosen to match", paper.place("dofs_coarse")},
          {"dofs, fine", paper("dofs_fine"), short_number(fine.run.frames.front().report.frame.dofs, "%.0f"),
           "each coarse cell in eight: nested", paper.place("dofs_fine")},
          {"dofs, most, 2x2x2", paper("dofs_max_2x2x2"), short_number(most_dofs(all[2]), "%.0f"),
           "θ alone decides; the paper's mesh is another, and so are the cells along its needle",
           paper.place("dofs_max_2x2x2")},
          {"dofs, most, 3x3x3", paper("dofs_max_3x3x3"), short_number(most_dofs(all[3]), "%.0f"),
           "the same; a cell in 27 brings three to four times as many nodes as one in 8",
           paper.place("dofs_max_3x3x3")},
          {"force when the needle is out", paper("loop_closes_at_zero"),
           context.quick ? std::string("-") : short_number(last_force) + " N", "largest of the four; no rows, no force",
           paper.place("loop_closes_at_zero")},
          {"envelope off fine: coarse", "-", of(0), "L² over the travel between first and last cut"},
          {"envelope off fine: 2x2x2 / 3x3x3", paper("adaptive_nearer_to_fine"), of(2) + " / " + of(3),
           "3x3x3 has smaller cells at the needle than the fine mesh itself", paper.place("adaptive_nearer_to_fine")},
          {"nearer to fine than coarse, times", "-", times_nearer(2) + " / " + times_nearer(3),
           "the two lines above; the paper's curves have no numbers"},
          {"force off fine, coarse: in / out", paper("stronger_on_insertion"),
           short_number(coarse_off_in) + " N / " + short_number(coarse_off_out) + " N",
           "root mean square over the travel: cuts a little sooner or later, and friction five times as large on the "
           "way "
           "in",
           paper.place("stronger_on_insertion")},
      },
      result);
  if (context.full) add_organ_cycles(context, study_share, result);
  return result;
}

}  // namespace finegauge
