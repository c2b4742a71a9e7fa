// The sequencer's release detector for Python: edges in, the release's time out.
#include "../../firmware/arduino_sequencer/src/core/release_detector.h"

using namespace tfsat::sequencer;

// Edges by time, in us; polls each 100 us until `end_us`. Returns the time of the first release, or -1.
extern "C" int64_t first_release_us(const uint32_t* t_us, const uint8_t* index, const uint8_t* open, size_t n,
                                    uint32_t end_us) {
  ReleaseDetector detector;
  detector.reset(0, 0);
  uint8_t levels = 0;
  size_t next = 0;
  for (uint32_t now_us = 0; now_us <= end_us; now_us += 100) {
    for (; next < n && t_us[next] <= now_us; ++next) {
      detector.on_edge(SwitchEdge{ticks_from_us(t_us[next]), index[next], open[next] != 0});
      const uint8_t bit = static_cast<uint8_t>(1u << index[next]);
      levels = static_cast<uint8_t>(open[next] != 0 ? levels | bit : levels & ~bit);
    }
    if (detector.poll(ticks_from_us(now_us), levels)) return detector.released_at() / kTicksPerUs;
  }
  return -1;
}
