// What really happened in a run, for judge.py: what the sensors said, and what the card was given
// and kept. Written beside the card's image; layouts as in truth.py.
#pragma once

#include <stddef.h>
#include <stdint.h>

namespace proof {

struct TickTruth {
  uint64_t t_us;
  int16_t imu[4][7];  // accel x y z, temperature, gyro x y z, as served last
  uint16_t angle[6];
  uint8_t served;        // bit i: IMU i gave a whole burst, awake, at this tick
  uint8_t switches_open;
  uint8_t angles;  // bit i: angle sensor i was converted
  uint8_t captured;  // which recording took it, from 1; 0: the logger did not record
};
static_assert(sizeof(TickTruth) == 80, "no padding");

// A block that the card took.
struct WriteTruth {
  uint64_t t_us;
  uint32_t position;
  uint32_t session;
  uint32_t number;
  uint32_t first_sample;
  uint8_t kind;
  uint8_t samples;
  uint8_t synced;     // a sync() came back after it
  uint8_t on_medium;  // it stands there whole at the end
  uint8_t file;       // of the card, from 1
  uint8_t padding[3];
};
static_assert(sizeof(WriteTruth) == 32, "no padding");

// From when to when the card took nothing.
struct TroubleTruth {
  uint64_t from_us;
  uint64_t to_us;
  uint8_t pulled;  // out of its contacts; else a stall
  uint8_t padding[7];
};
static_assert(sizeof(TroubleTruth) == 24, "no padding");

// A recording is a file.
struct FileTruth {
  uint32_t first_block;  // on the medium
  uint32_t blocks;
  uint32_t closed;
};
constexpr uint32_t kFiles = 4;

struct EdgeTruth {
  uint64_t t_us;
  uint8_t source;  // 0 switch, 1 stroke
  uint8_t index;
  uint8_t open;
  uint8_t lost;  // before it
  uint8_t padding[4];
};

struct TruthHead {
  char magic[8];
  uint32_t seed;
  uint8_t kind;
  uint8_t holds_older;
  uint8_t file_count;
  uint8_t state;  // LoggerState at the end
  uint16_t rate_hz;
  uint16_t stall_one_in;
  uint32_t ring_blocks;
  uint32_t image_blocks;
  uint32_t tick_count;
  uint32_t write_count;
  uint32_t trouble_count;
  uint32_t edge_count;
  uint64_t end_us;  // of the power
  uint64_t release_us;
  uint64_t landing_us;
  uint8_t faulty;  // bit i: IMU i, or its bus, fails some time
  uint8_t landing_felt;
  uint8_t pulled;
  uint8_t lost_for_good;
  uint32_t ram_blocks;  // fetched after the end
  uint32_t spoiled_blocks;
  uint32_t cache_blocks;
  uint64_t unix_at_zero_us;  // of the logger's clock, as the host has set it
  FileTruth files[kFiles];
};
static_assert(sizeof(TruthHead) == 144, "no padding");

template <typename Record, size_t kRoom>
struct List {
  Record items[kRoom];
  uint32_t count;

  // The last one is overwritten when there is no more room: judge.py notices.
  Record& add() {
    Record& item = items[count < kRoom ? count : kRoom - 1];
    if (count < kRoom) ++count;
    item = Record();
    return item;
  }
};

struct Truth {
  TruthHead head;
  List<TickTruth, 40960> ticks;
  List<WriteTruth, 16384> writes;
  List<TroubleTruth, 4096> troubles;
  List<EdgeTruth, 64> edges;
};

}  // namespace proof
