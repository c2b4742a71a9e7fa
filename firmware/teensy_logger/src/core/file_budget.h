// How large a recording's file must be, and may be.
#pragma once

#include "../protocol/messages.h"

namespace tfsat {
namespace logger {

constexpr uint32_t kBlocksPerMib = 1024u * 1024u / protocol::kBlockBytes;

// Blocks a second: filled by samples or closed by the time limit, and the header now and then.
constexpr uint32_t blocks_per_s(uint32_t rate_hz) {
  const uint32_t filled = (rate_hz + protocol::kSamplesPerBlock - 1) / protocol::kSamplesPerBlock;
  const uint32_t timed = 1000u / protocol::kPartialBlockMs;
  return (filled > timed ? filled : timed) + 1;
}

// From the release until the recording has closed by itself. A file with less room than this is
// changed for another before the release.
constexpr uint32_t drop_blocks(uint32_t rate_hz, uint32_t after_landing_s) {
  return blocks_per_s(rate_hz) * (protocol::kLandingLatestUs / 1000000u + after_landing_s + 1);
}

// A drop and its second copy.
constexpr uint32_t least_file_mib(uint32_t rate_hz, uint32_t after_landing_s) {
  const uint32_t blocks = drop_blocks(rate_hz, after_landing_s) + protocol::kRingBlocks;
  return (blocks + kBlocksPerMib - 1) / kBlocksPerMib;
}

static_assert(least_file_mib(protocol::kSampleRateMaxHz, protocol::kAfterLandingFactoryS) <=
                  protocol::kFileFactoryMib,
              "the factory's file fits every rate");

}  // namespace logger
}  // namespace tfsat
