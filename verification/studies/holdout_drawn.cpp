#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "verification/studies/holdout.hpp"
#include "verification/studies/problem_parts.hpp"
#include "verification/support/scrambled_mesh.hpp"
#include "verification/support/wedge_mesh.hpp"

namespace finegauge {

namespace {

using Eigen::Vector3d;
using std::numbers::pi;

/// The same numbers on every machine: the generator's are prescribed by the standard, its distributions' are not.
class Draws {
 public:
  explicit Draws(std::uint32_t seed) : generator_(seed) {}
  /// To two digits after the point, so that a name can tell all of it.
  double between(double low, double high) {
    const double share = static_cast<double>(generator_()) / 4294967296.0;
    return std::round(100.0 * (low + share * (high - low))) / 100.0;
  }
  int number(int low, int high) { return low + static_cast<int>(generator_() % static_cast<unsigned>(high - low + 1)); }
  Vector3d vector() {
    const double x = between(-1.0, 1.0), y = between(-1.0, 1.0);
    return {x, y, between(-1.0, 1.0)};
  }

 private:
  std::mt19937 generator_;
};

template <class... Values>
std::string text(const char* format, Values... values) {
  char result[160];
  std::snprintf(result, sizeof result, format, values...);
  return result;
}

HoldoutProblem drawn(const std::string& name, BaseMesh mesh, const Material& material) {
  HoldoutProblem problem{"drawn", name, std::move(mesh), {}, {}};
  problem.problem.material = material;
  problem.drawn = true;
  return problem;
}

/// Opening plus `shear` times sliding, where the corner has that mode.
ExactField mixed_corner(double opening, double bisector, double shear, const Material& material) {
  const ExactField open = corner_field(CornerMode::opening, opening, {0.0, 0.0}, bisector, material);
  constexpr double least_opening_of_sliding = 1.4303 * pi;  // tan ω = ω
  if (opening < 1.001 * least_opening_of_sliding) return open;
  return combined(1.0, open, shear, corner_field(CornerMode::sliding, opening, {0.0, 0.0}, bisector, material));
}

HoldoutProblem free_wedge(Draws& draws) {
  const int degrees = draws.number(195, 360), n = draws.number(5, 8);
  const double opening = degrees * pi / 180.0, shear = draws.between(-1.0, 1.0);
  const Material material = with_poisson_ratio(draws.between(0.0, 0.45));
  HoldoutProblem problem =
      drawn(text("free wedge of %d degrees, shear %.2f, nu %.2f", degrees, shear, material.poisson_ratio),
            wedge_mesh({opening, (degrees + 89) / 90, n}), material);
  problem.exact = mixed_corner(opening, 0.5 * opening, shear, material);
  hold_outside(problem);
  return problem;
}

HoldoutProblem clamped_wedge(Draws& draws) {
  const int degrees = draws.number(80, 140), n = draws.number(5, 8);
  const double opening = degrees * pi / 180.0;
  const Material material = with_poisson_ratio(draws.between(0.25, 0.45));
  HoldoutProblem problem = drawn(text("clamped wedge of %d degrees, nu %.2f", degrees, material.poisson_ratio),
                                 wedge_mesh({opening, degrees > 100 ? 2 : 1, n}), material);
  problem.exact = clamped_corner_field(opening, 0.0, {0.0, 0.0}, material);
  hold_outside(problem);
  problem.problem.supports.push_back(clamped("ray_first"));
  return problem;
}

HoldoutProblem notch(Draws& draws) {
  const int n = draws.number(6, 9), m = draws.number(4, 9);
  const double shear = draws.between(-1.0, 1.0);
  const Material material = with_poisson_ratio(draws.between(0.0, 0.45));
  HoldoutProblem problem = drawn(text("notch, cells %d:%d, shear %.2f, nu %.2f", m, n, shear, material.poisson_ratio),
                                 notched_square(n, m, draws.number(2, 4)), material);
  problem.exact = mixed_corner(1.5 * pi, 0.75 * pi, shear, material);
  hold_exactly(problem.exact, {"x_min", "x_max", "y_min", "y_max"}, problem.problem);
  hold_plane(problem.problem);
  return problem;
}

HoldoutProblem smooth_field(Draws& draws) {
  const double bulk = draws.between(0.2, 1.0), share = draws.between(0.05, 0.2);
  const Material material = with_poisson_ratio(draws.between(0.0, 0.4));
  BoxMeshOptions options;
  for (int axis = 0; axis < 3; ++axis) options.cells[axis] = draws.number(5, 9);
  std::mt19937 generator(7);
  HoldoutProblem problem = drawn(text("smooth, nodes moved by %.2f, nu %.2f", share, material.poisson_ratio),
                                 distorted_box(options, share, generator), material);
  problem.exact = combined(bulk, exact_field(smooth_solution(), material), draws.between(-1.0, 1.0),
                           exact_field(isochoric_solution(), material));
  problem.problem.body = problem.exact.body;
  hold_exactly(problem.exact, {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"}, problem.problem);
  problem.refused = refused_mesh;
  return problem;
}

constexpr std::array<const char*, 6> faces = {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"};

/// A block of any size, stiffness and cells, clamped on one face.
HoldoutProblem block_clamped_somewhere(Draws& draws, const char* what, int& held) {
  Vector3d size;
  std::array<int, 3> cells;
  for (int axis = 0; axis < 3; ++axis) size[axis] = draws.between(0.5, 2.0), cells[axis] = draws.number(4, 8);
  Material material = with_poisson_ratio(draws.between(0.0, 0.45));
  material.youngs_modulus = std::round(std::pow(10.0, draws.between(2.0, 6.0)));
  held = draws.number(0, 5);
  HoldoutProblem problem = drawn(text("%s, %.2f x %.2f x %.2f, %s held, E %.0f, nu %.2f", what, size.x(), size.y(),
                                      size.z(), faces[held], material.youngs_modulus, material.poisson_ratio),
                                 block(size, cells), material);
  problem.problem.supports = {clamped(faces[held])};
  const auto length = [&](int axis) { return size[axis] / cells[static_cast<std::size_t>(axis)]; };
  for (int axis = 0; axis < 3; ++axis) {
    const double ratio = length(axis) / length(held / 2);
    if (std::max(ratio, 1.0 / ratio) >= 2.0) problem.refused = refused_cells;
  }
  return problem;
}

HoldoutProblem pulled_block(Draws& draws) {
  int held = 0;
  HoldoutProblem problem = block_clamped_somewhere(draws, "block pulled", held);
  const int loaded = (held + draws.number(1, 5)) % 6;
  problem.name += std::string(", ") + faces[loaded];
  problem.problem.loads = {traction(faces[loaded], draws.vector())};
  return problem;
}

HoldoutProblem heavy_block(Draws& draws) {
  int held = 0;
  HoldoutProblem problem = block_clamped_somewhere(draws, "block with its weight", held);
  const Vector3d force = draws.vector();
  problem.problem.body = [force](const Vector3d&) { return force; };
  return problem;
}

HoldoutProblem displaced_block(Draws& draws) {
  int held = 0;
  HoldoutProblem problem = block_clamped_somewhere(draws, "block displaced", held);
  problem.problem.supports.push_back(moved(faces[held ^ 1], 0.1 * draws.vector()));
  return problem;
}

HoldoutProblem notched_block(Draws& draws) {
  const int at_x = draws.number(2, 5), at_y = draws.number(2, 5), deep = draws.number(1, 4);
  const Material material = with_poisson_ratio(draws.between(0.0, 0.45));
  HoldoutProblem problem =
      drawn(text("block without cells from %d, %d to %d deep, nu %.2f", at_x, at_y, deep, material.poisson_ratio),
            block({1.0, 1.0, draws.between(0.4, 1.0)}, {7, 7, 4}, {{at_x, at_y, 0}, {7, 7, deep}}), material);
  problem.problem.supports = {clamped("x_min")};
  problem.problem.loads = {traction("y_min", draws.vector())};
  return problem;
}

HoldoutProblem load_on_a_part(Draws& draws) {
  BaseMesh cube = block(Vector3d::Ones(), {8, 8, 8});
  const double x = draws.number(2, 6) / 8.0, y = draws.number(2, 6) / 8.0;
  name_surface(cube, "part", [=](const Vector3d& X) { return X.z() > 1.0 - 1e-9 && X.x() < x && X.y() < y; });
  const Material material = with_poisson_ratio(draws.between(0.0, 0.45));
  HoldoutProblem problem =
      drawn(text("load on %.3f x %.3f of a face, nu %.2f", x, y, material.poisson_ratio), std::move(cube), material);
  problem.family = drawn_load;
  problem.problem.supports = {clamped("z_min")};
  problem.problem.loads = {traction("part", draws.vector())};
  problem.refused = refused_load;
  return problem;
}

}  // namespace

std::vector<HoldoutProblem> drawn_holdout_problems() {
  Draws draws(20260101);
  std::vector<HoldoutProblem> problems;
  using Draw = HoldoutProblem (*)(Draws&);
  for (const Draw draw :
       {&free_wedge, &free_wedge, &free_wedge, &clamped_wedge, &clamped_wedge, &notch, &notch, &smooth_field,
        &pulled_block, &pulled_block, &heavy_block, &displaced_block, &notched_block, &load_on_a_part})
    problems.push_back(draw(draws));
  return problems;
}

}  // namespace finegauge
