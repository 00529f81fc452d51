#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/program/result_document.hpp"
#include "benchmarks/program/static_run.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// Writes what a user can look at while the loop goes on, and the picture of its last mesh.
class StaticFiles {
 public:
  StaticFiles(std::filesystem::path directory, const Scene& scene, int vtu_every);
  void add_step(const StaticView& view, bool last);

 private:
  void add_vtu(const StaticView& view);
  void draw_mesh(const StaticView& view) const;

  std::filesystem::path directory_;
  const Scene& scene_;
  int vtu_every_;
  std::vector<std::pair<double, std::string>> series_;
};

Json summarize(const StaticRun& run);

/// Draws the error over the dofs; why it was not drawn, if so.
std::optional<std::string> draw_error(const StaticRun& run, const std::string& name,
                                      const std::filesystem::path& directory);

/// The table on standard output.
void print_steps(const Scene& scene, const StaticRun& run, const std::vector<std::string>& notes);

}  // namespace finegauge
