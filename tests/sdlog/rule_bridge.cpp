// The release rule as the sequencer and the logger run it, for Python: edges in, releases out.
#include <random>

#include "../../firmware/teensy_logger/src/core/drop_watch.h"

using namespace tfsat;
using sequencer::ReleaseDetector;
using sequencer::SwitchEdge;
using sequencer::ticks_from_us;
using sequencer::us_from_ticks;

namespace {

struct Told {
  uint32_t at_us, first_us, last_us;  // interval at the end of the edges, or when it was a false one
  uint32_t false_release;
};

struct Edges {
  const uint32_t* t_us;
  const uint8_t* index;
  const uint8_t* open;
  size_t count;

  // Those up to `now_us`, from number `next` on; the levels after them.
  template <typename Take>
  void take(size_t& next, uint32_t now_us, uint8_t& levels, Take take_edge) const {
    for (; next < count && t_us[next] <= now_us; ++next) {
      const uint8_t bit = static_cast<uint8_t>(1u << index[next]);
      levels = static_cast<uint8_t>(open[next] != 0 ? levels | bit : levels & ~bit);
      take_edge(next);
    }
  }
};

}  // namespace

// As the main loop of the sequencer does, which comes round every 20 us to 1 ms. Returns how many.
extern "C" size_t sequencer_tells(const uint32_t* t_us, const uint8_t* index, const uint8_t* open,
                                  size_t count, uint32_t end_us, uint32_t seed, Told* told) {
  const Edges edges{t_us, index, open, count};
  std::minstd_rand random(seed);
  ReleaseDetector detector{};
  const uint32_t start = random();  // the clock may turn over
  detector.reset(start, 0);
  size_t next = 0, found = 0;
  uint8_t levels = 0;
  const auto note = [&] {
    const uint32_t at = detector.released_at();
    told[found - 1] = {us_from_ticks(at - start), us_from_ticks(at - start - detector.earlier_ticks()),
                       us_from_ticks(at - start + detector.later_ticks()),
                       told[found - 1].false_release};
  };
  const auto heed = [&](ReleaseDetector::Verdict verdict) {
    if (verdict == ReleaseDetector::Verdict::kReleased) told[found++].false_release = 0;
    if (verdict == ReleaseDetector::Verdict::kFalseRelease) {
      told[found - 1].false_release = 1;
    } else if (found > 0 && told[found - 1].false_release == 0) {
      note();
    }
  };
  for (uint32_t now_us = 0; now_us < end_us;) {
    now_us += 20 + random() % 980;
    edges.take(next, now_us, levels, [&](size_t i) {
      heed(detector.on_edge(SwitchEdge{start + ticks_from_us(t_us[i]), index[i], open[i] != 0, false}));
    });
    heed(detector.poll(start + ticks_from_us(now_us), levels));
  }
  return found;
}

// As the logger's interrupt does at `period_us`; times alone.
extern "C" size_t logger_tells(const uint32_t* t_us, const uint8_t* index, const uint8_t* open,
                               size_t count, uint32_t end_us, uint32_t period_us, Told* told) {
  const Edges edges{t_us, index, open, count};
  logger::DropWatch watch;
  watch.reset(2048.0f);
  size_t next = 0, found = 0;
  uint8_t levels = 0;
  for (uint32_t now_us = 0; now_us < end_us;) {
    now_us += period_us;
    edges.take(next, now_us, levels, [&](size_t i) {
      watch.on_edge(logger::Edge{t_us[i], logger::Edge::Source::kSwitch, index[i], open[i] != 0, 0});
    });
    watch.poll(now_us, levels, 0);
    protocol::Event event;
    while (watch.take_event(event)) {
      if (event.code != protocol::EventCode::kRelease) continue;
      if (event.arg != 0) told[found++] = {static_cast<uint32_t>(event.time_us), 0, 0, 0};
      if (event.arg == 0) told[found - 1].false_release = 1;
    }
  }
  return found;
}
