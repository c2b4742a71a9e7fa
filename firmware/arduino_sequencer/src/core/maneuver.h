// A maneuver as the board keeps it, and what makes one valid.
#pragma once

#include "../protocol/messages.h"

namespace tfsat {
namespace sequencer {

using protocol::ErrorCode;

struct Stroke {
  uint8_t joint;  // 1 to 3
  int16_t angle_cdeg;
  uint32_t start_us;  // after release

  bool operator==(const Stroke& other) const {
    return joint == other.joint && angle_cdeg == other.angle_cdeg && start_us == other.start_us;
  }
};

struct Defect {
  ErrorCode code;
  int32_t stroke;  // index of the offending stroke, or -1
};

struct Maneuver {
  static constexpr size_t kHeadBytes = 3;
  static constexpr size_t kStrokeBytes = 7;
  static constexpr size_t kMaxBytes = kHeadBytes + protocol::kMaxStrokes * kStrokeBytes;

  uint8_t stroke_count;
  uint16_t speed_cdeg_s;
  Stroke strokes[protocol::kMaxStrokes];

  // The paper's maneuver 59/70 (table "Designed experiment sequence").
  static Maneuver factory();

  size_t size_bytes() const { return kHeadBytes + stroke_count * kStrokeBytes; }
  // Byte `index` of the canonical form: stroke_count u8, speed_cdeg_s u16, then per stroke joint u8,
  // angle_cdeg i16, start_us u32; little endian.
  uint8_t byte_at(size_t index) const;
  // Takes byte `index` of the canonical form; bytes come in order.
  void set_byte(size_t index, uint8_t value);
  // CRC-16/IBM-3740 of the canonical form.
  uint16_t crc() const;

  uint32_t duration_us(const Stroke& stroke) const;
  // When the last stroke ends, after release.
  uint32_t end_us() const;
  // Everything that must hold before it may fly. The host checks the same; the board believes nobody.
  Defect find_defect() const;
  // Angle that `joint` (1 to 3) holds after the strokes before `stroke_index`, from the start pose 0.
  int16_t angle_before(uint8_t stroke_index, uint8_t joint) const;

  bool operator==(const Maneuver& other) const;
};

}  // namespace sequencer
}  // namespace tfsat
