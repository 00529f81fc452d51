#include "benchmarks/audit/audit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/scene/scene_error.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/scene_text.hpp"

namespace finegauge {
namespace {

std::string beam(double force) {
  return R"(
name = "beam"
[box]
size = [4, 1, 1]
cells = [8, 2, 2]
[material]
youngs_modulus = 1000
poisson_ratio = 0.3
[[support]]
surface = "x_min"
[[load]]
surface = "x_max"
total_force = [0, 0, )" +
         std::to_string(-force) + R"(]
[[quantity]]
kind = "displacement"
name = "end"
point = [4, 0.5, 0.5]
)";
}

Audit audit_of(const std::string& text, double tolerance = 0.02) {
  const TemporaryFile file("audited.toml", text);
  AuditOptions options;
  options.scene = file.path().string();
  options.tolerance = tolerance;
  return run_audit(options);
}

const AuditedIngredient& ingredient(const Audit& audit, const std::string& name) {
  const auto found = std::ranges::find_if(audit.ingredients,
                                          [&](const AuditedIngredient& one) { return one.ingredient.name == name; });
  REQUIRE(found != audit.ingredients.end());
  return *found;
}

}  // namespace

TEST_CASE("corotation is spare for a beam that hardly bends and needed for one that bends far") {
  // The end turns by F L² / (2 E I): 0.001 and 0.6 of a radian.
  const Audit little = audit_of(beam(0.01)), far = audit_of(beam(6.0));
  CHECK(little.with_itself.energy_norm_change == 0.0);
  CHECK(little.finished);
  const AuditedIngredient &small = ingredient(little, "corotation"), &large = ingredient(far, "corotation");
  CHECK_FALSE(small.ingredient.present);
  CHECK(small.verdict == Verdict::spare);
  CHECK(large.verdict == Verdict::needed);
  CHECK(small.comparison.largest_change() > 0.0);
  // What a linear beam gets wrong grows with the square of its rotation, along the beam with the rotation itself.
  CHECK(large.comparison.largest_change() > 50.0 * small.comparison.largest_change());
  CHECK(ingredient(far, "adaptivity").verdict == Verdict::needed);  // two cells across a beam lock by shear
}

TEST_CASE("what is left of a scene without its spare parts stays within the tolerance") {
  const std::string swing =
      beam(0.5) + "[dynamics]\ntime_step = 2e-3\nduration = 0.06\ndensity = 1\nstiffness_damping = 1e-9\n";
  const Audit audit = audit_of(swing, 0.01);
  REQUIRE(audit.finished);
  CHECK(ingredient(audit, "damping").verdict == Verdict::spare);
  CHECK(ingredient(audit, "damping").comparison.largest_change() > 0.0);
  CHECK(ingredient(audit, "inertia").verdict == Verdict::needed);  // a step load rings
  CHECK(ingredient(audit, "estimate").verdict == Verdict::spare);
  CHECK(ingredient(audit, "estimate").comparison.largest_change() == 0.0);
  REQUIRE(audit.cheapest);
  CHECK(audit.cheapest->comparison.largest_change() <= 0.01);
  CHECK(std::ranges::find(audit.cheapest->left_out, "inertia") == audit.cheapest->left_out.end());
}

TEST_CASE("an audit of a scene that does not run says so instead of judging") {
  CHECK_THROWS_AS(audit_of(replaced(beam(1.0), "point = [4, 0.5, 0.5]", "point = [5, 0.5, 0.5]")), SceneError);
  // Newton's iteration for a beam that is rolled up does not come to its end in one step.
  const std::string stubborn = replaced(beam(1e4), "[material]", "[material]\nkinematics = \"corotational\"");
  CHECK_THROWS_AS(audit_of(stubborn), std::runtime_error);
}

TEST_CASE("a body without inertia keeps its weight and its damping") {
  const std::string heavy = beam(0.0) + "[dynamics]\ntime_step = 2e-3\nduration = 0.02\ndensity = 500\n" +
                            "gravity = [0, 1, -9.81]\nmass_damping = 3\n";
  const std::vector<Ingredient> list = scene_ingredients(read(heavy));
  const auto inertia = std::ranges::find(list, "inertia", &Ingredient::name);
  REQUIRE(inertia != list.end());
  const Scene without = read(heavy, inertia->overrides);
  CHECK(without.dynamics->density < 1e-3);
  CHECK((without.dynamics->density * without.dynamics->gravity - 500.0 * Eigen::Vector3d(0, 1, -9.81)).norm() < 1e-6);
  CHECK(std::abs(without.dynamics->density * without.dynamics->mass_damping - 1500.0) < 1e-6);
}

TEST_CASE("a change that cannot be judged is neither needed nor spare") {
  SceneComparison c;
  CHECK(judge(c, 0.1) == Verdict::undecided);  // did not run
  c.complete = true;
  c.quantity_change["force"] = std::numeric_limits<double>::quiet_NaN();
  c.energy_norm_change = 0.2;
  CHECK(c.largest_change() == 0.2);  // nothing else to go by
  CHECK(judge(c, 0.1) == Verdict::needed);
  c.quantity_change["end"] = 0.1;
  CHECK(judge(c, 0.1) == Verdict::spare);
  c.changed_unconverged = 1;
  CHECK(judge(c, 0.1) == Verdict::undecided);
  c = scene_comparison(to_json(c));
  CHECK(c.changed_unconverged == 1);
  CHECK(std::isnan(c.quantity_change.at("force")));
}

TEST_CASE("what is spare is worth leaving out where it saves a hundredth of the time and more than noise does") {
  Audit audit;
  audit.with_itself.mean_ms = 1.0;
  const auto add = [&](const char* name, double saved, Verdict verdict, bool present) {
    AuditedIngredient one{{name, "", present, {}}, {}, verdict};
    one.comparison.mean_ms = 1.0, one.comparison.changed_mean_ms = 1.0 - saved;
    audit.ingredients.push_back(one);
  };
  add("little", 0.009, Verdict::spare, true);
  add("some", 0.02, Verdict::spare, true);
  add("much", 0.4, Verdict::spare, true);
  add("needed", 0.5, Verdict::needed, true);
  add("absent", 0.5, Verdict::spare, false);
  add("costly", -0.1, Verdict::spare, true);
  const auto names = [&](double noise) {
    audit.with_itself.changed_mean_ms = 1.0 + noise;
    std::string list;
    for (const AuditedIngredient* one : savings(audit)) list += one->ingredient.name + " ";
    return list;
  };
  CHECK(names(0.0) == "much some ");
  CHECK(names(0.006) == "much some ");
  CHECK(names(0.007) == "much ");
  CHECK(names(-0.007) == "much ");
}

TEST_CASE("each ingredient of the scenes that ship is a scene that can be read") {
  for (const char* name : {"phantom", "liver", "lshape", "block_swing"}) {
    const std::filesystem::path file = reference_data() / "scenes" / (std::string(name) + ".toml");
    const Scene scene = read_scene(file);
    const std::vector<Ingredient> list = scene_ingredients(scene);
    CHECK(list.size() >= 3);
    for (const Ingredient& one : list) {
      INFO(name << ": " << one.name);
      CHECK_NOTHROW(read_scene(file, one.overrides));
      CHECK_FALSE(one.overrides.empty());
    }
  }
}

}  // namespace finegauge
