#include <cmath>
#include <numbers>

#include "verification/studies/holdout.hpp"
#include "verification/studies/problem_parts.hpp"
#include "verification/support/wedge_mesh.hpp"

namespace finegauge {

namespace {

using Eigen::Vector3d;
using std::numbers::pi;
using Problems = std::vector<HoldoutProblem>;

HoldoutProblem& add(Problems& problems, const std::string& family, const std::string& name, BaseMesh mesh,
                    const Material& material = {}) {
  problems.push_back({family, name, std::move(mesh), {}, {}});
  problems.back().problem.material = material;
  return problems.back();
}

/// Free corners of other angles, modes and Poisson ratios than the ladder's; truth: Williams' field.
void add_free_wedges(Problems& problems) {
  struct Wedge {
    const char* name;
    double opening;
    int blocks;
    CornerMode mode;
    double nu;
  };
  using enum CornerMode;
  for (const Wedge& wedge : {Wedge{"225 degrees, opening", 1.25 * pi, 3, opening, 0.3},
                             {"225 degrees, opening, oblique cells", 1.25 * pi, 2, opening, 0.3},
                             {"210 degrees, opening", 7.0 * pi / 6.0, 2, opening, 0.3},
                             {"315 degrees, opening", 1.75 * pi, 4, opening, 0.3},
                             {"315 degrees, sliding", 1.75 * pi, 4, sliding, 0.3},
                             {"crack, opening", 2.0 * pi, 4, opening, 0.3},
                             {"crack, sliding", 2.0 * pi, 4, sliding, 0.3},
                             {"270 degrees, opening, nu 0", 1.5 * pi, 3, opening, 0.0},
                             {"270 degrees, opening, nu 0.45", 1.5 * pi, 3, opening, 0.45}}) {
    HoldoutProblem& problem = add(problems, "free wedge", wedge.name, wedge_mesh({wedge.opening, wedge.blocks, 6}),
                                  with_poisson_ratio(wedge.nu));
    problem.exact = corner_field(wedge.mode, wedge.opening, {0.0, 0.0}, 0.5 * wedge.opening, problem.problem.material);
    hold_outside(problem);
    if (wedge.mode == sliding && wedge.opening == 2.0 * pi)
      problem.weakness = "sheared, refined on one side of the crack";
  }
  HoldoutProblem& half =
      add(problems, "free wedge", "270 degrees, half of it on a roller", wedge_mesh({0.75 * pi, 2, 6}));
  half.exact = corner_field(CornerMode::opening, 1.5 * pi, {0.0, 0.0}, 0.0, half.problem.material);
  hold_outside(half);
  half.problem.supports.push_back(roller("ray_first", 1));
}

/// Corners whose one face is clamped; truth: the field of the corner's least real exponent.
void add_clamped_wedges(Problems& problems) {
  struct Wedge {
    const char* name;
    double opening;
    int blocks;
    double nu;
    const char* weakness;
  };
  for (const Wedge& wedge :
       {Wedge{"90 degrees, nu 0.2", 0.5 * pi, 1, 0.2, ""},
        {"90 degrees, nu 0.45", 0.5 * pi, 1, 0.45, ""},
        {"135 degrees", 0.75 * pi, 2, 0.3, ""},
        {"120 degrees, one cell", 2.0 * pi / 3.0, 1, 0.3, ""},
        {"120 degrees, two cells", 2.0 * pi / 3.0, 2, 0.3, ""},
        {"270 degrees", 1.5 * pi, 3, 0.3, "not the corner's sharpest mode, whose exponent the weight goes by"}}) {
    HoldoutProblem& problem = add(problems, "clamped wedge", wedge.name, wedge_mesh({wedge.opening, wedge.blocks, 6}),
                                  with_poisson_ratio(wedge.nu));
    problem.exact = clamped_corner_field(wedge.opening, 0.0, {0.0, 0.0}, problem.problem.material);
    hold_outside(problem);
    problem.problem.supports.push_back(clamped("ray_first"));
    problem.weakness = wedge.weakness;
    if (wedge.opening == 0.5 * pi) problem.refused = "";  // a square of square cells
  }
}

/// Cells that have two lengths across an edge, and graded ones; truth: the exact fields.
void add_stretched_cells(Problems& problems) {
  const auto finish = [](HoldoutProblem& problem) {
    problem.exact = corner_field(CornerMode::opening, 1.5 * pi, {0.0, 0.0}, 0.75 * pi, problem.problem.material);
    hold_exactly(problem.exact, {"x_min", "x_max", "y_min", "y_max"}, problem.problem);
    hold_plane(problem.problem);
  };
  std::vector<double> graded;
  for (int i = -5; i <= 5; ++i) graded.push_back(i * std::abs(i) / 25.0);
  HoldoutProblem& notch = add(problems, "stretched cells", "notch, graded",
                              tensor_mesh({graded, graded, {0.0, 0.25, 0.5}}, RemovedBlock{{5, 0, 0}, {10, 5, 2}}));
  notch.refused = refused_mesh;
  finish(notch);
  HoldoutProblem& half = add(problems, "stretched cells", "notch, 1:2", notched_square(8, 4, 2));
  half.refused = refused_cells;
  finish(half);
  HoldoutProblem& flat = add(problems, "stretched cells", "notch, 1:4", notched_square(8, 2, 2));
  flat.refused = refused_cells;
  flat.weakness = "one length of the cell where the edge sees two";
  finish(flat);
  for (const auto& [name, nx, ny] : {std::tuple{"rim, 1:2", 12, 6}, {"rim, 2:1", 6, 12}}) {
    HoldoutProblem& rim = add(problems, "stretched cells", name, block({1.0, 1.0, 0.5}, {nx, ny, 3}));
    rim.exact = clamped_corner_field(0.0, 0.5 * pi, {0.0, 0.0}, rim.problem.material);
    hold_exactly(rim.exact, {"x_max", "y_max"}, rim.problem);
    rim.problem.supports.push_back(clamped("x_min"));
    hold_plane(rim.problem);
    rim.refused = refused_cells;
    rim.weakness = "one length of the cell where the edge sees two";
  }
}

/// Smooth, but steep or short against the cells; truth: manufactured.
void add_smooth_fields(Problems& problems) {
  const ManufacturedSolution layers{"layers", [](const Jets& x) -> Jets {
                                      return {0.1 * exp(-8.0 * x[0]) * sin(pi * x[1]), 0.1 * exp(-8.0 * x[0]) * x[2],
                                              0.05 * exp(-6.0 * x[2]) * cos(pi * x[1])};
                                    }};
  const ManufacturedSolution waves{"waves", [](const Jets& x) -> Jets {
                                     return {0.1 * sin(2.0 * pi * x[0]) * sin(2.0 * pi * x[1]) * x[2],
                                             0.1 * cos(2.0 * pi * x[2]), 0.1 * sin(3.0 * pi * (x[0] - x[1]))};
                                   }};
  for (const auto& [name, n, field] :
       {std::tuple{"layers, 8 cells", 8, layers}, {"layers, 12 cells", 12, layers}, {"waves, 12 cells", 12, waves}}) {
    HoldoutProblem& problem = add(problems, "smooth", name, block(Vector3d::Ones(), {n, n, n}));
    problem.exact = exact_field(field, problem.problem.material);
    problem.problem.body = problem.exact.body;
    hold_exactly(problem.exact, {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"}, problem.problem);
    if (field.name == "layers") problem.weakness = "a layer of one or two cells on the boundary";
  }
}

/// The paper's L-shape, otherwise held, loaded and made; a cube without an octant. Here and below: reference meshes.
void add_notched_blocks(Problems& problems) {
  const RemovedBlock quadrant{{4, 0, 0}, {8, 4, 4}};
  const BaseMesh l_shape = block({4.0, 4.0, 2.0}, {8, 8, 4}, quadrant);
  for (const auto& [name, nu] :
       {std::pair{"L-shape, nu 0", 0.0}, {"L-shape, nu 0.2", 0.2}, {"L-shape, nu 0.45", 0.45}}) {
    StaticProblem& pulled = add(problems, "notched block", name, l_shape, with_poisson_ratio(nu)).problem;
    pulled.supports = {clamped("x_max"), roller("y_max", 1)};
    pulled.loads = {traction("x_min", {-1.0, 0.0, 0.0})};
  }
  StaticProblem& sheared = add(problems, "notched block", "L-shape, sheared", l_shape).problem;
  sheared.supports = {clamped("x_max")};
  sheared.loads = {traction("y_min", {1.0, 0.0, 0.3})};
  StaticProblem& pressed = add(problems, "notched block", "L-shape, displaced", l_shape).problem;
  pressed.supports = {clamped("x_max"), moved("y_min", {0.0, -0.1, 0.0})};
  HoldoutProblem& thin = add(problems, "notched block", "L-shape, two cells thick",
                             block({4.0, 4.0, 0.5}, {8, 8, 2}, {{4, 0, 0}, {8, 4, 2}}));
  thin.problem.supports = {clamped("x_max")};
  thin.problem.loads = {traction("y_min", {0.0, -1.0, 0.0})};
  thin.refused = refused_cells;
  const BaseMesh cut_cube = block({2.0, 2.0, 2.0}, {6, 6, 6}, {{3, 3, 3}, {6, 6, 6}});
  StaticProblem& cube = add(problems, "notched block", "cube without an octant", cut_cube).problem;
  cube.supports = {clamped("x_min")};
  cube.loads = {traction("x_max", {1.0, 0.0, 0.0})};
  StaticProblem& rolling = add(problems, "notched block", "cube without an octant, on rollers", cut_cube).problem;
  rolling.supports = {roller("x_min", 0), roller("y_min", 1), roller("z_min", 2)};
  rolling.loads = {traction("x_max", {1.0, 0.0, 0.0}), traction("z_max", {0.0, 0.0, 1.0})};
  StaticProblem& groove =
      add(problems, "notched block", "groove, pulled", block({3.0, 1.0, 1.0}, {12, 4, 4}, {{5, 0, 2}, {7, 4, 4}}))
          .problem;
  groove.supports = {roller("x_min", 0), roller("y_min", 1), roller("z_min", 2)};
  groove.loads = {traction("x_max", {1.0, 0.0, 0.0})};
  StaticProblem& pocket =
      add(problems, "notched block", "pocket, pulled", block(Vector3d::Ones(), {8, 8, 8}, {{3, 3, 6}, {5, 5, 8}}))
          .problem;
  pocket.supports = groove.supports, pocket.loads = groove.loads;
  StaticProblem& step =
      add(problems, "notched block", "step, bent", block({2.0, 1.0, 1.0}, {8, 4, 4}, {{4, 0, 2}, {8, 4, 4}})).problem;
  step.supports = {clamped("x_min")};
  step.loads = {traction("x_max", {0.0, 0.0, -1.0})};
}

/// Blocks, beams and plates on whole faces.
void add_blocks(Problems& problems) {
  for (const auto& [name, nu] :
       {std::pair{"cantilever, nu 0", 0.0}, {"cantilever, nu 0.3", 0.3}, {"cantilever, nu 0.45", 0.45}}) {
    StaticProblem& beam =
        add(problems, "block", name, block({2.0, 1.0, 1.0}, {8, 4, 4}), with_poisson_ratio(nu)).problem;
    beam.supports = {clamped("x_min")};
    beam.loads = {traction("x_max", {0.0, 0.0, 1.0})};
  }
  const BaseMesh cube = block(Vector3d::Ones(), {6, 6, 6});
  for (const auto& [name, nu] : {std::pair{", nu 0.3", 0.3}, {", nu 0.45", 0.45}}) {
    StaticProblem& heavy =
        add(problems, "block", std::string("under its weight") + name, cube, with_poisson_ratio(nu)).problem;
    heavy.supports = {clamped("z_min")};
    heavy.body = [](const Vector3d&) -> Vector3d { return -Vector3d::UnitZ(); };
    add(problems, "block", std::string("between platens") + name, cube, with_poisson_ratio(nu)).problem.supports = {
        clamped("z_min"), moved("z_max", {0.02, 0.0, -0.1})};
  }
  StaticProblem& plate = add(problems, "block", "plate, bent", block({1.0, 1.0, 0.2}, {8, 8, 2})).problem;
  plate.supports = {clamped("x_min")};
  plate.loads = {traction("z_max", {0.0, 0.0, -1.0})};
  StaticProblem& sheet = add(problems, "block", "plate, stretched", block({1.0, 1.0, 0.1}, {12, 12, 2})).problem;
  sheet.supports = {clamped("x_min")};
  sheet.loads = {traction("x_max", {1.0, 0.5, 0.0})};
  StaticProblem& beam =
      add(problems, "block", "under its weight, on rollers", block({2.0, 1.0, 1.0}, {8, 4, 4})).problem;
  beam.supports = {roller("x_min", 0), roller("y_min", 1), roller("z_min", 2)};
  beam.body = [](const Vector3d&) -> Vector3d { return -Vector3d::UnitZ(); };
  HoldoutProblem& confined = add(problems, "block", "pressed in a box", block(Vector3d::Ones(), {8, 8, 8}));
  confined.problem.supports = {roller("z_min", 2), clamped("x_min"), clamped("x_max"), clamped("y_min"),
                               clamped("y_max")};
  confined.problem.loads = {traction("z_max", {0.0, 0.0, -1.0})};
  confined.refused = refused_between;
  confined.weakness = "a load on a face between clamped ones";
}

/// A support or a load that ends inside a face.
void add_parts_of_faces(Problems& problems) {
  const std::vector<SupportCondition> rollers = {roller("z_min", 2), roller("x_min", 0), roller("y_min", 1)};
  BaseMesh cube = block(Vector3d::Ones(), {8, 8, 8});
  name_surface(cube, "half", [](const Vector3d& X) { return X.z() < 1e-9 && X.x() < 0.5; });
  name_surface(cube, "quarter", [](const Vector3d& X) { return X.z() > 1.0 - 1e-9 && X.x() < 0.5 && X.y() < 0.5; });
  name_surface(cube, "cell", [](const Vector3d& X) { return (X - Vector3d(0.4375, 0.4375, 1.0)).norm() < 1e-3; });
  StaticProblem& half = add(problems, "support on a part", "roller under one half", cube).problem;
  half.supports = {roller("half", 2), roller("x_min", 0), roller("y_min", 1)};
  half.loads = {traction("z_max", {0.0, 0.0, -1.0})};
  StaticProblem& punch = add(problems, "support on a part", "punch on a quarter", cube).problem;
  punch.supports = rollers;
  punch.supports.push_back(moved("quarter", {0.0, 0.0, -0.1}));
  StaticProblem& smooth = add(problems, "support on a part", "smooth punch on a quarter", cube).problem;
  smooth.supports = rollers;
  smooth.supports.push_back({"quarter", Vector3d(Vector3d::UnitZ()), [](const Vector3d&) -> Vector3d {
                               return {0.0, 0.0, -0.1};
                             }});

  struct Part {
    const char *name, *surface;
    std::vector<SupportCondition> supports;
    Vector3d traction;
  };
  for (const Part& part : {Part{"pressure on a quarter", "quarter", rollers, {0.0, 0.0, -1.0}},
                           {"shear on a quarter", "quarter", {clamped("z_min"), roller("y_min", 1)}, {1.0, 0.0, 0.0}},
                           {"pressure on one face", "cell", rollers, {0.0, 0.0, -1.0}},
                           {"oblique traction on one face", "cell", {clamped("z_min")}, {0.0, 1.0, -1.0}}}) {
    HoldoutProblem& problem = add(problems, "load on a part", part.name, cube);
    problem.problem.supports = part.supports;
    problem.problem.loads = {traction(part.surface, part.traction)};
    problem.refused = refused_load;
    problem.weakness = "the stress jumps where the load ends, inside a face";
  }
}

}  // namespace

void hold_outside(HoldoutProblem& wedge) {
  hold_exactly(wedge.exact, {"outer"}, wedge.problem);
  hold_plane(wedge.problem);
  wedge.refused = refused_mesh;
}

std::vector<HoldoutProblem> known_holdout_problems() {
  Problems problems;
  add_free_wedges(problems);
  add_clamped_wedges(problems);
  add_stretched_cells(problems);
  add_smooth_fields(problems);
  add_notched_blocks(problems);
  add_blocks(problems);
  add_parts_of_faces(problems);
  return problems;
}

}  // namespace finegauge
