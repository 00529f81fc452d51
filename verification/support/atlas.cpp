#include "verification/support/atlas.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "core/scene/scene_error.hpp"
#include "verification/support/run_apart.hpp"

namespace finegauge {
namespace {

std::string short_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// A message on one line.
std::string one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

std::string end_of(const AtlasPoint& point) { return point.refused ? "refused" : point.ok ? "answered" : "FAILS"; }

/// The values of the contiguous points around `normal` for which `holds`; `points` ascending.
template <class Holds>
std::optional<AtlasRange> range_around(double normal, const std::vector<AtlasPoint>& points, Holds holds) {
  std::size_t after = 0;  // first point above the normal value
  while (after < points.size() && points[after].value <= normal) ++after;
  std::optional<AtlasRange> range;
  const auto include = [&](double value) {
    if (!range) range = AtlasRange{value, value};
    range->low = std::min(range->low, value);
    range->high = std::max(range->high, value);
  };
  for (std::size_t i = after; i-- > 0 && holds(points[i]);) include(points[i].value);
  const bool normal_fails = after > 0 && points[after - 1].value == normal && !holds(points[after - 1]);
  if (normal_fails) return {};
  for (std::size_t i = after; i < points.size() && holds(points[i]); ++i) include(points[i].value);
  return range;
}

// A point on its way from the process that tries it: numbers and texts with their lengths, in the machine's own format.

void put(double number, std::string& bytes) { bytes.append(reinterpret_cast<const char*>(&number), sizeof number); }
void put(const std::string& text, std::string& bytes) {
  put(static_cast<double>(text.size()), bytes);
  bytes += text;
}
std::string packed(const AtlasPoint& point) {
  std::string bytes;
  for (const double number : {point.value, point.ok ? 1.0 : 0.0, point.refused ? 1.0 : 0.0, point.measure})
    put(number, bytes);
  put(point.why, bytes);
  put(point.scene, bytes);
  put(static_cast<double>(point.files.size()), bytes);
  for (const AtlasFile& file : point.files) put(file.name, bytes), put(file.content, bytes);
  return bytes;
}

/// Takes them out again.
struct Unpacking {
  std::string_view bytes;

  double number() {
    double value = 0.0;
    std::memcpy(&value, bytes.substr(0, sizeof value).data(), sizeof value);
    bytes.remove_prefix(sizeof value);
    return value;
  }
  std::string text() {
    const auto length = static_cast<std::size_t>(number());
    const std::string value(bytes.substr(0, length));
    bytes.remove_prefix(length);
    return value;
  }
  AtlasPoint point() {
    AtlasPoint point;
    point.value = number();
    point.ok = number() != 0.0;
    point.refused = number() != 0.0;
    point.measure = number();
    point.why = text();
    point.scene = text();
    const double files = number();
    for (int i = 0; i < files; ++i) {
      AtlasFile& file = point.files.emplace_back();
      file.name = text();
      file.content = text();
    }
    return point;
  }
};

const Say* announce_by = nullptr;  ///< in a process that tries a value: how its points go to the one that waits

}  // namespace

void announce_scene(const std::string& scene, std::span<const AtlasFile> files) {
  if (!announce_by) return;
  AtlasPoint point;
  point.scene = scene;
  point.files.assign(files.begin(), files.end());
  (*announce_by)(packed(point));
}

std::optional<AtlasPoint> try_value_apart(const AtlasAxis& axis, double value, double seconds,
                                          const std::function<bool()>& interrupted) {
  AtlasPoint announced;  // what the point said before it ended as it should not
  ApartOptions options;
  options.seconds = seconds;
  options.interrupted = interrupted;
  options.heard = [&](const std::string& bytes) { announced = Unpacking{bytes}.point(); };
  const ApartResult result = run_apart(
      [&](const Say& say) {
        announce_by = &say;
        return packed(try_value(axis, value));
      },
      options);
  if (result.end == ApartResult::End::stopped) return {};
  if (result.end == ApartResult::End::done) return Unpacking{result.bytes}.point();
  announced.value = value;
  announced.ok = announced.refused = false;
  announced.measure = std::numeric_limits<double>::quiet_NaN();
  announced.why = result.why;
  return announced;
}

std::vector<double> atlas_values(const AtlasAxis& axis, bool full) {
  std::vector<double> values = axis.values;
  if (full) values.insert(values.end(), axis.more_values.begin(), axis.more_values.end());
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

AtlasPoint point_or_refusal(double value, const std::function<AtlasPoint()>& judged) {
  AtlasPoint point;
  try {
    point = judged();
  } catch (const SceneError& error) {
    point = refusal(value, error.what());
  } catch (const std::invalid_argument& error) {
    point = refusal(value, error.what());
  } catch (const std::exception& error) {
    point.measure = std::numeric_limits<double>::quiet_NaN();
    point.why = std::string("an exception that names no input: ") + error.what();
  }
  return point;
}

AtlasPoint try_value(const AtlasAxis& axis, double value) {
  AtlasPoint point = point_or_refusal(value, [&] { return axis.at(value); });
  point.value = value;
  point.why = one_line(point.why);
  if (point.answered() && !std::isfinite(point.measure)) {
    point.ok = false;
    point.why += " (an answer without a number)";
  }
  return point;
}

AtlasSweep judge(const AtlasAxis& axis, std::vector<AtlasPoint> points) {
  AtlasSweep found;
  std::ranges::stable_sort(points, {}, &AtlasPoint::value);
  found.points = std::move(points);
  found.safe = range_around(axis.normal, found.points, [](const AtlasPoint& point) { return point.ok; });
  found.answered = range_around(axis.normal, found.points, [](const AtlasPoint& point) { return point.answered(); });
  const AtlasPoint *below = nullptr, *above = nullptr;
  for (const AtlasPoint& point : found.points) {
    if (point.ok) continue;
    if (point.value <= axis.normal)
      below = &point;
    else if (!above)
      above = &point;
  }
  for (const AtlasPoint* point : {below, above})
    if (point) found.first_failing.push_back(*point);
  return found;
}

AtlasSweep sweep(const AtlasAxis& axis, const AtlasOptions& options) {
  std::vector<AtlasPoint> points;
  const std::vector<double> values = atlas_values(axis, options.full);
  for (const double value : values) {
    if (options.interrupted()) break;
    options.progress(static_cast<double>(points.size()) / static_cast<double>(values.size()),
                     axis.name + " = " + short_text(value));
    std::optional<AtlasPoint> point = try_value_apart(axis, value, options.seconds, options.interrupted);
    if (!point) break;
    points.push_back(std::move(*point));
  }
  return judge(axis, std::move(points));
}

bool covers(const std::optional<AtlasRange>& found, const AtlasRange& asked) {
  return found && found->low <= asked.low && found->high >= asked.high;
}

EvidenceTable atlas_table(const AtlasAxis& axis, const AtlasSweep& found) {
  EvidenceTable table;
  table.title = axis.name + (axis.unit.empty() ? "" : " [" + axis.unit + "]") + ": " + axis.about;
  table.columns = {"value", "end", "measure", "why"};
  for (const AtlasPoint& point : found.points)
    table.rows.push_back({short_text(point.value), end_of(point), short_text(point.measure), point.why});
  return table;
}

void AtlasChecks::add(const std::string& what, double value, double bound) { checks_.push_back({what, value, bound}); }

bool AtlasChecks::hold() const {
  return !checks_.empty() && std::ranges::all_of(checks_, [](const Check& c) { return c.value <= c.bound; });
}

AtlasPoint AtlasChecks::point(double value) const {
  if (checks_.empty()) throw std::logic_error("a point of the atlas without a check");
  // A NaN is the worst of all.
  const auto share = [](const Check& c) {
    const double part = c.bound > 0.0 ? c.value / c.bound : c.value > c.bound ? INFINITY : 0.0;
    return std::isnan(part) ? INFINITY : part;
  };
  const Check& worst = *std::ranges::max_element(checks_, {}, share);
  AtlasPoint point{.value = value, .ok = hold(), .measure = worst.value};
  point.why = worst.what + " " + short_text(worst.value) + (point.ok ? ", at most " : ", allowed at most ") +
              short_text(worst.bound);
  return point;
}

void keep_largest(double& worst, double value) {
  if (std::isnan(worst) || value <= worst) return;
  worst = value;
}

double largest_entry(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  double largest = 0.0;
  for (const double entry : matrix.reshaped()) keep_largest(largest, std::abs(entry));
  return largest;
}

AtlasPoint refusal(double value, const std::string& why) {
  AtlasPoint point{.value = value, .ok = true, .measure = std::numeric_limits<double>::quiet_NaN()};
  point.why = "refused: " + why;
  point.refused = true;
  return point;
}

}  // namespace finegauge
