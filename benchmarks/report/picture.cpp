#include "benchmarks/report/picture.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "benchmarks/report/html.hpp"
#include "benchmarks/report/raster.hpp"
#include "benchmarks/report/svg_text.hpp"

namespace finegauge {
namespace {

using Point = std::array<double, 2>;

constexpr std::size_t many_paths = 2000;  // more is not for a browser to draw one by one

const std::set<std::string> known_elements = {
    "svg",      "g",     "path",  "rect",           "circle",         "ellipse", "line",    "polyline",   "polygon",
    "text",     "tspan", "title", "desc",           "defs",           "use",     "symbol",  "marker",     "pattern",
    "clipPath", "mask",  "stop",  "linearGradient", "radialGradient", "filter",  "feFlood", "feComposite"};

/// Throws where the drawing could do more than be looked at.
void require_harmless(const std::vector<SvgPart>& parts) {
  for (const SvgPart& part : parts) {
    if (part.kind == SvgPart::Kind::text) continue;
    if (!known_elements.contains(part.name)) throw std::runtime_error("<" + part.name + "> is not for this page");
    for (const auto& [key, value] : part.attributes) {
      if (key.starts_with("on")) throw std::runtime_error("it runs code on " + key.substr(2));
      if (key.ends_with("href") && !value.starts_with('#')) throw std::runtime_error("it refers to " + value);
      for (std::size_t at = value.find("url("); at != std::string::npos; at = value.find("url(", at + 1)) {
        const std::size_t target = value.find_first_not_of("'\" ", at + 4);
        if (target == std::string::npos || value[target] != '#') throw std::runtime_error("it refers to " + value);
      }
    }
  }
}

/// Of identifiers that a drawing has twice, as gnuplot's do, the first stays, which is the one that references find.
void add_prefix(std::vector<SvgPart>& parts, const std::string& prefix) {
  std::set<std::string> taken;
  for (SvgPart& part : parts) {
    std::erase_if(part.attributes, [&](const auto& a) { return a.first == "id" && !taken.insert(a.second).second; });
    for (auto& [key, value] : part.attributes) {
      if (key == "id")
        value = prefix + value;
      else if (key.ends_with("href") && value.starts_with('#'))
        value = "#" + prefix + value.substr(1);
      else
        for (std::size_t at = value.find("url("); at != std::string::npos; at = value.find("url(", at + 1))
          value.insert(value.find('#', at) + 1, prefix);
    }
  }
}

double number_of(const std::string* text, double otherwise) {
  double value = otherwise;
  if (text) std::from_chars(text->data(), text->data() + text->size(), value);
  return value;
}

std::optional<std::array<int, 3>> color_of(const std::string& text) {
  std::array<int, 3> color{};
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  for (std::size_t c = 0; c < 3; ++c) {
    const char* begin = text.data() + 1 + 2 * c;
    if (std::from_chars(begin, begin + 2, color[c], 16).ptr != begin + 2) return std::nullopt;
  }
  return color;
}

/// A path of straight lines with absolute coordinates.
struct StraightPath {
  std::vector<Point> corners;
  bool closed = false;
};
std::optional<StraightPath> straight_path(const std::string& d) {
  StraightPath path;
  const char *at = d.data(), *const end = at + d.size();
  while (at < end) {
    const char command = *at++;
    if (command == 'Z' && at == end) {
      path.closed = true;
      return path;
    }
    if (command != (path.corners.empty() ? 'M' : 'L')) return std::nullopt;
    Point point{};
    for (double& coordinate : point) {
      while (at < end && (*at == ' ' || *at == ',')) ++at;
      const auto [next, error] = std::from_chars(at, end, coordinate);
      if (error != std::errc()) return std::nullopt;
      at = next;
    }
    path.corners.push_back(point);
  }
  return path;
}

struct Stroke {
  std::string color = "none";
  double width = 1.0, opacity = 1.0;
};

struct RasterPath {
  StraightPath path;
  std::optional<std::array<int, 3>> fill, stroke;
  Stroke pen;
};

/// The paths of a group, parts[begin + 1 .. end); nothing where one of them is not of the sort that can be rasterized.
std::optional<std::vector<RasterPath>> raster_paths(const std::vector<SvgPart>& parts, std::size_t begin,
                                                    std::size_t end) {
  Stroke pen;
  if (const std::string* color = parts[begin].attribute("stroke")) pen.color = *color;
  pen.width = number_of(parts[begin].attribute("stroke-width"), 1.0);
  pen.opacity = number_of(parts[begin].attribute("stroke-opacity"), 1.0);
  for (const char* moved : {"transform", "opacity", "filter", "clip-path"})
    if (parts[begin].attribute(moved)) return std::nullopt;
  std::vector<RasterPath> paths;
  for (std::size_t i = begin + 1; i < end; ++i) {
    const SvgPart& part = parts[i];
    if (part.kind == SvgPart::Kind::text) continue;
    const std::string* d = part.attribute("d");
    if (part.kind != SvgPart::Kind::whole || part.name != "path" || !d) return std::nullopt;
    auto path = straight_path(*d);
    if (!path) return std::nullopt;
    const std::string *fill = part.attribute("fill"), *stroke = part.attribute("stroke");
    RasterPath shown{std::move(*path), {}, {}, pen};
    if (fill && *fill != "none" && !(shown.fill = color_of(*fill))) return std::nullopt;
    const std::string& color = stroke ? *stroke : pen.color;
    if (color != "none" && !(shown.stroke = color_of(color))) return std::nullopt;
    paths.push_back(std::move(shown));
  }
  return paths;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// An <image> in the place of the group.
SvgPart raster_image(const std::vector<RasterPath>& paths, double pixels) {
  double left = 1e300, right = -1e300, top = 1e300, bottom = -1e300;
  for (const RasterPath& shown : paths)
    for (const Point& p : shown.path.corners) {
      left = std::min(left, p[0]), right = std::max(right, p[0]);
      top = std::min(top, p[1]), bottom = std::max(bottom, p[1]);
    }
  left = std::floor(left - 2.0), top = std::floor(top - 2.0);
  const int columns = static_cast<int>(std::ceil((right + 2.0 - left) * pixels));
  const int rows = static_cast<int>(std::ceil((bottom + 2.0 - top) * pixels));
  if (!(columns > 0 && rows > 0 && columns < 5000 && rows < 5000))
    throw std::runtime_error("its size is out of bounds");
  Raster raster(columns, rows);
  std::vector<Point> corners;
  for (const RasterPath& shown : paths) {
    corners.clear();
    for (const Point& p : shown.path.corners) corners.push_back({(p[0] - left) * pixels, (p[1] - top) * pixels});
    if (shown.fill) fill_polygon(raster, corners, *shown.fill);
    if (!shown.stroke) continue;
    for (std::size_t i = 0; i + 1 < corners.size() + (shown.path.closed ? 1U : 0U); ++i)
      draw_line(raster, corners[i], corners[(i + 1) % corners.size()], shown.pen.width * pixels, *shown.stroke,
                shown.pen.opacity);
  }
  return {SvgPart::Kind::whole,
          "image",
          {},
          {{"x", number(left)},
           {"y", number(top)},
           {"width", number(columns / pixels)},
           {"height", number(rows / pixels)},
           {"href", "data:image/png;base64," + base64(png_file(raster))}}};
}

/// Groups of very many paths become pictures.
void rasterize_large_groups(std::vector<SvgPart>& parts, double pixels) {
  std::vector<SvgPart> out;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].kind == SvgPart::Kind::begin && parts[i].name == "g") {
      std::size_t end = i + 1;
      while (end < parts.size() && (parts[end].kind == SvgPart::Kind::whole || parts[end].kind == SvgPart::Kind::text))
        ++end;
      if (end < parts.size() && parts[end].kind == SvgPart::Kind::end && end - i > many_paths)
        if (const auto paths = raster_paths(parts, i, end); paths && paths->size() > many_paths) {
          out.push_back(raster_image(*paths, pixels));
          i = end;
          continue;
        }
    }
    out.push_back(std::move(parts[i]));
  }
  parts = std::move(out);
}

/// The root without a size of its own, with a box that tells its shape.
void fit_root(SvgPart& root, InlinePicture& picture) {
  const double width = number_of(root.attribute("width"), 0.0), height = number_of(root.attribute("height"), 0.0);
  Point size = {width, height};
  if (const std::string* box = root.attribute("viewBox")) {
    double x = 0.0, y = 0.0;
    if (std::sscanf(box->c_str(), "%lf%*[ ,]%lf%*[ ,]%lf%*[ ,]%lf", &x, &y, &size[0], &size[1]) != 4) size = {0.0, 0.0};
  } else {
    root.attributes.emplace_back("viewBox", "0 0 " + number(width) + " " + number(height));
  }
  if (!(size[0] > 0.0 && size[1] > 0.0 && size[0] < 1e5 && size[1] < 1e5)) throw std::runtime_error("it has no size");
  picture.width = static_cast<int>(std::lround(size[0])), picture.height = static_cast<int>(std::lround(size[1]));
  std::erase_if(root.attributes, [](const auto& a) {
    return a.first == "width" || a.first == "height" || a.first == "class" || a.first.starts_with("xmlns");
  });
  root.attributes.emplace_back("class", "picture");
  root.attributes.emplace_back("role", "img");
}

}  // namespace

InlinePicture inline_picture(const std::string& file_content, const std::string& prefix, std::size_t most_bytes,
                             double pixels) {
  InlinePicture picture;
  try {
    std::vector<SvgPart> parts = parse_svg(file_content);
    require_harmless(parts);
    add_prefix(parts, prefix);
    fit_root(parts.front(), picture);
    rasterize_large_groups(parts, pixels);
    // In HTML the old name of the attribute needs no declaration; the new one is understood in both.
    for (SvgPart& part : parts)
      for (auto& [key, value] : part.attributes)
        if (key == "xlink:href") key = "href";
    picture.svg = svg_text(parts);
  } catch (const std::runtime_error& error) {
    return {{}, error.what()};
  }
  if (picture.svg.size() > most_bytes)
    return {{},
            "it has " + count_text(static_cast<double>(picture.svg.size())) + " bytes, at most " +
                count_text(static_cast<double>(most_bytes)) + " have room"};
  return picture;
}

}  // namespace finegauge
