#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/mesh/body_location.hpp"
#include "core/mesh/hanging_nodes.hpp"
#include "core/mesh/immersed_body.hpp"
#include "core/space/discretization.hpp"
#include "verification/support/closed_surfaces.hpp"

/// What a needle asks of an immersed organ's surface in a frame: about 5,000 triangles in 300 cells, those at the place
/// of the insertion refined, and a bent displacement. A frame outside asks `entry` up to twice and `inside` once; a
/// frame inside asks nothing but `inside` at the end of a cut.
namespace {

using namespace finegauge;

struct Organ {
  RefinementForest forest;
  Mesh mesh;
  Eigen::Matrix3Xd u;
};

/// An ellipsoid of 1.5 litres in cells of a sixth of its height; cells near the end of the x axis are halved twice.
Organ make_organ() {
  const Eigen::Vector3d half_axes(0.1, 0.07, 0.051);
  ImmersedMeshOptions options;
  options.cell_size.setConstant(0.017);
  RefinementForest forest(immersed_mesh(closed_ellipsoid(16, half_axes), options));
  for (int sweep = 0; sweep < 2; ++sweep) {
    const Mesh mesh = forest.leaf_mesh();
    for (int cell = 0; cell < mesh.cell_count(); ++cell)
      if ((mesh.nodes.col(mesh.cells[cell][0]) - half_axes.x() * Eigen::Vector3d::UnitX()).norm() < 0.03)
        forest.refine(mesh.forest_cell[cell], {{2, 2, 2}});
  }
  Mesh mesh = forest.leaf_mesh();
  const HangingNodes hanging = find_hanging_nodes(forest, mesh);
  Eigen::Matrix3Xd u(3, mesh.node_count());
  for (int node = 0; node < mesh.node_count(); ++node) {
    const Eigen::Vector3d X = mesh.nodes.col(node);
    u.col(node) = 0.01 * Eigen::Vector3d(std::sin(20.0 * X.y()), std::cos(15.0 * X.x()), 10.0 * X.x() * X.y());
  }
  u = expand(hanging, gather(hanging, u));
  return {std::move(forest), std::move(mesh), std::move(u)};
}
const Organ& organ() {
  static const Organ made = make_organ();
  return made;
}
void count_organ(benchmark::State& state) {
  state.counters["triangles"] = organ().forest.base().body->surface.triangle_count();
  state.counters["cells"] = organ().mesh.cell_count();
}

/// A place on the axis through the end that is refined, at rest `depth` metres inside, and where it is now.
Eigen::Vector3d carried_point(double depth) {
  const Eigen::Vector3d X(0.1 - depth, 0.001, 0.002);
  const auto point = locate_at_rest(organ().forest.base(), X);
  return X + interpolate(organ().mesh, organ().u, find_leaf(organ().forest, organ().mesh, *point));
}

/// A frame's way of 0.2 mm: through the surface, or `away` from it.
void immersed_entry(benchmark::State& state, double away) {
  const Organ& made = organ();
  const Eigen::Vector3d target = carried_point(0.0005), outward = (carried_point(0.0004) - target).normalized();
  // The surface is between 0.4 mm and 0.6 mm off the target: a way of 2 mm crosses it.
  const double way = away == 0.0 ? 2e-3 : 2e-4;
  const Eigen::Vector3d from = target + (1e-3 + away) * outward, to = from - way * outward;
  for (auto _ : state) {
    auto hit = first_body_entry(made.forest.base(), made.mesh, made.u, from, to);
    benchmark::DoNotOptimize(hit);
  }
  const bool met = first_body_entry(made.forest.base(), made.mesh, made.u, from, to).has_value();
  if (met != (away == 0.0)) state.SkipWithError("the surface was met where it is not, or missed");
  count_organ(state);
}
BENCHMARK_CAPTURE(immersed_entry, at_the_surface, 0.0)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(immersed_entry, near_it, 0.004)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(immersed_entry, far_away, 0.05)->Unit(benchmark::kMicrosecond);

/// A needle that all but slides along the surface: 20 mm, in the middle a micrometre under it.
void immersed_grazing(benchmark::State& state) {
  const Organ& made = organ();
  const BaseMesh& base = made.forest.base();
  const auto under = nearest_body_surface(base, made.mesh, made.u, carried_point(0.0008), 1e-3);
  if (!under) {
    state.SkipWithError("no surface near");
    return;
  }
  const Eigen::Vector3d middle = under->position + 1e-6 * under->inward, way = 0.01 * under->inward.unitOrthogonal();
  for (auto _ : state) {
    auto hit = first_body_entry(base, made.mesh, made.u, middle - way, middle + way);
    benchmark::DoNotOptimize(hit);
  }
  const auto hit = first_body_entry(base, made.mesh, made.u, middle - way, middle + way);
  if (locate_in_body(base, made.mesh, made.u, middle - way) || !locate_in_body(base, made.mesh, made.u, middle))
    state.SkipWithError("the segment does not graze the surface");
  else if (!hit || !(hit->fraction < 0.5))
    state.SkipWithError("the surface was missed where it is grazed");
  count_organ(state);
}
BENCHMARK(immersed_grazing)->Unit(benchmark::kMicrosecond);

void immersed_inside(benchmark::State& state, double depth) {
  const Organ& made = organ();
  const Eigen::Vector3d x = carried_point(depth);
  for (auto _ : state) {
    auto found = locate_in_body(made.forest.base(), made.mesh, made.u, x);
    benchmark::DoNotOptimize(found);
  }
  if (!locate_in_body(made.forest.base(), made.mesh, made.u, x)) state.SkipWithError("a point inside was not located");
  count_organ(state);
}
BENCHMARK_CAPTURE(immersed_inside, near_the_surface, 0.005)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(immersed_inside, at_the_middle, 0.1)->Unit(benchmark::kMicrosecond);

/// The search under a tip that slides on the surface: 1 mm around it.
void immersed_nearest(benchmark::State& state) {
  const Organ& made = organ();
  const Eigen::Vector3d x = carried_point(0.0008);
  for (auto _ : state) {
    auto hit = nearest_body_surface(made.forest.base(), made.mesh, made.u, x, 1e-3);
    benchmark::DoNotOptimize(hit);
  }
  if (!nearest_body_surface(made.forest.base(), made.mesh, made.u, x, 1e-3)) state.SkipWithError("no surface near");
  count_organ(state);
}
BENCHMARK(immersed_nearest)->Unit(benchmark::kMicrosecond);

}  // namespace
