// The board's end of the link: bytes in, one request at a time, one reply each.
#ifndef TFSAT_PROTOCOL_LINK_H
#define TFSAT_PROTOCOL_LINK_H

#include "frame.h"
#include "messages.h"

namespace tfsat {
namespace protocol {

// Port: the serial connection to a host. Neither call may wait.
class ByteStream {
 public:
  // A host has the port open. While false, nothing is served or written.
  virtual bool connected() = 0;
  // The next byte, or -1.
  virtual int read() = 0;
  // Takes as many bytes as fit now; returns how many.
  virtual size_t write(const uint8_t* data, size_t size) = 0;

 protected:
  ~ByteStream() = default;
};

// What a handler makes of a request: a reply of `size` bytes, or an error.
struct Reply {
  size_t size;
  ErrorCode error;
  int32_t detail;

  static Reply of(size_t size) { return Reply{size, ErrorCode::kNone, -1}; }
  static Reply refused(ErrorCode error, int32_t detail = -1) { return Reply{0, error, detail}; }
};

class RequestHandler {
 public:
  // Serves the request `type`; writes the reply's payload to `reply` (kMaxPayloadBytes long).
  virtual Reply handle(uint8_t type, const uint8_t* payload, size_t size, uint8_t* reply) = 0;

 protected:
  ~RequestHandler() = default;
};

// Serves requests from a stream. A reply that does not fit at once is kept and sent as room comes;
// until then no further request is read, so one frame of memory is enough and a host that floods
// waits for itself. Nothing ever waits for the host. What is not served when the port is closed is
// dropped: an order from before must not be carried out for whoever opens it next.
class Link {
 public:
  Link(ByteStream& stream, RequestHandler& handler) : stream_(stream), handler_(handler) {}

  // Call from the main loop. Reads at most `byte_budget` bytes, so that a flooding host cannot hold
  // the loop for longer than that takes.
  void poll(uint8_t byte_budget = 64) {
    if (!stream_.connected()) {
      receiver_.restart();
      pending_size_ = 0;
      while (byte_budget-- > 0 && stream_.read() >= 0) continue;
      return;
    }
    while (flush() && byte_budget-- > 0) {
      const int byte = stream_.read();
      if (byte < 0) return;
      if (receiver_.feed(static_cast<uint8_t>(byte))) serve();
    }
  }

  // Sends an unasked frame if the link is free; returns false when it was skipped.
  bool send_stream(uint8_t type, const uint8_t* payload, size_t size) {
    if (!stream_.connected() || !flush()) return false;
    pending_size_ = encode_frame(type, stream_sequence_++, payload, size, pending_);
    pending_sent_ = 0;
    flush();
    return true;
  }

  uint16_t rejected_frames() const { return receiver_.rejected(); }

 private:
  // Hands on what is still to be sent; true when nothing is left.
  bool flush() {
    if (pending_sent_ < pending_size_) {
      pending_sent_ += stream_.write(pending_ + pending_sent_, pending_size_ - pending_sent_);
    }
    return pending_sent_ >= pending_size_;
  }

  void serve() {
    uint8_t payload[kMaxPayloadBytes];
    const uint8_t request = receiver_.type();
    if (request & kReplyBit) return;  // an echo of our own: answering it would never end
    const Reply reply =
        handler_.handle(request, receiver_.payload(), receiver_.payload_bytes(), payload);
    uint8_t type = static_cast<uint8_t>(request | kReplyBit);
    size_t size = reply.size;
    if (reply.error != ErrorCode::kNone) {
      ErrorReply error;
      error.request = request;
      error.code = reply.error;
      error.detail = reply.detail;
      error.encode(payload);
      type = ErrorReply::kType;
      size = ErrorReply::kSize;
    }
    pending_size_ = encode_frame(type, receiver_.sequence(), payload, size, pending_);
    pending_sent_ = 0;
  }

  ByteStream& stream_;
  RequestHandler& handler_;
  FrameReceiver<kMaxPayloadBytes> receiver_;
  uint8_t pending_[encoded_frame_bytes(kMaxPayloadBytes)];
  size_t pending_size_ = 0;
  size_t pending_sent_ = 0;
  uint8_t stream_sequence_ = 0;
};

}  // namespace protocol
}  // namespace tfsat

#endif
