#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "core/space/assembly.hpp"
#include "core/stopwatch.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/insertion_setup.hpp"
#include "verification/support/refinement_history.hpp"

using namespace finegauge;

namespace {

/// What a cycle of insertion, withdrawal and rest leaves behind.
struct Cycle {
  int most_cells = 0;
  std::size_t storage = 0;                  ///< forest and adaptation history [bytes], capacities
  double largest_u = 0.0, largest_v = 0.0;  ///< within the cycle [m], [m/s]
  double left_u = 0.0, left_v = 0.0;        ///< at its end
  int punctures = 0, exits = 0, unconverged = 0;
  double frame_ms = 0.0;     ///< median of its frames
  double resident_mb = 0.0;  ///< of the whole process, at its end; zero where the system does not tell
};

double resident_memory_mb() {
  std::ifstream statm("/proc/self/statm");
  long pages = 0, resident = 0;
  if (!(statm >> pages >> resident)) return 0.0;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

struct CycleRun {
  std::vector<Cycle> cycles;
  Insertion insertion;
  TissueMesh start;  ///< the mesh before the first
};

double largest(const Eigen::Matrix3Xd& field) { return std::sqrt(field.colwise().squaredNorm().maxCoeff()); }

/// In 8 mm, out, and rest until the body stands still: 60 frames a cycle.
CycleRun run_cycles(const FrameAdaptRules& rules, int count) {
  InsertionSetup setup;
  setup.cells = {6, 3, 3};
  setup.estimate_error = true;
  setup.adapt = rules;
  setup.contact.puncture_strength = setup.contact.cut_strength = 2.0;
  setup.strokes.clear();
  for (int cycle = 0; cycle < count; ++cycle) {
    setup.strokes.push_back({{0.0085, 0.0, 0.0}, 0.1});
    setup.strokes.push_back({{-0.0085, 0.0, 0.0}, 0.1});
    setup.strokes.push_back({Eigen::Vector3d::Zero(), 0.1});
  }
  InsertionCase made = insertion_case(setup);
  CycleRun run{{}, start_insertion(std::move(made.forest), made.problem), {}};
  Tissue& tissue = run.insertion.tissue;
  run.start = tissue.mesh;
  for (int k = 0; k < count; ++k) {
    Cycle cycle;
    std::array<double, 60> frame_ms{};
    for (int frame = 0; frame < 60; ++frame) {
      Stopwatch watch;
      const InsertionReport report = advance_frame(made.problem, run.insertion);
      frame_ms[frame] = watch.lap();
      cycle.most_cells = std::max(cycle.most_cells, tissue.mesh.d.mesh.cell_count());
      cycle.largest_u = std::max(cycle.largest_u, largest(tissue.state.u));
      cycle.largest_v = std::max(cycle.largest_v, largest(tissue.state.v));
      cycle.unconverged += !report.frame.converged;
      for (const ContactEvent& event : report.events) {
        cycle.punctures += event.kind == ContactEventKind::puncture;
        cycle.exits += event.kind == ContactEventKind::exit;
      }
    }
    cycle.left_u = largest(tissue.state.u);
    cycle.left_v = largest(tissue.state.v);
    cycle.storage = tissue.forest.storage_bytes() + tissue.history.von_mises.capacity() * sizeof(double) +
                    tissue.history.changed.capacity() * sizeof(int) + tissue.history.coarsened.capacity();
    std::nth_element(frame_ms.begin(), frame_ms.begin() + 30, frame_ms.end());
    cycle.frame_ms = frame_ms[30];
    cycle.resident_mb = resident_memory_mb();
    run.cycles.push_back(cycle);
  }
  return run;
}

/// The body is the one of the start, bit for bit, and nothing moves.
void check_return(const CycleRun& run) {
  const Tissue& tissue = run.insertion.tissue;
  const TissueMesh &now = tissue.mesh, &then = run.start;
  CHECK(same_bits(now.d.mesh, then.d.mesh, true));
  CHECK(now.d.hanging.row_start == then.d.hanging.row_start);
  CHECK(now.d.hanging.master == then.d.hanging.master);
  CHECK(now.d.hanging.weight == then.d.hanging.weight);
  CHECK(same_bits(now.mass, then.mass));
  CHECK(same_bits(now.loads, then.loads));
  CHECK(tissue.release.empty());
  const Eigen::Matrix3Xd rest = Eigen::Matrix3Xd::Zero(3, then.d.mesh.node_count());
  CHECK(assemble_stiffness(now.d, rest).values == assemble_stiffness(then.d, rest).values);
  CHECK(run.insertion.contacts.active_points() == 0);
  CHECK(run.insertion.contacts.tip_state() == TipState::outside);
  for (const Cycle& cycle : run.cycles) {
    CHECK(cycle.unconverged == 0);
    REQUIRE(cycle.punctures == 1);
    REQUIRE(cycle.exits == 1);
    REQUIRE(cycle.most_cells > then.d.mesh.cell_count());
    CHECK(cycle.largest_u > 1e-5);
    // Below the solver's tolerance, 1e-9 of each step's load and 1e-8 of the contact's speed, nothing moves it further.
    CHECK(cycle.left_u <= 1e-8 * cycle.largest_u);
    CHECK(cycle.left_v <= 1e-8 * cycle.largest_v);
  }
}

FrameAdaptRules follow(bool by_tolerance) {
  FrameAdaptRules rules{.dwell = 5, .release = 5};
  if (by_tolerance) rules.tolerance = 0.2;
  return rules;
}

}  // namespace

TEST_CASE("insertion, withdrawal and rest leave the body that there was, and no more memory", "[long run]") {
  const bool by_tolerance = GENERATE(false, true);
  CAPTURE(by_tolerance);
  const CycleRun run = run_cycles(follow(by_tolerance), 4);
  check_return(run);
  CHECK(run.cycles[3].storage == run.cycles[1].storage);
  CHECK(run.cycles[3].most_cells == run.cycles[1].most_cells);
}

TEST_CASE("a hundred insertions and withdrawals", "[.][long run]") {
  const bool by_tolerance = GENERATE(false, true);
  CAPTURE(by_tolerance);
  const CycleRun run = run_cycles(follow(by_tolerance), 100);
  check_return(run);
  CHECK(run.cycles.back().storage == run.cycles[1].storage);
  std::ostringstream figures;
  figures << "cycle, median frame [ms], resident [MB]";
  for (std::size_t k = 0; k < run.cycles.size(); k += k == 0 ? 9 : 10)
    figures << "\n  " << k + 1 << ", " << run.cycles[k].frame_ms << ", " << run.cycles[k].resident_mb;
  WARN(figures.str());
  // Times are for the reader. Of memory the allocator holds a megabyte more or less, the same after 30 cycles as after
  // a hundred.
  CHECK(run.cycles.back().resident_mb <= run.cycles[29].resident_mb + 1.0);
}
