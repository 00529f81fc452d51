#pragma once

/// Catch2 of either generation: 3 where it is installed, else 2.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
using Catch::Approx;
using Catch::Matchers::ContainsSubstring;
#else
#include <catch2/catch.hpp>  // puts Approx into the global namespace by itself
/// What 2 calls Contains, which in 3 asks ranges for their elements.
inline auto ContainsSubstring(const std::string& part) { return Catch::Matchers::Contains(part); }
#endif

using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
