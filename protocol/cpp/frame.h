// Frames on the link: COBS(type, sequence, payload, CRC-16) and a zero byte.
//
// COBS (Cheshire & Baker, IEEE/ACM Transactions on Networking 7(2), 1999) takes every zero out of a
// frame, so that a zero always ends one: after any garbage the next zero byte resynchronises.
#ifndef TFSAT_PROTOCOL_FRAME_H
#define TFSAT_PROTOCOL_FRAME_H

#include "crc16.h"

namespace tfsat {
namespace protocol {

constexpr size_t kFrameOverheadBytes = 4;  // type, sequence, CRC-16

// Bytes that a frame can take on the wire: one COBS code byte a started run of 254, and the zero.
constexpr size_t encoded_frame_bytes(size_t payload_bytes) {
  return payload_bytes + kFrameOverheadBytes + (payload_bytes + kFrameOverheadBytes) / 254 + 2;
}

// Writes COBS-coded bytes one by one.
class CobsEncoder {
 public:
  explicit CobsEncoder(uint8_t* out) : out_(out) {}

  void put(uint8_t byte) {
    if (byte != 0) {
      out_[size_++] = byte;
      if (size_ - code_at_ == 0xFF) close_run();
    } else {
      close_run();
    }
  }

  // Ends the frame; returns its length with the final zero.
  size_t finish() {
    out_[code_at_] = static_cast<uint8_t>(size_ - code_at_);
    out_[size_++] = 0;
    return size_;
  }

 private:
  void close_run() {
    out_[code_at_] = static_cast<uint8_t>(size_ - code_at_);
    code_at_ = size_++;
  }

  uint8_t* out_;
  size_t code_at_ = 0;
  size_t size_ = 1;
};

// Encodes one frame into `out` (at least encoded_frame_bytes(size)); returns its length.
inline size_t encode_frame(uint8_t type, uint8_t sequence, const uint8_t* payload, size_t size,
                           uint8_t* out) {
  CobsEncoder cobs(out);
  cobs.put(type);
  cobs.put(sequence);
  uint16_t crc = crc16_update(crc16_update(kCrc16Initial, type), sequence);
  for (size_t i = 0; i < size; ++i) {
    cobs.put(payload[i]);
    crc = crc16_update(crc, payload[i]);
  }
  cobs.put(static_cast<uint8_t>(crc));
  cobs.put(static_cast<uint8_t>(crc >> 8));
  return cobs.finish();
}

// Takes bytes as they come and says when a whole, undamaged frame stands in its buffer.
template <size_t kMaxPayloadBytes>
class FrameReceiver {
 public:
  // Returns true when `byte` completed a frame; type(), payload() … hold until the next call.
  bool feed(uint8_t byte) {
    if (byte == 0) return end_of_frame();
    if (complete_) restart();
    if (run_left_ == 0) {
      if (zero_pending_) store(0);
      run_left_ = static_cast<uint8_t>(byte - 1);
      zero_pending_ = byte != 0xFF;
      started_ = true;
    } else {
      store(byte);
      --run_left_;
    }
    return false;
  }

  uint8_t type() const { return buffer_[0]; }
  uint8_t sequence() const { return buffer_[1]; }
  const uint8_t* payload() const { return buffer_ + 2; }
  size_t payload_bytes() const { return size_ - kFrameOverheadBytes; }

  // Frames that were dropped for a wrong CRC, a wrong length or a broken code.
  uint16_t rejected() const { return rejected_; }

  // Forgets a frame that has begun, as when the cable was pulled.
  void restart() {
    size_ = 0;
    run_left_ = 0;
    zero_pending_ = false;
    overflow_ = false;
    started_ = false;
    complete_ = false;
  }

 private:
  void store(uint8_t byte) {
    if (size_ < sizeof buffer_) {
      buffer_[size_++] = byte;
    } else {
      overflow_ = true;
    }
  }

  bool end_of_frame() {
    if (complete_) restart();
    if (!started_) return false;  // an extra zero between frames harms nothing
    const bool whole = !overflow_ && run_left_ == 0 && size_ >= kFrameOverheadBytes &&
                       crc16(buffer_, size_ - 2) ==
                           (buffer_[size_ - 2] | (static_cast<uint16_t>(buffer_[size_ - 1]) << 8));
    if (!whole) {
      ++rejected_;
      restart();
      return false;
    }
    complete_ = true;
    return true;
  }

  uint8_t buffer_[kMaxPayloadBytes + kFrameOverheadBytes];
  size_t size_ = 0;
  uint16_t rejected_ = 0;
  uint8_t run_left_ = 0;
  bool zero_pending_ = false;
  bool overflow_ = false;
  bool started_ = false;
  bool complete_ = false;
};

}  // namespace protocol
}  // namespace tfsat

#endif
