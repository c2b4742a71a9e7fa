#include "upload.h"

namespace tfsat {
namespace sequencer {

static_assert(protocol::kMaxStrokes <= 16, "received_ has a bit for each stroke");

Defect Upload::begin(uint8_t stroke_count, uint16_t speed_cdeg_s) {
  if (stroke_count == 0 || stroke_count > protocol::kMaxStrokes) {
    return Defect{ErrorCode::kTooManyStrokes, stroke_count};
  }
  maneuver_.stroke_count = stroke_count;
  maneuver_.speed_cdeg_s = speed_cdeg_s;
  received_ = 0;
  begun_ = true;
  return Defect{ErrorCode::kNone, -1};
}

Defect Upload::put(uint8_t index, const Stroke& stroke) {
  if (!begun_) return Defect{ErrorCode::kNoStagedManeuver, -1};
  if (index >= maneuver_.stroke_count) return Defect{ErrorCode::kIndexOutOfRange, index};
  maneuver_.strokes[index] = stroke;
  received_ = static_cast<uint16_t>(received_ | (1u << index));
  return Defect{ErrorCode::kNone, -1};
}

Defect Upload::find_defect(uint16_t crc) const {
  if (!begun_) return Defect{ErrorCode::kNoStagedManeuver, -1};
  for (uint8_t i = 0; i < maneuver_.stroke_count; ++i) {
    if (!(received_ & (1u << i))) return Defect{ErrorCode::kStepMissing, i};
  }
  if (crc != maneuver_.crc()) return Defect{ErrorCode::kCrcMismatch, -1};
  return maneuver_.find_defect();
}

}  // namespace sequencer
}  // namespace tfsat
