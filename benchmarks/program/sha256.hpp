#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace finegauge {

/// SHA-256 (FIPS 180-4) as 64 lower-case hexadecimal digits: the identity of a scene file or of a final state.
/// Our own eighty lines rather than libcrypto, so that a fingerprint does not bring a cryptography package into every
/// installation; the standard's test vectors are its unit test. Nothing here is meant to keep a secret.
std::string sha256(std::span<const std::byte> bytes);
std::string sha256(std::string_view text);
/// Throws std::runtime_error when the file cannot be read.
std::string sha256_of_file(const std::filesystem::path& file);

}  // namespace finegauge
