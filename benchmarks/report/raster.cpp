#include "benchmarks/report/raster.hpp"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace finegauge {
namespace {

using Point = std::array<double, 2>;

std::uint8_t* pixel(Raster& raster, int x, int y) {
  return &raster.rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(raster.width) +
                          static_cast<std::size_t>(x))];
}

void append_number(std::string& out, std::uint32_t value) {
  for (const int shift : {24, 16, 8, 0}) out += static_cast<char>((value >> shift) & 0xFFU);
}

void append_chunk(std::string& png, const std::string& type, const std::string& data) {
  append_number(png, static_cast<std::uint32_t>(data.size()));
  const std::string content = type + data;
  png += content;
  append_number(png, static_cast<std::uint32_t>(
                         crc32(0, reinterpret_cast<const Bytef*>(content.data()), static_cast<uInt>(content.size()))));
}

/// Colours and the number of each pixel's, 256 at most: channels are rounded to steps as wide as that takes. A mesh's
/// picture has a colour map and its mixtures with the dark of the lines, which such a palette holds well at a third of
/// the bytes.
struct Palette {
  std::vector<std::uint32_t> colors;
  std::string numbers;  ///< a byte per pixel
};
Palette palette_of(const Raster& raster) {
  for (int step = 1;; ++step) {
    Palette palette;
    std::map<std::uint32_t, std::uint32_t> known;
    for (std::size_t i = 0; i < raster.rgb.size() && known.size() <= 256; i += 3) {
      std::uint32_t color = 0;
      for (std::size_t c = 0; c < 3; ++c)
        color = (color << 8U) | static_cast<std::uint32_t>(std::min(255, (raster.rgb[i + c] + step / 2) / step * step));
      const auto [found, fresh] = known.emplace(color, static_cast<std::uint32_t>(palette.colors.size()));
      if (fresh) palette.colors.push_back(color);
      palette.numbers += static_cast<char>(found->second);
    }
    if (known.size() <= 256) return palette;
  }
}

}  // namespace

Raster::Raster(int width_px, int height_px)
    : width(width_px),
      height(height_px),
      rgb(3 * static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px), 255) {}

void fill_polygon(Raster& raster, const std::vector<Point>& corners, std::array<int, 3> color) {
  if (corners.size() < 3) return;
  double low = corners[0][1], high = low;
  for (const Point& corner : corners) low = std::min(low, corner[1]), high = std::max(high, corner[1]);
  const int first = std::max(0, static_cast<int>(std::ceil(low - 0.5)));
  const int last = std::min(raster.height - 1, static_cast<int>(std::ceil(high - 0.5)) - 1);
  std::vector<double> crossings;
  for (int y = first; y <= last; ++y) {
    crossings.clear();
    const double at = y + 0.5;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
      if ((a[1] <= at) != (b[1] <= at)) crossings.push_back(a[0] + (b[0] - a[0]) * (at - a[1]) / (b[1] - a[1]));
    }
    std::ranges::sort(crossings);
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
      const int from = std::max(0, static_cast<int>(std::ceil(crossings[i] - 0.5)));
      const int to = std::min(raster.width - 1, static_cast<int>(std::ceil(crossings[i + 1] - 0.5)) - 1);
      for (int x = from; x <= to; ++x)
        for (std::size_t c = 0; c < 3; ++c) pixel(raster, x, y)[c] = static_cast<std::uint8_t>(color[c]);
    }
  }
}

void draw_line(Raster& raster, const Point& from, const Point& to, double line_width, std::array<int, 3> color,
               double opacity) {
  const double half = 0.5 * std::max(1.0, line_width), strength = opacity * std::min(1.0, line_width),
               reach = half + 1.0;
  const double dx = to[0] - from[0], dy = to[1] - from[1], square = dx * dx + dy * dy;
  const int left = std::max(0, static_cast<int>(std::floor(std::min(from[0], to[0]) - reach)));
  const int right = std::min(raster.width - 1, static_cast<int>(std::ceil(std::max(from[0], to[0]) + reach)));
  const int top = std::max(0, static_cast<int>(std::floor(std::min(from[1], to[1]) - reach)));
  const int bottom = std::min(raster.height - 1, static_cast<int>(std::ceil(std::max(from[1], to[1]) + reach)));
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x) {
      const double px = x + 0.5 - from[0], py = y + 0.5 - from[1];
      const double t = square > 0.0 ? std::clamp((px * dx + py * dy) / square, 0.0, 1.0) : 0.0;
      const double alpha = strength * std::clamp(half + 0.5 - std::hypot(px - t * dx, py - t * dy), 0.0, 1.0);
      if (alpha <= 0.0) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        std::uint8_t& channel = pixel(raster, x, y)[c];
        channel = static_cast<std::uint8_t>(std::lround(channel + alpha * (color[c] - channel)));
      }
    }
}

std::string png_file(const Raster& raster) {
  const Palette palette = palette_of(raster);
  std::string rows;
  const auto width = static_cast<std::size_t>(raster.width);
  for (std::size_t y = 0; y < static_cast<std::size_t>(raster.height); ++y)
    rows += '\0' + palette.numbers.substr(y * width, width);  // no filter: numbers of colours have no differences
  uLongf packed_size = compressBound(static_cast<uLong>(rows.size()));
  std::string packed(packed_size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &packed_size, reinterpret_cast<const Bytef*>(rows.data()),
                static_cast<uLong>(rows.size()), 9) != Z_OK)
    throw std::runtime_error("zlib cannot pack a picture");
  packed.resize(packed_size);
  std::string header;
  append_number(header, static_cast<std::uint32_t>(raster.width));
  append_number(header, static_cast<std::uint32_t>(raster.height));
  header += {8, 3, 0, 0, 0};  // bits per pixel, by a palette; the only compression and filtering; rows in order
  std::string colors;
  for (const std::uint32_t color : palette.colors)
    for (const unsigned shift : {16U, 8U, 0U}) colors += static_cast<char>((color >> shift) & 255U);
  std::string png = "\x89PNG\r\n\x1a\n";
  append_chunk(png, "IHDR", header);
  append_chunk(png, "PLTE", colors);
  append_chunk(png, "IDAT", packed);
  append_chunk(png, "IEND", {});
  return png;
}

std::string base64(const std::string& bytes) {
  static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = (group << 8U) | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? digits[(group >> (18U - 6U * k)) & 63U] : '=';
  }
  return text;
}

}  // namespace finegauge
