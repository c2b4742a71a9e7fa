#include "maneuver.h"

#include <string.h>

#include "../protocol/crc16.h"

namespace tfsat {
namespace sequencer {

namespace {

uint16_t magnitude(int16_t angle_cdeg) {
  return static_cast<uint16_t>(angle_cdeg < 0 ? -static_cast<int32_t>(angle_cdeg) : angle_cdeg);
}

}  // namespace

Maneuver Maneuver::factory() {
  Maneuver maneuver = {};
  maneuver.stroke_count = 4;
  maneuver.speed_cdeg_s = 17000;
  maneuver.strokes[0] = Stroke{1, 5900, 700000};
  maneuver.strokes[1] = Stroke{2, 7000, 1050000};
  maneuver.strokes[2] = Stroke{1, -5900, 1470000};
  maneuver.strokes[3] = Stroke{2, -7000, 1820000};
  return maneuver;
}

bool Maneuver::decode(const uint8_t* bytes, size_t size) {
  if (size != kSize) return false;
  memcpy(this, bytes, kSize);
  return true;
}

uint16_t Maneuver::crc() const {
  const uint8_t* bytes = reinterpret_cast<const uint8_t*>(this);
  const size_t size = kHeadBytes + stroke_count * sizeof(Stroke);
  uint16_t crc = protocol::kCrc16Initial;
  for (size_t i = 0; i < size; ++i) crc = protocol::crc16_update(crc, bytes[i]);
  return crc;
}

uint32_t Maneuver::arrival_us(uint8_t stroke_index) const {
  const Stroke& stroke = strokes[stroke_index];
  // Rounded up: cdeg / (cdeg/s) in microseconds, without 64-bit arithmetic. At most 32768 cdeg and
  // at least 1000 cdeg/s; the millisecond first, then the rest.
  const uint32_t scaled = static_cast<uint32_t>(magnitude(stroke.angle_cdeg)) * 1000;
  const uint32_t whole_ms = scaled / speed_cdeg_s;
  const uint32_t rest = scaled % speed_cdeg_s;
  return stroke.start_us + whole_ms * 1000 + (rest * 1000 + speed_cdeg_s - 1) / speed_cdeg_s;
}

uint32_t Maneuver::end_us() const {
  uint32_t end_us = 0;
  for (uint8_t i = 0; i < stroke_count; ++i) {
    const uint32_t arrived_us = arrival_us(i);
    if (arrived_us > end_us) end_us = arrived_us;
  }
  return end_us;
}

int16_t Maneuver::angle_before(uint8_t stroke_index, uint8_t joint) const {
  int16_t angle_cdeg = 0;
  for (uint8_t i = 0; i < stroke_index; ++i) {
    if (strokes[i].joint == joint)
      angle_cdeg = static_cast<int16_t>(angle_cdeg + strokes[i].angle_cdeg);
  }
  return angle_cdeg;
}

Defect Maneuver::find_defect(uint8_t moving_at_once) const {
  using namespace protocol;
  if (stroke_count == 0 || stroke_count > kMaxStrokes)
    return Defect{ErrorCode::kTooManyStrokes, -1};
  if (speed_cdeg_s < kSpeedMinCdegS || speed_cdeg_s > kSpeedMaxCdegS) {
    return Defect{ErrorCode::kSpeedOutOfRange, -1};
  }
  for (uint8_t i = 0; i < stroke_count; ++i) {
    const ErrorCode code = stroke_defect(i, moving_at_once);
    if (code != ErrorCode::kNone) return Defect{code, i};
  }
  return Defect{ErrorCode::kNone, -1};
}

// Those before it have no defect.
ErrorCode Maneuver::stroke_defect(uint8_t index, uint8_t moving_at_once) const {
  using namespace protocol;
  const Stroke& stroke = strokes[index];
  if (stroke.joint < 1 || stroke.joint > kJointCount) return ErrorCode::kJointUnknown;
  int32_t angle_cdeg = stroke.angle_cdeg;
  uint8_t moving = 1;
  bool overlaps = false;
  for (uint8_t i = 0; i < index; ++i) {
    const bool under_way = arrival_us(i) > stroke.start_us;
    if (under_way) ++moving;
    if (strokes[i].joint != stroke.joint) continue;
    angle_cdeg += strokes[i].angle_cdeg;
    overlaps = overlaps || under_way;
  }
  if (stroke.angle_cdeg == 0 || angle_cdeg < static_cast<int32_t>(kJointAngleMinCdeg) ||
      angle_cdeg > static_cast<int32_t>(kJointAngleMaxCdeg)) {
    return ErrorCode::kAngleOutOfRange;
  }
  if (stroke.start_us < kPauseMinUs) return ErrorCode::kTooEarly;
  if (index > 0) {
    const uint32_t before_us = strokes[index - 1].start_us;
    if (stroke.start_us != before_us && stroke.start_us < before_us + kScheduleGridUs) {
      return ErrorCode::kStartsTooClose;
    }
  }
  if (overlaps) return ErrorCode::kStrokesOverlap;
  if (stroke.start_us > kFallUs || arrival_us(index) > kFallUs) return ErrorCode::kTooLong;
  return moving > moving_at_once ? ErrorCode::kTooManyMoving : ErrorCode::kNone;
}

}  // namespace sequencer
}  // namespace tfsat
