#include "verification/studies/determinism.hpp"

#include <cmath>

#include "core/parallel/for_parts.hpp"
#include "core/scene/scene_error.hpp"
#include "verification/support/check_claims.hpp"
#include "verification/support/temporary_file.hpp"

using namespace finegauge;

namespace {

std::uint64_t hash_of(std::string_view bytes) {
  StateHash hash;
  hash.add(bytes);
  return hash.value();
}

std::uint64_t hash_of(double value) {
  StateHash hash;
  hash.add(value);
  return hash.value();
}

}  // namespace

TEST_CASE("the same scene ends in the same bits again, and where this build should", "[determinism]") {
  const Evidence evidence = determinism_evidence({});
  check_claims(evidence, 15);
}

TEST_CASE("the golden states are written anew", "[.][update]") {
  write_golden_states(find_golden_states(), golden_states_file());
  WARN("written: " << golden_states_file().string() << "; commit it alone, with the reason");
}

TEST_CASE("the hash of states is FNV-1a", "[determinism]") {
  // The authors' own test vectors.
  CHECK(hash_of("") == 0xcbf29ce484222325);
  CHECK(hash_of("a") == 0xaf63dc4c8601ec8c);
  CHECK(hash_of("foobar") == 0x85944171f73967e8);
  CHECK(hex(hash_of("a")) == "af63dc4c8601ec8c");
  CHECK(hex(0x1f) == "000000000000001f");
  CHECK(hash_of(1.0) == hash_of(std::string_view("\0\0\0\0\0\0\xf0\x3f", 8)));  // of 0x3ff0000000000000
  CHECK(hash_of(0.0) != hash_of(-0.0));
  CHECK(hash_of(1.0) != hash_of(std::nextafter(1.0, 2.0)));
}

TEST_CASE("golden states are read back as they were written", "[determinism]") {
  GoldenStates golden{{"g++ 1.2", "SSE", "Eigen", "none"}, {}};
  golden.states.push_back({"one", "static", "0123456789abcdef", 12, 3, 4, 1.0 / 3.0, 2e-300, -0.1});
  golden.states.push_back({"two", "a.b=[1,2] 20 frames", "fedcba9876543210", 0, 0, 0, 0.0, 1e300, 0.0});
  const TemporaryFile file("golden.toml", "nothing");
  CHECK_THROWS_AS(read_golden_states(file.path()), SceneError);
  write_golden_states(golden, file.path());
  const GoldenStates read = read_golden_states(file.path());
  CHECK(read.reference == golden.reference);
  REQUIRE(read.states.size() == 2);
  for (std::size_t k = 0; k < 2; ++k) CHECK(deviation(golden.states[k], read.states[k], true).empty());
  CHECK(read.states[0].largest_displacement == 1.0 / 3.0);
  CHECK(read.states[1].reduced_by == "a.b=[1,2] 20 frames");
}

TEST_CASE("a golden state gates bits where the build is the reference, and numbers everywhere", "[determinism]") {
  const GoldenState golden{"one", "static", "00", 12, 3, 4, 1e-3, 2.0, -0.5};
  GoldenState found = golden;
  CHECK(deviation(golden, found, true).empty());
  found.hash = "01";
  CHECK(deviation(golden, found, true) == "other bits");
  CHECK(deviation(golden, found, false).empty());
  found.energy = 2.0 * (1.0 + 0.9e-6);
  CHECK(deviation(golden, found, false).empty());
  found.energy = 2.0 * (1.0 + 1.1e-6);
  CHECK(deviation(golden, found, false) == "another energy");
  found = golden;
  found.force = -0.5 * (1.0 - 1.1e-6);
  CHECK(deviation(golden, found, true) == "another force");
  found = golden;
  found.largest_displacement = std::nan("");
  CHECK(deviation(golden, found, true) == "another displacement");
  found = golden;
  found.dofs = 15;
  CHECK(deviation(golden, found, false) == "another mesh");
  found = golden;
  found.reduced_by = "20 frames";
  CHECK(deviation(golden, found, false) == "another run");

  CHECK(difference(golden, golden) == 0.0);
  found = golden;
  found.dofs = 15;
  found.energy = 1.0;
  CHECK_THAT(difference(golden, found), WithinAbs(0.25 + 0.5, 1e-15));
  found.force = std::nan("");
  CHECK_FALSE(difference(golden, found) <= 1e9);
}

TEST_CASE("threads are what they were once the counts are given back", "[determinism]") {
  const int before = ThreadCounts::blas();
  {
    const ThreadCounts two(2, 2, 2);
    const int core = thread_count();
    CHECK((core == 2 || core == 1));  // one where the core is built without OpenMP
    const int during = ThreadCounts::blas();
    CHECK((during == 2 || during == 1));  // one where BLAS has no threads
    const ThreadCounts one(1, 1);
    CHECK(ThreadCounts::blas() == 1);
    CHECK(thread_count() == 1);
  }
  CHECK(thread_count() == 1);
  CHECK(ThreadCounts::blas() == before);
}
