// The cable, and the host at its other end: it prepares a drop, and fetches what RAM holds.
#pragma once

#include <string.h>

#include "../../../../firmware/teensy_logger/src/core/ports.h"
#include "../../../../firmware/teensy_logger/src/protocol/link.h"

namespace proof {

using namespace tfsat::protocol;

// What a host has fetched.
struct Ram {
  uint8_t bytes[tfsat::protocol::kRingBlocks * tfsat::protocol::kBlockBytes];
  uint32_t blocks;
};

class Cable final : public tfsat::protocol::ByteStream {
 public:
  explicit Cable(Ram& ram) : ram_(ram) {}

  template <typename Request>
  void send(const Request& request) {
    uint8_t payload[Request::kSize];
    request.encode(payload);
    if (read_ == size_) read_ = size_ = 0;
    size_ += tfsat::protocol::encode_frame(Request::kType, sequence_++, payload, sizeof payload,
                                           bytes_ + size_);
    connected_ = true;
  }
  void pull() { connected_ = false; }
  // One step; true when everything is fetched. It is asked for again until the logger gives it.
  bool fetch_ram(uint64_t t_us) {
    if (entry_.blocks != 0 && ram_.blocks == entry_.blocks) return true;
    if (waiting_ && t_us - asked_us_ < kAskAgainUs) return false;
    waiting_ = true;
    asked_us_ = t_us;
    if (entry_.blocks == 0) {
      send(LogListRequest{0});
    } else {
      asked_to_ = ram_.blocks + kLogReadBlocks;
      parts_ = 0;
      send(LogReadRequest{0, entry_.session, ram_.blocks, kLogReadBlocks});
    }
    return false;
  }
  uint32_t ram_blocks() const { return ram_.blocks; }

  bool connected() override { return connected_; }
  int read() override { return read_ < size_ ? bytes_[read_++] : -1; }
  size_t write(const uint8_t* data, size_t size) override {
    for (size_t i = 0; i < size; ++i) {
      if (receiver_.feed(data[i])) take_frame();
    }
    return size;
  }

 private:
  static constexpr uint64_t kAskAgainUs = 500000;

  void take_frame() {
    LogListReply list;
    LogPartStream part;
    if (receiver_.type() == LogListReply::kType &&
        list.decode(receiver_.payload(), receiver_.payload_bytes())) {
      if (list.found == 0 || list.entry.number != 0 || list.entry.blocks > kRingBlocks) return;
      entry_ = list.entry;
      waiting_ = false;
    } else if (receiver_.type() == LogPartStream::kType &&
               part.decode(receiver_.payload(), receiver_.payload_bytes())) {
      take_part(part);
    }
  }
  void take_part(const LogPartStream& part) {
    if (part.block != ram_.blocks || part.part != parts_ || ram_.blocks == entry_.blocks) return;
    memcpy(ram_.bytes + ram_.blocks * kBlockBytes + parts_ * kLogPartBytes, part.data, kLogPartBytes);
    if (++parts_ < kBlockBytes / kLogPartBytes) return;
    parts_ = 0;
    if (++ram_.blocks == asked_to_) waiting_ = false;
  }

  Ram& ram_;
  tfsat::protocol::FrameReceiver<tfsat::protocol::kMaxPayloadBytes> receiver_;
  tfsat::protocol::LogEntry entry_ = {};  // of RAM; no blocks: not yet known
  uint64_t asked_us_ = 0;
  uint32_t asked_to_ = 0;  // block
  uint8_t parts_ = 0;      // of the next block
  uint8_t bytes_[256];
  size_t size_ = 0;
  size_t read_ = 0;
  uint8_t sequence_ = 1;
  bool connected_ = false;
  bool waiting_ = false;
};

}  // namespace proof
