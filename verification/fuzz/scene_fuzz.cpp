// A scene file among the seeds of the other two targets, to which it may refer: read_scene gives a scene of finite
// numbers on a sound mesh, or refuses. Lines "#set KEY=VALUE" at its beginning are overrides, as --set gives them.

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/mesh/immersed_body.hpp"
#include "core/scene/moving_scene.hpp"
#include "core/scene/scene_document.hpp"
#include "core/scene/scene_reader.hpp"
#include "verification/fuzz/fuzz_input.hpp"

using namespace finegauge;

namespace {

std::vector<std::string> overrides_in(std::string_view text) {
  constexpr std::string_view mark = "#set ";
  std::vector<std::string> overrides;
  while (text.starts_with(mark)) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    overrides.emplace_back(text.substr(mark.size(), end - mark.size()));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return overrides;
}

std::optional<double> number_in(const toml::node_view<const toml::node>& node) { return node.value<double>(); }

/// Scenes that are sound or may be, and that take a fuzzer too long or out of its folder: counts that a scene says in
/// a few digits, whose own limits (4 million cells, 10000 beams) take seconds and gigabytes, and paths to elsewhere.
bool is_left_out(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  constexpr double most_cells = 512, most_beams = 64, surface_extent = 4.0;  // of the seeds, at most
  try {
    const SceneDocument document(file, overrides, [](const std::string&, const std::string&) { return true; });
    const toml::node_view<const toml::node> root(document.root());
    double cells = 1.0;
    for (std::size_t axis = 0; axis < 3; ++axis) cells *= number_in(root["box"]["cells"][axis]).value_or(1.0);
    if (cells > most_cells) return true;
    const double scale = number_in(root["organ"]["scale"]).value_or(1.0);
    const double along = surface_extent * scale / number_in(root["organ"]["cell_size"]).value_or(scale);
    if (along * along * along > most_cells) return true;
    if (number_in(root["needle"]["elements"]).value_or(1.0) > most_beams) return true;
    for (const auto& path : {root["gmsh"]["file"], root["organ"]["surface"]})
      if (const std::string name = path.value_or(std::string()); name.find('/') != std::string::npos) return true;
  } catch (const SceneError&) {  // read_scene will say so, too
  }
  return false;
}

/// The first number of a scene that is not finite, by the name of its key.
class Numbers {
 public:
  template <class... Values>
  void check(const char* name, const Values&... values) {
    if (bad_.empty() && !(is_finite(values) && ...)) bad_ = name;
  }
  const std::string& bad() const { return bad_; }

 private:
  static bool is_finite(double x) { return std::isfinite(x); }
  template <class Derived>
  static bool is_finite(const Eigen::DenseBase<Derived>& x) {
    return x.allFinite();
  }
  std::string bad_;
};

/// At its points, between them, and before and after.
void check_course(const char* name, const std::optional<Course>& course, Numbers& numbers) {
  if (!course) return;
  std::vector<double> times = {0.0, 0.01, 1.0, 1e3};
  if (const auto* linear = std::get_if<LinearCourse>(&*course)) {
    numbers.check(name, linear->period);
    for (const auto& [time, factor] : linear->points) {
      numbers.check(name, time, factor);
      times.push_back(0.5 * times.back() + 0.5 * time);
      times.push_back(time);
    }
  }
  for (const double time : times) numbers.check(name, course_factor(*course, time));
}

void check_motion(const Scene& scene, Numbers& numbers) {
  const SceneDynamics& d = *scene.dynamics;
  numbers.check("dynamics", d.time_step, d.duration, d.density, d.mass_damping, d.stiffness_damping, d.gravity);
  numbers.check("dynamics", d.step.newton_residual, d.solver.linear.relative_residual, d.deadline_ms.value_or(0.0));
  if (const int frames = frame_count(d); frames < 1 || frames > 10'000'001) report_finding("accepted too many frames");
  if (d.adapt)
    numbers.check("adapt", d.adapt->refine_above, d.adapt->coarsen_below, d.adapt->tolerance, d.adapt->local_tolerance,
                  d.adapt->refine_at, d.adapt->coarsen_at, d.adapt->energy_floor);
  if (!scene.needle) return;
  const SceneNeedle& n = *scene.needle;
  numbers.check("needle", n.properties.youngs_modulus, n.properties.poisson_ratio, n.properties.radius,
                n.properties.density, n.base, n.tip, n.imperfection, n.imperfection_direction);
  for (const Stroke& stroke : n.drive.strokes) numbers.check("stroke", stroke.displacement, stroke.duration);
  numbers.check("contact", n.contact.puncture_strength, n.contact.cut_strength, n.contact.cut_advance,
                n.contact.friction_in, n.contact.friction_out, n.contact.surface_friction, n.contact.clamping,
                n.contact.coupling_radius, n.interaction.weight, n.interaction.tolerance);
  const Needle needle = scene_needle(n);
  numbers.check("needle", needle.rest_positions);
  for (const Eigen::Matrix3d& frame : needle.rest_frames) numbers.check("needle", frame);
}

/// Name of the key.
std::string number_that_is_not_finite(const Scene& scene) {
  Numbers numbers;
  if (const auto* box = std::get_if<BoxMeshOptions>(&scene.geometry)) numbers.check("box", box->origin, box->size);
  for (const SurfaceDefinition& s : scene.surfaces) numbers.check("surface", s.normal, s.point, s.tolerance);
  numbers.check("material", scene.material.youngs_modulus, scene.material.poisson_ratio);
  for (const SceneSupport& support : scene.supports) {
    numbers.check("support", support.displacement, support.gradient);
    if (support.normal) numbers.check("support.normal", *support.normal);
    check_course("support.course", support.course, numbers);
  }
  for (const SceneAttachment& attachment : scene.attachments) {
    numbers.check("attachment", attachment.stiffness, attachment.displacement);
    check_course("attachment.course", attachment.course, numbers);
  }
  for (const SurfaceLoad& load : scene.loads) numbers.check("load", load.value);
  numbers.check("load.body_force", scene.body_force);
  for (const InitialRefinement& region : scene.refinements)
    if (region.min.hasNaN() || region.max.hasNaN()) report_finding("accepted a region without corners");
  if (scene.adapt) numbers.check("adapt", scene.adapt->theta, scene.adapt->threshold, scene.adapt->tolerance);
  numbers.check("solver", scene.solver.linear.relative_residual, scene.solver.newton_residual);
  for (const QuantityOfInterest& quantity : scene.quantities) numbers.check("quantity", quantity.point);
  if (scene.dynamics) check_motion(scene, numbers);
  return numbers.bad();
}

void check_scene(const Scene& scene) {
  if (const std::string key = number_that_is_not_finite(scene); !key.empty())
    report_finding("accepted a number that is not finite in " + key);
  const BaseMesh mesh = base_mesh(scene);
  if (const std::string defect = validate(mesh); !defect.empty()) report_finding("accepted an unsound mesh: " + defect);
  if (mesh.body)
    if (const std::string defect = validate(*mesh.body, mesh); !defect.empty())
      report_finding("accepted an unsound body: " + defect);
  const auto exists = [&](const std::string& name) {
    return mesh.surfaces.contains(name) || mesh.regions.contains(name);
  };
  for (const SupportCondition& support : support_conditions(scene))
    if (!exists(support.surface)) report_finding("accepted a support of no surface: " + support.surface);
  for (const SurfaceLoad& load : scene.loads)
    if (!exists(load.surface)) report_finding("accepted a load on no surface: " + load.surface);
  for (const SpringSupport& support : spring_supports(scene))
    for (const SpringPoint& point : support.points)
      if (!(point.stiffness > 0.0 && std::isfinite(point.stiffness)))
        report_finding("accepted springs of stiffness " + std::to_string(point.stiffness));
}

bool copy_seeds(const FuzzFolder& folder) {
  const std::filesystem::path corpus = std::filesystem::path(__FILE__).parent_path() / "corpus";
  for (const char* kind : {"gmsh", "surface"})
    for (const auto& entry : std::filesystem::directory_iterator(corpus / kind))
      std::filesystem::copy_file(entry.path(), folder.path() / entry.path().filename());
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const FuzzFolder folder;
  [[maybe_unused]] static const bool has_seeds = copy_seeds(folder);
  const std::string_view text = text_of(data, size);
  const std::filesystem::path file = folder.write("scene.toml", text);
  const std::vector<std::string> overrides = overrides_in(text);
  if (is_left_out(file, overrides)) return 0;
  Scene scene;
  if (accepts(folder, [&] { scene = read_scene(file, overrides); })) check_scene(scene);
  return 0;
}
