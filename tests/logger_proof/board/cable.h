// The cable, and the host at its other end: it prepares a drop, and fetches what RAM holds.
#pragma once

#include "../../../firmware/teensy_logger/src/core/ports.h"
#include "../../../firmware/teensy_logger/src/protocol/link.h"

namespace proof {

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
  bool fetch_ram(uint64_t t_us);
  uint32_t ram_blocks() const { return ram_.blocks; }

  bool connected() override { return connected_; }
  int read() override { return read_ < size_ ? bytes_[read_++] : -1; }
  size_t write(const uint8_t* data, size_t size) override;

 private:
  static constexpr uint64_t kAskAgainUs = 500000;

  void take_frame();
  void take_part(const tfsat::protocol::LogPartStream& part);

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
