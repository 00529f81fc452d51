#include "benchmarks/program/plots.hpp"

#include <algorithm>
#include <string>

#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

Plot decay(double low, double high) {
  Plot plot;
  plot.file = "decay.svg";
  plot.series = {{"curve", {100.0, 10000.0}, {high, low}, PlotLine::joined_with_slope}};
  return plot;
}

/// Labels of an axis: its list of ticks has a pair of quotes for each.
long tick_count(const std::string& script, const std::string& axis) {
  const std::size_t start = script.find("set " + axis + "tics ("), end = script.find('\n', start);
  REQUIRE(start != std::string::npos);
  return std::count(script.begin() + static_cast<long>(start), script.begin() + static_cast<long>(end), '"') / 2;
}

}  // namespace

TEST_CASE("the legend gives the slope without its sign", "[plots]") {
  const std::string script = gnuplot_script(decay(0.1, 10.0), "decay.svg");  // two decades over two decades
  CHECK(script.find("curve, slope 1.00") != std::string::npos);
  CHECK_THAT(logarithmic_slope(decay(0.1, 10.0).series[0]), WithinRel(-1.0, 1e-12));
}

TEST_CASE("a front goes in steps, with marks at its points alone", "[plots]") {
  Plot plot = decay(0.1, 10.0);
  REQUIRE_THAT(gnuplot_script(plot, "decay.svg"), ContainsSubstring("with linespoints"));
  plot.series[0].line = PlotLine::steps;
  const std::string script = gnuplot_script(plot, "decay.svg");
  CHECK_THAT(script, ContainsSubstring("$curve0 using 1:2 with steps"));
  CHECK_THAT(script, ContainsSubstring("$curve0 using 1:2 with points"));
  CHECK_THAT(script, !ContainsSubstring("linespoints"));
}

TEST_CASE("a logarithmic axis has two labelled ticks at the least, however short it is", "[plots]") {
  // The second and the third lie between two neighbours of 1, 2, 3, 4, 5, 6, 8; the last ends before the decade.
  const auto [low, high] = GENERATE(std::pair{0.01, 10.0}, std::pair{0.32, 0.36}, std::pair{6.4, 7.2},
                                    std::pair{3.01, 3.02}, std::pair{0.083, 0.0985});
  const std::string script = gnuplot_script(decay(low, high), "decay.svg");
  CAPTURE(low, high, script);
  CHECK(tick_count(script, "y") >= 2);
  CHECK(tick_count(script, "y") <= 12);
}
