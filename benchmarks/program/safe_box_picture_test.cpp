#include "benchmarks/program/safe_box_picture.hpp"

#include "verification/support/catch.hpp"
#include "verification/support/occurrences.hpp"

using namespace finegauge;

namespace {

AtlasAxis axis() {
  AtlasAxis axis;
  axis.group = "group";
  axis.name = "a_name";
  axis.unit = "<m>";
  axis.normal = 1.0;
  return axis;
}

AtlasPoint point(double value, bool ok, bool refused = false) {
  AtlasPoint point{.value = value, .ok = ok};
  point.refused = refused;
  return point;
}

}  // namespace

TEST_CASE("the safe box shows each limit, and each failure with a cross", "[atlas][picture]") {
  const AtlasAxis a = axis();
  const AtlasSweep found = judge(a, {point(0.0, true), point(1e-9, false), point(1e-3, true), point(1.0, true),
                                     point(1e4, true, true), point(1e6, false)});
  const std::string svg = safe_box_svg({{&a, found}}, "note"), empty = safe_box_svg({}, "note");
  CHECK(occurrences(svg, "class=\"failing\"") ==
        occurrences(empty, "class=\"failing\"") + 2);  // beside that of the legend
  CHECK(occurrences(svg, ">0.001 to 1<") == 1);
  CHECK(occurrences(svg, ">a name [&lt;m&gt;]<") == 1);
  CHECK(occurrences(svg, ">group<") == 1);
  CHECK(occurrences(svg, ">1e6<") == 1);
  CHECK(occurrences(svg, "nan") == 0);
  CHECK(occurrences(svg, "inf") == 0);
}

TEST_CASE("an axis of one value, of zero alone or of none is drawn as well", "[atlas][picture]") {
  const AtlasAxis a = axis();
  for (const std::vector<AtlasPoint>& points : {std::vector{point(1.0, true)}, std::vector{point(0.0, true)},
                                                std::vector{point(1.0, false)}, std::vector<AtlasPoint>{}}) {
    const std::string svg = safe_box_svg({{&a, judge(a, points)}}, "");
    CHECK(occurrences(svg, "nan") == 0);
    CHECK(occurrences(svg, "inf") == 0);
    CHECK(occurrences(svg, "a name") == 1);
  }
}

TEST_CASE("numbers of the atlas are short", "[atlas][picture]") {
  CHECK(brief_number(1e-9) == "1e-9");
  CHECK(brief_number(1e4) == "1e4");
  CHECK(brief_number(1e-300) == "1e-300");
  CHECK(brief_number(0.05) == "0.05");
  CHECK(brief_number(0.0) == "0");
}
