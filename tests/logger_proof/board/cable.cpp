#include "cable.h"

#include <string.h>

namespace proof {

using namespace tfsat::protocol;

bool Cable::fetch_ram(uint64_t t_us) {
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

size_t Cable::write(const uint8_t* data, size_t size) {
  for (size_t i = 0; i < size; ++i) {
    if (receiver_.feed(data[i])) take_frame();
  }
  return size;
}

void Cable::take_frame() {
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

void Cable::take_part(const LogPartStream& part) {
  if (part.block != ram_.blocks || part.part != parts_ || ram_.blocks == entry_.blocks) return;
  memcpy(ram_.bytes + ram_.blocks * kBlockBytes + parts_ * kLogPartBytes, part.data, kLogPartBytes);
  if (++parts_ < kBlockBytes / kLogPartBytes) return;
  parts_ = 0;
  if (++ram_.blocks == asked_to_) waiting_ = false;
}

}  // namespace proof
