// A fuzzer's input as a script: numbers one after the other. After its end come zeros.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace tfsat_fuzz {

class Script {
 public:
  Script(const uint8_t* data, size_t size) : data_(data), left_(size) {}

  bool done() const { return left_ == 0; }

  uint8_t u8() {
    if (left_ == 0) return 0;
    --left_;
    return *data_++;
  }
  uint16_t u16() {
    const unsigned low = u8();
    return static_cast<uint16_t>(low | static_cast<unsigned>(u8()) << 8);
  }

  // Fills `out` from the script, the rest with zeros.
  void bytes(uint8_t* out, size_t size) {
    const size_t given = std::min(size, left_);
    std::copy_n(data_, given, out);
    std::fill(out + given, out + size, static_cast<uint8_t>(0));
    data_ += given;
    left_ -= given;
  }

 private:
  const uint8_t* data_;
  size_t left_;
};

}  // namespace tfsat_fuzz
