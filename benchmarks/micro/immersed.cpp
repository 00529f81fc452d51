#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/mesh/immersed_body.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "verification/support/closed_surfaces.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"

/// An organ of the size of a liver, 5,120 triangles in some 1,500 lattice cells: what its shares of material cost when
/// it is built, when cells are refined, and what one more inside test costs. `each` is the time per cell or point [s].
namespace {

using namespace finegauge;
using Eigen::Vector3d;

constexpr double edge = 0.0113;  ///< of a base cell [m]

TriangleSurface organ_surface() { return closed_ellipsoid(16, {0.09, 0.07, 0.055}, {0.01, 0.02, -0.01}); }

benchmark::Counter each(std::size_t count) {
  return {static_cast<double>(count), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert};
}

double material_volume(const Mesh& mesh, const RefinementForest& forest) {
  double sum = 0.0;
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    sum += mesh.fraction[cell] * share_of_base_cell(forest.cell(mesh.forest_cell[cell]));
  return sum * edge * edge * edge;
}

void build_organ(benchmark::State& state) {
  const TriangleSurface surface = organ_surface();
  BaseMesh mesh;
  for (auto _ : state) {
    mesh = immersed_mesh(surface, {Vector3d::Constant(edge), {}});
    benchmark::ClobberMemory();
  }
  double volume = 0.0;
  for (const double share : mesh.body->share) volume += share * edge * edge * edge;
  if (!(std::abs(volume / enclosed_volume(surface) - 1.0) < 1e-9))
    state.SkipWithError("the cells do not hold the body");
  state.counters["triangles"] = surface.triangle_count();
  state.counters["cells"] = static_cast<double>(mesh.cells.size());
  state.counters["each"] = each(mesh.cells.size());
}
BENCHMARK(build_organ)->Unit(benchmark::kMillisecond);

/// Which base cells are refined.
enum class Cells { cut, inside };

/// Refines all base cells of a kind and coarsens them again; the time is of a refined cell. Without the body the same
/// mesh shows what the topology alone takes.
void refine_organ(benchmark::State& state, Cells cells, bool with_body) {
  BaseMesh base = immersed_mesh(organ_surface(), {Vector3d::Constant(edge), {}});
  std::vector<int> refined;
  for (int cell = 0; cell < static_cast<int>(base.cells.size()); ++cell)
    if ((base.body->share[cell] < 1.0) == (cells == Cells::cut)) refined.push_back(cell);
  const double volume = enclosed_volume(base.body->surface);
  if (!with_body) base.body = nullptr;
  RefinementForest forest(base);
  const auto divisions = static_cast<std::uint8_t>(state.range(0));
  const auto refine = [&] {
    for (const int cell : refined) forest.refine(cell, {{divisions, divisions, divisions}});
  };
  for (auto _ : state) {
    refine();
    for (auto cell = refined.rbegin(); cell != refined.rend(); ++cell) forest.coarsen(*cell);
    benchmark::ClobberMemory();
  }
  refine();
  const Mesh mesh = forest.leaf_mesh();
  if (with_body ? !(std::abs(material_volume(mesh, forest) / volume - 1.0) < 1e-9) : !mesh.fraction.empty())
    state.SkipWithError("the leaves do not hold the body");
  state.counters["cells"] = static_cast<double>(refined.size());
  state.counters["each"] = each(refined.size());
}
BENCHMARK_CAPTURE(refine_organ, cut, Cells::cut, true)->ArgName("divisions")->Arg(2)->Arg(3);
BENCHMARK_CAPTURE(refine_organ, inside, Cells::inside, true)->ArgName("divisions")->Arg(2)->Arg(3);
BENCHMARK_CAPTURE(refine_organ, cut_without_body, Cells::cut, false)->ArgName("divisions")->Arg(2)->Arg(3);

void inside_tests(benchmark::State& state) {
  const BaseMesh mesh = immersed_mesh(organ_surface(), {Vector3d::Constant(edge), {}});
  const BoundingBox box = bounding_box(mesh.body->surface);
  std::mt19937 generator(1);
  std::vector<Vector3d> points;
  for (int k = 0; k < 4096; ++k)
    points.push_back(0.5 * (box.lower + box.upper) +
                     0.5 * (box.upper - box.lower).cwiseProduct(random_vector(generator)));
  int inside = 0;
  for (auto _ : state) {
    inside = 0;
    for (const Vector3d& X : points) inside += contains(*mesh.body, X);
    benchmark::DoNotOptimize(inside);
  }
  // An ellipsoid fills π / 6 of its box; 4,096 points know that to 0.008, the polyhedron is less than 0.01 smaller.
  if (!(std::abs(inside / 4096.0 - 0.52) < 0.03)) state.SkipWithError("another share of points is inside");
  state.counters["inside"] = inside;
  state.counters["each"] = each(points.size());
}
BENCHMARK(inside_tests)->Unit(benchmark::kMicrosecond);

}  // namespace
