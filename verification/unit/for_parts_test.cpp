#include "core/parallel/for_parts.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/adapt/error_estimate.hpp"
#include "core/solve/direct_solver.hpp"
#include "core/solve/multigrid.hpp"
#include "core/space/assembly.hpp"
#include "core/space/free_surface.hpp"
#include "core/tissue_forces.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/scrambled_mesh.hpp"

using namespace finegauge;

namespace {

class Threads {
 public:
  explicit Threads(int count) : before_(thread_count()) { set_thread_count(count); }
  ~Threads() { set_thread_count(before_); }
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

 private:
  int before_;
};

bool has_threads() {
  const Threads two(2);
  return thread_count() == 2;
}

/// All that several threads share, of a bent and turned body with hanging nodes, one list of numbers after the other.
std::vector<double> shared_stages(Kinematics kinematics, CellShape shape) {
  std::mt19937 generator(7);
  BoxMeshOptions options;
  options.shape = shape;
  options.cells = shape == CellShape::hexahedron ? std::array{7, 6, 6} : std::array{4, 4, 4};
  RefinementForest forest(distorted_box(options, 0.05, generator));
  refine_randomly(forest, {all_templates(shape), 40, 2, 3000}, generator);
  Material material;
  material.youngs_modulus = 10.0;
  material.poisson_ratio = 0.4;
  material.kinematics = kinematics;
  const std::vector<SupportCondition> supports = {{"x_min", std::nullopt, {}}};
  Discretization d = discretize(forest, material, supports);
  d.free_surface = find_free_surface(forest, d, supports, {});
  d.driven_by_loads = true;
  Eigen::VectorXd reduced(d.dof_count());
  for (double& value : reduced) value = 0.02 * random_number(generator);
  const Eigen::Matrix3Xd u = expand(d.hanging, reduced);

  std::vector<double> all;
  const auto add = [&all](const auto& matrix) { all.insert(all.end(), matrix.data(), matrix.data() + matrix.size()); };
  BlockMatrix<double> A = assemble_stiffness(d, u);
  add(A.values);
  apply_supports(d.supports, A);
  Eigen::VectorXd product;
  multiply(A, reduced, product);
  add(product);
  add(internal_forces(d, u));
  const TissueForces forces = tissue_forces(d, u, 2.0 * u);
  add(forces.internal);
  add(forces.stiff);
  for (const Estimator estimator : {Estimator::spr, Estimator::spr_edges}) {
    const ErrorEstimate estimate = estimate_error(d, u, estimator);
    add(estimate.nodal_stress);
    add(estimate.eta);
    add(estimate.direction);
    all.push_back(estimate.total);
    all.push_back(estimate.energy_norm);
  }
  const MeshHierarchy hierarchy = build_hierarchy(forest, d, supports, {});
  FactorCache factors;
  Multigrid multigrid(d, A, u, hierarchy, factors);
  REQUIRE(multigrid.usable());
  multigrid.apply(product, reduced);
  add(reduced);
  return all;
}

}  // namespace

TEST_CASE("parts are contiguous and together the whole, whatever the numbers", "[parallel]") {
  for (const int threads : {1, 2, 3, 8})
    for (const int count : {0, 1, 2, 7, 64, 1000})
      for (const int grain : {0, 1, 5, 64}) {
        CAPTURE(threads, count, grain);
        const Threads with(threads);
        std::mutex mutex;
        std::vector<std::pair<int, int>> parts;
        for_parts(count, grain, [&](int first, int last) {
          const std::lock_guard lock(mutex);
          parts.emplace_back(first, last);
        });
        std::ranges::sort(parts);
        int next = 0;
        for (const auto& [first, last] : parts) {
          REQUIRE(first == next);
          REQUIRE(first < last);
          next = last;
        }
        REQUIRE(next == count);
        CHECK(static_cast<int>(parts.size()) <= std::max(1, std::min(threads, count / std::max(1, grain))));
        // Whether as many threads come as are asked for is the system's choice; one part is none.
        if (has_threads() && threads == 2 && count == 1000 && grain == 64) CHECK(parts.size() == 2);
      }
}

TEST_CASE("what a part throws is thrown on once all parts have ended", "[parallel]") {
  const Threads two(2);
  std::atomic<int> ended = 0;
  const auto work = [&] {
    for_parts(100, 1, [&](int first, int last) {
      ended += last - first;
      throw std::runtime_error("in a part");
    });
  };
  CHECK_THROWS_AS(work(), std::runtime_error);
  CHECK(ended == 100);
}

TEST_CASE("there is one thread until a number is set, and never less", "[parallel]") {
  CHECK(thread_count() == 1);
  const Threads none(0);
  CHECK(thread_count() == 1);
}

TEST_CASE("stages that threads share have the same bits for any number of them", "[parallel]") {
  const auto [kinematics, shape] =
      GENERATE(table<Kinematics, CellShape>({{Kinematics::linear, CellShape::hexahedron},
                                             {Kinematics::corotational, CellShape::hexahedron},
                                             {Kinematics::corotational, CellShape::tetrahedron}}));
  const std::vector<double> alone = shared_stages(kinematics, shape);
  for (const int threads : {2, 3, 5}) {
    CAPTURE(threads);
    const Threads with(threads);
    const std::vector<double> shared = shared_stages(kinematics, shape);
    REQUIRE(shared.size() == alone.size());
    CHECK(std::memcmp(shared.data(), alone.data(), alone.size() * sizeof(double)) == 0);
  }
}

TEST_CASE("several threads solve with one factor at a time", "[parallel][direct]") {
  std::mt19937 generator(3);
  BoxMeshOptions options;
  options.cells = {9, 9, 9};  // a factor in dense blocks, by BLAS
  const RefinementForest forest(distorted_box(options, 0.05, generator));
  Material material;
  material.youngs_modulus = 10.0;
  const Discretization d = discretize(forest, material, {{"x_min", std::nullopt, {}}});
  BlockMatrix<double> A = assemble_stiffness(d, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()));
  apply_supports(d.supports, A);
  const DirectSolver solver(A);
  REQUIRE(solver.factored());
  std::vector<Eigen::MatrixXd> right, alone;
  for (int k = 0; k < 12; ++k) {
    right.emplace_back(Eigen::MatrixXd::NullaryExpr(d.dof_count(), 3, [&] { return random_number(generator); }));
    alone.push_back(solver.solve_columns(right.back()));
  }
  std::vector<Eigen::MatrixXd> shared(right.size());
  const Threads four(4);
  for_parts(static_cast<int>(right.size()), 1, [&](int first, int last) {
    for (int k = first; k < last; ++k) shared[k] = solver.solve_columns(right[k]);
  });
  for (std::size_t k = 0; k < right.size(); ++k) CHECK(shared[k] == alone[k]);
}
