// A logger whose processor is shared: sampling at 1 kHz keeps it for most of each period, and each
// block that goes to the card takes some of what is left.
#pragma once

#include "board_bench.h"

namespace tfsat_test {

struct SharedProcessor : BoardBench {
  // `transfer_ns` of the processor for a block; `stall_one_in` blocks keeps the card busy.
  SharedProcessor(uint16_t rate_hz, uint16_t file_mib, uint32_t transfer_ns, uint32_t stall_one_in)
      : BoardBench(1, {100, 1000, 8, 1u << 20, transfer_ns, stall_one_in}) {
    LoggerSettings settings = logger::factory_settings();
    settings.rate_hz = rate_hz;
    settings.file_mib = file_mib;
    settings.after_landing_s = kAfterLandingMinS;
    write_settings(settings);
    CHECK(start(1).state == LoggerState::kRecording);
  }

  bool records_all() {
    const LoggerStatusReply now = status();
    return now.state == LoggerState::kRecording && now.error == ErrorCode::kNone &&
           now.samples_dropped == 0 && now.blocks_written > 0;
  }
  // Of the ring, since the file began.
  uint32_t blocks_to_spare() { return logger::kRingBlocks - status().ring_peak_blocks; }
};

}  // namespace tfsat_test
