#include "benchmarks/measure/measured_run.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/mesh/base_mesh.hpp"
#include "core/scene/scene_error.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/scene_text.hpp"

namespace finegauge {
namespace {

RefinementForest block(int cells) {
  BoxMeshOptions box;
  box.size = {2.0, 1.0, 1.0};
  box.cells = {2 * cells, cells, cells};
  return RefinementForest(box_mesh(box));
}

Eigen::Matrix3Xd linear_field(const Mesh& mesh, const Eigen::Matrix3d& F) {
  return (F - Eigen::Matrix3d::Identity()) * mesh.nodes;
}

StrainDistance distance(const RefinementForest& forest, const Eigen::Matrix3d& F, const StrainSamples& samples,
                        const Material& material) {
  const Mesh mesh = forest.leaf_mesh();
  return strain_distance(samples, locate_samples(forest.base(), samples), forest, mesh, linear_field(mesh, F),
                         material);
}

constexpr const char* beam = R"(
name = "beam"
[box]
size = [4, 1, 1]
cells = [4, 1, 1]
[material]
youngs_modulus = 1000
poisson_ratio = 0.3
[[support]]
surface = "x_min"
[[load]]
surface = "x_max"
total_force = [0, 0, -1]
[[quantity]]
kind = "energy"
[[quantity]]
kind = "displacement"
name = "end"
point = [4, 0.5, 0.5]
)";

}  // namespace

TEST_CASE("uniform strains on different meshes are as far apart as their closed form, however the body is turned") {
  Material material;
  material.kinematics = Kinematics::corotational;
  Eigen::Matrix3d strain, other;
  strain << 1e-3, 2e-3, 0, 2e-3, -1e-3, 5e-4, 0, 5e-4, 3e-3;
  other << 2e-3, 0, 1e-3, 0, 1e-3, 0, 1e-3, 0, -1e-3;
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  const RefinementForest coarse = block(1), fine = block(3);
  const Mesh fine_mesh = fine.leaf_mesh();
  const auto energy = [&](const Eigen::Matrix3d& e) {  // of two cubic metres
    return 2.0 * (2.0 * material.mu() * e.squaredNorm() + material.lambda() * e.trace() * e.trace());
  };
  for (const Eigen::Matrix3d& R : {one, turn}) {
    const StrainSamples samples = sample_strains(fine_mesh, linear_field(fine_mesh, R * (one + strain)));
    const StrainDistance same = distance(coarse, R * (one + strain), samples, material);
    const StrainDistance off = distance(coarse, R * (one + other), samples, material);
    const double size = energy(strain);
    CHECK(same.left_out == 0.0);
    CHECK(same.difference < 1e-24 * size / 1e-6);
    CHECK(std::abs(same.size / size - 1.0) < 1e-9);
    CHECK(std::abs(off.difference / energy(other - strain) - 1.0) < 1e-9);
  }
}

TEST_CASE("a solution on a coarser nested mesh is off by the energy that it lacks") {
  // Galerkin orthogonality: |u_ref - u_h|² = |u_ref|² - |u_h|² in the energy norm, for loads alone. The samples
  // integrate by one point a cell of a mesh that is four times finer: within 5 %.
  std::string why;
  const auto reference = record_reference(read(beam, {"box.cells=[32, 8, 8]"}), {0.0}, why);
  INFO(why);
  REQUIRE(reference);
  const Scene scene = read(beam, {"box.cells=[8, 2, 2]"});
  MeasureOptions options;
  options.reference = &*reference;
  options.passes_least = options.passes_most = 3;
  const MeasuredRun run = measure_run(scene, options);
  REQUIRE(run.complete);
  CHECK(run.frame_ms.size() == 3);
  CHECK(run.left_out == 0.0);
  const double exact = reference->curves.values.at("energy").front(), found = run.curves.values.at("energy").front();
  CHECK(found < exact);
  CHECK(std::abs(run.errors.at("energy") - (1.0 - found / exact)) < 1e-12);
  CHECK(std::abs(run.errors.at("energy_norm") / std::sqrt(1.0 - found / exact) - 1.0) < 0.05);

  const ReferenceRun back = reference_run(to_bytes(*reference));
  options.reference = &back;
  const MeasuredRun again = measured_run(to_json(measure_run(scene, options)));
  CHECK(again.errors == run.errors);
  CHECK(again.work == run.work);
}

TEST_CASE("a reference is no distance from itself, and a body that moves is compared where it is at the same time") {
  const std::string swing = std::string(beam) + "[dynamics]\ntime_step = 2e-3\nduration = 0.1\ndensity = 1\n";
  const Scene scene = read(swing);
  std::string why;
  const std::vector<double> times = instants_of(scene, 4e-3, 5);
  REQUIRE(times.size() == 5);
  CHECK(std::abs(times.back() - 0.1) < 1e-12);
  const auto reference = record_reference(scene, times, why);
  INFO(why);
  REQUIRE(reference);
  MeasureOptions options;
  options.reference = &*reference;
  const MeasuredRun same = measure_run(scene, options);
  REQUIRE(same.complete);
  CHECK(same.errors.at("energy_norm") == 0.0);
  CHECK(same.errors.at("end") == 0.0);
  // Backward Euler is of first order: half the step is off by half as much, a longer one in proportion.
  const MeasuredRun twice = measure_run(read(swing, {"dynamics.time_step=4e-3"}), options);
  const MeasuredRun half = measure_run(read(swing, {"dynamics.time_step=1e-3"}), options);
  REQUIRE(twice.complete);
  REQUIRE(half.complete);
  const double ratio = twice.errors.at("energy_norm") / half.errors.at("energy_norm");
  INFO("errors " << twice.errors.at("energy_norm") << ' ' << half.errors.at("energy_norm"));
  CHECK(ratio > 1.5);
  CHECK(ratio < 2.5);
}

TEST_CASE("a reference whose mesh follows the solution is no distance from itself") {
  const Scene scene = read(std::string(beam) + "[dynamics]\ntime_step = 4e-3\nduration = 0.04\ndensity = 1\n" +
                               "[adapt]\nmax_depth = 1\ntheta = 0.5\n",
                           {"box.cells=[8, 2, 2]"});
  std::string why;
  const auto reference = record_reference(scene, instants_of(scene, 4e-3, 5), why);
  INFO(why);
  REQUIRE(reference);
  const auto places = [&](std::size_t i) { return reference->instants[i].strains.places.cols(); };
  bool other = false;  // else every instant has the places of the one before
  for (std::size_t i = 1; i < reference->instants.size(); ++i) other |= places(i) != places(i - 1);
  REQUIRE(other);
  MeasureOptions options;
  options.reference = &*reference;
  const MeasuredRun same = measure_run(scene, options);
  REQUIRE(same.complete);
  CHECK(same.errors.at("energy_norm") == 0.0);
}

TEST_CASE("runs with and without corotation are compared in the reference's norm") {
  const std::string bent = replaced(beam, "total_force = [0, 0, -1]", "total_force = [0, 0, -6]");
  const Strings turning = {"material.kinematics=corotational"}, small = {"material.kinematics=linear"};
  std::string why;
  const auto reference = record_reference(read(bent, turning), {0.0}, why);
  INFO(why);
  REQUIRE(reference);
  MeasureOptions options;
  const ReferenceRun back = reference_run(to_bytes(*reference));
  options.reference = &back;
  const MeasuredRun same = measure_run(read(bent, turning), options), linear = measure_run(read(bent, small), options);
  CHECK(same.errors.at("energy_norm") == 0.0);
  CHECK(linear.errors.at("energy_norm") > 0.1);
  REQUIRE(same.reference_size > 0.0);
  CHECK(linear.reference_size == same.reference_size);
}

TEST_CASE("a scene that cannot start is refused before it is run, and bytes that are no reference are refused") {
  CHECK_NOTHROW(require_start(read(beam)));
  const std::string outside = replaced(beam, "point = [4, 0.5, 0.5]", "point = [5, 0.5, 0.5]");
  CHECK_THROWS_AS(require_start(read(outside)), SceneError);
  std::string why;
  auto reference = record_reference(read(beam), {0.0}, why);
  REQUIRE(reference);
  reference->instants.front().strains.volumes.conservativeResize(2);
  CHECK_THROWS_AS(reference_run(to_bytes(*reference)), std::runtime_error);
  Json json = Json::from_cbor(to_bytes(*reference));
  json["instants"][0]["places"].get_binary().pop_back();
  CHECK_THROWS_AS(reference_run(Json::to_cbor(json)), std::runtime_error);
}

TEST_CASE("a run that is shorter than the longest step has one instant, its end") {
  const std::string swing = std::string(beam) + "[dynamics]\ntime_step = 2e-3\nduration = 6e-3\ndensity = 1\n";
  const std::vector<double> times = instants_of(read(swing), 8e-3, 5);
  REQUIRE(times.size() == 1);
  CHECK(std::abs(times.front() - 6e-3) < 1e-12);
}

TEST_CASE("curves are off by what they differ, whatever their frames") {
  RunCurves exact, found;
  const auto fill = [](RunCurves& curves, int frames, double factor) {
    for (int k = 0; k <= frames; ++k) {
      const double t = static_cast<double>(k) / frames;
      curves.add(t, {{"energy", factor * t}, {"place", {factor * t, 0.0, -factor * t}}});
      curves.travel.push_back(2.0 * t - 0.5);
      curves.force.push_back(factor * std::max(0.0, 2.0 * t - 0.5));
      curves.tip_force.push_back(factor * (t > 0.25 ? 1.0 : 0.0));
    }
  };
  fill(exact, 1000, 1.0);
  fill(found, 400, 1.1);
  const std::vector<QuantityOfInterest> quantities = {{"energy", QuantityKind::energy, {}},
                                                      {"place", QuantityKind::displacement, {}},
                                                      {"curve", QuantityKind::force_curve, {}},
                                                      {"tip", QuantityKind::tip_force, {}}};
  const auto errors = errors_against(exact, found, quantities);
  CHECK(std::abs(errors.at("energy") - 0.1) < 1e-12);
  CHECK(std::abs(errors.at("place") - 0.1) < 1e-12);
  CHECK(std::abs(errors.at("curve") - 0.1) < 1e-3);
  CHECK(std::abs(errors.at("tip") - 0.1) < 2e-3);                     // half a frame of the tip's work at its step
  found.add(1.5, {{"energy", 100.0}, {"place", {100.0, 0.0, 0.0}}});  // after the reference's end
  CHECK(std::abs(errors_against(exact, found, quantities).at("energy") - 0.1) < 1e-12);
  RunCurves empty;
  CHECK(std::isnan(errors_against(exact, empty, quantities).at("place")));
  CHECK(std::isnan(errors_against(exact, empty, quantities).at("tip")));
}

}  // namespace finegauge
