#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/program/motion_run.hpp"
#include "benchmarks/program/needle_sections.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// Writes what a user can look at while the frames go on: a VTU of the body every so many frames (with the needle as a
/// curve beside it, and an immersed body's surface as triangles), pictures of a body with a needle cut open
/// (needle_sections.hpp), and a picture of the last mesh; in one colour where the body is at rest again
/// (energy_at_rest), as the stress that is left there is round-off.
class MotionFiles {
 public:
  MotionFiles(std::filesystem::path directory, const Scene& scene, int vtu_every);
  void add_frame(const MotionView& view, bool last);

 private:
  const std::vector<MaterialPoint>& surface_points(const BaseMesh& base);
  void add_vtu(const MotionView& view, const ErrorEstimate& estimate);
  void draw_mesh(const MotionView& view, const ErrorEstimate& estimate) const;

  std::filesystem::path directory_;
  const Scene& scene_;
  int vtu_every_;
  std::optional<NeedleSections> sections_;     ///< none without a needle
  double largest_elastic_energy_ = 0.0;        ///< of the frames so far [J]
  std::vector<MaterialPoint> surface_points_;  ///< at the vertices of an immersed body's surface, once they are needed
  std::vector<std::pair<double, std::string>> series_, needle_series_, surface_series_;
};

/// Draws NAME_force.svg (with a needle) and NAME_dofs.svg; returns why one was not drawn.
std::vector<std::string> draw_motion(const Scene& scene, const MotionRun& run, const std::filesystem::path& directory);

/// The table on standard output: about twenty frames and every event, then the summary.
void print_motion(const Scene& scene, const MotionRun& run, const Json& summary, const std::vector<std::string>& notes);

}  // namespace finegauge
