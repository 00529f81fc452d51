#include "verification/studies/reversibility.hpp"

#include <algorithm>

#include "verification/support/check_claims.hpp"
#include "verification/support/refinement_history.hpp"

using namespace finegauge;

TEST_CASE("refining and coarsening wears nothing out", "[reversibility]") {
  check_claims(reversibility_evidence({}), 25);
}

TEST_CASE("a history that breaks a statement is shrunk to operations that are all needed", "[property]") {
  // A list of numbers that must not hold a 7 before a 3, whatever lies between.
  const Property<int> property = [](const std::vector<int>& numbers) {
    const auto seven = std::ranges::find(numbers, 7);
    return std::find(seven, numbers.end(), 3) != numbers.end() ? "7 before 3" : "";
  };
  std::vector<int> numbers;
  for (int k = 0; k < 200; ++k) numbers.push_back((13 * k + 1) % 40);
  const Counterexample<int> found = shrink(numbers, property);
  CHECK(found.history == std::vector<int>{7, 3});
  CHECK(found.drawn == numbers);
  CHECK(found.fault == "7 before 3");
  CHECK(found.runs < 100);  // twice 200 operations by halves, not 200² / 2
  CHECK_THROWS_AS(shrink({3, 7}, property), std::invalid_argument);
}

TEST_CASE("what is thrown breaks a statement, and what is always broken needs no operation", "[property]") {
  const Property<int> thrower = [](const std::vector<int>& numbers) -> std::string {
    if (numbers.size() > 2) throw std::runtime_error("three");
    return {};
  };
  const Counterexample<int> found = shrink({1, 2, 3, 4, 5}, thrower);
  CHECK(found.history.size() == 3);
  CHECK(found.fault == "thrown: three");
  const Property<int> always = [](const std::vector<int>&) { return "always"; };
  CHECK(shrink({1, 2, 3}, always).history.empty());
}

TEST_CASE("a check ends at the first seed whose history breaks the statement", "[property]") {
  const std::array<std::uint32_t, 4> seeds = {2, 4, 5, 7};
  const auto draw = [](std::uint32_t seed) { return std::vector<std::uint32_t>{8, seed, 6}; };
  const Property<std::uint32_t> even = [](const std::vector<std::uint32_t>& numbers) {
    return std::ranges::any_of(numbers, [](std::uint32_t n) { return n % 2 == 1; }) ? "odd" : "";
  };
  const auto check = check_property<std::uint32_t>(seeds, draw, even);
  REQUIRE(check.counterexample);
  CHECK(check.histories == 3);
  CHECK(check.counterexample->seed == 5);
  CHECK(check.counterexample->history == std::vector<std::uint32_t>{5});
  CHECK_FALSE(check_property<std::uint32_t>(std::span(seeds).first(2), draw, even).counterexample);
}

TEST_CASE("a history of a forest is text and back, and means the same with operations left out", "[property]") {
  for (const HistoryBody& body : history_bodies()) {
    CAPTURE(body.name);
    const ForestHistory history = drawn_history(body, 1);
    REQUIRE(history.size() == 24);
    CHECK(parse_history(to_text(history)) == history);
    RefinementForest forest(body.base), again(body.base);
    CHECK(perform(history, forest) == history);  // drawn to fit
    // Without its first operation some of the rest fits no more; what does is a history by itself.
    const ForestHistory rest(history.begin() + 1, history.end());
    RefinementForest shorter(body.base);
    const ForestHistory done = perform(rest, shorter);
    CHECK(perform(done, again) == done);
    CHECK(same_bits(shorter.leaf_mesh(), again.leaf_mesh(), true));
  }
  for (const char* wrong : {"refine 0", "refine 0 1x1x1", "coarsen", "coarsen 0 2x2x2", "refine 0//1 2x2x2",
                            "refine -1 2x2x2", "refine 0/ 2x2x2", "split 0 2x2x2", "refine 0 2x2x2 more"})
    CHECK_THROWS_AS(parse_history(wrong), std::invalid_argument);
  CHECK_THROWS_WITH(parse_history("refine 0 2x2x2\n\nrefine x 2x2x2"), ContainsSubstring("line 3"));
  CHECK(parse_history("").empty());
}

TEST_CASE("an operation that does not fit the forest does nothing", "[property]") {
  const HistoryBody box = history_bodies().front();
  RefinementForest forest(box.base);
  const Mesh start = forest.leaf_mesh();
  for (const char* misfit : {"coarsen 0", "refine 99 2x2x2", "refine 0/3 2x2x2", "coarsen 1/0"})
    CHECK(perform(parse_history(misfit), forest).empty());
  CHECK(same_bits(start, forest.leaf_mesh(), true));
  CHECK(perform(parse_history("refine 0 2x1x1\nrefine 0 2x2x2\nrefine 0/1 1x1x3\ncoarsen 0\nrefine 0/2 2x2x2"), forest)
            .size() == 2);
  CHECK(forest.leaf_count() == static_cast<int>(box.base.cells.size()) + 3);
}
