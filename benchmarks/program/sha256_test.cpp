#include "benchmarks/program/sha256.hpp"

#include <string>

#include "verification/support/catch.hpp"

using namespace finegauge;

// The messages of FIPS 180-4's examples and of NIST's test vectors for SHA-256.
TEST_CASE("SHA-256 agrees with the standard's examples", "[sha256]") {
  CHECK(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  CHECK(sha256(std::string(1000000, 'a')) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_CASE("SHA-256 tells every byte of a message around the padding's limits apart", "[sha256]") {
  // 55, 56 and 64 bytes are where the padding takes one block more.
  for (const int length : {54, 55, 56, 57, 63, 64, 65}) {
    CAPTURE(length);
    std::string message(static_cast<std::size_t>(length), 'x');
    const std::string digest = sha256(message);
    CHECK(digest != sha256(message + 'x'));
    for (char& c : message) {
      c = 'y';
      CHECK(digest != sha256(message));
      c = 'x';
    }
  }
}
