#include "verification/studies/atlas_scene.hpp"

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>

#include "core/scene/check_held.hpp"
#include "core/scene/moving_scene.hpp"
#include "core/scene/scene_reader.hpp"
#include "core/scene/start_forest.hpp"

namespace finegauge {
namespace {

/// A folder of this process that lives as long as this value.
class Folder {
 public:
  Folder() : path_(std::filesystem::temp_directory_path() / ("finegauge_atlas_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::filesystem::path write(const std::string& name, const std::string& content) const {
    std::ofstream(path_ / name, std::ios::binary) << content;
    return path_ / name;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::string without(std::string text, const std::string& part) {
  for (std::size_t at; (at = text.find(part)) != std::string::npos;) text.erase(at, part.size());
  return text;
}

}  // namespace

std::string filled(std::string text, std::span<const std::pair<std::string_view, double>> values) {
  for (const auto& [name, value] : values) {
    char number[32];
    std::snprintf(number, sizeof number, "%.17g", value);
    const std::string token = "$" + std::string(name);
    for (std::size_t at = 0; (at = text.find(token, at)) != std::string::npos;) text.replace(at, token.size(), number);
  }
  if (text.find('$') != std::string::npos) throw std::logic_error("a scene's text with a number missing: " + text);
  return text;
}

Scene scene_from_text(const std::string& text, std::span<const AtlasFile> files) {
  const Folder folder;
  for (const AtlasFile& file : files) folder.write(file.name, file.content);
  try {
    Scene scene = read_scene(folder.write("scene.toml", text));
    scene.file = "scene.toml";
    return scene;
  } catch (const SceneError& error) {
    throw SceneError(without(error.what(), folder.path().string() + "/"));
  }
}

StaticEnd solve_scene(const std::string& text, std::span<const AtlasFile> files) {
  Scene scene = scene_from_text(text, files);
  if (scene.dynamics || scene.adapt) throw std::logic_error("not a static scene of one step");
  RefinementForest forest = start_forest(scene);
  const StaticProblem problem{scene.material, support_conditions(scene), scene.loads,    body_force(scene),
                              scene.solver,   spring_supports(scene),    scene.estimator};
  Discretization d = discretize(forest, forest.leaf_mesh(), problem.material, problem.supports, problem.springs);
  check_held(scene, forest.topology(), d);
  FactorCache factors;
  StaticSolution solution = solve_static(forest, std::move(d), problem, nullptr, factors);
  // Its pattern and shapes refer to themselves only, so that the value may be moved.
  return {std::move(scene), std::move(forest), std::move(solution)};
}

std::string why_unsolved(const Equilibrium& equilibrium) {
  if (equilibrium.converged) return {};
  char text[160];
  std::snprintf(text, sizeof text,
                "did not converge and says so: relative residual %.2g after %d linear and %d outer iterations",
                equilibrium.relative_residual, equilibrium.linear_iterations, equilibrium.newton_iterations);
  return text;
}

void run_scene(const Scene& scene, const std::function<bool(const FrameView&)>& observe) {
  RefinementForest forest = start_forest(scene);
  const int frames = frame_count(scene.dynamics.value());
  if (scene.needle) {
    const InsertionProblem problem = insertion_problem(scene);
    Insertion insertion = start_insertion(std::move(forest), problem);
    for (int i = 0; i < frames; ++i)
      if (!observe({advance_frame(problem, insertion), insertion.tissue, &insertion})) return;
    return;
  }
  const MotionProblem problem = motion_problem(scene);
  Tissue tissue = start_tissue(std::move(forest), problem);
  EnergyLedger energy;
  InsertionReport report;
  for (int i = 0; i < frames; ++i) {
    report.frame = advance_frame(problem, tissue, energy);
    if (!observe({report, tissue, nullptr})) return;
  }
}

AtlasPoint scene_point(double value, const std::string& text, const std::function<AtlasPoint()>& judged,
                       std::vector<AtlasFile> files) {
  announce_scene(text, files);
  AtlasPoint point = point_or_refusal(value, judged);
  point.value = value;
  point.scene = text;
  point.files = std::move(files);
  return point;
}

}  // namespace finegauge
