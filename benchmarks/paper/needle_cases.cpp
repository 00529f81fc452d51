#include "benchmarks/paper/needle_cases.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "benchmarks/program/command.hpp"
#include "benchmarks/program/frame_rows.hpp"
#include "benchmarks/program/known_scenes.hpp"
#include "benchmarks/program/mesh_picture.hpp"
#include "benchmarks/program/needle_sections.hpp"
#include "benchmarks/program/processor_time.hpp"
#include "core/elasticity/cell_response.hpp"
#include "core/mesh/immersed_body.hpp"
#include "core/scene/moving_scene.hpp"
#include "core/scene/start_forest.hpp"
#include "core/stopwatch.hpp"

namespace finegauge {
namespace {

ForceCurve force_curve(const MotionRun& run, const ContactRules& rules) {
  ForceCurve curve;
  double margin_before = 0.0;
  for (const MotionFrame& frame : run.frames) {
    const InsertionReport& report = frame.report;
    const int index = static_cast<int>(curve.travel.size());
    curve.travel.push_back(report.tip_displacement);
    curve.force.push_back(report.force);
    const ForcePeak now{report.tip_displacement, report.force};
    const ForcePeak before = index > 0 ? ForcePeak{curve.travel[index - 1], curve.force[index - 1]} : now;
    const double margin = report.tip_force - rules.cut_strength - rules.friction_in * report.tip_lateral_force;
    for (const ContactEvent& event : report.events) {
      if (event.kind == ContactEventKind::puncture && curve.puncture < 0) curve.puncture = index;
      if (event.kind == ContactEventKind::cut) curve.peaks.push_back(passing_point(margin_before, before, margin, now));
    }
    margin_before = margin;
  }
  return curve;
}

}  // namespace

std::filesystem::path scene_file(const std::string& name) {
  for (const std::filesystem::path& file : known_scenes())
    if (file.stem() == name) return file;
  throw UsageError("the scene " + name + ".toml, which this study runs, is not in reference_data/scenes");
}

NeedleCase needle_case(const std::string& name, Scene scene, int frames, Strokes strokes) {
  if (strokes == Strokes::first) {
    scene.needle->drive.strokes.resize(1);
    scene.dynamics->duration = total_duration(scene.needle->drive);
  }
  InsertionProblem problem = insertion_problem(scene);
  Insertion insertion = start_insertion(start_forest(scene), problem);
  NeedleCase made{name, std::move(scene), {}, {}, 0.0, 0.0, std::move(insertion), std::move(problem)};
  made.run.planned_frames = frame_count(*made.scene.dynamics);
  if (frames > 0) made.run.planned_frames = std::min(made.run.planned_frames, frames);
  made.run.buckling_load = buckling_load_fixed_free(made.problem.needle);
  return made;
}

bool run_side_by_side(const std::vector<NeedleCase*>& cases, const StudyContext& context,
                      const std::function<void(double)>& progress) {
  int longest = 0;
  for (const NeedleCase* one : cases) longest = std::max(longest, one->run.planned_frames);
  for (int frame = 0; frame < longest; ++frame) {
    for (NeedleCase* one : cases) {
      if (frame >= one->run.planned_frames) continue;
      MotionFrame made;
      const double processor_before = processor_ms();
      Stopwatch watch;
      made.report = advance_frame(one->problem, one->insertion);
      made.frame_ms = watch.lap();
      made.processor_ms = processor_ms() - processor_before;
      one->unestimated_ms += made.frame_ms - (one->scene.dynamics->adapt ? 0.0 : made.report.frame.times.estimate_ms);
      one->run.frames.push_back(std::move(made));
    }
    if (context.interrupted()) return false;
    if ((frame + 1) % std::max(1, longest / 20) == 0) progress((frame + 1.0) / longest);
  }
  for (NeedleCase* one : cases) {
    one->run.stopped_because = "the duration is over";
    one->run.final_state = state_values(one->insertion);
    one->curve = force_curve(one->run, one->problem.contact);
    double dofs = 0.0;
    for (const MotionFrame& made : one->run.frames) dofs += made.report.frame.dofs;
    one->mean_dofs = dofs / static_cast<double>(one->run.frames.size());
  }
  return true;
}

Json case_row(const NeedleCase& the_case, std::vector<StudyFile>& files) {
  Json rows = Json::array();
  for (const MotionFrame& frame : the_case.run.frames) rows.push_back(to_json(frame, the_case.scene));
  const std::string file = the_case.name + ".csv";
  files.push_back({file, to_csv(rows)});
  Json row = summarize(the_case.scene, the_case.run);
  row["curve"] = file;
  row["mean_dofs"] = the_case.mean_dofs;
  row["frames_per_second_without_unused_estimate"] = the_case.frames_per_second();
  return row;
}

StudyFile case_picture(const NeedleCase& the_case, const std::string& title) {
  const Tissue& tissue = the_case.insertion.tissue;
  const ErrorEstimate estimate = estimate_error_spr(tissue.mesh.d, tissue.state.u);
  const Eigen::Index nodes = estimate.nodal_stress.cols();
  Eigen::VectorXd stress(nodes);
  for (Eigen::Index node = 0; node < nodes; ++node) stress[node] = von_mises(estimate.nodal_stress.col(node));
  MeshPictureOptions options;
  options.title = title;
  options.deformation_scale = suggested_deformation_scale(tissue.mesh.d.mesh, tissue.state.u);
  return {the_case.name + "_mesh.svg", mesh_picture_svg(tissue.mesh.d.mesh, stress, tissue.state.u, options)};
}

std::vector<StudyFile> case_sections(const NeedleCase& the_case) {
  const Tissue& tissue = the_case.insertion.tissue;
  const ErrorEstimate estimate = estimate_error_spr(tissue.mesh.d, tissue.state.u);
  Scene scene = the_case.scene;
  scene.name = the_case.name;
  const BaseMesh& base = tissue.forest.base();
  const auto points = base.body ? points_of_surface(base, base.body->surface) : std::vector<MaterialPoint>{};
  std::vector<StudyFile> files;
  for (auto& [name, svg] :
       section_pictures(scene, the_case.insertion, estimate, points,
                        {"depth", the_case.run.frames.back().report.insertion_depth, estimate.energy_norm}))
    files.push_back({name, std::move(svg)});
  return files;
}

}  // namespace finegauge
