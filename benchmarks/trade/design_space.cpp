#include "benchmarks/trade/design_space.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>

#include "core/mesh/immersed_body.hpp"

namespace finegauge {
namespace {

constexpr std::array mesh_factors = {0.5, 2.0 / 3.0, 1.0, 1.5, 2.0};
constexpr std::array time_step_factors = {4.0, 2.0, 1.0};
constexpr double reference_mesh_factor = 2.0, coarser_mesh_factor = 1.5;

std::string text(double value) {
  std::array<char, 40> buffer;
  std::snprintf(buffer.data(), buffer.size(), "%.6g", value);
  return buffer.data();
}

std::string key(const std::string& name, const std::string& value) {
  std::string both = name;
  return both.append("=").append(value);
}

std::string list_of(const std::array<int, 3>& numbers) {
  std::string list;
  for (const int number : numbers) list += (list.empty() ? "[" : ", ") + std::to_string(number);
  return list + "]";
}

/// A box of `factor` times the cells along each axis. With a removed block, which is whole cells, only where they come
/// out whole.
std::optional<TradeChoice> box_choice(const BoxMeshOptions& box, double factor) {
  bool whole = true;
  const auto scaled = [&](const std::array<int, 3>& numbers, int least) {
    std::array<int, 3> made{};
    for (std::size_t i = 0; i < 3; ++i) {
      made[i] = std::max(least, static_cast<int>(std::lround(factor * numbers[i])));
      whole &= std::abs(factor * numbers[i] - made[i]) < 1e-9;
    }
    return made;
  };
  const std::array<int, 3> cells = scaled(box.cells, 1);
  TradeChoice choice{"", {key("box.cells", list_of(cells))}};
  for (const int number : cells) choice.label += (choice.label.empty() ? "" : " x ") + std::to_string(number);
  if (box.removed) {
    choice.overrides.push_back(key("box.removed_first", list_of(scaled(box.removed->first, 0))));
    choice.overrides.push_back(key("box.removed_last", list_of(scaled(box.removed->last, 0))));
    if (!whole) return {};
  }
  return choice;
}

/// The base mesh finer by a factor along each axis; none for geometries whose mesh is given, and where cells do not
/// come out whole that must.
std::optional<TradeChoice> base_mesh_choice(const Scene& scene, double factor) {
  if (const auto* box = std::get_if<BoxMeshOptions>(&scene.geometry)) return box_choice(*box, factor);
  const BaseMesh& mesh = std::get<BaseMesh>(scene.geometry);
  if (!mesh.body) return {};
  const double size = mesh.body->cell_size.x() / factor;
  return TradeChoice{"cells of " + text(size) + " m", {key("organ.cell_size", text(size))}};
}

CellShape cell_shape(const Scene& scene) {
  const auto* box = std::get_if<BoxMeshOptions>(&scene.geometry);
  return box ? box->shape : std::get<BaseMesh>(scene.geometry).shape;
}

void add(std::vector<TradeAxis>& axes, TradeAxis axis) {
  if (axis.choices.size() > 1) axes.push_back(std::move(axis));
}

/// An axis of values of one key around the scene's own, which is the one without overrides.
TradeAxis values_of(const std::string& name, const std::string& about, const std::string& field,
                    const std::vector<double>& values, double own) {
  TradeAxis axis{name, about, {}, 0};
  for (const double value : values) {
    const bool is_own = std::abs(value - own) <= 1e-9 * std::abs(own);
    if (is_own) axis.own = static_cast<int>(axis.choices.size());
    axis.choices.push_back({text(value), is_own ? std::vector<std::string>{} : std::vector{key(field, text(value))}});
  }
  return axis;
}

/// The same of the key's words.
TradeAxis words_of(const std::string& name, const std::string& about, const std::string& field,
                   const std::vector<std::string>& words, const std::string& own) {
  TradeAxis axis{name, about, {}, 0};
  for (const std::string& word : words) {
    if (word == own) axis.own = static_cast<int>(axis.choices.size());
    axis.choices.push_back({word, word == own ? std::vector<std::string>{} : std::vector{key(field, word)}});
  }
  return axis;
}

std::vector<double> with_own(std::vector<double> values, double own) {
  if (std::ranges::none_of(values, [&](double v) { return std::abs(v - own) <= 1e-9 * own; })) values.push_back(own);
  std::ranges::sort(values, std::greater<>());
  return values;
}

TradeAxis base_mesh_axis(const Scene& scene) {
  TradeAxis axis{"base_mesh", "the mesh before any refinement", {}, 0};
  for (const double factor : mesh_factors) {
    std::optional<TradeChoice> choice = base_mesh_choice(scene, factor);
    if (!choice) continue;
    if (factor == 1.0) choice->overrides.clear();
    const auto same = std::ranges::find(axis.choices, choice->label, &TradeChoice::label);
    if (same != axis.choices.end()) {
      if (factor == 1.0) same->overrides.clear(), axis.own = static_cast<int>(same - axis.choices.begin());
      continue;
    }
    if (factor == 1.0) axis.own = static_cast<int>(axis.choices.size());
    axis.choices.push_back(std::move(*choice));
  }
  return axis;
}

void add_adaptivity(const Scene& scene, std::vector<TradeAxis>& axes) {
  const SceneDynamics& dynamics = *scene.dynamics;
  if (!dynamics.adapt) {
    add(axes, words_of("estimate", "whether each frame's error is estimated", "dynamics.estimate_error",
                       {"false", "true"}, dynamics.estimate_error ? "true" : "false"));
    return;
  }
  const FrameAdaptRules& adapt = *dynamics.adapt;
  TradeAxis depth{"adaptivity", "off, or how often a cell may be refined", {}, adapt.max_depth};
  depth.choices.push_back({"off", {"adapt.enabled=false", "dynamics.estimate_error=false"}});
  for (int levels = 1; levels <= std::max(2, adapt.max_depth + 1); ++levels)
    depth.choices.push_back({std::to_string(levels),
                             levels == adapt.max_depth ? std::vector<std::string>{}
                                                       : std::vector{key("adapt.max_depth", std::to_string(levels))}});
  if (adapt.max_depth == 0) depth.own = 0;
  add(axes, depth);
  if (asks_for_tolerance(adapt) && adapt.tolerance > 0.0) {
    std::vector<double> values;
    for (const double factor : {2.0, 1.4, 1.0, 0.7, 0.5})
      if (factor * adapt.tolerance < 1.0) values.push_back(factor * adapt.tolerance);
    add(axes, values_of("tolerance", "of the estimated error", "adapt.tolerance", values, adapt.tolerance));
  } else {
    TradeAxis theta{"theta", "share of the largest error from which cells are refined", {}, 0};
    for (const double value : with_own({0.7, 0.5, 0.3, 0.15}, adapt.refine_above)) {
      const bool own = value == adapt.refine_above;
      if (own) theta.own = static_cast<int>(theta.choices.size());
      std::vector<std::string> keys = {key("adapt.theta", text(value))};
      if (adapt.coarsen_below >= value) keys.push_back(key("adapt.coarsen_below", text(0.5 * value)));
      theta.choices.push_back({text(value), own ? std::vector<std::string>{} : keys});
    }
    add(axes, theta);
  }
  const auto& divisions = adapt.refinement.divisions;
  const std::string own_template =
      adapt.directional
          ? "directional"
          : std::to_string(divisions[0]) + "x" + std::to_string(divisions[1]) + "x" + std::to_string(divisions[2]);
  TradeAxis policy{"template", "how a cell is divided", {}, 0};
  std::vector<std::string> names = {"2x2x2", "directional", "3x3x3"};
  if (std::ranges::find(names, own_template) == names.end()) names.push_back(own_template);
  for (const std::string& name : names) {
    const bool own = name == own_template;
    if (own) policy.own = static_cast<int>(policy.choices.size());
    const std::vector<std::string> keys =
        name == "directional" ? std::vector<std::string>{"adapt.policy=directional"}
                              : std::vector<std::string>{"adapt.policy=template", key("adapt.template", name)};
    policy.choices.push_back({name, own ? std::vector<std::string>{} : keys});
  }
  add(axes, policy);
  add(axes, words_of("estimator", "of the error", "adapt.estimator", {"spr", "spr_edges"},
                     scene.estimator == Estimator::spr ? "spr" : "spr_edges"));
  add(axes, values_of("every", "frames from one marking to the next", "adapt.every",
                      with_own({5.0, 2.0, 1.0}, adapt.every), adapt.every));
}

/// One linear solve a frame, or as many as an equilibrium error asks for: they gain a digit or less each, since the
/// matrix leaves out how rotations change.
TradeAxis newton_axis(const TissueStepOptions& step) {
  TradeAxis axis{"newton", "linear solves of a frame: one, or until what is out of balance is small", {}, 0};
  const bool several = step.newton_iterations > 1;
  axis.own = several ? 1 : 0;
  axis.choices.push_back(
      {"one", several ? std::vector<std::string>{"dynamics.newton_iterations=1"} : std::vector<std::string>{}});
  axis.choices.push_back({"several", several ? std::vector<std::string>{}
                                             : std::vector<std::string>{"dynamics.newton_iterations=50",
                                                                        "dynamics.newton_residual=1e-4"}});
  return axis;
}

void add_motion(const Scene& scene, std::vector<TradeAxis>& axes) {
  const SceneDynamics& dynamics = *scene.dynamics;
  std::vector<double> steps;
  for (const double factor : time_step_factors) steps.push_back(factor * dynamics.time_step);
  add(axes, values_of("time_step", "length of a frame [s]", "dynamics.time_step", steps, dynamics.time_step));
  if (scene.material.kinematics == Kinematics::corotational) add(axes, newton_axis(dynamics.step));
  add(axes, words_of("step_method", "kept: a factor that is kept while it serves; plain: none", "solver.step_method",
                     {"plain", "kept"}, dynamics.solver.method == StepMethod::kept ? "kept" : "plain"));
  const double residual = dynamics.solver.linear.relative_residual;
  add(axes, values_of("relative_residual", "at which a linear solve ends", "solver.relative_residual",
                      with_own({1e-3, 1e-4, 1e-6, 1e-8}, residual), residual));
  if (!scene.needle) return;
  const double tolerance = scene.needle->interaction.tolerance;
  add(axes, values_of("contact_tolerance", "at which Uzawa's iteration ends", "contact.tolerance",
                      with_own({1e-3, 1e-5, 1e-8}, tolerance), tolerance));
  const double elements = scene.needle->elements;
  std::vector<double> counts = {elements};
  for (const double factor : {0.5, 2.0})
    if (factor * elements >= 1.0) counts.push_back(std::floor(factor * elements));
  std::ranges::sort(counts);
  counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
  add(axes, values_of("needle_elements", "beam elements of the needle", "needle.elements", counts, elements));
  const double spacing = scene.needle->contact.cut_advance;
  add(axes, values_of("point_spacing", "between the points that the tip leaves along its path, and of a cut [m]",
                      "contact.cut_advance", {2.0 * spacing, spacing}, spacing));
}

void add_static(const Scene& scene, std::vector<TradeAxis>& axes) {
  if (scene.adapt) {
    std::vector<double> steps =
        with_own({0.0, std::floor(0.5 * scene.adapt->steps), scene.adapt->steps + 2.0}, scene.adapt->steps);
    std::ranges::sort(steps);
    steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
    add(axes, values_of("adapt_steps", "refinements at most", "adapt.steps", steps, scene.adapt->steps));
    if (scene.adapt->marking != Marking::threshold)
      add(axes, values_of("theta", "of the marking", "adapt.theta", with_own({0.7, 0.5, 0.3, 0.15}, scene.adapt->theta),
                          scene.adapt->theta));
    add(axes, words_of("policy", "template: all cells alike; directional: by the direction of the error",
                       "adapt.policy", {"template", "directional"},
                       scene.adapt->policy == RefinementPolicy::directional ? "directional" : "template"));
    add(axes, words_of("estimator", "of the error", "adapt.estimator", {"spr", "spr_edges"},
                       scene.estimator == Estimator::spr ? "spr" : "spr_edges"));
  }
  const LinearMethod method = scene.solver.method;
  add(axes, words_of("method", "of the linear solves", "solver.method", {"automatic", "direct", "multigrid"},
                     method == LinearMethod::direct      ? "direct"
                     : method == LinearMethod::multigrid ? "multigrid"
                                                         : "automatic"));
  const double residual = scene.solver.linear.relative_residual;
  add(axes, values_of("relative_residual", "at which a linear solve ends", "solver.relative_residual",
                      with_own({1e-3, 1e-4, 1e-6, 1e-9}, residual), residual));
}

/// Powers of two up to the processors, and the sweep's own.
TradeAxis threads_axis(int own, int processors) {
  std::set<int> numbers = {own};
  if (processors > 1)
    for (int number = 1; number <= processors; number *= 2) numbers.insert(number);
  TradeAxis axis{"threads", "that share the loops over cells, nodes and rows", {}, 0};
  for (const int number : numbers) {
    if (number == own) axis.own = static_cast<int>(axis.choices.size());
    axis.choices.push_back({std::to_string(number), {}, number == own ? 0 : number});
  }
  return axis;
}

}  // namespace

Json to_json(const TradeAxis& axis) {
  Json json = {{"name", axis.name}, {"about", axis.about}, {"own", axis.own}, {"choices", Json::array()}};
  for (const TradeChoice& choice : axis.choices)
    json["choices"].push_back({{"label", choice.label}, {"overrides", choice.overrides}, {"threads", choice.threads}});
  return json;
}

TradeAxis trade_axis(const Json& json) {
  TradeAxis axis{
      json.at("name").get<std::string>(), json.at("about").get<std::string>(), {}, json.at("own").get<int>()};
  for (const Json& choice : json.at("choices"))
    axis.choices.push_back({choice.at("label").get<std::string>(),
                            choice.at("overrides").get<std::vector<std::string>>(), choice.value("threads", 0)});
  return axis;
}

std::vector<TradeAxis> trade_axes(const Scene& scene, int threads, int processors) {
  std::vector<TradeAxis> axes;
  add(axes, base_mesh_axis(scene));
  if (scene.material.kinematics == Kinematics::corotational)  // of a linear problem it would be another problem
    add(axes, words_of("kinematics", "linear, or corotational cells", "material.kinematics", {"linear", "corotational"},
                       "corotational"));
  add(axes, words_of("dilatation", "standard, or mean: locking-free cells", "material.dilatation", {"standard", "mean"},
                     scene.material.dilatation == Dilatation::mean ? "mean" : "standard"));
  if (scene.dynamics) {
    add_adaptivity(scene, axes);
    add_motion(scene, axes);
  } else {
    add_static(scene, axes);
  }
  add(axes, threads_axis(threads, processors));
  return axes;
}

TradeSetting own_setting(const std::vector<TradeAxis>& axes) {
  TradeSetting setting;
  for (const TradeAxis& axis : axes) setting.push_back(axis.own);
  return setting;
}

std::vector<std::string> overrides(const std::vector<TradeAxis>& axes, const TradeSetting& setting) {
  std::vector<std::string> list;
  for (std::size_t a = 0; a < axes.size(); ++a)
    for (const std::string& one : axes[a].choices.at(static_cast<std::size_t>(setting[a])).overrides)
      list.push_back(one);
  return list;
}

int threads(const std::vector<TradeAxis>& axes, const TradeSetting& setting) {
  int number = 0;
  for (std::size_t a = 0; a < axes.size(); ++a)
    number = std::max(number, axes[a].choices.at(static_cast<std::size_t>(setting[a])).threads);
  return number;
}

std::string describe(const std::vector<TradeAxis>& axes, const TradeSetting& setting) {
  std::string words;
  for (std::size_t a = 0; a < axes.size(); ++a)
    if (setting[a] != axes[a].own)
      words += (words.empty() ? "" : ", ") + axes[a].name + " " +
               axes[a].choices[static_cast<std::size_t>(setting[a])].label;
  return words.empty() ? "as the scene has it" : words;
}

double longest_time_step(const Scene& scene) {
  return scene.dynamics ? time_step_factors.front() * scene.dynamics->time_step : 0.0;
}

TradeReference trade_reference(const Scene& scene) {
  TradeReference reference;
  const auto each = [&](const std::string& name, const std::string& fine, const std::string& coarser) {
    reference.fine.push_back(key(name, fine));
    reference.coarser.push_back(key(name, coarser));
  };
  const auto both = [&](const std::string& name, const std::string& value) { each(name, value, value); };
  const auto add_mesh = [&](double factor, std::vector<std::string>& list) {
    if (const auto mesh = base_mesh_choice(scene, factor))
      list.insert(list.end(), mesh->overrides.begin(), mesh->overrides.end());
  };
  add_mesh(reference_mesh_factor, reference.fine);
  both("solver.relative_residual", "1e-9");
  if (!scene.dynamics) {
    // Refined until it is large, by direction: at edges where the stress has no bound this is what converges fast
    // enough for one run to be a truth for others.
    add_mesh(coarser_mesh_factor, reference.coarser);
    both("adapt.enabled", "true");
    both("adapt.steps", "40");
    both("adapt.theta", "0.3");
    both("adapt.policy", cell_shape(scene) == CellShape::hexahedron ? "directional" : "template");
    both("adapt.tolerance", "0");
    each("adapt.max_dofs", "100000", "25000");
    return reference;
  }
  add_mesh(coarser_mesh_factor, reference.coarser);
  if (scene.material.kinematics == Kinematics::corotational) {
    both("dynamics.newton_iterations", "100");
    both("dynamics.newton_residual", "1e-6");
  }
  const SceneDynamics& dynamics = *scene.dynamics;
  each("dynamics.time_step", text(0.5 * dynamics.time_step), text(dynamics.time_step));
  if (dynamics.adapt) {
    both("adapt.max_depth", std::to_string(std::max(1, dynamics.adapt->max_depth)));
    both("adapt.policy", "template");
    both("adapt.template", "2x2x2");
    both("adapt.every", "1");
    if (dynamics.adapt->tolerance > 0.0)
      each("adapt.tolerance", text(0.35 * dynamics.adapt->tolerance), text(0.5 * dynamics.adapt->tolerance));
    else
      each("adapt.theta", "0.1", "0.15"), both("adapt.coarsen_below", "0");
  }
  if (scene.needle) {
    both("contact.tolerance", "1e-9");
    both("contact.iterations", "1000");
    both("needle.elements", std::to_string(2 * scene.needle->elements));
  }
  return reference;
}

}  // namespace finegauge
