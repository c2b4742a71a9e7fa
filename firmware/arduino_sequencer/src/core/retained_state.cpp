#include "retained_state.h"

namespace tfsat {
namespace sequencer {

namespace {

// What stands before it in the program is in memory before what stands behind.
inline void order_writes() { __asm__ __volatile__("" ::: "memory"); }

}  // namespace

constexpr uint8_t RetainedState::kPending;

uint16_t retained_checksum(const void* data, size_t size, uint16_t sum) {
  return protocol::crc16(static_cast<const uint8_t*>(data), size, sum);
}

void RetainedState::change(const void* target, const void* value, uint8_t size) {
  if (memcmp(target, value, size) == 0) return;
  write.at = static_cast<uint8_t>(static_cast<const uint8_t*>(target) - bytes());
  write.size = size;
  memcpy(write.value, value, size);
  // The checksum as it will be.
  const size_t begin = of_run() ? offsetof(RetainedState, run) : 0;
  const size_t end = of_run() ? begin + sizeof run.report : offsetof(RetainedState, crc);
  uint16_t sum = retained_checksum(bytes() + begin, write.at - begin);
  sum = retained_checksum(write.value, size, sum);
  const size_t behind = write.at + size;
  write.crc = retained_checksum(bytes() + behind, end - behind, sum);
  order_writes();
  write.pending = kPending;
  order_writes();
  finish();
}

void RetainedState::finish() {
  memcpy(bytes() + write.at, write.value, write.size);
  (of_run() ? run.crc : crc) = write.crc;
  order_writes();
  write.pending = 0;
}

}  // namespace sequencer
}  // namespace tfsat
