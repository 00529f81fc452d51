#include "benchmarks/paper/paper_numbers.hpp"

#include <stdexcept>

#include "benchmarks/paper/needle_cases.hpp"
#include "core/scene/scene_reader.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/temporary_file.hpp"

using namespace finegauge;

namespace {

/// What reading the text as a file of the paper's numbers, and then an entry of it, throws; empty: nothing.
std::string complaint(const std::string& text, const std::string& key) {
  const TemporaryFile file("paper.json", text);
  try {
    static_cast<void>(PaperNumbers(file.path()).value(key));
  } catch (const std::runtime_error& error) {
    const std::string message = error.what(), name = file.path().string();
    REQUIRE(message.starts_with(name));
    return message.substr(name.size());
  }
  return "";
}

}  // namespace

TEST_CASE("a number of the paper is read with its place, and a table shows its digits", "[paper]") {
  const PaperNumbers paper = paper_numbers("phantom");
  CHECK(paper.value("frames_per_second_adaptive") == 45.0);
  CHECK(paper("frames_per_second_adaptive") == "45");
  CHECK(paper.place("frames_per_second_adaptive") == "text beside the figure of the number of DOFs");
  CHECK(paper.values("puncture_strengths") == std::vector{0.0, 10.0, 20.0});
  CHECK(paper.words("dofs") == paper("dofs"));
}

TEST_CASE("a file of the paper's numbers that is missing or broken is named, with the key", "[paper]") {
  CHECK_THROWS_WITH(PaperNumbers("no/such/file.json"), "no/such/file.json: cannot be opened");
  const std::string good = R"({"source": "x", "speed": {"value": 2.5, "place": "Table 1"}})";
  CHECK(complaint(good, "speed") == "");
  CHECK(complaint(good, "weight") == ": has no weight");
  CHECK(complaint(good, "source") == ": has no source");
  CHECK(complaint(R"({"speed": {"value": "fast", "place": "Table 1"}})", "speed") ==
        ": the value of speed is not a number");
  CHECK(complaint(R"({"speed": {"value": 2.5}})", "speed") == ": speed has no value or no place");
  CHECK(complaint(R"({"speed": {"place": "Table 1"}})", "speed") == ": speed has no value or no place");
  CHECK(complaint(R"({"speed": 2.5})", "speed") == ": speed has no value or no place");
  CHECK(complaint("[]", "speed") == ": is not an object of entries");
  CHECK(complaint(R"({"speed": )", "speed").find("parse error") != std::string::npos);
}

TEST_CASE("what the paper says of its needle studies is what our scenes have", "[paper][scene]") {
  const PaperNumbers phantom = paper_numbers("phantom"), field = paper_numbers("displacement_field");
  Scene scene = read_scene(scene_file("phantom"), {});
  CHECK(scene.material.youngs_modulus == phantom.value("tissue_youngs_modulus"));
  CHECK(scene.material.poisson_ratio == phantom.value("tissue_poisson_ratio"));
  CHECK(scene.needle->properties.youngs_modulus == phantom.value("needle_youngs_modulus"));
  CHECK(scene.needle->properties.poisson_ratio == phantom.value("needle_poisson_ratio"));
  CHECK(scene.needle->properties.radius == phantom.value("needle_radius"));
  CHECK_THAT((scene.needle->tip - scene.needle->base).norm(), WithinRel(phantom.value("needle_length"), 1e-12));
  CHECK(scene.needle->contact.surface_friction == phantom.value("surface_friction"));
  CHECK(scene.needle->contact.friction_in == phantom.value("friction_of_puncture_strengths"));
  CHECK(scene.needle->contact.puncture_strength == phantom.value("puncture_strength_of_frictions"));
  const auto& box = std::get<BoxMeshOptions>(scene.geometry);
  for (int axis = 0; axis < 3; ++axis) {
    CHECK(box.size[axis] == phantom.values("block_size").at(static_cast<std::size_t>(axis)));
    CHECK(box.cells[axis] + 1 == phantom.values("nodes_coarse").at(static_cast<std::size_t>(axis)));
  }
  scene = read_scene(scene_file("displacement_field"), {});
  CHECK(scene.material.youngs_modulus == field.value("tissue_youngs_modulus"));
  CHECK(scene.material.poisson_ratio == field.value("poisson_ratio"));
  CHECK(scene.needle->properties.youngs_modulus == field.value("needle_youngs_modulus"));
  CHECK(scene.needle->properties.poisson_ratio == field.value("poisson_ratio"));
  CHECK(scene.needle->contact.friction_in == field.value("friction"));
}
