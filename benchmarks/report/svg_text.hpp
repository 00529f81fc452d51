#pragma once

#include <string>
#include <utility>
#include <vector>

namespace finegauge {

/// A part of an SVG file between two tags, or a tag. Attribute values and texts stay as they are written, entities and
/// all.
struct SvgPart {
  enum class Kind { begin, end, whole, text } kind;  ///< whole: <name/>
  std::string name;                                  ///< of a tag
  std::string text;                                  ///< between tags
  std::vector<std::pair<std::string, std::string>> attributes = {};

  const std::string* attribute(const std::string& key) const;
};

/// The tags of an SVG file in their order; its prolog, comments and processing instructions are left out.
/// Throws std::runtime_error that tells what is wrong where tags do not match or are not written as XML.
std::vector<SvgPart> parse_svg(const std::string& text);
std::string svg_text(const std::vector<SvgPart>& parts);

}  // namespace finegauge
