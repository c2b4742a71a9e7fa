// A maneuver as the board keeps it, and what makes one valid.
#pragma once

#include "../protocol/messages.h"

namespace tfsat {
namespace sequencer {

using protocol::ErrorCode;

// A maneuver's memory is its canonical form: no gaps, little endian.
static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the canonical form is little endian");
#define TFSAT_PACKED __attribute__((packed))

struct TFSAT_PACKED Stroke {
  uint8_t joint;  // 1 to 3
  int16_t angle_cdeg;
  uint32_t start_us;  // after release
};

struct Defect {
  ErrorCode code;
  int32_t stroke;  // index of the offending stroke, or -1
};

// Strokes beyond stroke_count hold anything.
struct TFSAT_PACKED Maneuver {
  static constexpr size_t kHeadBytes = 3;
  static constexpr size_t kSize = kHeadBytes + protocol::kMaxStrokes * sizeof(Stroke);

  uint8_t stroke_count;
  uint16_t speed_cdeg_s;
  Stroke strokes[protocol::kMaxStrokes];

  // The paper's maneuver 59/70 (table "Designed experiment sequence").
  static Maneuver factory();

  // Takes the canonical form; false when it has another size. What it means, find_defect() judges.
  bool decode(const uint8_t* bytes, size_t size);
  // CRC-16/IBM-3740 of the canonical form up to the last stroke in use.
  uint16_t crc() const;

  ErrorCode stroke_defect(uint8_t index, uint8_t moving_at_once) const;
  // When a stroke has brought its joint where it should be, after release.
  uint32_t arrival_us(uint8_t stroke_index) const;
  // When the last stroke ends, after release.
  uint32_t end_us() const;
  // Everything that must hold before it may fly. The host checks the same; the board believes
  // nobody.
  Defect find_defect(uint8_t moving_at_once = protocol::kJointCount) const;
  bool valid() const { return find_defect().code == ErrorCode::kNone; }
  // Angle that `joint` (1 to 3) holds after the strokes before `stroke_index`, from the start pose
  // 0.
  int16_t angle_before(uint8_t stroke_index, uint8_t joint) const;
};

static_assert(sizeof(Maneuver) == Maneuver::kSize, "a maneuver has no gaps in memory");

}  // namespace sequencer
}  // namespace tfsat
