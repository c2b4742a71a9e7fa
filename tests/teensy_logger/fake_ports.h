// Ports of the logger that do what a test says: non-volatile memory, the cable.
#pragma once

#include <algorithm>
#include <deque>
#include <vector>

#include "../../firmware/teensy_logger/src/core/ports.h"
#include "../../firmware/teensy_logger/src/protocol/link.h"

namespace tfsat_test {

struct FakeMemory final : tfsat::logger::NonVolatile {
  void load(uint8_t* out, uint8_t size) override { std::copy_n(bytes.begin(), size, out); }
  void save(const uint8_t* in, uint8_t size) override {
    ++saves;
    for (uint8_t i = 0; i < size; ++i) {
      if (i != worn_cell) bytes[i] = in[i];
    }
  }
  std::vector<uint8_t> bytes = std::vector<uint8_t>(64, 0xFF);
  int saves = 0;
  int worn_cell = -1;
};

// A host that takes `room` bytes.
struct FakeStream final : tfsat::protocol::ByteStream {
  bool connected() override { return plugged; }
  int read() override {
    if (to_board.empty()) return -1;
    const uint8_t byte = to_board.front();
    to_board.pop_front();
    return byte;
  }
  size_t write(const uint8_t* data, size_t size) override {
    const size_t taken = size < room ? size : room;
    bytes.insert(bytes.end(), data, data + taken);
    room -= taken;
    return taken;
  }
  std::deque<uint8_t> to_board;
  std::vector<uint8_t> bytes;
  size_t room = SIZE_MAX;
  bool plugged = true;
};

}  // namespace tfsat_test
