#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "verification/support/evidence.hpp"

namespace finegauge {

/// The same scene gives the same bits: run to run in one process, wherever the heap puts its arrays, and for one and
/// two threads. From build to build the bits of one reference are stored, `reference_data/golden_states.toml`, with the
/// compiler, the instruction sets and the libraries that made them. A build that is the reference has to have the same
/// hashes; any other tells its own, and has to have the same numbers within golden_tolerance.
///
/// A change that means to change the last bits writes the file anew, alone and with the reason:
///
///     finegauge_study_tests "[update]"

/// FNV-1a, 64 bits (Fowler, Noll & Vo 1991): xor a byte, multiply by the prime. Of doubles their eight bytes, the
/// lowest first, so that -0 is not 0 and every NaN is told from another.
class StateHash {
 public:
  void add(std::string_view bytes);
  void add(double value);
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325;
};
std::string hex(std::uint64_t hash);

/// A scene of reference_data/scenes, made small enough for a test.
struct SmallScene {
  std::string name;
  std::vector<std::string> overrides;  ///< KEY=VALUE, scene_reader.hpp
  int frames = 0;                      ///< of a moving scene; the scene's own duration does not count
};
/// Every scene of reference_data/scenes.
std::vector<SmallScene> small_scenes();

/// Where a scene ended, and what happened on the way.
struct SceneEnd {
  Eigen::Matrix3Xd u;          ///< nodal displacement [m]
  std::vector<double> values;  ///< all that decides what would happen next, u among it, and the mesh
  std::uint64_t hash = 0;      ///< of these
  int dofs = 0, cells = 0, hanging_nodes = 0;
  double largest_displacement = 0.0;  ///< [m]
  double energy = 0.0;                ///< ∫ ε:σ of a static scene, kinetic and elastic of a moving one [J]
  double force = 0.0;                 ///< axial, on a needle [N]
  int refined = 0, contact_points = 0;
};
/// Throws SceneError where the scene cannot be read, and std::runtime_error when a solve fails.
SceneEnd run_small_scene(const SmallScene& scene);

/// What decides the last bits beside the source.
struct BuildDescription {
  std::string compiler;
  std::string code;       ///< instruction sets that Eigen uses, optimization, sanitizers: from the compiler's macros
  std::string libraries;  ///< Eigen, CHOLMOD, the C library with its sines
  std::string blas;       ///< version and kernel of OpenBLAS, as it chose them for this processor
  bool operator==(const BuildDescription&) const = default;
};
BuildDescription this_build();

/// How many threads BLAS, OpenMP and the core use while this lives; without effect where the installation has no such
/// switch.
class ThreadCounts {
 public:
  ThreadCounts(int blas, int openmp, int core = 1);
  ~ThreadCounts();
  ThreadCounts(const ThreadCounts&) = delete;
  ThreadCounts& operator=(const ThreadCounts&) = delete;
  static int blas();    ///< now; 1 where it cannot be told
  static int openmp();  ///< that CHOLMOD would use; likewise

 private:
  int blas_before_, openmp_before_, core_before_, levels_before_;
};

/// A run of a scene against the first one, which is told too.
struct RepeatRow {
  std::string scene, how;
  int blas_threads = 1, openmp_threads = 1, core_threads = 1;
  int values = 0, changed = 0;  ///< numbers of the end, and those that are not the same to the last bit
  double largest_change = 0.0;  ///< of the displacement, over the largest one
  int refined = 0, contact_points = 0;
};
std::vector<RepeatRow> repeat_scene(const SmallScene& scene);

struct GoldenState {
  std::string scene;
  std::string reduced_by;  ///< overrides and frames in one line: the golden of another run is none
  std::string hash;
  int dofs = 0, cells = 0, hanging_nodes = 0;
  double largest_displacement = 0.0, energy = 0.0, force = 0.0;
};
struct GoldenStates {
  BuildDescription reference;
  std::vector<GoldenState> states;
};
inline constexpr double golden_tolerance = 1e-6;
std::filesystem::path golden_states_file();
/// Throws SceneError with file and line on anything but what write_golden_states writes.
GoldenStates read_golden_states(const std::filesystem::path& file);
void write_golden_states(const GoldenStates& golden, const std::filesystem::path& file);
/// Of this build, from runs of all small scenes.
GoldenStates find_golden_states();
/// Relative differences of dofs, displacement, energy and force, summed; infinite where only the golden has a zero.
double difference(const GoldenState& golden, const GoldenState& found);
/// What is not as it should be, in words; empty when all is. Hashes are asked for only where the builds are the same.
std::string deviation(const GoldenState& golden, const GoldenState& found, bool same_build);

Evidence determinism_evidence(const EvidenceOptions& options);

}  // namespace finegauge
