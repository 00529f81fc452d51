#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace finegauge {

/// Writes a file whole: to a temporary name in the same directory, then renamed over the old one, so that a reader
/// sees the old content or the new and never a part. Creates missing directories. Throws std::runtime_error naming the
/// file and the system's reason; the temporary file is removed then.
void write_file_atomically(const std::filesystem::path& file, std::string_view content);

/// The temporary name that belongs to a file: in its directory, and of this process alone.
std::filesystem::path temporary_beside(const std::filesystem::path& file);

}  // namespace finegauge
