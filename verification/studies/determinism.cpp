#include "verification/studies/determinism.hpp"

#include <dlfcn.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>

#include "core/adapt/apply_refinements.hpp"
#include "core/adapt/marking.hpp"
#include "core/parallel/for_parts.hpp"
#include "core/scene/file_tokens.hpp"
#include "core/scene/moving_scene.hpp"
#include "core/scene/scene_reader.hpp"
#include "core/scene/start_forest.hpp"
#include "core/scene/text_file.hpp"
#include "core/static_step.hpp"
#include "verification/support/temporary_file.hpp"

namespace finegauge {
namespace {

/// A function of the process, found at run time: which BLAS and whether OpenMP is the installation's choice.
template <class Function>
Function* find_function(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

void set_threads(const char* setter, int count) {
  if (count < 1) return;
  if (auto* set = find_function<void(int)>(setter)) set(count);
}

int threads(const char* getter) {
  auto* get = find_function<int()>(getter);
  return get ? get() : 0;
}

/// Whether parallel regions of other libraries (CHOLMOD's, which ask for four threads) may be active.
void set_levels(int levels) {
  if (auto* set = find_function<void(int)>("omp_set_max_active_levels")) set(levels);
}

/// How many parts a loop really has that may have as many as there are threads.
int shared_by(int threads) {
  std::atomic<int> parts = 0;
  for_parts(threads, 1, [&](int, int) { ++parts; });
  return parts;
}

/// Holes of all small sizes in the heap, so that what a run allocates lies elsewhere, on other multiples of 16 bytes.
class DisturbedHeap {
 public:
  explicit DisturbedHeap(unsigned seed) {
    std::mt19937 generator(seed);
    std::vector<std::unique_ptr<char[]>> holes;
    for (int k = 0; k < 20000; ++k) {
      auto& block = (k % 2 ? blocks_ : holes).emplace_back(new char[16 + 16 * (generator() % 300)]);
      block[0] = 1;  // used, so that it is there
    }
  }

 private:
  std::vector<std::unique_ptr<char[]>> blocks_;
};

double largest_column(const Eigen::Matrix3Xd& field) { return std::sqrt(field.colwise().squaredNorm().maxCoeff()); }

void add_mesh(const Discretization& d, SceneEnd& end) {
  end.dofs = d.dof_count();
  end.cells = d.mesh.cell_count();
  end.hanging_nodes = d.hanging.hanging_count();
  end.values.insert(end.values.end(), d.mesh.nodes.data(), d.mesh.nodes.data() + d.mesh.nodes.size());
  for (const auto& cell : d.mesh.cells) end.values.insert(end.values.end(), cell.begin(), cell.end());
}

void add_frame(const FrameReport& report, SceneEnd& end) {
  if (!report.converged) throw std::runtime_error("frame " + std::to_string(report.frame) + " did not converge");
  end.refined += report.refined;
  end.energy = report.energy.kinetic + report.energy.elastic;
}

std::vector<int> mark(const AdaptRules& rules, const Eigen::VectorXd& eta) {
  const std::span<const double> cells(eta.data(), static_cast<std::size_t>(eta.size()));
  if (rules.policy == RefinementPolicy::one_template && rules.marking == Marking::maximum)
    return mark_maximum(cells, rules.theta);
  if (rules.policy == RefinementPolicy::one_template && rules.marking == Marking::fraction)
    return mark_fraction(cells, rules.theta);
  throw std::invalid_argument("no small scene marks by these rules");
}

void run_static(const Scene& scene, SceneEnd& end) {
  RefinementForest forest = start_forest(scene);
  const StaticProblem problem{scene.material, support_conditions(scene), scene.loads,    body_force(scene),
                              scene.solver,   spring_supports(scene),    scene.estimator};
  FactorCache factors;
  std::optional<StaticSolution> solution;
  for (int step = 0;; ++step) {
    solution = solve_static(forest, problem, solution ? &*solution : nullptr, factors);
    if (!solution->equilibrium.converged) throw std::runtime_error(scene.name + ": the solve did not converge");
    if (!scene.adapt || step == scene.adapt->steps) break;
    std::vector<Refinement> chosen;
    for (const int cell : mark(*scene.adapt, solution->estimate.eta)) chosen.push_back({cell, scene.adapt->refinement});
    end.refined += apply_refinements(forest, solution->discretization.mesh, chosen);
  }
  end.u = solution->equilibrium.u;
  end.values.assign(end.u.data(), end.u.data() + end.u.size());
  end.energy = solution->equilibrium.energy;
  add_mesh(solution->discretization, end);
}

void run_motion(const Scene& scene, int frames, SceneEnd& end) {
  const MotionProblem problem = motion_problem(scene);
  Tissue tissue = start_tissue(start_forest(scene), problem);
  EnergyLedger energy;
  for (int frame = 0; frame < frames; ++frame) add_frame(advance_frame(problem, tissue, energy), end);
  end.u = tissue.state.u;
  end.values = state_values(tissue);
  add_mesh(tissue.mesh.d, end);
}

void run_insertion(const Scene& scene, int frames, SceneEnd& end) {
  const InsertionProblem problem = insertion_problem(scene);
  Insertion insertion = start_insertion(start_forest(scene), problem);
  for (int frame = 0; frame < frames; ++frame) {
    const InsertionReport report = advance_frame(problem, insertion);
    add_frame(report.frame, end);
    end.force = report.force;
    end.contact_points = report.contact_points;
  }
  end.u = insertion.tissue.state.u;
  end.values = state_values(insertion);
  add_mesh(insertion.tissue.mesh.d, end);
}

std::string in_one_line(const SmallScene& scene) {
  std::string text;
  for (const std::string& override_text : scene.overrides) text += override_text + ' ';
  return scene.frames > 0 ? text + std::to_string(scene.frames) + " frames" : text + "static";
}

std::string exact_text(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

double relative_difference(double value, double reference) {
  return value == reference ? 0.0 : (value - reference) / std::abs(reference);
}

}  // namespace

void StateHash::add(std::string_view bytes) {
  constexpr std::uint64_t prime = 0x00000100000001b3;
  for (const char byte : bytes) hash_ = (hash_ ^ static_cast<unsigned char>(byte)) * prime;
}

void StateHash::add(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  std::array<char, 8> bytes;
  for (int k = 0; k < 8; ++k) bytes[k] = static_cast<char>((bits >> (8 * k)) & 0xff);
  add(std::string_view(bytes.data(), bytes.size()));
}

std::string hex(std::uint64_t hash) {
  char text[20];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

std::vector<SmallScene> small_scenes() {
  const std::string near_base = "needle.base=[-0.052,0.004,-0.19]", near_tip = "needle.tip=[-0.052,0.004,-0.09]";
  return {
      {"block_tetrahedra", {}, 0},
      {"cantilever_corotational", {}, 0},
      {"gmsh_block", {}, 0},
      {"incompressible_block", {"box.cells=[10,10,5]"}, 0},
      {"lshape", {"solver.method=direct", "adapt.steps=2"}, 0},
      {"patch_test", {}, 0},
      {"block_swing", {"dynamics.time_step=1e-2"}, 20},
      {"liver_breathing",
       {"organ.cell_size=0.05", "attachment[0].breathing_period=1", "attachment[0].breathing_ramp=0.1",
        "adapt.tolerance=0.2", "adapt.max_depth=1"},
       20},
      {"displacement_field", {"dynamics.time_step=2e-2"}, 20},
      {"phantom",
       {"dynamics.time_step=2e-2", "contact.puncture_strength=1", "adapt.theta=0.05", "adapt.coarsen_below=0.01"},
       20},
      {"liver",
       {near_base, near_tip, "organ.cell_size=0.05", "stroke[0].dwell=0.02", "stroke[1].speed=0.02",
        "adapt.tolerance=0.2", "adapt.max_depth=1", "contact.puncture_strength=2"},
       20},
      {"liver_local",
       {near_base, near_tip, "organ.cell_size=0.05", "stroke[0].dwell=0.02", "stroke[1].speed=0.02",
        "attachment[1].course=[[0,0],[0.1,1]]", "adapt.tolerance=0.2", "adapt.local_tolerance=0.05",
        "adapt.max_depth=1", "contact.puncture_strength=2"},
       20},
      {"liver_phantom",
       {near_base, near_tip, "organ.cell_size=0.05", "dynamics.time_step=2e-2", "contact.puncture_strength=2"},
       20},
  };
}

SceneEnd run_small_scene(const SmallScene& small) {
  const Scene scene = read_scene(reference_data() / "scenes" / (small.name + ".toml"), small.overrides);
  SceneEnd end;
  if (scene.needle)
    run_insertion(scene, small.frames, end);
  else if (scene.dynamics)
    run_motion(scene, small.frames, end);
  else
    run_static(scene, end);
  end.largest_displacement = largest_column(end.u);
  StateHash hash;
  for (const double value : end.values) hash.add(value);
  end.hash = hash.value();
  return end;
}

BuildDescription this_build() {
  BuildDescription build;
#if defined(__clang__)
  build.compiler = __VERSION__;
#elif defined(__GNUC__)
  build.compiler = std::string("g++ ") + __VERSION__;
#else
  build.compiler = "unknown";
#endif
  build.code = Eigen::SimdInstructionSetsInUse();
#if defined(__OPTIMIZE__)
  build.code += ", optimized";
#else
  build.code += ", not optimized";
#endif
#if defined(__FAST_MATH__)
  build.code += ", fast math";
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  build.code += ", sanitizer";
#endif
  build.libraries = "Eigen " + std::to_string(EIGEN_WORLD_VERSION) + '.' + std::to_string(EIGEN_MAJOR_VERSION) + '.' +
                    std::to_string(EIGEN_MINOR_VERSION);
  if (auto* version = find_function<int(int*)>("cholmod_version")) {
    int parts[3] = {};
    version(parts);
    build.libraries +=
        ", CHOLMOD " + std::to_string(parts[0]) + '.' + std::to_string(parts[1]) + '.' + std::to_string(parts[2]);
  }
  if (auto* version = find_function<const char*()>("gnu_get_libc_version"))
    build.libraries += std::string(", glibc ") + version();
  build.blas = "not OpenBLAS";
  if (auto* configuration = find_function<char*()>("openblas_get_config")) {
    const std::string words = configuration();  // name, version, and what it was built with
    build.blas = words.substr(0, words.find(' ', words.find(' ') + 1));
  }
  if (auto* kernel = find_function<char*()>("openblas_get_corename")) build.blas += std::string(", kernel ") + kernel();
  return build;
}

ThreadCounts::ThreadCounts(int blas, int openmp, int core)
    : blas_before_(threads("openblas_get_num_threads")),
      openmp_before_(threads("omp_get_max_threads")),
      core_before_(thread_count()),
      levels_before_(threads("omp_get_max_active_levels")) {
  set_thread_count(core);
  set_levels(openmp > 1 ? 1 : 0);
  set_threads("openblas_set_num_threads", blas);
  set_threads("omp_set_num_threads", openmp);
}

ThreadCounts::~ThreadCounts() {
  set_thread_count(core_before_);
  set_levels(levels_before_);
  set_threads("openblas_set_num_threads", blas_before_);
  set_threads("omp_set_num_threads", openmp_before_);
}

int ThreadCounts::blas() { return std::max(1, threads("openblas_get_num_threads")); }
int ThreadCounts::openmp() { return std::max(1, threads("omp_get_max_threads")); }

std::vector<RepeatRow> repeat_scene(const SmallScene& scene) {
  std::vector<RepeatRow> rows;
  SceneEnd first;
  const auto run = [&](const std::string& how, int blas, int openmp, int core) {
    const ThreadCounts counts(blas, openmp, core);
    const SceneEnd end = run_small_scene(scene);
    if (rows.empty()) first = end;
    RepeatRow row{.scene = scene.name, .how = how};
    row.blas_threads = ThreadCounts::blas();
    row.openmp_threads = ThreadCounts::openmp();
    row.core_threads = shared_by(core);
    row.refined = end.refined;
    row.contact_points = end.contact_points;
    row.values = static_cast<int>(end.values.size());
    row.changed = std::max(row.values, static_cast<int>(first.values.size()));
    row.largest_change = std::numeric_limits<double>::infinity();
    if (first.values.size() == end.values.size()) {
      row.changed = 0;
      for (std::size_t k = 0; k < end.values.size(); ++k)
        row.changed += std::bit_cast<std::uint64_t>(first.values[k]) != std::bit_cast<std::uint64_t>(end.values[k]);
      row.largest_change = largest_column(end.u - first.u) / first.largest_displacement;
    }
    rows.push_back(row);
  };
  run("first", 1, 1, 1);
  {
    const DisturbedHeap elsewhere(1);
    run("again, elsewhere in the heap", 1, 1, 1);
  }
  run("2 threads", 1, 1, 2);
  run("3 threads", 1, 1, 3);
  run("2 OpenMP threads in CHOLMOD too", 1, 2, 2);
  run("2 BLAS threads", 2, 2, 1);
  return rows;
}

std::filesystem::path golden_states_file() { return reference_data() / "golden_states.toml"; }

GoldenStates read_golden_states(const std::filesystem::path& file) {
  constexpr std::uintmax_t size_limit = 1 << 20;
  constexpr std::int64_t most = 100'000'000;
  const std::string text = read_text_file(file, size_limit);
  FileTokens tokens(file.string(), text);
  const auto quoted = [&](const char* key) {
    tokens.expect(key);
    tokens.expect("=");
    return tokens.quoted(key);
  };
  const auto whole = [&](const char* key) {
    tokens.expect(key);
    tokens.expect("=");
    return static_cast<int>(tokens.integer(key, 0, most));
  };
  const auto number = [&](const char* key) {
    tokens.expect(key);
    tokens.expect("=");
    return tokens.number(key);
  };
  GoldenStates golden;
  tokens.skip_to("[reference]");
  golden.reference = {quoted("compiler"), quoted("code"), quoted("libraries"), quoted("blas")};
  while (!tokens.at_end()) {
    tokens.expect("[[state]]");
    GoldenState state;
    state.scene = quoted("scene");
    state.reduced_by = quoted("reduced_by");
    state.hash = quoted("hash");
    state.dofs = whole("dofs");
    state.cells = whole("cells");
    state.hanging_nodes = whole("hanging_nodes");
    state.largest_displacement = number("largest_displacement");
    state.energy = number("energy");
    state.force = number("force");
    golden.states.push_back(state);
  }
  return golden;
}

void write_golden_states(const GoldenStates& golden, const std::filesystem::path& file) {
  std::ofstream out(file, std::ios::binary);
  out << "# Where the scenes, made small, end: written by `finegauge_study_tests \"[update]\"`, read by\n"
         "# verification/studies/determinism.cpp. Hashes (FNV-1a of the final state and mesh) are asked of the build\n"
         "# named here, the numbers of any build within 1e-6. SI, but for scenes without units.\n\n"
      << "[reference]\ncompiler = \"" << golden.reference.compiler << "\"\ncode = \"" << golden.reference.code
      << "\"\nlibraries = \"" << golden.reference.libraries << "\"\nblas = \"" << golden.reference.blas << "\"\n";
  for (const GoldenState& state : golden.states)
    out << "\n[[state]]\nscene = \"" << state.scene << "\"\nreduced_by = \"" << state.reduced_by << "\"\nhash = \""
        << state.hash << "\"\ndofs = " << state.dofs << "\ncells = " << state.cells
        << "\nhanging_nodes = " << state.hanging_nodes
        << "\nlargest_displacement = " << exact_text(state.largest_displacement)
        << "\nenergy = " << exact_text(state.energy) << "\nforce = " << exact_text(state.force) << '\n';
  if (!out.flush()) throw std::runtime_error(file.string() + ": cannot be written");
}

GoldenStates find_golden_states() {
  const ThreadCounts one(1, 1);
  GoldenStates golden{this_build(), {}};
  for (const SmallScene& scene : small_scenes()) {
    const SceneEnd end = run_small_scene(scene);
    golden.states.push_back({scene.name, in_one_line(scene), hex(end.hash), end.dofs, end.cells, end.hanging_nodes,
                             end.largest_displacement, end.energy, end.force});
  }
  return golden;
}

double difference(const GoldenState& golden, const GoldenState& found) {
  return std::abs(relative_difference(found.dofs, golden.dofs)) +
         std::abs(relative_difference(found.largest_displacement, golden.largest_displacement)) +
         std::abs(relative_difference(found.energy, golden.energy)) +
         std::abs(relative_difference(found.force, golden.force));
}

std::string deviation(const GoldenState& golden, const GoldenState& found, bool same_build) {
  if (golden.scene != found.scene || golden.reduced_by != found.reduced_by) return "another run";
  if (golden.dofs != found.dofs || golden.cells != found.cells || golden.hanging_nodes != found.hanging_nodes)
    return "another mesh";
  const auto beyond = [](double value, double reference) {
    return !(std::abs(relative_difference(value, reference)) <= golden_tolerance);
  };
  if (beyond(found.largest_displacement, golden.largest_displacement)) return "another displacement";
  if (beyond(found.energy, golden.energy)) return "another energy";
  if (beyond(found.force, golden.force)) return "another force";
  if (same_build && golden.hash != found.hash) return "other bits";
  return {};
}

namespace {

bool has_threads() {
  const ThreadCounts two(1, 1, 2);
  return thread_count() == 2;
}

int scene_count() {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(reference_data() / "scenes"))
    count += entry.path().extension() == ".toml";
  return count;
}

void claim_repeats(const std::vector<RepeatRow>& rows, Evidence& evidence) {
  EvidenceTable table{
      "The same scene again",
      {"scene", "how", "BLAS", "OpenMP", "core", "numbers", "changed", "change of u", "refined", "points"},
      {}};
  int changed = 0, most_points = 0, most_threads = 0;
  double by_blas = 0.0;
  for (const RepeatRow& row : rows) {
    table.rows.push_back({row.scene, row.how, 1.0 * row.blas_threads, 1.0 * row.openmp_threads, 1.0 * row.core_threads,
                          1.0 * row.values, 1.0 * row.changed, row.largest_change, 1.0 * row.refined,
                          1.0 * row.contact_points});
    if (row.blas_threads == 1)
      changed += row.changed;
    else
      by_blas = std::isnan(by_blas) || row.largest_change <= by_blas ? by_blas : row.largest_change;
    most_points = std::max(most_points, row.contact_points);
    most_threads = std::max(most_threads, row.core_threads);
  }
  evidence.tables.push_back(table);
  evidence.claim("numbers_that_another_run_changes", changed, 0, 0,
                 "every sum is taken in the same order, whatever the heap and the threads; BLAS has one, as in the "
                 "program");
  evidence.claim("change_by_two_BLAS_threads", by_blas, 0.0, 1e-9,
                 "BLAS sums in another order then: round-off times a condition number of 1e6 at most");
  evidence.claim("threads_that_shared_a_loop", most_threads, has_threads() ? 2 : 1, 3,
                 "two and three were asked for, where the core is built with OpenMP");
  evidence.claim("contact_points_at_the_end", most_points, 2, 100, "the needle is in the tissue");
}

EvidenceTable build_table(const BuildDescription& reference, const BuildDescription& here) {
  return {"What decides the last bits",
          {"", "reference", "here"},
          {{"compiler", reference.compiler, here.compiler},
           {"code", reference.code, here.code},
           {"libraries", reference.libraries, here.libraries},
           {"BLAS", reference.blas, here.blas}}};
}

void claim_golden(const GoldenStates& golden, const GoldenStates& found, Evidence& evidence) {
  const bool same_build = golden.reference == found.reference;
  evidence.tables.push_back(build_table(golden.reference, found.reference));
  EvidenceTable table{
      same_build ? "Where small scenes end: the reference build"
                 : "Where small scenes end: another build, whose bits are told and not asked for",
      {"scene", "dofs", "cells", "hanging", "largest u", "energy", "force", "hash", "golden", "verdict"},
      {}};
  int other_bits = 0, other_runs = 0;
  for (const GoldenState& state : found.states) {
    const auto match = std::ranges::find(golden.states, state.scene, &GoldenState::scene);
    const bool known = match != golden.states.end();
    const std::string fault = known ? deviation(*match, state, same_build) : "no golden";
    table.rows.push_back({state.scene, 1.0 * state.dofs, 1.0 * state.cells, 1.0 * state.hanging_nodes,
                          state.largest_displacement, state.energy, state.force, state.hash,
                          known ? match->hash : "none", fault.empty() ? "as it was" : fault});
    other_runs += !known || match->reduced_by != state.reduced_by;
    if (!known) continue;
    other_bits += same_build && match->hash != state.hash;
    evidence.claim(state.scene + "_against_its_golden", difference(*match, state), 0.0, golden_tolerance,
                   "steps are solved to 1e-9, statics to 1e-8: other sums end within a hundred times that");
  }
  if (same_build) evidence.claim("scenes_with_other_bits", other_bits, 0, 0, "the reference build has its own bits");
  evidence.claim("scenes_without_a_golden_of_this_run", other_runs, 0, 0, "the same overrides and frames");
  evidence.tables.push_back(table);
  const double scenes = scene_count();
  evidence.claim("scenes_with_a_golden", static_cast<double>(golden.states.size()), scenes, scenes,
                 "every scene of the reference data");
}

}  // namespace

Evidence determinism_evidence(const EvidenceOptions& options) {
  Evidence evidence;
  std::vector<RepeatRow> rows;
  const std::vector<SmallScene> scenes = small_scenes();
  int done = 0;
  for (const SmallScene& scene : scenes) {
    options.progress(0.5 * done++ / static_cast<double>(scenes.size()), scene.name + ", again");
    if (options.interrupted()) return evidence;
    if (!options.full && scene.name != "lshape" && scene.name != "phantom") continue;  // one of each kind
    for (const RepeatRow& row : repeat_scene(scene)) rows.push_back(row);
  }
  claim_repeats(rows, evidence);
  options.progress(0.5, "golden states");
  claim_golden(read_golden_states(golden_states_file()), find_golden_states(), evidence);
  return evidence;
}

}  // namespace finegauge
