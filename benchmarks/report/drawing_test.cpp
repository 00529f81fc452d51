#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <sstream>
#include <vector>

#include "benchmarks/report/chart.hpp"
#include "benchmarks/report/chart_axis.hpp"
#include "benchmarks/report/curve_reduction.hpp"
#include "benchmarks/report/picture.hpp"
#include "benchmarks/report/raster.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

const std::string head = R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 50" width="100" height="50">)";

std::string drawing(const std::string& inner) { return head + inner + "</svg>"; }

unsigned number_at(const std::string& bytes, std::size_t at) {
  unsigned value = 0;
  for (std::size_t k = 0; k < 4; ++k) value = (value << 8U) | static_cast<unsigned char>(bytes[at + k]);
  return value;
}

}  // namespace

TEST_CASE("a reduced curve keeps each column's first, lowest, highest and last point, in order",
          "[report][reduction]") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> anywhere(0.0, 300.0);
  std::vector<PlotPoint> points;
  // There and back again, as a needle goes.
  for (int i = 0; i < 40000; ++i) points.push_back({480.0 * (1.0 - std::abs(i / 20000.0 - 1.0)), anywhere(random)});
  points[12345].y = -50.0, points[30001].y = 400.0;
  const std::vector<PlotPoint> reduced = reduced_curve(points, 560.0, 4000);
  CHECK(reduced.size() < 2 * 4 * 482);
  CHECK(reduced.size() > 2 * 3 * 470);
  // A subsequence: no point is made up, none moved to another place in the order.
  std::size_t at = 0;
  for (const PlotPoint& p : reduced) {
    while (at < points.size() && !(points[at].x == p.x && points[at].y == p.y)) ++at;
    REQUIRE(at < points.size());
  }
  const auto by_height = [](const PlotPoint& a, const PlotPoint& b) { return a.y < b.y; };
  CHECK(std::ranges::min_element(reduced, by_height)->y == -50.0);
  CHECK(std::ranges::max_element(reduced, by_height)->y == 400.0);
  // Every column's extremes on the way there.
  for (int column = 0; column < 480; column += 37) {
    const auto extremes = [&](const std::vector<PlotPoint>& of) {
      double low = 1e9, high = -1e9;
      for (const PlotPoint& p : of)
        if (std::floor(p.x) == column) low = std::min(low, p.y), high = std::max(high, p.y);
      return std::pair(low, high);
    };
    CHECK(extremes(points) == extremes(reduced));
  }
  CHECK(reduced_curve(points, 560.0, 500).size() <= 500);
  CHECK(reduced_curve({}, 560.0, 500).empty());
}

TEST_CASE("ticks are round, within the axis, and told apart", "[report]") {
  const auto [low, high, logarithmic] = GENERATE(table<double, double, bool>({{0.0, 1.0, false},
                                                                              {-3.2e-7, 5e-7, false},
                                                                              {99.9, 100.1, false},
                                                                              {0.8, 7e5, true},
                                                                              {3.1, 4.4, true},
                                                                              {1e-12, 1e9, true}}));
  CAPTURE(low, high, logarithmic);
  ChartAxis axis{.logarithmic = logarithmic};
  axis.include(low), axis.include(high), axis.include(std::nan(""));
  axis.widen(0.02);
  const std::vector<double> ticks = axis.ticks(5);
  CHECK((ticks.size() >= 2 && ticks.size() <= 9));
  for (const double tick : ticks) CHECK((tick >= axis.low && tick <= axis.high));
  std::vector<std::string> labels = tick_labels(ticks);
  std::ranges::sort(labels);
  CHECK(std::ranges::adjacent_find(labels) == labels.end());
}

TEST_CASE("a chart leaves out what its axes cannot show and has no number that is none", "[report]") {
  const double none = std::nan("");
  Chart chart{.title = "t", .x_label = "x", .y_label = "y", .log_x = true, .log_y = true};
  CHECK_FALSE(drawable(chart));
  chart.series = {{.label = "a", .x = {0.0, 1.0, none}, .y = {1.0, -1.0, 3.0}, .points = true}};
  CHECK_FALSE(drawable(chart));
  chart.series.push_back(
      {.label = "b < c", .x = {1.0, 10.0, 100.0, 1000.0}, .y = {1.0, 2.0, none, 3.0}, .points = true});
  REQUIRE(drawable(chart));
  const std::string html = chart_html(chart);
  CHECK(html.find("nan") == std::string::npos);
  CHECK(html.find("b &lt; c: 1,000, 3") != std::string::npos);
  // The gap parts the curve.
  const std::size_t first = html.find("<polyline");
  REQUIRE(first != std::string::npos);
  CHECK(html.find("<polyline", first + 1) != std::string::npos);
}

TEST_CASE("a curve in steps keeps a point's height up to the next one", "[report]") {
  Chart chart{.title = "t", .x_label = "x", .y_label = "y"};
  chart.series = {{.label = "front", .x = {1.0, 2.0, 4.0}, .y = {3.0, 2.0, 1.0}, .steps = true}};
  const auto corners = [&] {
    const std::string html = chart_html(chart);
    const std::size_t start = html.find("points=\"", html.find("<polyline")) + 8;
    std::istringstream text(html.substr(start, html.find('"', start) - start));
    std::vector<std::array<double, 2>> found;
    char comma = 0;
    for (std::array<double, 2> p{}; text >> p[0] >> comma >> p[1];) found.push_back(p);
    return found;
  };
  const auto steps = corners();
  REQUIRE(steps.size() == 5);
  for (const std::size_t corner : {1, 3}) {
    CHECK(steps[corner][0] == steps[corner + 1][0]);
    CHECK(steps[corner][1] == steps[corner - 1][1]);
  }
  chart.series[0].steps = false;
  CHECK(corners().size() == 3);
}

TEST_CASE("a histogram counts every frame once", "[report]") {
  std::vector<double> times;
  for (int i = 0; i < 1000; ++i) times.push_back(1.0 + 0.001 * i);
  times.push_back(500.0), times.push_back(std::nan(""));
  const ChartBars bars = histogram("frames", times);
  REQUIRE(bars.edges.size() == bars.counts.size() + 1);
  double sum = 0.0;
  for (const double n : bars.counts) sum += n;
  CHECK(sum == 1001.0);
  CHECK(bars.counts.back() == 1.0);
  CHECK((bars.edges.front() <= 1.0 && bars.edges.back() >= 500.0));
  CHECK(histogram("none", {std::nan("")}).counts.empty());
}

TEST_CASE("identifiers of a picture and what refers to them get its prefix", "[report][picture]") {
  const std::string svg = drawing(R"svg(<defs><pattern id="p"/><path id='q' d="M0 0"/></defs><use xlink:href="#q"/>)svg"
                                  R"svg(<rect fill="url(#p)" style="mask: url('#p')" width="3" height="3"/>)svg");
  const InlinePicture picture = inline_picture(svg, "one-");
  REQUIRE(picture.why_not.empty());
  for (const char* part : {"id=\"one-p\"", "id=\"one-q\"", "href=\"#one-q\"", "url(#one-p)", "url('#one-p')"})
    CHECK_THAT(picture.svg, ContainsSubstring(part));
  CHECK(picture.svg.find("\"#q\"") == std::string::npos);
  CHECK(picture.svg.find("xlink") == std::string::npos);
  CHECK((picture.width == 100 && picture.height == 50));
  const std::string twice = inline_picture(drawing("<g id=\"a\"/><g id=\"a\"/>"), "p-").svg;
  CHECK(twice.find("id=\"p-a\"") != std::string::npos);
  CHECK(twice.find("id=\"p-a\"") == twice.rfind("id=\"p-a\""));
}

TEST_CASE("a picture that acts, fetches or is broken is left out with the reason", "[report][picture]") {
  const auto why = [](const std::string& svg) { return inline_picture(svg, "p-").why_not; };
  CHECK(why(drawing("<rect width='1' height='1'/>")).empty());
  CHECK_THAT(why(drawing("<script>alert(1)</script>")), ContainsSubstring("<script>"));
  CHECK_THAT(why(drawing("<rect onclick='x()'/>")), ContainsSubstring("runs code"));
  CHECK_THAT(why(drawing("<use href='http://a/b.svg#c'/>")), ContainsSubstring("http://a/b.svg"));
  CHECK_THAT(why(drawing("<rect fill='url( http://a/b )'/>")), ContainsSubstring("http://a/b"));
  CHECK_THAT(why(drawing("<style>@import 'x'</style>")), ContainsSubstring("<style>"));
  CHECK_THAT(why(drawing("<g>")), ContainsSubstring("closes nothing"));
  CHECK_THAT(why(head + "<g>"), ContainsSubstring("not closed"));
  CHECK_THAT(why("<!DOCTYPE svg [<!ENTITY a 'b'>]>" + drawing("")),
             ContainsSubstring("entities") || ContainsSubstring("document type"));
  CHECK_THAT(why("<html></html>"), ContainsSubstring("no drawing"));
  CHECK_THAT(why("<svg></svg>"), ContainsSubstring("no size"));
  CHECK_THAT(inline_picture(drawing("<text>" + std::string(5000, 'x') + "</text>"), "p-", 4000).why_not,
             ContainsSubstring("bytes"));
}

TEST_CASE("thousands of patches become one picture in their place, and texts stay", "[report][picture]") {
  std::string group = R"(<g stroke="#000000" stroke-opacity="1" stroke-width="1">)";
  for (int i = 0; i < 3000; ++i) group += "<path stroke=\"none\" fill=\"#ff0000\" d=\"M10 10L40 10L40 30L10 30Z\"/>\n";
  const std::string svg = drawing(group + "</g><text x=\"1\" y=\"9\">words</text>");
  const InlinePicture picture = inline_picture(svg, "p-", 2000000, 1.0);
  REQUIRE(picture.why_not.empty());
  CHECK(picture.svg.size() < 2000);
  CHECK_THAT(picture.svg,
             ContainsSubstring("<image x=\"8\" y=\"8\" width=\"34\" height=\"24\" href=\"data:image/png;base64,") &&
                 ContainsSubstring(">words<"));
  // A curve among them cannot be drawn so: the drawing stays what it was.
  const InlinePicture curved =
      inline_picture(drawing(group + "<path fill=\"#ff0000\" d=\"M0 0C1 1 2 2 3 3\"/></g>"), "p-");
  CHECK(curved.svg.find("<image") == std::string::npos);
  CHECK(curved.svg.size() > 100000);
}

TEST_CASE("a picture's file unpacks to the pixels that were drawn", "[report][picture]") {
  Raster raster(7, 5);
  fill_polygon(raster, {{{1, 1}}, {{4, 1}}, {{4, 3}}, {{1, 3}}}, {200, 10, 30});
  const std::string png = png_file(raster);
  REQUIRE(png.substr(1, 3) == "PNG");
  CHECK((number_at(png, 16) == 7 && number_at(png, 20) == 5));
  const std::size_t palette = png.find("PLTE") + 4, data = png.find("IDAT") + 4;
  std::string rows(5 * 8, '\0');
  uLongf size = rows.size();
  REQUIRE(uncompress(reinterpret_cast<Bytef*>(rows.data()), &size, reinterpret_cast<const Bytef*>(png.data() + data),
                     number_at(png, data - 8)) == Z_OK);
  REQUIRE(size == rows.size());
  int red = 0;
  for (std::size_t y = 0; y < 5; ++y)
    for (std::size_t x = 0; x < 7; ++x) {
      const auto color = static_cast<std::size_t>(static_cast<unsigned char>(rows[8 * y + 1 + x]));
      const bool is_red = static_cast<unsigned char>(png[palette + 3 * color]) == 200;
      CHECK(is_red == (x >= 1 && x < 4 && y >= 1 && y < 3));
      red += is_red;
    }
  CHECK(red == 6);
  // Neighbours with a common edge share no pixel and leave none out.
  Raster two(20, 20);
  fill_polygon(two, {{{0, 0}}, {{20, 0}}, {{0, 20}}}, {1, 1, 1});
  const auto dark = std::ranges::count(two.rgb, 1);
  fill_polygon(two, {{{20, 0}}, {{20, 20}}, {{0, 20}}}, {2, 2, 2});
  CHECK(std::ranges::count(two.rgb, 1) == dark);
  CHECK(std::ranges::count(two.rgb, 255) == 0);
  CHECK(base64("Man") == "TWFu");
  CHECK(base64("Ma") == "TWE=");
  CHECK(base64("M") == "TQ==");
}
