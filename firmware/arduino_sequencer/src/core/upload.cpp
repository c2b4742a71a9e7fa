#include "upload.h"

#include <string.h>

namespace tfsat {
namespace sequencer {

static_assert(protocol::kMaxStrokes <= 16, "received_ has a bit for each stroke");

namespace {

// Strokes that are not in use are as erased memory, so that nothing is written for them.
constexpr uint8_t kErasedByte = 0xFF;

}  // namespace

Defect Upload::begin(uint8_t stroke_count, uint16_t speed_cdeg_s) {
  if (stroke_count == 0 || stroke_count > protocol::kMaxStrokes) {
    return Defect{ErrorCode::kTooManyStrokes, stroke_count};
  }
  Maneuver maneuver;
  memset(&maneuver, kErasedByte, sizeof maneuver);
  maneuver.stroke_count = stroke_count;
  maneuver.speed_cdeg_s = speed_cdeg_s;
  memcpy(store_.staged(), &maneuver, Maneuver::kSize);
  received_ = 0;
  begun_ = true;
  return Defect{ErrorCode::kNone, -1};
}

Defect Upload::put(uint8_t index, const Stroke& stroke) {
  if (!begun_) return Defect{ErrorCode::kNoStagedManeuver, -1};
  if (index >= store_.staged()[0]) return Defect{ErrorCode::kIndexOutOfRange, index};
  memcpy(store_.staged() + Maneuver::kHeadBytes + index * sizeof stroke, &stroke, sizeof stroke);
  received_ = static_cast<uint16_t>(received_ | (1u << index));
  return Defect{ErrorCode::kNone, -1};
}

Defect Upload::find_defect(uint16_t crc) const {
  if (!begun_) return Defect{ErrorCode::kNoStagedManeuver, -1};
  const Maneuver maneuver = collected();
  for (uint8_t i = 0; i < maneuver.stroke_count; ++i) {
    if (!(received_ & (1u << i))) return Defect{ErrorCode::kStepMissing, i};
  }
  if (crc != maneuver.crc()) return Defect{ErrorCode::kCrcMismatch, -1};
  return maneuver.find_defect();
}

Maneuver Upload::collected() const {
  Maneuver maneuver;
  maneuver.decode(store_.staged(), Maneuver::kSize);
  return maneuver;
}

}  // namespace sequencer
}  // namespace tfsat
