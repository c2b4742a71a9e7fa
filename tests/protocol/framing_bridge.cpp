// The sketches' framing for Python: encode, COBS alone, and a receiver that lists what it accepts.
#include <cstring>
#include <new>

#include "frame.h"
#include "messages.h"

using namespace tfsat::protocol;

using Receiver = FrameReceiver<kMaxPayloadBytes>;

extern "C" {

size_t bridge_encode(uint8_t type, uint8_t sequence, const uint8_t* payload, size_t size,
                     uint8_t* out) {
  return encode_frame(type, sequence, payload, size, out);
}

// With the final zero.
size_t bridge_cobs(const uint8_t* data, size_t size, uint8_t* out) {
  CobsEncoder cobs(out);
  for (size_t i = 0; i < size; ++i) cobs.put(data[i]);
  return cobs.finish();
}

// Feeds a new receiver; appends payload length, type, sequence and payload of each accepted frame
// to `out`, which must hold `size` bytes (a frame is longer on the wire). Returns their length.
size_t bridge_receive(const uint8_t* data, size_t size, uint8_t* out, uint16_t* rejected) {
  Receiver receiver;
  size_t used = 0;
  for (size_t i = 0; i < size; ++i) {
    if (!receiver.feed(data[i])) continue;
    out[used++] = static_cast<uint8_t>(receiver.payload_bytes());
    out[used++] = receiver.type();
    out[used++] = receiver.sequence();
    std::memcpy(out + used, receiver.payload(), receiver.payload_bytes());
    used += receiver.payload_bytes();
  }
  *rejected = receiver.rejected();
  return used;
}

}  // extern "C"
