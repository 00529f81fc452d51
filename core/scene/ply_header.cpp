#include "core/scene/ply_header.hpp"

#include <array>
#include <utility>

#include "core/scene/file_tokens.hpp"
#include "core/scene/text_file.hpp"

namespace finegauge {
namespace {

constexpr std::array<std::pair<std::string_view, ScalarType>, 16> type_names = {{{"char", ScalarType::int8},
                                                                                 {"uchar", ScalarType::uint8},
                                                                                 {"short", ScalarType::int16},
                                                                                 {"ushort", ScalarType::uint16},
                                                                                 {"int", ScalarType::int32},
                                                                                 {"uint", ScalarType::uint32},
                                                                                 {"float", ScalarType::float32},
                                                                                 {"double", ScalarType::float64},
                                                                                 {"int8", ScalarType::int8},
                                                                                 {"uint8", ScalarType::uint8},
                                                                                 {"int16", ScalarType::int16},
                                                                                 {"uint16", ScalarType::uint16},
                                                                                 {"int32", ScalarType::int32},
                                                                                 {"uint32", ScalarType::uint32},
                                                                                 {"float32", ScalarType::float32},
                                                                                 {"float64", ScalarType::float64}}};

[[noreturn]] void refuse(const FileTokens& in, const std::string& field, const std::string& found,
                         const std::string& allowed) {
  in.fail(field, "found \"" + quoted_excerpt(found) + "\", allowed " + allowed);
}

ScalarType scalar_type(const FileTokens& in, const std::string& word) {
  for (const auto& [name, type] : type_names)
    if (name == word) return type;
  refuse(in, "type of property", word, "char, uchar, short, ushort, int, uint, float, double, or int8 to float64");
}

PlyEncoding read_encoding(FileTokens& in) {
  const std::string encoding = in.word("format");
  const std::string version = in.word("format version");
  if (version != "1.0") refuse(in, "format version", version, "1.0");
  if (encoding == "ascii") return PlyEncoding::text;
  if (encoding == "binary_little_endian") return PlyEncoding::little_endian;
  if (encoding == "binary_big_endian") return PlyEncoding::big_endian;
  refuse(in, "format", encoding, "ascii, binary_little_endian or binary_big_endian");
}

PlyProperty read_property(FileTokens& in) {
  PlyProperty property{};
  std::string word = in.word("property");
  if (word == "list") {
    property.list_count = scalar_type(in, in.word("type of property"));
    if (!is_whole(*property.list_count)) in.fail("length of list", "found a type with decimals, allowed a whole type");
    word = in.word("type of property");
  }
  property.type = scalar_type(in, word);
  property.name = in.word("name of property");
  return property;
}

}  // namespace

PlyHeader read_ply_header(const std::string& file, std::string_view bytes) {
  FileTokens in(file, bytes);
  PlyHeader header;
  if (const std::string magic = in.word("ply"); magic != "ply") refuse(in, "ply", magic, "\"ply\" at the start");
  bool has_format = false;
  for (;;) {
    if (!in.line_ends()) refuse(in, "header", in.word("header"), "the end of the line");
    const std::string word = in.word("end_header");
    if (word == "end_header") break;
    if (word == "comment" || word == "obj_info") {
      in.skip_line();
    } else if (word == "format") {
      if (std::exchange(has_format, true)) in.fail("format", "found twice, allowed once");
      header.encoding = read_encoding(in);
    } else if (word == "element") {
      PlyElement element{};
      element.name = in.word("name of element");
      element.count = in.integer("number of elements", 0, INT32_MAX);
      element.line = in.line();
      header.elements.push_back(std::move(element));
    } else if (word == "property") {
      if (header.elements.empty()) in.fail("property", "found before any element, allowed after one");
      header.elements.back().properties.push_back(read_property(in));
    } else {
      refuse(in, "header", word, "format, comment, obj_info, element, property or end_header");
    }
  }
  if (!has_format) in.fail("format", "found nothing, required: the encoding");
  header.lines = in.line();
  header.bytes = bytes.size() - in.left();
  const std::string_view data = bytes.substr(header.bytes);
  const std::size_t line_end = data.starts_with("\r\n") ? 2 : data.starts_with("\n") ? 1 : 0;
  if (line_end == 0) in.fail("end_header", "found no end of its line, allowed one");
  header.bytes += line_end;
  return header;
}

}  // namespace finegauge
