#pragma once

#include <string>

namespace finegauge {

/// An SVG file made fit for a page that holds many: or why not.
struct InlinePicture {
  std::string svg;      ///< empty where it was left out
  std::string why_not;  ///< then
  int width = 0, height = 0;
};

/// Identifiers and the references to them get the prefix; the root takes the width that the page gives it. Drawings
/// that run code or fetch something are left out, for they would act when the page is read. A group of thousands of
/// patches and lines (the surface of a mesh) becomes one PNG picture of `pixels` per unit, texts and colour bar stay
/// drawings. What is then still larger than `most_bytes` is left out.
InlinePicture inline_picture(const std::string& file_content, const std::string& prefix,
                             std::size_t most_bytes = 2000000, double pixels = 1.25);

}  // namespace finegauge
