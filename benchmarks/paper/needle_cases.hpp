#pragma once

#include <functional>
#include <string>
#include <vector>

#include "benchmarks/measure/force_curves.hpp"
#include "benchmarks/program/motion_run.hpp"
#include "benchmarks/program/study.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// One insertion of a study: its scene, and what became of it.
struct NeedleCase {
  std::string name;  ///< of its files
  Scene scene;
  MotionRun run;
  ForceCurve curve;  ///< of all frames
  double mean_dofs = 0.0;
  double unestimated_ms = 0.0;  ///< all frames, without the estimate of a mesh that does not use it
  Insertion insertion;          ///< in its last state
  InsertionProblem problem;

  double frames_per_second() const { return 1e3 * static_cast<double>(run.frames.size()) / unestimated_ms; }
};

/// The scene file of that name among those that come with the program; throws UsageError when there is none.
std::filesystem::path scene_file(const std::string& name);

/// Which of a scene's strokes a case makes: the first one, which is the insertion, or all in the scene's own duration.
enum class Strokes { first, all };

/// A case before its first frame. `frames` > 0 ends it earlier.
NeedleCase needle_case(const std::string& name, Scene scene, int frames = 0, Strokes strokes = Strokes::first);

/// Advances all cases side by side, a frame of each in turn, so that what disturbs the machine disturbs all alike.
/// False when interrupted; the cases hold what was finished.
bool run_side_by_side(const std::vector<NeedleCase*>& cases, const StudyContext& context,
                      const std::function<void(double)>& progress);

/// Summary keys of the run, name, and the case's CSV (added to `files`).
Json case_row(const NeedleCase& the_case, std::vector<StudyFile>& files);

/// The body as it is at the end, coloured by stress.
StudyFile case_picture(const NeedleCase& the_case, const std::string& title);

/// The body as it is at the end, cut open along the needle, coloured by stress and by error (needle_sections.hpp).
std::vector<StudyFile> case_sections(const NeedleCase& the_case);

}  // namespace finegauge
