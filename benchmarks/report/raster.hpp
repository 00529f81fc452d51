#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace finegauge {

/// Red, green and blue of each pixel, row by row, from white.
struct Raster {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;

  Raster(int width_px, int height_px);
};

/// A polygon by the pixels whose centres are in it (even-odd), so that neighbours with a common edge neither leave a
/// gap nor blend. Corners in pixels.
void fill_polygon(Raster& raster, const std::vector<std::array<double, 2>>& corners, std::array<int, 3> color);
/// A line with round ends; thinner than a pixel it is as much lighter.
void draw_line(Raster& raster, const std::array<double, 2>& from, const std::array<double, 2>& to, double line_width,
               std::array<int, 3> color, double opacity);

/// The raster as a PNG file with a palette (ISO/IEC 15948; compression by zlib).
std::string png_file(const Raster& raster);
std::string base64(const std::string& bytes);

}  // namespace finegauge
