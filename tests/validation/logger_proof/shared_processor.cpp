// shared_processor RATE_HZ TRANSFER_NS STALL_ONE_IN: how many blocks RAM had to spare while the factory's
// file was filled, and while the next one was, when a robot has waited until the first was full. -1: a
// sample was lost, or the recording failed.
#include "../../teensy_logger/shared_processor.h"

#include <cstdio>
#include <cstdlib>

namespace {

using namespace tfsat_test;

constexpr uint64_t kLongestWaitUs = 1600000000;

int to_spare(SharedProcessor& bench) {
  return bench.records_all() ? static_cast<int>(bench.blocks_to_spare()) : -1;
}

int at_start(uint16_t rate_hz, uint32_t transfer_ns, uint32_t stall_one_in) {
  SharedProcessor bench(rate_hz, kFileFactoryMib, transfer_ns, stall_one_in);
  bench.run_ms(30000);
  return to_spare(bench);
}

int at_change(uint16_t rate_hz, uint32_t transfer_ns, uint32_t stall_one_in) {
  SharedProcessor bench(rate_hz, kFileFactoryMib, transfer_ns, stall_one_in);
  const uint32_t first = bench.status().session;
  while (bench.status().session == first && bench.t_us < kLongestWaitUs) bench.run_ms(100);
  bench.run_ms(15000);
  return bench.status().session == first ? -1 : to_spare(bench);
}

}  // namespace

int main(int count, char** words) {
  if (count != 4) return 2;
  const uint16_t rate_hz = static_cast<uint16_t>(std::atoi(words[1]));
  const uint32_t transfer_ns = static_cast<uint32_t>(std::atoi(words[2]));
  const uint32_t stall_one_in = static_cast<uint32_t>(std::atoi(words[3]));
  std::printf("%d %d\n", at_start(rate_hz, transfer_ns, stall_one_in),
              at_change(rate_hz, transfer_ns, stall_one_in));
  return 0;
}
