#include "benchmarks/profile/marking_patterns.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>
#include <utility>

namespace finegauge {
namespace {

double distance(MarkingPattern pattern, const Eigen::Vector3d& centre) {
  const Eigen::Vector3d from_middle = centre - Eigen::Vector3d::Constant(0.5);
  if (pattern == MarkingPattern::block) return from_middle.cwiseAbs().maxCoeff();
  constexpr double depth = 0.6;
  return Eigen::Vector3d(std::max(0.0, centre.x() - depth), from_middle.y(), from_middle.z()).norm();
}

/// The candidates in the order in which the pattern takes them.
void sort_by_pattern(const MarkedCube& cube, const Mesh& mesh, std::vector<int>& cells) {
  if (cube.pattern == MarkingPattern::scattered) {
    // Fisher and Yates by hand: what std::shuffle draws differs between libraries.
    std::mt19937_64 random(cube.seed);
    for (std::size_t left = cells.size(); left > 1; --left) std::swap(cells[left - 1], cells[random() % left]);
    return;
  }
  std::vector<std::pair<long, int>> order;
  for (const int cell : cells) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const int node : mesh.cells[cell]) centre += 0.125 * mesh.nodes.col(node);
    order.emplace_back(std::lround(1e9 * distance(cube.pattern, centre)), cell);  // equal ones are equal
  }
  std::sort(order.begin(), order.end());
  std::transform(order.begin(), order.end(), cells.begin(), [](const auto& entry) { return entry.second; });
}

}  // namespace

std::string to_string(MarkingPattern pattern) {
  switch (pattern) {
    case MarkingPattern::block:
      return "block";
    case MarkingPattern::needle:
      return "needle";
    default:
      return "scattered";
  }
}

RefinementForest refined_forest(const MarkedCube& cube) {
  if (!(cube.share > 0.0 && cube.share <= 1.0))
    throw std::invalid_argument("share: found " + std::to_string(cube.share) + ", allowed is above 0, at most 1");
  BoxMeshOptions box;
  box.cells = {cube.cells_per_edge, cube.cells_per_edge, cube.cells_per_edge};
  RefinementForest forest(box_mesh(box));
  for (int level = 0; level < cube.levels; ++level) {
    const Mesh mesh = forest.leaf_mesh();
    std::vector<int> candidates;
    for (int cell = 0; cell < mesh.cell_count(); ++cell)
      if (mesh.frames[cell].depth == level) candidates.push_back(cell);
    const double wanted = std::round(cube.share * static_cast<double>(candidates.size()));
    sort_by_pattern(cube, mesh, candidates);
    candidates.resize(static_cast<std::size_t>(std::max(1.0, wanted)));
    for (const int cell : candidates) forest.refine(mesh.forest_cell[cell], cube.refinement);
  }
  return forest;
}

std::vector<SupportCondition> cube_supports() { return {{"x_max", std::nullopt, {}}}; }

std::vector<SurfaceLoad> cube_loads() { return {{"x_min", LoadKind::traction, Eigen::Vector3d(-1.0, 0.0, 0.5)}}; }

}  // namespace finegauge
